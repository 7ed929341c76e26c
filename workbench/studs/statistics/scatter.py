"""Whether tests tell the scatters of several formulas apart, whose residuals go together.

Source: Pitman 1939, the ratio of the standard deviations of correlated normal variables.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

LIKE = 1.01  # ratio of scatters that is no difference: an interval must lie above it
_EQUAL = 1e-12  # of squares of logarithms


def rank_scatters(tests: Mapping[str, Any], confidence: float) -> tuple[str, list[dict[str, Any]]]:
    """The formula of least scatter within campaigns, among equals the first, and its rivals.

    `tests`: rows with campaign, specimen and ratio, test over prediction, by formula; those count
    that every formula has a value for. A rival: `name`, `ratio` of its scatter to the least one
    with its interval `low`, `high` (None with too few tests), and `apart`, whether that lies above
    `LIKE`.
    """
    from scipy.special import stdtrit

    key = ["campaign", "specimen"]
    ratios = {name: pd.DataFrame(rows).set_index(key)["ratio"] for name, rows in tests.items()}
    logs = pd.DataFrame(ratios).dropna().apply(np.log)
    campaigns = logs.groupby(level="campaign")
    left, nu = logs - campaigns.transform("mean"), len(logs) - campaigns.ngroups - 1
    products = left.T.to_numpy() @ left.to_numpy()
    squares = np.diag(products)
    best = int(np.flatnonzero(squares <= squares.min() + _EQUAL)[0])
    rivals: list[dict[str, Any]] = []
    for k in (k for k in range(len(squares)) if k != best):
        ends: tuple[float | None, ...] = (None, None, None)
        apart = False
        if nu > 0 and squares[best] > _EQUAL:
            ratio = float(np.sqrt(squares[k] / squares[best]))
            open_ = max(1.0 - products[k, best] ** 2 / (squares[k] * squares[best]), 0.0)
            wide = 1.0 + 2.0 * open_ * float(stdtrit(nu, 0.5 + 0.5 * confidence)) ** 2 / nu
            factor = float(np.sqrt(wide + np.sqrt(wide**2 - 1.0)))
            ends, apart = (ratio, ratio / factor, ratio * factor), ratio / factor > LIKE
        told = dict(zip(("ratio", "low", "high"), ends, strict=True))
        rivals.append({"name": str(left.columns[k]), **told, "apart": apart})
    return str(left.columns[best]), rivals
