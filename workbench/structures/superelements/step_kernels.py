"""The equations of a time step of superelements with a striker, and Newton's method for them.

A midpoint step solves M (v1 - v0) / dt + f = p + w P / dt with v1 = 2 (x1 - x0) / dt - v0 and
energy-exact forces f; a closed contact eliminates the impulse P. Axial vibrations of the bars are
not resolved: the scheme keeps their energy at any step.
"""

from typing import Any, NamedTuple

import numpy as np

from workbench.arrays import Array, Indices
from workbench.impact.contact import called, inner
from workbench.structures import kernels
from workbench.structures.elements import Step
from workbench.structures.kernels import add_inertia, copy, largest
from workbench.structures.superelements.kernels import assemble

ITERATIONS, SEARCHES = 25, 8
LARGEST_CUT, SMALLEST_CUT = 0.9, 0.1  # bounds of a regula-falsi factor
CLOSEST = 0.02  # of a bracket, to its ends, that the tangent along a step may lead
LARGEST_TURN = 0.03  # rad of a node in an iteration; beyond it a spring holds it back
FALLEN = 0.1  # of the residual, with which a step is taken whatever its slope


class Body(NamedTuple):
    """What does not change: the structure and where the striker hits it.

    `bars` and `hinges` of all elements; flat bands of the `mass` with half-bandwidth `width`;
    `held` dofs; dead `load` (dofs,); springs to the ground: `spring_dofs`, and `springs` (s, 2) of
    stiffness and place where unstressed; `shortest` element in m; struck `dof`, the `sign` of the
    strike, `origin` of its path in m; `energy` of the striker at first in J; `tolerance` of the
    residual over the largest force.
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
    """What moves: committed `x`, `v` and momentum M v (dofs,), states of the elements.

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
    trial: Array
    moved: Array
    given: Array
    internal: Array
    residual: Array
    step: Array
    pull: Array
    pivots: Indices


@called
def evaluate(body, motion, work, dt, closed, touch, striker, x):
    """Residual and tangent of a step of `dt` (s) that ends at displacements `x`.

    A `closed` contact ends the step with the velocity `touch` of the `striker` (kg), before what P
    takes.
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
        work.residual[d] -= body.sign * striker * (touch - v1) / dt
        work.band[d * rows + diagonal] += factor * striker
    return largest(work.residual)


@inner
def dot(a, b):
    """Scalar product."""
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@inner
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


@inner
def _hold_back(body, work):
    """Write the step anew where a node turns by more than `LARGEST_TURN`; False if there is none.

    A joint at which all hinges yield turns freely, and a step that follows its tangent far beyond
    where they unload would cut all others short: such nodes are held by a spring, in the ratio of
    the turns stiffer than they are by themselves or, at most, in the whole step.
    """
    rows, diagonal = 3 * body.width + 1, 2 * body.width
    energy = abs(dot(work.step, work.residual))
    for i in range(2, work.x.size, 3):
        turn, at = abs(work.step[i]) / LARGEST_TURN, i * rows + diagonal
        if turn > 1.0:
            soft = min(abs(work.kept[at]), energy / work.step[i] ** 2)
            work.kept[at] += (turn - 1.0) * soft
    for i in range(work.x.size):
        work.step[i] = -work.residual[i]
    return kernels.solve_band(work.kept, body.width, work.step, work.pivots)


@inner
def newton(body, motion, work, dt, closed, touch, striker):
    """Solve a step from `work.x`, as `newton` of `structures/equilibrium` does.

    A step is taken for its residual only where that falls to `FALLEN`: with halves, steps in which
    all hinges of a joint yield take a sixth more evaluations. The line search follows the tangent
    of its last point where that stays inside the bracket: hinges unload at a kink, on whose far
    side the step is steep.
    Result: whether it converged, the residual over the allowed one, number of evaluations.
    """
    size = evaluate(body, motion, work, dt, closed, touch, striker, work.x)
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
        slope = dot(work.step, work.residual)
        low, slope_low, high, slope_high = 0.0, slope, np.nan, np.nan
        s, new_size = 1.0, size
        for _search in range(SEARCHES):
            for i in range(n):
                work.trial[i] = work.x[i] + s * work.step[i]
            new_size = evaluate(body, motion, work, dt, closed, touch, striker, work.trial)
            evaluations += 1
            new_slope = dot(work.step, work.residual)
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
            bend = dot(work.step, work.pull)
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
