"""Impacts on structures of bars between hinges, in compiled steps, whatever the bars are.

A midpoint step solves M (v1 - v0) / dt + f = p + w P / dt with v1 = 2 (x1 - x0) / dt - v0 and
energy-exact forces f; a closed contact eliminates the impulse P. Axial vibrations of the bars are
not resolved: the scheme keeps their energy at any step.
"""

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
    check_end,
    law_of,
    march_of,
)
from workbench.mechanics.impact.newton import Equations, newton_of
from workbench.mechanics.impact.pace import Pace
from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.elements import StepEnergies, StepRequest
from workbench.mechanics.structures.impact import PointMass
from workbench.mechanics.structures.kernels import (
    add_inertia,
    allowed_residual,
    band_product,
    copy,
    hold,
    largest,
    solve_band,
)

LONGER = 1.5  # times as long a step may be as the one before: with 2 peaks are ten times as far off
CUT = 0.2  # least share of a repeated step: with 0.1 peaks of columns scatter a third wider
LARGEST_TURN = 0.03  # rad of a node in an iteration; beyond it a spring holds it back
WORK, REPEATS = 1e-9, 3  # of the energy brought in, that a residual may do in a step; tries at that
NUMBERS = 500_000  # that are handed over at a time, at most
SUMS = (*StepEnergies._fields, "external_work")
RECORD = np.dtype([(name, float) for name in dict.fromkeys((*COMMON, *SUMS))])
LEDGER = np.dtype([(name, float) for name in SUMS])


class CollapseLimits(NamedTuple):
    """Beyond what a structure has collapsed; why it has is for `frames.collapse` to say.

    Movement of the ends of a member `sideways` over its length; `contraction` of a line of members
    over its length; least `length` of an element over its first one. Of each member the number of
    its `first` element (members + 1,); translations of both `corners` (members, 2 axes), and what
    of the movement of its end counts `across` (members, parts, axes) and `along` (members, axes),
    over the length; which `chain` of members in a straight line it is in, and its `share` of that
    in 1/m.
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


class Body(NamedTuple):
    """Body that does not change in a run: the structure and where the striker hits it.

    `bars` and their tables `hinges` of all elements; flat bands of the `mass` with half-bandwidth
    `width`; `held` dofs; dead `load` (dofs,); springs to the ground: `spring_dofs`, and `springs`
    (s, 2) of stiffness and place where unstressed; `shortest` element in m; struck `dof`, the
    `sign` of the strike, `origin` of its path in m; `energy` of the striker at first in J;
    `tolerance` of the residual over the largest force.
    """

    bars: Any
    hinges: Any
    mass: Array
    width: int
    held: Indices
    load: Array
    spring_dofs: Indices
    springs: Array
    shortest: float
    dof: int
    sign: float
    origin: float
    energy: float
    tolerance: float


class Motion(NamedTuple):
    """Motion: committed `x`, `v` and momentum M v (dofs,), states of the elements.

    `old` is committed, `new` the trial; mean `rate` (dofs,) of the last step, how that has changed
    since the one before, `slope`, and is expected to change, `trend`, both per time; `lasted` (1,),
    length of the last step; `force` (1,), the largest nodal force so far; `energies` (2,) of
    LEDGER, committed sums and those of the trial step.
    """

    x: Array
    v: Array
    momentum: Array
    old: Any
    new: Any
    rate: Array
    slope: Array
    trend: Array
    lasted: Array
    force: Array
    energies: Any


class Work(NamedTuple):
    """Scratch of a step: the flat `band` of the tangent, one `kept`, and vectors (dofs,)."""

    band: Array
    kept: Array
    x: Array
    start: Array
    moved: Array
    given: Array
    internal: Array
    residual: Array
    step: Array
    pull: Array
    pivots: Indices


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
    states: Any


class BarFunctions(NamedTuple):
    """Functions of a kind of bars, compiled, over their tables and states.

    `assemble(step, bars, hinges, old, new)`: see `ElementGroup`.
    `start(old, new)`: from where the trial state of a step begins.
    `finish(weight, bars, hinges, old, new) -> stored, plastic, algorithmic, ideal, spent`: energies
    of a solved step in J, which may settle; what flow has cost that the step did not follow.
    `keep(new, old)`: commits a state. `write(old, states, n)`: row n of the recorded states.
    `kinetic(hinges, old)`: kinetic energy beside the mass matrix, in J.
    """

    assemble: Any
    start: Any
    finish: Any
    keep: Any
    write: Any
    kinetic: Any


@inner
def vectors(s):
    """Displacements at the end of the step, where Newton's step began, that step, the residual."""
    return s.work.x, s.work.start, s.work.step, s.work.residual


@inner
def allowed(s, dt, size):
    """Residual of a solved step, `size` that of the first guess."""
    body, motion = s.body, s.motion
    least = body.tolerance * max(motion.force[0], largest(body.load), 1e-3 * size)
    reach = max(largest(motion.x), body.shortest)
    return allowed_residual(least, s.work.band, body.width, reach)


@inner
def bend(s):
    """Return d'Kd of the step d with the tangent K."""
    band_product(s.work.band, s.body.width, s.work.step, s.work.pull)
    return dot(s.work.step, s.work.pull)


@njit(cache=True, error_model="numpy", forceinline=True)
def dot(a, b):
    """Scalar product."""
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@inner
def hit(s):
    """Place and velocity of the struck dof along the strike."""
    body, d = s.body, s.body.dof
    return body.sign * s.motion.x[d] - body.origin, body.sign * s.motion.v[d]


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
        left, square, axes = 1.0, 0.0, along.shape[1]
        for k in range(axes):
            left += along[m, k] * (x[corners[m, axes + k]] - x[corners[m, k]])
        for part in range(across.shape[1]):
            moved = 0.0
            for k in range(axes):
                moved += across[m, part, k] * (x[corners[m, axes + k]] - x[corners[m, k]])
            square += moved * moved
        apart = square**0.5
        # a chord that turns over passes all of what is left between its ends, see `CollapseWatch`
        if apart > limits.sideways * min(1.0, np.hypot(apart, left)):
            return True
    return squashed.size > 0 and squashed.max() > limits.contraction


def march_of_bars(bars: BarFunctions, axes: int, each: int) -> Any:
    """The march of a structure of bars: `march(system, pace, progress, records)`, see `march_of`.

    Of the `each` dofs of a node the first `axes` are translations.
    """
    assemble, start, finish, keep, keep_row, kinetic = bars

    @inner
    def evaluate(s, dt, closed, touch, striker):
        """Residual and tangent of a step of `dt` (s) that ends at `work.x`; size of the residual.

        A `closed` contact ends the step with the velocity `touch` of the `striker` (kg), before
        what P takes.
        """
        body, motion, work, x = s.body, s.motion, s.work, s.work.x
        factor = 2.0 / (dt * dt)
        for i in range(work.band.size):
            work.band[i] = factor * body.mass[i]
        work.internal[:] = 0.0
        step = StepRequest(work.internal, work.band, motion.x, x, 0.5, True, dt, True)
        assemble(step, body.bars, body.hinges, motion.old, motion.new)
        diagonal, rows = 2 * body.width, 3 * body.width + 1
        for k in range(body.spring_dofs.size):
            dof, stiffness = body.spring_dofs[k], body.springs[k, 0]
            at = 0.5 * (x[dof] + motion.x[dof])
            work.internal[dof] += stiffness * (at - body.springs[k, 1])
            work.band[dof * rows + diagonal] += 0.5 * stiffness
        for i in range(x.size):
            work.moved[i] = x[i] - motion.x[i]
        add_inertia(
            body.mass, body.width, work.moved, factor, work.given, work.internal, body.held,
            work.residual,
        )  # fmt: skip
        if closed:
            d = body.dof
            v1 = body.sign * (2.0 * work.moved[d] / dt - motion.v[d])
            work.residual[d] -= body.sign * striker * (touch - v1) / dt
            work.band[d * rows + diagonal] += factor * striker
        return largest(work.residual)

    @inner
    def hold_back(body, work):
        """Write the step anew where a node turns by too much; False if there is none.

        A joint at which all hinges yield turns freely, and a step that follows its tangent far
        beyond where they unload would cut all others short: such nodes are held by a spring, in the
        ratio of the turns to `LARGEST_TURN` stiffer than they are by themselves or, at most, in the
        whole step.
        """
        rows, diagonal = 3 * body.width + 1, 2 * body.width
        energy = abs(dot(work.step, work.residual))
        for i in range(work.x.size):
            turn, at = abs(work.step[i]) / LARGEST_TURN, i * rows + diagonal
            if i % each >= axes and turn > 1.0:
                soft = min(abs(work.kept[at]), energy / work.step[i] ** 2)
                work.kept[at] += (turn - 1.0) * soft
        for i in range(work.x.size):
            work.step[i] = -work.residual[i]
        return solve_band(work.kept, body.width, work.step, work.pivots)

    @inner
    def aim(s):
        """Write Newton's step; False if there is none."""
        body, work = s.body, s.work
        hold(work.band, body.width, body.held, work.x.size)
        copy(work.band, work.kept)
        for i in range(work.x.size):
            work.step[i] = -work.residual[i]
        if not solve_band(work.band, body.width, work.step, work.pivots):
            return False
        for i in range(work.x.size):
            if i % each >= axes and abs(work.step[i]) > LARGEST_TURN:
                return hold_back(body, work)
        return True

    newton = newton_of(Equations(vectors, evaluate, allowed, aim, bend))

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
        start(motion.old, motion.new)
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
        """Finish the trial; root of what flow costs beside the step over the energy brought in.

        It shows where hinges begin to flow, ring, or follow the surface around a bend.
        """
        trial, motion, body = s.motion.energies[1], s.motion, s.body
        trial.stored, trial.plastic, trial.algorithmic, trial.ideal, spent = finish(
            0.5, body.bars, body.hinges, motion.old, motion.new
        )
        return (max(spent, 0.0) / body.energy) ** 0.5

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
        band_product(body.mass, body.width, v0, motion.momentum)
        keep(motion.new, motion.old)
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
        row, sums, motion = records[n], s.motion.energies[0], s.motion
        row.stored, row.plastic, row.algorithmic = sums.stored, sums.plastic, sums.algorithmic
        row.ideal, row.external_work = sums.ideal, sums.external_work
        row.kinetic = 0.5 * dot(motion.v, motion.momentum) + kinetic(s.body.hinges, motion.old)
        copy(motion.x, s.x[n])
        copy(motion.v, s.v[n])
        keep_row(motion.old, s.states, n)

    # forces between striker and bars ring: contacts open at the end of a step, not on their line
    step = contact_step_of(hit, solve, released=False)
    functions = StepFunctions(hit, solve, settle, accept, write, collapsed, step=step)
    return march_of(functions, LONGER, CUT)


class Records(NamedTuple):
    """Several records of an impact: their `table` of RECORD, and committed states.

    Of all records the displacements `x` and velocities `v` (records, dofs) and, of all elements,
    `states`; whether the structure has `collapsed` in the last one; `evaluations` and `cuts` so
    far.
    """

    table: Any
    x: Array
    v: Array
    states: Any
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
    The only group of the `assembly` are bars with `impact` and `own_tables`; both stay as they are,
    so that several threads may follow impacts on them. Yields several records at a time, the first
    one of the start. Raises `SolverError`.
    """
    group: Any = assembly.groups[0]
    springs, (old, new) = assembly.springs, group.states
    state = type(old)
    body = Body(
        group.bars,
        group.own_tables(),
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
        state(*(values.copy() for values in old)),
        state(*(values.copy() for values in new)),
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
        states = state(*(np.empty((rows, *values.shape)) for values in old))
        system = StruckSystem(body, motion, work, limits, x, v, states)
        status, count = group.impact(system, drive, progress, table)
        if count:
            states = state(*(values[:count] for values in states))
            spent = int(progress["evaluations"][0]), int(progress["cuts"][0])
            yield Records(table[:count], x[:count], v[:count], states, status == COLLAPSE, *spent)
    check_end(status, progress[0], pace)
