"""Metrics of two records: histories over time, and curves over displacement.

Between its instants a record is linear. Integrals run over the union of both grids, on which both
are linear from place to place, so that none of them depends on a resampling step.
"""

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import InputError
from workbench.study.assessment.metric import Common, Curves, Scope, Swap, metric, on_common_base

_SAMPLES = 400  # points along each curve; the distance changes by less than 1e-3 of itself beyond


def product_integral(time: Array, first: Array, second: Array) -> float:
    """Integral of the product of two piecewise linear functions (exact, by Simpson's rule)."""
    a, b, step = first, second, np.diff(time)
    ends = 2.0 * (a[:-1] * b[:-1] + a[1:] * b[1:])
    return float(np.sum(step * (ends + a[:-1] * b[1:] + a[1:] * b[:-1])) / 6.0)


def _energies(common: Common) -> tuple[float, float, float]:
    """Integrals of the squares of both histories and of their product, over equal factors."""
    time, values, reference, quantity = common
    # scaled, so that squares neither overflow nor vanish
    top, top_reference = float(np.max(np.abs(values))), float(np.max(np.abs(reference)))
    if top == 0.0 or top_reference == 0.0:
        raise InputError(quantity, 0.0, "is zero throughout the overlap", "use difference")
    a, b = values / top, reference / top_reference
    return (
        product_integral(time, a, a) * (top / top_reference) ** 2,
        product_integral(time, b, b),
        product_integral(time, a, b) * (top / top_reference),
    )


def _magnitude(square: float, reference_square: float) -> float:
    return float(np.sqrt(square / reference_square) - 1.0)


def _phase(square: float, reference_square: float, product: float) -> float:
    cosine = product / np.sqrt(square * reference_square)
    if cosine > 1.0 - 1e-14:  # equal histories: acos would blow rounding up to 1e-8
        return 0.0
    return float(np.arccos(max(cosine, -1.0)) / np.pi)


@metric("Sprague-Geers M", Scope.HISTORY, "sprague-geers", low=-1.0)
def sprague_geers_magnitude(common: Common) -> float:
    """Ratio of root-mean-square levels less one; blind to phase.

    M = sqrt(Scc/Stt) - 1. Raises `InputError` if one history is zero throughout.
    """
    return _magnitude(*_energies(common)[:2])


@metric("Sprague-Geers P", Scope.HISTORY, "sprague-geers", low=0.0, high=1.0, swap=Swap.SAME)
def sprague_geers_phase(common: Common) -> float:
    """Angle between both histories over pi; blind to magnitude.

    P = acos(Sct / sqrt(Scc Stt)) / pi. Raises `InputError` as the magnitude does.
    """
    return _phase(*_energies(common))


@metric("Sprague-Geers C", Scope.HISTORY, "sprague-geers", low=0.0)
def sprague_geers_comprehensive(common: Common) -> float:
    """Root of M squared plus P squared.

    Raises `InputError` as the magnitude does.
    """
    energies = _energies(common)
    return float(np.hypot(_magnitude(*energies[:2]), _phase(*energies)))


def _residuals(common: Common) -> tuple[Array, Array]:
    time, values, reference, quantity = common
    top = float(np.max(np.abs(reference)))
    if top == 0.0:
        raise InputError(quantity, 0.0, "of the reference is zero throughout the overlap")
    return time, (values - reference) / top


@metric("mean residual", Scope.HISTORY, "nchrp179")
def residual_mean(common: Common) -> float:
    """Mean difference over time, over the peak of the reference."""
    time, residual = _residuals(common)
    return float(np.trapezoid(residual, time) / (time[-1] - time[0]))


@metric("standard deviation of the residual", Scope.HISTORY, "nchrp179", low=0.0)
def residual_deviation(common: Common) -> float:
    """Standard deviation of the difference over time, over the peak of the reference."""
    time, residual = _residuals(common)
    span = time[-1] - time[0]
    centred = residual - np.trapezoid(residual, time) / span
    return float(np.sqrt(product_integral(time, centred, centred) / span))


def common_range(curves: Curves) -> Common:
    """Both curves on the union of their displacements, over the range that both cover.

    Raises `InputError` if a curve's displacement does not increase or the ranges do not meet.
    """
    for side in ("response", "reference"):
        x, _ = getattr(curves, side)
        if np.any(np.diff(x) <= 0.0):
            advice = "use arc_length_distance"
            raise InputError(f"{side}.displacement", x.shape, "must increase", advice)
    return on_common_base(*curves)


def absolute_area(x: Array, y: Array) -> float:
    """Integral of |y| of a piecewise linear y(x), exact where it crosses zero."""
    a, b = np.abs(y[:-1]), np.abs(y[1:])
    crossing = y[:-1] * y[1:] < 0.0
    total = np.where(a + b > 0.0, a + b, 1.0)
    area = np.where(crossing, (a * a + b * b) / (2.0 * total), 0.5 * (a + b))
    return float(np.sum(np.diff(x) * area))


@metric("area between the curves", Scope.CURVE, "jekel2019", low=0.0)
def area_difference(curves: Curves) -> float:
    """Area between both curves over the area under the reference.

    Raises `InputError` as `common_range` does, and if the reference is zero throughout.
    """
    common = common_range(curves)
    return absolute_area(common.at, common.values - common.reference) / _area(common)


@metric("difference of work", Scope.CURVE, "jekel2019")
def work_difference(curves: Curves) -> float:
    """Signed area between both curves over the area under the reference.

    The work too much. Raises `InputError` as `area_difference` does.
    """
    common = common_range(curves)
    return float(np.trapezoid(common.values - common.reference, common.at)) / _area(common)


def _area(common: Common) -> float:
    """Area under the reference."""
    area = absolute_area(common.at, common.reference)
    if area == 0.0:
        raise InputError(common.quantity, 0.0, "of the reference is zero over the common range")
    return area


@metric("distance along the curves", Scope.CURVE, "witowski2012", low=0.0)
def arc_length_distance(curves: Curves) -> float:
    """Distance of points at equal shares of arc length, axes scaled by the reference.

    Root of the mean square; curves may turn back (unloading). Both end where the shorter one
    reaches its largest displacement. Raises `InputError` if the reference has no extent along an
    axis.
    """
    (x1, y1), (x2, y2), quantity = curves
    end = min(x1.max(), x2.max())
    x1, y1 = _until(x1, y1, end)
    x2, y2 = _until(x2, y2, end)
    wide, high = np.ptp(x2), np.ptp(y2)
    if wide == 0.0 or high == 0.0:
        raise InputError(f"reference.{quantity}", (wide, high), "must have an extent on both axes")
    first = _resampled(x1 / wide, y1 / high)
    second = _resampled(x2 / wide, y2 / high)
    return float(np.sqrt(np.mean(np.sum((first - second) ** 2, axis=0))))


def _until(x: Array, y: Array, end: float) -> tuple[Array, Array]:
    beyond = np.flatnonzero(x > end)
    if len(beyond) == 0 or beyond[0] == 0:
        return x, y
    i = int(beyond[0])
    share = (end - x[i - 1]) / (x[i] - x[i - 1])
    last = y[i - 1] + share * (y[i] - y[i - 1])
    return np.append(x[:i], end), np.append(y[:i], last)


def _resampled(x: Array, y: Array) -> Array:
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    at = np.linspace(0.0, length[-1], _SAMPLES)
    return np.stack([np.interp(at, length, x), np.interp(at, length, y)])
