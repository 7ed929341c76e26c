"""The equations of a midpoint step of the column in space, their solution, its march.

As `four_dof.march`, with hinges and kinematics of `kinematics`; masses move along all axes. b is in
equilibrium at the end of a step, a head without mass in the mean of it: energy is then exact.

A face with friction holds the impact point sideways (the striker keeps its line) with an impulse of
at most mu times that along the hit: a step is solved sticking, and sliding where that needs more.
"""

from typing import Any, NamedTuple

import numpy as np

from workbench.base.compiled import njit
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
)
from workbench.mechanics.impact.newton import Equations, newton_of
from workbench.mechanics.impact.pace import EPS
from workbench.mechanics.structures.kernels import copy, solve_dense
from workbench.models.batch import COLLAPSES, UNKNOWN
from workbench.models.four_dof.march import HINGES, bend, mass_of, read_hit, vectors
from workbench.models.four_dof.statics import hold
from workbench.models.seven_dof.kinematics import (
    ABOVE,
    BELOW,
    BN,
    BT,
    HEAD,
    PLACES,
    SIGNS,
    STATE,
    TWIST,
    WORK,
    N,
    T,
    U,
    chord,
    deformations,
    internal_forces,
    mean_forces,
    place,
)
from workbench.responses.kernels import signed_peak
from workbench.steel.hinges.biaxial_kernels import (
    ELASTIC,
    ROOM,
    factorise,
    substitute,
)

STICKS = 2
_TOLERANCE = 1e-10  # of the squash load
_HELD = 1e-7  # of the stiffness at the impact point: holds a rotation between hinges that flow
_FARTHEST = 0.03  # step of Newton, rad and of a quarter of the column
_TRIES = 100  # at rest under a weight


class SpaceColumn(NamedTuple):
    """Column (1,), committed and trial state (2,), scratch (1,), hinges of both bars (2,)."""

    columns: Any
    states: Any
    room: Any
    hinges: Any


@njit(cache=True, error_model="numpy")
def evaluate(s, dt, closed, touch, striker):
    """Residual `R` (impulses) and tangent `J` of a midpoint step; the scaled size of the residual.

    m (w - w_0) + dt F_mean = P with w = 2 (q - q_0) / dt - w_0; of the rotation b, F(q) = 0.
    """
    column, state, work = s.columns[0], s.states[1], s.room[0]
    q, K, R, J = state.q, work.K, work.R, work.J
    for i in range(7):
        q[i] = work.q0[i] + work.moved[i]
    if not internal_forces(column, state, work, s.hinges):
        R[N] = np.nan
        return np.inf
    mean_forces(column, state, work)
    for i in range(7):
        m = column.mass[i]
        for k in range(7):
            J[i, k] = 0.5 * dt * K[i, k]
        J[i, i] += 2.0 * m / dt
        R[i] = 0.5 * dt * work.F[i]
        if i != BN and i != BT:
            R[i] = 2.0 * m * (work.moved[i] / dt - work.w0[i]) + dt * work.mean[i]
    held = 0.5 * dt * _HELD * column.stiffness[BELOW, 3, 3] * column.strength[3] ** 2
    J[BN, BN] += held
    J[BT, BT] += held
    if closed:
        end = 2.0 * work.moved[N] / dt - work.w0[N]
        R[N] += striker * (end - touch)
        J[N, N] += 2.0 * striker / dt
        if work.sideways == STICKS:
            work.push = R[T]
            R[T] = 0.0
            hold(J, T)
        elif work.sideways != 0:
            share = work.sideways * column.friction * striker
            work.push = share * (end - touch)
            R[T] -= work.push
            J[T, N] -= 2.0 * share / dt
    if not column.free_head:
        R[HEAD] = 0.0
        hold(J, HEAD)
    forces = max(max(abs(R[N]), abs(R[T])), max(abs(R[U]), abs(R[HEAD]))) / column.strength[0]
    moments = max(abs(R[TWIST]), max(abs(R[BN]), abs(R[BT]))) / column.strength[3]
    return max(forces, moments) / dt


@njit(cache=True, error_model="numpy")
def solved(A, b, symmetric):
    """Solve seven equations in place."""
    if symmetric and factorise(A, 7):
        substitute(A, b, 7)
        return True
    if symmetric:
        for i in range(7):
            for k in range(i):  # the diagonal is lost as well: this system has no step
                A[i, k] = A[k, i]
        return False
    return solve_dense(A, b)


@njit(cache=True, error_model="numpy")
def shorten(lengths, step):
    """Shorten a step of Newton that goes too far."""
    farthest, quarter = 0.0, 0.25 * (lengths[BELOW] + lengths[ABOVE])
    for i in range(7):
        turns = i in (BN, BT, TWIST)
        farthest = max(farthest, abs(step[i]) / (1.0 if turns else quarter))
    if farthest > _FARTHEST:
        for i in range(7):
            step[i] *= _FARTHEST / farthest


@njit(cache=True, error_model="numpy")
def predict(s, dt, closed, touch, striker):
    """First guess of a step: forces grow along the last tangent, bars stretch as linearised.

    That the chords turn about their ends is taken into account.
    """
    column, work = s.columns[0], s.room[0]
    q0, w0, moved, step, J = work.q0, work.w0, work.moved, work.step, work.J
    held = _HELD * column.stiffness[BELOW, 3, 3] * column.strength[3] ** 2
    for i in range(7):
        m = column.mass[i] + (striker if closed and i == N else 0.0)
        for k in range(7):
            J[i, k] = 0.5 * dt * work.K0[i, k]
        J[i, i] += 2.0 * m / dt
        step[i] = 2.0 * m * w0[i] - (0.5 * dt if i in (BN, BT) else dt) * work.F0[i]
        moved[i] = 0.0
    for i in (BN, BT):
        J[i, i] += 0.5 * dt * held
        step[i] += 0.5 * dt * held * dt * work.rate[i]
    if closed:
        step[N] -= striker * (w0[N] - touch)
    if not column.free_head:
        step[HEAD] = 0.0
        hold(J, HEAD)
    if not solved(J, step, True):
        for i in range(7):
            step[i] = dt * w0[i] if column.mass[i] > 0.0 else dt * work.rate[i]
    if closed and work.sideways == STICKS:
        step[T] = 0.5 * dt * w0[T]
    copy(step, moved)
    if not column.free_head:
        return
    for bar in (BELOW, ABOVE):  # each end moves along as its bar stretches
        n, t = q0[N], q0[T]
        x = column.lengths[bar] + (q0[U] if bar == BELOW else q0[HEAD] - q0[U])
        dx = step[U] if bar == BELOW else step[HEAD] - step[U]
        long = (n * n + t * t + x * x) ** 0.5
        long += (n * step[N] + t * step[T] + x * dx) / long
        left = long * long - (n + step[N]) ** 2 - (t + step[T]) ** 2
        along = max(left, 0.0) ** 0.5 - x
        if bar == BELOW:
            moved[U] = along
        else:
            moved[HEAD] = moved[U] + along


@inner
def allowed(s, dt, size):
    """Residual of a solved step: 1e-10, or what the round-off of velocities leaves."""
    work, column = s.room[0], s.columns[0]
    velocity = abs(work.w0[N]) + 2.0 * abs(work.moved[N]) / dt
    rounded = 8.0 * EPS * work.strike_mass * velocity / (dt * column.strength[0])
    return max(_TOLERANCE, rounded)


@inner
def aim(s):
    """Newton's step, not too far."""
    work = s.room[0]
    step = work.step
    for i in range(7):
        step[i] = -work.R[i]
    free = work.sideways == 0 or work.sideways == STICKS
    if not solved(work.J, step, free):
        return False
    shorten(s.columns[0].lengths, step)
    return True


@njit(cache=True, error_model="numpy")
def finish(s, size):
    """Take the last Newton step with forces along the tangent, not evaluated anew.

    Those of an elastic bar are exact: along the tangent it would seem to flow by a round-off.
    """
    column, state, work = s.columns[0], s.states[1], s.room[0]
    if size > work.finish_below or work.sideways != 0 or not aim(s):
        return False
    step, strength = work.step, column.strength
    for i in range(7):
        work.moved[i] += step[i]
        state.q[i] = work.q0[i] + work.moved[i]
        for k in range(7):
            work.F[i] += work.K[i, k] * step[k]
    for bar in (BELOW, ABOVE):
        plastic, stress = state.plastic[bar], state.stress[bar]
        if work.branch[bar] == ELASTIC:
            deformations(column, bar, state.q, work, work.trial)
            for i in range(5):
                stiff = column.stiffness[bar, i, i] * strength[i] ** 2
                stress[i] = stiff * (work.trial[i] - plastic[i])
            continue
        y = work.start
        for i in range(6):
            y[i] = SIGNS[bar, i] * step[PLACES[i]]
        y[U] += 0.0 if bar == BELOW else step[HEAD]
        for i in range(5):
            for m in range(5):
                for j in range(6):
                    stress[i] += work.D[bar, i, m] * work.B[bar, m, j] * y[j]
    return True


newton = newton_of(Equations(vectors, evaluate, allowed, aim, bend, finish))


@njit(cache=True, error_model="numpy")
def assign(source, target):
    """Copy a state field by field: as a whole it takes numba minutes to compile."""
    copy(source.q, target.q)
    copy(source.w, target.w)
    copy(source.stress, target.stress)
    copy(source.plastic, target.plastic)
    target.force, target.dissipated = source.force, source.dissipated
    target.elastic = source.elastic


@inner
def hit(s):
    """Displacement along the hit, and its velocity."""
    return s.states[0].q[N] - s.columns[0].sag, s.states[0].w[N]


@called
def _attempt(s, dt, closed, touch, striker):
    """A midpoint step with what holds the impact point sideways as `room.sideways` says."""
    predict(s, dt, closed, touch, striker)
    done, residual, count = newton(s, dt, closed, touch, striker)
    work, trial = s.room[0], s.states[1]
    for i in range(7):
        trial.w[i] = 2.0 * work.moved[i] / dt - work.w0[i]
    return done, residual, count


@called
def solve(s, dt, closed, touch, striker):
    """A midpoint step; with friction sticking if the face can hold so much, else sliding."""
    assign(s.states[0], s.states[1])
    now, work, column = s.states[0], s.room[0], s.columns[0]
    copy(now.q, work.q0)
    copy(now.w, work.w0)
    copy(now.stress, work.stress0)
    for bar in (BELOW, ABOVE):
        place(work.q0, column.lengths, bar, work.start)
        work.chord0[bar, 0], work.chord0[bar, 1], _ = chord(work.start, work.G)
    work.strike_mass = 2.0 * column.mass[N] + column.mass[HEAD] + striker
    work.push, rubs = 0.0, closed and column.friction > 0.0
    work.sideways = STICKS if rubs else 0
    done, residual, count = _attempt(s, dt, closed, touch, striker)
    trial = s.states[1]
    pressed = striker * (touch - trial.w[N])
    if rubs and done and pressed > 0.0 and abs(work.push) > column.friction * pressed:
        work.sideways = -1 if work.push < 0.0 else 1
        work.sideways = -work.sideways
        done, residual, more = _attempt(s, dt, closed, touch, striker)
        count += more
    return done, trial.w[N], residual, count


@called
def settle(s, dt):
    """Plastic flow; the largest one of a hinge over its elastic deformation at yielding."""
    column, start, end, work = s.columns[0], s.states[0], s.states[1], s.room[0]
    most, last, total = 0.0, 0.0, work.trial
    for bar in (BELOW, ABOVE):
        deformations(column, bar, end.q, work, total)
        for j in range(5):
            strength = column.strength[j]
            stiff = column.stiffness[bar, j, j] * strength
            if stiff > 0.0:  # a pin: all of its rotation is free
                total[j] -= end.stress[bar, j] / (stiff * strength)
            flow = total[j] - start.plastic[bar, j]
            end.dissipated += 0.5 * (work.stress0[bar, j] + end.stress[bar, j]) * flow
            end.plastic[bar, j] = total[j]
            share = abs(flow) * stiff
            if column.surface.count == 0 and j in (2, 4):  # any two axes are those of a round tube
                share = (share**2 + last**2) ** 0.5
            most, last = max(most, share), share
    if work.sideways != 0:
        end.dissipated -= 0.5 * work.push * (work.w0[T] + end.w[T])
    return most


@called
def accept(s, dt):
    """Commit the trial, and what the next first guess starts from."""
    now, trial, work = s.states[0], s.states[1], s.room[0]
    for i in range(7):
        work.rate[i] = (trial.q[i] - now.q[i]) / dt
    assign(s.states[1], s.states[0])
    at_place(s)


@called
def at_place(s):
    """Forces and energy of the committed state, which was evaluated last."""
    column, state = s.columns[0], s.states[0]
    copy(s.room[0].F, s.room[0].F0)
    copy(s.room[0].K, s.room[0].K0)
    state.force = s.room[0].F[N]
    energy = column.spring * (state.q[HEAD] - column.unstressed) ** 2
    energy += column.torsion * state.q[TWIST] ** 2
    for bar in (BELOW, ABOVE):
        for j in range(5):
            stiff = column.stiffness[bar, j, j] * column.strength[j] ** 2
            if stiff > 0.0:
                energy += state.stress[bar, j] ** 2 / stiff
    state.elastic = 0.5 * energy


SCALARS = (
    *("peak_displacement", "time_of_peak", "residual_displacement", "peak_force", "impulse"),
    *("largest_plastic_rotation", "largest_compression", "largest_tension"),
)
RECORD = np.dtype(
    [
        *((name, float) for name in (*COMMON, "force", "elastic", "dissipated")),
        *(("q", float, 7), ("stress", float, (2, 5)), ("plastic", float, (2, 5))),
    ]
)


@called
def write(s, records, n):
    """Places, forces, plastic deformations, energies."""
    row, now, column = records[n], s.states[0], s.columns[0]
    copy(now.q, row.q)
    copy(now.stress, row.stress)
    copy(now.plastic, row.plastic)
    row.force, row.elastic, row.dissipated = now.force, now.elastic, now.dissipated
    row.external_work, row.kinetic = column.weight * now.q[N] - column.load * now.q[HEAD], 0.0
    for i in range(7):
        if i != HEAD or column.free_head:
            row.kinetic += 0.5 * column.mass[i] * now.w[i] ** 2


@inner
def lost(s):
    """Whether a chord turns by more than nine tenths of its bar, or the bars are squashed.

    The length of a bar is its first one, or the distance left between its ends if that is shorter.
    """
    lengths, q = s.columns[0].lengths, s.states[0].q
    across = q[N] ** 2 + q[T] ** 2
    below = (across + (lengths[0] + q[U]) ** 2) ** 0.5
    above = (across + (lengths[1] + q[HEAD] - q[U]) ** 2) ** 0.5
    shorter = min(min(lengths[0], lengths[1]), min(below, above))
    squashed = below + above < (1.0 - COLLAPSE_CONTRACTION) * (lengths[0] + lengths[1])
    return squashed or across**0.5 > COLLAPSE_SIDEWAYS * shorter


@inner
def apply_impulse(s, dv):
    """Change the velocity of the impact point; a face with friction takes some of it sideways."""
    now, column = s.states[0], s.columns[0]
    now.w[N] += dv
    before, most = now.w[T], column.friction * abs(dv)
    now.w[T] -= min(max(before, -most), most)
    now.dissipated += 0.5 * column.mass[T] * (before**2 - now.w[T] ** 2)


_march = march_of(
    StepFunctions(
        hit, solve, settle, accept, write, lost, mass=mass_of, apply_impulse=apply_impulse
    )
)


@njit(cache=True, error_model="numpy")
def impact(columns, states, room, hinges, drive, progress, records):
    """Follow an impact: (status, rows).

    Arguments: `columns` (1,) of COLUMN, `states` (2,) of STATE, `room` (1,) of WORK, `hinges` (2,)
    of ROOM; `drive`, `progress` and `records` of `workbench.mechanics.impact`.
    """
    pace, s = begin(drive, progress[0]), SpaceColumn(columns, states, room, hinges)
    internal_forces(s.columns[0], s.states[0], s.room[0], s.hinges)
    at_place(s)
    s.room[0].collision_mass = s.columns[0].mass[N] if pace.error < np.inf else 0.0
    return _march(s, pace, progress[0], records)


@njit(cache=True, error_model="numpy")
def lie(columns, states, room, hinges):
    """Lay a column down under the weight at its impact point; whether there is a state of rest."""
    column, state, work = columns[0], states[0], room[0]
    J, step = work.J, work.step
    for _ in range(_TRIES):
        if not internal_forces(column, state, work, hinges):
            return False
        forces = max(max(abs(work.F[N]), abs(work.F[T])), max(abs(work.F[U]), abs(work.F[HEAD])))
        moments = max(abs(work.F[BN]), max(abs(work.F[BT]), abs(work.F[TWIST])))
        if max(forces / column.strength[0], moments / column.strength[3]) <= _TOLERANCE:
            break
        copy(work.K, J)
        for i in range(7):
            step[i] = -work.F[i]
        if not solved(J, step, True):
            return False
        shorten(column.lengths, step)
        for i in range(7):
            state.q[i] += step[i]
    else:
        return False
    for bar in (BELOW, ABOVE):
        deformations(column, bar, state.q, work, work.trial)
        for j in range(5):
            stiff = column.stiffness[bar, j, j] * column.strength[j] ** 2
            held = state.stress[bar, j] / stiff if stiff > 0.0 else 0.0
            state.plastic[bar, j] = work.trial[j] - held
    return True


@njit(cache=True, error_model="numpy")
def turned(records):
    """Plastic rotations (4, n) of the hinges, from base to head, about whatever axis."""
    turns = np.empty((4, records.size))
    for n in range(records.size):
        for k, (bar, at) in enumerate(HINGES):
            flow = records[n].plastic[bar]
            turns[k, n] = (flow[2 * at - 1] ** 2 + flow[2 * at] ** 2) ** 0.5
    return turns


@njit(cache=True, error_model="numpy", nogil=True)
def impacts(columns, q, drives, given, nearly, which, codes, numbers, errors):
    """Follow impacts on the columns `which` of a table: see `four_dof.march.impacts`.

    Of one that collapses the numbers are those of a column in the plane of its displacement.
    """
    records = np.empty(1024, RECORD)
    for i in which:
        states, room, hinges = np.zeros(2, STATE), np.zeros(1, WORK), np.zeros(2, ROOM)
        copy(q[i], states[0].q)
        progress = np.zeros(1, PROGRESS)
        room[0].finish_below = nearly
        needed = 2 * int(np.ceil(drives[i, 0] / drives[i, 6])) + 4
        if records.size < needed:
            records = np.empty(needed, RECORD)
        one = columns[i : i + 1]
        status, n = impact(one, states, room, hinges, drives[i], progress, records[:needed])
        if status == COLLAPSE:
            codes[i], row = COLLAPSES, records[n - 1]
            numbers[i, 0] = (row.q[N] ** 2 + row.q[T] ** 2) ** 0.5
            numbers[i, 1], numbers[i, 2], numbers[i, 3] = row.q[U], 0.0, row.q[HEAD]
            numbers[i, 4] = row.time
        elif status == DONE:
            numbers[i, 5] = turned(records[:n]).max()
            bounces = drives[i, 10] > 0.0
            errors[i] = read_hit(records[:n], progress[0], given[i], bounces, numbers[i])
            time, v = records["time"][:n], records["displacement"][:n]
            if np.isnan(numbers[i, 0]) and not signed_peak(time, v)[2]:
                codes[i] = UNKNOWN
        else:
            codes[i] = UNKNOWN
