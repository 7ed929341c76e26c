"""Fiber references, common parts: options, mesh, time steps, findings, runs and refinement.

A column is the frame of its two members. Each reference adds its elements and their section.

**Second part.** Members of a fiber reference: their mesh, what it cannot resolve, joints, and what
is read off.

Every member is graded from the smallest element at both of its ends, where hinges form, to the
largest one between them. A column is meshed as the frame of its two members.
"""

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, inf
from typing import ClassVar, NamedTuple

import numpy as np

from workbench.base.arrays import Array, Flags, Indices
from workbench.base.fields import Number, checked
from workbench.mechanics.frames.elastic import Spans, line_wave_times, spans_to, time_to_peak
from workbench.mechanics.frames.members import (
    LAYERS,
    chains,
    eventful,
    fiber_overrides,
    fiber_section,
    named,
)
from workbench.mechanics.frames.structure import (
    POINTS,
    FrameStructure,
    MemberReader,
    apply_dead_loads,
)
from workbench.mechanics.structures.assembly import PlanarAssembly, graded_lengths, halved
from workbench.mechanics.structures.elements import JointSprings
from workbench.mechanics.structures.fibers import BeamSection, FiberElements
from workbench.mechanics.structures.fibers.section import Law, LinearHardening
from workbench.models.base import respond
from workbench.models.frame_model import FrameModel, as_frame
from workbench.models.references.refine import (
    HALVED_STEPS,
    LEVELS,
    MESHES,
    REFINEMENT,
    check_levels,
    refined,
)
from workbench.responses import Finding, Response, finding
from workbench.scenarios import (
    ColumnImpact,
    ColumnScenario,
    Frame,
    FrameImpact,
    FrameScenario,
    FrameStatic,
    Member,
    Scenario,
)
from workbench.steel.materials import Steel

# of the longest member; travelling hinges pass through inner elements
LARGEST_SHARE_IN_DYNAMICS = 1.0 / 40.0
WARNED_IN_DYNAMICS = 0.06  # of the longest member
MIDDLE = 0.5 + 1e-9  # of a member, seen from its start
LARGEST_EXCESS = 0.025  # of the resistance, by sampling plasticity inside the member
ENVELOPE = 181  # points of the exact interaction curve
STIFF = 1e3  # stiffness of a rigid joint of limited strength over that of its member


JointLaw = tuple[float, float, float]  # stiffness, strengths either way


class MeshRule(NamedTuple):
    """Sizes of elements where no option gives them, and how they grow.

    The smallest element is a `share` of the shorter member at the struck or driven node, but not
    below `depth` times the depth of the section; the largest one 1/40 of the longest member and
    at most `largest_depth` times the depth of its section in dynamics, `static_share` of the
    longest member in statics; `growth`, ratio of neighbouring elements.
    """

    share: float
    depth: float
    growth: float = 1.5
    static_share: float = LARGEST_SHARE_IN_DYNAMICS
    largest_depth: float = inf


# Sizes before the option `refinement` halves them, by reference; of co-rotational elements in
# dynamics, in statics and balanced: hinges need room, and statics has no inertia to carry an
# element over the loss of stiffness when its hinge crumples.
STATIC_SHARE = 1.0 / 8.0  # no hinge travels in statics
CLASSICAL_RULE = MeshRule(1.0 / 32.0, 0.1, static_share=STATIC_SHARE)
CLASSICAL_STATIC_RULE = MeshRule(1.0 / 16.0, 0.2, static_share=STATIC_SHARE)
BALANCED_RULE = MeshRule(1.0 / 12.0, 0.3, static_share=STATIC_SHARE)
# Linear elements longer than half a depth lose waves of a light striker: peaks up to 4 % off.
HALF_DEPTH = 0.5
REISSNER_RULE = MeshRule(1.0 / 256.0, 0.01, growth=2.0, largest_depth=HALF_DEPTH)  # within 1 %
REISSNER_GIVEN = REISSNER_RULE._replace(growth=1.5)  # from a given smallest element on
SHEAR_RULE = MeshRule(1.0 / 64.0, 0.05, largest_depth=HALF_DEPTH)


def member_lengths(
    scenario: FrameScenario,
    rule: MeshRule,
    smallest: float | None = None,
    largest: float | None = None,
    refinement: int = 0,
) -> list[Array]:
    """Element lengths (m) of every member.

    Arguments: lengths of the `smallest` element, at both ends of every member, and of the
    `largest` in m (None: by `rule`; a given one ignores its floors); `refinement`, how often all
    are halved (negative: doubled). Where both lengths are given and equal the mesh is uniform.
    Members that continue each other straight on count as one in the length of the longest.
    """
    frame = scenario.frame
    static = isinstance(scenario, FrameStatic)
    bound = rule.static_share if static else LARGEST_SHARE_IN_DYNAMICS
    uniform = smallest is not None and smallest == largest
    depths = inf if static or largest else rule.largest_depth
    largest = largest or bound * _longest(frame)
    node = scenario.striker.node if isinstance(scenario, FrameImpact) else scenario.node
    shorter = min(frame.length(end.member) for end in frame.meeting(node))
    wanted = smallest or min(rule.share * shorter, largest)
    coarser = 2.0 ** max(-refinement, 0)
    result = []
    for member in frame.members:
        span = frame.length(member)
        least = wanted if smallest else max(wanted, rule.depth * member.section.height)
        if uniform:
            count = ceil(span / (coarser * wanted) - 1e-9)
            lengths = np.full(count, span / count)
        else:
            inside = min(largest, depths * member.section.height)
            ends, inner = coarser * least, coarser * max(inside, least)
            lengths = graded_lengths(span, ends, inner, rule.growth)
        result.append(halved(lengths, max(refinement, 0)))
    return result


def _longest(frame: Frame) -> float:
    """Length of the longest member, all its parts, in m."""
    return max(sum(frame.length(name) for name in line.members) for line in chains(frame))


class FrameMesh(NamedTuple):
    """Elements of all members, one member after the other, each from its start to its end.

    `coordinates` (nodes, 2) in m, those of the frame's nodes first; `nodes` (elements, 2);
    `member` (elements,), number of the member; `first` (members + 1,), where its elements start;
    `lengths` (elements,) in m; `joints`, those that turn: number of the member, whether at its
    start, node of the frame, and the node of the member that is tied to it.
    """

    coordinates: Array
    nodes: Indices
    member: Indices
    first: Indices
    lengths: Array
    joints: tuple[tuple[int, bool, int, int], ...]

    @property
    def ties(self) -> tuple[tuple[int, int], ...]:
        """Pairs (node of the frame, node of a member) that share translations only."""
        return tuple((master, slave) for _, _, master, slave in self.joints)

    @property
    def upper(self) -> Flags:
        """Which elements (elements,) lie nearer to the end of their member than to its start.

        One in the very middle belongs to the start, whatever the rounding of the lengths.
        """
        parts = np.split(self.lengths, self.first[1:-1])
        return np.concatenate([np.cumsum(p) - 0.5 * p > MIDDLE * np.sum(p) for p in parts])


def mesh_frame(frame: Frame, lengths: list[Array]) -> FrameMesh:
    """Cut the members into elements of the given lengths (m), in the order of the members."""
    points = frame.points.tolist()
    nodes: list[tuple[int, int]] = []
    joints: list[tuple[int, bool, int, int]] = []
    for index, (member, parts) in enumerate(zip(frame.members, lengths, strict=True)):
        ends = frame.ends[index].tolist()
        start, chord = frame.points[ends[0]], frame.chords[index]
        for side, joint in enumerate(frame.joints_of(member)):
            moments = joint.plastic_moment, joint.plastic_moment_negative
            if (joint.rotational_stiffness, *moments) != (None, None, None):
                joints.append((index, side == 0, ends[side], len(points)))
                points.append(list(points[ends[side]]))
                ends[side] = len(points) - 1
        inner = range(len(points), len(points) + len(parts) - 1)
        shares = np.cumsum(parts[:-1]) / np.sum(parts)
        points.extend((start + np.multiply.outer(shares, chord)).tolist())
        nodes.extend(pairwise([ends[0], *inner, ends[1]]))
    counts = [len(parts) for parts in lengths]
    return FrameMesh(
        np.array(points),
        np.array(nodes, dtype=np.int64),
        np.repeat(np.arange(len(counts)), counts),
        np.concatenate([[0], np.cumsum(counts)]),
        np.concatenate(lengths),
        tuple(joints),
    )


def mesh_findings(scenario: FrameScenario, lengths: list[Array], sampled: float) -> list[Finding]:
    """Meshes for which the result is known to be off by several percent.

    Arguments: element `lengths` (m) of every member; `sampled`, where an element samples
    plasticity, from its end next to a hinge and over its length.
    """
    frame, findings = scenario.frame, []
    parts = {m.name: p for m, p in zip(frame.members, lengths, strict=True)}
    excess = {}
    for names, _, _ in chains(frame, eventful(scenario)):
        whole = sum(float(np.sum(parts[name])) for name in names)
        excess[names[0]] = sampled * (parts[names[0]][0] + parts[names[-1]][-1]) / whole
    above = [name for name in excess if excess[name] > LARGEST_EXCESS]
    if above:
        percent = 100 * max(excess.values())
        findings.append(finding("coarse-hinges", members=named(above), percent=percent))
    longest = max(float(part.max()) for part in lengths)
    limit = WARNED_IN_DYNAMICS * _longest(frame)
    if not isinstance(scenario, FrameStatic) and longest > limit:
        findings.append(finding("coarse-inside", longest=longest))
    return findings


class FiberMembers(MemberReader):
    """Reads the members of a frame off their fiber elements.

    Arguments: the `frame`, its `mesh`, its elements `beams`, its `springs` (None without joints);
    `sampled`, where an element samples plasticity, from its end next to a hinge and over its
    length; `shear_yields`, whether yielding limits the shear force.
    """

    elements: FiberElements

    def __init__(
        self,
        frame: Frame,
        mesh: FrameMesh,
        beams: FiberElements,
        springs: JointSprings | None,
        sampled: float,
        shear_yields: bool,
    ) -> None:
        super().__init__(beams, mesh.first)
        self._mesh, self._springs = mesh, springs
        self._sampled, self._shear_yields = sampled, shear_yields
        sections = [frame.strength_section(member) for member in frame.members]
        steel = frame.steel
        self._squash = np.repeat([s.squash_load(steel) for s in sections], 2)
        self._plastic = np.repeat([s.plastic_moment(steel) for s in sections], 2)
        radii = {s: np.hypot(*s.interaction_envelope(ENVELOPE)) for s in set(sections)}
        self._radii = np.repeat(np.stack([radii[s] for s in sections]), 2, axis=0)
        self._half = 2 * mesh.member + mesh.upper
        self._hinge = np.array([2 * m + (not start) for m, start, _, _ in mesh.joints], dtype=int)
        self._dofs: list[Indices] | None = None
        self._drawn = drawn_points(mesh)

    def plastic_rotations(self) -> Array:
        """Plastic curvature integrated over the half member next to each end, and its joint."""
        rotation = self._near_ends(self.elements.plastic_rotations())
        if self._springs is not None:
            rotation[self._hinge] += self._springs.plastic
        return rotation

    def _near_ends(self, of_elements: Array) -> Array:
        """Sums (..., hinges) of values (..., elements) over the half member next to each end."""
        total = np.zeros((*of_elements.shape[:-1], len(self._ends)))
        np.add.at(total.T, self._half, of_elements.T)
        return total

    def utilisation(self) -> Array:
        """Radius of (N/Np, M/Mp) over that of the exact envelope, where the end is sampled.

        Of the joint there, if more of its strength is used.
        """
        local = self.elements.local_forces[self._ends]
        rows = np.arange(len(local))
        near = self._signs * local[rows, 1 + self._side]
        far = -self._signs * local[rows, 2 - self._side]
        moment = (1.0 - self._sampled) * near + self._sampled * far
        n, m = np.abs(local[:, 0]) / self._squash, np.abs(moment) / self._plastic
        at = np.arctan2(n, m) / (0.5 * np.pi) * (ENVELOPE - 1)
        low = np.minimum(at.astype(int), ENVELOPE - 2)
        rows = np.arange(len(at))
        share = at - low
        bound = (1.0 - share) * self._radii[rows, low] + share * self._radii[rows, low + 1]
        used = np.asarray(np.hypot(n, m) / bound)
        if self._springs is not None:
            np.maximum.at(used, self._hinge, self._springs.utilisation())
        return used

    def shear_forces(self) -> Array:
        """Shear force of each member (members,), mean along it."""
        return self._mean(self.elements.shear_forces)

    def shear_strains(self) -> Array | None:
        """Shear strain of each member (members,), mean along it; None unless shear yields."""
        return self._mean(self.elements.shear_strains) if self._shear_yields else None

    def _mean(self, values: Array) -> Array:
        """Magnitude of the mean along each member (members,) of values (elements,)."""
        mesh = self._mesh
        weighted = np.add.reduceat(values * mesh.lengths, mesh.first[:-1], axis=-1)
        return np.abs(weighted / np.add.reduceat(mesh.lengths, mesh.first[:-1]))

    def shapes(self, assembly: PlanarAssembly) -> Array:
        """Displaced positions (members, points, axes), straight between the nodes."""
        if self._dofs is None:
            count, along = range(len(self._mesh.coordinates)), list(assembly.components)
            self._dofs = [assembly.dofs(count, each) for each in along[: assembly.axes]]
        moved = [assembly.displacement[..., dofs] for dofs in self._dofs]
        position = self._mesh.coordinates + np.stack(moved, axis=-1)
        start, end, share = self._drawn
        first, last = position[..., start, :], position[..., end, :]
        return np.asarray(first + share[..., None] * (last - first))


def drawn_points(mesh: FrameMesh) -> tuple[Indices, Indices, Array]:
    """Nodes before and after the `POINTS` of all members, and how far between (members, points)."""
    rows = []
    for first, last in zip(mesh.first[:-1], mesh.first[1:], strict=True):
        line = np.append(mesh.nodes[first:last, 0], mesh.nodes[last - 1, 1])
        at = np.concatenate([[0.0], np.cumsum(mesh.lengths[first:last])])
        points = POINTS * at[-1]
        k = np.clip(np.searchsorted(at, points, side="right") - 1, 0, len(at) - 2)
        rows.append((line[k], line[k + 1], (points - at[k]) / (at[k + 1] - at[k])))
    start, end, share = (np.stack(each) for each in zip(*rows, strict=True))
    return start, end, share


def joint_laws(frame: Frame, mesh: FrameMesh) -> Iterator[tuple[tuple[int, int], JointLaw]]:
    """Nodes and laws of the rotational springs between members and their nodes.

    A rigid joint of limited strength gets `STIFF` times 4 EI/L of its member. Bounds that a joint
    does not give are those of the member, whose fibers yield by themselves.
    """
    for index, at_start, master, slave in mesh.joints:
        member = frame.members[index]
        joint = frame.joints_of(member)[not at_start]
        stiffness = joint.rotational_stiffness
        if stiffness is None:
            bending = frame.steel.elastic_modulus * frame.properties(member).second_moment
            stiffness = STIFF * 4.0 * bending / frame.length(member)
        bounds = joint.plastic_moment or inf, joint.plastic_moment_negative or inf
        yield (master, slave) if at_start else (slave, master), (stiffness, *bounds)


def joint_springs(frame: Frame, mesh: FrameMesh) -> JointSprings | None:
    """Rotational springs between members and their nodes; None where no joint turns."""
    springs = list(joint_laws(frame, mesh))
    return JointSprings(*zip(*springs, strict=True)) if springs else None


PEAK_STEPS = 130.0  # time steps up to the expected peak, at least
WAVE_STEPS = 20.0  # time steps while an axial wave passes the longest member, at least
LONE_STEPS = 10.0  # where no other member is: it does as well within 0.1 % of the peak
LEAST_STEPS = 200.0  # time steps of a record, at least


@dataclass(frozen=True)
class FiberReference(FrameModel):
    """Frames of fiber elements with a refinement ladder."""

    smallest_element: float | None = checked(
        Number(1e-4, 10.0, "m"), optional=True, help="at both ends of every member (None: by rule)"
    )
    largest_element: float | None = checked(
        Number(1e-4, 100.0, "m"), optional=True, help="None: by rule"
    )
    layers: int = checked(LAYERS, 20, help="over the depth")
    time_step: float | None = checked(
        Number(1e-8, 1e-2, "s"),
        optional=True,
        help="None: 1/20 of the time of an axial wave along the longest member, 1/10 in a single "
        "one, at first at most 1/130 of the expected time to the peak",
    )
    refinement: int = checked(
        REFINEMENT, 0, help="how often all elements and steps are halved (negative: doubled)"
    )
    step_refinement: int = checked(REFINEMENT, 0, help=HALVED_STEPS)
    levels: int = checked(LEVELS, 3, help=MESHES)
    weight: float = checked(
        Number(0.5, 1.0, advice="1/2 conserves energy, 1 dissipates most"),
        0.5,
        help="of the end stresses in a time step; more than 1/2 damps waves",
    )
    hardening_ratio: float = checked(
        Number(0.0, 0.1), 1e-6, help="regularising hardening over the elastic modulus"
    )

    judged: ClassVar[bool] = False
    unused: ClassVar[tuple[str, ...]] = ("joint.axial_stiffness", "joint.*_resistance")
    collision_halvings: ClassVar[int] = 5
    longer: ClassVar[float] = 1.0  # steps, where less is left of the waves
    largest_error: ClassVar[float | None] = None  # refinement measures it
    shear_yields: ClassVar[bool] = False
    concentrated: ClassVar[bool] = False

    def check(self) -> None:
        """Refuse levels that do not fit."""
        check_levels(self.refinement, self.levels)

    @abstractmethod
    def mesh_rule(self, scenario: FrameScenario) -> MeshRule:
        """Sizes of elements where no option gives them."""

    @property
    @abstractmethod
    def sampled(self) -> float:
        """Where an element samples plasticity, from its end next to a hinge and over its length."""

    @abstractmethod
    def fibers(self, frame: Frame, mesh: FrameMesh) -> FiberElements:
        """The elements of a mesh."""

    def sections(self, frame: Frame) -> list[BeamSection]:
        """The fibers of every member."""
        return [self.section(frame, member) for member in frame.members]

    def section(self, frame: Frame, member: Member) -> BeamSection:
        """The fibers of a member."""
        law, sheared = self.law(frame.steel), self.shear_flexible
        return fiber_section(frame, member, self.layers, law, self.residual_stress, sheared=sheared)

    def law(self, steel: Steel) -> Law:
        """The law of the fibers."""
        return LinearHardening.of(steel, self.hardening_ratio)

    def domain(self, scenario: ColumnScenario | FrameScenario) -> list[Finding]:
        """Findings common to all member models that fibers do not follow, then `limits`."""
        followed = ("buckling", "shear") if self.shear_yields else ("buckling",)
        return [f for f in super().domain(scenario) if f.refusal or f.subject not in followed]

    def limits(self, event: FrameScenario) -> list[Finding]:
        """Joints, overrides and meshes that fibers do not follow."""
        return [
            *joint_findings(event.frame),
            *fiber_overrides(event.frame, self.layers),
            *mesh_findings(event, self.lengths(event), self.sampled),
        ]

    def simulate(self, scenario: Scenario) -> Response:
        """Answer a scenario of a column or a frame, with numerical uncertainty."""
        return respond(self, scenario, lambda given: refined(self, given, self.solve))

    def lengths(self, scenario: ColumnScenario | FrameScenario) -> list[Array]:
        """Element lengths (m) of every member; of a column below and above the impact point."""
        event = as_frame(scenario)
        sizes = self.smallest_element, self.largest_element, self.refinement
        return member_lengths(event, self.mesh_rule(event), *sizes)

    def time_spans(self, scenario: ColumnImpact | FrameImpact) -> Spans:
        """End times and time steps (s) of the parts of the record, refinement applied."""
        event = as_frame(scenario)
        assert isinstance(event, FrameImpact)
        share = 0.5**self.halvings
        if self.time_step is not None:
            return [(event.duration, self.time_step * share)]
        waves = line_wave_times(event.frame)
        wave_steps = WAVE_STEPS if len(waves) > 1 else LONE_STEPS
        coarsest = min(self.longer * max(waves) / wave_steps, event.duration / LEAST_STEPS)
        peak = time_to_peak(event, shear_flexible=True)
        return spans_to(peak, event.duration, self.longer * peak / PEAK_STEPS, coarsest, share)

    def structure(self, scenario: ColumnScenario | FrameScenario) -> FrameStructure:
        """The frame, or the column as one, under its dead loads. Raises `SolverError`."""
        frame = as_frame(scenario).frame
        mesh = self.placed(mesh_frame(frame, self.lengths(scenario)))
        beams = self.fibers(frame, mesh)
        springs = joint_springs(frame, mesh)
        members = FiberMembers(frame, mesh, beams, springs, self.sampled, self.shear_yields)
        groups = [beams] if springs is None else [beams, springs]
        assembly = PlanarAssembly(mesh.coordinates, groups, ties=mesh.ties)
        return apply_dead_loads(frame, assembly, members)

    def placed(self, mesh: FrameMesh) -> FrameMesh:
        """The mesh with its nodes where they are before any load."""
        return mesh

    @property
    def halvings(self) -> int:
        """How often the steps are halved."""
        return self.refinement + self.step_refinement


def joint_findings(frame: Frame) -> list[Finding]:
    """Findings on joints: strengths that a rotational spring at a fiber member leaves out."""
    used = {m.joint_start for m in frame.members} | {m.joint_end for m in frame.members}
    strengths = {j.name: (j.plastic_moment, j.plastic_moment_negative) for j in frame.joints}
    names = [name for name, each in strengths.items() if name in used and any(each)]
    return [finding("joint-moments", names=", ".join(names))] if names else []
