"""Flanges that fold: the rule, and the drawn shells that it was fitted to."""

from __future__ import annotations

import numpy as np
import pytest

from workbench.base.catalogue import load
from workbench.models.base import make_model
from workbench.models.domain import FOLDS, FOLDS_FROM, FOLDS_MUCH, buckling_findings
from workbench.responses import Finding, findings_of
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.materials import Steel
from workbench.steel.sections import i_section

DRAWN = load("slender-shells")
ANSWERED = DRAWN[DRAWN["shell_outcome"] == "ok"]
FARTHER = ANSWERED["shell_axis_m"] / ANSWERED["fiber_space_m"]
SLENDER = ANSWERED["flange_over_epsilon"] > ANSWERED["axis"].map(FOLDS_FROM)
FELL = 0.45  # of the squash load
THIN = Column(i_section(0.3, 0.25, 0.008, 0.008), 1.5, 2.5, Steel(yield_stress=355e6))


def folding_findings(column: Column) -> list[Finding]:
    """Those of a hit column about its plates."""
    found = buckling_findings(ColumnImpact("hit", column, Striker(600.0, 6.0), 0.02))
    return [each for each in found if each.subject == "local-buckling"]


def test_the_rule_is_that_of_the_stored_shells() -> None:
    kept = SLENDER & (ANSWERED["axis"] == "strong") & (ANSWERED["axial_over_squash"] < FELL)
    rows = ANSWERED[kept]
    numbers = rows[["axial_over_squash", "flange_over_epsilon"]]
    given = np.column_stack([np.ones(len(rows)), numbers])
    slope = np.linalg.lstsq(given, np.log(FARTHER[kept]))[0]
    assert list(FOLDS) == pytest.approx(slope, rel=0.03)
    assert np.abs(np.log(FARTHER[kept]) - given @ FOLDS).max() < 0.10


def test_plates_that_are_not_warned_of_hold() -> None:
    """Within the 10 % of the rule and its rest; all of those that fell are warned of."""
    for number, row in DRAWN.iterrows():
        sizes = (row[f"{part}_m"] for part in ("height", "width", "web", "flange"))
        column = Column(
            i_section(*sizes),
            row["length_below_m"],
            row["length_above_m"],
            Steel(yield_stress=row["yield_stress_Pa"]),
            axial_load=row["axial_load_N"],
            axis=row["axis"],
        )
        if not folding_findings(column):
            assert row["axial_over_squash"] < FELL
            assert FARTHER[number] < 1.16


def test_models_say_how_far_flanges_fold() -> None:
    pressed = THIN.changed(axial_load=0.2 * THIN.properties.squash_load)
    hit = ColumnImpact("hit", pressed, Striker(600.0, 6.0), 0.02)
    (warned,) = (
        each
        for each in findings_of(make_model("four-dof").simulate(hit))
        if each.subject == "local-buckling"
    )
    outstand = (0.5 * (0.25 - 0.008)) / 0.008 / np.sqrt(235.0 / 355.0)
    expected = np.exp(np.dot(FOLDS, (1.0, 0.2, outstand)))
    assert warned.number == pytest.approx(expected, rel=1e-9)
    assert f"about {expected:.2f} times" in warned.text
    assert warned.number > FOLDS_MUCH


def test_stocky_flanges_and_tubes_are_not_warned_of() -> None:
    thick = THIN.changed(section=i_section(0.3, 0.25, 0.008, 0.016))
    assert folding_findings(thick.changed(axial_load=1e6)) == []
    assert folding_findings(Column("SHS 200x10", 1.5, 2.5)) == []
