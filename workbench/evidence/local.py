"""What is expected at a point from measured ones near it: a line through all, the mean rest near.

*Source:* Hoerl and Kennard 1970 for the ridge; Vovk, Gammerman and Shafer 2005 for rests whose own
value is left out (docs/theory/error-model.md).
"""

from functools import cached_property

import numpy as np

from workbench.arrays import Array

NEAREST = 20
RIDGE = 10.0  # on standard features
CUT = 0.02  # share of the values at each end that the line does not follow


class LocalMean:
    """Expected values from measured `values` (n,) at `points` (n, k), on any scales."""

    def __init__(self, points: Array, values: Array) -> None:
        self.values = values
        self._mean, self._scale = points.mean(axis=0), np.maximum(points.std(axis=0), 1e-9)
        self._places = self._standard(points)
        sides, shrink = self._with_one(self._places), RIDGE * np.eye(points.shape[1] + 1)
        shrink[0, 0] = 0.0
        cut = np.clip(values, *np.quantile(values, [CUT, 1.0 - CUT]))
        self._line = np.linalg.solve(sides.T @ sides + shrink, sides.T @ cut)
        self._off = cut - sides @ self._line

    def at(self, point: Array) -> float:
        """What is expected at a point (k,); measured ones at this very point are left out."""
        place = self._standard(point)
        distances = np.linalg.norm(self._places - place, axis=1)
        distances[distances == 0.0] = np.inf
        near = np.argsort(distances, kind="stable")[: min(NEAREST, len(distances) - 1)]
        weights = 1.0 - (distances[near] / distances[near[-1]]) ** 2 + 1e-9
        line = float(self._with_one(place) @ self._line)
        return line + float(weights @ self._off[near] / weights.sum())

    @cached_property
    def rests(self) -> Array:
        """The values less what the others make expect of them (n,)."""
        points = self._places * self._scale + self._mean
        rests: Array = self.values - np.array([self.at(point) for point in points])
        return rests

    def _standard(self, points: Array) -> Array:
        standard: Array = np.round((points - self._mean) / self._scale, 9)
        return standard

    @staticmethod
    def _with_one(places: Array) -> Array:
        sides: Array = np.concatenate([np.ones((*places.shape[:-1], 1)), places], axis=-1)
        return sides
