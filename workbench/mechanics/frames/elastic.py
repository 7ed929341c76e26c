"""The column that is hit in a frame, the line of members through the struck node; its head mass.

**Second part.** Small displacements of a frame of elastic Bernoulli beams: unit loads, buckling,
time scales.

Displacements of the nodes and forces at member ends are exact for loads at the nodes. Mass and
geometric stiffness are consistent with the cubic deflection (Przemieniecki 1968). Time steps follow
from how long the events of a frame take.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from math import inf, pi, sqrt
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike
from threadpoolctl import ThreadpoolController

from workbench.base.arrays import Array
from workbench.mechanics.frames import out_of_domain
from workbench.mechanics.frames.members import chains, shear_stiffness
from workbench.mechanics.frames.structure import dead_loads, hinge_names, nodal_loads, series
from workbench.mechanics.structures.assembly import COMPONENTS, SPATIAL
from workbench.scenarios import Frame, FrameImpact, Load, Member, Node
from workbench.scenarios.parts import COMPONENT, OVERRIDES
from workbench.steel.sections.slenderness import twist_stiffness

NO_STIFFNESS = 1e-11  # eigenvalue of the scaled stiffness that counts as none
UNBALANCED = 1e-6  # share of a load that meets no stiffness
LEAST_SOFTENING = 1e-9  # share of the stiffness; what is less is rounding
HALVES = 2  # of a member: its buckling load is 0.8 % too large with pinned ends, 1.3 % clamped
FIRST_SPAN, LATER = 6.0, 4.0  # beyond so many times to the peak, so many times longer steps
_FELT = 0.05  # of the largest swing of a mode after a blow

Spans = list[tuple[float, float]]  # end times and time steps of the parts of a record, in s


@cache
def linear_algebra() -> ThreadpoolController:
    """The libraries of linear algebra with threads; to look for them takes some ms.

    Band solves and small eigenvalue problems are far too small for several: `limit(limits=1)`.
    """
    return ThreadpoolController().select(user_api="blas")


class ElasticFrame:
    """The elastic frame for small displacements from its state under dead loads.

    Arguments: `frame`; names of the `members` that count (None: all); `springs`, whether springs
    to the ground and locks act, as they do once the dead loads are on; beams (`parts`) per member.
    Nodes of a frame in space have six dofs, and joints turn about all axes alike.
    """

    def __init__(
        self,
        frame: Frame,
        members: Collection[str] | None = None,
        *,
        springs: bool = True,
        parts: int = 1,
    ) -> None:
        self._frame = frame
        self._counted = [members is None or m.name in members for m in frame.members]
        # of each member: dofs of its parts, stiffness of a part, to local axes
        self._beams: list[tuple[Array, Array, Array]] = []
        self._parts = parts
        self.places = SPATIAL if frame.spatial else COMPONENTS
        each, turns = len(self.places), len(self.places) // 2
        # dofs of a member: rotations at joints, nodes between parts
        inner = 2 * turns + each * (parts - 1)
        size = each * len(frame.nodes) + inner * len(frame.members)
        self.stiffness: Array = np.zeros((size, size))
        self.mass: Array = np.zeros((size, size))
        for number in range(len(frame.members)):
            self._place(number, each * len(frame.nodes) + inner * number)
        held = []
        for number, node in enumerate(frame.nodes):
            dofs = each * number + np.arange(each)
            self.mass[dofs, dofs] += np.repeat(
                [node.mass, node.rotary_inertia], [each - turns, turns]
            )
            parts_held = node.held + (node.held_beside if frame.spatial else ())
            held += [dofs[self.places[component]] for component in parts_held]
            if frame.spatial and node.name not in frame.turned:  # pins alone, which twist nothing
                held += dofs[each - turns :].tolist()
            if springs:
                for direction, component in COMPONENT.items():
                    at = dofs[self.places[component]]
                    self.stiffness[at, at] += getattr(node, f"spring_{direction}")
                if node.locked != "none":
                    held.append(dofs[self.places[COMPONENT[node.locked]]])
        resisting = np.flatnonzero(np.diag(self.stiffness) > 0.0)
        self._free = np.setdiff1d(resisting, held)
        self._held = np.array(sorted(held), dtype=np.int64)
        scale = 1.0 / np.sqrt(np.diag(self.stiffness)[self._free])
        values, modes = np.linalg.eigh(
            self.stiffness[np.ix_(self._free, self._free)] * np.outer(scale, scale)
        )
        self._stiff = values > NO_STIFFNESS * max(values.max(initial=0.0), 1e-300)
        self._values, self._modes = values, scale[:, None] * modes

    def _place(self, number: int, spare: int) -> None:
        """Add stiffness and mass of a member; its own dofs begin with `spare`."""
        frame, member, counted = self._frame, self._frame.members[number], self._counted[number]
        each = len(self.places)
        turns = each // 2
        dofs = np.concatenate([each * end + np.arange(each) for end in frame.ends[number]])
        properties = frame.properties(member)
        softness = frame.length(member) / (frame.steel.elastic_modulus * properties.area)
        bent = properties.second_moment / (properties.area * softness)
        axes = _axes(frame, number)
        for side, joint in enumerate(frame.joints_of(member)):
            softness += 0.0 if joint.axial_stiffness is None else 1.0 / joint.axial_stiffness
            if joint.rotational_stiffness is not None:
                at = each * side + each - turns + np.arange(turns)
                ends = np.concatenate([dofs[at], spare + turns * side + np.arange(turns)])
                dofs[at] = ends[turns:]
                if counted:
                    turn = joint.rotational_stiffness * np.eye(turns)
                    if turns > 1:  # what is pinned does not twist
                        turn += 6.0 * bent * np.outer(axes[0, :3], axes[0, :3])
                    self.stiffness[np.ix_(ends, ends)] += np.kron([[1.0, -1.0], [-1.0, 1.0]], turn)
        local = scipy.linalg.block_diag(axes, axes)
        part = frame.length(member) / self._parts
        stiffness = _beam(frame, member, self._parts / softness, part)
        mass = _mass(properties.mass_per_length * part, part)
        if frame.spatial:
            both = frame.about_both(member)
            radius = sum(values.second_moment for values in both) / properties.area
            turned = properties.mass_per_length * part * radius / 6.0
            mass = _both_planes(mass, mass, turned * np.array([[2.0, 1.0], [1.0, 2.0]]))
        between = spare + 2 * turns + np.arange(each * (self._parts - 1)).reshape(-1, each)
        line = np.vstack([dofs[:each], between, dofs[each:]])
        beams = np.hstack([line[:-1], line[1:]])
        self._beams.append((beams, stiffness, local))
        for beam in beams if counted else ():
            self.stiffness[np.ix_(beam, beam)] += local.T @ stiffness @ local
            self.mass[np.ix_(beam, beam)] += local.T @ mass @ local

    def load(self, loads: Sequence[Load]) -> Array:
        """Nodal forces and moments (dofs,)."""
        total, each = np.zeros(len(self.stiffness)), len(self.places)
        for component, forces in zip(COMPONENTS, nodal_loads(self._frame, loads).T, strict=True):
            total[each * np.arange(len(forces)) + self.places[component]] = forces
        return total

    def displacement(self, load: Array) -> Array | None:
        """Displacements (dofs,) under a load; None where something moves without resistance."""
        moved = np.zeros(len(load))
        carried = np.concatenate([self._free, self._held])
        loose = np.delete(load, carried)
        shares = self._modes.T @ load[self._free]
        lost = np.linalg.norm(shares[~self._stiff])
        if np.any(loose) or lost > UNBALANCED * np.linalg.norm(shares):
            return None
        stiff = self._stiff
        moved[self._free] = self._modes[:, stiff] @ (shares[stiff] / self._values[stiff])
        return moved

    @property
    def is_mechanism(self) -> bool:
        """Whether something can move without resistance."""
        return not bool(np.all(self._stiff))

    def buckling_factor(self, axial: Array) -> float:
        """Factor on `axial` forces (hinges,) at which the frame, no mechanism, buckles.

        Forces in N, tension positive, as `end_forces` gives them. Infinite without compression.
        """
        softening = np.zeros_like(self.stiffness)
        for i, (beams, _, local) in enumerate(self._beams):
            bow = _geometric(self._frame.length(self._frame.members[i]) / self._parts)
            bow = _both_planes(bow, bow, np.zeros((2, 2))) if self._frame.spatial else bow
            for dofs in beams:
                softening[np.ix_(dofs, dofs)] += axial[2 * i] * local.T @ bow @ local
        grid = np.ix_(self._free, self._free)
        lowest = scipy.linalg.eigh(
            softening[grid], self.stiffness[grid], eigvals_only=True, subset_by_index=[0, 0]
        )[0]
        return np.inf if lowest > -LEAST_SOFTENING else -1.0 / float(lowest)

    def vibrations(self, load: Array) -> tuple[Array, Array]:
        """Periods (s) of the modes, and how far each swings after an impulse along a `load`.

        Both (modes,), without those that have no mass or move without resistance.
        """
        shapes = self._modes[:, self._stiff] / np.sqrt(self._values[self._stiff])
        squares, modes = scipy.linalg.eigh(
            shapes.T @ self.mass[np.ix_(self._free, self._free)] @ shapes
        )
        moved = (modes.T @ (shapes.T @ load[self._free])) ** 2
        heavy = squares > NO_STIFFNESS * squares.max(initial=0.0)
        slowness = np.sqrt(squares[heavy])  # 1 / omega
        return 2.0 * np.pi * slowness, moved[heavy] / slowness

    def end_forces(self, displacement: Array) -> tuple[Array, Array]:
        """Axial forces and moments (hinges,) at the ends of all members, see `hinge_names`.

        Axial forces are positive in tension, moments where they stretch the fibers on the right
        of somebody who looks from start to end; zero in members that do not count.
        """
        (axial, moment), each = np.zeros((2, len(hinge_names(self._frame)))), len(self.places)
        for i, (beams, stiffness, local) in enumerate(self._beams):
            if self._counted[i]:
                first, last = (stiffness @ local @ displacement[beams[j]] for j in (0, -1))
                axial[2 * i : 2 * i + 2] = last[each]
                moment[2 * i : 2 * i + 2] = -first[each - 1], last[2 * each - 1]
        return axial, moment


def _axes(frame: Frame, number: int) -> Array:
    """Rotation of the dofs of a node from global axes to those of a member, (3, 3) or (6, 6)."""
    if not frame.spatial:
        c, s = frame.chords[number] / frame.lengths[number]
        return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    along, height = frame.directions[number, 0], frame.heights[number]
    rows = np.stack([along, height, np.cross(along, height)])
    return np.asarray(scipy.linalg.block_diag(rows, rows))


def _beam(frame: Frame, member: Member, axial: float, length: float, softer: float = 0.0) -> Array:
    """Stiffness of `length` (m) of a member in local axes, `axial` in N/m.

    `softer`, Timoshenko's ratio of bending to shear stiffness, see `_stiffness`.
    """
    modulus = frame.steel.elastic_modulus
    if not frame.spatial:
        return _stiffness(axial, modulus * frame.properties(member).second_moment, length, softer)
    strong, weak = (modulus * values.second_moment for values in frame.about_both(member))
    section = frame.strength_section(member)
    twist = twist_stiffness(section.about("strong"), frame.steel) / length
    planes = _stiffness(axial, strong, length, softer), _stiffness(axial, weak, length)
    return _both_planes(*planes, twist * np.array([[1.0, -1.0], [-1.0, 1.0]]))


def _both_planes(strong: Array, weak: Array, twist: Array) -> Array:
    """Matrix (12, 12) of two planes of bending (6, 6), the first with what is axial, and twist."""
    matrix, alike = np.zeros((12, 12)), np.array([0.0, 1.0, -1.0, 0.0, 1.0, -1.0])
    matrix[np.ix_([0, 2, 4, 6, 8, 10], [0, 2, 4, 6, 8, 10])] = weak * np.outer(alike, alike)
    matrix[np.ix_([0, 1, 5, 6, 7, 11], [0, 1, 5, 6, 7, 11])] += strong
    matrix[np.ix_([3, 9], [3, 9])] = twist
    return matrix


def _local(lengthwise: ArrayLike, across: ArrayLike) -> Array:
    """Matrix (6, 6) in local axes, of axial displacements (2, 2) and of deflections (4, 4)."""
    matrix = np.zeros((6, 6))
    matrix[np.ix_([0, 3], [0, 3])] = lengthwise
    matrix[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = across
    return matrix


def _stiffness(axial: float, bending: float, length: float, softer: float = 0.0) -> Array:
    """Stiffness of a beam in local axes (6, 6): `axial` in N/m, `bending` EI in N m2.

    `softer`, Timoshenko's ratio of bending to shear stiffness, 12 EI / (L^2 G A_v).
    """
    a, b, c, d = 12.0 / length**2, 6.0 / length, 4.0 + softer, 2.0 - softer
    rows = [[a, b, -a, b], [b, c, -b, d], [-a, -b, a, -b], [b, d, -b, c]]
    bent = bending / (1.0 + softer) / length * np.array(rows)
    return _local([[axial, -axial], [-axial, axial]], bent)


def _geometric(length: float) -> Array:
    """Geometric stiffness of a beam under unit tension in local axes (6, 6)."""
    a, b, c, d = 36.0, 3.0 * length, 4.0 * length**2, -(length**2)
    rows = [[a, b, -a, b], [b, c, -b, d], [-a, -b, a, -b], [b, d, -b, c]]
    return _local(np.zeros((2, 2)), np.array(rows) / (30.0 * length))


def _mass(mass: float, length: float) -> Array:
    """Consistent mass of a beam in local axes (6, 6)."""
    a, b, c = 22.0 * length, 13.0 * length, length**2
    rows = [
        [156.0, a, 54.0, -b],
        [a, 4 * c, b, -3 * c],
        [54.0, b, 156.0, -a],
        [-b, -3 * c, -a, 4 * c],
    ]
    lengthwise = mass / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    return _local(lengthwise, mass / 420.0 * np.array(rows))


class DeadLoadState(NamedTuple):
    """Axial forces (members,) in N, tension positive, and the critical factor on the dead loads.

    The factor is infinite without compression, and None for a mechanism.
    """

    axial: Array
    factor: float | None


def dead_load_state(frame: Frame) -> DeadLoadState:
    """First-order axial forces and buckling factor under the dead loads of a frame."""
    return _dead_load_state(frame.elastic)


@lru_cache(maxsize=64)
def _dead_load_state(frame: Frame) -> DeadLoadState:
    elastic = ElasticFrame(frame, springs=False, parts=HALVES)
    moved = None if elastic.is_mechanism else elastic.displacement(elastic.load(dead_loads(frame)))
    if moved is None:
        return DeadLoadState(np.zeros(len(frame.members)), None)
    axial, _ = elastic.end_forces(moved)
    return DeadLoadState(axial[::2], elastic.buckling_factor(axial))


def spans_to(peak: float, duration: float, first: float, coarsest: float, share: float) -> Spans:
    """Parts of a record around and after a peak, at the time `peak` in s.

    Arguments: `duration` of the record, step at `first` and the `coarsest` one allowed, all in s;
    `share` of these steps that is taken.
    """
    first = min(coarsest, first)
    later = min(coarsest, LATER * first)
    return [(min(FIRST_SPAN * peak, duration), share * first), (duration, share * later)]


def time_to_peak(scenario: FrameImpact, shear_flexible: bool = False) -> float:
    """Estimate (s) of the time of the peak: of an elastic spring, or of hinges if longer.

    Both from the members at the struck node alone, held at their far ends; the plastic estimate
    is that of a mechanism with hinges at both ends of them. Elastic shear strain counts if
    `shear_flexible`.
    """
    frame, striker = scenario.frame, scenario.striker
    each = 6 if frame.spatial else 3
    push = np.zeros(each)
    push["xy".index(striker.direction[-1])] = 1.0
    stiffness, resistance = np.zeros((each, each)), 0.0
    inertia = striker.mass + frame.node(striker.node).mass
    for end in frame.meeting(striker.node):
        member, length = end.member, frame.length(end.member)
        properties, modulus = frame.properties(member), frame.steel.elastic_modulus
        axes = _axes(frame, frame.members.index(member))
        softer = 0.0
        if shear_flexible:
            shear = shear_stiffness(frame.strength_section(member), frame.steel)
            softer = 12.0 * modulus * properties.second_moment / (length**2 * shear)
        stiff = _beam(frame, member, modulus * properties.area / length, length, softer)
        own = slice(0, each) if end.at_start else slice(each, 2 * each)
        stiffness += axes.T @ stiff[own, own] @ axes
        lengthwise, *across = np.abs(axes @ push)[: (each + 1) // 2]
        both = frame.about_both(member) if frame.spatial else (properties,)
        for values, share in zip(both, across, strict=True):
            resistance += 2.0 * values.plastic_moment / length * float(share)
        resistance += properties.squash_load * float(lengthwise)
        inertia += properties.mass_per_length * length / 3.0
    flexibility = float(push @ np.linalg.pinv(stiffness) @ push)
    elastic = 0.5 * pi * sqrt(inertia * flexibility)
    return max(elastic, striker.mass * striker.velocity / resistance)


def slowest_period(frame: Frame, node: str, direction: str) -> float:
    """Longest period (s) of those that a blow on a node along a direction makes felt.

    Of the elastic frame; dead loads lengthen it by no more than they soften the mode in which it
    buckles.
    """
    return _slowest_period(frame.elastic, node, direction)


@lru_cache(maxsize=64)
def _slowest_period(frame: Frame, node: str, direction: str) -> float:
    elastic = ElasticFrame(frame, parts=HALVES)
    blow = elastic.load([Load(node, **{direction[-1]: 1.0})])
    periods, swings = elastic.vibrations(blow)
    factor = dead_load_state(frame).factor if dead_loads(frame) else inf
    softer = 1.0 if factor is None else sqrt(1.0 - 1.0 / factor)
    return float(periods[swings >= _FELT * swings.max(initial=0.0)].max(initial=0.0)) / softer


def wave_times(frame: Frame) -> Array:
    """Times (members,) in s of an axial wave along every member."""
    stiffness = frame.steel.elastic_modulus * frame.each("area")
    return np.asarray(frame.lengths / np.sqrt(stiffness / frame.each("mass_per_length")))


def line_wave_times(frame: Frame) -> list[float]:
    """Times (s) of an axial wave along every line of members that continue each other."""
    times = dict(zip((m.name for m in frame.members), wave_times(frame).tolist(), strict=True))
    return [sum(times[name] for name in line.members) for line in chains(frame)]


OBLIQUE = 0.02  # sine of the largest angle between the strike and the normal of the column
RIGID, PINNED = 8.0, 0.5  # stiffness of a joint over EI/L: EN 1993-1-8, 5.2.2.5 (braced frames)
HEAD_MASSES = ("column-line", "joint", "deflected-shape", "none")
STRAIGHT_ON = 0.02  # sine of the largest kink in the line above the head


@dataclass(frozen=True)
class ColumnLine:
    """The line of `members` (names) from node `base` to node `head` through the struck one.

    `axis` (2,) points from base to head; lengths `below` and `above` the struck node in m;
    `fixed`, whether the rotations of base and head are held; `softness`, flexibility in m/N of
    joints along the line.
    """

    frame: Frame
    members: tuple[str, ...]
    base: str
    head: str
    axis: tuple[float, float]
    below: float
    above: float
    fixed: tuple[bool, bool]
    softness: float

    @property
    def rest(self) -> tuple[str, ...]:
        """Names of all other members."""
        return tuple(m.name for m in self.frame.members if m.name not in self.members)

    def pull(self, force: float) -> tuple[Load, Load]:
        """Forces (N) on both ends that draw them together."""
        x, y = force * self.axis[0], force * self.axis[1]
        return Load(self.head, x=-x, y=-y), Load(self.base, x=x, y=y)

    def turned(self) -> ColumnLine:
        """Line with base and head exchanged."""
        return replace(
            self,
            members=self.members[::-1],
            base=self.head,
            head=self.base,
            axis=(-self.axis[0], -self.axis[1]),
            below=self.above,
            above=self.below,
            fixed=self.fixed[::-1],
        )


def column_line(scenario: FrameImpact) -> ColumnLine:
    """The column that a striker hits.

    The base is the end that a support holds against all translation; of two such ends, or none,
    the lower one. Raises `OutOfDomainError` where what is hit is no column between two joints.
    """
    frame, struck = scenario.frame, scenario.striker.node
    chain = next((each for each in chains(frame) if struck in each.nodes[1:-1]), None)
    if chain is None:
        raise out_of_domain("hit-at-joint", node=struck)
    members, line = [frame.member(name) for name in chain.members], chain.nodes
    ends = frame.node(line[0]), frame.node(line[-1])
    chord = np.array([ends[1].x - ends[0].x, ends[1].y - ends[0].y])
    axis, joints = chord / np.hypot(*chord), [end.joint for end in chain.ends]
    _refuse_what_no_column_has(scenario, members, line, axis)
    lengths, at = [frame.length(member) for member in members], line.index(struck)
    properties = frame.properties(members[0])
    unit = frame.steel.elastic_modulus * properties.second_moment / sum(lengths)
    fixed = [
        _is_fixed(frame, end, chain.members, joint, unit)
        for end, joint in zip(ends, joints, strict=True)
    ]
    for name in joints:
        if frame.joint(name).weaker(properties.strength) != properties.strength:
            raise out_of_domain("weak-joint", joint=name)
    column = ColumnLine(
        frame,
        chain.members,
        line[0],
        line[-1],
        (float(axis[0]), float(axis[1])),
        sum(lengths[:at]),
        sum(lengths[at:]),
        (fixed[0], fixed[1]),
        sum(1.0 / k for name in joints if (k := frame.joint(name).axial_stiffness) is not None),
    )
    ranks = [(not {"u", "v"} <= set(node.held), node.y, node.x) for node in ends]
    return column if ranks[0] <= ranks[1] else column.turned()


def _refuse_what_no_column_has(
    scenario: FrameImpact, members: list[Member], line: Sequence[str], axis: Array
) -> None:
    """Raise `OutOfDomainError` for changing sections, loads between the ends, oblique strikes."""
    frame, striker = scenario.frame, scenario.striker
    kinds = {(m.section, *(getattr(m, key) for key in OVERRIDES)) for m in members}
    if len(kinds) > 1:
        raise out_of_domain("changing-section", members=", ".join(m.name for m in members))
    for name in line[1:-1]:
        node = frame.node(name)
        loaded = any(load.node == name for load in frame.loads)
        if loaded or node.rotary_inertia > 0.0 or (node.mass > 0.0 and name != striker.node):
            raise out_of_domain("loaded-inside", node=name)
    lengthwise = abs(float(axis[0 if striker.direction.endswith("x") else 1]))
    if lengthwise > OBLIQUE:
        how = "along" if lengthwise > 1.0 - OBLIQUE else "obliquely to"
        raise out_of_domain("oblique-strike", direction=striker.direction, how=how)


def _is_fixed(frame: Frame, node: Node, chain: Sequence[str], joint: str, unit: float) -> bool:
    """Whether the rotation at an end is held; `unit` is EI/L in N m/rad.

    Raises `OutOfDomainError` for free ends, and for joints neither stiff nor soft.
    """
    alone = all(end.member.name in chain for end in frame.meeting(node.name))
    if alone and not node.resisted - {"rotation"}:
        raise out_of_domain("loose-end", node=node.name)
    turning = frame.turns(node.name, chain) or "rotation" in node.held
    rigid = None if turning else node.spring_rotation
    share = series(frame.joint(joint).rotational_stiffness, rigid) / unit
    if PINNED < share < RIGID:
        limits = {"rigid": RIGID, "pinned": PINNED}
        raise out_of_domain("semi-rigid-end", node=node.name, share=share, **limits)
    return share >= RIGID


def mass_of_head(rule: str, line: ColumnLine, shape: Array | None) -> float:
    """Mass (kg) at the head by a rule of `HEAD_MASSES`.

    Joint: point mass of the head and half of the other members that meet there. Column line: the
    same for all joints of the line that goes on beyond the head, its members whole; that line is
    far stiffer along its axis than the beams that hold it, and moves with the head. Deflected
    shape: generalised mass of the frame without the column in the deflection that its spring has.
    """
    frame = line.frame
    if rule == "none":
        return 0.0
    if rule == "deflected-shape":
        if shape is None:
            raise out_of_domain("no-deflected-shape")
        return float(shape @ ElasticFrame(frame, line.rest).mass @ shape)
    nodes = [line.head] if rule == "joint" else _line_above(line)
    total = sum(frame.node(name).mass for name in nodes)
    for member in frame.members:
        if member.name not in line.members:
            ends = (member.start in nodes) + (member.end in nodes)
            mass = frame.properties(member).mass_per_length * frame.length(member)
            total += 0.5 * ends * mass
    return total


def _line_above(line: ColumnLine) -> list[str]:
    """Names of the nodes from the head on along the axis of the column."""
    frame, nodes = line.frame, [line.head]
    axis = np.array(line.axis)
    while True:
        at = frame.node(nodes[-1])
        if at.held:
            return nodes
        for end in frame.meeting(at.name):
            far = frame.node(end.other.node)
            chord = np.array([far.x - at.x, far.y - at.y])
            across = abs(float(axis[0] * chord[1] - axis[1] * chord[0]))
            if axis @ chord > 0.0 and across < STRAIGHT_ON * float(np.hypot(*chord)):
                nodes.append(far.name)
                break
        else:
            return nodes
