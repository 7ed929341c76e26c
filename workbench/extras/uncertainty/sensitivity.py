"""First and total Sobol indices where some answers are missing, with bootstrap intervals.

Rows A and B are independent, C_i is A with column i of B (Saltelli et al. 2010, Jansen's forms):

    T_i = mean((f_A - f_Ci)^2) / (2 V),   S_i = 1 - mean((f_B - f_Ci)^2) / (2 V_i)

Each mean is over the rows in which both answers exist, V_i the variance of exactly those values.
The indices then describe the answer given that both members exist; what decides whether there is an
answer is shown by the indices of that indicator, in which nothing is missing.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import InputError
from workbench.responses import COVERAGE
from workbench.studs.statistics.intervals import tails_of

REPETITIONS = 200
FEWEST_ROWS = 64
FEWEST_OF_A_KIND = 16  # answers, and missing ones, in A and in B, for indices of the indicator


class Index(NamedTuple):
    """An index with its interval of 90 %."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Indices:
    """First and total indices of each input; `rows`, how many have both members of each pair."""

    first: tuple[Index, ...]
    total: tuple[Index, ...]
    rows: tuple[int, ...]


def sobol_indices(A: Array, B: Array, C: Array, seed: int = 0) -> Indices:
    """Sobol indices of answers.

    `A`, `B` (rows,) and `C` (inputs, rows), NaN where there is no answer. Raises `InputError` where
    too few rows are left or the answer does not vary.
    """
    first, total, rows = [], [], []
    known = np.concatenate([A[np.isfinite(A)], B[np.isfinite(B)]])
    if len(known) < 2 * FEWEST_ROWS or not np.ptp(known) > 0.0:
        text = f"must be at least {FEWEST_ROWS} that differ"
        raise InputError("answers", len(known), text, "draw more samples, or wider inputs")
    middle = known.mean()
    drawn = np.random.default_rng(seed).multinomial(
        len(A), np.full(len(A), 1.0 / len(A)), REPETITIONS
    )
    weights = np.vstack([np.ones(len(A)), drawn.astype(float)])  # the first: the answer itself
    a, b = A - middle, B - middle
    variance = _variance(weights, a, b)
    for c in C - middle:
        pairs, half = _half_square(weights, a, c)
        total.append(_index(half / variance))
        rows.append(pairs)
        both = np.isfinite(b) & np.isfinite(c)
        _, half = _half_square(weights, b, c)
        own_variance = _variance(weights, np.where(both, b, np.nan), np.where(both, c, np.nan))
        first.append(_index(1.0 - half / own_variance))
    return Indices(tuple(first), tuple(total), tuple(rows))


def _half_square(weights: Array, x: Array, y: Array) -> tuple[int, Array]:
    """Number of whole pairs, and half the mean square of their difference for all weights."""
    both = np.isfinite(x) & np.isfinite(y)
    if both.sum() < FEWEST_ROWS:
        text = f"must be at least {FEWEST_ROWS} pairs with both answers"
        raise InputError("answers", int(both.sum()), text, "draw more samples")
    inside = weights[:, both]
    return int(both.sum()), inside @ (x[both] - y[both]) ** 2 / inside.sum(axis=1) / 2.0


def _variance(weights: Array, *columns: Array) -> Array:
    """Variance of the values that exist, for all weights."""
    count, sums, squares = np.zeros((3, len(weights)))
    for x in columns:
        exists = np.isfinite(x)
        inside = weights[:, exists]
        count = count + inside.sum(axis=1)
        sums = sums + inside @ x[exists]
        squares = squares + inside @ x[exists] ** 2
    return np.asarray(squares / count - (sums / count) ** 2)


def _index(values: Array) -> Index:
    low, high = np.quantile(values[1:], tails_of(COVERAGE))
    return Index(float(values[0]), float(low), float(high))
