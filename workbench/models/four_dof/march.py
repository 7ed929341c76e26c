"""A midpoint step of the impacted column: its equations, their solution, the march (Heng 2017, 3).

`solve` predicts and takes Newton steps on `evaluate`, `accept` commits; `advance` is the march of
the impact integrator over them, `lie` the column at rest under a weight.

The impact mass m1 moves with v1 and u1, the head mass m2 (may be zero) with u2; beta1 is massless.
Steps hold the error of the displacement, see `impact.pace`; and hinges that flow, whose
forces are those at the end of a step (backward Euler), may flow by no more than `flow` times their
elastic deformation at yielding. Axial vibrations of the masses are not resolved: the midpoint rule
keeps their energy at any step.
"""

from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit, register_jitable
from workbench.mechanics.frames.collapse import COLLAPSE_CONTRACTION, COLLAPSE_SIDEWAYS
from workbench.mechanics.impact.contact import called, inner
from workbench.mechanics.impact.integrator import (
    COLLAPSE,
    COMMON,
    DONE,
    PROGRESS,
    StepFunctions,
    begin,
    march_of,
    standstill,
)
from workbench.mechanics.impact.newton import Equations, newton_of
from workbench.mechanics.impact.pace import EPS
from workbench.mechanics.structures.kernels import copy, solve_four
from workbench.models.batch import COLLAPSES, UNKNOWN
from workbench.models.four_dof import kinematics as geometry
from workbench.models.four_dof import statics
from workbench.models.four_dof.kinematics import ABOVE, BELOW, BETA, U1, U2, V
from workbench.models.four_dof.statics import STATE, WORK
from workbench.responses.histories import FORCE_WINDOW, open_share, unbalanced
from workbench.responses.kernels import largest_window, mean_of_cycles, signed_peak
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
    step, J, total = s.room[0].step, s.room[0].J, 0.0
    for i in range(step.size):
        for k in range(step.size):
            total += step[i] * J[i, k] * step[k]
    return total


def along_tangent(bars: Any) -> bool:
    """Whether the last step of Newton may be taken without an evaluation.

    Not of panels that know no time, nor where what has flowed is counted.
    """
    if "law" in bars.dtype.names:
        return not any(bars["law"][body]["hardening"] for body in ("whole", "web"))
    return "sliding" not in bars.dtype.names or not bars["sliding"]


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
    """Lay a column down under a `weight` (N) at its impact point; head springs keep their force.

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


# bar and place of the hinges from base to head
HINGES = ((0, 1), (0, 2), (1, 2), (1, 1))
SCALARS = (
    *("peak_displacement", "time_of_peak", "residual_displacement", "peak_force", "impulse"),
    *("largest_plastic_rotation", "largest_compression", "largest_tension", "largest_sliding"),
)
_unbalanced, _open_share = register_jitable(unbalanced), register_jitable(open_share)
# residual over the squash load that one more Newton step removes: of controlled, of equal steps
NEARLY, CLOSELY = 2e-5, 1e-6
RECORD = np.dtype(
    [
        *((name, float) for name in (*COMMON, "force", "elastic", "dissipated")),
        *(("q", float, 4), ("stress", float, (2, 4)), ("plastic", float, (2, 4))),
    ]
)


@inner
def hit(s):
    """Displacement v1 and its velocity."""
    return s.states[0].q[V] - s.columns[0].sag, s.states[0].w[V]


@called
def solve(s, dt, closed, touch, striker):
    """A midpoint step; where Newton fails, again with the rotation balanced inside."""
    statics.assign(s.states[0], s.states[1])
    now, work = s.states[0], s.room[0]
    copy(now.q, work.q0)
    copy(now.w, work.w0)
    copy(now.stress, work.stress0)
    work.strike_mass = 2.0 * s.columns[0].mass[V] + s.columns[0].mass[U2] + striker
    done, residual, total = False, np.inf, 0
    for nested in range(2):
        work.nested = nested
        predict(s, dt, closed, touch, striker)
        done, residual, count = newton(s, dt, closed, touch, striker)
        total += count
        if done:
            break
    trial = s.states[1]
    for i in range(4):
        trial.w[i] = 2.0 * work.moved[i] / dt - work.w0[i]
    return done, trial.w[V], residual, total


@called
def settle(s, dt):
    """Plastic flow; the largest one of a hinge over its elastic deformation at yielding.

    Plastic shear of webs has no bound of its own: the hinges that turn with it have.
    """
    column, start, end = s.columns[0], s.states[0], s.states[1]
    statics.update_plastic_deformations(column, s.room[0].stress0, end, s.room[0])
    most = 0.0
    for bar in range(2):
        for j in range(3):
            strength = column.squash_loads[0] if j == 0 else column.plastic_moments[0]
            flow = abs(end.plastic[bar, j] - start.plastic[bar, j])
            most = max(most, flow * column.stiffness[bar, j] / strength)
    return most


@called
def accept(s, dt):
    """Commit the trial, and what the next first guess starts from."""
    now, trial, work = s.states[0], s.states[1], s.room[0]
    for i in range(4):
        work.rate[i] = (trial.q[i] - now.q[i]) / dt
    statics.assign(s.states[1], s.states[0])
    at_place(s)


@called
def at_place(s):
    """Forces and energy of the committed state, which was evaluated last."""
    copy(s.room[0].F, s.room[0].F0)
    copy(s.room[0].K, s.room[0].K0)
    s.states[0].force = s.room[0].F[V]
    statics.store(s.columns[0], s.states[0])


@called
def write(s, records, n):
    """Places, forces, plastic deformations, energies."""
    row, now, m = records[n], s.states[0], s.columns[0].mass
    copy(now.q, row.q)
    copy(now.stress, row.stress)
    for at in np.ndindex(row.plastic.shape):
        row.plastic[at] = now.plastic[at]
    row.force, row.elastic, row.dissipated, row.kinetic = (
        now.force,
        now.elastic,
        now.dissipated,
        0.0,
    )
    row.external_work = s.columns[0].weight * now.q[V] - s.columns[0].load * now.q[U2]
    for i in (V, U1, U2):
        row.kinetic += 0.5 * m[i] * now.w[i] ** 2 if i != U2 or s.columns[0].free_head else 0.0


@njit(cache=True, error_model="numpy")
def chords(lengths, q):
    """Distances that are left between the ends of both bars, in m."""
    below = (q[V] ** 2 + (lengths[0] + q[U1]) ** 2) ** 0.5
    above = (q[V] ** 2 + (lengths[1] + q[U2] - q[U1]) ** 2) ** 0.5
    return below, above


@inner
def lost(s):
    """Whether v1 passes nine tenths of a bar, or the bars are squashed by a tenth.

    The length of a bar is its first one, or the distance left between its ends if that is shorter.
    """
    lengths, q = s.columns[0].lengths, s.states[0].q
    below, above = chords(lengths, q)
    shorter = min(min(lengths[0], lengths[1]), min(below, above))
    squashed = below + above < (1.0 - COLLAPSE_CONTRACTION) * (lengths[0] + lengths[1])
    return squashed or abs(q[V]) > COLLAPSE_SIDEWAYS * shorter


@inner
def mass_of(s):
    """The impact mass; in equal steps none, the striker is met within a step as in the thesis."""
    return s.room[0].collision_mass


@inner
def apply_impulse(s, dv):
    """Change the velocity of the impact point."""
    s.states[0].w[V] += dv


_march = march_of(
    StepFunctions(
        hit, solve, settle, accept, write, lost, mass=mass_of, apply_impulse=apply_impulse
    )
)


@called
def start(columns, states, room, pace):
    """The system before the hit: the preloaded column in the first of the `states`."""
    s = TwoBars(columns, states, room)
    statics.internal_forces(s.columns[0], s.states[0], s.room[0])
    at_place(s)
    s.room[0].collision_mass = s.columns[0].mass[V] if pace.error < np.inf else 0.0
    return s


@njit(cache=True, error_model="numpy")
def impact(columns, states, room, drive, progress, records):
    """Follow an impact: (status, rows).

    Arguments: `columns` (1,) of COLUMN, `states` (2,) of STATE, `room` (1,) of WORK, see `statics`;
    `drive`, `progress` and `records` of `workbench.mechanics.impact`.
    """
    pace = begin(drive, progress[0])
    return _march(start(columns, states, room, pace), pace, progress[0], records)


@njit(cache=True, error_model="numpy")
def turned(column, records):
    """Plastic rotations (4, n) of the hinges, from base to head; of sliding bars against chords."""
    turns = np.empty((4, records.size))
    for n in range(records.size):
        for k, (bar, place) in enumerate(HINGES):
            flow = records[n].plastic[bar]
            turns[k, n] = flow[place]
            if column.sliding:
                share = flow[3] / column.lengths[bar]
                turns[k, n] -= share if place == 1 else -share
    return turns


@njit(cache=True, error_model="numpy")
def read(column, records, progress, given, bounces, numbers):
    """Write the `numbers` of an impact, as SCALARS has them; returns how far its ledger is open.

    Arguments: the energy `given` (J); whether the striker `bounces`.
    """
    numbers[5] = np.abs(turned(column, records)).max()
    for n in range(records.size):
        for bar in range(2 if column.sliding else 0):
            slid = abs(records[n].plastic[bar, 3])
            numbers[8] = max(numbers[8], slid) if n > 0 or bar else 0.0
    return read_hit(records, progress, given, bounces, numbers)


@njit(cache=True, error_model="numpy")
def read_hit(records, progress, given, bounces, numbers):
    """Write what all columns of two bars have: the first five, and axial forces; as `read`."""
    time, v, percussion = records["time"], records["displacement"], records["percussion"]
    numbers[0], numbers[1] = standstill(records, progress, bounces)
    if not np.isnan(numbers[0]) and not percussion[-1] > 0.0:
        numbers[2] = mean_of_cycles(time, v)
    numbers[3] = largest_window(time[1:], percussion[1:], FORCE_WINDOW) / FORCE_WINDOW
    numbers[4] = percussion.sum()
    numbers[6] = numbers[7] = 0.0
    balance, start = np.empty(records.size), records[0]
    for n in range(records.size):
        row = records[n]
        for bar in range(2):
            numbers[6] = max(numbers[6], -row.stress[bar, 0])
            numbers[7] = max(numbers[7], row.stress[bar, 0])
        brought = given + row.external_work - start.external_work
        gained = row.elastic - start.elastic
        balance[n] = _unbalanced(brought, row.kinetic, gained, row.dissipated, row.contact_loss)
    return _open_share(balance, given, start.elastic)


@njit(cache=True, error_model="numpy", nogil=True)
def impacts(columns, q, drives, given, nearly, which, codes, numbers, errors):
    """Follow impacts on the columns `which` of a table: writes their `codes`, numbers and `errors`.

    Numbers (n, SCALARS); of one that collapses q and the time (s). Arguments: preloaded states `q`
    (n, 4); `drives` (n, DRIVE); energies `given` (n,) in J; `nearly`, the residual that one more
    Newton step removes; open shares of the ledgers, `errors`.
    """
    records = np.empty(1024, RECORD)
    for i in which:
        states, room, progress = np.zeros(2, STATE), np.zeros(1, WORK), np.zeros(1, PROGRESS)
        copy(q[i], states[0].q)
        room[0].finish_below = nearly
        needed = 2 * int(np.ceil(drives[i, 0] / drives[i, 6])) + 4
        if records.size < needed:
            records = np.empty(needed, RECORD)
        one = columns[i : i + 1]
        status, n = impact(one, states, room, drives[i], progress, records[:needed])
        if status == COLLAPSE:
            codes[i], row = COLLAPSES, records[n - 1]
            copy(row.q, numbers[i, :4])
            numbers[i, 4] = row.time
        elif status == DONE:
            bounces = drives[i, 10] > 0.0
            errors[i] = read(columns[i], records[:n], progress[0], given[i], bounces, numbers[i])
            time, v = records["time"][:n], records["displacement"][:n]
            if np.isnan(numbers[i, 0]) and not signed_peak(time, v)[2]:
                codes[i] = UNKNOWN
        else:
            codes[i] = UNKNOWN
