"""Discretisation error from four levels or more by least squares (Eca and Hoekstra 2014).

The values phi_i at sizes h_i are fitted by phi_0 + a h^p. Scatter, which a formula through three
points would take for an order, becomes a standard deviation and widens the uncertainty.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

Array = NDArray[np.float64]
RELIABLE = (0.5, 1.1)  # order over the expected one; the paper: 0.5 to 2.1 for order two
SEARCHED = (0.05, 8.0)  # orders among which a power law is sought
POINTS = 60  # of the search, before the best of them is refined


@dataclass(frozen=True, slots=True)
class Fit:
    """A fitted law: its `limit` at size zero, its value at the `finest` size, its order.

    `deviation`, the standard deviation of the values from it; `order` None where the exponents
    were given.
    """

    limit: float
    finest: float
    deviation: float
    order: float | None


def best_law(
    values: Sequence[float], ratio: float, expected_order: float
) -> tuple[Fit, float | None]:
    """The law that counts for the `values` of four levels or more, coarse to fine.

    Arguments: each level is `ratio` times finer than the one before; `expected_order` q of the
    method. All laws are fitted with equal weights and with weights that grow as 1/h, and the one
    that scatters least counts: a power law if its order lies within 0.5 to 1.1 of q; above that
    a h^q; below, or if there is none, the best of a h^q, a h^2q and a h^q + b h^2q. Result: its
    fit, and the order of the best power law (None: there is none).
    """
    phi = np.asarray(values, dtype=float)
    sizes = ratio ** np.arange(len(phi) - 1.0, -1.0, -1.0)
    weights = (np.full(len(phi), 1.0 / len(phi)), 1.0 / sizes / np.sum(1.0 / sizes))
    laws = [_power_law(phi, sizes, weight) for weight in weights]
    free = min((law for law in laws if law), key=lambda law: law.deviation, default=None)
    order = free.order if free is not None else None
    share = order / expected_order if order is not None else 0.0
    if free is not None and RELIABLE[0] <= share <= RELIABLE[1]:
        return free, order
    given = ((1.0,),) if share > RELIABLE[1] else ((1.0,), (2.0,), (1.0, 2.0))
    fits = [
        _fitted(phi, sizes, weight, expected_order * np.array(exponents))
        for weight in weights
        for exponents in given
    ]
    return min(fits, key=lambda found: found.deviation), order


def _power_law(phi: Array, sizes: Array, weights: Array) -> Fit | None:
    """The best phi_0 + a h^p; None if no order within the searched range is best."""

    def deviation(exponent: float) -> float:
        return _fitted(phi, sizes, weights, np.array([exponent]), free=True).deviation

    tried = np.geomspace(*SEARCHED, POINTS)
    best = int(np.argmin([deviation(float(p)) for p in tried]))
    if best in (0, POINTS - 1):
        return None
    bounds, fine = (tried[best - 1], tried[best + 1]), {"xatol": 1e-10}
    found = minimize_scalar(deviation, bounds=bounds, method="bounded", options=fine)
    return _fitted(phi, sizes, weights, np.array([float(found.x)]), free=True)


def _fitted(phi: Array, sizes: Array, weights: Array, exponents: Array, free: bool = False) -> Fit:
    """phi_0 + sum a_k h^p_k by linear least squares; `free`: the exponent counts as fitted too."""
    root = np.sqrt(weights)
    terms = np.column_stack([np.ones_like(sizes), sizes[:, None] ** exponents])
    solution = np.linalg.lstsq(terms * root[:, None], phi * root, rcond=None)[0]
    fitted = terms @ solution
    unknowns = len(exponents) + 1 + int(free)
    variance = len(phi) * np.sum(weights * (phi - fitted) ** 2) / (len(phi) - unknowns)
    return Fit(
        float(solution[0]),
        float(fitted[-1]),
        float(np.sqrt(variance)),
        float(exponents[0]) if free else None,
    )
