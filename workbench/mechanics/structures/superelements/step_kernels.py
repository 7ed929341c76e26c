"""The equations of a time step of superelements with a striker, for Newton's method.

A midpoint step solves M (v1 - v0) / dt + f = p + w P / dt with v1 = 2 (x1 - x0) / dt - v0 and
energy-exact forces f; a closed contact eliminates the impulse P. Axial vibrations of the bars are
not resolved: the scheme keeps their energy at any step.
"""

from typing import Any, NamedTuple

from workbench.base.arrays import Array, Indices
from workbench.mechanics.impact.contact import inner
from workbench.mechanics.structures.elements import Step
from workbench.mechanics.structures.kernels import (
    add_inertia,
    allowed_residual,
    band_product,
    copy,
    hold,
    largest,
    solve_band,
)
from workbench.mechanics.structures.superelements.kernels import assemble

LARGEST_TURN = 0.03  # rad of a node in an iteration; beyond it a spring holds it back


class Body(NamedTuple):
    """Body that does not change in a run: the structure and where the striker hits it.

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


@inner
def vectors(s):
    """Displacements at the end of the step, where Newton's step began, that step, the residual."""
    return s.work.x, s.work.start, s.work.step, s.work.residual


@inner
def evaluate(s, dt, closed, touch, striker):
    """Residual and tangent of a step of `dt` (s) that ends at `work.x`; size of the residual.

    A `closed` contact ends the step with the velocity `touch` of the `striker` (kg), before what P
    takes.
    """
    body, motion, work, x = s.body, s.motion, s.work, s.work.x
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
def allowed(s, dt, size):
    """Residual of a solved step, `size` that of the first guess."""
    body, motion = s.body, s.motion
    least = body.tolerance * max(motion.force[0], largest(body.load), 1e-3 * size)
    reach = max(largest(motion.x), body.shortest)
    return allowed_residual(least, s.work.band, body.width, reach)


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
    for i in range(2, work.x.size, 3):  # rotations: a node has u, v and that
        if abs(work.step[i]) > LARGEST_TURN:
            return _hold_back(body, work)
    return True


@inner
def bend(s):
    """Return d'Kd of the step d with the tangent K."""
    band_product(s.work.band, s.body.width, s.work.step, s.work.pull)
    return dot(s.work.step, s.work.pull)


@inner
def dot(a, b):
    """Scalar product."""
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


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
    return solve_band(work.kept, body.width, work.step, work.pivots)
