"""Statistics of groups of tests against simple formulas, without any fitting."""

from __future__ import annotations

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.studs.quantities import Array, specimens


def summarise(table: pd.DataFrame, by: str | None = None) -> pd.DataFrame:
    """Mean, scatter and ratios to simple formulas, one row per value of the column `by` (or one).

    Columns: `count`; `mean` load per stud (N) and its coefficient of `variation`; means of
    P / (0.5 A_s sqrt(f_c E_c)) as `over_concrete`, P / (A_s f_u) as `over_steel` and
    P / (0.8 A_s f_u) as `over_reduced_steel`; NaN where values for it were not reported. Raises
    `InputError` for an unknown column or a table without shear.
    """
    if by is not None and by not in table.columns:
        raise InputError("by", by, "must be a column of the table")
    rows = table[np.isfinite(table["shear_kN"].to_numpy(float))]
    if rows.empty:
        raise InputError("table", len(table), "holds no test with shear_kN")
    groups = [("all", rows)] if by is None else list(rows.groupby(by, sort=False))
    return pd.DataFrame({str(name): _summary(group) for name, group in groups}).T


def _summary(rows: pd.DataFrame) -> dict[str, float]:
    tests = specimens(rows)
    stiff: Array = np.sqrt(tests.concrete_strength * tests.concrete_modulus)
    steel = tests.shear / (tests.area * tests.ultimate_strength)
    mean = float(np.mean(tests.shear))
    return {
        "count": len(tests),
        "mean": mean,
        "variation": float(np.std(tests.shear, ddof=1) / mean) if len(tests) > 1 else np.nan,
        "over_concrete": float(np.mean(tests.shear / (0.5 * tests.area * stiff))),
        "over_steel": float(np.mean(steel)),
        "over_reduced_steel": float(np.mean(steel)) / 0.8,
    }


def ratio_summary(table: pd.DataFrame) -> dict[str, float | int]:
    """Mean, scatter and range of `strength_over_nominal`, and range of the means per campaign.

    For sources that report only the ratio to a nominal value. Raises `InputError`.
    """
    rows = table[np.isfinite(table["strength_over_nominal"].to_numpy(float))]
    if len(rows) < 2:
        raise InputError("strength_over_nominal", len(rows), "must be given for two rows or more")
    ratio = rows["strength_over_nominal"].astype(float)
    means = ratio.groupby(rows["campaign"]).mean()
    return {
        "count": len(rows),
        "campaigns": len(means),
        "mean": float(ratio.mean()),
        "variation": float(ratio.std(ddof=1) / ratio.mean()),
        "lowest": float(ratio.min()),
        "highest": float(ratio.max()),
        "lowest_campaign_mean": float(means.min()),
        "highest_campaign_mean": float(means.max()),
    }
