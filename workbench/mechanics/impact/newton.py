"""Newton's method for the equations of a time step, whatever solves them: registers or bands.

A line search on the work of the residual along the step follows the tangent of its last point where
that stays inside the bracket: hinges unload at a kink, on whose far side the step is steep.
"""

from typing import Any, NamedTuple

import numpy as np

from workbench.mechanics.impact.contact import called, inner

ITERATIONS, SEARCHES = 25, 8
LARGEST_CUT, SMALLEST_CUT = 0.9, 0.1  # bounds of a regula-falsi factor
CLOSEST = 0.02  # of a bracket, to its ends, that the tangent along a step may lead
FALLEN = 0.1  # of the residual, with which a step is taken whatever its slope
STALLED = 100.0  # times the allowed residual; iterations that stall below it have converged too


@inner
def no_finish(s, size):
    """Every step is evaluated."""
    return False


class Equations(NamedTuple):
    """Functions of a step over a system `s`, compiled; see `integrator.StepFunctions`.

    `vectors(s) -> x, start, step, residual`: unknowns (n,), where Newton's step began, the step.
    `evaluate(s, dt, closed, touch, striker) -> size`: residual and tangent at x, and its size.
    `allowed(s, dt, size) -> float`: with which a step is solved, `size` that of the first guess.
    `aim(s) -> bool`: writes Newton's step; false if there is none.
    `bend(s) -> float`: d'Kd of the step d with the tangent K at x.
    `finish(s, size) -> bool`: optional, may aim, take the step without an evaluation, and end.
    """

    vectors: Any
    evaluate: Any
    allowed: Any
    aim: Any
    bend: Any
    finish: Any = no_finish


def newton_of(equations: Equations) -> Any:
    """Newton's method: `newton(s, dt, closed, touch, striker) -> done, residual, evaluations`.

    The unknowns hold the first guess; the residual is that over the allowed one.
    """
    vectors, evaluate, allowed, aim, bend, finish = equations

    @called
    def newton(s, dt, closed, touch, striker):
        x, start, step, residual = vectors(s)
        n, limit, size, slope, share = x.size, np.inf, np.inf, 0.0, 1.0
        low, slope_low, high, slope_high = 0.0, 0.0, np.nan, np.nan
        iterations, searches = 0, 0
        for count in range(1, ITERATIONS * SEARCHES):
            new_size, new_slope = evaluate(s, dt, closed, touch, striker), 0.0
            if count == 1:
                limit = allowed(s, dt, new_size)
            else:
                for i in range(n):
                    new_slope += step[i] * residual[i]
                searches += 1
            finite = np.isfinite(new_slope)
            good = abs(new_slope) <= 0.5 * abs(slope) or new_size <= FALLEN * size
            # without a sign change in reach the step is taken, the tangent will follow
            far = finite and new_slope * slope > 0.0 and np.isnan(high)
            if not (count == 1 or good or far or searches == SEARCHES):
                if not finite or new_slope * slope <= 0.0:
                    high, slope_high = share, new_slope
                else:
                    low, slope_low = share, new_slope
                part = (share - new_slope / bend(s) - low) / (high - low)
                if not CLOSEST < part < 1.0 - CLOSEST:
                    part = 0.5
                    if np.isfinite(slope_high):
                        part = slope_low / (slope_low - slope_high)
                        part = min(max(part, SMALLEST_CUT), LARGEST_CUT)
                share = low + part * (high - low)
            else:
                size = new_size
                # where a step starts may be right by chance
                if finish(s, size) or (size <= limit and count > 1):
                    return True, size / limit, count
                if iterations == ITERATIONS or not (np.isfinite(size) and aim(s)):
                    break
                iterations, searches, slope, share = iterations + 1, 0, 0.0, 1.0
                for i in range(n):
                    start[i] = x[i]
                    slope += step[i] * residual[i]
                low, slope_low, high, slope_high = 0.0, slope, np.nan, np.nan
            for i in range(n):
                x[i] = start[i] + share * step[i]
        return size <= STALLED * limit, size / limit, count

    return newton
