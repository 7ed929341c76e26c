"""Bias and scatter of a model over many cases, with intervals."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workbench.assessment.metric import Array
from workbench.errors import InputError


@dataclass(frozen=True, slots=True)
class Bias:
    """Bias and scatter of the ratio of a model to data.

    `count` pairs; `bias`, the expected ratio; `low` and `high`, its confidence interval (None
    with fewer than two pairs); `total_scatter`, standard deviation of the log ratio (None with
    fewer than two pairs); `model_scatter`, that with the scatter of the data removed; `note`,
    one sentence where the numbers need one.
    """

    count: int
    bias: float
    low: float | None
    high: float | None
    total_scatter: float | None
    model_scatter: float | None
    note: str = ""


def bias_and_scatter(
    model: ArrayLike, data: ArrayLike, *, data_scatter: float = 0.0, confidence: float = 0.95
) -> Bias:
    """Bias factor and model scatter as the FDS validation guide defines them.

    Arguments: positive `model` and `data` values (n,); `data_scatter`, relative standard
    deviation of the data. With the log ratios' mean and standard deviation u, the model scatter
    is sqrt(u^2 - data_scatter^2) and the bias exp(mean + model_scatter^2/2 - data_scatter^2/2).
    The interval is Cox's for the mean of a lognormal quantity, with Student quantiles.
    Raises `InputError` for values that are not positive or not in pairs.
    """
    from scipy.stats import t as student

    ratio = _log_ratio(model, data)
    if not data_scatter >= 0.0:
        raise InputError("data_scatter", data_scatter, "must not be negative")
    if not 0.0 < confidence < 1.0:
        raise InputError("confidence", confidence, "must lie between 0 and 1")
    n, mean = len(ratio), float(np.mean(ratio))
    if n == 1:
        bias = float(np.exp(mean))
        return Bias(1, bias, None, None, None, None, "one case: no scatter, no interval")
    total = float(np.std(ratio, ddof=1))
    model_variance = max(total**2 - data_scatter**2, 0.0)
    note = ""
    if total < data_scatter:
        note = "the total scatter is smaller than that of the data, whose estimate is too large"
    centre = mean + 0.5 * model_variance - 0.5 * data_scatter**2
    from_scatter = total**4 / (2.0 * (n - 1)) if model_variance > 0.0 else 0.0
    width = float(student.ppf(0.5 + 0.5 * confidence, n - 1)) * np.sqrt(total**2 / n + from_scatter)
    low, bias, high = (float(x) for x in np.exp([centre - width, centre, centre + width]))
    return Bias(n, bias, low, high, total, float(np.sqrt(model_variance)), note)


def _log_ratio(model: ArrayLike, data: ArrayLike) -> Array:
    own, held_against = np.atleast_1d(model).astype(float), np.atleast_1d(data).astype(float)
    if own.shape != held_against.shape or own.ndim != 1 or len(own) == 0:
        raise InputError(
            "model, data", (own.shape, held_against.shape), "must be pairs, one or more"
        )
    both = np.concatenate([own, held_against])
    if not (np.all(np.isfinite(both)) and np.all(both > 0.0)):
        raise InputError("model, data", both.min(), "must be positive")
    ratio: Array = np.log(own / held_against)
    return ratio
