"""The frame: nodes, members, joints and dead loads that fit together and are supported.

**Second part.** Frames in files: nodes and members, or axes and levels; splits refine both.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import chain, count, islice, pairwise, product
from math import hypot, pi
from string import ascii_lowercase, ascii_uppercase
from typing import Any, TypeVar, cast

import numpy as np

from workbench.base.arrays import Array, Flags, Indices
from workbench.base.errors import InputError
from workbench.base.fields import Choice, Declared, Flag, Instance, Many, checked, did_you_mean
from workbench.scenarios.parts import (
    GRAVITY,
    LENGTH,
    NAME,
    PREDEFINED,
    PULL,
    RIGID,
    Joint,
    Load,
    Member,
    MemberEnd,
    MemberProperties,
    Node,
    member_properties,
    strength_section,
    stronger,
)
from workbench.steel.materials import MadeOfSteel, Steel
from workbench.steel.sections import AXES, SECTION, Section

ROUNDING = 1.0 - 1e-9  # a length that is computed from coordinates
APART = 1e-6  # m; nodes closer than this are in one place
UPRIGHT = 1e-3  # run over rise of a member that counts as upright
FREE = 1e-6  # singular value of the support conditions below which a motion is free

T = TypeVar("T")


class of_geometry(cached_property[T]):  # noqa: N801
    """A property that frames share which differ in the strength of their steel alone."""

    def __get__(self, frame: Any, owner: type[Any] | None = None) -> T:  # type: ignore[override]
        value = super().__get__(frame.elastic, owner)
        return cast(T, vars(frame).setdefault(self.attrname, value))


@lru_cache(maxsize=64)
def _first_of(frame: Frame) -> Frame:
    """The first of equal frames."""
    return frame


@dataclass(frozen=True)
class Frame(MadeOfSteel, table="frame"):
    """A steel frame, in the plane z = 0 or in space.

    Examples
    --------
    >>> nodes = wb.Node("A0", 0.0, 0.0, "clamped"), wb.Node("A1", 0.0, 3.0)
    >>> frame = wb.Frame(nodes, (wb.Member("A0-A1", "A0", "A1", "HEB 220"),))
    >>> frame.length("A0-A1")
    3.0
    """

    nodes: tuple[Node, ...] = checked(Many(Instance(Node), 2))
    members: tuple[Member, ...] = checked(Many(Instance(Member), 1))
    loads: tuple[Load, ...] = checked(
        Many(Instance(Load)), (), help="dead loads that are brought on first and kept"
    )
    joints: tuple[Joint, ...] = checked(Many(Instance(Joint)), (), help="beside rigid and pinned")
    steel: Steel = checked(Instance(Steel), Steel())
    fillets: bool = checked(
        Flag(), True, help="whether root fillets count in the strength (always in stiffness, mass)"
    )
    gravity: tuple[float, ...] = checked(PULL, (0.0, 0.0), help="under which its own mass weighs")

    def check(self) -> None:
        """Refuse names that do not fit, members without length, loose parts, no supports."""
        if "fits" not in self.elastic.kept:
            self._check_parts()
            self.elastic.kept["fits"] = True

    @property
    def elastic(self) -> Frame:
        """One and the same frame for all that differ in the strength of their steel alone."""
        if "elastic" not in self.kept:
            alike = {"yield_stress": 1.0, "hardening_modulus": None, "rate": None}
            steel = self.steel.unchecked(**alike, grade=None, thickness=None)
            first = _first_of(self.unchecked(steel=steel))
            self.kept["elastic"] = first.kept["elastic"] = first
        return cast(Frame, self.kept["elastic"])

    def _check_parts(self) -> None:
        for joint in self.joints:
            if joint.name in PREDEFINED:
                raise InputError("joint.name", joint.name, "is predefined", "choose another name")
        for parts in (self.nodes, self.members, self.joints):
            counts = Counter(part.name for part in cast(Sequence[Node], parts))
            for part in cast(Sequence[Node], parts):
                if counts[part.name] > 1:
                    raise part.refusal("name", "is given twice", "names must be unique")
        for member in self.members:
            self._check_member(member)
        for load in self.loads:
            self.node(load.node, f"load.{load.node}.node")
        places = [tuple(map(round, place)) for place in (self.points / APART).tolist()]
        advice = "join the members at one node; joints make pins"
        _check_unique(self.nodes, places, "lies where node {} lies", advice)
        pairs = [frozenset((member.start, member.end)) for member in self.members]
        _check_unique(self.members, pairs, "joins the same nodes as member {}", "drop one of them")
        _check_connected(self)
        _check_supported(self)

    def _check_member(self, member: Member) -> None:
        path = f"member.{member.name}"
        for end in ("start", "end"):
            self.node(getattr(member, end), f"{path}.{end}")
            self.joint(getattr(member, f"joint_{end}"), f"{path}.joint_{end}")
        length = self.length(member)
        if not LENGTH.low * ROUNDING <= length <= LENGTH.high / ROUNDING:
            ends = f"between {member.start} and {member.end}"
            text = f"is {length:g} m long {ends}; a length {LENGTH.allowed()}"
            raise member.refusal("", text, LENGTH.advice)

    @cached_property
    def _named(self) -> dict[str, dict[str, Any]]:
        """Nodes, members and joints by their kind and name."""
        return {
            "node": {node.name: node for node in self.nodes},
            "member": {member.name: member for member in self.members},
            "joint": PREDEFINED | {joint.name: joint for joint in self.joints},
        }

    def stronger(self, factor: float) -> Frame:
        """Return the frame with another yield stress; strengths that are given grow alike."""
        members = tuple(replace(each, **stronger(each, factor)) for each in self.members)
        return replace(self, steel=self.steel.stronger(factor), members=members)

    @of_geometry
    def turned(self) -> set[str]:
        """Names of nodes that cannot turn without a member."""
        return {node.name for node in self.nodes if self.turns(node.name)}

    def turns(self, node: str, without: Collection[str] = ()) -> bool:
        """Whether a member turns with a node; those of the names `without` do not count."""
        return any(
            self.joint(end.joint).rotational_stiffness != 0.0
            for end in self.meeting(node)
            if end.member.name not in without
        )

    @cached_property
    def _meeting(self) -> dict[str, list[MemberEnd]]:
        meeting: dict[str, list[MemberEnd]] = {node.name: [] for node in self.nodes}
        for member in self.members:
            for end in member.ends:
                meeting[end.node].append(end)
        return meeting

    def meeting(self, node: str) -> list[MemberEnd]:
        """Ends of the members that meet at the node of this name, in the order of the members."""
        return self._meeting[node]

    @of_geometry
    def number(self) -> dict[str, int]:
        """Numbers of the nodes by their names."""
        return {node.name: i for i, node in enumerate(self.nodes)}

    @of_geometry
    def spatial(self) -> bool:
        """Whether it lies in no plane z = 0, or has members that are turned out of it."""
        return any(node.z for node in self.nodes) or any(member.roll for member in self.members)

    @of_geometry
    def places(self) -> Array:
        """Coordinates of the nodes (nodes, 3), in m."""
        return np.array([(node.x, node.y, node.z) for node in self.nodes], dtype=float)

    @of_geometry
    def points(self) -> Array:
        """Coordinates of the nodes (nodes, 2), or (nodes, 3) of a frame in space, in m."""
        return self.places if self.spatial else self.places[:, :2]

    @of_geometry
    def upright(self) -> Flags:
        """Whether each member stands upright (members,)."""
        run, rise, aside = np.diff(self.places[self.ends], axis=1)[:, 0].T
        return np.asarray(np.hypot(run, aside) < UPRIGHT * np.abs(rise))

    @of_geometry
    def directions(self) -> Array:
        """Axes of each member before its section is rolled (members, 3, 3), unit vectors as rows.

        From start to end, upright (of an upright member along x), and across both.
        """
        start, end = self.places[self.ends.T]
        along = (end - start) / self.lengths[:, None]
        side = np.where(self.upright[:, None], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
        side -= np.sum(side * along, axis=1)[:, None] * along
        side /= np.linalg.norm(side, axis=1)[:, None]
        return np.stack([along, side, np.cross(along, side)], axis=1)

    @of_geometry
    def heights(self) -> Array:
        """Unit vectors along the height of the section of each member (members, 3)."""
        weak = [0.5 * pi if member.axis == "weak" else 0.0 for member in self.members]
        roll = (np.array([member.roll for member in self.members]) + weak)[:, None]
        _, side, across = np.moveaxis(self.directions, 1, 0)
        return np.asarray(np.cos(roll) * side + np.sin(roll) * across)

    @of_geometry
    def ends(self) -> Indices:
        """Numbers of the nodes at start and end of each member (members, 2)."""
        return np.array([(self.number[m.start], self.number[m.end]) for m in self.members])

    @of_geometry
    def chords(self) -> Array:
        """Vectors from the start of each member to its end, as `points`, in m."""
        start, end = self.points[self.ends.T]
        return np.asarray(end - start)

    @of_geometry
    def lengths(self) -> Array:
        """Lengths of the members (members,), in m."""
        return np.array([self.length(member) for member in self.members])

    def joints_of(self, member: Member) -> tuple[Joint, Joint]:
        """Return the joints at the start and at the end of a member."""
        return self.joint(member.joint_start), self.joint(member.joint_end)

    @cached_property
    def _properties(self) -> dict[str, MemberProperties]:
        return {
            member.name: member_properties(member, self.steel, self.length(member), self.fillets)
            for member in self.members
        }

    def node(self, name: str, path: str = "node") -> Node:
        """Return the node of this name. Raises `InputError` naming `path`."""
        return cast(Node, _find("node", self._named["node"], name, path))

    def member(self, name: str, path: str = "member") -> Member:
        """Return the member of this name. Raises `InputError` naming `path`."""
        return cast(Member, _find("member", self._named["member"], name, path))

    def joint(self, name: str, path: str = "joint") -> Joint:
        """Return the joint of this name. Raises `InputError` naming `path`."""
        return cast(Joint, _find("joint", self._named["joint"], name, path))

    @of_geometry
    def extent(self) -> float:
        """Diagonal of the box around the nodes, in m."""
        return hypot(*np.ptp(self.points, axis=0))

    @of_geometry
    def load_masses(self) -> dict[str, float]:
        """Masses (kg) that weigh what the dead loads on the nodes of these names do."""
        weights: Counter[str] = Counter()
        for load in self.loads:
            weights[load.node] += -load.y  # type: ignore[assignment]
        for member in self.members:
            for end in member.ends:
                weights[end.node] -= 0.5 * member.load_y * self.length(member)  # type: ignore[assignment]
        return {name: weight / GRAVITY for name, weight in weights.items() if weight > 0.0}

    @of_geometry
    def line_loads(self) -> Array:
        """Dead line loads on the members, along x and y in N/m (members, 2)."""
        return np.array([(member.load_x, member.load_y) for member in self.members])

    def length(self, member: Member | str) -> float:
        """Length of a member, in m."""
        ends = self._member(member)
        return _distance(self.node(ends.start), self.node(ends.end))

    def properties(self, member: Member | str) -> MemberProperties:
        """Section values of a member with its overrides applied."""
        return self._properties[self._member(member).name]

    def about_both(self, member: Member | str) -> tuple[MemberProperties, MemberProperties]:
        """Section values about the strong and the weak axis, `properties` about the member's."""
        whole = self._member(member)
        turned = whole.section.about("strong" if whole.axis == "weak" else "weak")
        other = whole.unchecked(section=turned, second_moment=None, plastic_moment=None)
        length = self.length(whole)
        pair = (
            self.properties(whole),
            member_properties(other, self.steel, length, self.fillets),
        )
        return pair if whole.axis == "strong" else pair[::-1]

    def each(self, name: str) -> Array:
        """Section value of that name of every member (members,), overrides applied."""
        return np.array([getattr(values, name) for values in self._properties.values()])

    def strength_section(self, member: Member | str) -> Section:
        """Return the section whose fibers and envelope give a member's strength."""
        return strength_section(self._member(member).section, self.fillets)

    def _member(self, member: Member | str) -> Member:
        name = member.name if isinstance(member, Member) else member
        return self._named["member"].get(name) or self.member(name)

    def split(self, member: Member | str, at: float, node: str) -> Frame:
        """Return the frame with a new `node` on a member, `at` m from its start.

        The parts are named ``<member>/1`` and ``<member>/2``; joints stay at the outer ends.
        Raises `InputError`.
        """
        name = member.name if isinstance(member, Member) else member
        return self.split_all([(name, at, node)])

    def split_all(self, splits: Iterable[tuple[str, float, str]]) -> Frame:
        """Return the frame after many splits, each as in `split`; it is checked once."""
        nodes, members = dict(self._named["node"]), dict(self._named["member"])
        for name, at, node in splits:
            whole = _find("member", members, name, "split.member")
            start, end = nodes[whole.start], nodes[whole.end]
            length = _distance(start, end)
            distance = float(LENGTH.check("split.at", at))
            if not distance <= length - LENGTH.low:
                reach = f"from {LENGTH.low:g} to {length - LENGTH.low:.6g} m from its start"
                text = f"must lie on member {name}, {reach}"
                raise InputError("split.at", at, text, "measure from the start of the member")
            if node in nodes:
                text = "is the name of a node already"
                raise InputError("split.node", node, text, "choose another")
            share = distance / length
            x, y, z = (
                getattr(start, c) + share * (getattr(end, c) - getattr(start, c)) for c in "xyz"
            )
            nodes[node] = Node(node, x, y, z=z)
            parts = (
                replace(whole, name=f"{name}/1", end=node, joint_end=RIGID.name),
                replace(whole, name=f"{name}/2", start=node, joint_start=RIGID.name),
            )
            rows = [parts if each is whole else (each,) for each in members.values()]
            members = {part.name: part for row in rows for part in row}
        return replace(self, nodes=tuple(nodes.values()), members=tuple(members.values()))


def _distance(start: Node, end: Node) -> float:
    """Distance of two nodes, in m."""
    return hypot(end.x - start.x, end.y - start.y, end.z - start.z)


def _find(kind: str, parts: Mapping[str, Any], name: str, path: str) -> Any:
    """Return the part of this name. Raises `InputError` naming `path`, with the nearest names."""
    if isinstance(name, str) and name in parts:
        return parts[name]
    shown = ", ".join(list(parts)[:8]) + (", ..." if len(parts) > 8 else "")
    advice = did_you_mean(name, parts, f"known are {shown}")
    raise InputError(path, name, f"there is no {kind} of this name", advice)


def _check_unique(parts: Sequence[Any], keys: Sequence[Hashable], text: str, advice: str) -> None:
    """Refuse parts with equal keys (`InputError`); `text` names the earlier one as ``{}``."""
    first: dict[Hashable, Any] = {}
    for part, key in zip(parts, keys, strict=True):
        if first.setdefault(key, part) is not part:
            raise part.refusal("", text.format(first[key].name), advice)


def _check_connected(frame: Frame) -> None:
    """Refuse nodes that no chain of members joins to the first one (`InputError`)."""
    nodes = frame.nodes
    for node in nodes:
        if not frame.meeting(node.name):
            raise node.refusal("", "no member ends there", "drop the node")
    reached, ahead = {nodes[0].name}, [nodes[0].name]
    while ahead:
        new = {end.other.node for end in frame.meeting(ahead.pop())} - reached
        reached |= new
        ahead += new
    apart = next((node.name for node in nodes if node.name not in reached), None)
    if apart is not None:
        chain = f"no chain of members joins node {apart} to node {nodes[0].name}"
        advice = "add a member or make it a scenario of its own"
        raise InputError("frame.members", None, f"the frame falls apart: {chain}", advice)


def _check_supported(frame: Frame) -> None:
    """Refuse a frame that can move as a rigid body (`InputError`).

    Springs and locks act only once the dead loads are on, which the supports carry before.
    """
    centre, size = frame.places.mean(axis=0), frame.extent
    rows, loaded = [], frame.loads or any(frame.gravity) or frame.line_loads.any()
    places = (frame.places - centre) / size
    for node, (x, y, z) in zip(frame.nodes, places, strict=True):
        held = set(node.held) if loaded else node.resisted
        turns = {"rotation", "turn_x", "turn_y"}
        held |= set(node.held_beside) if frame.spatial else set()
        held -= set() if node.name in frame.turned else turns
        # what a motion of the whole does to each displacement of the node
        motion = {
            "u": (1.0, 0.0, 0.0, 0.0, z, -y),
            "v": (0.0, 1.0, 0.0, -z, 0.0, x),
            "w": (0.0, 0.0, 1.0, y, -x, 0.0),
            "turn_x": (0.0, 0.0, 0.0, 1.0, 0.0, 0.0),
            "turn_y": (0.0, 0.0, 0.0, 0.0, 1.0, 0.0),
            "rotation": (0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
        }
        rows += [row for component, row in motion.items() if component in held]
    # motion of the whole: displacement of the centre along x, y, z, rotations times extent
    kept = slice(None) if frame.spatial else [0, 1, 5]
    _, values, motions = np.linalg.svd(np.array([*rows, *np.zeros((6, 6))])[:, kept])
    free = motions[values < FREE]
    if len(free):
        can = "move as a whole"
        if not frame.spatial:
            can = _motion_text(free[0] / np.array([1.0, 1.0, size]), centre, size)
        how = "nothing holds it" if len(free) == len(values) else f"it can {can}"
        when = " under its dead loads, before springs and locks act" if loaded else ""
        text = f"the frame is not supported{when}: {how}"
        raise InputError("node.support", None, text, "add supports")


def _motion_text(motion: Array, centre: Array, size: float) -> str:
    along_x, along_y, turn = (float(value) for value in motion)
    if abs(turn) * size > FREE:
        x, y = centre[:2] + np.array([-along_y, along_x]) / turn
        return f"turn about x = {round(x, 3) + 0.0:g} m, y = {round(y, 3) + 0.0:g} m"
    if abs(along_y) < FREE:
        return "slide along x"
    return "slide along y" if abs(along_x) < FREE else "slide"


SPANS = Many(LENGTH, 1, 100)


@dataclass(frozen=True)
class RegularForm(Declared, table="frame"):
    """A frame of columns on axes A, B, ... and of beams on every level; see `regular_frame`."""

    bays: tuple[float, ...] = checked(SPANS)
    storeys: tuple[float, ...] = checked(SPANS)
    column: Section = checked(SECTION)
    beam: Section = checked(SECTION)
    base: str = checked(Choice(("clamped", "pinned")), "clamped")
    beam_joint: str = checked(NAME, RIGID.name)
    column_axis: str = checked(Choice(AXES), "strong", help="about which columns bend")
    depths: tuple[float, ...] = checked(
        Many(LENGTH, 0, 25), (), omitted=True, help="bays along z, of a frame in space"
    )

    def frame(self, steel: Steel, fillets: bool, joints: Sequence[Joint]) -> Frame:
        """Return the frame, its beams joined by one of `joints`. Raises `InputError`."""
        words = (product(ascii_uppercase, repeat=length) for length in count(1))
        letters = ("".join(word) for word in chain.from_iterable(words))
        axes = list(islice(letters, len(self.bays) + 1))  # A to Z, then AA, AB and so on
        rows = list(ascii_lowercase[: len(self.depths) + 1]) if self.depths else [""]
        levels = range(len(self.storeys) + 1)
        nodes = []
        for level, j, i in product(levels, range(len(rows)), range(len(axes))):
            x, y, z = sum(self.bays[:i]), sum(self.storeys[:level]), sum(self.depths[:j])
            support = "free" if level else self.base
            nodes.append(Node(f"{axes[i]}{rows[j]}{level}", x, y, support, z=z))
        lines = [f"{axis}{row}" for axis, row in product(axes, rows)]
        columns = [(f"{line}{i}", f"{line}{i + 1}") for line in lines for i in levels[:-1]]
        floor = [(f"{a}{row}", f"{b}{row}") for row in rows for a, b in pairwise(axes)]
        floor += [(f"{axis}{a}", f"{axis}{b}") for axis in axes for a, b in pairwise(rows)]
        beams = [(f"{a}{i}", f"{b}{i}") for i in levels[1:] for a, b in floor]
        joint = self.beam_joint
        axis = self.column_axis
        members = [Member(f"{a}-{b}", a, b, self.column, axis=axis) for a, b in columns]
        members += [Member(f"{a}-{b}", a, b, self.beam, joint, joint) for a, b in beams]
        return Frame(tuple(nodes), tuple(members), (), tuple(joints), steel, fillets)


@dataclass(frozen=True)
class Split(Declared, table="split"):
    """A new `node` on a `member`, `at` m from its start."""

    member: str = checked(NAME)
    at: float = checked(LENGTH)
    node: str = checked(NAME)


@dataclass(frozen=True)
class FrameForm(Declared):
    """A frame as files show it; written with nodes and members, read in both forms."""

    fillets: bool = checked(Flag(), True, path="frame.fillets")
    steel: Steel = checked(Instance(Steel), Steel())
    regular: RegularForm | None = checked(
        Instance(RegularForm, instead_of=("node", "member")), optional=True
    )
    nodes: tuple[Node, ...] = checked(Many(Instance(Node)), (), path="node")
    joints: tuple[Joint, ...] = checked(Many(Instance(Joint)), (), path="joint")
    members: tuple[Member, ...] = checked(Many(Instance(Member)), (), path="member")
    splits: tuple[Split, ...] = checked(Many(Instance(Split)), (), path="split")
    loads: tuple[Load, ...] = checked(Many(Instance(Load)), (), path="load")

    @classmethod
    def of(cls, frame: Frame) -> FrameForm:
        """Return the form of a frame that lists its parts."""
        parts = frame.nodes, frame.joints, frame.members
        return cls(frame.fillets, frame.steel, None, *parts, loads=frame.loads)

    def build(self) -> Frame:
        """Return the frame. Raises `InputError`."""
        if self.regular is not None:
            for joint in self.joints:
                if joint.name != self.regular.beam_joint:
                    path, text = f"joint.{joint.name}", "is no joint of this regular frame"
                    advice = "name it as frame.beam_joint, or list nodes and members"
                    raise InputError(path, None, text, advice)
            frame = self.regular.frame(self.steel, self.fillets, self.joints)
        else:
            for name, parts in (("node", self.nodes), ("member", self.members)):
                if not parts:
                    advice = f"add [[{name}]], or bays and storeys in [frame]"
                    raise InputError(name, None, f"the tables [[{name}]] are missing", advice)
            frame = Frame(self.nodes, self.members, (), self.joints, self.steel, self.fillets)
        if self.splits:
            frame = frame.split_all((split.member, split.at, split.node) for split in self.splits)
        return replace(frame, loads=self.loads) if self.loads else frame


def regular_frame(
    bays: Sequence[float],
    storeys: Sequence[float],
    column: Section,
    beam: Section,
    base: str = "clamped",
    steel: Steel | None = None,
    fillets: bool = True,
    beam_joint: str | Joint = RIGID.name,
    column_axis: str = "strong",
    depths: Sequence[float] = (),
) -> Frame:
    """Return a frame of columns on axes A, B, ... and of beams on every level above the ground.

    Nodes are named A0, B0, ..., A1, ... (axis and level), columns A0-A1 (from the bottom to the
    top), beams A1-B1 (from the left to the right). With `depths` in rows a, b, ...: Aa0, columns
    Aa0-Aa1, beams Aa1-Ba1 along x and Aa1-Ab1 along z.

    Parameters
    ----------
    bays, storeys : sequence of float
        Widths from the left and heights from the ground, in m.
    column, beam : Section or str
        Sections, or their names in the catalogue.
    base : str
        Supports of the columns, ``"clamped"`` or ``"pinned"``.
    steel : Steel, optional
        Steel of all members; S355 by default.
    fillets : bool
        Whether root fillets count in the strength.
    beam_joint : Joint or str
        Joint at both ends of every beam, or its name, rigid or pinned.
    column_axis : str
        Axis about which the columns bend in the plane x-y, ``"strong"`` or ``"weak"``.
    depths : sequence of float
        Widths of bays along z, in m, of a frame in space.

    Returns
    -------
    Frame
        Without loads.

    Raises
    ------
    InputError
        For values outside their ranges and an unknown joint.

    Examples
    --------
    >>> frame = wb.regular_frame([6.0], [3.5, 3.0], "HEB 220", "IPE 300")
    >>> [member.name for member in frame.members][:3]
    ['A0-A1', 'A1-A2', 'B0-B1']
    """
    joints = (beam_joint,) if isinstance(beam_joint, Joint) else ()
    joint = joints[0].name if joints else str(beam_joint)
    spans = tuple(bays), tuple(storeys)
    form = RegularForm(*spans, column, beam, base, joint, column_axis, tuple(depths))
    return form.frame(Steel() if steel is None else steel, fillets, joints)
