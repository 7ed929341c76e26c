"""Superelements as the impact integrator takes them, and the march from Python."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array, Indices
from workbench.base.compiled import njit
from workbench.mechanics.impact.contact import contact_step_of, inner
from workbench.mechanics.impact.integrator import (
    COLLAPSE,
    COMMON,
    GOING,
    PROGRESS,
    StepFunctions,
    begin,
    check_end,
    law_of,
    march_of,
)
from workbench.mechanics.impact.newton import Equations, newton_of
from workbench.mechanics.impact.pace import Pace
from workbench.mechanics.structures import kernels
from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.elements import StepEnergies
from workbench.mechanics.structures.impact import PointMass
from workbench.mechanics.structures.kernels import copy, largest
from workbench.mechanics.structures.superelements import kernels as elements
from workbench.mechanics.structures.superelements import kernels as step
from workbench.mechanics.structures.superelements.group import (
    Superelements,
    SuperelementState,
    scratch,
)
from workbench.mechanics.structures.superelements.kernels import Body, Motion, Work, dot

LONGER = 1.5  # times as long a step may be as the one before: with 2 peaks are ten times as far off
CUT = 0.2  # least share of a repeated step: with 0.1 peaks of columns scatter a third wider
WORK, REPEATS = 1e-9, 3  # of the energy brought in, that a residual may do in a step; tries at that
NUMBERS = 500_000  # that are handed over at a time, at most
SUMS = (*StepEnergies._fields, "external_work")
RECORD = np.dtype([(name, float) for name in dict.fromkeys((*COMMON, *SUMS))])
LEDGER = np.dtype([(name, float) for name in SUMS])


class CollapseLimits(NamedTuple):
    """Beyond what a structure has collapsed; why it has is for `frames.collapse` to say.

    Movement of the ends of a member `sideways` over its length; `contraction` of a line of members
    over its length; least `length` of an element over its first one. Of each member the number of
    its `first` element (members + 1,); dofs u, v of both `corners` (members, 4), and what of the
    movement of its end counts `across` and `along` (members, 2), over the length; which `chain` of
    members in a straight line it is in, and its `share` of that in 1/m.
    """

    sideways: float
    contraction: float
    length: float
    first: Indices
    corners: Indices
    across: Array
    along: Array
    chain: Indices
    share: Array


class StruckSystem(NamedTuple):
    """All of a struck structure: what is fixed, moves, is scratch; its limits of collapse.

    Committed states of records: `x` and `v` (records, dofs) and, of all elements, `states`.
    """

    body: Body
    motion: Motion
    work: Work
    limits: CollapseLimits
    x: Array
    v: Array
    states: SuperelementState


newton = newton_of(Equations(step.vectors, step.evaluate, step.allowed, step.aim, step.bend))


@inner
def hit(s):
    """Place and velocity of the struck dof along the strike."""
    body, d = s.body, s.body.dof
    return body.sign * s.motion.x[d] - body.origin, body.sign * s.motion.v[d]


@inner
def solve(s, dt, closed, touch, striker):
    """Solve a step with the contact closed or open; its end stands in `work.x`.

    Result: whether that was possible, velocity of the struck dof at the end, residual over the
    allowed one, number of evaluations.
    """
    body, motion, work, d = s.body, s.motion, s.work, s.body.dof
    for i in range(work.x.size):
        work.given[i] = 2.0 / dt * motion.momentum[i] + body.load[i]
        ahead = motion.rate[i] + 0.5 * (dt + motion.lasted[0]) * motion.trend[i]
        work.x[i] = motion.x[i] + dt * ahead
    copy(motion.old.carried, motion.new.carried)
    done, residual, evaluations = False, 0.0, 0
    for _ in range(REPEATS):
        done, residual, count = newton(s, dt, closed, touch, striker)
        evaluations += count
        if not done or abs(dot(work.residual, work.moved)) <= WORK * body.energy:
            break
    end = body.sign * (2.0 * (work.x[d] - motion.x[d]) / dt - motion.v[d])
    return done, end, residual, evaluations


@inner
def settle(s, dt):
    """Let hinges flow on; root of what they spend on that over the energy brought in.

    It shows where hinges begin to flow, ring, or follow the surface around a bend.
    """
    trial, motion = s.motion.energies[1], s.motion
    trial.stored, trial.plastic, trial.algorithmic, trial.ideal, excess = elements.settle(
        0.5, s.body.hinges, motion.old, motion.new
    )
    return (max(excess, 0.0) / s.body.energy) ** 0.5


@inner
def accept(s, dt):
    """Commit the solved step and its energies."""
    body, motion, work = s.body, s.motion, s.work
    x0, v0, sums, trial = motion.x, motion.v, motion.energies[0], motion.energies[1]
    for i in range(work.x.size):
        moved = work.x[i] - x0[i]
        slope = 2.0 * (moved / dt - motion.rate[i]) / (dt + motion.lasted[0])
        # of two that differ in sign none, else the smaller one: what rings is not extrapolated
        same = slope * motion.slope[i] > 0.0
        motion.trend[i] = min(abs(slope), abs(motion.slope[i])) if same else 0.0
        if slope < 0.0:
            motion.trend[i] *= -1.0
        motion.slope[i], motion.rate[i] = slope, moved / dt
        sums.external_work += body.load[i] * moved
        v0[i] = 2.0 * moved / dt - v0[i]
        x0[i] = work.x[i]
    for h in body.held:
        v0[h] = 0.0
    kernels.band_product(body.mass, body.width, v0, motion.momentum)
    copy(motion.new.plastic, motion.old.plastic)
    copy(motion.new.carried, motion.old.carried)
    copy(motion.new.local, motion.old.local)
    copy(motion.new.deformation, motion.old.deformation)
    copy(motion.new.rate, motion.old.rate)
    motion.lasted[0] = dt
    motion.force[0] = max(motion.force[0], largest(work.internal))
    sums.stored = trial.stored
    for k in range(body.spring_dofs.size):
        moved = x0[body.spring_dofs[k]] - body.springs[k, 1]
        sums.stored += 0.5 * body.springs[k, 0] * moved**2
    sums.plastic += trial.plastic
    sums.algorithmic += trial.algorithmic
    sums.ideal += trial.ideal


@inner
def write(s, records, n):
    """Energies, and the states."""
    row, sums, motion, states = records[n], s.motion.energies[0], s.motion, s.states
    row.stored, row.plastic, row.algorithmic = sums.stored, sums.plastic, sums.algorithmic
    row.ideal, row.external_work = sums.ideal, sums.external_work
    row.kinetic = 0.5 * dot(motion.v, motion.momentum)
    for e in range(s.body.hinges.rotary.size):
        row.kinetic += 0.5 * s.body.hinges.rotary[e] * motion.old.rate[e] ** 2
    copy(motion.x, s.x[n])
    copy(motion.v, s.v[n])
    copy(motion.old.plastic, states.plastic[n])
    copy(motion.old.carried, states.carried[n])
    copy(motion.old.local, states.local[n])
    copy(motion.old.deformation, states.deformation[n])


@inner
def collapsed(s):
    """Whether the committed state is beyond a limit."""
    limits, lengths, x = s.limits, s.body.bars.lengths, s.motion.x
    deformation = s.motion.old.deformation
    first, corners, across, along = limits.first, limits.corners, limits.across, limits.along
    squashed = np.zeros(limits.chain.size)
    for m in range(limits.chain.size):
        stretched = 0.0
        for e in range(first[m], first[m + 1]):
            stretched += deformation[e, 0]
            if deformation[e, 0] < (limits.length - 1.0) * lengths[e]:
                return True
        squashed[limits.chain[m]] -= limits.share[m] * stretched
        du = x[corners[m, 2]] - x[corners[m, 0]]
        dv = x[corners[m, 3]] - x[corners[m, 1]]
        apart = abs(du * across[m, 0] + dv * across[m, 1])
        left = 1.0 + du * along[m, 0] + dv * along[m, 1]
        # a chord that turns over passes all of what is left between its ends, see `CollapseWatch`
        if apart > limits.sideways * min(1.0, np.hypot(apart, left)):
            return True
    return squashed.size > 0 and squashed.max() > limits.contraction


# forces between striker and bars ring: contacts open at the end of a step, not on a line of forces
_STEP = contact_step_of(hit, solve, released=False)
advance = march_of(
    StepFunctions(hit, solve, settle, accept, write, collapsed, step=_STEP), LONGER, CUT
)


@njit(cache=True, error_model="numpy", nogil=True)
def impact(system, drive, progress, records):
    """Follow an impact, see `workbench.mechanics.impact.integrator`: (status, records written)."""
    return advance(system, begin(drive, progress[0]), progress[0], records)


class Records(NamedTuple):
    """Several records of an impact: their `table` of RECORD, and committed states.

    Of all records the displacements `x` and velocities `v` (records, dofs) and, of all elements,
    `states`; whether the structure has `collapsed` in the last one; `evaluations` and `cuts` so
    far.
    """

    table: Any
    x: Array
    v: Array
    states: SuperelementState
    collapsed: bool
    evaluations: int
    cuts: int

    @property
    def time(self) -> Array:
        """Times (records,) in s."""
        return np.asarray(self.table["time"])


def follow_impact(
    assembly: PlanarAssembly,
    dof: int,
    striker: PointMass,
    pace: Pace,
    limits: CollapseLimits,
    *,
    sign: float = 1.0,
    tolerance: float = 1e-9,
    vibration_start: float = 0.0,
) -> Iterator[Records]:
    """Follow an impact as `structures.impact.impact` does with its midpoint scheme.

    Arguments as there, but the `pace` of the steps, `limits` beyond which the structure has
    collapsed, and the time `vibration_start` (s) before which no step is as long as in a vibration.
    The only group of the `assembly` are superelements; both stay as they are, so that several
    threads may follow impacts on them. Yields several records at a time, the first one of the
    start. Raises `SolverError`.
    """
    (group,) = assembly.groups
    assert isinstance(group, Superelements)
    springs, (hinges,), (old, new) = assembly.springs, group.tables, group.states
    body = Body(
        group.bars,
        hinges._replace(scratch=scratch(*old.plastic.shape)),
        assembly.mass,
        assembly.width,
        assembly.held,
        assembly.load,
        np.array(list(springs), dtype=np.int64),
        np.array(list(springs.values()), dtype=float).reshape(-1, 2),
        float(assembly.shortest),
        dof,
        sign,
        sign * float(assembly.displacement[dof]),
        striker.kinetic_energy,
        tolerance,
    )
    energies = np.zeros(2, LEDGER)
    energies["stored"][0] = assembly.stored
    motion = Motion(
        assembly.displacement.copy(),
        assembly.velocity.copy(),
        assembly.mass_times(assembly.velocity),
        SuperelementState(*(values.copy() for values in old)),
        SuperelementState(*(values.copy() for values in new)),
        np.zeros(assembly.size),
        np.zeros(assembly.size),
        np.zeros(assembly.size),
        np.zeros(1),
        np.array([assembly.largest_force]),
        energies,
    )
    vectors: list[Array] = [*np.empty((2, assembly.band.size)), *np.zeros((8, assembly.size))]
    work = Work._make([*vectors, np.zeros(assembly.size, np.int64)])
    progress = np.zeros(1, PROGRESS)
    progress["place"], progress["crush"] = striker.position, law_of(striker.crushing)
    progress["gravity"] = striker.gravity
    drive = np.array([*pace, striker.mass, striker.velocity, striker.restitution, vibration_start])
    size = 2 * assembly.size + sum(values.size for values in old)
    rows, status = max(3, min(1024, NUMBERS // size)), GOING
    while status in (GOING, COLLAPSE):
        table = np.zeros(rows, RECORD)
        x, v = np.empty((rows, assembly.size)), np.empty((rows, assembly.size))
        states = SuperelementState(*(np.empty((rows, *values.shape)) for values in old))
        system = StruckSystem(body, motion, work, limits, x, v, states)
        status, count = impact(system, drive, progress, table)
        if count:
            states = SuperelementState(*(values[:count] for values in states))
            spent = int(progress["evaluations"][0]), int(progress["cuts"][0])
            yield Records(table[:count], x[:count], v[:count], states, status == COLLAPSE, *spent)
    check_end(status, progress[0], pace)
