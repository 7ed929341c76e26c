"""A small decision tree: regions of few bounds that a reader can check (Breiman et al. 1984).

Splits lower a loss most, at round numbers; a leaf is a box of the features.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import floor, inf, log10

import numpy as np

from workbench.arrays import Array, Indices

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
        own = features[leaf.members, i]
        for bound in dict.fromkeys(rounded(float(x)) for x in np.quantile(own, _QUANTILES)):
            below = own < bound
            if min(np.sum(below), np.sum(~below)) < fewest:
                continue
            found = sum(loss(leaf.members[part]) for part in (below, ~below))
            if found < best:
                best, place = found, (i, bound)
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
