"""Tests after pre-damage: level of the damage, what is left of a stud, grade of the evidence.

A level is given, or it is the share of the fatigue life: of that of equal studs, or of that by the
S-N line of EN 1994-1-1, 6.8.3 (recalled), tau^m N = 90^m 2e6 with m = 8 and tau in MPa, the range
of the load over the area of the shank. That line is characteristic and no mean, so that shares by
it are a measure of their own, which no fit mixes with shares of measured lives.
"""

from collections.abc import Iterator
from enum import StrEnum
from math import sqrt

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.base.errors import InputError
from workbench.base.fields import Choice
from workbench.responses import Finding, finding
from workbench.studs.formulas import strength_formula
from workbench.studs.schema import (
    FATIGUE,
    HEADED,
    LARGEST_GAIN,
    LARGEST_LEVEL,
    LIFE,
    NO_PREDAMAGE,
    PREDICTED,
    QUANTITIES,
    SN_LIFE,
    TOTAL_TOLERANCE,
)
from workbench.studs.statistics.mixed import LEAST_CAMPAIGNS
from workbench.studs.tables import Array, equal_studs, named, shank_area, specimens

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
    for share, name in ((cycles / life, LIFE), (cycles / characteristic, SN_LIFE)):
        computed = level.isna() & (table["predamage"] == FATIGUE) & share.notna()
        level, measure = level.mask(computed, share), measure.mask(computed, name)
    return pd.DataFrame({"level": level, "measure": measure})


def peaks_of(rows: pd.DataFrame) -> pd.Series:
    """Peak of the load cycles over the undamaged strength (n,), of rows with a `ratio` of it."""
    return rows["predamage_peak_kN"].astype(float) * rows["ratio"] / rows["shear_kN"].astype(float)


def damage_findings(rows: pd.DataFrame, quantity: str) -> Iterator[Finding]:
    """Findings on the way in which damage was measured, for the rows of a fit."""
    if (rows["predamage_measure"] == SN_LIFE).any():
        yield finding("stud-characteristic-life")
    weak = rows[rows["shear_kN"] < (1.0 - TOTAL_TOLERANCE) * rows["predamage_peak_kN"]]
    if len(weak):
        yield finding("stud-weaker", float(len(weak)), count=len(weak), tests=named(weak))
    peak, tests = peaks_of(rows), len(rows)
    if quantity != "strength":
        peak = rows["predamage_peak_kN"].astype(float) / rows["undamaged_shear_kN"].astype(float)
    elif set(rows["predamage_measure"]) == {LIFE} and (unknown := int(peak.isna().sum())):
        yield finding("stud-unknown-peaks", count=unknown, tests=tests)
    elif set(rows["predamage_measure"]) == {LIFE} and np.ptp(peak) > LIKE_PEAK:
        ends = {"least": peak.min(), "most": peak.max()}
        yield finding("stud-different-peaks", float(peak.mean()), **ends, mean=peak.mean())
    high, most = int((peak > NORMAL_PEAK).sum()), float(peak.max())
    if high:
        yield finding(
            "stud-high-peaks", most, count=high, tests=tests, limit=NORMAL_PEAK, most=most
        )


REFERENCE = ("reference", "reference_tests", "uncertainty")
FORMULA = "roik-mean"  # that predicts undamaged strengths
LEAST_UNDAMAGED = 3
DRIVEN = 3.0  # damage of a stud driven beyond what it bears; the most that a table may give


def references(table: pd.DataFrame, quantity: str) -> pd.DataFrame:
    """The undamaged reference of every row, NaN where there is none.

    It is the row's own, or the mean of the undamaged tests that a fit may use with the same
    campaign and diameter, in concrete of about the same strength. Columns: `reference`, in the unit
    of the table; `reference_tests` behind it (0: the row's own) and standard `uncertainty` of what
    is left, by the pooled scatter of such tests (NaN: not known).
    """
    column, given = QUANTITIES[quantity]
    undamaged = table[(table["predamage"] == NO_PREDAMAGE) & (table["use_for_fit"] == 1.0)]
    whole, counts, squares = table[given].astype(float), pd.Series(0.0, table.index), {}
    for index in table.index[whole.isna() & (table["predamage"] != NO_PREDAMAGE)]:
        tests = equal_studs(undamaged, table.loc[index])[column].astype(float).dropna()
        whole[index], counts[index] = tests.mean(), float(len(tests))
        if len(tests) > 1:  # a group counts once, however many rows refer to it
            squares[tuple(tests.index)] = len(tests) - 1, float((tests / tests.mean()).var())
    freedom = sum(nu for nu, _ in squares.values())
    spread = sqrt(sum(nu * s for nu, s in squares.values()) / freedom) if freedom else np.nan
    relative = (spread / counts**0.5).where(counts > 0.0)
    uncertainty = relative * table[column].astype(float) / whole
    return pd.DataFrame(dict(zip(REFERENCE, (whole, counts, uncertainty), strict=True)))


def ratios(table: pd.DataFrame, quantity: str) -> pd.Series:
    """Ratios of every row to its undamaged reference; NaN where there is none."""
    return table[QUANTITIES[quantity][0]].astype(float) / references(table, quantity)["reference"]


def damaged_rows(
    table: pd.DataFrame, quantity: str, predamage: str | None = None, measure: str | None = None
) -> pd.DataFrame:
    """Tests after pre-damage with `level`, `ratio` of what is left and its reference; may be empty.

    Raises `InputError` for an unknown quantity, kinds or measures of damage that must not be mixed,
    or a test that bears more after damage than any can.
    """
    Choice(tuple(QUANTITIES)).check("quantity", quantity)
    damaged = (table["predamage"] != NO_PREDAMAGE) & (table["use_for_fit"] == 1.0)
    damage, whole = damage_of(table), references(table, quantity)
    ratio = table[QUANTITIES[quantity][0]].astype(float) / whole["reference"]
    measures = damage["measure"]
    rows = table.assign(level=damage["level"], predamage_measure=measures, ratio=ratio, **whole)
    for name, wanted in (("predamage", predamage), ("predamage_measure", measure)):
        if wanted is not None:
            damaged &= rows[name] == wanted
    rows = rows[damaged & np.isfinite(ratio)]
    for name, advice in (("predamage", "predamage="), ("predamage_measure", "measure=")):
        words = sorted(set(rows[name]))
        if len(words) > 1:
            reason = "different kinds of damage do not share one relation"
            raise InputError(name, ", ".join(words), reason, f"choose one with {advice}")
    highest = rows["predamage_measure"].map(LARGEST_LEVEL).fillna(DRIVEN)
    for _, row in rows.assign(highest=highest)[rows["level"] > highest].iterrows():
        name, most = f"{row['campaign']} {row['specimen']}", row["highest"]
        reason = f"damage of {row['level']:.3g} by {row['predamage_measure']}"
        advice = "predamage_range_kN is per stud; predamage_cycles are single cycles"
        raise InputError(name, reason, f"must be at most {most:g}", advice)
    for _, row in rows[rows["ratio"] > LARGEST_GAIN].iterrows():
        name, reason = f"{row['campaign']} {row['specimen']}", "times the undamaged tests"
        advice = "are columns swapped, or the units different?"
        raise InputError(name, f"{row['ratio']:.3g} {reason}", "no damage adds so much", advice)
    return pd.DataFrame(rows).reset_index(drop=True)


def predicted_references(table: pd.DataFrame) -> pd.DataFrame:
    """The table with undamaged strengths of a formula where damaged studs have no companion.

    The mean form of EN 1994-1-1 times the median of test over formula of the undamaged headed studs
    of the table. Rows that get one say so in `undamaged_basis`. Raises `InputError` with fewer than
    `LEAST_UNDAMAGED` of them: nothing then tells how far the formula is off.
    """
    tests = specimens(table)
    formula = pd.Series(strength_formula(FORMULA).of(tests), index=table.index)
    whole = (table["predamage"] == NO_PREDAMAGE) & (table["use_for_fit"] == 1.0)
    whole &= (table["connector"] == HEADED) & (table["test"] == "push-out")
    bias = (1e3 * table["shear_kN"].astype(float) / formula)[whole].dropna()
    if len(bias) < LEAST_UNDAMAGED:
        reason = f"undamaged tests: must be {LEAST_UNDAMAGED} or more to predict references"
        advice = "test companions, or add the shipped tests with --with-shipped"
        raise InputError("table", f"{len(bias)} rows", reason, advice)
    lacking = (table["predamage"] != NO_PREDAMAGE) & ratios(table, "strength").isna()
    lacking &= formula.notna() & table["shear_kN"].notna()
    reference = table["undamaged_shear_kN"].mask(lacking, 1e-3 * float(bias.median()) * formula)
    basis = table["undamaged_basis"].mask(lacking, PREDICTED)
    return table.assign(undamaged_shear_kN=reference, undamaged_basis=basis)


def reference_findings(table: pd.DataFrame, rows: pd.DataFrame, quantity: str) -> Iterator[Finding]:
    """Damaged tests of a table without an undamaged reference, and rows with a predicted one."""
    damaged = (table["predamage"] != NO_PREDAMAGE) & (table["use_for_fit"] == 1.0)
    damaged &= table[QUANTITIES[quantity][0]].notna() & ratios(table, quantity).isna()
    if damaged.any():
        remedy = "--predicted-reference" if quantity == "strength" else ""
        yield finding("stud-no-reference", count=damaged.sum(), quantity=quantity, remedy=remedy)
    relative, tests = (rows["uncertainty"] / rows["ratio"]).dropna(), len(rows)
    share = sqrt(float((relative**2).mean())) if len(relative) else 0.0
    known = int(rows["uncertainty"].notna().sum())
    if share:
        yield finding(
            "stud-scattering-references", share, known=known, tests=tests, percent=100 * share
        )
    if known < tests:
        yield finding("stud-unknown-references", unknown=tests - known, tests=tests)
    predicted = (rows["undamaged_basis"] == PREDICTED).sum() if quantity == "strength" else 0
    if predicted:
        yield finding("stud-predicted-references", count=predicted, tests=tests)


def studs_in_words(rows: pd.DataFrame) -> str:
    """The tested studs in words: ranges of sizes and strengths, as far as the table tells them."""

    def span(column: str, words: str) -> str:
        values = rows[column].astype(float).dropna()
        low, high = f"{values.min():.4g}", f"{values.max():.4g}"
        return "" if values.empty else words.format(low if low == high else f"{low} to {high}")

    size = " x ".join(filter(None, (span(f"{name}_mm", "{}") for name in ("diameter", "height"))))
    strengths = (span("fcm_MPa", "f_c {} MPa"), span("fu_MPa", "f_u {} MPa"))
    return ", ".join(filter(None, (f"{size} mm" if size else "", *strengths)))


ONSET_OF_FATIGUE_LOSS = 0.15  # share of life; Hanswille, Porsch and Ustundag 2007, abstract


class Grade(StrEnum):
    """How well a residual capacity is supported, from weakest to strongest."""

    MECHANICAL = "mechanical prediction, not validated by tests after pre-damage"
    SYNTHETIC = "exercise on synthetic rows: shows the method, is no evidence"
    NARROW = "fitted to tests whose damage hardly varies: supports no relation"
    ONE_CAMPAIGN = "fitted to tests after pre-damage of one campaign, not validated on others"
    PREDICTED = "fitted to tests after pre-damage over predicted, not measured, undamaged strengths"
    TWO_CAMPAIGNS = "fitted to tests after pre-damage of two campaigns, too few to validate it"
    CROSS_VALIDATED = "fitted to tests after pre-damage, cross-validated over campaigns"


LEAST_RANGE = 0.25  # of damage, over which a relation may be called validated


def grade_of(rows: pd.DataFrame, quantity: str) -> Grade:
    """The grade of tests after pre-damage (with `level`)."""
    if (rows["origin"] == "synthetic").any():
        return Grade.SYNTHETIC
    campaigns, levels = rows["campaign"].nunique(), rows["level"]
    if levels.max() < LEAST_RANGE or levels.nunique() < 2:
        return Grade.NARROW
    if quantity == "strength" and (rows["undamaged_basis"] == PREDICTED).any():
        return Grade.PREDICTED
    few = {1: Grade.ONE_CAMPAIGN, 2: Grade.TWO_CAMPAIGNS}
    return few.get(campaigns, Grade.CROSS_VALIDATED)


def residual_findings(
    rows: pd.DataFrame, at_bound: tuple[str, ...], onset: float, between: float | None = None
) -> Iterator[Finding]:
    """Findings of a fit to tests after pre-damage.

    Arguments: parameters `at_bound`; what is left at the `onset` of loss, 15 % of the life; scatter
    `between` campaigns if it is known.
    """
    synthetic = int((rows["origin"] == "synthetic").sum())
    if synthetic:
        yield finding("stud-synthetic", count=synthetic, tests=len(rows))
    if between is not None:
        yield finding("stud-known-between", between, between=between)
    elif (campaigns := rows["campaign"].nunique()) < LEAST_CAMPAIGNS:
        key = "stud-one-damaged-campaign" if campaigns == 1 else "stud-few-damaged-campaigns"
        yield finding(key, campaigns=campaigns)
    if at_bound:
        yield finding("stud-bounds", names=", ".join(at_bound))
    if rows["predamage"].iloc[0] == FATIGUE and onset >= 1.0:
        yield finding("stud-no-loss-of-fatigue")
