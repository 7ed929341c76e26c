"""The equations of a midpoint step of the column (Heng 2017, chapter 3), and their solution.

And where the column lies at rest before, under a weight.
"""

from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit
from workbench.mechanics.impact.contact import inner
from workbench.mechanics.impact.newton import Equations, newton_of
from workbench.mechanics.impact.pace import EPS
from workbench.mechanics.structures.kernels import copy, solve_four
from workbench.models.four_dof import kinematics as geometry
from workbench.models.four_dof import statics
from workbench.models.four_dof.kinematics import ABOVE, BELOW, BETA, U1, U2, V
from workbench.steel.hinges.kernels import ELASTIC

_TRIES, _WEIGHED = 100, 1e-10  # at rest under a weight; share of that which is left
_TOLERANCE = 1e-8  # of the squash load: the error of a step is far larger


class TwoBars(NamedTuple):
    """System: column (1,), committed and trial state (2,), scratch (1,); records of `statics`."""

    columns: Any
    states: Any
    room: Any


@njit(cache=True, error_model="numpy")
def mean_forces(column, state, work):
    """Energy-consistent mean forces of a step: averaged stresses, discrete gradients."""
    lengths, a, b = column.lengths, work.stress0, state.stress
    for bar in range(2):
        N = 0.5 * (a[bar, 0] + b[bar, 0])
        M = 0.5 * (a[bar, 1] + b[bar, 1] - a[bar, 2] - b[bar, 2])
        v0, x0, _ = geometry.place(work.q0, lengths, bar)
        v1, x1, _ = geometry.place(state.q, lengths, bar)
        small = column.small_rotations
        ev, ex, pv, px = geometry.step_gradients(v0, x0, v1, x1, lengths[bar], small)
        work.f[bar, 0], work.f[bar, 1] = N * ev + M * pv, N * ex + M * px
    statics.add_up(column, work.f, 0.5 * (work.q0[U2] + state.q[U2]), work.mean)


@njit(cache=True, error_model="numpy")
def evaluate(s, dt, closed, touch, striker):
    """Residual `R` (impulses) and tangent `J` of a midpoint step; the scaled size of the residual.

    With (3.31) to (3.33) w = 2 (q - q_0) / dt - w_0 and m (w - w_0) + dt F_mean = P for a massive
    unknown, F(q) = 0 for a massless one.
    """
    column, state, work = s.columns[0], s.states[1], s.room[0]
    q, F, K, R, J, work.dt = state.q, work.F, work.K, work.R, work.J, dt
    for i in range(4):
        q[i] = work.q0[i] + work.moved[i]
    if work.nested:
        statics.balance_rotation(column, state, work)
        work.moved[BETA] = q[BETA] - work.q0[BETA]
    else:
        statics.internal_forces(column, state, work)
    mean_forces(column, state, work)
    for i in range(4):
        m = column.mass[i]
        for k in range(4):
            J[i, k] = (0.5 * dt if m > 0.0 else dt) * K[i, k]
        if m > 0.0:
            R[i] = 2.0 * m * (work.moved[i] / dt - work.w0[i]) + dt * work.mean[i]
            J[i, i] += 2.0 * m / dt
        else:
            R[i] = dt * F[i]
    if closed:
        end = 2.0 * work.moved[V] / dt - work.w0[V]
        R[V] += striker * (end - touch)
        J[V, V] += 2.0 * striker / dt
    if not column.free_head:
        R[U2] = 0.0
        statics.hold(J, U2)
    if statics.rotation_is_free(column, K):
        statics.hold(J, BETA)
        if work.nested:
            R[BETA] = 0.0
    axial = max(abs(R[V]), max(abs(R[U1]), abs(R[U2]))) / (dt * column.squash_loads[0])
    return max(axial, abs(R[BETA]) / (dt * column.plastic_moments[0]))


@njit(cache=True, error_model="numpy")
def predict(s, dt, closed, touch, striker):
    """First guess of a step: forces grow along the last tangent, bars stretch as linearised.

    That the chords turn about their ends is taken into account.
    """
    column, work = s.columns[0], s.room[0]
    q0, w0, moved, step, J = work.q0, work.w0, work.moved, work.step, work.J
    moved[:] = 0.0
    for i in range(4):
        m = column.mass[i] + (striker if closed and i == V else 0.0)
        for k in range(4):
            J[i, k] = 0.5 * dt * work.K0[i, k] if m > 0.0 else work.K0[i, k]
        J[i, i] += 2.0 * m / dt
        step[i] = 2.0 * m * w0[i] - (dt * work.F0[i] if m > 0.0 else work.F0[i])
    if closed:
        step[V] -= striker * (w0[V] - touch)
    if not column.free_head:
        step[U2] = 0.0
        statics.hold(J, U2)
    if statics.rotation_is_free(column, work.K0):
        step[BETA] = dt * work.rate[BETA]
        statics.hold(J, BETA)
    if not solve_four(J, step):
        return
    copy(step, moved)
    if not column.free_head or column.small_rotations:
        return
    for bar, i in ((BELOW, U1), (ABOVE, U2)):  # each end moves along as its bar stretches
        v, x, _ = geometry.place(q0, column.lengths, bar)
        dx = step[U1] if bar == BELOW else step[U2] - step[U1]
        chord = (v * v + x * x) ** 0.5
        chord += (v * step[V] + x * dx) / chord
        along = max(chord * chord - (v + step[V]) ** 2, 0.0) ** 0.5 - x
        moved[i] = along if bar == BELOW else moved[U1] + along


@inner
def vectors(s):
    """Displacements of the step, where Newton's step began, that step, the residual.

    Not places: in very short steps their round-off would be that of velocities.
    """
    return s.room[0].moved, s.room[0].old, s.room[0].step, s.room[0].R


@inner
def allowed(s, dt, size):
    """Residual of a solved step: 1e-8, or what the round-off of velocities leaves in short ones."""
    work, column = s.room[0], s.columns[0]
    velocity = abs(work.w0[V]) + 2.0 * abs(work.moved[V]) / dt
    rounded = 8.0 * EPS * work.strike_mass * velocity / (dt * column.squash_loads[0])
    return max(_TOLERANCE, rounded)


@inner
def aim(s):
    """Newton's step."""
    for i in range(4):
        s.room[0].step[i] = -s.room[0].R[i]
    return solve_four(s.room[0].J, s.room[0].step)


@inner
def bend(s):
    """Return d'Kd of the step d with the tangent K."""
    total = 0.0
    for i in range(4):
        for k in range(4):
            total += s.room[0].step[i] * s.room[0].J[i, k] * s.room[0].step[k]
    return total


def along_tangent(bars: Any) -> bool:
    """Whether the last step of Newton may be taken without an evaluation.

    Not of panels that know no time, nor where what has flowed is counted.
    """
    if "law" in bars.dtype.names:
        return not any(bars["law"][body]["hardening"] for body in ("whole", "web"))
    return not bars["sliding"]


@njit(cache=True, error_model="numpy")
def finish(s, size):
    """Take the last Newton step with forces along the tangent, not evaluated anew.

    Those of an elastic bar are exact: along the tangent it would seem to flow by a round-off.
    """
    column, state, work = s.columns[0], s.states[1], s.room[0]
    if size > work.finish_below or not aim(s):
        return False
    step, D, elastic = work.step, work.D, column.stiffness
    for i in range(4):
        work.moved[i] += step[i]
        state.q[i] = work.q0[i] + work.moved[i]
        for k in range(4):
            work.F[i] += work.K[i, k] * step[k]
    for bar in range(2):
        plastic, stress = state.plastic[bar], state.stress[bar]
        if work.branch[bar] == ELASTIC and not column.sliding:
            v, x, b = geometry.place(state.q, column.lengths, bar)
            length, small = column.lengths[bar], column.small_rotations
            stretch, angle = geometry.stretch_and_angle(v, x, length, small)
            stress[0] = elastic[bar, 0] * (stretch - plastic[0])
            stress[1] = elastic[bar, 1] * (angle - plastic[1])
            stress[2] = elastic[bar, 2] * (b - angle - plastic[2])
            continue
        sign = 1.0 if bar == BELOW else -1.0
        dx = step[U1] if bar == BELOW else step[U2] - step[U1]
        for j in range(3):
            stress[j] += D[bar, j, 0] * step[V] + D[bar, j, 1] * dx
            stress[j] += sign * D[bar, j, 2] * step[BETA]
        stress[3] = (stress[1] - stress[2]) / column.lengths[bar]  # of panels
    return True


newton = newton_of(Equations(vectors, evaluate, allowed, aim, bend, finish))


def lie(still: Any, q: Array, weight: float, bars: Any, states: Any) -> bool:
    """Lay a column down under a `weight` (N) at its hit point; what springs at the head bear stays.

    Arguments: tables of one column that knows no rate, `still`, with its state `q` (1, 4), and of
    its `bars`; their `states`. Writes weight and state of rest; whether there is one.
    """
    still["load"] += still["spring"] * (q[0, U2] - still["unstressed"])
    still["free_head"], still["spring"] = True, 0.0
    work, records = np.zeros(1, statics.WORK)[0], np.zeros(2, statics.STATE)
    records["q"][0], at = q[0], np.array([1e-6 * still["lengths"].sum()])
    for _ in range(_TRIES):  # forces grow nearly in proportion
        statics.pushover(still[0], at, -np.inf, records, work)
        rest, force = records[1], float(records[1]["force"])
        if abs(force - weight) <= _WEIGHED * abs(weight):
            break
        at *= weight / force
    else:
        return False
    for name in ("q", "stress"):
        states[0][name] = rest[name]
    states[0]["plastic"][:, :4] = rest["plastic"]
    bars["weight"], bars["sag"] = weight, rest["q"][V]
    bars["unstressed"] += rest["q"][U2] - q[0, U2]
    return True
