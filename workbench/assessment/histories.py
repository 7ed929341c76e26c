"""Metrics of time histories, on the overlap of both records.

Between its instants a history is linear. Integrals run over the union of both time grids, on
which both are linear from instant to instant, so that none of them depends on a resampling step.
"""

import numpy as np

from workbench.assessment.metric import Array, Common, Scope, Swap, metric, on_common_base, present
from workbench.errors import InputError
from workbench.responses import Response


def overlap(response: Response, reference: Response, quantity: str) -> Common:
    """Both histories of a quantity on the union of their time grids where both are known.

    Raises `InputError` if one is not a history in time or the records do not overlap.
    """
    records = []
    for side, given in (("response", response), ("reference", reference)):
        values = present(given, quantity, side)
        if given[quantity].dims != ("time",):
            allowed = "must be a history over time alone"
            advice = "choose a hinge first, or use a scalar or curve metric"
            raise InputError(f"{side}.{quantity}", given[quantity].dims, allowed, advice)
        records.append((np.asarray(given["time"].values, dtype=float), values))
    return on_common_base(records[0], records[1], quantity)


def product_integral(time: Array, first: Array, second: Array) -> float:
    """Integral of the product of two piecewise linear functions (exact, by Simpson's rule)."""
    a, b, step = first, second, np.diff(time)
    ends = 2.0 * (a[:-1] * b[:-1] + a[1:] * b[1:])
    return float(np.sum(step * (ends + a[:-1] * b[1:] + a[1:] * b[:-1])) / 6.0)


def _energies(response: Response, reference: Response, quantity: str) -> tuple[float, ...]:
    time, values, held_against = overlap(response, reference, quantity)
    # scaled, so that squares neither overflow nor vanish
    top, top_reference = float(np.max(np.abs(values))), float(np.max(np.abs(held_against)))
    if top == 0.0 or top_reference == 0.0:
        raise InputError(quantity, 0.0, "is zero throughout the overlap", "use difference")
    a, b = values / top, held_against / top_reference
    return (
        product_integral(time, a, a) * (top / top_reference) ** 2,
        product_integral(time, b, b),
        product_integral(time, a, b) * (top / top_reference),
    )


@metric("Sprague-Geers M", Scope.HISTORY, "sprague-geers", low=-1.0)
def sprague_geers_magnitude(response: Response, reference: Response, quantity: str) -> float:
    """Ratio of root-mean-square levels less one; blind to phase.

    M = sqrt(Scc/Stt) - 1. Raises `InputError` as `overlap` does, and if one history is zero
    throughout.
    """
    own, held_against, _ = _energies(response, reference, quantity)
    return float(np.sqrt(own / held_against) - 1.0)


@metric("Sprague-Geers P", Scope.HISTORY, "sprague-geers", low=0.0, high=1.0, swap=Swap.SAME)
def sprague_geers_phase(response: Response, reference: Response, quantity: str) -> float:
    """Angle between both histories over pi; blind to magnitude.

    P = acos(Sct / sqrt(Scc Stt)) / pi. Raises `InputError` as the magnitude does.
    """
    own, held_against, mixed = _energies(response, reference, quantity)
    cosine = mixed / np.sqrt(own * held_against)
    if cosine > 1.0 - 1e-14:  # equal histories: acos would blow rounding up to 1e-8
        return 0.0
    return float(np.arccos(max(cosine, -1.0)) / np.pi)


@metric("Sprague-Geers C", Scope.HISTORY, "sprague-geers", low=0.0)
def sprague_geers_comprehensive(response: Response, reference: Response, quantity: str) -> float:
    """Root of M squared plus P squared.

    Raises `InputError` as the magnitude does.
    """
    first = sprague_geers_magnitude(response, reference, quantity)
    second = sprague_geers_phase(response, reference, quantity)
    return float(np.hypot(first, second))


def _residuals(response: Response, reference: Response, quantity: str) -> tuple[Array, Array]:
    time, values, held_against = overlap(response, reference, quantity)
    top = float(np.max(np.abs(held_against)))
    if top == 0.0:
        raise InputError(quantity, 0.0, "of the reference is zero throughout the overlap")
    return time, (values - held_against) / top


@metric("mean residual", Scope.HISTORY, "nchrp179")
def residual_mean(response: Response, reference: Response, quantity: str) -> float:
    """Mean difference over time, over the peak of the reference."""
    time, residual = _residuals(response, reference, quantity)
    return float(np.trapezoid(residual, time) / (time[-1] - time[0]))


@metric("standard deviation of the residual", Scope.HISTORY, "nchrp179", low=0.0)
def residual_deviation(response: Response, reference: Response, quantity: str) -> float:
    """Standard deviation of the difference over time, over the peak of the reference."""
    time, residual = _residuals(response, reference, quantity)
    span = time[-1] - time[0]
    centred = residual - np.trapezoid(residual, time) / span
    return float(np.sqrt(product_integral(time, centred, centred) / span))
