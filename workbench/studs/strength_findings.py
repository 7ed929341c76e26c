"""What is to be said of the tests behind a fit of strength, and of their measurement."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from workbench.responses import Finding
from workbench.studs.formulas import Formula
from workbench.studs.quantities import Specimens, named, profiled, undamaged_headed_studs
from workbench.studs.statistics.annex_d import LEAST_FOR_DESIGN
from workbench.studs.statistics.problem import Problem

ABOVE_STEEL = 1.0
FEW_CAMPAIGNS = 5


def measurement_of(kept: pd.DataFrame, load: str) -> float | None:
    """Root mean square of the relative uncertainty of the loads, if all rows report it."""
    relative = (kept[f"{load}_uncertainty_kN"] / kept[f"{load}_kN"]).to_numpy(float)
    return float(np.sqrt(np.mean(relative**2))) if np.all(np.isfinite(relative)) else None


def _stiffer(tests: Specimens) -> str:
    """By how much the modulus of EN 1992-1-1 exceeds the computed one, in words."""
    own = ~tests.modulus_measured
    european = 22e9 * (tests.concrete_strength[own] / 10e6) ** 0.3
    more = 100.0 * (european / tests.concrete_modulus[own] - 1.0)
    low, high = float(np.min(more)), float(np.max(more))
    return f"{low:.0f} %" if high - low < 1.0 else f"{low:.0f} to {high:.0f} %"


def strength_findings(
    kept: pd.DataFrame, tests: Specimens, model: Formula, given: Problem
) -> Iterator[Finding]:
    """What a fit to tests warns of."""
    yield from model.findings(tests)
    strongest = tests.area * tests.ultimate_strength
    above = int(np.sum(tests.quantity(model.load) / strongest > ABOVE_STEEL))
    if above:
        yield Finding(
            "shank",
            f"{above} of {len(tests)} tests exceed the tensile strength of their shank: part of "
            "their load was carried otherwise (bond, friction, weld collar), and a formula "
            "calibrated on them alone would be unsafe",
        )
    yield from _campaign_findings(given)
    if given.count < LEAST_FOR_DESIGN:
        yield Finding(
            "tests",
            f"{given.count} tests: EN 1990 has no factor of the design value for fewer than "
            f"{LEAST_FOR_DESIGN} with unknown scatter",
        )
    if measurement_of(kept, model.load) is None:
        text = "the uncertainty of the measured loads is not reported: it stays in sigma"
        yield Finding("measurement", text)
    computed = int(np.sum(~tests.modulus_measured))
    if computed and model.powers[-1]:
        yield Finding(
            "modulus",
            f"the modulus of concrete is computed as 4733 sqrt(fc) MPa (ACI 318), not measured, in "
            f"{computed} tests; 22 (fc/10)^0.3 GPa of EN 1992-1-1 is {_stiffer(tests)} more and "
            "would raise predictions that the concrete governs: give Ecm_MPa to use another",
        )


def other_slabs(table: pd.DataFrame, slab: str, load: str) -> Iterator[Finding]:
    """That tests in the other kind of slab are left out, and which."""
    every = undamaged_headed_studs(table, "any", load)
    others = every[profiled(every) == (slab == "solid")]
    if slab != "any" and len(others):
        kind, other = ("profiled decks", "deck") if slab == "solid" else ("solid slabs", "solid")
        text = f"{len(others)} of {len(every)} tests in {kind} are left out: {named(others)}"
        yield Finding("tests", text, remedy=f"--slab {other}", number=float(len(others)))


def deck_findings(kept: pd.DataFrame) -> Iterator[Finding]:
    """What is assumed of profiled decks that the table does not tell."""
    in_deck = kept[profiled(kept)]
    usual = {
        "deck_thickness_mm": "a sheet of up to 1 mm",
        "studs_per_rib": "one stud",
        "deck_fixing": "welded through",
        "deck_stud_position_mm": "weak (AISC R_p 0.6)",
    }
    counts = {name: int((in_deck[name].isna() | (in_deck[name] == "")).sum()) for name in usual}
    texts = [f"{name} of {n} tests: {usual[name]}" for name, n in counts.items() if n]
    if texts:
        yield Finding("stud", f"decks: not told, so assumed: {'; '.join(texts)}")


def left_without_value(count: int, total: int, model: Formula) -> Iterator[Finding]:
    """That tests were left out, without a value of the formula."""
    if count:
        why = "missing values, or a stud or a deck outside its rules"
        text = f"{count} of {total} tests left out: {model.title} has no value for them ({why})"
        yield Finding("range", text)


def _campaign_findings(given: Problem) -> Iterator[Finding]:
    if given.count == given.campaigns > 1:
        why = "one test per campaign: the scatter within and between campaigns cannot be told apart"
        yield Finding("campaigns", why)
    few = f"{given.campaigns} campaigns: the scatter between campaigns is hardly known"
    texts = {
        1: "one campaign: nothing can be said about the scatter between campaigns",
        2: "two campaigns: nothing tells how much campaigns differ; the interval of the bias is "
        "too narrow and without a prior of tau there is no value for a new campaign",
    }
    if given.campaigns < FEW_CAMPAIGNS:
        yield Finding("campaigns", texts.get(given.campaigns, few))
