"""Statistics over many cases: bias and scatter with intervals, and small decision trees.

A tree (Breiman et al. 1984) has regions of few bounds that a reader can check: splits lower a loss
most, at round numbers; a leaf is a box of the features.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import floor, inf, log10

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array, Indices
from workbench.errors import InputError


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

    Arguments: positive `model` and `data` values (n,), the data without a scatter of their own.
    With the log ratios' mean and standard deviation u, the bias is exp(mean + u^2/2). The
    interval is Cox's for the mean of a lognormal quantity, with Student quantiles.
    Raises `InputError` for values that are not positive or not in pairs.
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
    both = np.concatenate([values, references])
    if not (np.all(np.isfinite(both)) and np.all(both > 0.0)):
        raise InputError("model, data", both.min(), "must be positive")
    ratio: Array = np.log(values / references)
    return ratio


Loss = Callable[[Indices], float]  # of the members of a leaf
_DIGITS = 2  # of a bound
_QUANTILES = np.linspace(0.05, 0.95, 19)  # of a feature, where bounds are tried


@dataclass(frozen=True)
class Leaf:
    """A region: `bounds` of features, their numbers to (low, high), and the `members` in it."""

    bounds: dict[int, tuple[float, float]]
    members: Indices

    def holds(self, features: Array) -> bool:
        """Whether a point (features,) lies in it."""
        return all(low <= features[i] < high for i, (low, high) in self.bounds.items())


def grow(
    features: Array, loss: Loss, depth: int, fewest: int, leaf: Leaf | None = None
) -> Iterator[Leaf]:
    """Leaves of the tree of points (points, features) that lowers the sum of their `loss`.

    The loss is that of the members of a leaf, for instance of `impurity`. At most `depth` splits
    deep, with at least so many points in each; grown from a `leaf` (None: all points).
    """
    leaf = leaf or Leaf({}, np.arange(len(features)))
    best, place = loss(leaf.members) * (1.0 - 1e-9), (-1, 0.0)
    for i in range(features.shape[1]) if depth > 0 else ():
        values = features[leaf.members, i]
        for bound in dict.fromkeys(rounded(float(x)) for x in np.quantile(values, _QUANTILES)):
            below = values < bound
            if min(np.sum(below), np.sum(~below)) < fewest:
                continue
            lost = sum(loss(leaf.members[part]) for part in (below, ~below))
            if lost < best:
                best, place = lost, (i, bound)
    i, bound = place
    if i < 0:
        yield leaf
        return
    low, high = leaf.bounds.get(i, (-inf, inf))
    below = features[leaf.members, i] < bound
    for part, ends in ((below, (low, bound)), (~below, (bound, high))):
        child = Leaf({**leaf.bounds, i: ends}, leaf.members[part])
        yield from grow(features, loss, depth - 1, fewest, child)


def impurity(classes: Indices) -> Loss:
    """Gini impurity of the classes (points,) of the members of a leaf, times their number."""

    def gini(members: Indices) -> float:
        counts = np.bincount(classes[members])
        return float(len(members) - np.sum(counts**2) / len(members))

    return gini


def rounded(value: float) -> float:
    """The next number of two digits."""
    if value == 0.0:
        return 0.0
    return round(value, _DIGITS - 1 - floor(log10(abs(value))))
