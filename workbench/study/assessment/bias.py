"""Bias and scatter over many cases, with intervals."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array
from workbench.base.errors import InputError


@dataclass(frozen=True, slots=True)
class Bias:
    """Bias and scatter of the ratio of a model to data.

    `count` pairs; `bias`, the expected ratio; `low` and `high`, its 95 % confidence interval, and
    `model_scatter`, the standard deviation of the log ratio (None with fewer than two pairs).
    """

    count: int
    bias: float
    low: float | None = None
    high: float | None = None
    model_scatter: float | None = None


def bias_and_scatter(model: ArrayLike, data: ArrayLike) -> Bias:
    """Bias factor and model scatter as the FDS validation guide defines them.

    Arguments: pairs of `model` and `data` (n,), of one sign, the data without their own scatter.
    With the log ratios' mean and standard deviation u, the bias is exp(mean + u^2/2). The
    interval is Cox's for the mean of a lognormal quantity, with Student quantiles.
    Raises `InputError` for values of different signs, zeros, and values not in pairs.
    """
    from scipy.stats import t as student

    ratio = _log_ratio(model, data)
    n, mean = len(ratio), float(np.mean(ratio))
    if n == 1:
        return Bias(1, float(np.exp(mean)))
    scatter = float(np.std(ratio, ddof=1))
    centre = mean + 0.5 * scatter**2
    width = student.ppf(0.975, n - 1) * np.sqrt(scatter**2 / n + scatter**4 / (2.0 * (n - 1)))
    low, bias, high = (float(x) for x in np.exp([centre - width, centre, centre + width]))
    return Bias(n, bias, low, high, scatter)


def _log_ratio(model: ArrayLike, data: ArrayLike) -> Array:
    values, references = np.atleast_1d(model).astype(float), np.atleast_1d(data).astype(float)
    if values.shape != references.shape or values.ndim != 1 or len(values) == 0:
        shapes = values.shape, references.shape
        raise InputError("model, data", shapes, "must be pairs, one or more")
    ratio = values / np.where(references == 0.0, np.nan, references)
    if not (np.all(np.isfinite(ratio)) and np.all(ratio > 0.0)):
        raise InputError("model, data", ratio.min(), "must be finite and of one sign in each pair")
    logarithm: Array = np.log(ratio)
    return logarithm
