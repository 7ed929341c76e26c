"""A scenario's frame as an assembly: supports, masses, springs, dead loads and locks.

Models differ in the elements of the members only. They hand these over with a reader of the
members' states; everything else happens here.

**Second part.** A scenario's frame as superelements: hinges and bars of every member, and what is
read off.

The element itself stands in `structures/superelements`, the two models in `models/superelements`.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import pairwise
from math import ceil, inf
from typing import Any, NamedTuple, Self, TypeVar

import numpy as np

from workbench.base.arrays import Array, Indices
from workbench.mechanics.structures.assembly import COMPONENTS, PlanarAssembly
from workbench.mechanics.structures.elements import ElementGroup, HingedElements
from workbench.mechanics.structures.impact import rigid_displacement
from workbench.mechanics.structures.paths import apply_loads
from workbench.mechanics.structures.superelements import HingeEnd, Superelements
from workbench.responses import Response, finding, findings_of, set_findings
from workbench.scenarios import Frame, FrameImpact, FramePulse, FrameScenario, Joint, Load, Member
from workbench.scenarios.parts import COMPONENT, RIGID, MemberProperties
from workbench.steel.hinges import YieldSurface
from workbench.steel.sections import Section

Whole = TypeVar("Whole")
POINTS = np.linspace(0.0, 1.0, 9)  # along a member, where its deformed shape is drawn


class MemberReader(ABC):
    """Reads the committed state of all members off their elements, in SI units.

    Two hinges per member, start and end. Axial forces are positive in tension, moments where they
    stretch the fibers on the right of somebody who looks from start to end.
    Arguments: the `elements`, one member after the other; `first` (members + 1,), where those of
    each member start.
    """

    def __init__(self, elements: ElementGroup, first: Indices) -> None:
        self.elements, self.first = elements, first
        self._ends: Indices = np.stack([first[:-1], first[1:] - 1], axis=1).ravel()
        self._signs: Array = np.resize([-1.0, 1.0], len(self._ends))
        self._side: Indices = np.resize([0, 1], len(self._ends))

    def axial_forces(self) -> Array:
        """Axial forces (hinges,)."""
        return np.asarray(self.elements.local_forces[..., self._ends, 0])

    def moments(self) -> Array:
        """Bending moments (hinges,)."""
        return self._signs * self.elements.local_forces[..., self._ends, 1 + self._side]

    def of_member(self, number: int) -> slice:
        """Elements of a member."""
        return slice(int(self.first[number]), int(self.first[number + 1]))

    def reading(self, elements: ElementGroup) -> Self:
        """Reader of a copy of the elements."""
        other = copy(self)
        other.elements = elements
        return other

    @abstractmethod
    def plastic_rotations(self) -> Array:
        """Plastic rotations (hinges,), those of the joints included."""

    def plastic_shear(self) -> Array | None:
        """Plastic shear displacement of each member (members,) in m; None where no web yields."""
        return None

    @abstractmethod
    def utilisation(self) -> Array:
        """Utilisation of the sections (hinges,) under N and M: 1 on the yield surface."""

    @abstractmethod
    def shear_forces(self) -> Array:
        """Largest shear force of each member (members,), without sign."""

    def unyielding_shear(self) -> Array:
        """Shear force of each member (members,), mean along it; zero where shear yields.

        Its end moments over its length: waves that run along it leave the mean.
        """
        return self.shear_forces()

    def shear_strains(self) -> Array | None:
        """Mean shear strain of each member (members,), without sign; None unless shear yields."""
        return None

    def contractions(self) -> Array:
        """Loss of length along the axis of each member (members,)."""
        return -np.add.reduceat(self.elements.elongations, self.first[:-1], axis=-1)

    def lengths_left(self) -> Array:
        """Least length of an element of each member over its initial one (members,).

        Where no element must vanish the length is 1.
        """
        elements = self.elements
        if not elements.crumples:
            return np.ones(len(self.first) - 1)
        left = 1.0 + elements.elongations / elements.lengths
        return np.asarray(np.minimum.reduceat(left, self.first[:-1], axis=-1))

    @abstractmethod
    def shapes(self, assembly: PlanarAssembly) -> Array:
        """Displaced positions (members, points, axes) in m at the `POINTS` of each member."""


@dataclass(frozen=True)
class FrameStructure:
    """A frame under its dead loads, ready to be hit, pushed or shaken.

    `assembly`, whose first nodes are those of the `frame`; `members` read their states;
    `start`, the displacements (dofs,) from which those of the response count; `watched`, further
    histories of the response by name: dof and sign of a displacement since the unloaded state;
    names of its `hinges`, where they are not those of the members' ends; results
    `kept` of it, shared by its copies.
    """

    frame: Frame
    assembly: PlanarAssembly
    members: MemberReader
    start: Array
    watched: Mapping[str, tuple[int, float]] = field(default_factory=dict)
    hinges: Sequence[str] = ()
    kept: dict[str, Any] = field(default_factory=dict, compare=False, repr=False)

    @property
    def is_column(self) -> bool:
        """Whether it stands for a column, whose head cannot drift."""
        return bool(self.hinges)

    @property
    def sense(self) -> float:
        """Sign of the reported moments: those of a column are positive at the base.

        The strike on it flies along +x and it goes up, which is the other way round in a frame.
        """
        return -1.0 if self.is_column else 1.0

    def fresh(self) -> Self:
        """Copy of the structure in a state of its own, which a run may change."""
        assembly = self.assembly.copy()
        members = self.members.reading(assembly.groups[0])
        return replace(self, assembly=assembly, members=members)

    def seen(self) -> Self:
        """Copy of the structure, of which other states can be shown."""
        assembly = _again(self.assembly)
        assembly.groups = tuple(map(_again, assembly.groups))
        structure, members = _again(self), _again(self.members)
        members.elements = assembly.groups[0]
        vars(structure).update(assembly=assembly, members=members)
        return structure

    def dof(self, node: str, direction: str) -> tuple[int, float]:
        """Dof and sign of a node's motion along `direction` (x, y or rotation, with a sign)."""
        sign = -1.0 if direction.startswith("-") else 1.0
        component = COMPONENT[direction.lstrip("+-")]
        return self.assembly.dof(self.frame.number[node], component), sign

    def pattern(self, loads: Sequence[Load]) -> Array:
        """Nodal forces (dofs,) of `loads`."""
        return nodal_forces(self.frame, self.assembly, loads)

    def line_load(self, members: Sequence[str], direction: str) -> Array:
        """Nodal forces (dofs,) of 1 N/m on `members` along x or y, with a sign.

        Half of what stands on an element acts at each of its ends, which does the work of the line
        load in any mechanism of the elements.
        """
        sign, sizes = (
            -1.0 if direction.startswith("-") else 1.0,
            np.zeros((len(self.frame.members), 2)),
        )
        rows = [member_names(self.frame).index(name) for name in members]
        sizes[rows, "xy".index(direction.lstrip("+-"))] = sign
        return line_forces(self.assembly, self.members, sizes)


def line_forces(assembly: PlanarAssembly, members: MemberReader, loads: Array) -> Array:
    """Nodal forces (dofs,) of line `loads` on members, along x and y in N/m (members, 2)."""
    forces, elements = np.zeros(assembly.size), members.elements
    for number in np.flatnonzero(loads.any(axis=1)):
        part = members.of_member(int(number))
        for load, component in zip(loads[number], "uv", strict=True):
            for end in elements.nodes[part].T:
                np.add.at(
                    forces, assembly.dofs(end, component), 0.5 * load * elements.lengths[part]
                )
    return forces


def hinge_names(frame: Frame) -> tuple[str, ...]:
    """Names of the two hinges of every member, in the order of the members."""
    return tuple(f"{member.name}:{end}" for member in frame.members for end in ("start", "end"))


def member_names(frame: Frame) -> tuple[str, ...]:
    """Names of the members in their order."""
    return tuple(member.name for member in frame.members)


@lru_cache(maxsize=64)
def upright_names(frame: Frame) -> tuple[str, ...]:
    """Names of the members that stand upright, in their order."""
    return tuple(frame.members[i].name for i in np.flatnonzero(frame.upright))


def in_space(vectors: Array) -> Array:
    """Vectors (n, 2) or (n, 3) with their part along z (n, 3)."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))


def _again(whole: Whole) -> Whole:
    """A shallow copy, as of `copy.copy`, which takes five times as long."""
    other = object.__new__(type(whole))
    vars(other).update(vars(whole))
    return other


def nodal_loads(frame: Frame, loads: Sequence[Load]) -> Array:
    """Forces along x and y and moments of `loads` at the nodes of a frame (nodes, 3)."""
    total = np.zeros((len(frame.nodes), 3))
    for load in loads:
        total[frame.number[load.node]] += load.x, load.y, load.moment
    return total


def nodal_forces(frame: Frame, assembly: PlanarAssembly, loads: Sequence[Load]) -> Array:
    """Forces and moments (dofs,) of `loads` at the nodes of the frame."""
    forces = np.zeros(assembly.size)
    for component, values in zip(COMPONENTS, nodal_loads(frame, loads).T, strict=True):
        forces[assembly.dofs(range(len(frame.nodes)), component)] = values
    return forces


def _counted(frame: Frame) -> list[Load]:
    """Loads that take off the weight of nodal masses as far as dead loads bring it already."""
    (x, y), stood = frame.gravity, frame.load_masses
    masses = {node.name: -min(node.mass, stood.get(node.name, 0.0)) for node in frame.nodes}
    return [Load(name, x=x * mass, y=y * mass) for name, mass in masses.items() if mass]


@lru_cache(maxsize=64)
def dead_loads(frame: Frame) -> tuple[Load, ...]:
    """Dead loads of a frame at its nodes, half of line loads and, under gravity, of own weight."""
    if not any(frame.gravity) and not frame.line_loads.any():
        return frame.loads
    lines = frame.line_loads + np.outer(frame.each("mass_per_length"), frame.gravity)
    forces = np.outer([node.mass for node in frame.nodes], frame.gravity)
    np.add.at(forces, frame.ends, (0.5 * frame.lengths[:, None] * lines)[:, None])
    pairs = zip(frame.nodes, forces.tolist(), strict=True)
    return (*frame.loads, *_counted(frame), *(Load(node.name, x=x, y=y) for node, (x, y) in pairs))


def own_weight(frame: Frame, assembly: PlanarAssembly) -> Array:
    """Forces (dofs,) of all masses under the gravity of the frame, but for which loads stand."""
    x, y = frame.gravity
    pull = x * rigid_displacement(assembly, "x") + y * rigid_displacement(assembly, "y")
    return assembly.mass_times(pull) + nodal_forces(frame, assembly, _counted(frame))


def apply_dead_loads(
    frame: Frame,
    assembly: PlanarAssembly,
    members: MemberReader,
    *,
    rotary_inertia: Array | None = None,
) -> FrameStructure:
    """Support a frame, bring its dead loads on, then its springs and locks.

    Arguments: `assembly` with the frame's nodes first and in their order, in the plane or in space;
    the reader of its `members`; `rotary_inertia` (nodes,) in kg m2, beside what frame and members
    give. Springs are unstressed, and locked nodes stand still, once the dead loads are on. Raises
    `SolverError` when those find no equilibrium.
    """
    equip(frame, assembly, members, rotary_inertia)
    if np.any(assembly.load):
        apply_loads(assembly)
    for number, node in enumerate(frame.nodes):
        for direction, component in COMPONENT.items():
            stiffness = getattr(node, f"spring_{direction}")
            if stiffness > 0.0:
                assembly.add_spring(assembly.dof(number, component), stiffness)
        if node.locked != "none":
            assembly.hold([assembly.dof(number, COMPONENT[node.locked])])
    assembly.assemble(assembly.displacement, None)
    assembly.stored = assembly.account(assembly.displacement, 0.5).stored
    return FrameStructure(frame, assembly, members, assembly.displacement.copy())


def equip(
    frame: Frame,
    assembly: PlanarAssembly,
    members: MemberReader,
    rotary_inertia: Array | None = None,
) -> None:
    """Give an assembly supports, masses and the dead loads of a frame, which do not act yet.

    Arguments as of `apply_dead_loads`.
    """
    held = [(number, part) for number, node in enumerate(frame.nodes) for part in node.held]
    held += [(number, "rotation") for number in free_to_spin(frame)]
    assembly.hold([assembly.dof(*each) for each in held])
    for number, node in enumerate(frame.nodes):
        if node.mass or node.rotary_inertia:
            assembly.add_mass(number, node.mass, node.rotary_inertia)
    if rotary_inertia is not None:
        assembly.add_rotary_inertia(rotary_inertia)
    assembly.load = nodal_forces(frame, assembly, frame.loads)
    if any(frame.gravity):
        assembly.load += own_weight(frame, assembly)
    if frame.line_loads.any():
        assembly.load += line_forces(assembly, members, frame.line_loads)


def free_to_spin(frame: Frame) -> list[int]:
    """Numbers of nodes whose rotation nothing resists: every member there ends in a pin."""
    nodes = enumerate(frame.nodes)
    return [i for i, n in nodes if n.name not in frame.turned and n.spring_rotation == 0.0]


HingeSurfaces = tuple[YieldSurface, YieldSurface]
FEWEST_LOADED = 4  # elements of a member under a line load: 1 % of an elastic deflection
_LONGEST = 5.0  # section heights, of an element of a struck member where none are asked for
_NEIGHBOURS = 4  # elements of members that meet struck ones; one gives light hits 20 % too much
_SHARED = 0.05  # of the energy, lost in a first collision with two elements
MOST_PARTS = 16
_STRAIGHT = 1e-6  # N/m across a member that do not bend it
_SOFT = 3.0  # % of axial flexibility that hinges add


@dataclass(frozen=True)
class Piece:
    """One of the equal parts into which a member of a frame is cut, as element groups read it.

    The `member`, of which it is number `index` of `parts`; its strength `section` and `properties`;
    `length` in m; elastic EA (N) and EI (N m2); `joints` at its two ends (a rigid one inside the
    member); `pins`, rotational stiffness of the joints or supports at its ends (N m/rad), zero also
    at a support that leaves the end free to turn.
    """

    frame: Frame
    member: Member
    index: int
    parts: int
    section: Section
    properties: MemberProperties
    length: float
    axial: float
    bending: float
    joints: tuple[Joint, Joint]
    pins: tuple[float, float]


def series(*stiffnesses: float | None) -> float:
    """Stiffness of springs in series; None is rigid."""
    known = [k for k in stiffnesses if k is not None]
    if 0.0 in known:
        return 0.0
    softness = sum(1.0 / k for k in known)
    return 1.0 / softness if softness > 0.0 else inf


def hinge_ends(
    piece: Piece, surfaces: HingeSurfaces, axial: float, bending: tuple[float, float]
) -> tuple[HingeEnd, HingeEnd]:
    """Both hinges of a piece: `axial` stiffness (N/m) of each beside its joint, `bending` in all.

    A free end that is no pin gets some stiffness, so that its node turns with the bar; it carries
    no moment anyway.
    """
    ends = []
    some = max(bending) or 6.0 * piece.bending / piece.length
    for surface, joint, stiffness in zip(surfaces, piece.joints, bending, strict=True):
        pinned = joint.rotational_stiffness == 0.0
        turned = stiffness if pinned or stiffness > 0.0 else some
        ends.append(HingeEnd(surface, series(axial, joint.axial_stiffness), turned))
    return ends[0], ends[1]


def struck_parts(
    scenario: FrameScenario, multiple: int, far: int = 1, most: int = MOST_PARTS
) -> tuple[int, ...]:
    """Parts of every member where none are asked for: of struck ones a `multiple`, at `most`.

    Arguments: `far`, of members of a struck frame that are neither struck nor meet struck ones.

    A node shares its velocity with a third of each bar beside it at once, of which the beam knows
    nothing: in an inelastic hit that takes its share of the energy. Bars are at most `_LONGEST`,
    and so short that two of them take some `_SHARED`, unless they were shorter than high. Beside
    the force of a pulse there is no striker whose mass governs: the member swings in its own
    modes, and bars are half as long. Joints at
    the far ends of struck members turn against the inertia of what meets them there, which one bar
    has at its ends alone: such members are `_NEIGHBOURS` bars. So do members beyond, by less: their
    beam's own swinging needs a node between their ends. Members under line loads or their own
    weight, which act at the ends of elements, are at least `FEWEST_LOADED`.
    """
    frame, counts = scenario.frame, (1,) * len(scenario.frame.members)
    if isinstance(scenario, FrameImpact):
        counts = _parts(frame, (scenario.striker.node,), scenario.striker.mass, multiple, far, most)
    elif isinstance(scenario, FramePulse):
        counts = _parts(
            frame, tuple(load.node for load in scenario.loads), inf, multiple, far, MOST_PARTS
        )
    several = multiple * ceil(FEWEST_LOADED / multiple)
    pressed = getattr(scenario, "members", ())
    lines = frame.line_loads + np.outer(frame.each("mass_per_length"), frame.gravity)
    across = np.linalg.norm(np.cross(in_space(frame.chords), in_space(lines)), axis=1)
    bent = across > _STRAIGHT * frame.lengths  # by their dead loads
    loaded = bent | np.array([member.name in pressed for member in frame.members])
    return tuple(np.maximum(counts, np.where(loaded, several, 1)).tolist())


@lru_cache(maxsize=64)
def _parts(
    frame: Frame, nodes: tuple[str, ...], mass: float, multiple: int, far: int, most: int
) -> tuple[int, ...]:
    """Parts of each member of a frame whose nodes a `mass` (kg), or a pulse (infinite), hits."""
    counts = [far] * len(frame.members)
    at = np.isin(frame.ends, [frame.number[name] for name in nodes])
    struck = at.any(axis=1)
    beside = np.isin(frame.ends, frame.ends[struck][~at[struck]]).any(axis=1)
    for number in np.flatnonzero(beside):
        counts[number] = multiple * ceil(_NEIGHBOURS / multiple)
    heights = _LONGEST if mass < inf else 0.5 * _LONGEST
    for number in np.flatnonzero(struck):
        member = frame.members[number]
        height, per_length = member.section.height, frame.properties(member).mass_per_length
        longest = min(heights * height, 1.5 * _SHARED * mass / per_length)
        pairs = frame.length(member) / max(longest, height) / multiple
        counts[number] = multiple * min(ceil(pairs - 1e-9), most // multiple)
    return tuple(counts)


def curvature_shares(parts: int) -> Array:
    """Shares (parts, 2) of the length that each end of each of equal parts stands for.

    Weights of Simpson's rule (of its 3/8 form for the first three of an odd number), split where
    parts meet: the work of a moment that is straight along the member is exact.
    """
    shares = np.tile([[1.0, 2.0], [2.0, 1.0]], (parts // 2 + 1, 1))[:parts] / 3.0
    if parts % 2:
        shares = np.roll(shares, 1, axis=0)
        shares[:3] = np.array([[3.0, 4.5], [4.5, 4.5], [4.5, 3.0]]) / 8.0
    return shares / parts


class Cut(NamedTuple):
    """Members of a `frame` in equal parts.

    `coordinates` (nodes, 2) in m, those of the frame's nodes first; of every part, in the order of
    the members, the numbers of its `nodes`, and the `pieces` themselves.
    """

    frame: Frame
    coordinates: Array
    nodes: list[tuple[int, int]]
    pieces: list[Piece]


def cut_members(frame: Frame, parts: Sequence[int]) -> Cut:
    """Every member of a frame in so many equal `parts`."""
    points = frame.points.tolist()
    nodes: list[tuple[int, int]] = []
    pieces: list[Piece] = []
    for member, count, (first, last), chord in zip(
        frame.members, parts, frame.ends.tolist(), frame.chords, strict=True
    ):
        nodes.extend(pairwise([first, *range(len(points), len(points) + count - 1), last]))
        points.extend((frame.points[first] + chord * k / count).tolist() for k in range(1, count))
        pieces.extend(_pieces(frame, member, count))
    return Cut(frame, np.array(points), nodes, pieces)


def joint_inertias(cut: Cut) -> Array:
    """Rotary inertia (nodes,) in kg m2 of the joints at the ends of pieces, by their nodes.

    That of half a section depth of the heaviest bar there: its sections turn with the joint.
    """
    inertia = np.zeros(len(cut.coordinates))
    for ends, piece in zip(cut.nodes, cut.pieces, strict=True):
        half = 0.5 * piece.properties.rotary_inertia * piece.member.section.height
        np.maximum.at(inertia, list(ends), half)
    return inertia


def _pieces(frame: Frame, member: Member, parts: int) -> Iterator[Piece]:
    """The pieces of one member, from its start to its end."""
    whole, modulus, ends = frame.properties(member), frame.steel.elastic_modulus, []
    for end, joint in zip(member.ends, frame.joints_of(member), strict=True):
        held = "rotation" in frame.node(end.node).resisted
        turned = held or frame.turns(end.node, (member.name,))
        ends.append((joint, series(joint.rotational_stiffness) if turned else 0.0))
    elastic = modulus * whole.area, modulus * whole.second_moment
    alike = frame.strength_section(member), whole, frame.length(member) / parts, *elastic
    for k in range(parts):
        first = ends[0] if k == 0 else (RIGID, inf)
        last = ends[1] if k == parts - 1 else (RIGID, inf)
        yield Piece(frame, member, k, parts, *alike, (first[0], last[0]), (first[1], last[1]))


def joint_surface(member: YieldSurface, joint: Joint) -> YieldSurface:
    """The weaker of member and joint at each bound; linear where the joint is the weaker one.

    A joint has no interaction curve of its own: EN 1993-1-8, 6.2.7.1(3) takes a straight line.
    """
    bounds = (*member.axial_bounds, *member.moment_bounds)
    tension, compression, positive, negative = weaker = joint.weaker(bounds)
    if weaker == bounds:
        return member
    return YieldSurface(
        tension, positive, squash_load_compression=compression, plastic_moment_negative=negative
    )


def softened(response: Response, stiffness: float) -> Response:
    """The response, with a warning where hinges `stiffness` times as stiff as bars soften it.

    Of one in which nothing yields: they add 1 / n to the axial and, of several elements, 1 / 3n to
    the bending flexibility, little beside what yields.
    """
    spent, brought = response["dissipated"].max(), response["external_work"].max()
    share = 100.0 / stiffness
    if share > _SOFT and float(spent) <= 1e-9 * float(brought):
        soft = finding("elastic-hinges", share, stiffness=stiffness, bending=share / 3.0)
        set_findings(response, [*findings_of(response), soft])
    return response


class SuperelementMembers(MemberReader):
    """Reads the members of a frame off their superelements.

    Arguments: the `group` of all elements, so many `parts` of every member in turn;
    `coordinates` (nodes, 2) of the nodes in m.
    """

    elements: HingedElements

    def __init__(self, group: HingedElements, coordinates: Array, parts: Sequence[int]) -> None:
        super().__init__(group, np.concatenate([[0], np.cumsum(parts)]))
        along = np.multiply.outer(parts, POINTS)  # of every member, where its shape is drawn
        piece = np.minimum(along.astype(np.int64), np.array(parts)[:, None] - 1)
        self._drawn: Indices = self.first[:-1, None] + piece
        self._along: Array = along - piece
        self._origin: Array = coordinates[group.nodes[self._drawn, 0]]

    def plastic_rotations(self) -> Array:
        """Plastic rotations (hinges,) by bending alone; of pins the whole rotation."""
        return self._signs * self.elements.plastic[..., self._ends, 1 + 2 * self._side]

    def plastic_shear(self) -> Array | None:
        """Plastic shear of each member, the sum over its parts."""
        group = self.elements
        if not isinstance(group, Superelements) or not group.yields_in_shear.any():
            return None
        return np.asarray(np.add.reduceat(group.plastic_shear, self.first[:-1], axis=-1))

    def utilisation(self) -> Array:
        """Left side of the yield condition (hinges,)."""
        return np.asarray(self.elements.utilisation()[..., self._ends, self._side])

    def shear_forces(self) -> Array:
        """Largest shear force of each member (members,), without sign."""
        shear = np.abs(self.elements.shear_forces)
        return np.asarray(np.maximum.reduceat(shear, self.first[:-1], axis=-1))

    def unyielding_shear(self) -> Array:
        """Shear force of each member (members,), mean along its equal parts; zero of panels."""
        webs, parts = self.elements.yields_in_shear, np.diff(self.first)
        if webs.all():
            return np.zeros(len(parts))
        shear = np.where(webs, 0.0, self.elements.shear_forces)
        return np.asarray(np.abs(np.add.reduceat(shear, self.first[:-1], axis=-1)) / parts)

    def shapes(self, assembly: PlanarAssembly) -> Array:
        """Displaced positions (members, points, 2)."""
        drawn = self.elements.shapes(assembly.displacement, self._drawn, self._along)
        return np.asarray(self._origin + drawn)
