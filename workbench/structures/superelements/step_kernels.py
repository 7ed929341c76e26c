"""Compiled time steps of superelements with a striker: the equations of `structures/time_steps`.

The midpoint scheme of `structures/impact` in one call per step: M (v1 - v0) / dt + f = p + w P / dt
with v1 = 2 (x1 - x0) / dt - v0 and energy-exact forces f; a closed contact eliminates the
percussion P. A test holds both to each other. What takes a whole body is inlined: a call that
passes all its arrays costs as much as an element.
"""

from typing import Any, NamedTuple

import numpy as np

from workbench.arrays import Array, Indices
from workbench.compiled import njit
from workbench.impact import contact as law
from workbench.structures import kernels
from workbench.structures.elements import Step
from workbench.structures.kernels import add_inertia, copy, largest
from workbench.structures.superelements.kernels import assemble

ITERATIONS, SEARCHES = 25, 8
LARGEST_CUT, SMALLEST_CUT = 0.9, 0.1  # bounds of a regula-falsi factor
CLOSEST = 0.02  # of a bracket, to its ends, that the tangent along a step may lead
LARGEST_TURN = 0.03  # rad of a node in an iteration; beyond it a spring holds it back
FALLEN = 0.1  # of the residual, with which a step is taken whatever its slope
WORK, REPEATS = 1e-9, 3  # of the energy brought in, that a residual may do in a step; tries at that


class Body(NamedTuple):
    """What does not change: the structure and where the striker hits it.

    `bars` and `hinges` of all elements; flat bands of the `mass` with half-bandwidth `width`;
    `held` dofs; dead `load` (dofs,); springs to the ground: `spring_dofs`, and `springs` (s, 2) of
    stiffness and place where unstressed; `shortest` element in m; struck `dof`, the `sign` of the
    strike, mass of the `striker` in kg, its `speed` at first in m/s, `restitution`, `origin` of its
    path in m; `tolerance` of the residual over the largest force.
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
    striker: float
    speed: float
    restitution: float
    origin: float
    tolerance: float


class Motion(NamedTuple):
    """What moves: committed `x`, `v` and momentum M v (dofs,), states of the elements.

    `old` is committed, `new` the trial; `striker` (2,), its position and velocity; mean `rate`
    (dofs,) of the last step, and how it has changed since the one before, `slope`, and is expected
    to change, `trend`, both per time; `lasted` (1,), length of the last step; `force` (1,), the
    largest nodal force so far.
    """

    x: Array
    v: Array
    momentum: Array
    old: Any
    new: Any
    striker: Array
    rate: Array
    slope: Array
    trend: Array
    lasted: Array
    force: Array


class Work(NamedTuple):
    """Scratch of a step: the flat `band` of the tangent, one `kept`, and vectors (dofs,)."""

    band: Array
    kept: Array
    x: Array
    trial: Array
    moved: Array
    given: Array
    internal: Array
    residual: Array
    step: Array
    pull: Array
    pivots: Indices


@njit(cache=True, error_model="numpy")
def evaluate(body, motion, work, dt, closed, touch, x):
    """Residual and tangent of a step of `dt` (s) that ends at displacements `x`.

    A `closed` contact ends the step with the velocity `touch` of the striker, before what P takes.
    """
    factor = 2.0 / (dt * dt)
    for i in range(work.band.size):
        work.band[i] = factor * body.mass[i]
    work.internal[:] = 0.0
    step = Step(work.internal, work.band, motion.x, x, 0.5, True, dt, True)
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
        work.residual[d] -= body.sign * body.striker * (touch - v1) / dt
        work.band[d * rows + diagonal] += factor * body.striker
    return largest(work.residual)


@njit(cache=True, error_model="numpy")
def _dot(a, b):
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@njit(cache=True, error_model="numpy")
def _aim(body, work):
    """Write Newton's step; False if there is none."""
    kernels.hold(work.band, body.width, body.held, work.x.size)
    copy(work.band, work.kept)
    for i in range(work.x.size):
        work.step[i] = -work.residual[i]
    if not kernels.solve_band(work.band, body.width, work.step, work.pivots):
        return False
    for i in range(2, work.x.size, 3):  # rotations: a node has u, v and that
        if abs(work.step[i]) > LARGEST_TURN:
            return _hold_back(body, work)
    return True


@njit(cache=True, error_model="numpy")
def _hold_back(body, work):
    """Write the step anew where a node turns by more than `LARGEST_TURN`; False if there is none.

    A joint at which all hinges yield turns freely, and a step that follows its tangent far beyond
    where they unload would cut all others short: such nodes are held by a spring, in the ratio of
    the turns stiffer than they are by themselves or, at most, in the whole step.
    """
    rows, diagonal = 3 * body.width + 1, 2 * body.width
    energy = abs(_dot(work.step, work.residual))
    for i in range(2, work.x.size, 3):
        turn, at = abs(work.step[i]) / LARGEST_TURN, i * rows + diagonal
        if turn > 1.0:
            soft = min(abs(work.kept[at]), energy / work.step[i] ** 2)
            work.kept[at] += (turn - 1.0) * soft
    for i in range(work.x.size):
        work.step[i] = -work.residual[i]
    return kernels.solve_band(work.kept, body.width, work.step, work.pivots)


@njit(cache=True, error_model="numpy", forceinline=True)
def newton(body, motion, work, dt, closed, touch):
    """Solve a step from `work.x`, as `newton` of `structures/equilibrium` does.

    A step is taken for its residual only where that falls to `FALLEN`: with halves, steps in which
    all hinges of a joint yield take a sixth more evaluations. The line search follows the tangent
    of its last point where that stays inside the bracket: hinges unload at a kink, on whose far
    side the step is steep.
    Result: whether it converged, the residual over the allowed one, number of evaluations.
    """
    size = evaluate(body, motion, work, dt, closed, touch, work.x)
    allowed = kernels.allowed_residual(
        body.tolerance * max(motion.force[0], largest(body.load), 1e-3 * size),
        work.band, body.width, max(largest(motion.x), body.shortest),
    )  # fmt: skip
    evaluations, n = 1, work.x.size
    for _ in range(ITERATIONS):
        if size <= allowed and evaluations > 1:  # where a step starts may be right by chance
            return True, size / allowed, evaluations
        solved = _aim(body, work)
        if not (solved and np.isfinite(size)):
            break
        slope = _dot(work.step, work.residual)
        low, slope_low, high, slope_high = 0.0, slope, np.nan, np.nan
        s, new_size = 1.0, size
        for _search in range(SEARCHES):
            for i in range(n):
                work.trial[i] = work.x[i] + s * work.step[i]
            new_size = evaluate(body, motion, work, dt, closed, touch, work.trial)
            evaluations += 1
            new_slope = _dot(work.step, work.residual)
            if abs(new_slope) <= 0.5 * abs(slope) or new_size <= FALLEN * size:
                break
            finite = np.isfinite(new_slope)
            if finite and new_slope * slope > 0.0 and np.isnan(high):
                break  # no sign change in reach: take the step, the tangent will follow
            if not finite or new_slope * slope <= 0.0:
                high, slope_high = s, new_slope
            else:
                low, slope_low = s, new_slope
            kernels.band_product(work.band, body.width, work.step, work.pull)
            bend = _dot(work.step, work.pull)
            share = (s - new_slope / bend - low) / (high - low)
            if not CLOSEST < share < 1.0 - CLOSEST:
                share = 0.5
                if np.isfinite(slope_high):
                    share = slope_low / (slope_low - slope_high)
                    share = min(max(share, SMALLEST_CUT), LARGEST_CUT)
            s = low + share * (high - low)
        copy(work.trial, work.x)
        size = new_size
    return size <= kernels.STALLED * allowed, size / allowed, evaluations


@njit(cache=True, error_model="numpy")
def gap_of(body, motion):
    """Distance (m) from the striker to the struck dof, and its rate (m/s)."""
    gap = body.sign * motion.x[body.dof] - body.origin - motion.striker[0]
    return gap, body.sign * motion.v[body.dof] - motion.striker[1]


@njit(cache=True, error_model="numpy", forceinline=True)
def solve(body, motion, work, dt):
    """Solve a step with the right state of contact; the end stands in `work.x`.

    Result: whether that was possible, the percussion in N s, residual over the allowed one and
    number of evaluations.
    """
    gap, gamma = gap_of(body, motion)
    eps = law.rebound(gamma, body.restitution)
    touch = motion.striker[1] - eps * gamma
    may, refused, d = gap + dt * min(gamma, 0.0) <= 0.0, False, body.dof
    allowed = WORK * 0.5 * body.striker * body.speed**2
    closed, evaluations, residual = may and not gamma > 0.0, 0, 0.0
    for i in range(work.given.size):
        work.given[i] = 2.0 / dt * motion.momentum[i] + body.load[i]
    for _ in range(2 if may else 1):
        for i in range(work.x.size):
            ahead = motion.rate[i] + 0.5 * (dt + motion.lasted[0]) * motion.trend[i]
            work.x[i] = motion.x[i] + dt * ahead
        copy(motion.old.carried, motion.new.carried)
        for _again in range(REPEATS):
            done, residual, spent = newton(body, motion, work, dt, closed, touch)
            evaluations += spent
            if not done or abs(_dot(work.residual, work.moved)) <= allowed:
                break
        if done:
            end = body.sign * (2.0 * (work.x[d] - motion.x[d]) / dt - motion.v[d])
            percussion = body.striker * (touch - end) if closed else 0.0
            fits = percussion >= 0.0 if closed else end - motion.striker[1] + eps * gamma >= 0.0
            # a closed contact that pulls must open, whatever the open solution says of velocities
            if fits or not may or (refused and not closed):
                return True, percussion, residual, evaluations
            refused = True
        closed = not closed
    return False, 0.0, residual, evaluations


@njit(cache=True, error_model="numpy")
def commit(body, motion, work, dt, percussion, energies, record):
    """Commit the solved step and add what it has spent to a `record` of RECORD."""
    x0, v0, n = motion.x, motion.v, work.x.size
    gamma = body.sign * v0[body.dof] - motion.striker[1]
    stored, plastic, algorithmic, ideal, _ = energies
    for i in range(n):
        moved = work.x[i] - x0[i]
        slope = 2.0 * (moved / dt - motion.rate[i]) / (dt + motion.lasted[0])
        # of two that differ in sign none, else the smaller one: what rings is not extrapolated
        same = slope * motion.slope[i] > 0.0
        motion.trend[i] = min(abs(slope), abs(motion.slope[i])) if same else 0.0
        if slope < 0.0:
            motion.trend[i] *= -1.0
        motion.slope[i], motion.rate[i] = slope, moved / dt
        record.external_work += body.load[i] * moved
        v0[i] = 2.0 * moved / dt - v0[i]
        x0[i] = work.x[i]
    for h in body.held:
        v0[h] = 0.0
    for k in range(body.spring_dofs.size):
        stored += 0.5 * body.springs[k, 0] * (x0[body.spring_dofs[k]] - body.springs[k, 1]) ** 2
    kernels.band_product(body.mass, body.width, v0, motion.momentum)
    record.kinetic = 0.5 * _dot(v0, motion.momentum)
    for e in range(body.hinges.rotary.size):
        record.kinetic += 0.5 * body.hinges.rotary[e] * motion.new.rate[e] ** 2
    copy(motion.new.plastic, motion.old.plastic)
    copy(motion.new.carried, motion.old.carried)
    copy(motion.new.local, motion.old.local)
    copy(motion.new.deformation, motion.old.deformation)
    copy(motion.new.rate, motion.old.rate)
    motion.lasted[0] = dt
    motion.force[0] = max(motion.force[0], largest(work.internal))
    before = motion.striker[1]
    motion.striker[1] = before - percussion / body.striker
    motion.striker[0] += 0.5 * dt * (before + motion.striker[1])
    departure = body.sign * v0[body.dof] - motion.striker[1]
    record.contact_loss += law.contact_loss(percussion, gamma, departure)
    record.impulse += percussion
    record.stored = stored
    record.plastic += plastic
    record.algorithmic += algorithmic
    record.ideal += ideal
    record.length += dt
    record.striker_position, record.striker_velocity = motion.striker[0], motion.striker[1]
