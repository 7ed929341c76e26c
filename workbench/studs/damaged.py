"""Tests after pre-damage: what is left of a stud over that of an undamaged one."""

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.fields import Choice
from workbench.studs.quantities import LIKE_CONCRETE
from workbench.studs.schema import LARGEST_GAIN, NO_PREDAMAGE

QUANTITIES = {
    "strength": ("shear_kN", "undamaged_shear_kN"),
    "stiffness": ("stiffness_10_40_kN_per_mm", "undamaged_stiffness_kN_per_mm"),
}


def ratios(table: pd.DataFrame, quantity: str) -> pd.Series:
    """What every row has of the undamaged reference; NaN where there is none.

    The reference is the row's own, or the mean of the undamaged tests that a fit may use with the
    same campaign and diameter, in concrete of about the same strength.
    """
    column, reference = QUANTITIES[quantity]
    undamaged = table[(table["predamage"] == NO_PREDAMAGE) & (table["use_for_fit"] == 1.0)]
    values, own = (table[name].astype(float) for name in (column, reference))
    for index in table.index[own.isna()]:
        row = table.loc[index]
        same = (undamaged[name] == row[name] for name in ("campaign", "diameter_mm"))
        near = undamaged[np.logical_and.reduce(list(same))]
        other = np.abs(near["fcm_MPa"].astype(float) / row["fcm_MPa"] - 1.0) > LIKE_CONCRETE
        own[index] = near.loc[~other, column].astype(float).mean()  # an unknown one counts as alike
    return values / own


def damaged_rows(
    table: pd.DataFrame, quantity: str, predamage: str | None = None, measure: str | None = None
) -> pd.DataFrame:
    """Tests after pre-damage with `level` and `ratio` of what is left; empty when there are none.

    Raises `InputError` for an unknown quantity, kinds or measures of damage that must not be mixed,
    or a test that bears more after damage than any can.
    """
    Choice(tuple(QUANTITIES)).check("quantity", quantity)
    damaged = (table["predamage"] != NO_PREDAMAGE) & (table["use_for_fit"] == 1.0)
    for name, wanted in (("predamage", predamage), ("predamage_measure", measure)):
        if wanted is not None:
            damaged &= table[name] == wanted
    ratio = ratios(table, quantity)
    rows = table.assign(level=table["predamage_level"].astype(float), ratio=ratio)
    rows = rows[damaged & np.isfinite(ratio)]
    for name, advice in (("predamage", "predamage="), ("predamage_measure", "measure=")):
        words = sorted(set(rows[name]))
        if len(words) > 1:
            reason = "different kinds of damage do not share one relation"
            raise InputError(name, ", ".join(words), reason, f"choose one with {advice}")
    for _, row in rows[rows["ratio"] > LARGEST_GAIN].iterrows():
        name, reason = f"{row['campaign']} {row['specimen']}", "times the undamaged tests"
        advice = "are columns swapped, or the units different?"
        raise InputError(name, f"{row['ratio']:.3g} {reason}", "no damage adds so much", advice)
    return pd.DataFrame(rows).reset_index(drop=True)


def studs_in_words(rows: pd.DataFrame) -> str:
    """The tested studs in words: ranges of sizes and strengths, as far as the table tells them."""

    def span(column: str, words: str) -> str:
        values = rows[column].astype(float).dropna()
        low, high = f"{values.min():.4g}", f"{values.max():.4g}"
        return "" if values.empty else words.format(low if low == high else f"{low} to {high}")

    size = " x ".join(filter(None, (span(f"{name}_mm", "{}") for name in ("diameter", "height"))))
    strengths = (span("fcm_MPa", "f_c {} MPa"), span("fu_MPa", "f_u {} MPa"))
    return ", ".join(filter(None, (f"{size} mm" if size else "", *strengths)))
