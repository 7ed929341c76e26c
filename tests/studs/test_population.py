"""Which tests enter a fit of the headed stud in a solid slab, and which make a series."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from workbench.studs import POINTS, TESTS, evaluate_groups, fit_load_slip, fit_strength, shipped
from workbench.studs.schema import from_frame


def table(**changes: object) -> pd.DataFrame:
    """Eight push-outs of two campaigns, with some columns changed."""
    loads = [101.3, 108.4, 97.2, 104.9, 110.6, 99.8, 103.1, 106.0]
    values = {"campaign": ["lab 1"] * 4 + ["lab 2"] * 4, "specimen": [f"s{i}" for i in range(8)],
            "test": "push-out", "diameter_mm": 19.0, "height_mm": 100.0, "fcm_MPa": 31.0,
            "fu_MPa": 470.0, "shear_kN": loads, "use_for_fit": 1}  # fmt: skip
    return from_frame(pd.DataFrame(values).assign(**changes), TESTS)


def last(value: object, other: object) -> list[object]:
    return [other] * 7 + [value]


@pytest.mark.parametrize(
    "changes",
    [
        {"deck_depth_mm": last(55.0, np.nan)},
        {"slab": last("deck transverse", "solid")},
        {"test": last("combined", "push-out"), "tension_kN": last(30.0, np.nan)},
    ],
)
def test_decks_and_combined_tests_do_not_enter_the_solid_slab(changes: dict[str, object]) -> None:
    fit = fit_strength(table(**changes))
    assert fit.rows["specimen"].tolist() == [f"s{i}" for i in range(7)]


def test_a_stud_that_a_formula_has_no_value_for_takes_no_other_with_it() -> None:
    fit = fit_strength(table(height_mm=last(50.0, 100.0)), "en1994")
    assert len(fit.rows) == 7
    assert any("1 of 8 tests left out: EN 1994-1-1 has no value" in f.text for f in fit.findings)


def test_a_series_may_have_cylinders_that_scatter() -> None:
    strengths = [31.0, 32.5, 30.2, 33.0, 20.0, 25.0, 31.0, 26.0]
    evaluation = evaluate_groups(table(fcm_MPa=strengths), specified_strength=450e6)
    assert [each.tests for each in evaluation] == [4, 1, 2, 1]
    assert evaluation[0].result is not None


def test_curves_must_be_those_of_the_tests() -> None:
    rows = table().iloc[:3]
    points = [
        {"campaign": "lab 1", "specimen": name, "slip_mm": slip, "load_kN": share * load}
        for name, load in zip(rows["specimen"], rows["shear_kN"], strict=True)
        for slip, share in ((0.0, 0.0), (4.0, 1.0), (9.0, 0.7))
    ]
    curves = pd.DataFrame(points)
    good = evaluate_groups(rows, from_frame(curves, POINTS), specified_strength=450e6)
    assert good[0].result is not None
    half = from_frame(curves.assign(load_kN=0.5 * curves["load_kN"]), POINTS)
    (bad,) = evaluate_groups(rows, half, specified_strength=450e6)
    assert bad.result is None
    assert "the curve of s0 must reach the 101.3 kN of the table" in bad.refusal


def test_the_design_function_takes_the_specified_strength_up_to_500_mpa() -> None:
    rows = table(fcm_MPa=[80.0 + i for i in range(8)])  # the steel governs

    def nominal(specified: float | None) -> float:
        fit = fit_strength(rows, specified_strength=specified).d8.r_nominal
        assert fit is not None
        return fit

    area = np.pi * 19.0**2 / 4.0
    assert nominal(None) == pytest.approx(0.8 * 470.0 * area)
    assert nominal(450e6) == pytest.approx(0.8 * 450.0 * area)
    assert nominal(600e6) == pytest.approx(0.8 * 500.0 * area)


def test_the_population_of_load_slip_curves_is_not_trimmed() -> None:
    """The scatter of the logarithms is that of all curves: independent of any reweighting."""
    fit = fit_load_slip(shipped("stud-load-slip"), "ollgaard")
    population = fit.population["rate"]
    spread = np.hypot(population.sigma.value, population.tau.value)
    assert spread == pytest.approx(np.std(np.log(fit.rows["rate"]), ddof=1), rel=0.02)
