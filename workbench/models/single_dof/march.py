"""The elasto-plastic spring of the single-degree-of-freedom column (Heng 2017, section 5.2).

The envelope of the spring is a resistance curve, `pieces`. The impact integrator
(`workbench.mechanics.impact`) follows one mass on it: the smallest example of a march.

The entry `impact` takes energy-conserving midpoint steps, as long as the error allows or equal;
`pulse` has another. `impacts` follows many columns, with curve, pace and numbers of each. Once the
striker cannot come back and the column swings on a straight line, the rest of the record is exact:
a rotation in the plane of displacement and velocity over frequency.
"""

from typing import Any, NamedTuple

import numpy as np

from workbench.base.compiled import njit
from workbench.mechanics.impact.contact import explicit_percussion, inner, uncounted
from workbench.mechanics.impact.integrator import (
    COLLAPSE,
    COMMON,
    DONE,
    DRIVE,
    PROGRESS,
    StepFunctions,
    begin,
    march_of,
    no_flow,
    standstill,
)
from workbench.mechanics.impact.pace import EPS, Pace
from workbench.models.batch import COLLAPSES, LOST, SURVIVES, UNKNOWN
from workbench.models.resistance.kernels import (
    on_curve,
    residual,
    unloading_stiffness,
    work_between,
)
from workbench.models.resistance.shapes import curve_of
from workbench.responses.histories import FORCE_WINDOW
from workbench.responses.kernels import largest_window, signed_peak


class Spring(NamedTuple):
    """Displacement `v` and `force`; farthest place on the envelope, either way, and its force.

    Before the first yielding `top` is the elastic limit. Further the unloading `stiffness` there,
    whether the spring has `yielded`, and the energy `dissipated` so far.
    """

    v: float
    force: float
    top: float
    top_force: float
    stiffness: float
    yielded: bool
    dissipated: float


@njit(cache=True, error_model="numpy")
def spring_at_rest(elastic_limit, pieces):
    """State of the spring before the impact."""
    force, _ = on_curve(pieces, elastic_limit)
    stiffness = unloading_stiffness(pieces, elastic_limit)
    return Spring(0.0, 0.0, elastic_limit, force, stiffness, False, 0.0)


@njit(cache=True, error_model="numpy")
def spring_path(state, v1, pieces):
    """Force, slope and work of the straight path from the state to v1, which is not taken.

    Below the first yielding the spring follows the envelope both ways; later it moves on the
    unloading line between -F_top and F_top, flows at these two, and rejoins the envelope at v_top,
    at -v_top the mirrored one. What goes down is the mirror image of what goes up.
    """
    way = 1.0 if v1 >= state.v else -1.0
    v0, f0, v_top, f_top, k, yielded, _ = state
    v0, f0, v1 = way * v0, way * f0, way * v1
    if v1 >= v_top:
        f1, slope = on_curve(pieces, v1)
    if not yielded:
        a, b = abs(v0), min(abs(v1), v_top)
        work = work_between(pieces, a, b) if b >= a else -work_between(pieces, b, a)
        if v1 >= v_top:
            return way * f1, slope, work + work_between(pieces, v_top, v1)
        f1, slope = on_curve(pieces, b)
        return way * (f1 if v1 >= 0.0 else -f1), slope, work
    if v0 == v_top:
        return way * f1, slope, work_between(pieces, v0, v1)
    bend = min(v0 + max(f_top - f0, 0.0) / k, v_top)  # back at F_top
    if v1 <= bend and v1 < v_top:
        f1 = f0 + k * (v1 - v0)
        return way * f1, k, 0.5 * (f0 + f1) * (v1 - v0)
    work = 0.5 * (f0 + f_top) * (bend - v0)
    if v1 < v_top:
        return way * f_top, 0.0, work + f_top * (v1 - bend)
    work += f_top * (v_top - bend)
    return way * f1, slope, work + work_between(pieces, v_top, v1)


@njit(cache=True, error_model="numpy")
def spring_energy(state, pieces):
    """Elastic energy of the spring."""
    if state.yielded:
        return 0.5 * state.force**2 / state.stiffness
    return work_between(pieces, 0.0, abs(state.v))


@njit(cache=True, error_model="numpy")
def spring_moved(state, v1, pieces):
    """State after the straight path to v1: force, top, unloading stiffness, dissipation."""
    v0, f0, v_top, f_top, k, yielded, dissipated = state
    if unloads(state, v1):
        return Spring(v1, f0 + k * (v1 - v0), v_top, f_top, k, True, dissipated)
    f1 = spring_path(state, v1, pieces)[0]
    way = 1.0 if v1 >= v0 else -1.0
    start, far = way * v0, way * v1
    if not yielded:
        if far <= v_top:
            return Spring(v1, f1, v_top, f_top, k, False, dissipated)
        # elastic energy of the curve gives way to that of the unloading line
        dissipated += work_between(pieces, 0.0, v_top) - 0.5 * f_top * f_top / k
    elif start < v_top:
        flows = start + max(f_top - way * f0, 0.0) / k
        dissipated += f_top * max(min(far, v_top) - flows, 0.0)
    if far <= v_top:
        return Spring(v1, f1, v_top, f_top, k, True, dissipated)
    stiffness = unloading_stiffness(pieces, far)
    dissipated += work_between(pieces, v_top, far)
    dissipated -= 0.5 * (f1 * f1 / stiffness - f_top * f_top / k)
    return Spring(v1, f1, far, abs(f1), stiffness, True, dissipated)


@njit(cache=True, error_model="numpy")
def unloads(state, v1):
    """Whether the spring stays on its unloading line on the way to v1."""
    v0, f0, v_top, f_top, k, yielded, _ = state
    rise = k * (v1 - v0)
    return yielded and abs(v0) < v_top and abs(v1) < v_top and -f_top <= f0 + rise <= f_top


@njit(cache=True, error_model="numpy")
def solve_midpoint(dt, w0, mass, jump, state, pieces):
    """End velocity w1 of mass (w1 - w0) + jump + dt F_mean = 0; returns (w1, residual).

    F_mean is the work of the step over its displacement, so energy is kept whatever the curve.
    The residual grows with w1 unless the curve softens within the step faster than 2 mass / dt^2.
    """
    v0 = state.v
    elastic = state.stiffness if state.yielded and abs(state.v) < state.top else 0.0
    ahead = jump + dt * (state.force + 0.5 * dt * elastic * w0)  # exact on the unloading line
    w1 = w0 - ahead / (mass + 0.25 * dt * dt * elastic)
    if unloads(state, v0 + 0.5 * dt * (w0 + w1)):
        return w1, 0.0
    low, high, residual = -np.inf, np.inf, np.inf
    for _ in range(200):
        v1 = v0 + 0.5 * dt * (w0 + w1)
        f1, slope, work = spring_path(state, v1, pieces)
        mean = work / (v1 - v0) if v1 != v0 else state.force
        residual = mass * (w1 - w0) + jump + dt * mean
        scale = mass * (abs(w0) + abs(w1)) + abs(jump) + dt * (abs(mean) + abs(f1))
        scale += dt * abs(slope) * (abs(v0) + abs(v1))  # round-off of v in the force
        if abs(residual) <= 4.0 * EPS * scale:
            return w1, 0.0
        if residual > 0.0:
            high = w1
        else:
            low = w1
        gradient = mass + 0.25 * dt * dt * slope
        new = w1 - residual / gradient if gradient > 0.0 else w1 - residual / mass
        if not low < new < high and high - low < np.inf:
            new = 0.5 * (low + high)
        if abs(new - w1) <= 2.0 * EPS * (abs(w0) + abs(w1)):
            return new, 0.0
        w1 = new
    return w1, abs(residual) / scale


@njit(cache=True, error_model="numpy")
def pushed(path, elastic_limit, pieces):
    """Force, elastic and dissipated energy, (n, 3), along displacements `path` (n,)."""
    state, out = spring_at_rest(elastic_limit, pieces), np.empty((path.size, 3))
    for n in range(path.size):
        state = spring_moved(state, path[n], pieces)
        out[n] = state.force, spring_energy(state, pieces), state.dissipated
    return out


RECORD = np.dtype(
    [(name, float) for name in (*COMMON, "force", "elastic", "dissipated", "plastic")]
)
STATE = np.dtype(
    [
        *((name, bool if name == "yielded" else float) for name in Spring._fields),
        *(("w", float), ("mass", float)),  # velocity and mass that move
        *(("time", float), ("push", float), ("work", float)),  # of pulses: mean force, its work
        ("stage", int),
        *(("x", float), ("contact", float), ("crushed", float)),  # of a striker that crushes
        *(("weight", float), ("sag", float)),  # dead force (N), displacement under it (m)
    ],
    align=True,
)
_POINTS, _MOST_POINTS = 20, 2000  # records of a period of the vibration, and of a whole record
_FIRST, _FEWEST_STEPS = 4e-3, 50  # step after an impact over that period; steps of a record
_ERRORS = (1e-3, 8e-5)  # of a step without and with restitution, see `Pace`
_PARTS = (500, 80_000)  # of the duration that are recorded, at least and at most
MOST_STEPS = 4_000_000
_INSTANT = 1e-12  # s, of the first collision
SCALARS = ("peak_displacement", "time_of_peak", "residual_displacement", "impulse", "peak_force")
_NO_MORE = 1.0 + 1e-4  # of the peak


class OneMass(NamedTuple):
    """System: committed and trial state, resistance curve, displacement of collapse (m)."""

    states: Any
    pieces: Any
    limit: float


@uncounted
def spring_of(state):
    """The spring of a state."""
    return Spring(
        *(state.v, state.force, state.top, state.top_force, state.stiffness),
        *(state.yielded, state.dissipated),
    )


@uncounted
def put(state, spring):
    """Write the spring into a state."""
    state.v, state.force, state.top = spring.v, spring.force, spring.top
    state.top_force, state.stiffness = spring.top_force, spring.stiffness
    state.yielded, state.dissipated = spring.yielded, spring.dissipated


@uncounted
def hit(s):
    """Displacement and velocity."""
    return s.states[0].v - s.states[0].sag, s.states[0].w


@uncounted
def solve(s, dt, closed, touch, striker):
    """The step of the mass, with that of a striker in contact."""
    now = s.states[0]
    mass, jump = now.mass, -dt * now.weight
    if closed:
        mass, jump = mass + striker, jump + striker * (now.w - touch)
    w1, residual = solve_midpoint(dt, now.w, mass, jump, spring_of(now), s.pieces)
    s.states[1].w = w1
    return residual <= 1e-9, w1, residual, 1


@uncounted
def accept(s, dt):
    """Move the spring."""
    now = s.states[0]
    w1 = s.states[1].w
    put(now, spring_moved(spring_of(now), now.v + 0.5 * dt * (now.w + w1), s.pieces))
    now.w = w1


@uncounted
def write(s, records, n):
    """Force, energies, plastic displacement."""
    row, now = records[n], s.states[0]
    row.plastic = now.v - now.force / now.stiffness if now.yielded else 0.0
    row.kinetic, row.force, row.dissipated = 0.5 * now.mass * now.w**2, now.force, now.dissipated
    row.elastic = spring_energy(spring_of(now), s.pieces)
    row.external_work = now.work + now.weight * (now.v - now.sag)


@uncounted
def lost(s):
    """Whether the displacement of collapse is passed, either way."""
    return abs(s.states[0].v) > s.limit


@uncounted
def mass_of(s):
    """The impact mass."""
    return s.states[0].mass


@uncounted
def apply_impulse(s, dv):
    """Change the velocity."""
    s.states[0].w += dv


@uncounted
def slope_of(now, pieces):
    """Slope of the line on which the spring unloads, or on which it has not yielded yet."""
    return now.stiffness if now.yielded else pieces[0].c[1]


@uncounted
def is_free_vibration(s, progress):
    """Whether a free column swings on a straight line for good, out of reach of its striker.

    And no farther than to the peak that it has had; nothing weighs.
    """
    now, first = s.states[0], s.pieces[0]
    k = slope_of(now, s.pieces)
    turn = (now.w * now.w * now.mass / k + (now.force / k) ** 2) ** 0.5
    if now.yielded:
        straight = now.v <= now.top and k * turn <= now.top_force
    else:
        straight = first.c[2] == 0.0 and first.c[3] == 0.0 and turn <= now.top
        straight = straight and (s.pieces.size == 1 or now.top <= s.pieces[1].start)
    centre = now.v - now.force / k
    away = progress.velocity <= 0.0 and progress.place < centre - turn
    away = away and progress.gravity == 0.0 and now.weight == 0.0
    return straight and away and centre + turn <= _NO_MORE * progress.peak


@uncounted
def closed_form_tail(s, pace, progress, records, n):
    """Records after the n-th of a column that swings on a straight line; which is the last one."""
    now = s.states[0]
    k = slope_of(now, s.pieces)
    omega, left = (k / now.mass) ** 0.5, pace.duration - progress.time
    step = max(2.0 * np.pi / (_POINTS * omega), 0.5 * pace.spacing, pace.duration / _MOST_POINTS)
    count = max(int(np.ceil(left / step)), 1)
    step = left / count
    c, sine = np.cos(omega * step), np.sin(omega * step)
    centre, x, y = now.v - now.force / k, now.force / k, now.w / omega
    striking = 0.5 * progress.mass * progress.velocity**2
    for i in range(1, count + 1):
        x, y = c * x + sine * y, c * y - sine * x
        row = records[n + i]
        row.time = pace.duration if i == count else progress.time + i * step
        row.displacement, row.velocity = centre + x, omega * y
        row.striker_velocity, row.contact_loss = progress.velocity, progress.contact_loss
        row.percussion, row.force, row.external_work = 0.0, k * x, 0.0
        row.kinetic, row.elastic = 0.5 * k * y * y + striking, 0.5 * k * x * x
        row.dissipated, row.plastic = now.dissipated, records[n].plastic
    return n + count


_march = march_of(
    StepFunctions(
        *(hit, solve, no_flow, accept, write, lost),
        mass=mass_of,
        apply_impulse=apply_impulse,
        is_free_vibration=is_free_vibration,
        closed_form_tail=closed_form_tail,
    )
)


@inner
def at_rest(drive, pieces):
    """States before anything happens; see `impact` for the end of the drive."""
    states, now = np.zeros(2, STATE), drive[DRIVE:]
    states[0].mass, states[0].weight, states[0].sag = now[2], now[3], now[4]
    put(states[0], spring_moved(spring_at_rest(now[0], pieces), now[4], pieces))
    states[0].dissipated = 0.0
    return states


@njit(cache=True, error_model="numpy")
def impact(pieces, drive, progress, records):
    """Follow an impact: (status, rows).

    Arguments: `pieces` of the resistance; `drive`, `progress` and `records` of `mechanics.impact`,
    the drive with elastic limit (m), displacement of collapse (m), impact mass (kg), dead force (N)
    and displacement under it (m), from which those of the records count.
    """
    s = OneMass(at_rest(drive, pieces), pieces, drive[DRIVE + 1])
    return _march(s, begin(drive, progress[0]), progress[0], records)


@njit(cache=True, error_model="numpy")
def pace_of(period, duration, bounces):
    """Pace of an impact: `period` (s) of the mass on the steepest slope; may the striker come back.

    Followed for a `duration` (s).
    """
    longest = duration / _FEWEST_STEPS
    spacing = max(min(period / _POINTS, duration / _PARTS[0]), duration / _PARTS[1])
    error = _ERRORS[1] if bounces else _ERRORS[0]
    first = min(_FIRST * period, longest)
    return Pace(duration, first, longest, error, error, np.inf, spacing, MOST_STEPS)


@njit(cache=True, error_model="numpy")
def scalars(records, progress, pieces, elastic_limit, mass, bounces, sag=0.0):
    """Numbers of an impact on a mass (kg), in the order of SCALARS; NaN where there is none."""
    peak, when = standstill(records, progress, bounces)
    left = np.nan
    if not np.isnan(peak):  # after the peak reverse yielding takes some back
        plastic = records["plastic"]
        left = residual(pieces, elastic_limit, peak + sag) + plastic[-1] - plastic.max()
    percussion, force = records["percussion"], np.nan
    if progress.crush.points == 0:
        # the first collision is recorded with the first step but happens at time 0
        v, e = progress.approach, progress.restitution
        first = explicit_percussion(-v, -v, e, mass, progress.mass)
        times, pushes = np.zeros(percussion.size + 1), np.zeros(percussion.size + 1)
        times[1], times[2:] = _INSTANT, records["time"][1:]
        pushes[1], pushes[2:] = first, percussion[1:]
        pushes[2] -= first
        force = largest_window(times, pushes, FORCE_WINDOW) / FORCE_WINDOW
    return peak, when, left, percussion.sum(), force


@njit(cache=True, error_model="numpy", nogil=True)
def impacts(rows, strikes, codes, results):
    """Follow impacts on many columns: writes the `codes` (n,) and `results` (n, SCALARS).

    Of one that collapses displacement (m) and time (s). Arguments: `rows` of mechanisms; `strikes`
    (n, 5), mass (kg), velocity (m/s) and restitution of the striker, duration (s), impact mass.
    """
    records = np.empty(1024, RECORD)
    for i in range(codes.size):
        if codes[i] != SURVIVES:
            continue
        striker, velocity, restitution, duration, mass = strikes[i]
        pieces, elastic_limit, lost, unloads = curve_of(rows, i)
        if unloads:
            codes[i] = UNKNOWN
            continue
        limit, bounces = min(rows.reach[i], lost), restitution > 0.0
        period = 2.0 * np.pi * (mass / unloading_stiffness(pieces, rows.reach[i])) ** 0.5
        pace = pace_of(period, duration, bounces)
        drive = np.array(
            [
                *(pace.duration, pace.first, pace.longest, pace.error, pace.vibration, pace.flow),
                *(pace.spacing, float(pace.most), striker, velocity, restitution, 0.0),
                *(elastic_limit, limit, mass, 0.0, 0.0),
            ]
        )
        needed = 2 * int(np.ceil(duration / pace.spacing)) + 4
        if records.size < needed:
            records = np.empty(needed, RECORD)
        progress = np.zeros(1, PROGRESS)
        status, n = impact(pieces, drive, progress, records[:needed])
        if status == COLLAPSE:
            row = records[n - 1]
            codes[i] = LOST if lost <= rows.reach[i] else COLLAPSES
            when = progress[0].time - (row.displacement - limit) / row.velocity
            results[i, 0], results[i, 1] = limit, when
        elif status == DONE:
            answer = scalars(records[:n], progress[0], pieces, elastic_limit, mass, bounces)
            for k in range(len(answer)):
                results[i, k] = answer[k]
            time, v = records["time"][:n], records["displacement"][:n]
            if np.isnan(answer[0]) and not signed_peak(time, v)[2]:
                codes[i] = UNKNOWN
        else:
            codes[i] = UNKNOWN
