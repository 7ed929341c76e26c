"""Fits of strength formulas: recovery, honesty about few campaigns, refusal of seen rows."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

from workbench.base.errors import InputError
from workbench.studs import SHEAR_MODELS, TESTS, StrengthFit, fit_factors, fit_strength
from workbench.studs.fit_protocol import plain
from workbench.studs.schema import from_frame
from workbench.studs.tables import identity_of, specimens, undamaged_headed_studs


def campaigns_of(
    model: str, count: int = 8, tests: int = 6, *, bias: float = 1.1, tau: float = 0.08,
    sigma: float = 0.06, trend: float = 0.0, seed: int = 0,
) -> pd.DataFrame:  # fmt: skip
    """Synthetic push-outs of several laboratories around a formula."""
    generator = np.random.default_rng(seed)
    rows = []
    for j in range(count):
        effect = tau * generator.normal()
        for i in range(tests):
            rows.append(
                {
                    "campaign": f"lab {j}", "specimen": f"s{i}", "test": "push-out",
                    "origin": "synthetic", "diameter_mm": generator.choice([16.0, 19.0, 22.0]),
                    "height_mm": 120.0, "fcm_MPa": round(generator.uniform(20, 60), 2),
                    "fu_MPa": round(generator.uniform(420, 520), 1),
                    "effect": effect + sigma * generator.normal(),
                }
            )  # fmt: skip
    frame = pd.DataFrame(rows)
    effect = frame.pop("effect").to_numpy()
    table = from_frame(frame.assign(shear_kN=1.0 + 99.0), TESTS)
    tests_ = specimens(table)
    resistance = SHEAR_MODELS[model].of(tests_) * bias * np.exp(effect)
    resistance *= (tests_.concrete_strength / 36e6) ** trend
    return from_frame(frame.assign(shear_kN=resistance / 1e3), TESTS)


def texts(fit: StrengthFit) -> list[str]:
    return [finding.text for finding in fit.findings]


def test_bias_and_scatters_are_recovered() -> None:
    fit = fit_strength(campaigns_of("roik-mean", 20, bias=0.75), "roik-mean")
    bias = fit.fitted.parameters["bias"]
    assert bias.low < 0.75 < bias.high
    assert fit.fitted.sigma.low < 0.06 < fit.fitted.sigma.high
    assert fit.fitted.tau.low < 0.08 < fit.fitted.tau.high
    assert np.mean([each.covered for each in fit.left_out]) > 0.8
    # 5 % fractile of a new campaign: 0.75 exp(-1.645 x 0.1) = 0.636 with scatters known
    assert 0.58 < fit.new_campaign_factor < 0.65  # measured 0.605
    measured, modulus = texts(fit)
    assert measured == "the uncertainty of the measured loads is not reported: it stays in sigma"
    assert "(ACI 318), not measured; 22 (fc/10)^0.3 GPa of EN 1992-1-1 is" in modulus
    assert modulus.startswith("in 120 tests the modulus of concrete is computed as 4733 sqrt(fc)")
    assert fit.model_scatter is None


def test_the_scatter_of_the_measurement_is_taken_out() -> None:
    table = campaigns_of("roik-mean", 4)
    known = fit_strength(table.assign(shear_uncertainty_kN=0.05 * table["shear_kN"]))
    assert known.measurement == pytest.approx(0.05)
    total = known.fitted.sigma.value**2 + known.fitted.tau.value**2
    assert known.model_scatter == pytest.approx(np.sqrt(total - 0.05**2))


def test_a_missing_trend_is_found() -> None:
    table = campaigns_of("ollgaard", 10, trend=-0.2)
    fit = fit_strength(table, "ollgaard", trends=("concrete_strength",))
    trend = fit.fitted.parameters["concrete_strength"]
    assert trend.low < -0.2 < trend.high
    assert trend.high < 0.0
    with pytest.raises(InputError, match="trends"):
        fit_strength(table, trends=("colour",))


def test_predictions_follow_the_fit() -> None:
    table = campaigns_of("roik-mean", 6, tau=0.0, sigma=1e-4)
    fit = fit_strength(table, "roik-mean", trends=("diameter",))
    tests = specimens(undamaged_headed_studs(table))
    assert fit.predict(tests) == pytest.approx(tests.shear, rel=3.7e-4)  # measured 1.85e-4


def test_d8_inside_the_fit_speaks_of_the_reference_stud() -> None:
    fit = fit_strength(campaigns_of("roik-mean", 6, tau=0.0), "roik-mean")
    assert fit.d8.count == 36
    assert fit.d8.b == pytest.approx(1.1, abs=0.016)  # measured 0.0078
    assert fit.d8.r_d < fit.d8.r_k < fit.d8.r_m * fit.d8.b
    assert fit.d8.gamma_m_star == pytest.approx(fit.d8.r_nominal / fit.d8.r_d)
    certain = fit_strength(campaigns_of("roik-mean", 6, tau=0.0), "roik-mean", variations={})
    assert certain.d8.V_rt == 0.0
    assert certain.d8.r_k > fit.d8.r_k


def test_validation_on_calibration_rows_is_refused(push_outs: pd.DataFrame) -> None:
    calibration = push_outs[push_outs["campaign"] == "provines2019"]
    fit = fit_strength(calibration)
    with pytest.raises(InputError, match="was used for the fit"):
        fit.judge(calibration)
    with pytest.raises(InputError, match="was used for the fit"):
        fit.judge(push_outs)  # one seen row is enough
    renamed = calibration.assign(campaign="our own lab", specimen=[f"n{i}" for i in range(24)])
    with pytest.raises(InputError, match="equals a row of the fit under other names"):
        fit.judge(renamed)
    spaced = calibration.assign(specimen=[f" {s.upper()} " for s in calibration["specimen"]])
    with pytest.raises(InputError, match="was used for the fit"):
        fit.judge(spaced)


def test_validation_on_other_campaigns_shows_the_error(push_outs: pd.DataFrame) -> None:
    fit = fit_strength(push_outs[push_outs["campaign"] == "provines2019"], "roik-mean")
    result = fit.judge(push_outs[push_outs["campaign"] == "lehigh279"], corrected=True)
    assert len(result.rows) == 2
    assert result.summary["known_campaigns"] == ""
    assert result.summary["covered"] is None  # one campaign tells nothing of another
    bias = result.summary["test_over_prediction"]
    assert bias == pytest.approx(0.91, abs=2.1e-4)  # measured 1.0e-4
    half = push_outs[push_outs["specimen"].str.endswith("CIP")]
    other = push_outs[push_outs["specimen"].str.endswith("PC")]
    assert fit_strength(half).judge(other).summary["known_campaigns"] == "provines2019"


def test_two_specimens_of_equal_content_in_one_campaign_are_two_tests() -> None:
    table = campaigns_of("roik-mean", 2)
    twin = table.assign(specimen=[f"twin of {s}" for s in table["specimen"]])
    identity_of(table).refuse_overlap(twin)


def test_shipped_tests_are_judged_with_their_caveats(push_outs: pd.DataFrame) -> None:
    fit = fit_strength(push_outs, "en1994")
    assert len(fit.rows) == 26
    assert fit.new_campaign_factor is None
    text = " ".join(texts(fit))
    assert "24 of 26 tests exceed the tensile strength of their shank" in text
    assert "two campaigns: nothing tells how much campaigns differ" in text
    # calibrated on this one campaign, a formula would give 1.5 times the Eurocode mean
    only = fit_strength(push_outs[push_outs["campaign"] == "provines2019"], "en1994")
    assert only.bias == pytest.approx(1.5, abs=7e-3)  # measured 0.0031
    assert only.fitted.tau.high is None
    content = json.dumps(plain({"fit": fit.summary(), **fit.tables()}), allow_nan=False)
    assert "new_campaign_factor" in content


def test_rows_that_a_fit_may_not_use_are_left_out(push_outs: pd.DataFrame) -> None:
    used = undamaged_headed_studs(push_outs)
    assert set(used["campaign"]) == {"provines2019", "lehigh279"}
    with pytest.raises(InputError, match="use_for_fit is 0: 11"):
        undamaged_headed_studs(push_outs[push_outs["use_for_fit"] == 0.0])
    unknown = used.assign(fcm_MPa=np.nan, Ecm_MPa=np.nan)
    with pytest.raises(InputError, match="no test with all values that Roik"):
        fit_strength(unknown)
    with pytest.raises(InputError, match="must be one of en1994"):
        fit_strength(push_outs, "en1995")


def test_robust_fit_is_not_led_by_a_wrong_row() -> None:
    table = campaigns_of("roik-mean", 6, tau=0.02)
    bad = table.assign(shear_kN=np.where(np.arange(len(table)) == 7, 2.5, 1.0) * table["shear_kN"])
    clean, plain, robust = (
        fit_strength(t, loss=loss).bias
        for t, loss in ((table, "linear"), (bad, "linear"), (bad, "bisquare"))
    )
    assert abs(robust - clean) < 0.085 * abs(plain - clean)  # measured 0.043


def test_factors_are_recovered_and_refused_without_influence() -> None:
    table = campaigns_of("roik-mean", 10, bias=1.0, tau=0.03, sigma=0.03)
    start = SHEAR_MODELS["roik-mean"].scaled(steel=0.9, concrete=0.3)
    fit = fit_factors(table, start, ("concrete", "steel"))
    steel, concrete = start.scaled(**fit.estimates).terms(specimens(table))
    assert 0.1 < np.mean(steel < concrete) < 0.9  # both govern some tests
    for name, truth in (("concrete", 0.374), ("steel", 1.0)):
        result = fit.parameters[name]
        assert result.low < truth < result.high
        assert result.value == pytest.approx(truth, rel=0.03)  # measured 0.014
    weak = table.assign(fcm_MPa=15.0)
    with pytest.raises(InputError, match=r"steel = .*has no influence"):
        fit_factors(weak, "roik-mean", ("steel",))
    with pytest.raises(InputError, match="has no steel term"):
        fit_factors(table, "ollgaard", ("steel",))
    with pytest.raises(InputError, match="must be one of steel, concrete"):
        fit_factors(table, "roik-mean", ("weld",))
