"""Stepping through the impact of the one mass: as long as the error allows, or equal steps.

The midpoint scheme keeps the energy at any step, so that the error is one of time alone. Once the
striker cannot come back and the column swings on a straight line, the rest of the record is exact:
a rotation in the plane of displacement and velocity over frequency.
"""

import numpy as np

from workbench.compiled import njit
from workbench.impact import contact_loss, explicit_percussion
from workbench.impact.pace import PIECES, Pace, aimed, growth, met
from workbench.impact.stepping import SLACK
from workbench.models.single_dof.kernels import (
    COLLAPSE,
    EPS,
    MOREAU,
    NO_CONVERGENCE,
    OK,
    TOO_MANY,
    Blow,
    midpoint_step,
    moreau_step,
    spring_at_rest,
    spring_energy,
)

_POINTS, _MOST_POINTS = 20, 2000  # records of a period of the vibration, and of a whole record
_LONGER = 2.0  # times as long a step may be as the one before
_SHORTEST = 1e-6  # of the first step, to which an impact is stepped on
_CLOSE = 1e-8  # of the way of the striker in that step, below which a gap is closed
_SOFT = 1e-3  # of the velocity of the striker; what rebounds slower stays in contact
_NO_MORE = 1.0 + 1e-4  # of the peak
_AT_REST = 1e-4  # of the velocity after the hit, to which the peak is stepped on


@njit(cache=True, error_model="numpy")
def slope_of(state, pieces):
    """Slope of the line on which the spring unloads, or on which it has not yielded yet."""
    return state.stiffness if state.yielded else pieces[0].c[1]


@njit(cache=True, error_model="numpy")
def swings(motion, state, pieces, mass, peak):
    """Whether a free column swings on a straight line for good, out of reach of its striker.

    And no farther than to the `peak` that it has had.
    """
    w, x, wx = motion
    k, first = slope_of(state, pieces), pieces[0]
    turn = (w * w * mass / k + (state.force / k) ** 2) ** 0.5
    if state.yielded:
        straight = state.v <= state.top and k * turn <= state.top_force
    else:
        straight = first.c[2] == 0.0 and first.c[3] == 0.0 and turn <= state.top
        straight = straight and (pieces.size == 1 or state.top <= pieces[1].start)
    centre = state.v - state.force / k
    return straight and wx <= 0.0 and x < centre - turn and centre + turn <= _NO_MORE * peak


@njit(cache=True, error_model="numpy")
def swing(pace, time, blow, motion, state, k, n, records):
    """Records after the n-th of a column that swings on the slope k; which is the last one."""
    w, _, wx = motion
    last, omega = records[n], (k / blow.mass) ** 0.5
    step = max(2.0 * np.pi / (_POINTS * omega), 0.5 * pace.spacing, pace.duration / _MOST_POINTS)
    left = pace.duration - time
    count = int(np.ceil(left / step))
    step = left / count
    c, s = np.cos(omega * step), np.sin(omega * step)
    centre, x, y = state.v - state.force / k, state.force / k, w / omega
    for i in range(1, count + 1):
        x, y = c * x + s * y, c * y - s * x
        row = records[n + i]
        row.time = pace.duration if i == count else time + i * step
        row.displacement, row.velocity, row.striker_velocity = centre + x, omega * y, wx
        row.percussion, row.force = 0.0, k * x
        row.kinetic = 0.5 * (k * y * y + blow.striker * wx * wx)
        row.elastic, row.dissipated = 0.5 * k * x * x, state.dissipated
        row.contact_loss = last.contact_loss
    return n + count


@njit(cache=True, error_model="numpy")
def impact(scheme, given, elastic_limit, limit, pieces, records):
    """Follow the impact: (status, last record, time, residual, peak, its time, plastic change).

    `given`: the numbers of `Pace` and `Blow` in a row, which to hand over one by one costs more
    than many steps. The first collision, whose instant is known, comes before the first step, and
    its percussion is recorded with that. COLLAPSE when v passes `limit`. The peak (m) is the
    largest displacement at which the column stood still; what reverse yielding has changed since
    of the plastic displacement (m) comes last.
    """
    pace = Pace(given[0], given[1], given[2], given[3], given[4], given[5], given[6], int(given[7]))
    blow = Blow(given[8], given[9], given[10], given[11])
    state = spring_at_rest(elastic_limit, pieces)
    mass, striker, velocity, restitution = blow
    motion, lost, carried, peak, at = (0.0, 0.0, velocity), 0.0, 0.0, 0.0, 0.0
    row = records[0]
    row.time = row.displacement = row.velocity = row.force = row.elastic = 0.0
    row.dissipated = row.contact_loss = row.percussion = 0.0
    row.striker_velocity, row.kinetic = velocity, 0.5 * striker * velocity**2
    controlled, smooth, start = pace.error < np.inf, False, 0.0
    n, steps, time, dt, before, slowing = 0, 0, 0.0, pace.first, 0.0, 0.0
    while time < pace.duration * (1.0 - 1e-12):
        w, x, wx = motion
        gap, gamma = state.v - x, w - wx
        close = _CLOSE * velocity * pace.first + 4.0 * EPS * abs(x) if controlled else SLACK
        if (controlled or time == 0.0) and gap <= close and gamma < -1e-9 * velocity:
            eps = restitution if -gamma * restitution > _SOFT * velocity else 0.0
            push = explicit_percussion(gamma, gamma, eps, mass, striker)
            motion = (w + push / mass, x, wx - push / striker)
            lost += contact_loss(push, gamma, motion[0] - motion[2])
            carried, smooth, dt = carried + push, False, pace.first
            start = max(start, motion[0])
            continue
        dt = aimed(pace, time, dt, 0.0, gamma)
        if controlled and gap > close and gamma < 0.0:
            dt = min(dt, -gap / gamma)
        steps += 1
        if steps > pace.most:
            return TOO_MANY, n, time, 0.0, peak, at, 0.0
        if scheme == MOREAU:
            found = moreau_step(dt, motion, blow, state, pieces)
        else:
            found = midpoint_step(dt, motion, blow, state, pieces, close)
        residual, moved, spring, percussion, loss = found
        if residual > 1e-9:
            dt *= 0.5
            if dt < pace.first / PIECES:
                return NO_CONVERGENCE, n, time, residual, peak, at, 0.0
            continue
        acceleration, factor = (moved[0] - w) / dt, _LONGER
        if controlled:
            if percussion == 0.0 and dt > _SHORTEST * pace.first:
                meeting = met(gap, gamma, moved[0] - moved[2], dt, close)
                if meeting < dt:
                    dt = max(meeting, _SHORTEST * pace.first)
                    continue
            rate = abs(acceleration - slowing) / (0.5 * (dt + before)) if smooth else 0.0
            factor = growth(pace, pace.error * start, rate, dt, 0.0)
            passes = min(w, -moved[0]) > _AT_REST * start and spring.v > peak
            if passes:  # on to the peak
                factor = min(factor, w / (w - moved[0]))
            if (factor < 0.7 or passes) and dt > pace.first:
                dt = max(dt * max(factor, 0.1), pace.first)
                continue
        if w > 0.0 >= moved[0]:
            rise = dt * w / (w - moved[0])
            if state.v + 0.5 * rise * w > peak:
                peak, at = state.v + 0.5 * rise * w, time + rise
        lost, time, before, smooth, slowing = lost + loss, time + dt, dt, True, acceleration
        motion, state = moved, spring
        dt = min(max(dt * min(max(factor, 0.3), _LONGER), pace.first), pace.longest)
        if n > 0 and time - records[n - 1].time <= pace.spacing:
            carried += records[n].percussion
        else:
            n += 1
        row = records[n]
        row.time = min(time, pace.duration)
        row.displacement, row.velocity, row.striker_velocity = state.v, motion[0], motion[2]
        row.percussion, carried = carried + percussion, 0.0
        row.kinetic = 0.5 * (mass * motion[0] ** 2 + striker * motion[2] ** 2)
        row.contact_loss, row.force, row.dissipated = lost, state.force, state.dissipated
        row.elastic = spring_energy(state, pieces)
        if state.v > limit:
            return COLLAPSE, n, time, 0.0, peak, at, 0.0
        if controlled and percussion == 0.0 and swings(motion, state, pieces, mass, peak):
            slope = slope_of(state, pieces)
            n = swing(pace, time, blow, motion, state, slope, n, records)
            break
    changed = (state.v - state.top) - (state.force - state.top_force) / state.stiffness
    return OK, n, time, 0.0, peak, at, changed if state.yielded else 0.0
