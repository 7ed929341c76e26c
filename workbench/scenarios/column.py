"""The impacted column: geometry, supports, striker; its pushover and its impact."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import pairwise
from math import pi
from typing import Any, ClassVar, Self

from workbench.base.fields import Choice, Declared, Flag, Instance, Many, Number, Text, checked
from workbench.scenarios.parts import (
    CLAMPED_HINT,
    FORCE,
    GRAVITY,
    LENGTH,
    SPRING,
    MemberProperties,
    member_properties,
    override,
    strength_section,
    stronger,
)
from workbench.steel.materials import MadeOfSteel, Steel
from workbench.steel.sections import AXES, SECTION, CircularTube, Section

MASS = Number(1e-3, 1e7, "kg")
VELOCITY = Number(1e-6, 300.0, "m/s", advice="velocities are in m/s, not km/h")
RESTITUTION = Number(0.0, 1.0)
DURATION = Number(1e-9, 10.0, "s", advice="durations are in seconds")
MOST_POINTS = 50  # of a crush law
STIFFNESS = Number(1.0, 1e12, "N/m")
SENSES = {"horizontal": 0.0, "down": 1.0, "up": -1.0}  # of gravity along what acts so
SENSE = Choice(tuple(SENSES))
WEIGHS = "whether all weighs; by default where a striker, or a pulse on a column, comes down"


@dataclass(frozen=True)
class CrushLaw(Many):
    """Points of a force over a stroke."""

    def _allowed(self) -> str:
        return f"points [[stroke in m, force in N], ...], {self.shortest} to {self.longest} of them"


@dataclass(frozen=True)
class Column(MadeOfSteel, table="column"):
    """A steel column with one impact point.

    The elastic stiffness and the mass are those of the rolled profile, fillets included, whether
    or not `fillets` count in the strength (as in Heng 2017, section 5.2).

    Examples
    --------
    >>> column = wb.Column("HEB 220", length_below="0.8 m", length_above=3.2, axial_load="500 kN")
    >>> column.length, column.axial_load
    (4.0, 500000.0)
    """

    section: Section = checked(SECTION)
    length_below: float = checked(LENGTH, help="from the base to the impact point")
    length_above: float = checked(LENGTH, help="from the impact point to the head")
    steel: Steel = checked(Instance(Steel), Steel())
    fillets: bool = checked(Flag(), True, help="whether root fillets count in the strength")
    base: str = checked(Choice(("clamped", "pinned"), CLAMPED_HINT), "clamped")
    head: str = checked(
        Choice(("guided", "pinned", "fixed")),
        "guided",
        help="guided: rotation and sway held, free to shorten; pinned: sway held; fixed: as "
        "guided, and held against shortening once the axial load is on",
    )
    axial_load: float = checked(
        replace(FORCE, advice="forces are in N, compression positive"), 0.0, help="on the head"
    )
    restraint_stiffness: float = checked(
        SPRING, 0.0, help="axial spring at the head, unstressed once the axial load is on"
    )
    head_mass: float = checked(Number(0.0, 1e7, "kg"), 0.0)
    axis: str = checked(
        Choice(AXES),
        "strong",
        omitted=True,
        help="about which it bends: strong, hit along the web; weak, hit along the flanges",
    )
    base_weak: str | None = checked(
        Choice(("clamped", "pinned"), CLAMPED_HINT),
        optional=True,
        help="the base about the weak axis, as base unless given",
    )
    head_weak: str | None = checked(
        Choice(("guided", "pinned")),
        optional=True,
        help="the head about the weak axis, as head unless given",
    )
    unbraced_length: float | None = checked(
        LENGTH,
        optional=True,
        help="between braces against buckling about the weak axis, else by length and ends",
    )
    area: float | None = override("area")
    second_moment: float | None = override("second_moment")
    plastic_moment: float | None = override("plastic_moment")
    squash_load: float | None = override("squash_load")
    mass_per_length: float | None = override("mass_per_length")
    impact_mass: float | None = checked(
        Number(1e-3, 1e7, "kg"),
        optional=True,
        help="lumped at the impact point, else rho A L / 3; what is more is attached there",
    )

    def check(self) -> None:
        """Turn the section to its axis; refuse loads above the squash load, columns no beams."""
        object.__setattr__(self, "section", self.section.about(self.axis))
        if self.head == "fixed" and self.head_weak == "pinned":
            text = "cannot be pinned where the head is fixed, which holds its rotation"
            raise self.refusal("head_weak", text, "drop it, or take a pinned head")
        if self.axis == "weak" and self.unbraced_length is not None:
            text = "must be left out with axis = weak: a brace would hold what the hit bends"
            raise self.refusal("unbraced_length", text, "model the braced part alone")
        if self.is_squashed:
            squash = self.properties.squash_load
            text = f"must stay below the squash load {squash:.6g} N in tension and compression"
            raise self.refusal("axial_load", text, "reduce the load or take a stronger section")
        if self.is_stocky:
            slenderness = self.length / self.section.height
            text = f"the column is {slenderness:.2g} section heights long; must be at least 2"
            raise self.refusal("length_below", text, "a stockier member is not a beam")

    @property
    def is_squashed(self) -> bool:
        """Whether the axial load is above the squash load."""
        return abs(self.axial_load) >= self.properties.squash_load

    @property
    def is_stocky(self) -> bool:
        """Whether the column is too short beside its section to be a beam."""
        return self.length / self.section.height < 2.0

    @property
    def length(self) -> float:
        """Whole length, in m."""
        return self.length_below + self.length_above

    @property
    def attached_mass(self) -> float:
        """Mass (kg) at the impact point beside the column's own, of which a third stands for it."""
        properties = self.properties
        own: float = properties.mass_per_length * self.length / 3.0
        return max(0.0, properties.impact_mass - own)

    @cached_property
    def strength_section(self) -> Section:
        """The section whose fibers and envelope give the strength (`fillets` applied)."""
        return strength_section(self.section, self.fillets)

    @cached_property
    def properties(self) -> MemberProperties:
        """Section values with the overrides of this column applied."""
        return member_properties(self, self.steel, self.length, self.fillets)

    @property
    def is_round(self) -> bool:
        """Whether it bends alike in all directions: a round section, held alike, none given."""
        given = self.second_moment, self.plastic_moment, self.unbraced_length
        alike = self.ends_about("strong") == self.ends_about("weak")
        round_ = isinstance(self.section.shape, CircularTube)
        return round_ and alike and all(each is None for each in given)

    @property
    def bars(self) -> dict[str, tuple[float, bool]]:
        """Length (m) of the segment below and above, and whether its far end is clamped."""
        base, head = self.ends
        return {
            "below": (self.length_below, base == "clamped"),
            "above": (self.length_above, head != "pinned"),
        }

    @property
    def ends(self) -> tuple[str, str]:
        """Base and head in the plane of bending."""
        return self.ends_about(self.axis)

    def ends_about(self, axis: str) -> tuple[str, str]:
        """Base and head about the strong or weak axis."""
        if axis == "strong":
            return self.base, self.head
        return self.base_weak or self.base, self.head_weak or self.head

    def stronger(self, factor: float) -> Column:
        """Return the column with another yield stress; strengths that are given grow alike."""
        return self.changed(steel=self.steel.stronger(factor), **stronger(self, factor))

    def effective_length_factor(self, axis: str | None = None) -> float:
        """Euler effective-length factor of the whole column about an axis: 0.5, 0.7 or 1."""
        base, head = self.ends_about(axis or self.axis)
        clamps = (base == "clamped") + (head != "pinned")
        return {2: 0.5, 1: 0.699156, 0: 1.0}[clamps]

    @property
    def weaker(self) -> Column:
        """The column bent about the axis with the smaller Euler load."""
        both = [self.bent_about(axis) for axis in AXES]
        return min(both, key=lambda column: column.euler_load(column.axis))

    def bent_about(self, axis: str) -> Column:
        """The column bent about an axis; section values that are given are those about its own."""
        if axis == self.axis:
            return self
        of_section = {"second_moment": None, "plastic_moment": None}
        return self.unchecked(axis=axis, section=self.section.about(axis), **of_section)

    def euler_load(self, axis: str) -> float:
        """Elastic critical load (N) about an axis; that of bending has the given second moment."""
        name = f"Euler load, {axis}"
        if name not in self.kept:
            self.kept[name] = self._euler_load(axis)
        load: float = self.kept[name]
        return load

    def _euler_load(self, axis: str) -> float:
        second = self.section.about(axis).second_moment
        if axis == self.axis:
            second = self.properties.second_moment
        length = self.effective_length_factor(axis) * self.length
        if axis == "weak" and self.unbraced_length is not None:
            length = self.unbraced_length
        return pi**2 * self.steel.elastic_modulus * second / length**2


@dataclass(frozen=True)
class Striker(Declared, table="striker"):
    """A mass that hits the column, rigid or behind a front that crushes by its law.

    Examples
    --------
    >>> wb.Striker(mass="1.5 t", velocity="54 km/h").velocity
    15.0
    >>> wb.Striker(1500, 15, stiffness=3e5).crushes
    True
    """

    mass: float = checked(MASS)
    velocity: float = checked(VELOCITY)
    restitution: float = checked(RESTITUTION, 0.0, help="Newton's, velocity after over before")
    stiffness: float | None = checked(
        STIFFNESS, optional=True, help="of what crushes: force over stroke, unloading is steep"
    )
    crush: tuple[tuple[float, float], ...] | None = checked(
        CrushLaw(Many(Number(0.0, 1e12), 2, 2), 2, MOST_POINTS),
        optional=True,
        help="from [0, 0] on, straight between its points, behind the last one its force",
    )
    angle: float = checked(
        Number(0.0, 0.5 * pi, "rad", advice='angles are in rad, or texts: "30 deg"'),
        0.0,
        omitted=True,
        help="of the hit off the height of the section; 90 deg is along its flanges",
    )
    friction: float = checked(
        Number(0.0, 1e3), 0.0, omitted=True, help="of its face; 0 slides freely, much sticks"
    )

    eccentricity: float = checked(
        Number(-2.5, 2.5, "m", advice="lengths are in metres, not millimetres"),
        0.0,
        omitted=True,
        help="of its line from the shear centre, to the left of who flies along it",
    )

    def check(self) -> None:
        """Refuse two laws, laws that are none, and a restitution beside one."""
        if self.crushes and self.restitution > 0.0:
            text = "must be 0 where the striker crushes: its law says what comes back"
            raise self.refusal("restitution", text, "drop it, or stiffness and crush")
        if self.crush is None:
            return
        if self.stiffness is not None:
            raise self.refusal("stiffness", "cannot stand beside crush", "give one of them")
        if self.crush[0] != (0.0, 0.0):
            raise self.refusal(
                "crush", "must begin with [0, 0]", "without stroke there is no force"
            )
        slopes = []
        for (stroke, force), (next_stroke, next_force) in pairwise(self.crush):
            if next_stroke <= stroke:
                text = f"strokes must rise, after {stroke:g} m comes {next_stroke:g} m"
                raise self.refusal("crush", text, "sort the points, each stroke once")
            slopes.append((next_force - force) / (next_stroke - stroke))
        if not STIFFNESS.holds(max(slopes)):
            least, most = STIFFNESS.low, STIFFNESS.high
            text = (
                f"must rise somewhere by {least:g} N/m or more, nowhere by more than {most:g} N/m"
            )
            raise self.refusal("crush", text, "forces are in N, strokes in m")

    @property
    def crushes(self) -> bool:
        """Whether it has a law by which it crushes."""
        return self.stiffness is not None or self.crush is not None

    @property
    def rebounds(self) -> bool:
        """Whether it may be thrown off and come back."""
        return (self.restitution > 0.0) | self.crushes

    @property
    def alone(self) -> Striker:
        """The striker without the place that it hits."""
        names = (field.name for field in fields(Striker))
        return Striker(**{name: getattr(self, name) for name in names})


class Impact:
    """The impact of a striker on a structure."""

    striker: Any

    @property
    def input_energy(self) -> float:
        """Kinetic energy of the striker before the impact, in J."""
        energy: float = 0.5 * self.striker.mass * self.striker.velocity**2
        return energy

    def at_velocity(self, velocity: float) -> Self:
        """Return the impact at another velocity (m/s)."""
        striker = self.striker.changed(velocity=velocity)
        changed: Self = self.changed(striker=striker)  # type: ignore[attr-defined]
        return changed


class Weighed:
    """Action on a column in a `direction`, across it, with or without `gravity`."""

    column: Column
    direction: str | None
    gravity: bool | None

    def check(self) -> None:
        """Refuse gravity across what acts."""
        if self.gravity and not self.acceleration:
            text = "must be down or up with gravity = true, which has no part in a horizontal one"
            advice = "a member that is hit from above lies: write down, or leave gravity out"
            raise self.refusal("direction", text, advice)  # type: ignore[attr-defined]

    @property
    def acceleration(self) -> float:
        """Gravity (m/s2) along what acts; 0 where it does not count, by default not upwards."""
        sense = SENSES[self.direction or "horizontal"]
        return GRAVITY * sense * (sense > 0.0 if self.gravity is None else self.gravity)

    @property
    def dead_force(self) -> float:
        """Weight (N) of the column at its impact point, as two rigid bars bring it there."""
        column, gravity = self.column, self.acceleration
        if gravity == 0.0:
            return 0.0
        own = column.properties.mass_per_length * column.length
        return (0.5 * own + max((column.impact_mass or 0.0) - own / 3.0, 0.0)) * gravity


@dataclass(frozen=True)
class ColumnPushover(Declared, table="pushover"):
    """Quasi-static push of the impact point by displacement control.

    Examples
    --------
    >>> push = wb.ColumnPushover("push", wb.Column("HEB 220", 2.0, 2.0), displacement=0.2)
    >>> wb.simulate(push, "four-dof").sizes["step"] > 1
    True
    """

    name: str = checked(Text(), path="name")
    column: Column = checked(Instance(Column))
    displacement: float = checked(Number(1e-6, 50.0, "m", advice="lengths are in metres"), 0.1)

    KIND: ClassVar[str] = "column-pushover"
    STATIC: ClassVar[bool] = True

    def check(self) -> None:
        """Refuse a push past what the column can reach."""
        shorter = min(self.column.length_below, self.column.length_above)
        if self.displacement > 2.0 * shorter:
            text = f"must be at most twice the shorter segment, {2 * shorter:g} m"
            raise self.refusal("displacement", text, "reduce the displacement")


@dataclass(frozen=True)
class ColumnImpact(Impact, Weighed, Declared, table="time"):
    """A striker hits the column at rest under its axial load, and its weight if it lies.

    Examples
    --------
    >>> impact = wb.ColumnImpact("van", wb.Column("HEB 220", 0.8, 3.2), wb.Striker(1500, 10))
    >>> impact.input_energy, impact.at_velocity(20).input_energy
    (75000.0, 300000.0)
    """

    name: str = checked(Text(), path="name")
    column: Column = checked(Instance(Column))
    striker: Striker = checked(Instance(Striker))
    duration: float = checked(DURATION, 0.1)
    direction: str | None = checked(
        SENSE, optional=True, path="striker.direction", help="of its flight, horizontal by default"
    )
    gravity: bool | None = checked(Flag(), optional=True, path="gravity", help=WEIGHS)

    def check(self) -> None:
        """Refuse gravity across what acts, and an angle to an axis that is given already."""
        super().check()
        if self.is_turned_twice:
            text = "must be left out with axis = weak, which is a hit along the flanges"
            raise self.striker.refusal("angle", text, "drop one of them")

    @property
    def is_turned_twice(self) -> bool:
        """Whether the striker has an angle to a column that is bent about its weak axis."""
        return (self.striker.angle > 0.0) & (self.column.axis == "weak")

    @property
    def angle_from_height(self) -> float:
        """Angle (rad) of the hit from the height of the section, whatever axis it bends about."""
        return self.striker.angle + (0.5 * pi if self.column.axis == "weak" else 0.0)

    KIND: ClassVar[str] = "column-impact"
    READING: ClassVar[int] = 2  # raised when what all models read off their histories changes
    STATIC: ClassVar[bool] = False
