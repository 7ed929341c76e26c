"""A striker that crushes: a mass behind a force over its crushed length, one-sided, with history.

The approach c of striker and hit point loads along the law F(c) of the scenario, straight between
its points; from the largest approach c_m on it unloads along one steep line,

    F = F(c_m) - k_u (c_m - c) >= 0,   k_u = UNLOADING times the largest slope of the law,

on which it is loaded again. A step acts with the mean force over its approach, whose work is exact;
that makes the impulse P a function of the velocity v1 of the hit point at its end. Near a trial it
is replaced by a line P = m* (touch - v1): the equation of a rigid contact with a lighter striker,
so that models solve steps with both alike. Derivation and numbers: docs/theory/soft-impact.md.
"""

import numpy as np

from workbench.base.compiled import njit

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
    without P at the end, less that of the hit point at the start (m/s). Result: impulse, m* (kg)
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
