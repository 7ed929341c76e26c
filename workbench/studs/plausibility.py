"""Plausibility of tables of tests: rows that are possible one by one and absurd together.

Also what a fit of strength says of the tests behind it, and of their measurement. The sentences
stand in ``findings.toml``; `workbench data check` and every fit to such a table give them.
"""

from collections.abc import Iterator
from math import sqrt
from typing import Any

import numpy as np
import pandas as pd

from workbench.responses import Finding, finding
from workbench.studs.damaged import damage_of, ratios
from workbench.studs.fit_protocol import outlier_findings
from workbench.studs.formulas import SHEAR_MODELS, Formula
from workbench.studs.schema import HEADED, LARGEST_GAIN, NO_PREDAMAGE, QUANTITIES
from workbench.studs.series import LEAST_FOR_DESIGN
from workbench.studs.statistics.mixed import Problem, fit, location
from workbench.studs.tables import (
    Specimens,
    named,
    profiled,
    same_contents,
    specimens,
    undamaged_headed_studs,
)

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
FEW_CAMPAIGNS = 5
EUROPEAN_DENSITY = 2200.0  # kg/m3, of eta_E = (w / 2200)^2, EN 1992-1-1, 11.3.2 (recalled)


def suspicions(table: pd.DataFrame) -> list[Finding]:
    """Findings on implausible tests of a table (schema `TESTS`), one per suspicion."""
    checks = (_loads, _single, _slips, _columns, _rises, _outliers)
    return [each for check in checks for each in check(table)]


def suspicions_of_points(points: pd.DataFrame) -> list[Finding]:
    """Findings on implausible load-slip points of a table (schema `POINTS`)."""
    curves = points.groupby(["campaign", "specimen"])["slip_mm"].agg(["max", "count"])
    curves = curves[curves["count"] >= LEAST_ROWS]
    return list(_slips(curves["max"].rename("slip_at_max_mm").reset_index()))


def _ratios(table: pd.DataFrame) -> pd.Series:
    """Undamaged studs in solid slabs over a formula of their mean strength."""
    whole = (table["predamage"] == NO_PREDAMAGE) & (table["connector"] == HEADED)
    whole &= (table["test"] == "push-out") & table["deck_depth_mm"].isna()
    whole &= ~(table["height_mm"] < 3.0 * table["diameter_mm"])
    rows = table[whole]
    tests = specimens(rows)
    return pd.Series(tests.shear / SHEAR_MODELS["roik-mean"].of(tests), index=rows.index)


def _loads(table: pd.DataFrame) -> Iterator[Finding]:
    """Campaigns whose loads are another unit, or those of several studs."""
    for campaign, ratio in _ratios(table).dropna().groupby(table["campaign"]).median().items():
        low, high = USUAL_RATIO
        if low <= ratio <= high:
            continue
        guess = "loads of two studs, or of the specimen, instead of loads per stud"
        if ratio < low:
            guess = min(UNITS, key=lambda words: abs(np.log(UNITS[words] * ratio)))
        yield finding("stud-unit-of-loads", campaign=campaign, ratio=ratio, guess=guess)


def _single(table: pd.DataFrame) -> Iterator[Finding]:
    """Single tests that bear more than their shank can."""
    tests = specimens(table)
    for load, most in TWO_STUDS.items():
        share = tests.quantity(load) / (tests.area * tests.ultimate_strength)
        rows = table[share > most]
        if len(rows):
            yield finding("stud-two-studs", load=load, tests=named(rows), share=np.nanmax(share))


def _outliers(table: pd.DataFrame) -> Iterator[Finding]:
    """Undamaged tests far off the others of their campaign, without a formula of their diameter."""
    ratio = _ratios(table)
    rows, known = table.loc[ratio.index], ratio.notna()
    value = ratio.where(known, rows["shear_kN"].astype(float)).dropna()
    if LEAST_ROWS < len(value) <= MOST_ROWS:
        size = rows["campaign"] + " " + rows["diameter_mm"].astype(str)
        rows, alike = rows.loc[value.index], rows["campaign"].where(known, size)[value.index]
        estimate = fit(location(np.log(value.to_numpy()), alike.to_numpy(str)))
        yield from outlier_findings(estimate, rows, lambda value: float(np.exp(value)))


def _rises(table: pd.DataFrame) -> Iterator[Finding]:
    """Findings where the rest rises with the damage, as with the life that remains (Spearman)."""
    from scipy.special import stdtrit

    damage = damage_of(table).assign(predamage=table["predamage"])
    for quantity in QUANTITIES:
        left = damage.assign(ratio=ratios(table, quantity)).dropna(subset=["level", "ratio"])
        for (kind, measure), rows in left.groupby(["predamage", "measure"]):
            rank, nu = float(rows["level"].rank().corr(rows["ratio"].rank())), len(rows) - 2
            if nu < LEAST_ROWS:
                continue
            if rank * sqrt(nu / max(1.0 - rank**2, 1e-12)) > stdtrit(nu, 1.0 - RISES):
                which: dict[str, Any] = {"quantity": quantity, "kind": kind, "measure": measure}
                yield finding("stud-rises", **which, tests=len(rows))


def _slips(table: pd.DataFrame) -> Iterator[Finding]:
    for campaign, slips in table.groupby("campaign")["slip_at_max_mm"]:
        slip = float(slips.astype(float).median())
        if slip < INCHES:
            unit = "metres" if slip < METRES else "inches"
            yield finding("stud-short-slips", campaign=campaign, slip=slip, unit=unit)


def _columns(table: pd.DataFrame) -> Iterator[Finding]:
    """Columns that hold the same, swapped references, and rows that stand twice under two names."""
    damaged = table[(table["predamage"] != NO_PREDAMAGE) & (damage_of(table)["level"] > 0.0)]
    for quantity, (column, reference) in QUANTITIES.items():
        ratio = ratios(table, quantity)[damaged.index].dropna()
        middle, count = float(ratio.median()), len(ratio)
        if count >= LEAST_ROWS and (ratio == 1.0).all():
            yield finding("stud-copied-column", column=column, reference=reference, count=count)
        elif (count >= LEAST_ROWS and middle > HIGHER) or middle > LARGEST_GAIN:
            yield finding("stud-swapped-columns", ratio=middle, column=column, count=count)
    for first, second in same_contents(table):
        yield finding("same-test", first=first, second=second)


# -- of the tests behind a fit of strength --------------------------------------------------------


def measurement_of(kept: pd.DataFrame, load: str) -> float | None:
    """Root mean square of the relative uncertainty of the loads, if all rows report it."""
    relative = (kept[f"{load}_uncertainty_kN"] / kept[f"{load}_kN"]).to_numpy(float)
    return float(np.sqrt(np.mean(relative**2))) if np.all(np.isfinite(relative)) else None


def strength_findings(
    kept: pd.DataFrame, tests: Specimens, model: Formula, given: Problem
) -> Iterator[Finding]:
    """Findings of a fit to tests; the `kept` rows are the `tests`."""
    yield from model.findings(tests)
    above = int(np.sum(tests.quantity(model.load) > tests.area * tests.ultimate_strength))
    if above:
        yield finding("stud-shank", count=above, tests=len(tests))
    if given.count == given.campaigns > 1:
        yield finding("stud-single-tests")
    if given.between is not None:
        yield finding("stud-known-between", given.between, between=given.between)
    elif given.campaigns < FEW_CAMPAIGNS:
        few = {1: "stud-one-campaign", 2: "stud-two-campaigns"}
        key = few.get(given.campaigns, "stud-few-campaigns")
        yield finding(key, campaigns=given.campaigns)
    if given.count < LEAST_FOR_DESIGN:
        yield finding("stud-no-design-factor", count=given.count, least=LEAST_FOR_DESIGN)
    if measurement_of(kept, model.load) is None:
        yield finding("stud-no-measurement")
    if model.powers[-1]:
        yield from _computed_moduli(tests)


def _computed_moduli(tests: Specimens) -> Iterator[Finding]:
    """Moduli that are computed, of normal and of lightweight concrete, against EN 1992-1-1."""
    light, strength = tests.where("lightweight"), tests.concrete_strength
    european = 22e9 * (strength / 10e6) ** 0.3
    lighter = european * (tests.density / EUROPEAN_DENSITY) ** 2
    kinds = (
        (~light, european, "4733 sqrt(fc) MPa", "22 (fc/10)^0.3 GPa"),
        (light, lighter, "0.043 w^1.5 sqrt(fc) MPa", "22 (fc/10)^0.3 (w/2200)^2 GPa"),
    )
    for of_kind, other, formula, compared in kinds:
        rows = of_kind & ~tests.modulus_measured
        if rows.any():
            more = 100.0 * (other / tests.concrete_modulus - 1.0)[rows]
            low, high = float(np.min(more)), float(np.max(more))
            ends = (f"{abs(end):.0f} % {'more' if end > 0.0 else 'less'}" for end in (low, high))
            raises = "raise" if low > 0.0 else "lower" if high < 0.0 else "change"
            words = f"{' to '.join(dict.fromkeys(ends))} and would {raises}"
            which: dict[str, Any] = {"formula": formula, "other": compared, "more": words}
            yield finding("stud-computed-modulus", count=int(rows.sum()), **which)


def slab_findings(
    table: pd.DataFrame, kept: pd.DataFrame, slab: str, model: Formula
) -> Iterator[Finding]:
    """Tests in the other kind of slab that are left out; what is assumed of the decks of others.

    Of the latter what the rule of the `model` uses.
    """
    every = undamaged_headed_studs(table, "any", model.load)
    others = every[profiled(every) == (slab == "solid")]
    if slab != "any" and len(others):
        kind, other = ("profiled decks", "deck") if slab == "solid" else ("solid slabs", "solid")
        which: dict[str, Any] = {"count": len(others), "tests": len(every), "kind": kind}
        yield finding(
            "stud-other-slabs", float(len(others)), other=other, names=named(others), **which
        )
    in_deck = kept[profiled(kept)]
    usual = {"studs_per_rib": "one stud"}
    if model.deck_rule == "en1994":
        usual |= {"deck_thickness_mm": "a sheet of up to 1 mm", "deck_fixing": "welded through"}
    elif model.deck_rule == "aisc360":
        usual |= {"deck_stud_position_mm": "weak (AISC R_p 0.6)"}
    counts = {name: int((in_deck[name].isna() | (in_deck[name] == "")).sum()) for name in usual}
    assumed = [f"{name} of {n} tests: {usual[name]}" for name, n in counts.items() if n]
    if assumed:
        yield finding("stud-assumed-of-decks", assumed="; ".join(assumed))
