"""Tests after pre-damage: what is left of a stud over that of an undamaged one."""

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.fields import Choice
from workbench.studs.schema import NO_PREDAMAGE

QUANTITIES = {
    "strength": ("shear_kN", "undamaged_shear_kN"),
    "stiffness": ("stiffness_10_40_kN_per_mm", "undamaged_stiffness_kN_per_mm"),
}


def damaged_rows(
    table: pd.DataFrame, quantity: str, predamage: str | None = None, measure: str | None = None
) -> pd.DataFrame:
    """Tests after pre-damage with `level` and `ratio` of what is left; empty when there are none.

    The undamaged reference is the row's own, or the mean of the undamaged tests with the same
    campaign and diameter. Raises `InputError` for an unknown quantity, or kinds or measures of
    damage that must not be mixed.
    """
    Choice(tuple(QUANTITIES)).check("quantity", quantity)
    column, reference = QUANTITIES[quantity]
    damaged = (table["predamage"] != NO_PREDAMAGE) & (table["use_for_fit"] == 1.0)
    for name, wanted in (("predamage", predamage), ("predamage_measure", measure)):
        if wanted is not None:
            damaged &= table[name] == wanted
    undamaged = table[table["predamage"] == NO_PREDAMAGE]
    means = undamaged.groupby(["campaign", "diameter_mm"])[column].mean()
    keys = pd.MultiIndex.from_frame(table[["campaign", "diameter_mm"]])
    companion = pd.Series(means.reindex(keys).to_numpy(float), index=table.index)
    ratio = table[column].astype(float) / table[reference].astype(float).fillna(companion)
    rows = table.assign(level=table["predamage_level"].astype(float), ratio=ratio)
    rows = rows[damaged & np.isfinite(ratio)]
    for name, advice in (("predamage", "predamage="), ("predamage_measure", "measure=")):
        words = sorted(set(rows[name]))
        if len(words) > 1:
            reason = "different kinds of damage do not share one relation"
            raise InputError(name, ", ".join(words), reason, f"choose one with {advice}")
    return rows.reset_index(drop=True)


def studs_in_words(rows: pd.DataFrame) -> str:
    """The tested studs in words: ranges of sizes and strengths, as far as the table tells them."""

    def span(column: str, words: str) -> str:
        values = rows[column].astype(float).dropna()
        low, high = f"{values.min():.4g}", f"{values.max():.4g}"
        return "" if values.empty else words.format(low if low == high else f"{low} to {high}")

    size = " x ".join(filter(None, (span(f"{name}_mm", "{}") for name in ("diameter", "height"))))
    strengths = (span("fcm_MPa", "f_c {} MPa"), span("fu_MPa", "f_u {} MPa"))
    return ", ".join(filter(None, (f"{size} mm" if size else "", *strengths)))
