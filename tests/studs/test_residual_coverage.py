"""Synthetic laboratories after pre-damage: what the bands hold, and what is found of a loss.

Tests scatter by 8 % within and 6 % between 3 to 6 campaigns of 4 to 10 tests, over all damage. The
long form (--run-slow) is that of the table in docs/theory/studs-statistics.md.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm

from workbench.studs import fit_residual
from workbench.studs.schema import TESTS, from_frame

TRUTHS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "exponential": lambda d: np.exp(-0.6 * d),
    "square": lambda d: 1.0 - 0.4 * d**2,
    "root": lambda d: 1.0 - 0.4 * np.sqrt(d),
    "linear": lambda d: 1.0 - 0.4 * d,
    "threshold": lambda d: 1.0 - 0.4 * np.maximum(d - 0.3, 0.0) / 0.7,
}
LEVELS = np.linspace(0.0, 1.0, 41)
WITHIN, BETWEEN = 0.08, 0.06
Generator = np.random.Generator


def laboratory(
    generator: Generator, truth: str, sizes: list[int], most: float = 1.0
) -> pd.DataFrame:
    """Tests after fatigue of campaigns of some `sizes`, with damage up to `most`."""
    groups = np.repeat(np.arange(len(sizes)), sizes)
    level = np.round(most * generator.uniform(size=len(groups)), 4)
    effect = BETWEEN * generator.normal(size=len(sizes))[groups]
    error = effect + WITHIN * generator.normal(size=len(groups))
    left = np.maximum(TRUTHS[truth](level) + error, 0.01)
    values = {"test": "push-out", "diameter_mm": 19, "undamaged_shear_kN": 100.0,
            "predamage": "fatigue", "predamage_measure": "life fraction"}  # fmt: skip
    names = {
        "campaign": [f"lab {g}" for g in groups],
        "specimen": [f"s{i}" for i in range(len(groups))],
    }
    frame = pd.DataFrame({**names, "predamage_level": level, "shear_kN": 100.0 * left})
    return from_frame(frame.assign(**values), TESTS)


def measured(truth: str, runs: int, seed: int) -> tuple[float, float, float, float]:
    """Share of new tests of new campaigns in the band, its error; how often no loss is found.

    And how often the confidence band of the median holds the truth, over the tested damage.
    """
    generator, shares, medians, no_loss = np.random.default_rng(seed), [], [], 0
    for _ in range(runs):
        sizes = generator.integers(4, 11, generator.integers(3, 7)).tolist()
        fit = fit_residual(laboratory(generator, truth, sizes))
        no_loss += fit.relation.name == "none"
        band = fit.band(LEVELS)
        assert band is not None
        level = generator.uniform(0.0, fit.levels[1], 200)
        scatter = np.hypot(WITHIN, BETWEEN)
        ratio = TRUTHS[truth](level) + scatter * generator.normal(size=200)
        known = np.isfinite(band[0])
        low, high = (np.interp(level, LEVELS[known], side[known]) for side in band)
        shares.append(np.mean((ratio >= low) & (ratio <= high)))
        rows = fit.design_rows()
        truth_there = TRUTHS[truth](rows["level"].to_numpy())
        medians.append(np.mean((truth_there >= rows["low"]) & (truth_there <= rows["high"])))
    error = float(np.std(shares) / np.sqrt(runs))
    return float(np.mean(shares)), error, no_loss / runs, float(np.mean(medians))


@pytest.mark.thorough
def test_bands_of_laboratories_are_not_off() -> None:
    share, error, no_loss, median = measured("linear", 3, 5)
    assert 0.87 - 2.0 * error <= share <= 0.95 + 2.0 * error
    assert no_loss == 0.0
    assert median >= 0.7


TOO_NARROW = "square", "root"  # see the theory page


@pytest.mark.slow
@pytest.mark.parametrize("truth", TRUTHS)
def test_bands_of_two_hundred_laboratories(truth: str) -> None:
    share, _, no_loss, median = measured(truth, 200, 31)
    assert 0.87 <= share <= 0.95, share
    assert no_loss <= 0.05
    if truth in TOO_NARROW and median < 0.86:
        pytest.xfail(f"the band of the median holds {median:.2f}, nominally 0.90")
    assert 0.86 <= median <= 0.99, median


def below(sizes: list[int], runs: int) -> float:
    """Share of new tests in new campaigns below the characteristic value, truths in turn."""
    generator, shares = np.random.default_rng(2), []
    for run in range(runs):
        truth = list(TRUTHS)[run % len(TRUTHS)]
        fit = fit_residual(laboratory(generator, truth, sizes))
        rows = fit.design_rows()
        short = rows["characteristic"] - TRUTHS[truth](rows["level"].to_numpy())
        shares.append(norm.cdf(short / np.hypot(WITHIN, BETWEEN)).mean())
    return float(np.mean(shares))


@pytest.mark.thorough
def test_characteristic_values_are_not_off() -> None:
    assert 0.005 <= below([6, 6, 6], 5) <= 0.1


@pytest.mark.slow
@pytest.mark.parametrize("sizes", [[6] * 3, [4] * 4, [6] * 6])
def test_five_percent_of_new_tests_lie_below_characteristic_values(sizes: list[int]) -> None:
    assert 0.03 <= below(sizes, 200) <= 0.07


def test_two_campaigns_give_no_characteristic_value() -> None:
    """EN 1990 D.8 on the tests that the relation was fitted to: 15 to 19 % of new ones below."""
    fit = fit_residual(laboratory(np.random.default_rng(1), "linear", [4, 4]))
    assert fit.design_rows()[["characteristic", "design"]].isna().all(axis=None)
    findings = " ".join(f"{finding.text} {finding.remedy}" for finding in fit.findings)
    assert "no characteristic or design value" in findings
    assert "fit few-tests with a scatter that is known" in findings


def test_a_parameter_that_reaches_its_bound_does_not_end_a_fit() -> None:
    """The criterion counted only parameters off their bounds: no interval could be bracketed."""
    level = [0.4066, 0.3502, 0.2524, 0.1101, 0.1756, 0.1758]
    left = [67.371, 67.280, 65.869, 102.266, 81.325, 85.829]
    table = laboratory(np.random.default_rng(1), "linear", [6])
    fit = fit_residual(table.assign(predamage_level=level, shear_kN=left))
    assert all(c.estimate.sigma > 0.0 for c in fit.averaged)


@pytest.mark.thorough
def test_a_criterion_with_kinks_does_not_end_a_fit() -> None:
    """The 175th laboratory of six campaigns: the estimate of a threshold lay in a side valley."""
    generator = np.random.default_rng(2)
    for run in range(175):
        table = laboratory(generator, list(TRUTHS)[run % len(TRUTHS)], [6] * 6)
    fitted = fit_residual(table).fitted
    assert fitted is not None
    for each in fitted.parameters.values():
        assert each.low <= each.value <= each.high


@pytest.mark.thorough
def test_a_second_valley_does_not_end_an_interval_of_the_scatters() -> None:
    """The 163rd of a threshold: followed from one campaign effect to the next, it was lost."""
    generator = np.random.default_rng(31)
    for _ in range(163):
        sizes = generator.integers(4, 11, generator.integers(3, 7)).tolist()
        table = laboratory(generator, "threshold", sizes)
        generator.uniform(size=200)
        generator.normal(size=200)
    fitted = fit_residual(table).fitted
    assert fitted is not None
    for name in ("sigma", "tau"):
        low, high = (fitted.scatters[f"{name}_{end}"] for end in ("low", "high"))
        assert 0.0 < low < fitted.scatters[name] < high < 0.2


def test_a_loss_that_shows_beyond_the_tests_is_not_denied_there() -> None:
    """1 - 0.4 D^2 tested up to 0.5: a band there would hold next to nothing at 1."""
    fit = fit_residual(laboratory(np.random.default_rng(3), "square", [6, 6, 6], 0.5))
    low, high = fit.band([0.4, 1.0])
    assert low[0] < TRUTHS["square"](np.array(0.4)) < high[0]
    assert np.isnan([low[1], high[1]]).all()
    assert fit.extrapolates([0.4, 1.0]).tolist() == [False, True]
