"""Relations that end a fatigue life at the peak of its load cycles, R(1) = P_max / P_u."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from workbench.studs import RELATIONS, TESTS, ResidualFit, fit_residual
from workbench.studs.relations import ANCHORED, Relation
from workbench.studs.schema import from_frame

THETA = {"oehlers": (), "anchored-power": (0.4,), "inverted-s": (0.7, 0.05)}


@pytest.mark.parametrize("name", ANCHORED)
def test_every_life_ends_at_its_peak(name: str) -> None:
    relation, level = ANCHORED[name].at(0.45), np.linspace(0.0, 1.0, 201)
    left = relation(level, THETA[name])
    assert (left[0], left[-1]) == pytest.approx((1.0, 0.45))
    assert np.all(np.diff(left) <= 1e-12)
    assert relation.formula.endswith("P_max/P_u = 0.45")
    given = ANCHORED[name].at(np.array([0.3, 0.6]))([1.0, 1.0], THETA[name])
    assert given == pytest.approx([0.3, 0.6])


@pytest.mark.claim(
    "model:stud-residual", "share left by {name} at {level}", "closed form", "{expected}", 1e-5
)
@pytest.mark.parametrize(
    ("name", "level", "expected"),
    [
        ("oehlers", 0.5, 0.7),  # 1 - 0.6 x 0.5
        ("anchored-power", 0.25, 0.65539),  # 1 - 0.6 x 0.25^0.4
        ("inverted-s", 0.5, 0.7),  # ln 1 = 0
        ("inverted-s", 0.9, 0.59014),  # 0.7 - 0.05 ln 9
        ("inverted-s", 0.001, 1.0),  # 0.7 + 0.05 ln 999 = 1.045
        ("inverted-s", 0.9999, 0.4),  # 0.239 is less than the peak
    ],
)
def test_relations_by_hand(name: str, level: float, expected: float, claim) -> None:
    claim(ANCHORED[name].at(0.4)(level, THETA[name]))


def fatigue(truth: Relation, labs: int = 4, tests: int = 10, **changes: object) -> pd.DataFrame:
    """Tests of laboratories whose load cycles had two peaks."""
    generator, rows = np.random.default_rng(6), []
    for j in range(labs):
        effect = 0.01 * generator.normal()
        for i in range(tests):
            peak, level = (0.35, 0.6)[i % 2], generator.uniform(0.05, 0.99)
            left = float(truth.at(peak)(level, THETA[truth.name])) + effect
            rows.append({
                "campaign": f"lab {j}", "specimen": f"s{i}", "test": "push-out", "diameter_mm": 22,
                # a stud bears what its cycles have just put on it
                "shear_kN": 150 * max(left + 0.02 * generator.normal(), peak),
                "undamaged_shear_kN": 150.0,
                "predamage": "fatigue", "predamage_measure": "life fraction",
                "predamage_level": level, "predamage_peak_kN": 150 * peak, **changes,
            })  # fmt: skip
    return from_frame(pd.DataFrame(rows), TESTS)


def weights(fit: ResidualFit) -> dict[str, float]:
    return {score.name: score.weight for score in fit.scores}


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["oehlers", "inverted-s"])
def test_the_law_of_the_laboratories_is_found(name: str) -> None:
    table = fatigue(ANCHORED[name])
    fit = fit_residual(table)
    result = weights(fit)
    assert set(result) == {*RELATIONS, *ANCHORED}
    # a power with the exponent one is that of Oehlers
    mine = result[name] + (result["anchored-power"] if name == "oehlers" else 0.0)
    assert mine > 0.9
    for peak in (0.35, 0.6):
        assert float(fit.left(1.0, peak)) == pytest.approx(peak, abs=0.04)
    assert float(fit.left(1.0)) == pytest.approx(0.475, abs=0.04)
    assert any("0.35 to 0.60: curves are for 0.47" in each.text for each in fit.findings)


def test_unseen_tests_are_judged_at_their_own_peak() -> None:
    table = fatigue(ANCHORED["oehlers"])
    held = table[table["campaign"] == "lab 3"]
    fit = fit_residual(table[table["campaign"] != "lab 3"])
    assert fit.judge(held).summary["scatter"] == pytest.approx(0.03, abs=0.02)


def test_without_peaks_nothing_is_anchored() -> None:
    fit = fit_residual(fatigue(ANCHORED["oehlers"], predamage_peak_kN=np.nan))
    assert set(weights(fit)) == set(RELATIONS)
    (finding,) = [each for each in fit.findings if "peak of their cycles" in each.text]
    assert "40 of 40 tests do not tell" in finding.text
    assert finding.remedy == "give predamage_peak_kN"


def test_other_damage_has_no_such_end() -> None:
    table = fatigue(ANCHORED["oehlers"], predamage_measure="S-N life fraction")
    assert set(weights(fit_residual(table))) == set(RELATIONS)
