"""Metrics of curves over displacement, such as the force-displacement curve of a pushover."""

import numpy as np

from workbench.assessment.metric import Array, Common, Scope, metric, on_common_base, present
from workbench.errors import InputError
from workbench.responses import Response

_SAMPLES = 400  # points along each curve; the distance changes by less than 1e-3 of itself beyond


def _curve(response: Response, quantity: str, side: str) -> tuple[Array, Array]:
    y = present(response, quantity, side)
    x = present(response, "displacement", side)
    if y.ndim != 1 or y.shape != x.shape or len(y) < 2:
        raise InputError(
            f"{side}.{quantity}", y.shape, "must be a curve of 2 points or more over displacement"
        )
    return x, y


def common_range(response: Response, reference: Response, quantity: str) -> Common:
    """Both curves on the union of their displacements, over the range that both cover.

    Raises `InputError` if a curve's displacement does not increase or the ranges do not meet.
    """
    records = []
    for side, given in (("response", response), ("reference", reference)):
        records.append(_curve(given, quantity, side))
        if np.any(np.diff(records[-1][0]) <= 0.0):
            shape, advice = records[-1][0].shape, "use arc_length_distance"
            raise InputError(f"{side}.displacement", shape, "must increase", advice)
    return on_common_base(records[0], records[1], quantity)


def absolute_area(x: Array, y: Array) -> float:
    """Integral of |y| of a piecewise linear y(x), exact where it crosses zero."""
    a, b = np.abs(y[:-1]), np.abs(y[1:])
    crossing = y[:-1] * y[1:] < 0.0
    total = np.where(a + b > 0.0, a + b, 1.0)
    area = np.where(crossing, (a * a + b * b) / (2.0 * total), 0.5 * (a + b))
    return float(np.sum(np.diff(x) * area))


@metric("area between the curves", Scope.CURVE, "jekel2019", low=0.0)
def area_difference(response: Response, reference: Response, quantity: str) -> float:
    """Area between both curves over the area under the reference.

    Raises `InputError` as `common_range` does, and if the reference is zero throughout.
    """
    x, values, held_against = common_range(response, reference, quantity)
    return absolute_area(x, values - held_against) / _area(x, held_against, quantity)


@metric("difference of work", Scope.CURVE, "jekel2019")
def work_difference(response: Response, reference: Response, quantity: str) -> float:
    """Signed area between both curves over the area under the reference.

    The work too much. Raises `InputError` as `area_difference` does.
    """
    x, values, held_against = common_range(response, reference, quantity)
    return float(np.trapezoid(values - held_against, x)) / _area(x, held_against, quantity)


def _area(x: Array, y: Array, quantity: str) -> float:
    area = absolute_area(x, y)
    if area == 0.0:
        raise InputError(quantity, 0.0, "of the reference is zero over the common range")
    return area


@metric("distance along the curves", Scope.CURVE, "witowski2012", low=0.0)
def arc_length_distance(response: Response, reference: Response, quantity: str) -> float:
    """Distance of points at equal shares of arc length, axes scaled by the reference.

    Root of the mean square; curves may turn back (unloading). Both end where the shorter one
    reaches its largest displacement. Raises `InputError` if the reference has no extent along an
    axis.
    """
    x1, y1 = _curve(response, quantity, "response")
    x2, y2 = _curve(reference, quantity, "reference")
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
