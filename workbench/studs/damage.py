"""Damage as laboratories measure it: the level of every test after pre-damage, and its measure.

A level is given, or it is the share of the fatigue life: of that of equal studs, or of that by the
S-N line of EN 1994-1-1, 6.8.3 (recalled), tau^m N = 90^m 2e6 with m = 8 and tau in MPa, the range
of the load over the area of the shank. That line is characteristic and no mean, so that shares by
it are a measure of their own, which no fit mixes with shares of measured lives.
"""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.responses import Finding
from workbench.studs.quantities import Array, shank_area
from workbench.studs.schema import FATIGUE, LIFE, SN_LIFE

EXPONENT, STRESS, CYCLES = 8.0, 90.0, 2e6  # of the S-N line: m, tau_c (MPa), N_c
LIKE_PEAK = 0.05  # by which P_max / P_u may differ between tests of one curve
NORMAL_PEAK = 0.75  # of the strength, to which EN 1994-1-1, 6.8.1 (recalled) keeps peak loads


def fatigue_life(load_range: ArrayLike, diameter: ArrayLike) -> Array:
    """Characteristic cycles to failure (n,) for ranges of the load (kN) and shanks (mm)."""
    area = 1e6 * shank_area(1e-3 * np.asarray(diameter, float))
    return np.asarray(CYCLES * (STRESS * area / (1e3 * np.asarray(load_range, float))) ** EXPONENT)


def damage_of(table: pd.DataFrame) -> pd.DataFrame:
    """Level and measure of the damage of every row of a table (schema `TESTS`)."""
    level, measure = table["predamage_level"].astype(float), table["predamage_measure"]
    cycles, life = (table[f"predamage_{n}"].astype(float) for n in ("cycles", "life_cycles"))
    characteristic = fatigue_life(table["predamage_range_kN"], table["diameter_mm"])
    by_line = pd.Series(cycles / characteristic, index=table.index)
    open_ = level.isna() & (table["predamage"] == FATIGUE)
    told = open_ & (cycles / life).notna()
    line = open_ & ~told & by_line.notna()
    level = level.mask(told, cycles / life).mask(line, by_line)
    measure = measure.mask(told, LIFE).mask(line, SN_LIFE)
    return pd.DataFrame({"level": level, "measure": measure})


def peaks_of(rows: pd.DataFrame) -> pd.Series:
    """Peak of the load cycles over the undamaged strength (n,), of rows with a `ratio` of it."""
    return rows["predamage_peak_kN"].astype(float) * rows["ratio"] / rows["shear_kN"].astype(float)


def damage_findings(rows: pd.DataFrame, quantity: str) -> Iterator[Finding]:
    """What the way in which damage was measured says against it, for the rows of a fit."""
    if (rows["predamage_measure"] == SN_LIFE).any():
        text = (
            "damage is the share of the characteristic life of EN 1994-1-1, 6.8.3, which is no "
            "mean: a range 10 % higher halves the life"
        )
        remedy = "give predamage_life_cycles of equal studs"
        yield Finding("evidence", text, remedy=remedy)
    peak = peaks_of(rows)
    if quantity != "strength":
        peak = rows["predamage_peak_kN"].astype(float) / rows["undamaged_shear_kN"].astype(float)
    elif set(rows["predamage_measure"]) == {LIFE} and (unknown := int(peak.isna().sum())):
        text = f"{unknown} of {len(rows)} tests do not tell the peak of their cycles: no relation"
        text += " that ends a fatigue life at R(1) = P_max/P_u is a candidate"
        yield Finding("fatigue", text, remedy="give predamage_peak_kN")
    elif set(rows["predamage_measure"]) == {LIFE} and np.ptp(peak) > LIKE_PEAK:
        text = f"P_max/P_u of the tests is {peak.min():.2f} to {peak.max():.2f}: curves are for"
        yield Finding("fatigue", f"{text} {peak.mean():.2f}", number=float(peak.mean()))
    high = int((peak > NORMAL_PEAK).sum())
    if high:
        text = (
            f"{high} of {len(rows)} tests were cycled above {NORMAL_PEAK:g} of their undamaged "
            f"strength (up to {peak.max():.2f}): such peaks damage by themselves, which a "
            "share of the fatigue life does not tell"
        )
        yield Finding("evidence", text, number=float(peak.max()))
