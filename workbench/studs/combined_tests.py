"""Tests of studs under tension and shear together, as ratios to what each alone would bear."""

from __future__ import annotations

import numpy as np
import pandas as pd

from workbench.studs.schema import NO_PREDAMAGE

COLUMNS = ("campaign", "specimen", "tension", "shear")


def combined_tests(table: pd.DataFrame) -> pd.DataFrame:
    """Rows (campaign, specimen, tension, shear) of the combined tests of a table; may be empty.

    Both are over the mean resistance of the undamaged pull-outs and push-outs of the same campaign
    and diameter; a combined test without both companions is left out.
    """
    usable = table[(table["use_for_fit"] == 1.0) & (table["predamage"] == NO_PREDAMAGE)]
    resistance = {
        (kind, column): usable[usable["test"] == kind]
        .groupby(["campaign", "diameter_mm"])[column]
        .mean()
        for kind, column in (("pull-out", "tension_kN"), ("push-out", "shear_kN"))
    }
    rows = []
    for _, row in usable[usable["test"] == "combined"].iterrows():
        key = (row["campaign"], row["diameter_mm"])
        alone = [
            resistance["pull-out", "tension_kN"].get(key, np.nan),
            resistance["push-out", "shear_kN"].get(key, np.nan),
        ]
        ratios = row["tension_kN"] / alone[0], row["shear_kN"] / alone[1]
        if np.all(np.isfinite(ratios)):
            rows.append((row["campaign"], row["specimen"], float(ratios[0]), float(ratios[1])))
    return pd.DataFrame(rows, columns=list(COLUMNS))
