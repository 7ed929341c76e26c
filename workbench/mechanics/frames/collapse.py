"""Plastic collapse of a frame: limit load, margin against P-Delta sway collapse, when it has come.

Limit load of the rigid-plastic frame on its undeformed shape, by the static theorem: end forces (N
and both end moments) of every member and the load factor are the unknowns of a linear programme.
Equilibrium is an equality, yielding bounds N and M apart, without interaction; the largest factor
is the collapse load (Livesley 1975, chapter 3).

The rigid-plastic sway of a frame resists R - c w at a drift w, c what its dead loads take of it:
beyond w = R / c it falls. The energy that it takes up to w is R w - c w^2 / 2; so a share q of R is
missing for the same energy to reach R / c where (1 - q)^2 = 1 - (1 - c w / R)^2. Near the end
little energy is left in much drift, and models that differ by some percent in what yields differ
in whether the frame stands. A frame that has collapsed (`CollapseWatch`) ends a run.
"""

from collections.abc import Collection, Sequence
from functools import lru_cache
from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from workbench.base.arrays import Array, Indices
from workbench.base.errors import (
    Collapse,
    CollapseError,
    CrumpledError,
    Mechanism,
    OutOfDomainError,
)
from workbench.mechanics.frames.elastic import column_line, dead_load_state
from workbench.mechanics.frames.members import chains, named
from workbench.mechanics.frames.structure import (
    FrameStructure,
    dead_loads,
    nodal_loads,
    upright_names,
)
from workbench.mechanics.structures.assembly import COMPONENTS, PlanarAssembly
from workbench.responses import Finding, finding
from workbench.scenarios import Frame, FrameImpact, Load, Member

UNBOUNDED = 3  # status of `linprog`
SUBJECT = "near-collapse"
MISSING = 0.1  # of the resistance: what limits at yield and their spread leave open


def collapse_factor(
    frame: Frame,
    pattern: Sequence[Load],
    dead: Sequence[Load] = (),
    members: Collection[str] | None = None,
) -> float | None:
    """Largest factor on a `pattern` of loads that the strength of the members allows.

    Arguments: `dead` loads, not multiplied; names of the `members` that count (None: all).
    Springs to the ground and locks never yield. Infinite if nothing that yields is in the way;
    None if the strength does not reach for the dead loads alone.
    """
    mechanism = collapse_mechanism(frame, pattern, dead, members)
    return None if mechanism is None else mechanism.factor


class CollapseMechanism(NamedTuple):
    """Collapse load `factor` and displacements (nodes, 3) per unit of work of the pattern."""

    factor: float
    shape: Array

    def softening(self, frame: Frame, axial: ArrayLike) -> float:
        """Loss of the factor per unit of the mechanism's work by forces `axial` (members,) in N.

        Second-order work of what members carry (tension positive) as their chords turn.
        """
        return float(self.works(frame, axial).sum())

    def works(self, frame: Frame, axial: ArrayLike) -> Array:
        """Share of each member (members,) in that second-order work."""
        return np.asarray(-np.asarray(axial) * self.turns(frame) ** 2 * frame.lengths)

    def turns(self, frame: Frame) -> Array:
        """Rotations of the chords of the members (members,) per unit of work."""
        (dx, dy), (start, end) = frame.chords.T, self.shape[frame.ends.T]
        moved = end - start
        return np.asarray((dx * moved[:, 1] - dy * moved[:, 0]) / (dx**2 + dy**2))


def collapse_mechanism(
    frame: Frame,
    pattern: Sequence[Load],
    dead: Sequence[Load] = (),
    members: Collection[str] | None = None,
) -> CollapseMechanism | None:
    """`collapse_factor` and how the frame moves there: displacements are the dual variables."""
    counted = [m for m in frame.members if members is None or m.name in members]
    strengths = [member_strength(frame, member) for member in counted]
    moment = max((float(moments.max()) for _, _, moments in strengths), default=1.0)
    force = moment / max((frame.length(member) for member in counted), default=1.0)
    unknowns = 3 * len(counted) + 1
    balance = np.zeros((3 * len(frame.nodes), unknowns))
    bounds: list[tuple[float | None, float | None]] = []
    for number, (member, strength) in enumerate(zip(counted, strengths, strict=True)):
        tension, compression, ((sagging, hogging), (far_sagging, far_hogging)) = strength
        unit = np.array([tension, moment, moment])
        dofs = np.concatenate([3 * frame.number[end.node] + np.arange(3) for end in member.ends])
        balance[dofs, 3 * number : 3 * number + 3] = _equilibrium(frame, member) * unit
        bounds.append((-compression / tension, 1.0))
        # the internal moment is -M1 at the start and +M4 at the end
        bounds.append((-sagging / moment, hogging / moment))
        bounds.append((-far_hogging / moment, far_sagging / moment))
    bounds.append((None, None))
    balance[:, -1] = -force * nodal_loads(frame, pattern).ravel()
    units = np.resize([force, force, moment], len(balance))
    free = [
        3 * i + k
        for i, node in enumerate(frame.nodes)
        for component, k in COMPONENTS.items()
        if component not in node.resisted  # by a support, a spring or a lock
    ]
    optimum = scipy.optimize.linprog(
        np.append(np.zeros(unknowns - 1), -1.0),
        A_eq=(balance / units[:, None])[free],
        b_eq=(nodal_loads(frame, dead).ravel() / units)[free],
        bounds=bounds,
        method="highs",
    )
    shape = np.zeros(len(balance))
    if optimum.status == UNBOUNDED:
        return CollapseMechanism(inf, shape.reshape(-1, 3))
    if not optimum.success or optimum.x[-1] < 0.0:
        return None
    shape[free] = optimum.eqlin.marginals / units[free]
    work = float(nodal_loads(frame, pattern).ravel() @ shape)
    return CollapseMechanism(float(optimum.x[-1] * force), (shape / work).reshape(-1, 3))


def _equilibrium(frame: Frame, member: Member) -> Array:
    """Nodal forces (6, 3) of a unit tension and unit end moments."""
    length = frame.length(member)
    c, s = frame.chords[frame.members.index(member)] / length
    e, n = np.array([c, s, 0.0]), np.array([-s, c, 0.0]) / length
    turn = np.array([0.0, 0.0, 1.0])
    rows = [np.append(-e, e), np.append(turn + n, -n), np.append(n, turn - n)]
    return np.array(rows).T


def member_strength(frame: Frame, member: Member) -> tuple[float, float, Array]:
    """Tension and compression resistance; sagging and hogging plastic moments at both ends."""
    strength = frame.properties(member).strength
    joints = frame.joints_of(member)
    ends = np.array([joint.weaker(strength) for joint in joints])
    pinned = [joint.rotational_stiffness == 0.0 for joint in joints]
    ends[pinned, 2:] = 0.0
    tension, compression = ends[:, :2].min(axis=0)
    return float(tension), float(compression), ends[:, 2:]


def sway_collapse(scenario: FrameImpact) -> Array | None:
    """Share of the way to P-Delta collapse per drift of each upright member (uprights,).

    For the storey above or below the struck column; its mechanism is that of a force at the head of
    the column, or at the struck joint. None if dead loads take none of its resistance, or in space.
    """
    frame, striker = scenario.frame, scenario.striker
    if not dead_loads(frame) or striker.direction[-1] != "x" or frame.spatial:
        return None
    try:
        node = column_line(scenario).head
    except OutOfDomainError:
        node = striker.node
    push = Load(node, x=-1.0 if striker.direction.startswith("-") else 1.0)
    mechanism = collapse_mechanism(frame, [push], dead_loads(frame))
    if mechanism is None or not 0.0 < mechanism.factor < inf:
        return None
    work = mechanism.works(frame, dead_load_state(frame).axial)
    names = [member.name for member in frame.members]
    upright = [names.index(name) for name in upright_names(frame)]
    softening, turns = work.sum(), np.abs(mechanism.turns(frame))[upright]
    if softening <= 0.0 or not np.any(turns > 0.0):
        return None
    # drifts over those of the mechanism, weighted by what the dead loads do on them
    weights = np.maximum(work[upright], 0.0)
    shares = np.divide(weights, turns, out=np.zeros_like(turns), where=turns > 0.0)
    return np.asarray(shares / weights.sum() * float(softening / mechanism.factor))


def sway_findings(per_drift: Array | None, drift: Array) -> list[Finding]:
    """Warning of a frame that stands, but with little resistance less would collapse.

    Arguments: `per_drift` of `sway_collapse`; largest `drift` of each upright member (uprights,).
    """
    reached = 0.0 if per_drift is None else float(per_drift @ drift)
    missing = 0.0 if reached >= 1.0 else 1.0 - sqrt(reached * (2.0 - reached))
    if missing >= MISSING:
        return []
    return [finding(SUBJECT, reached, reached=reached, missing=100.0 * missing)]


COLLAPSE_SIDEWAYS = 0.9  # movement of a member's ends across its axis, over its length
TURNED_OVER = 0.99  # the same, of bars that may hang on until then
COLLAPSE_CONTRACTION = 0.1  # of the length of a straight chain of members: squashed
LEAST_LENGTH = 0.05  # of an element; plastic strains have lost all meaning long before


class DriftOperator(NamedTuple):
    """Matrices from nodal displacements to member drift, contraction and storey sway.

    Translations of both ends of each member, its `corners` (members, 2 axes); the `transverse`
    parts (one in the plane, two in space) and the `axial` part of the movement of its end from its
    start (members, parts, axes) and (members, axes), over its length; names of the
    members of each straight line, its `chains`, and `chain_average` (chains, members), 1 over its
    length; the dofs of upright members, `column_dofs`, and the drift of the line of each from
    them, `sway` (parts, column_dofs, uprights).
    """

    corners: Indices
    transverse: Array
    axial: Array
    chains: list[tuple[str, ...]]
    chain_average: Array
    column_dofs: Indices
    sway: Array


def _drift_operator(frame: Frame, assembly: PlanarAssembly) -> DriftOperator:
    """The drift operator of a frame and of the dofs of its assembly."""
    along = list(assembly.components)[: assembly.axes]
    corners = np.stack([assembly.dofs(frame.ends[:, k], c) for k in (0, 1) for c in along], axis=1)
    return _drift_matrices(frame.elastic, corners.tobytes(), assembly.size, assembly.axes)


@lru_cache(maxsize=64)
def _drift_matrices(frame: Frame, placed: bytes, size: int, axes: int) -> DriftOperator:
    lengths = frame.lengths
    corners = np.frombuffer(placed, np.int64).reshape(-1, 2 * axes)
    directions = frame.directions[:, :, :axes] / lengths[:, None, None]
    axial, transverse = directions[:, 0], directions[:, 1:axes]
    moved, rows = np.zeros((transverse.shape[1], len(lengths), size)), np.arange(len(lengths))
    parts = np.moveaxis(transverse, 1, 0)
    moved[:, rows[:, None], corners] = np.concatenate([-parts, parts], axis=2)
    place = {member.name: i for i, member in enumerate(frame.members)}
    straight = [chain.members for chain in chains(frame)]
    members = np.zeros((len(straight), len(place)))
    for row, names in zip(members, straight, strict=True):
        row[[place[name] for name in names]] = 1.0
    chain_average = members / (members @ lengths)[:, None]
    lines = ((chain_average * lengths) @ moved)[:, members.argmax(axis=0)]
    drifting = lines[:, [place[name] for name in upright_names(frame)]]
    column_dofs = np.flatnonzero(drifting.any(axis=(0, 1)))
    return DriftOperator(
        corners,
        transverse,
        axial,
        straight,
        chain_average,
        column_dofs,
        np.swapaxes(drifting[..., column_dofs], 1, 2).copy(),
    )


class CollapseWatch:
    """Checks the committed state of a `structure` after every step.

    A member whose ends have moved across by `COLLAPSE_SIDEWAYS` has collapsed with what was then
    (`turned`), unless its bars hang on: a peak comes before it has turned over.
    """

    def __init__(self, structure: FrameStructure) -> None:
        self._structure = structure
        self.turned: CollapseError | None = None
        if "drift" not in structure.kept:
            structure.kept["drift"] = _drift_operator(structure.frame, structure.assembly)
        self.drift: DriftOperator = structure.kept["drift"]

    def follow(self, displacement: Any, time: Any) -> None:
        """Note what has `turned` first, in the committed state or in several, one of each time."""
        transverse = np.atleast_2d(self._apart(now=True))
        rows = np.flatnonzero(transverse.max(axis=1) > COLLAPSE_SIDEWAYS)
        if self.turned is None and len(rows):
            row, apart = rows[0], transverse[rows[0]]
            names = (self._structure.frame.members[int(apart.argmax())].name,)
            reached = (float(np.atleast_1d(each)[row]) for each in (displacement, time))
            reason = finding("turned-over", float(apart.max())).text
            collapse = Collapse(Mechanism.GEOMETRY, names, *reached)
            self.turned = CollapseError(collapse, f"{named(names)} {reason}")

    def check(self, displacement: float, time: float | None) -> None:
        """Raise `CollapseError` when the frame has collapsed, with the `displacement` (m) so far.

        Without a `time` (s), on a static path, nothing collapses.
        Raises `CrumpledError` where an element crumples: that depends on its length, and other
        meshes may go on and survive; `OutOfDomainError` where equilibrium is that of the
        undeformed frame, which knows no tension of members that hang.
        """
        structure, members = self._structure, self._structure.members
        left = members.lengths_left()
        if left.min() < LEAST_LENGTH:
            name, at = structure.frame.members[int(left.argmin())].name, float(displacement)
            values: dict[str, Any] = {"member": name, "displacement": at, "least": LEAST_LENGTH}
            raise CrumpledError(finding("element-crumples", **values).text)
        if time is None:
            return
        first_order = getattr(structure.assembly.groups[0], "first_order", False)
        if first_order and self._apart(now=True).max() > COLLAPSE_SIDEWAYS:
            raise OutOfDomainError(finding("undeformed", float(displacement)))
        self.follow(displacement, time)
        if self.turned is not None and self._apart(now=True).max() > TURNED_OVER:
            raise self.turned
        lost = members.contractions() @ self.drift.chain_average.T
        if lost.max() > COLLAPSE_CONTRACTION:
            names, most = self.drift.chains[int(lost.argmax())], 100.0 * COLLAPSE_CONTRACTION
            reason = finding("squashed", 100.0 * float(lost.max()), most=most).text
            collapse = Collapse(Mechanism.SQUASH, names, float(displacement), time)
            raise self.turned or CollapseError(collapse, f"{named(names)} {reason}")

    def drifts(self, moved: Array) -> Array:
        """Drift of the straight line of members that each upright one belongs to (uprights,).

        Of displacements `moved` (dofs,): movement of the line's ends across it over its length.
        """
        sways = [moved[..., self.drift.column_dofs] @ part for part in self.drift.sway]
        return np.asarray(np.hypot.reduce(sways))

    def sideways(self) -> tuple[float, int]:
        """Largest movement of a member's ends across its axis over its length; which member."""
        moved = self._apart(now=False)
        worst = int(moved.argmax())
        return float(moved[worst]), worst

    def _apart(self, *, now: bool) -> Array:
        """Movement of each member's ends across its axis over its length (members,).

        `now`, also over the distance that is left between its ends: a chord that turns over passes
        all of that, and may be too short to reach its first length.
        """
        drift, at = self.drift, self._structure.assembly.displacement[..., self.drift.corners]
        axes = drift.axial.shape[1]
        apart = at[..., axes:] - at[..., :axes]
        across = np.sum(apart[..., None, :] * drift.transverse, axis=-1)
        moved = np.linalg.norm(across, axis=-1)
        if now:
            left = 1.0 + np.sum(apart * drift.axial, axis=-1)
            moved /= np.minimum(1.0, np.hypot(moved, left))
        return np.asarray(moved)
