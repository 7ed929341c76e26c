"""Overstress of a step: backward Euler of Cowper-Symonds flow under one or two stresses, compiled.

The unknown is x = (p / (D dt))^(1/q) with the equivalent plastic strain p of the step: in p itself
the slope of the overstress at rest has no bound. Derivation: docs/theory/strain-rate.md.
"""

import math

import numpy as np

from workbench.base.compiled import njit

ITERATIONS = 60
CLOSED = 1e-15  # step of Newton's method in x + 1 that is round-off


@njit(cache=True, error_model="numpy")
def rate_flow(
    excess: float, resistance: float, fy: float, D: float, q: float, duration: float
) -> tuple[float, float]:
    """Plastic strain of a step with Cowper-Symonds overstress, and d(strain)/d(excess).

    Solves resistance g + fy (g / (D dt))^(1/q) = excess for the plastic strain g, where
    `excess` is the trial stress above the static yield stress. In x = (g / (D dt))^(1/q) the left
    side is convex and rising, so that Newton's method from above is monotone.
    """
    scale = resistance * D * duration
    x = min(excess / fy, (excess / scale) ** (1.0 / q))
    for _ in range(ITERATIONS):
        power = scale * x ** (q - 1.0)
        change = (power * x + fy * x - excess) / (q * power + fy)
        x -= change
        if abs(change) <= 1e-15 * x:
            break
    strain_slope = D * duration * q * x ** (q - 1.0)  # dg/dx
    return D * duration * x**q, strain_slope / (resistance * strain_slope + fy)


@njit(cache=True, error_model="numpy")
def rate_multiplier(
    first: float,
    second: float,
    a: float,
    b: float,
    strength: float,
    H: float,
    fy: float,
    D: float,
    q: float,
    duration: float,
) -> tuple[float, float]:
    """Multiplier lam = p / s of a return from two trial stresses, and the stiffness s ds / dlam.

    With p = D dt x^q and the equivalent stress s = strength + H p + fy x at the end of the step
    solves (first / (s + a p))^2 + (second / (s + b p))^2 = 1: the inverse root of the left side
    rises with x, with one stress or a = b convexly, and Newton's method is kept inside the bracket
    that the smaller of the resistances gives. Arguments: trial stresses (Pa) outside of the yield
    surface, their `a` and `b` in Pa; `strength` at the start of the step, isotropic `H`, static
    yield stress `fy` that the overstress multiplies, in Pa; D in 1/s, q, `duration` in s. NaN if it
    does not converge.
    """
    scale = D * duration
    excess = max(math.sqrt(first * first + second * second) - strength, 0.0)
    x = min(excess / fy, (excess / ((min(a, b) + H) * scale)) ** (1.0 / q))
    low, high = 0.0, x
    for _ in range(ITERATIONS):
        power = scale * x ** (q - 1.0)
        p, slope = power * x, q * power
        s, rise = strength + H * p + fy * x, H * slope + fy
        across, along = s + a * p, s + b * p
        u, v = first / across, second / along
        square = u * u + v * v
        u *= u * (rise + a * slope) / across
        v *= v * (rise + b * slope) / along
        change = (1.0 - math.sqrt(square)) * square / (u + v)
        if abs(change) <= CLOSED * (1.0 + x):
            # p' s - p s' = power (q strength + (q - 1) fy x)
            return p / s, s**3 * rise / (power * (q * strength + (q - 1.0) * fy * x))
        if change > 0.0:
            high = x
        else:
            low = x
        x -= change
        if not low <= x <= high:
            x = 0.5 * (low + high)
    return np.nan, np.nan
