"""What a fit of strength prints, recomputed with statsmodels and plain numpy from the table."""

from __future__ import annotations

import warnings
from math import exp, log, sqrt

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from workbench.studs import evaluate_groups, fit_strength
from workbench.studs.schema import TESTS, from_frame
from workbench.studs.statistics.intervals import profile_interval
from workbench.studs.strength_fit import VARIATIONS

mixed = pytest.importorskip("statsmodels.regression.mixed_linear_model", reason="extra test")
TOLERANCE = 1e-4


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    """Unbalanced campaigns of push-outs, which differ."""
    generator, rows = np.random.default_rng(17), []
    for j, count in enumerate((3, 9, 5, 7, 4, 6)):
        effect = 0.1 * generator.normal()
        for i in range(count):
            d, fc, fu = generator.choice([16.0, 19.0, 22.0]), generator.uniform(25, 50), 470.0
            shear = 0.9 * formula(d, fc, fu) * exp(effect + 0.07 * generator.normal())
            rows.append((f"lab {j}", f"s{i}", "push-out", d, 6.0 * d, fc, fu, round(shear, 3)))
    names = ("campaign", "specimen", "test", "diameter_mm", "height_mm", "fcm_MPa", "fu_MPa")
    return from_frame(pd.DataFrame(rows, columns=[*names, "shear_kN"]), TESTS)


def formula(d: float, fc: float, fu: float, ec: float | None = None) -> float:
    """Mean form of EN 1994-1-1 in kN from mm and MPa."""
    modulus = 4733.0 * np.sqrt(fc) if ec is None else ec
    concrete = 0.374 * d**2 * np.sqrt(fc * modulus)
    return np.minimum(0.25 * np.pi * d**2 * fu, concrete) / 1e3


def columns(table: pd.DataFrame) -> tuple[np.ndarray, ...]:
    names = ("diameter_mm", "fcm_MPa", "fu_MPa", "shear_kN")
    return tuple(table[name].to_numpy(float) for name in names)


@pytest.mark.claim("model:stud-strength", "bias over statsmodels", "another program", 1, 1e-4)
@pytest.mark.parametrize("trends", [(), ("diameter",)])
def test_bias_and_scatters_are_those_of_statsmodels(
    table: pd.DataFrame, trends: tuple[str, ...], claim
) -> None:
    d, fc, fu, shear = columns(table)
    design = np.ones((len(d), 1))
    if trends:
        design = np.column_stack([design, np.log(d) - np.mean(np.log(d))])
    ratio = np.log(shear / formula(d, fc, fu))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        oracle = mixed.MixedLM(ratio, design, groups=table["campaign"].to_numpy(str)).fit(
            reml=True, method="powell", xtol=1e-10, ftol=1e-12
        )
    fit = fit_strength(table, "roik-mean", trends=trends).fitted
    claim(fit.parameters["bias"].value / exp(oracle.fe_params[0]))
    if trends:
        slope = fit.parameters["diameter"].value
        assert slope == pytest.approx(oracle.fe_params[1], rel=TOLERANCE)
    assert fit.sigma.value == pytest.approx(sqrt(oracle.scale), rel=TOLERANCE)
    assert fit.tau.value == pytest.approx(sqrt(oracle.cov_re[0, 0]), rel=TOLERANCE)
    error = sqrt(fit.estimate.covariance[0, 0])
    assert error == pytest.approx(oracle.bse_fe[0], rel=TOLERANCE)


def test_the_interval_of_balanced_campaigns_is_that_of_their_means() -> None:
    generator = np.random.default_rng(18)
    effects = 0.1 * generator.normal(size=(5, 1))
    ratios = 0.95 * np.exp(effects + 0.05 * generator.normal(size=(5, 6)))
    shear = (ratios * formula(19.0, 30.0, 450.0)).ravel()
    values = {"test": "push-out", "diameter_mm": 19.0, "height_mm": 100.0, "fcm_MPa": 30.0}
    names = {"campaign": np.repeat([f"lab {j}" for j in range(5)], 6).tolist()}
    frame = pd.DataFrame({**names, "specimen": [f"s{i}" for i in range(30)], "shear_kN": shear})
    fit = fit_strength(from_frame(frame.assign(**values, fu_MPa=450.0), TESTS), "roik-mean")
    means = np.log(ratios).mean(axis=1)
    ends = stats.t.interval(0.9, 4, means.mean(), means.std(ddof=1) / sqrt(5))
    interval = profile_interval(fit.fitted.estimate, "bias", 0.9)
    assert interval[:2] == pytest.approx(ends, rel=TOLERANCE)


def test_the_chain_of_d8_is_that_of_plain_numpy(table: pd.DataFrame) -> None:
    d, fc, fu, shear = columns(table)
    theory = formula(d, fc, fu)
    b = (shear @ theory) / (theory @ theory)
    delta = np.log(shear / (b * theory))
    n = len(delta)
    v_delta = sqrt(exp(np.var(delta, ddof=1)) - 1.0)
    means = [exp(np.mean(np.log(x))) for x in (d, fc, fu, 4733.0 * np.sqrt(fc))]
    order = ("diameter", "concrete_strength", "ultimate_strength", "concrete_modulus")
    v_rt2 = 0.0
    for k, name in enumerate(order):
        up, down = ([m * (1.0 + e * (i == k)) for i, m in enumerate(means)] for e in (1e-5, -1e-5))
        slope = (formula(*up) - formula(*down)) / (2e-5 * formula(*means))
        v_rt2 += (slope * VARIATIONS[name]) ** 2
    q2 = log((1.0 + v_delta**2) * (1.0 + v_rt2))
    alpha_rt, alpha_delta = sqrt(log(1.0 + v_rt2) / q2), sqrt(log(1.0 + v_delta**2) / q2)
    values = {}
    for name, limit, p in (("r_k", 1.64, 0.95), ("r_d", 3.04, 0.999)):
        k = stats.t.ppf(p, n - 1) * sqrt(1.0 + 1.0 / n)
        weighted = limit * alpha_rt * sqrt(log(1.0 + v_rt2))
        weighted += k * alpha_delta * sqrt(log(1.0 + v_delta**2))
        values[name] = 1e3 * b * formula(*means) * exp(-weighted - 0.5 * q2)
    d8 = fit_strength(table, "roik-mean").d8
    expected = {"b": b, "V_delta": v_delta, "V_rt": sqrt(v_rt2), "Q": sqrt(q2), **values}
    assert {name: getattr(d8, name) for name in expected} == pytest.approx(expected, rel=TOLERANCE)
    assert d8.gamma_m == pytest.approx(values["r_k"] / values["r_d"], rel=TOLERANCE)


def test_annex_b_is_that_of_plain_arithmetic() -> None:
    loads = np.array([101.0, 108.0, 104.0])
    values = {"campaign": "lab", "test": "push-out", "diameter_mm": 19, "height_mm": 100}
    frame = pd.DataFrame({"specimen": ["a", "b", "c"], "shear_kN": loads, "fcm_MPa": 30.0})
    (group,) = evaluate_groups(
        from_frame(frame.assign(**values, fu_MPa=480.0), TESTS), specified_strength=450e6
    )
    assert np.all(np.abs(loads / loads.mean() - 1.0) <= 0.1)
    assert group.result is not None
    assert group.result.P_Rk == pytest.approx(0.9e3 * 101.0, rel=TOLERANCE)
    design = 450.0 / 480.0 * 0.9e3 * 101.0 / 1.25
    assert group.result.P_Rd == pytest.approx(design, rel=TOLERANCE)
