"""The contact law of striker and structure: Newton's restitution on velocities.

Moreau 1988; Heng 2017, 3.1 and 3.2, eqs 3.17-3.30. Gap g >= 0, gap velocity gamma = g'; the
impulse P of a step obeys 0 <= P perp xi = gamma_1 + e gamma_0 >= 0 while the contact is closed.
Explicit steps and collisions call `explicit_percussion`; implicit steps write xi = 0 into their
equations with the `rebound` given here (`contact_step_of`, which decides who touches). A striker
that crushes has no restitution: its impulse is that of its law.

**Second part.** A striker that crushes: a mass behind a force over its crushed length, one-sided,
with history.

The approach c of striker and impact point loads along the law F(c) of the scenario, straight
between its points; from the largest approach c_m on it unloads along one steep line,

    F = F(c_m) - k_u (c_m - c) >= 0,   k_u = UNLOADING times the largest slope of the law,

on which it is loaded again. A step acts with the mean force over its approach, whose work is exact;
that makes the impulse P a function of the velocity v1 of the impact point at its end. Near a trial
it is replaced by a line P = m* (touch - v1): the equation of a rigid contact with a lighter
striker, so that models solve steps with both alike. Derivation and numbers:
docs/theory/soft-impact.md.
"""

from typing import Any

import numpy as np

from workbench.base.compiled import njit
from workbench.mechanics.impact.pace import APART, RELEASED

MOST_POINTS = 50  # of a law, as in scenarios
UNLOADING = 100.0  # unloading over the largest loading slope: a rigid wall gives back a tenth of v
TRIES = 12  # lines through the law in a step before it is halved
CLOSE = 1e-9, 1e-12  # impulse as the law has it: of itself, of the momentum of the striker
_FLAT = 1e-9  # of the slope that stops the striker in a step: less is no line
CRUSH = np.dtype(
    [
        ("points", int),  # of the law; 0: the striker is rigid
        *((name, float, MOST_POINTS) for name in ("strokes", "forces")),  # m, N
        *(("beyond", float), ("unloading", float)),  # slopes: behind the last point, backwards, N/m
        ("crushed", float),  # largest approach so far, m
    ],
    align=True,
)


@njit(cache=True, error_model="numpy")
def envelope(law, at):
    """Force (N) and slope (N/m) of the law where `at` (m) was never passed."""
    i = law.points - 1
    while i > 0 and at < law.strokes[i]:
        i -= 1
    slope = law.beyond
    if i + 1 < law.points:
        slope = (law.forces[i + 1] - law.forces[i]) / (law.strokes[i + 1] - law.strokes[i])
    return law.forces[i] + slope * (at - law.strokes[i]), slope


@njit(cache=True, error_model="numpy")
def force_at(law, at):
    """Contact force (N) and slope (N/m) at an approach (m)."""
    if at > law.crushed:
        return envelope(law, at)
    force = envelope(law, law.crushed)[0] - law.unloading * (law.crushed - at)
    return (force, law.unloading) if force > 0.0 else (0.0, 0.0)


@njit(cache=True, error_model="numpy")
def front(law):
    """Approach (m) at which the crushed striker just touches; 0 of a rigid one."""
    if law.points == 0:
        return 0.0
    return law.crushed - envelope(law, law.crushed)[0] / law.unloading


@njit(cache=True, error_model="numpy")
def mean_force(law, start, end):
    """Mean force (N) from one approach (m) to another, and its slope (N/m) with that at the end."""
    low, high = min(start, end), max(start, end)
    at, (force, slope) = low, force_at(law, low)
    work, kinks = 0.0, 0
    for i in range(-2, law.points):
        knot = front(law) if i == -2 else law.crushed if i == -1 else law.strokes[i]
        if at < knot < high:
            next_force = force_at(law, knot)[0]
            work += 0.5 * (force + next_force) * (knot - at)
            at, force, kinks = knot, next_force, kinks + 1
    last, slope = force_at(law, high)
    if kinks == 0:
        return 0.5 * (force + last), 0.5 * slope
    mean = (work + 0.5 * (force + last) * (high - at)) / (high - low)
    return mean, (force_at(law, end)[0] - mean) / (end - start)


@njit(cache=True, error_model="numpy")
def crush_line(law, start, end, dt, mass, speeds):
    """Impulse (N s) of a step between two approaches (m), and the line on which it changes.

    Arguments: `dt` of the step (s); `mass` of the striker; `speeds`, its velocity at the start and
    without P at the end, less that of the impact point at the start (m/s). Result: impulse, m* (kg)
    and touch (m/s) of the line.
    """
    force, slope = mean_force(law, start, end)
    softness = 2.0 / max(dt * dt * slope, 2.0 * _FLAT * mass)
    touch = speeds + 2.0 * (start - end) / dt + dt * force * softness
    return dt * force, 1.0 / (1.0 / mass + softness), touch


@njit(cache=True, error_model="numpy")
def approach_at(start, dt, mass, speeds, impulse, end_speed):
    """Approach (m) at the end of a step, by the velocities (m/s) of both bodies."""
    return start + 0.5 * dt * (speeds - impulse / mass - end_speed)


@njit(cache=True, error_model="numpy")
def obeys(law, impulse, wanted, mass, velocity):
    """Whether an `impulse` (N s) is the one that the law wants, of a striker that came so fast."""
    return abs(wanted - impulse) <= CLOSE[0] * wanted + CLOSE[1] * mass * velocity


# Small functions that end in one entry: inlined, without the wrappers that Python would call.
_WRAPPERS: Any = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": True}
inner = njit(error_model="numpy", forceinline=True, **_WRAPPERS)
called = njit(error_model="numpy", **_WRAPPERS)  # the same, large and called in several places
# Inlined, without counting arrays at every call: that costs more than a step of one mass, and the
# entry holds them anyway. Such functions make no arrays and return none; nor may the kernels that
# they call, which are compiled in the same way.
uncounted = njit(error_model="numpy", forceinline=True, **(_WRAPPERS | {"_nrt": False}))


@njit(cache=True, error_model="numpy")
def rebound(gamma_start: float, restitution: float) -> float:
    """Restitution that the step uses: e while approaching, 1 while separating.

    Contact is enforced on velocities, so a drifted gap can be closed while the bodies separate.
    Newton's law with e < 1 would then do positive work on the mean gap velocity and create
    energy; with 1 the mean gap velocity, and so that work, is zero.
    """
    return 1.0 if gamma_start > 0.0 else restitution


@njit(cache=True, error_model="numpy")
def may_touch(gap: float, gamma: float, dt: float, slack: float) -> bool:
    """Whether a step of `dt` can be one of contact: the gap at its end, if it only closes."""
    return gap + dt * min(gamma, 0.0) <= slack


@njit(cache=True, error_model="numpy")
def touch_velocity(striker: float, gamma: float, restitution: float) -> float:
    """Velocity of the impact point at the end of a closed step, from the striker's without P.

    An open step is admissible if the impact point is at least as fast at its end.
    """
    return striker - rebound(gamma, restitution) * gamma


@njit(cache=True, error_model="numpy")
def accepts(fits: bool, can_touch: bool, closed: bool, refused: bool) -> bool:
    """Whether a solved state of contact is taken: it fits, or nothing else is left.

    Arguments: `fits`, P >= 0 or open and not slower than `touch_velocity`; `can_touch`, whether
    contact was possible; whether it was `closed`; whether the other state was solved and `refused`.
    A closed contact that pulls must open, whatever the open solution says of velocities.
    """
    return fits or not can_touch or (refused and not closed)


@njit(cache=True, error_model="numpy")
def explicit_percussion(
    gamma_free: float, gamma_start: float, restitution: float, mass: float, striker_mass: float
) -> float:
    """Impulse (N s) from the gap velocity without contact; one contact needs no iteration.

    The factor r of Heng 2017, eq. 3.28, must be (w' M^-1 w)^-1, in kg, as here; eq. 3.29 prints
    its inverse.
    """
    xi = gamma_free + rebound(gamma_start, restitution) * gamma_start
    return max(-xi, 0.0) / (1.0 / mass + 1.0 / striker_mass)


@njit(cache=True, error_model="numpy")
def contact_loss(percussion: float, gamma_start: float, gamma_end: float) -> float:
    """Energy lost in the contact during the step: minus the work of P on the mean gap velocity."""
    return -0.5 * percussion * (gamma_start + gamma_end)


def contact_step_of(hit: Any, solve: Any, released: bool = True) -> Any:
    """The step of a model that writes contact into its equations; see `integrator.StepFunctions`.

    `step(s, progress, dt, can_touch) -> done, impulse (N s), end velocity of the impact point
    (m/s), energy lost in contact (J)`; `can_touch`: whether contact is possible. The step is solved
    closed if bodies do not separate, else open, and the other way if the law refuses that.
    `released`: a step in which the contact opens is not done; its length up to there, by a straight
    line through the mean forces of two steps, is written as `progress.release`. Not for forces that
    ring. Of a striker that crushes the step is solved with lines through its law until the impulse
    obeys that.
    """

    @uncounted
    def step(s, progress, dt, can_touch):
        (place, speed), mass, law = hit(s), progress.mass, progress.crush
        gamma, free = speed - progress.velocity, progress.velocity + dt * progress.gravity
        touch = touch_velocity(free, gamma, progress.restitution)
        closed, refused, striker = can_touch and gamma <= APART * progress.approach, False, mass
        tries, crushes = 2 if can_touch else 1, law.points > 0
        start, speeds = progress.place - place, progress.velocity + free - speed
        if crushes:
            law.crushed = max(law.crushed, start)
            wanted, striker, touch = crush_line(law, start, start - dt * gamma, dt, mass, speeds)
            closed, tries = wanted > 0.0, TRIES
        for _ in range(tries):
            done, end, residual, count = solve(s, dt, closed, touch, striker)
            progress.residual = residual
            progress.evaluations += count
            impulse = striker * (touch - end) if closed else 0.0
            if crushes:
                if not done:
                    break
                reached = approach_at(start, dt, mass, speeds, impulse, end)
                wanted, striker, touch = crush_line(law, start, reached, dt, mass, speeds)
                if obeys(law, impulse, wanted, mass, progress.approach):
                    lost = contact_loss(impulse, gamma, end - free + impulse / mass)
                    return True, impulse, end, lost
                closed = wanted > 0.0
                continue
            if released and done and impulse < 0.0 and progress.pushed > 0.0:  # no force there
                bend = 2.0 * (progress.pushed - impulse / dt) / (dt + progress.before)
                release = progress.pushed / bend - 0.5 * progress.before
                if progress.least < release < RELEASED * dt:
                    progress.release = release
                    return False, 0.0, 0.0, 0.0
            fits = impulse >= 0.0 if closed else end >= touch
            if done and accepts(fits, can_touch, closed, refused):
                left = 0.0
                if closed:
                    left = contact_loss(impulse, gamma, end - free + impulse / mass)
                return True, impulse, end, left
            refused, closed = refused or done, not closed
        return False, 0.0, 0.0, 0.0

    return step
