"""Parts of frames, and what their members share with columns; all values in SI units.

Directions are global: x to the right, y up, z towards the viewer, rotation counter-clockwise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Any, NamedTuple

from workbench.base.fields import Choice, Declared, Many, Number, Text, checked
from workbench.steel.materials import Steel
from workbench.steel.sections import AXES, SECTION, Section

NAME = Text(60, label=True)
COORDINATE = Number(-1e4, 1e4, "m", advice="coordinates are in metres, not millimetres")
LENGTH = Number(0.02, 100.0, "m", advice="lengths are in metres, not millimetres")
LINE_LOAD = Number(-1e8, 1e8, "N/m", advice="line loads are in N/m: 20 kN/m is 20e3")
FORCE, MOMENT = Number(-1e9, 1e9, "N"), Number(-1e9, 1e9, "N m")
SPRING, ROTATIONAL_SPRING = Number(0.0, 1e14, "N/m"), Number(0.0, 1e14, "N m/rad")
GRAVITY = 9.80665  # m/s2, standard acceleration of free fall
PULL = Many(Number(-GRAVITY, GRAVITY, "m/s2"), 2, 2)
OVERRIDES = {
    "area": Number(1e-6, 2.0, "m2", advice="areas are in m2: 91 cm2 is 91e-4"),
    "second_moment": Number(
        1e-12, 1.0, "m4", advice="second moments are in m4: 8091 cm4 is 8091e-8"
    ),
    "plastic_moment": Number(1.0, 1e9, "N m"),
    "squash_load": Number(1.0, 1e10, "N"),
    "mass_per_length": Number(0.01, 1e5, "kg/m"),
}
HELD: dict[str, tuple[str, ...]] = {
    "free": (),
    "clamped": ("u", "v", "rotation"),
    "pinned": ("u", "v"),
    "roller-x": ("v",),
    "roller-y": ("u",),
    "guide-x": ("v", "rotation"),
    "guide-y": ("u", "rotation"),
}
# what they hold beside that in space; what is pinned does not twist
HELD_BESIDE = {"clamped": ("w", "turn_x", "turn_y"), "pinned": ("w", "turn_y")}
CLAMPED_HINT = "a support that is fixed, its rotation held too, is clamped"
COMPONENT = {"x": "u", "y": "v", "rotation": "rotation"}


def override(name: str) -> Any:
    """Declare the field that overrides what the section gives, None unless given."""
    return checked(OVERRIDES[name], optional=True, help="overrides that of the section")


@dataclass(frozen=True)
class MemberProperties:
    """Section values of a member with the overrides of the scenario.

    `area` (m2) and `second_moment` (m4) are elastic; `plastic_moment` (N m), `squash_load` and
    `shear_resistance` (N) are strengths; `mass_per_length` (kg/m), `impact_mass` (kg); its
    `rotary_inertia` is per length (kg m).
    """

    area: float
    second_moment: float
    plastic_moment: float
    squash_load: float
    shear_resistance: float
    mass_per_length: float
    impact_mass: float

    @property
    def rotary_inertia(self) -> float:
        """Mass per length times the square of the radius of gyration."""
        return self.mass_per_length * self.second_moment / self.area

    @property
    def strength(self) -> tuple[float, ...]:
        """In tension and compression (N), sagging and hogging (N m): see `Joint.weaker`."""
        return self.squash_load, self.squash_load, self.plastic_moment, self.plastic_moment


def strength_section(section: Section, fillets: bool) -> Section:
    """Return the section whose fibers and envelope give the strength: plates unless `fillets`."""
    return section if fillets else section.without_fillets()


def member_properties(part: Any, steel: Steel, length: float, fillets: bool) -> MemberProperties:
    """Return the properties of a column or member `part` of `length` (m).

    Stiffness and mass are those of the whole profile, the strength leaves the root fillets out
    unless `fillets`; the impact mass is rho A L / 3 (Heng 2017, section 5.2).
    """
    strength = strength_section(part.section, fillets)

    def given(name: str, computed: float) -> float:
        value: float | None = getattr(part, name, None)
        return computed if value is None else value

    area = given("area", part.section.area)
    mass = given("mass_per_length", steel.density * area)
    return MemberProperties(
        area=area,
        second_moment=given("second_moment", part.section.second_moment),
        plastic_moment=given("plastic_moment", strength.plastic_moment(steel)),
        squash_load=given("squash_load", strength.squash_load(steel)),
        shear_resistance=strength.shear_resistance(steel),
        mass_per_length=mass,
        impact_mass=given("impact_mass", mass * length / 3.0),
    )


def stronger(part: Any, factor: float) -> dict[str, Any]:
    """Return the strengths that are given for a column or member `part`, grown by a factor."""
    given = {name: getattr(part, name) for name in ("plastic_moment", "squash_load")}
    return {name: factor * value for name, value in given.items() if value is not None}


@dataclass(frozen=True)
class Node(Declared, table="node", label="name"):
    """A point where members meet.

    Examples
    --------
    >>> wb.Node("A0", x=0.0, y=0.0, support="pinned").held
    ('u', 'v')
    """

    name: str = checked(NAME)
    x: float = checked(COORDINATE)
    y: float = checked(COORDINATE)
    support: str = checked(
        Choice(tuple(HELD), CLAMPED_HINT), "free", help="roller-x and guide-x: free along x"
    )
    mass: float = checked(Number(0.0, 1e7, "kg"), 0.0, help="beside that of the members")
    rotary_inertia: float = checked(Number(0.0, 1e9, "kg m2"), 0.0)
    spring_x: float = checked(SPRING, 0.0, help="to the ground, unstressed under dead loads")
    spring_y: float = checked(SPRING, 0.0, help="to the ground, unstressed under dead loads")
    spring_rotation: float = checked(ROTATIONAL_SPRING, 0.0, help="unstressed under dead loads")
    locked: str = checked(
        Choice(("none", "x", "y")), "none", help="direction that is held once dead loads are on"
    )
    z: float = checked(COORDINATE, 0.0, omitted=True, help="of a frame in space")

    def check(self) -> None:
        """Refuse springs and locks where the support holds the node."""
        for direction, component in COMPONENT.items():
            name = f"spring_{direction}"
            if component in self.held and getattr(self, name) > 0.0:
                text = f"acts where the support {self.support} already holds the node"
                raise self.refusal(name, text, "drop the spring or change the support")
        if self.locked != "none" and COMPONENT[self.locked] in self.held:
            text = f"the support {self.support} already holds the node there"
            raise self.refusal("locked", text, "write none or change the support")

    @property
    def held(self) -> tuple[str, ...]:
        """Displacements that the support holds, out of u (along x), v (along y) and rotation."""
        return HELD[self.support]

    @property
    def held_beside(self) -> tuple[str, ...]:
        """Displacements that the support holds beside those in space: w (along z), turns."""
        return HELD_BESIDE.get(self.support, ())

    @property
    def resisted(self) -> set[str]:
        """Displacements that the support, a spring or a lock resists."""
        sprung = {c for name, c in COMPONENT.items() if getattr(self, f"spring_{name}") > 0.0}
        return {*self.held, *sprung, *([] if self.locked == "none" else [COMPONENT[self.locked]])}


@dataclass(frozen=True)
class Joint(Declared, table="joint", label="name"):
    """Joint between the end of a member and its node; strengths as positive numbers.

    None stands for a rigid stiffness, and for the strength of the member.

    Examples
    --------
    >>> wb.Joint("bolted", rotational_stiffness=2e7, plastic_moment="60 kN m").plastic_moment
    60000.0
    """

    name: str = checked(NAME)
    rotational_stiffness: float | None = checked(
        ROTATIONAL_SPRING, optional=True, help="zero for a pin"
    )
    axial_stiffness: float | None = checked(Number(1.0, 1e14, "N/m"), optional=True)
    plastic_moment: float | None = checked(
        OVERRIDES["plastic_moment"], optional=True, help="sagging in the axes of the member"
    )
    plastic_moment_negative: float | None = checked(OVERRIDES["plastic_moment"], optional=True)
    tension_resistance: float | None = checked(OVERRIDES["squash_load"], optional=True)
    compression_resistance: float | None = checked(OVERRIDES["squash_load"], optional=True)

    def check(self) -> None:
        """Refuse a pin that carries a moment."""
        for name in ("plastic_moment", "plastic_moment_negative"):
            if self.rotational_stiffness == 0.0 and getattr(self, name) is not None:
                advice = "drop it or give a rotational stiffness"
                raise self.refusal(name, "a pin carries no moment", advice)

    def weaker(self, member: Sequence[float]) -> tuple[float, ...]:
        """Return the strength at a member's end: that of the `member` or of the joint, if less.

        Tension and compression resistance (N), sagging and hogging plastic moment (N m).
        """
        forces = self.tension_resistance, self.compression_resistance
        limits = *forces, self.plastic_moment, self.plastic_moment_negative
        pairs = zip(member, limits, strict=True)
        return tuple(value if limit is None else min(value, limit) for value, limit in pairs)


RIGID, PINNED = Joint("rigid"), Joint("pinned", rotational_stiffness=0.0)
PREDEFINED = {joint.name: joint for joint in (RIGID, PINNED)}


@dataclass(frozen=True)
class Member(Declared, table="member", label="name"):
    """A straight member between two nodes, bent about its strong axis, or its weak one.

    Its internal moment is positive where it stretches the fibers on the right of somebody who
    looks from start to end.

    Examples
    --------
    >>> wb.Member("A1-B1", "A1", "B1", "IPE 300", joint_start="pinned").joint_end
    'rigid'
    """

    name: str = checked(NAME)
    start: str = checked(NAME, help="name of a node")
    end: str = checked(NAME, help="name of a node")
    section: Section = checked(SECTION)
    joint_start: str = checked(NAME, RIGID.name, help="name of a joint, rigid or pinned")
    joint_end: str = checked(NAME, RIGID.name, help="name of a joint, rigid or pinned")
    load_x: float = checked(LINE_LOAD, 0.0, help="dead line load along x")
    load_y: float = checked(LINE_LOAD, 0.0, help="dead line load along y, down is negative")
    area: float | None = override("area")
    second_moment: float | None = override("second_moment")
    plastic_moment: float | None = override("plastic_moment")
    squash_load: float | None = override("squash_load")
    mass_per_length: float | None = override("mass_per_length")
    axis: str = checked(Choice(AXES), "strong", help="about which it bends in the plane")
    roll: float = checked(
        Number(-pi, pi, "rad", advice='angles are in rad, or texts: "30 deg"'),
        0.0,
        omitted=True,
        help="of the section about the line from start to end, from where its height is upright, "
        "of an upright member along x",
    )

    def check(self) -> None:
        """Turn the section to its axis; refuse a member from a node to itself."""
        object.__setattr__(self, "section", self.section.about(self.axis))
        if self.start == self.end:
            raise self.refusal("end", "must be another node than the start")

    @property
    def ends(self) -> "tuple[MemberEnd, MemberEnd]":
        """Both ends, the start first."""
        return MemberEnd(self, True), MemberEnd(self, False)


class MemberEnd(NamedTuple):
    """The start of a `member`, or its other end."""

    member: Member
    at_start: bool

    @property
    def node(self) -> str:
        """Name of the node there."""
        return self.member.start if self.at_start else self.member.end

    @property
    def joint(self) -> str:
        """Name of the joint there."""
        return self.member.joint_start if self.at_start else self.member.joint_end

    @property
    def other(self) -> "MemberEnd":
        """The other end of the member."""
        return MemberEnd(self.member, not self.at_start)


@dataclass(frozen=True)
class Load(Declared, table="load", label="node"):
    """Forces and a moment on the node of that name.

    Examples
    --------
    >>> wb.Load("A1", y="-200 kN").y
    -200000.0
    """

    node: str = checked(NAME)
    x: float = checked(FORCE, 0.0)
    y: float = checked(FORCE, 0.0)
    moment: float = checked(MOMENT, 0.0)
