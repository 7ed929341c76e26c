"""Tables whose rows are possible one by one and absurd together: units, columns, copies.

Each suspicion is a finding, named by `workbench data check` and by every fit to such a table.
"""

from collections.abc import Iterator
from math import sqrt

import numpy as np
import pandas as pd

from workbench.responses import Finding
from workbench.studs.damaged import damage_of, ratios
from workbench.studs.fit_protocol import outlier_findings
from workbench.studs.formulas import SHEAR_MODELS
from workbench.studs.quantities import named, specimens
from workbench.studs.schema import HEADED, LARGEST_GAIN, NO_PREDAMAGE, QUANTITIES
from workbench.studs.statistics.mixed import fit
from workbench.studs.statistics.problem import location
from workbench.studs.tables import same_contents

# median of test over the mean form of EN 1994-1-1 in a campaign: shipped ones have 0.9 and 1.2
USUAL_RATIO = (0.5, 1.5)
# load over the tensile strength of the shank, above which one test alone is doubted: of the shipped
# push-outs the strongest has 1.58 (friction and collar bear too), under tension none has more
TWO_STUDS = {"shear": 1.6, "tension": 1.2}
RISES = 0.01  # chance of so steep a rise of what is left if it did not depend on the damage
# what a load may have been in instead of kN per stud, by the factor that would put it right
UNITS = {"kip instead of kN": 4.448, "tonnes instead of kN": 9.807}
METRES, INCHES = 0.1, 0.5  # mm, below which slips of a campaign look like another unit
HIGHER = 1.05  # median of damaged over undamaged, above which columns look swapped
LEAST_ROWS, MOST_ROWS = 3, 5000  # that show a pattern; in which single tests are looked at


def suspicions(table: pd.DataFrame) -> list[Finding]:
    """What looks wrong in a table of tests (schema `TESTS`), one finding per suspicion."""
    parts = (_loads(table), _single(table), _slips(table), _columns(table), _rises(table))
    return [*(Finding("data", text) for part in parts for text in part), *_outliers(table)]


def suspicions_of_points(points: pd.DataFrame) -> list[Finding]:
    """What looks wrong in a table of load-slip points (schema `POINTS`)."""
    curves = points.groupby(["campaign", "specimen"])["slip_mm"].agg(["max", "count"])
    curves = curves[curves["count"] >= LEAST_ROWS]
    named = curves["max"].rename("slip_at_max_mm").reset_index()
    return [Finding("data", text) for text in _slips(named)]


def _ratios(table: pd.DataFrame) -> pd.Series:
    """Undamaged studs in solid slabs over a formula of their mean strength."""
    whole = (table["predamage"] == NO_PREDAMAGE) & (table["connector"] == HEADED)
    whole &= (table["test"] == "push-out") & table["deck_depth_mm"].isna()
    whole &= ~(table["height_mm"] < 3.0 * table["diameter_mm"])
    rows = table[whole]
    tests = specimens(rows)
    return pd.Series(tests.shear / SHEAR_MODELS["roik-mean"].of(tests), index=rows.index)


def _loads(table: pd.DataFrame) -> Iterator[str]:
    """Campaigns whose loads are another unit, or those of several studs."""
    for campaign, own in _ratios(table).dropna().groupby(table["campaign"]):
        middle, (low, high) = float(own.median()), USUAL_RATIO
        if low <= middle <= high:
            continue
        guess = "loads of two studs, or of the specimen, instead of loads per stud"
        if middle < low:
            guess = min(UNITS, key=lambda words: abs(np.log(UNITS[words] * middle)))
        words = f"loads of {campaign} are {middle:.2g} times those that studs like these bear"
        yield f"{words}: {guess}?"


def _single(table: pd.DataFrame) -> Iterator[str]:
    """Single tests that bear more than their shank can."""
    tests = specimens(table)
    for load, most in TWO_STUDS.items():
        share = tests.quantity(load) / (tests.area * tests.ultimate_strength)
        rows = table[share > most]
        if len(rows):
            words = f"{load} of {named(rows)} is up to {np.nanmax(share):.3g} times the tensile"
            yield f"{words} strength of the shank: the load of two studs entered as one?"


def _outliers(table: pd.DataFrame) -> Iterator[Finding]:
    """Undamaged tests far off the others of their campaign, without a formula of their diameter."""
    ratio = _ratios(table)
    rows, known = table.loc[ratio.index], ratio.notna()
    value = ratio.where(known, rows["shear_kN"].astype(float)).dropna()
    if LEAST_ROWS < len(value) <= MOST_ROWS:
        own = rows["campaign"] + " " + rows["diameter_mm"].astype(str)
        rows, alike = rows.loc[value.index], rows["campaign"].where(known, own)[value.index]
        estimate = fit(location(np.log(value.to_numpy()), alike.to_numpy(str)))
        yield from outlier_findings(estimate, rows, lambda value: float(np.exp(value)))


def _rises(table: pd.DataFrame) -> Iterator[str]:
    """What is left that rises with the damage, as it does with the life that remains (Spearman)."""
    from scipy.special import stdtrit

    damage = damage_of(table).assign(predamage=table["predamage"])
    for quantity in QUANTITIES:
        own = damage.assign(ratio=ratios(table, quantity)).dropna(subset=["level", "ratio"])
        for (kind, measure), rows in own.groupby(["predamage", "measure"]):
            rank, nu = float(rows["level"].rank().corr(rows["ratio"].rank())), len(rows) - 2
            if nu < LEAST_ROWS:
                continue
            if rank * sqrt(nu / max(1.0 - rank**2, 1e-12)) > stdtrit(nu, 1.0 - RISES):
                told = f"{quantity} left after {kind} rises with the damage ({measure}) in"
                asked = "is the life that remains given instead of the damage?"
                yield f"{told} {len(rows)} tests: {asked}"


def _slips(table: pd.DataFrame) -> Iterator[str]:
    for campaign, own in table.groupby("campaign")["slip_at_max_mm"]:
        slip = float(own.astype(float).median())
        if slip < INCHES:
            unit = "metres" if slip < METRES else "inches"
            yield f"slips of {campaign}, {slip:.3g} mm at the most, are short: {unit}?"


def _columns(table: pd.DataFrame) -> Iterator[str]:
    """Columns that hold the same, swapped references, and rows that stand twice under two names."""
    damaged = table[(table["predamage"] != NO_PREDAMAGE) & (damage_of(table)["level"] > 0.0)]
    for quantity, (column, reference) in QUANTITIES.items():
        ratio = ratios(table, quantity)[damaged.index].dropna()
        middle, count = float(ratio.median()), len(ratio)
        if count >= LEAST_ROWS and (ratio == 1.0).all():
            yield f"{column} equals {reference} in all {count} damaged rows: one column copied?"
        elif (count >= LEAST_ROWS and middle > HIGHER) or middle > LARGEST_GAIN:
            more = f"damaged studs have {middle:.2f} times the {column} of undamaged ones"
            yield f"{more} (median of {count}): columns swapped, or another unit?"
    for first, second in same_contents(table):
        yield f"{first} and {second} hold the same numbers: one test under two names?"
