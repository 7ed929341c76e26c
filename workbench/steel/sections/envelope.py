"""Exact plastic interaction of axial force and moment, and its super-elliptic fit."""

from collections.abc import Callable
from functools import cache

import numpy as np

from workbench.base.arrays import Array, Flags
from workbench.base.errors import SolverError
from workbench.steel.sections.shapes import Shape, half_integrals

_LARGEST_EXPONENT = 20.0


def envelope(shape: Shape, points: int) -> tuple[Array, Array]:
    """Axial force N/N_p and moment M/M_p of the fully plastic section, [points] each.

    The neutral axis moves from the centroid (pure bending) to the edge (pure axial force); the
    stress resultants are closed forms of its height. The points lie at equal angles
    atan2(n, m), each found by bisection to machine precision.
    """
    half, bands = shape.height / 2.0, shape.bands
    whole_area, whole_first, _ = half_integrals(bands, half)

    def resultants(axis: Array) -> tuple[Array, Array]:
        area, first, _ = half_integrals(bands, axis)
        return area / whole_area, 1.0 - first / whole_first

    angle = np.linspace(0.0, np.pi / 2.0, points)

    def too_low(axis: Array) -> Flags:
        n, m = resultants(axis)
        return n * np.cos(angle) < m * np.sin(angle)

    n, m = resultants(where_it_ends(too_low, np.full(points, half)))
    n[0], m[0], n[-1], m[-1] = 0.0, 1.0, 1.0, 0.0
    return n, m


def superellipse_radius(angle: Array, alpha: float, beta: float) -> Array:
    """Radius of |m|^alpha + |n|^beta = 1 at the angles atan2(n, m) in [0, pi/2]."""
    cosine, sine = np.cos(angle), np.sin(angle)

    def inside(radius: Array) -> Flags:
        return np.asarray((radius * cosine) ** alpha + (radius * sine) ** beta < 1.0)

    return where_it_ends(inside, np.full_like(angle, np.sqrt(2.0)))


def where_it_ends(below: Callable[[Array], Flags], high: Array) -> Array:
    """Return the ends of `below` between 0 and `high`, to the last bit, by bisection."""
    low = np.zeros_like(high)
    for _ in range(60):
        middle = (low + high) / 2.0
        left = below(middle)
        low, high = np.where(left, middle, low), np.where(left, high, middle)
    return (low + high) / 2.0


@cache
def corner_share(shape: Shape, points: int = 181) -> float:
    """Axial force over N_p up to which a surface of straight lines keeps the plastic moment.

    The line falls from there to (N_p, 0), and the surface encloses the area A of the exact
    envelope: (1 + n) / 2 = A. It is within 0.06 M_p of that of I sections.
    """
    n, m = envelope(shape, points)
    return max(2.0 * float(np.trapezoid(m, n)) - 1.0, 0.0)


@cache
def fit_superellipse(shape: Shape, points: int = 181) -> tuple[float, float]:
    """Exponents (alpha of the moment, beta of the axial force) that fit the exact envelope.

    Least squares of the radii at equally spaced angles of the (n, m) plane, both exponents kept
    at 1 or above (below 1 the surface is not convex). Raises `SolverError`.
    """
    from scipy.optimize import least_squares

    n, m = envelope(shape, points)
    radius, angle = np.hypot(n, m), np.linspace(0.0, np.pi / 2.0, points)

    def error(exponents: Array) -> Array:
        return superellipse_radius(angle, exponents[0], exponents[1]) - radius

    bounds = ([1.0, 1.0], [_LARGEST_EXPONENT, _LARGEST_EXPONENT])
    fit = least_squares(error, (1.2, 1.6), bounds=bounds, xtol=1e-12, ftol=1e-14, gtol=1e-12)
    if not fit.success:
        raise SolverError("super-elliptic fit", float(fit.optimality), "trust region")
    # The solver stays a rounding error inside its bounds; a linear exponent means exactly 1.
    alpha, beta = (1.0 if x < 1.0 + 1e-9 else float(x) for x in fit.x)
    return alpha, beta
