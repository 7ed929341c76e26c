"""Statistics of groups of tests against formulas, without any fitting."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.studs.quantities import Array, specimens


@dataclass(frozen=True, slots=True)
class GroupSummary:
    """A group of tests: `count`, mean load per stud (N), coefficient of variation (None for one).

    `over_concrete`, mean of P / (0.5 A_s sqrt(f_c E_c)); `over_steel`, of P / (A_s f_u);
    `over_reduced_steel`, of P / (0.8 A_s f_u); None where values for it were not reported.
    """

    group: str
    count: int
    mean: float
    variation: float | None
    over_concrete: float | None
    over_steel: float | None
    over_reduced_steel: float | None

    def to_dict(self) -> dict[str, object]:
        """All values by name."""
        return asdict(self)


def summarise(table: pd.DataFrame, by: str | None = None) -> list[GroupSummary]:
    """Mean, scatter and ratios to simple formulas, per value of the column `by` (None: all rows).

    Raises `InputError` for an unknown column or a table without shear.
    """
    if by is not None and by not in table.columns:
        raise InputError("by", by, "must be a column of the table")
    rows = table[np.isfinite(table["shear_kN"].to_numpy(float))]
    if rows.empty:
        raise InputError("table", len(table), "holds no test with shear_kN")
    groups = [("all", rows)] if by is None else list(rows.groupby(by, sort=False))
    return [_summary(str(name), group) for name, group in groups]


def _summary(name: str, rows: pd.DataFrame) -> GroupSummary:
    tests = specimens(rows)
    area = tests.area
    steel = tests.shear / (area * tests.ultimate_strength)
    concrete = tests.shear / (
        0.5 * area * np.sqrt(tests.concrete_strength * tests.concrete_modulus)
    )
    mean = float(np.mean(tests.shear))
    scatter = float(np.std(tests.shear, ddof=1) / mean) if len(tests) > 1 else None
    over_steel = _mean(steel)
    return GroupSummary(
        name, len(tests), mean, scatter, _mean(concrete), over_steel,
        None if over_steel is None else over_steel / 0.8,
    )  # fmt: skip


def _mean(values: Array) -> float | None:
    return float(np.mean(values)) if np.all(np.isfinite(values)) else None


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
