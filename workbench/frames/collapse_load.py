"""Plastic collapse of a frame: limit load, and the margin against P-Delta sway collapse.

Limit load of the rigid-plastic frame on its undeformed shape, by the static theorem: end forces (N
and both end moments) of every member and the load factor are the unknowns of a linear programme.
Equilibrium is an equality, yielding bounds N and M apart, without interaction; the largest factor
is the collapse load (Livesley 1975, chapter 3).

The rigid-plastic sway of a frame resists R - c w at a drift w, c what its dead loads take of it:
beyond w = R / c it falls. The energy that it takes up to w is R w - c w^2 / 2; so a share q of R is
missing for the same energy to reach R / c where (1 - q)^2 = 1 - (1 - c w / R)^2. Near the end
little energy is left in much drift, and models that differ by some percent in what yields differ
in whether the frame stands.
"""

from collections.abc import Collection, Sequence
from math import inf, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linprog

from workbench.arrays import Array
from workbench.errors import OutOfDomainError
from workbench.frames.column_line import column_line
from workbench.frames.elastic import dead_load_state
from workbench.frames.structure import nodal_loads, upright_names
from workbench.responses import Finding, finding
from workbench.scenarios import Frame, FrameImpact, Load, Member
from workbench.structures.assembly import COMPONENTS

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
        """What each member (members,) takes of that."""
        lengths = [frame.length(member) for member in frame.members]
        return -np.asarray(axial) * self.turns(frame) ** 2 * lengths

    def turns(self, frame: Frame) -> Array:
        """Rotations of the chords of the members (members,) per unit of work."""
        number = {node.name: i for i, node in enumerate(frame.nodes)}
        turns = []
        for member in frame.members:
            start, end = frame.node(member.start), frame.node(member.end)
            dx, dy = end.x - start.x, end.y - start.y
            moved = self.shape[number[member.end]] - self.shape[number[member.start]]
            turns.append((dx * moved[1] - dy * moved[0]) / (dx**2 + dy**2))
        return np.array(turns)


def collapse_mechanism(
    frame: Frame,
    pattern: Sequence[Load],
    dead: Sequence[Load] = (),
    members: Collection[str] | None = None,
) -> CollapseMechanism | None:
    """`collapse_factor` and how the frame moves there: displacements are the dual variables."""
    counted = [m for m in frame.members if members is None or m.name in members]
    first = {node.name: 3 * i for i, node in enumerate(frame.nodes)}
    strengths = [member_strength(frame, member) for member in counted]
    moment = max((float(moments.max()) for _, _, moments in strengths), default=1.0)
    force = moment / max((frame.length(member) for member in counted), default=1.0)
    unknowns = 3 * len(counted) + 1
    balance = np.zeros((3 * len(frame.nodes), unknowns))
    bounds: list[tuple[float | None, float | None]] = []
    for number, (member, strength) in enumerate(zip(counted, strengths, strict=True)):
        tension, compression, ((sagging, hogging), (far_sagging, far_hogging)) = strength
        unit = np.array([tension, moment, moment])
        dofs = np.concatenate([first[n] + np.arange(3) for n in (member.start, member.end)])
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
    optimum = linprog(
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
    start, end = frame.node(member.start), frame.node(member.end)
    length = frame.length(member)
    c, s = (end.x - start.x) / length, (end.y - start.y) / length
    e, n = np.array([c, s, 0.0]), np.array([-s, c, 0.0]) / length
    turn = np.array([0.0, 0.0, 1.0])
    rows = [np.append(-e, e), np.append(turn + n, -n), np.append(n, turn - n)]
    return np.array(rows).T


def member_strength(frame: Frame, member: Member) -> tuple[float, float, Array]:
    """Tension and compression resistance; sagging and hogging plastic moments at both ends."""
    strength = frame.properties(member).strength
    joints = [frame.joint(name) for name in (member.joint_start, member.joint_end)]
    ends = np.array([joint.weaker(strength) for joint in joints])
    pinned = [joint.rotational_stiffness == 0.0 for joint in joints]
    ends[pinned, 2:] = 0.0
    tension, compression = ends[:, :2].min(axis=0)
    return float(tension), float(compression), ends[:, 2:]


def sway_collapse(scenario: FrameImpact) -> Array | None:
    """Share of the way to P-Delta collapse per drift of each upright member (uprights,).

    For the storey above or below the struck column; its mechanism is that of a force at the head of
    the column, or at the struck joint. None if dead loads take none of its resistance.
    """
    frame, striker = scenario.frame, scenario.striker
    if not frame.loads or striker.direction[-1] != "x":
        return None
    try:
        node = column_line(scenario).head
    except OutOfDomainError:
        node = striker.node
    push = Load(node, x=-1.0 if striker.direction.startswith("-") else 1.0)
    mechanism = collapse_mechanism(frame, [push], frame.loads)
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
