"""Parts of planar frames: nodes, joints, members and loads.

Directions are global: x to the right, y up, rotation counter-clockwise.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from workbench.fields import Choice, Declared, Number, Text, checked
from workbench.scenarios.members import override
from workbench.sections import SECTION, Section

NAME = Text(60, label=True)
COORDINATE = Number(-1e4, 1e4, "m", advice="coordinates are in metres, not millimetres")
SPRING = Number(0.0, 1e14, "N/m")
ROTATIONAL_SPRING = Number(0.0, 1e14, "N m/rad")
HELD: dict[str, tuple[str, ...]] = {
    "free": (),
    "clamped": ("u", "v", "rotation"),
    "pinned": ("u", "v"),
    "roller-x": ("v",),
    "roller-y": ("u",),
    "guide-x": ("v", "rotation"),
    "guide-y": ("u", "rotation"),
}
COMPONENT = {"x": "u", "y": "v", "rotation": "rotation"}


@dataclass(frozen=True)
class Node(Declared, table="node", label="name"):
    """A point where members meet.

    Arguments (SI): `name`; `x`, `y`; `support`, free, clamped, pinned, roller-x (free along x and
    to rotate), roller-y, guide-x (free along x only) or guide-y; `mass` and `rotary_inertia`
    (kg m2) beside those of the members; `spring_x`, `spring_y`, `spring_rotation` to the ground,
    unstressed once the dead loads are on; `locked`, the direction (x, y or none) in which the
    node is held once the dead loads are on. Raises `InputError`.
    """

    name: str = checked(NAME)
    x: float = checked(COORDINATE)
    y: float = checked(COORDINATE)
    support: str = checked(Choice(tuple(HELD)), "free")
    mass: float = checked(Number(0.0, 1e7, "kg"), 0.0)
    rotary_inertia: float = checked(Number(0.0, 1e9, "kg m2"), 0.0)
    spring_x: float = checked(SPRING, 0.0)
    spring_y: float = checked(SPRING, 0.0)
    spring_rotation: float = checked(ROTATIONAL_SPRING, 0.0)
    locked: str = checked(Choice(("none", "x", "y")), "none")

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
    def resisted(self) -> set[str]:
        """Displacements that the support, a spring or a lock resists."""
        sprung = {c for name, c in COMPONENT.items() if getattr(self, f"spring_{name}") > 0.0}
        return {*self.held, *sprung, *([] if self.locked == "none" else [COMPONENT[self.locked]])}


@dataclass(frozen=True)
class Joint(Declared, table="joint", label="name"):
    """How the end of a member is joined to its node.

    Arguments (SI): `name`; `rotational_stiffness` (N m/rad, zero for a pin) and `axial_stiffness`
    (N/m), None for rigid; `plastic_moment`, sagging positive in the member's own axes,
    `plastic_moment_negative`, `tension_resistance` and `compression_resistance`, all as positive
    numbers, None for the member's own. Raises `InputError`.
    """

    name: str = checked(NAME)
    rotational_stiffness: float | None = checked(ROTATIONAL_SPRING, optional=True)
    axial_stiffness: float | None = checked(Number(1.0, 1e14, "N/m"), optional=True)
    plastic_moment: float | None = override("plastic_moment")
    plastic_moment_negative: float | None = override("plastic_moment")
    tension_resistance: float | None = override("squash_load")
    compression_resistance: float | None = override("squash_load")

    def check(self) -> None:
        """Refuse a pin that carries a moment."""
        for name in ("plastic_moment", "plastic_moment_negative"):
            if self.rotational_stiffness == 0.0 and getattr(self, name) is not None:
                advice = "drop it or give a rotational stiffness"
                raise self.refusal(name, "a pin carries no moment", advice)

    def weaker(self, member: Sequence[float]) -> tuple[float, ...]:
        """Strength at the end of a `member`, its own or that of the joint, whichever is less.

        Tension and compression resistance (N), sagging and hogging plastic moment (N m).
        """
        forces = self.tension_resistance, self.compression_resistance
        given = *forces, self.plastic_moment, self.plastic_moment_negative
        pairs = zip(member, given, strict=True)
        return tuple(own if least is None else min(own, least) for own, least in pairs)


RIGID, PINNED = Joint("rigid"), Joint("pinned", rotational_stiffness=0.0)
PREDEFINED = {joint.name: joint for joint in (RIGID, PINNED)}


@dataclass(frozen=True)
class Member(Declared, table="member", label="name"):
    """A straight member from node `start` to node `end`, bent about its strong axis.

    Arguments (SI): `name`; names of the two nodes; `section`; names of the joints at its ends;
    the other fields override what the section gives. Its internal moment is positive where it
    stretches the fibers on the right of somebody who looks from start to end.
    Raises `InputError`.
    """

    name: str = checked(NAME)
    start: str = checked(NAME)
    end: str = checked(NAME)
    section: Section = checked(SECTION)
    joint_start: str = checked(NAME, RIGID.name)
    joint_end: str = checked(NAME, RIGID.name)
    area: float | None = override("area")
    second_moment: float | None = override("second_moment")
    plastic_moment: float | None = override("plastic_moment")
    squash_load: float | None = override("squash_load")
    mass_per_length: float | None = override("mass_per_length")

    def check(self) -> None:
        """Refuse a member from a node to itself."""
        if self.start == self.end:
            raise self.refusal("end", "must be another node than the start")


@dataclass(frozen=True)
class Load(Declared, table="load", label="node"):
    """Forces `x` and `y` (N) and a `moment` (N m) on the node of that name."""

    node: str = checked(NAME)
    x: float = checked(Number(-1e9, 1e9, "N"), 0.0)
    y: float = checked(Number(-1e9, 1e9, "N"), 0.0)
    moment: float = checked(Number(-1e9, 1e9, "N m"), 0.0)
