"""THE integrator: follows a structure and its striker through an impact, in compiled code.

A model brings its own bundle of constants, committed and trial state and scratch, the *system* `s`
(a NamedTuple of arrays and records, defined in a module), and plain compiled functions of it,
`StepFunctions`. The integrator never looks inside a system: it owns the striker, the clock, contact
and its impulses, the length of steps, the peak, the timing of records, and what ends a run. One
step:

1. `march` asks `hit` where the structure is hit and how fast. Bodies that touch and approach
   collide at an instant if the impact point has a `mass` of its own (`apply_impulse`); else within
   a step.
2. The length is that of the controller (`pace.step_factor`), at most to the next impact
   (`pace.next_step_size`).
3. `contact_step_of` has the model `solve` the step (predict, then Newton) with contact closed or
   open, and takes the solution that obeys 0 <= P perp gamma_1 + e gamma_0 >= 0. This decides
   contact within a step; a model with a `step` of its own decides there.
4. A step in which the gap closes (`pace.contact_time`), whose error is too large
   (`pace.step_factor`), or in which the impact point passes its peak, is taken again, shorter.
   Nothing has been committed so far.
5. The committed state is recorded if the new one lies a `spacing` behind the last record. Then the
   model must `accept` the new one, and is asked whether it is `lost` (collapse), or
   `is_free_vibration`: then `closed_form_tail` writes the rest of the record in closed form.

How to put a model on it (`models/single_dof/march.py` is the smallest example)::

    advance = march_of(StepFunctions(hit, solve, settle, accept, write, lost), longer=1.5)

    @njit(cache=True, error_model="numpy")          # the entry: arrays and NamedTuples in
    def impact(table, drive, progress, records):
        s = System(table[0], ...)
        pace = begin(drive, progress[0])
        return advance(s, pace, progress[0], records)

`advance` is specialised for the model when numba compiles the entry, whose cache file holds the
machine code of all it calls. Functions made by factories are not cached themselves and are called
by name; systems must not be defined in `__main__`. The entry may be called in a compiled loop over
many columns, with a `spacing` of infinity and records of three rows for ends and peaks alone.
From Python, `follow` calls an entry and reads its records once for all models, as `FollowedImpact`:
histories, peak, why it ended.
"""

from math import isnan, pi, prod, sqrt
from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit
from workbench.base.errors import SolverError
from workbench.mechanics.impact.contact import (
    CRUSH,
    UNLOADING,
    called,
    contact_loss,
    contact_step_of,
    explicit_percussion,
    front,
    may_touch,
    uncounted,
)
from workbench.mechanics.impact.pace import (
    APART,
    AT_REST,
    CLOSE,
    CLOSER,
    CUT,
    EPS,
    LASTING,
    LONGER,
    PIECES,
    SHORTEST,
    SLOWEST,
    SOFT,
    Pace,
    contact_time,
    next_step_size,
    step_factor,
)
from workbench.responses.kernels import first_peak, signed_peak
from workbench.scenarios import Striker

DONE, NO_CONVERGENCE, COLLAPSE, TOO_MANY, GOING = range(5)
PROGRESS = np.dtype(  # how far an impact has been followed, all that the integrator owns
    [
        *((name, float) for name in ("mass", "restitution", "place", "velocity")),  # of the striker
        *(("gravity", float), ("weighed", float)),  # along the strike (m/s2); its work so far (J)
        ("crush", CRUSH),  # its law if it crushes
        ("contact_loss", float),  # energy lost in contact, or spent on crushing, so far, J
        ("approach", float),  # first velocity of the striker, m/s
        ("scale", float),  # velocity that the hit gives this point, m/s; errors are shares of it
        # now, next step, last step, shortest step up to where a contact opens, s
        *((name, float) for name in ("time", "dt", "before", "least")),
        *((name, float) for name in ("acceleration", "change")),  # of the impact point, last ones
        ("highest", float),  # place at the end of a step so far, m
        *((name, float) for name in ("peak", "time_of_peak")),  # largest place of standstill
        ("error", float),  # tolerated now, as a share
        ("vibration_start", float),  # time before which that of a vibration is not allowed, s
        *((name, float) for name in ("recorded", "carried")),  # last record (s), impulse since, N s
        ("pushed", float),  # mean contact force of the last step, N
        ("release", float),  # length of the step up to where the contact opens, s; 0: unknown
        ("residual", float),  # of the last solution, over the allowed one
        *((name, int) for name in ("steps", "evaluations", "cuts")),
        ("begun", bool),
        ("smooth", bool),  # the last step was no impact: accelerations have a rate
    ]
)
COMMON = (  # columns of the records of all models, written here; energy and work with the striker
    *("time", "displacement", "velocity", "striker_velocity", "percussion"),
    *("contact_loss", "kinetic", "external_work"),
)
DRIVE = len(Pace._fields) + 4  # numbers of a drive that the integrator reads


@uncounted
def massless(s):
    """No mass of the impact point alone."""
    return 0.0


@uncounted
def no_impulse(s, dv):
    """Nothing: what has no mass of its own does not collide at an instant."""


@uncounted
def never(s, progress):
    """Never calm: steps go on to the end."""
    return False


@uncounted
def no_closed_form_tail(s, pace, progress, records, n):
    """No closed form."""
    return n


@uncounted
def no_flow(s, dt):
    """Nothing to settle, no measure of flow."""
    return 0.0


class StepFunctions(NamedTuple):
    """Functions of a model over its system `s`, compiled, bound when numba compiles an entry.

    `hit(s) -> place, speed`: of the impact point, committed, along the strike from its start (m,
    m/s).
    `solve(s, dt, closed, touch, striker) -> done, end speed, residual, evaluations`: trial state of
    a step; a closed contact adds the impulse P = striker (touch - v1) against the structure.
    `settle(s, dt) -> flow`: completes the trial (plastic flow); measure of flow for the controller.
    `accept(s, dt)`: the trial becomes the committed state. Only here committed sums may change.
    `write(s, records, n)`: the model's own columns of row n, of the committed state; `kinetic` is
    that of the structure, `external_work` that of its loads (both without the striker).
    `lost(s) -> bool`: collapse, asked after each accepted step.
    Optional: `mass(s)`, own mass (kg) of the impact point (0: none), and `apply_impulse(s, dv)`, a
    change of its velocity: for collisions at an instant. `is_free_vibration(s, progress) -> bool`
    and
    `closed_form_tail(s, pace, progress, records, n) -> rows`: the rest of the record after row n in
    closed form. `step(s, progress, dt, can_touch) -> done, impulse, end speed, loss`: instead of
    `solve`, for contacts of their own.
    """

    hit: Any
    solve: Any
    settle: Any
    accept: Any
    write: Any
    lost: Any
    mass: Any = massless
    apply_impulse: Any = no_impulse
    is_free_vibration: Any = never
    closed_form_tail: Any = no_closed_form_tail
    step: Any = None


@njit(cache=True, error_model="numpy")
def begin(drive, progress):
    """Return the pace of an impact; set its progress at the first call.

    The `drive` is one row of numbers, as passing them one by one costs more than many steps: those
    of `Pace`; mass (kg; 0: none), velocity (m/s) and restitution of the striker; the time (s)
    before which no step is as long as in a vibration; then, from `DRIVE` on, what a model adds.
    """
    pace = Pace(
        *(drive[0], drive[1], drive[2], drive[3], drive[4], drive[5], drive[6]), int(drive[7])
    )
    if not progress.begun:
        progress.mass, progress.restitution, progress.vibration_start = (
            drive[8],
            drive[10],
            drive[11],
        )
        progress.velocity = progress.approach = drive[9]
        progress.scale, progress.error, progress.dt = abs(drive[9]), pace.error, pace.first
        progress.scale *= SLOWEST if progress.crush.points > 0 else 1.0  # the rest shows on the way
        progress.least = pace.first if pace.error < np.inf else np.inf
    return pace


def march_of(model: StepFunctions, longer: float = LONGER, cut: float = CUT) -> Any:
    """The march of a model: `march(s, pace, progress, records) -> status, rows written`.

    `longer`: times as long a step may be as the one before; `cut`: least share of its length that a
    repeated step keeps. The status is GOING when the records (three rows at least) are full: read
    them and call again. The very first row is the start.
    """
    (
        hit,
        solve,
        settle,
        accept,
        write,
        lost,
        mass_of,
        apply_impulse,
        is_free_vibration,
        closed_form_tail,
        step,
    ) = model
    step = step or contact_step_of(hit, solve)

    @called
    def record(s, pace, progress, records, n):
        """Write the committed state as row n."""
        write(s, records, n)
        row, (place, speed) = records[n], hit(s)
        row.time = min(progress.time, pace.duration)
        row.displacement, row.velocity = place, speed
        row.striker_velocity, row.contact_loss = progress.velocity, progress.contact_loss
        row.kinetic += 0.5 * progress.mass * progress.velocity**2
        row.external_work += progress.weighed
        row.percussion, progress.carried = progress.carried, 0.0
        progress.recorded = progress.time

    @uncounted
    def meeting(pace, progress, dt, instant, gap, gamma, end, slack):
        """Length of an open step that meets the striker on its way, else dt."""
        least = SHORTEST * pace.first if instant else pace.first
        if dt <= least:
            return dt
        allowed = slack if instant else pace.error * progress.scale * dt
        when = contact_time(
            gap, gamma, end - progress.velocity - dt * progress.gravity, dt, allowed
        )
        return max(when, least) if when < dt else dt

    @uncounted
    def to_peak(progress, dt, place, speed, end):
        """Share of a step at which the impact point comes to rest, farther than ever; else 1."""
        passes = min(speed, -end) > AT_REST * progress.scale
        if passes and place + 0.5 * dt * (speed + end) > progress.peak:
            return max(speed / (speed - end), CUT)
        return 1.0

    @uncounted
    def march(s, pace, progress, records):
        n, end_time, controlled = 0, pace.duration * (1.0 - 1e-12), pace.error < np.inf
        slowest, crushes = APART * progress.approach, progress.crush.points > 0
        if not progress.begun:
            progress.begun, progress.highest = True, hit(s)[0]
            record(s, pace, progress, records, 0)
            n = 1
        while progress.time < end_time:
            if n + 2 > records.size:
                return GOING, n
            progress.steps += 1  # a collision at an instant, which takes no time, is one as well
            if progress.steps > pace.most:
                return TOO_MANY, n
            (place, speed), mass = hit(s), progress.mass
            struck_mass = 0.0 if crushes else mass_of(s)  # what crushes meets nothing at an instant
            gap, gamma = np.inf, 0.0
            slack = LASTING * progress.approach * pace.first
            if mass > 0.0:
                gap, gamma = place - progress.place, speed - progress.velocity
                gap += front(progress.crush)
            if controlled:
                slack = CLOSE * progress.approach * pace.first + 4.0 * EPS * abs(progress.place)
            if (
                struck_mass > 0.0
                and (controlled or progress.time == 0.0)
                and gap <= slack
                and gamma < -slowest
            ):
                e = progress.restitution
                e = e if -gamma * e > SOFT * progress.approach else 0.0
                impulse = explicit_percussion(gamma, gamma, e, struck_mass, mass)
                apply_impulse(s, impulse / struck_mass)
                progress.velocity -= impulse / mass
                after = gamma + impulse / struck_mass + impulse / mass
                progress.contact_loss += contact_loss(impulse, gamma, after)
                progress.carried += impulse
                progress.pushed = 0.0
                progress.smooth, progress.dt, progress.error = False, pace.first, pace.error
                given = speed + impulse / struck_mass
                progress.scale = given if progress.time == 0.0 else max(given, progress.scale)
                continue
            instant = struck_mass > 0.0 and controlled
            dt = next_step_size(
                pace, progress.time, progress.dt, 0.0 if instant else CLOSER * gap, gamma
            )
            if instant and gap > slack and gamma < 0.0:
                dt = min(dt, -gap / gamma)
            can_touch = gap <= slack if instant else may_touch(gap, gamma, dt, slack)
            done, impulse, end, left = step(s, progress, dt, can_touch)
            if not done:
                progress.cuts += 1
                released, progress.release = progress.release, 0.0
                progress.dt = released if released > 0.0 else 0.5 * dt
                if progress.dt < pace.first / PIECES:
                    return NO_CONVERGENCE, n
                continue
            if controlled and impulse == 0.0 and not crushes:
                shorter = meeting(pace, progress, dt, instant, gap, gamma, end, slack)
                if shorter < dt:
                    progress.dt = shorter
                    continue
            flow, factor = settle(s, dt), 0.0
            acceleration = (end - speed) / dt
            change = acceleration - progress.acceleration
            place1 = place + 0.5 * dt * (speed + end)
            struck = impulse > 0.0 and gamma < -slowest and not crushes
            if impulse > 0.0 and (crushes or progress.gravity != 0.0):
                progress.error, progress.scale = pace.error, max(progress.scale, end)
            if struck:  # factor 0: the next step is as short as the first
                progress.error = pace.error
            else:
                free = place1 < progress.highest and end > 0.0 and impulse == 0.0
                factor = step_factor(progress, pace, longer, cut, dt, change, free, flow)
                share = to_peak(progress, dt, place, speed, end) if controlled else 1.0
                if share < 1.0 and dt > pace.first:
                    factor = -min(share, abs(factor))
                if factor < 0.0:
                    progress.dt = max(-factor * dt, pace.first)
                    continue
                progress.change = change if progress.smooth else 0.0
                progress.acceleration = acceleration
            if progress.time > progress.recorded and (
                progress.time + dt - progress.recorded > pace.spacing
            ):
                record(s, pace, progress, records, n)
                n += 1
            if speed > 0.0 >= end:
                rise = dt * speed / (speed - end)
                if place + 0.5 * rise * speed > progress.peak:
                    progress.peak = place + 0.5 * rise * speed
                    progress.time_of_peak = progress.time + rise
            accept(s, dt)
            if mass > 0.0:
                faster = dt * progress.gravity - impulse / mass
                way = dt * (progress.velocity + 0.5 * faster)
                progress.weighed += mass * progress.gravity * way
                progress.place, progress.velocity = progress.place + way, progress.velocity + faster
            progress.carried += impulse
            progress.contact_loss += left
            progress.pushed, progress.release = impulse / dt, 0.0
            progress.smooth, progress.before, progress.time = not struck, dt, progress.time + dt
            progress.highest = max(progress.highest, place1)
            progress.dt = min(max(dt * factor, pace.first), pace.longest)
            if lost(s):
                record(s, pace, progress, records, n)
                return COLLAPSE, n + 1
            going = progress.time < end_time  # what has ended coasts nowhere
            if impulse == 0.0 and controlled and going and is_free_vibration(s, progress):
                record(s, pace, progress, records, n)
                return DONE, closed_form_tail(s, pace, progress, records, n) + 1
        record(s, pace, progress, records, n)
        return DONE, n + 1

    return march


RECORDS = 40, 20_000  # of a period in which a striker is crushed, of a whole record at most


class FollowedImpact(NamedTuple):
    """A followed impact: table of `records`, `progress` at the end, whether it `collapsed`."""

    records: Any
    progress: Any
    collapsed: bool

    @property
    def histories(self) -> dict[str, Array]:
        """The columns of the records."""
        return histories_of(self.records)

    def peak(self, bounces: bool = False) -> dict[str, float]:
        """Largest displacement at which the impact point stood still, and when; empty without one.

        Negative where it swings back farther.
        With `bounces` the column may come as far again: then the time is that of the first peak.
        """
        peak, when = standstill(self.records, self.progress, bounces)
        return {} if isnan(peak) else {"peak_displacement": peak, "time_of_peak": when}


@njit(cache=True, error_model="numpy")
def standstill(records, progress, bounces):
    """Peak (m) of an impact and its time (s), see `FollowedImpact.peak`; NaN without one."""
    time, v = records["time"], records["displacement"]
    largest, at, grows = signed_peak(time, v)
    if grows or not progress.peak > 0.0:
        return np.nan, np.nan
    if largest < 0.0:
        return largest, at
    when = progress.time_of_peak
    if bounces:
        first = first_peak(time, v)[1]
        if np.searchsorted(time, when) - np.searchsorted(time, first) > 1:
            when = first
    return progress.peak, when


def follow(
    entry: Any,
    tables: tuple[Any, ...],
    pace: Pace,
    drive: tuple[float, ...],
    of: Any,
    striker: Striker | None = None,
    gravity: float = 0.0,
) -> FollowedImpact:
    """Follow one impact by the compiled `entry` of a model.

    Arguments: the `tables` that it takes first; `pace`; the `drive` after it, see
    `integrator.begin`; the type `of` its records; the `striker`, for the law by which it crushes,
    and the `gravity` (m/s2) along its flight. Raises `SolverError`.
    """
    progress, records = np.zeros(1, PROGRESS), np.empty(pace.records, of)
    progress["gravity"] = gravity
    if striker is not None and striker.crushes:
        progress["crush"] = law_of(striker)
    status, rows = entry(*tables, np.array((*pace, *drive)), progress, records)
    check_end(status, progress[0], pace)
    return FollowedImpact(records[:rows], progress[0], status == COLLAPSE)


def check_end(status: int, reached: Any, pace: Pace) -> None:
    """Raise `SolverError` where a march has stopped before the end, as far as it has `reached`."""
    if status in (NO_CONVERGENCE, TOO_MANY):
        where = f"time {reached['time']:.6g} s"
        tried = f"open and closed contact, steps down to 1/{PIECES} of the first"
        if status == TOO_MANY:
            tried = f"{pace.most} steps; a softer or heavier structure needs fewer"
        raise SolverError(where, float(reached["residual"]), tried)


def histories_of(records: Any) -> dict[str, Array]:
    """The columns of a table of numbers as arrays of their own, time last."""
    flat = records.view(float).reshape(len(records), -1).T.copy()
    return {
        name: flat[at // 8 : at // 8 + prod(of.shape)].reshape(*of.shape, -1)
        for name, (of, at) in records.dtype.fields.items()
    }


def law_of(striker: Striker | None) -> Any:
    """The law of a striker as a record of CRUSH, not yet crushed; without points if it is rigid."""
    law = np.zeros(1, CRUSH)
    if striker is not None and striker.crushes:
        points = np.array(striker.crush or [(0.0, 0.0)])
        slopes = np.diff(points[:, 1]) / np.diff(points[:, 0])
        law["points"], law["beyond"] = len(points), striker.stiffness or 0.0
        law["strokes"][0, : len(points)], law["forces"][0, : len(points)] = points.T
        law["unloading"] = UNLOADING * max(slopes.max(initial=0.0), law["beyond"][0])
    return law[0]


def followed(pace: Pace, striker: Striker, struck: float) -> Pace:
    """The pace at which the force of a crushing striker on a mass (kg) is recorded as it swings."""
    if not striker.crushes or not pace.error < np.inf:
        return pace
    slope = float(law_of(striker)["unloading"]) / UNLOADING
    period = 2.0 * pi / sqrt(slope * (1.0 / struck + 1.0 / striker.mass))
    spacing = min(pace.spacing, max(period / RECORDS[0], pace.duration / RECORDS[1]))
    return pace._replace(spacing=spacing)
