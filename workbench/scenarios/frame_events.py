"""Scenarios of a frame; a column as its two-member frame."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, astuple, dataclass, replace
from functools import lru_cache
from itertools import pairwise
from math import cos, hypot, pi, sin
from typing import Any, ClassVar

import numpy as np

from workbench.base.errors import InputError
from workbench.base.fields import Choice, Declared, Flag, Instance, Many, Number, Text, checked
from workbench.scenarios.column import (
    DURATION,
    WEIGHS,
    Column,
    ColumnImpact,
    ColumnPushover,
    Impact,
    Striker,
)
from workbench.scenarios.frame import Frame, FrameForm
from workbench.scenarios.parts import COMPONENT, GRAVITY, NAME, OVERRIDES, Load, Member, Node
from workbench.scenarios.pulse import UNIFORM, MemberPulse, Pulse

MOTIONS = ("x", "y", "rotation", "-x", "-y", "-rotation")
STRIKES = ("+x", "-x", "+y", "-y")
CONTROLS = ("displacement", "load", "arc-length")
LARGEST_ROTATION = 20.0  # rad; three turns
TARGETS = Many(Number(-1e9, 1e9), 1, 10_000, single=True)
ACCELERATIONS = Many(
    Number(-1e3, 1e3, "m/s2", advice="accelerations are in m/s2: 0.3 g is 2.94"), 2, 200_000
)
LEAST_ACCELERATION = 1e-6  # m/s2, of the ground at its peak
FRAME = Instance(Frame, form=FrameForm)
RECORD = replace(DURATION, high=1e3)
TOWARDS = Number(-pi, pi, "rad", advice='angles are in rad, or texts: "30 deg"')
HEADS = {"guided": "guide-y", "pinned": "roller-y", "fixed": "guide-y"}


def _horizontal(part: Any) -> None:
    """Refuse an angle towards z of what acts along y."""
    if part.angle and part.direction.endswith("y"):
        text = "turns what acts along x towards z, not what acts along y"
        raise part.refusal("angle", text, "take direction +x or -x, or leave it out")


@dataclass(frozen=True)
class FrameStriker(Striker):
    """A mass that hits a node of a frame.

    Examples
    --------
    >>> wb.FrameStriker("1.5 t", "36 km/h", node="A1").direction
    '+x'
    """

    angle: float = checked(TOWARDS, 0.0, omitted=True, help="of its flight, off x towards z")
    _: KW_ONLY
    node: str = checked(NAME)
    direction: str = checked(Choice(STRIKES), "+x", help="of its flight")

    def check(self) -> None:
        """Refuse laws that no striker has, and an angle of a flight along y."""
        super().check()
        _horizontal(self)


@dataclass(frozen=True)
class FrameStatic(Declared, table="push"):
    """Static loading of a frame by a pattern of loads times a load factor.

    The dead loads of the frame are brought on first and kept. `path` is reached target by target:

    * control ``displacement``: displacements (m or rad) along the direction; several for cycles;
    * control ``load``: load factors;
    * control ``arc-length``: one displacement, followed through limit points.

    Examples
    --------
    >>> frame = wb.regular_frame([6.0], [3.0], "HEB 220", "IPE 300")
    >>> loads = (wb.Load("A1", x="10 kN"),)
    >>> wb.FrameStatic("sway", frame, loads, node="B1", direction="x", path=(0.05,)).magnitude  # N
    10000.0
    """

    name: str = checked(Text(), path="name")
    frame: Frame = checked(FRAME)
    loads: tuple[Load, ...] = checked(Many(Instance(Load), 1), path="pattern")
    node: str = checked(NAME, help="whose displacement is recorded")
    direction: str = checked(Choice(MOTIONS), help="of the displacement that is recorded")
    path: tuple[float, ...] = checked(TARGETS)
    control: str = checked(Choice(CONTROLS), "displacement")
    gravity: bool | None = checked(Flag(), optional=True, path="gravity", help=WEIGHS)

    KIND: ClassVar[str] = "frame-static"
    STATIC: ClassVar[bool] = True

    def check(self) -> None:
        """Refuse loads, displacements and targets that the frame cannot have."""
        _weigh(self)
        moves = False
        for load in self.loads:
            node = self.frame.node(load.node, f"pattern.{load.node}.node")
            for axis, value in (("x", load.x), ("y", load.y), ("rotation", load.moment)):
                moves |= value != 0.0 and not _is_held(node, axis)
        if not moves:
            text = "no load acts where the frame can move"
            raise InputError("pattern", None, text, "give x, y or moment")
        _check_motion(self.frame, self)
        if self.control == "arc-length" and len(self.path) != 1:
            text = "must be one displacement under arc-length control"
            raise self.refusal("path", text, "use control displacement or load for several")
        turning = self.direction.endswith("rotation")
        limit = LARGEST_ROTATION if turning else 2.0 * self.frame.extent
        for i, (before, target) in enumerate(pairwise((0.0, *self.path))):
            place = f"push.path.{i}"
            if target == before:
                text = "must differ from the one before (at first: from 0)"
                raise InputError(place, target, text)
            if self.control != "load" and abs(target) > limit:
                within = "rotations up to {:g} rad" if turning else "twice the frame, {:g} m"
                advice = "targets are displacements in m or rad; control load takes load factors"
                raise InputError(place, target, f"must stay within {within.format(limit)}", advice)

    @property
    def magnitude(self) -> float:
        """Size of the pattern at a load factor of 1.

        Its resultant force in N; the largest single force where those balance each other; the
        largest moment in N m where there are only moments.
        """
        forces = [hypot(load.x, load.y) for load in self.loads]
        if not any(forces):
            return max(abs(load.moment) for load in self.loads)
        resultant = hypot(sum(load.x for load in self.loads), sum(load.y for load in self.loads))
        return resultant if resultant > 1e-9 * max(forces) else max(forces)


@dataclass(frozen=True)
class FrameImpact(Impact, Declared, table="time"):
    """A striker hits a frame at rest under its dead loads.

    With `gravity` its own weight is among them, and the striker weighs.

    Examples
    --------
    >>> frame = wb.regular_frame([6.0], [3.0], "HEB 220", "IPE 300")
    >>> wb.FrameImpact("van", frame, wb.FrameStriker(1500, 10, node="A1")).input_energy  # J
    75000.0
    """

    name: str = checked(Text(), path="name")
    frame: Frame = checked(FRAME)
    striker: FrameStriker = checked(Instance(FrameStriker))
    duration: float = checked(DURATION, 0.1)
    gravity: bool | None = checked(Flag(), optional=True, path="gravity", help=WEIGHS)

    KIND: ClassVar[str] = "frame-impact"
    READING: ClassVar[int] = 3  # raised when what all models read off their histories changes
    STATIC: ClassVar[bool] = False

    def check(self) -> None:
        """Refuse a strike where the frame is held; it weighs if that comes down."""
        if self.gravity is None and self.striker.direction == "-y":
            object.__setattr__(self, "gravity", True)
        _weigh(self)
        _check_motion(self.frame, self.striker)

    @property
    def acceleration(self) -> float:
        """Gravity (m/s2) along the flight of the striker."""
        pull = self.frame.gravity["xy".index(self.striker.direction[-1])]
        return -pull if self.striker.direction.startswith("-") else pull


@dataclass(frozen=True)
class FrameGroundMotion(Declared, table="ground"):
    """The ground under all supports of a frame at rest moves.

    Examples
    --------
    >>> frame = wb.regular_frame([6.0], [3.0], "HEB 220", "IPE 300")
    >>> wb.FrameGroundMotion("jolt", frame, (0.0, 3.0, -3.0, 0.0), 0.01, "A1").duration  # s
    0.03
    """

    name: str = checked(Text(), path="name")
    frame: Frame = checked(FRAME)
    acceleration: tuple[float, ...] = checked(
        ACCELERATIONS, help="of the ground, at 0, time_step, 2 time_step, ..., then zero"
    )
    time_step: float = checked(Number(1e-6, 1.0, "s", advice="time steps are in seconds"))
    node: str = checked(NAME, help="whose displacement relative to the ground is recorded")
    direction: str = checked(Choice(("x", "y")), "x")
    duration: float = checked(
        RECORD, optional=True, path="time.duration", help="by default to the end of the record"
    )  # never None afterwards
    damping: float = checked(
        Number(0.0, 1e4, "1/s"), 0.0, help="forces in proportion to mass and relative velocity"
    )
    load_as_mass: bool = checked(
        Flag(), False, help="whether nodes have the mass of their dead loads too"
    )
    gravity: bool | None = checked(Flag(), optional=True, path="gravity", help=WEIGHS)

    KIND: ClassVar[str] = "frame-ground-motion"
    READING: ClassVar[int] = 2  # raised when what all models read off their histories changes
    STATIC: ClassVar[bool] = False

    def with_masses(self) -> "FrameGroundMotion":
        """Return the motion with the dead loads as masses of the nodes, if `load_as_mass`."""
        if not self.load_as_mass:
            return self
        mass = self.frame.load_masses
        nodes = tuple(replace(n, mass=n.mass + mass.get(n.name, 0.0)) for n in self.frame.nodes)
        return replace(self, frame=replace(self.frame, nodes=nodes), load_as_mass=False)

    def check(self) -> None:
        """Refuse a ground at rest and displacements that are held; take the duration."""
        _weigh(self)
        if max(map(abs, self.acceleration)) < LEAST_ACCELERATION:
            text = f"must reach {LEAST_ACCELERATION:g} m/s2 somewhere"
            raise InputError("ground.acceleration", None, text)
        _check_motion(self.frame, self)
        if self.duration is None:
            end = (len(self.acceleration) - 1) * self.time_step
            object.__setattr__(self, "duration", RECORD.check("time.duration", end))


@dataclass(frozen=True)
class FramePulse(Declared, table="pulse"):
    """A pulse on a frame at rest under its dead loads.

    Examples
    --------
    >>> frame = wb.regular_frame([6.0], [3.0], "HEB 220", "IPE 300")
    >>> pulse = wb.Pulse("triangular", peak=2e4, length=0.05)
    >>> wb.FramePulse("blast", frame, pulse, node="A1", members=("A0-A1",)).duration  # s
    0.1
    """

    name: str = checked(Text(), path="name")
    frame: Frame = checked(FRAME)
    pulse: Pulse = checked(Instance(Pulse), help="factor on the loads, line load on the members")
    node: str = checked(NAME, help="whose displacement along direction is recorded")
    direction: str = checked(Choice(STRIKES), "+x", help="of the line load and the displacement")
    loads: tuple[Load, ...] = checked(Many(Instance(Load)), (), path="pattern")
    members: tuple[str, ...] = checked(
        Many(NAME, different=True), (), help="that the line load (N/m) acts on"
    )
    duration: float = checked(DURATION, 0.1, path="time.duration")
    gravity: bool | None = checked(Flag(), optional=True, path="gravity", help=WEIGHS)
    angle: float = checked(TOWARDS, 0.0, omitted=True, help="of both, off x towards z")

    KIND: ClassVar[str] = "frame-pulse"
    READING: ClassVar[int] = 3  # raised when what all models read off their histories changes
    STATIC: ClassVar[bool] = False

    def check(self) -> None:
        """Refuse a pulse on nothing, and nodes and members that are not there."""
        _horizontal(self)
        _weigh(self)
        _check_motion(self.frame, self)
        for load in self.loads:
            self.frame.node(load.node, f"pattern.{load.node}.node")
        known = [member.name for member in self.frame.members]
        for name in self.members:
            if name not in known:
                raise self.refusal("members", f"{name} is not among {', '.join(known)}")
        if not self.loads and not self.members:
            raise self.refusal("members", "must not be empty without a [[pattern]] of loads")


FrameScenario = FrameStatic | FrameImpact | FrameGroundMotion | FramePulse


def azimuth(scenario: FrameScenario) -> float:
    """Angle (rad) about y by which a frame is turned for what acts on it to lie along x."""
    part: Any = getattr(scenario, "striker", scenario)
    angle: float = getattr(part, "angle", 0.0)
    return -angle if part.direction.startswith("-") else angle


@lru_cache(maxsize=64)
def facing(scenario: FrameScenario) -> FrameScenario:
    """Return the scenario turned about y, so that what acts on its frame lies along x."""
    turn, frame = azimuth(scenario), scenario.frame
    if not turn:
        return scenario
    c, s = cos(turn), sin(turn)
    nodes = tuple(
        node.unchecked(x=c * node.x + s * node.z, z=c * node.z - s * node.x) for node in frame.nodes
    )
    # upright members turn, of others the rule does
    rolls = turn * np.sign(frame.chords[:, 1]) * frame.upright
    members = tuple(
        member.unchecked(roll=member.roll + roll)
        for member, roll in zip(frame.members, rolls.tolist(), strict=True)
    )
    part: Any = {"angle": 0.0}
    if isinstance(scenario, FrameImpact):
        part = {"striker": scenario.striker.unchecked(angle=0.0)}
    return scenario.unchecked(frame=frame.unchecked(nodes=nodes, members=members), **part)


def cyclic_path(amplitudes: Sequence[float], cycles: int = 1) -> tuple[float, ...]:
    """Targets that swing `cycles` times between both signs of each amplitude, then end at zero.

    Equal amplitudes give the constant protocol, rising ones the increasing one. Raises
    `InputError`.
    """
    count = int(Number(1, 1000, integer=True).check("cycles", cycles))
    rule = Many(Number(0.0, 1e9, low_included=False), 1, 1000)
    path = [(a, -a) for a in rule.check("amplitudes", amplitudes) for _ in range(count)]
    return (*(target for pair in path for target in pair), 0.0)


def _weigh(scenario: Any) -> None:
    """Let the frame of a scenario weigh if its `gravity` says so; else it does not."""
    weighs = any(scenario.frame.gravity)  # that of a column that lies along y weighs along x
    if weighs != bool(scenario.gravity):
        pull = (0.0, 0.0) if weighs else (0.0, -GRAVITY)
        object.__setattr__(scenario, "frame", scenario.frame.changed(gravity=pull))


def _check_motion(
    frame: Frame, motion: FrameStatic | FrameGroundMotion | FramePulse | FrameStriker
) -> None:
    """Refuse nodes that are not there or cannot move along a direction."""
    node, axis = frame.node(motion.node, f"{motion.TABLE}.node"), motion.direction.lstrip("+-")
    if _is_held(node, axis):
        by = f"support {node.support}" if COMPONENT[axis] in node.held else "lock"
        text = f"node {node.name} cannot move there: its {by} holds it"
        raise motion.refusal("direction", text, "take another node or direction")


def _is_held(node: Node, axis: str) -> bool:
    return COMPONENT[axis] in node.held or node.locked == axis


@lru_cache(maxsize=64)
def frame_of(column: Column) -> Frame:
    """Return a column as a frame: nodes base, hit and head, members below and above the hit.

    Its axial load is a dead load on the head, its restraint a spring there. Members carry their
    own mass; of an `impact_mass` the impact point has what is attached beside a third of that.
    """
    base_support, head_support = column.ends
    head = Node("head", 0.0, column.length, HEADS[head_support], column.head_mass)
    locked = "y" if column.head == "fixed" else "none"
    head = replace(head, spring_y=column.restraint_stiffness, locked=locked)
    base, place = Node("base", 0.0, 0.0, base_support), (0.0, column.length_below)
    hit = Node("hit", *place, mass=column.attached_mass)
    overrides = {name: getattr(column, name) for name in (*OVERRIDES, "axis")}
    members = (
        Member("below", "base", "hit", column.section, **overrides),
        Member("above", "hit", "head", column.section, **overrides),
    )
    loads = (Load("head", y=-column.axial_load),) if column.axial_load else ()
    return Frame((base, hit, head), members, loads, steel=column.steel, fillets=column.fillets)


@lru_cache(maxsize=64)
def frame_scenario(
    scenario: FrameScenario | ColumnPushover | ColumnImpact | MemberPulse,
) -> FrameScenario:
    """Return the frame scenario; a column becomes its two-member frame, acted on along +x.

    So gravity is along x where it counts: the frame of a column stands although that lies.
    """
    if isinstance(scenario, FrameScenario):
        return scenario
    frame, name, weighs = frame_of(scenario.column), scenario.name, None
    if not isinstance(scenario, ColumnPushover) and scenario.acceleration:
        frame, weighs = frame.changed(gravity=(scenario.acceleration, 0.0)), True
    if isinstance(scenario, ColumnImpact):
        striker = FrameStriker(*astuple(scenario.striker), node="hit", direction="+x")
        return FrameImpact(name, frame, striker, scenario.duration, weighs)
    pattern = (Load("hit", x=1.0),)
    if isinstance(scenario, ColumnPushover):
        path = (scenario.displacement,)
        return FrameStatic(name, frame, pattern, "hit", "x", path, "displacement")
    on: Any = {"loads": pattern, "gravity": weighs}
    if scenario.load == UNIFORM:
        on = {"members": ("below", "above"), "gravity": weighs}
    return FramePulse(name, frame, scenario.pulse, "hit", "+x", duration=scenario.duration, **on)
