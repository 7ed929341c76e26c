"""Stepping through the impact of a column: as long as the error allows, or steps of one length.

Controlled steps hold two measures: the error of the displacement, see `workbench.impact.pace`; and
hinges that flow, whose forces are those at the end of a step (backward Euler), may flow by no more
than `flow` times their elastic deformation at yielding. Axial vibrations of the masses are not
resolved: the midpoint rule keeps their energy at any step. Records are merged to what a plot needs.
"""

import numpy as np

from workbench.compiled import njit
from workbench.frames.collapse_watch import COLLAPSE_CONTRACTION, COLLAPSE_SIDEWAYS
from workbench.impact.pace import PIECES, aimed, growth
from workbench.models.four_dof import dynamics, panels, statics
from workbench.models.four_dof.kinematics import U1, U2, V
from workbench.structures.kernels import copy

# residual over the squash load that one more Newton step removes: of controlled, of equal steps
_NEARLY, _CLOSELY = 2e-5, 1e-6
TOO_MANY = 3  # status beside those of `statics`


@njit(cache=True, error_model="numpy")
def flown(column, start, end):
    """Largest plastic deformation of a hinge between two states over its elastic one at yielding.

    Webs that slide are held by the hinges that turn with them.
    """
    most = 0.0
    for bar in range(2):
        for j in range(3):
            strength = column.squash_loads[0] if j == 0 else column.plastic_moments[0]
            flow = abs(end.plastic[bar, j] - start.plastic[bar, j])
            most = max(most, flow * column.stiffness[bar, j] / strength)
    return most


@njit(cache=True, error_model="numpy")
def chords(lengths, q):
    """Distances that are left between the ends of both bars, in m."""
    below = (q[V] ** 2 + (lengths[0] + q[U1]) ** 2) ** 0.5
    above = (q[V] ** 2 + (lengths[1] + q[U2] - q[U1]) ** 2) ** 0.5
    return below, above


@njit(cache=True, error_model="numpy")
def collapsed(column, q):
    """Whether v1 passes nine tenths of a bar, or the bars are squashed by a tenth.

    Of its first length, or of the distance that is left between its ends, which a chord that turns
    over passes in any case.
    """
    below, above = chords(column.lengths, q)
    shorter = min(min(column.lengths[0], column.lengths[1]), min(below, above))
    squashed = below + above < (1.0 - COLLAPSE_CONTRACTION) * column.lengths.sum()
    return squashed or abs(q[V]) > COLLAPSE_SIDEWAYS * shorter


@njit(cache=True, error_model="numpy")
def energy(column, state):
    """Energy of a state and what has become of it, in J; writes its elastic and kinetic parts."""
    statics.store(column, state)
    m, w = column.mass, state.w
    kinetic = column.striker_mass * state.striker_velocity**2
    for i in (V, U1, U2):
        kinetic += m[i] * w[i] ** 2 if i != U2 or column.free_head else 0.0
    state.kinetic = 0.5 * kinetic
    gone = state.dissipated + state.contact_loss
    return state.kinetic + state.elastic + gone + column.load * state.q[U2]


@njit(cache=True, error_model="numpy")
def impact(columns, scheme, pace, records, room):
    """Follow the impact; returns (status, last record, time, residual, cuts).

    `columns` and `room` have one row, of COLUMN and of WORK; `records` of STATE begin with the
    preloaded column and the velocity of the striker. A step that does not converge is halved.
    """
    column, work = columns[0], room[0]
    statics.internal_forces(column, records[0], work)
    records[0].force = work.F[V]
    scale, given = abs(records[0].striker_velocity), energy(column, records[0])
    n, steps, cuts, residual, time = 0, 0, 0, 0.0, 0.0
    dt, before, highest, smooth, error = pace.first, 0.0, 0.0, False, pace.error
    copy(work.F, work.F0)
    copy(work.K, work.K0)
    if column.sliding == panels.RIGID_IN_SHEAR:
        work.nearly = _NEARLY if pace.error < np.inf else _CLOSELY
    while time < pace.duration * (1.0 - 1e-12):
        last, state = records[n], records[n + 1]
        gap, gamma = last.q[V] - last.striker, last.w[V] - last.striker_velocity
        dt = aimed(pace, time, dt, gap, gamma)
        records[n + 1] = last
        state.percussion = 0.0
        steps += 1
        if steps > pace.most:
            return TOO_MANY, n, time, residual, cuts
        done, residual = dynamics.step(column, scheme, dt, state, work)
        if not done:
            cuts += 1
            dt *= 0.5
            if dt < pace.first / PIECES:
                return statics.NO_CONVERGENCE, n, time, residual, cuts
            continue
        struck = state.percussion > 0.0 and gamma < -1e-9 * scale
        acceleration, factor = (state.w[V] - last.w[V]) / dt, 0.0 if struck else 2.0
        if smooth and not struck and pace.error < np.inf:
            if state.q[V] < highest and state.w[V] > 0.0 and state.percussion == 0.0:
                error = pace.vibration
            rate = abs(acceleration - work.acceleration) / (0.5 * (dt + before))
            factor = growth(pace, error * scale, rate, dt, flown(column, last, state))
            if factor < 0.7 and dt > pace.first:
                dt = max(dt * max(factor, 0.2), pace.first)
                continue
            factor = min(max(factor, 0.3), 2.0)
        if not struck:
            work.acceleration = acceleration
        for i in range(4):
            work.rate[i] = (state.q[i] - last.q[i]) / dt
        smooth, before, time, highest = not struck, dt, time + dt, max(highest, state.q[V])
        state.time, state.force = time, work.F[V]
        state.balance = given - energy(column, state)
        copy(work.F, work.F0)
        copy(work.K, work.K0)
        dt = min(max(dt * factor, pace.first), pace.longest)
        if n > 0 and time - records[n - 1].time <= pace.spacing:
            state.percussion += last.percussion
            records[n] = state
        else:
            n += 1
        if collapsed(column, records[n].q):
            return statics.COLLAPSE, n, time, residual, cuts
    return statics.OK, n, time, residual, cuts
