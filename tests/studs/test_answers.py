"""Fits as models: the contract, what is judged by unseen tests, what is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from workbench.base.errors import InputError
from workbench.responses import Outcome, Response, outcome_of, warnings_of
from workbench.responses.uncertainty import sampled_interval
from workbench.scenarios import StudTests
from workbench.studs import TESTS, Grade, evaluate_groups
from workbench.studs.answers import (
    StudInteraction,
    StudLoadSlip,
    StudMeasured,
    StudMechanical,
    StudResidual,
    StudSeries,
    StudStrength,
)
from workbench.studs.fit_protocol import judge, plain
from workbench.studs.interaction import combined_tests
from workbench.studs.model import tables_of
from workbench.studs.schema import from_frame
from workbench.studs.tables import joined, split_table
from workbench.study.store import read_netcdf, to_netcdf_bytes
from workbench.testing import check_model

Maker = Callable[..., pd.DataFrame]
UNSEEN = StudTests("unseen", calibrate=("provines2019",), validate=("lehigh279",))
ALL = StudTests("all", calibrate=("provines2019", "lehigh279"))
CURVES = ("stud-load-slip",)


def asked(question: str, **changes: Any) -> StudTests:
    given = {"calibrate": ("provines2019",), "validate": ("lehigh279",), **changes}
    return StudTests(question, question, **given)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("model", "scenario"),
    [  # the default options are held to the contract with all registered models
        (StudStrength("aisc360", corrected=True), UNSEEN),
        (StudSeries(), ALL),
        (StudLoadSlip(published=True), asked("load-slip", tables=(), curves=CURVES)),
        (StudInteraction("mechanical"), asked("interaction")),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_every_model_of_studs_keeps_the_contract(model: Any, scenario: StudTests) -> None:
    check_model(model, [scenario])


def fit_of(response: Response) -> pd.Series:
    """The only row of the summary of a fit."""
    (row,) = (row for _, row in tables_of(response)["fit"].iterrows())
    return row


def judgement_of(response: Response) -> pd.Series:
    return tables_of(response)["judgement"].iloc[0]


def number(response: Response, name: str) -> float:
    return float(response[name])


def test_formulas_are_judged_by_what_they_have_not_seen() -> None:
    plain_, corrected = (StudStrength(corrected=c).simulate(UNSEEN) for c in (False, True))
    for response in (plain_, corrected):
        assert outcome_of(response) is Outcome.OK
        assert fit_of(response)["campaigns"] == "provines2019"
        assert judgement_of(response)["campaigns"] == "lehigh279"
    bias = fit_of(plain_)["bias"]
    ratio = number(plain_, "test_over_prediction") / number(corrected, "test_over_prediction")
    assert ratio == pytest.approx(bias)
    # calibrated on the campaign of strong shanks the formula is unsafe on the other one
    assert number(corrected, "least_test_over_prediction") < 0.8
    widths = json.loads(plain_.attrs["sampling_uncertainty"])
    assert set(widths) == {"test_over_prediction"}  # a single test has no interval
    low, high = sampled_interval(plain_, "test_over_prediction")
    assert 0.0 < low < number(plain_, "test_over_prediction") < high
    assert sampled_interval(plain_, "least_test_over_prediction") is None


@pytest.mark.thorough
def test_the_mechanical_model_is_judged_by_unseen_tests() -> None:
    response = StudMechanical().simulate(UNSEEN)
    # measured 0.0013
    assert number(response, "least_test_over_prediction") == pytest.approx(0.91, abs=2.6e-3)
    assert judgement_of(response)["worst"] == "lehigh279 P3"
    assert set(tables_of(response)["curves"]["specimen"]) == {"P3", "P8"}


def test_a_table_without_a_split_is_fitted_but_judges_nothing() -> None:
    response = StudStrength().simulate(ALL)
    assert number(response, "tests_fitted") == 26
    assert "test_over_prediction" not in response
    measured = StudMeasured().simulate(ALL)
    assert number(measured, "tests_fitted") == 26
    subjects = {finding.subject for finding in warnings_of(response)}
    assert {"shank", "campaigns", "measurement", "modulus"} <= subjects


def test_the_wrong_question_is_refused() -> None:
    for model, scenario in (
        (StudStrength(), asked("load-slip", tables=(), curves=CURVES)),
        (StudLoadSlip(), UNSEEN),
        (StudResidual(), UNSEEN),
        (StudInteraction(), UNSEEN),
    ):
        response = model.simulate(scenario)
        assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
        assert f"not {scenario.asked}" in response.attrs["message"]


def test_tests_refuse_what_they_do_not_hold() -> None:
    for question in ("interaction", "residual-strength", "residual-stiffness"):
        response = StudMeasured().simulate(asked(question))
        assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
        assert "in the validating campaigns (lehigh279)" in response.attrs["message"]


def test_names_and_tables_are_checked() -> None:
    with pytest.raises(InputError, match="did you mean lehigh279"):
        StudStrength().simulate(StudTests("x", validate=("lehigh27",)))
    with pytest.raises(InputError, match="must be a CSV file or stud-push-out"):
        StudStrength().simulate(StudTests("x", tables=("stud-load-slip",)))
    with pytest.raises(InputError, match="is known for the law ollgaard only"):
        StudLoadSlip("rational", published=True)


@pytest.mark.thorough
def test_load_slip_laws_are_judged_by_unseen_curves() -> None:
    given = asked("load-slip", tables=(), curves=CURVES, validate=("lehigh279", "mcgarraugh1971"))
    fitted = StudLoadSlip().simulate(given)
    assert judgement_of(fitted)["curves"] == 4
    assert 0.8 < number(fitted, "coverage") <= 1.0  # nominal 0.9, measured 0.97
    assert json.loads(fitted.attrs["sampling_uncertainty"])["coverage"] >= 0.25
    assert sampled_interval(fitted, "coverage")[1] == 1.0  # no band holds more than all
    published = StudLoadSlip(published=True).simulate(given)
    assert "coverage" not in published
    # measured 0.0021
    assert number(published, "stiffness_test_over_prediction") == pytest.approx(0.75, abs=4.3e-3)
    assert number(StudMeasured().simulate(given), "coverage") == 0.9


def test_tables_are_stored_with_their_types_and_units(tmp_path: Path) -> None:
    response = StudStrength("en1994").simulate(UNSEEN)
    (tmp_path / "cell.nc").write_bytes(to_netcdf_bytes(response))
    stored = read_netcdf(tmp_path / "cell.nc")
    assert stored["answer.judged.prediction"].attrs["units"] == "N"
    tables = tables_of(stored)
    for name, table in tables_of(response).items():
        pd.testing.assert_frame_equal(tables[name], table, check_dtype=False, check_like=True)
    assert tables["fit"]["tests"].dtype.kind == "i"


# -- a laboratory's own table, as a scenario ------------------------------------------------------


def written(table: pd.DataFrame, path: Path) -> str:
    table.to_csv(path, index=False)
    return str(path)


@pytest.mark.claim("model:stud-measured", "tests over themselves", "property", 1, 1e-12)
@pytest.mark.thorough
def test_tests_after_pre_damage_flip_the_path(damaged: Maker, tmp_path: Path, claim) -> None:
    """The same model and question: a prediction, then a fit that says what it rests on."""
    before = fit_of(StudResidual().simulate(asked("residual-strength")))
    assert before["grade"] == Grade.MECHANICAL
    assert not before["validated"]
    rows = damaged(6, kind="pull-out", measure="displacement ratio", origin="measured")
    file = written(rows.assign(use_for_fit=1), tmp_path / "lab.csv")
    given = StudTests(
        "mine", "residual-strength", ("stud-push-out", file),
        calibrate=("provines2019", *(f"lab {k}" for k in range(4))), validate=("lab 4", "lab 5"),
    )  # fmt: skip
    response = StudResidual().simulate(given)
    after = fit_of(response)
    assert set(tables_of(response)["scores"]["name"]) >= {"linear", "mechanical"}
    assert after["grade"] == Grade.CROSS_VALIDATED
    assert after["validated"]
    assert after["tests"] == 32
    assert number(response, "test_over_prediction") == pytest.approx(1.0, abs=0.09)  # measured 0.04
    claim(number(StudMeasured().simulate(given), "test_over_prediction"))
    synthetic = written(damaged(4, kind="fatigue"), tmp_path / "synthetic.csv")
    given = StudTests("s", "residual-strength", (synthetic,))
    assert fit_of(StudResidual().simulate(given))["grade"] == Grade.SYNTHETIC


def combined(campaigns: int = 2) -> pd.DataFrame:
    """Pull-outs, push-outs and tests of both on the 5/3 power."""
    rows: list[dict[str, Any]] = []
    for j in range(campaigns):
        common = {"campaign": f"lab {j}", "diameter_mm": 19}
        rows.append({**common, "specimen": "t", "test": "pull-out", "tension_kN": 60.0})
        rows.append({**common, "specimen": "v", "test": "push-out", "shear_kN": 100.0})
        for i, t in enumerate((0.3, 0.6, 0.8)):
            v = (1.0 - t ** (5.0 / 3.0)) ** 0.6
            rows.append({**common, "specimen": f"c{i}", "test": "combined",
                         "tension_kN": 60.0 * t, "shear_kN": 100.0 * v})  # fmt: skip
    return from_frame(pd.DataFrame(rows), TESTS)


@pytest.mark.claim("model:stud-interaction", "tests over their law", "closed form", 1, 1e-8)
def test_combined_tests_judge_the_interaction_laws(tmp_path: Path, claim) -> None:
    rows = combined_tests(combined())
    assert rows["tension"].tolist() == pytest.approx([0.3, 0.6, 0.8] * 2)
    assert rows["companions"].tolist() == [1] * 6
    table = combined()
    more = table[table["test"] == "push-out"].assign(specimen="w")
    scarcer = combined_tests(pd.concat([table, more, more.assign(specimen="x")]))
    assert scarcer["companions"].tolist() == [1] * 6  # three push-outs, one pull-out
    lonely = combined()
    assert combined_tests(lonely[lonely["test"] != "pull-out"]).empty
    file = written(combined(), tmp_path / "lab.csv")
    given = StudTests("mine", "interaction", (file,), validate=("lab 1",))
    power = StudInteraction("five-thirds").simulate(given)
    claim(number(power, "test_over_prediction"))
    linear = StudInteraction("linear").simulate(given)
    assert number(linear, "least_test_over_prediction") > 1.05
    assert number(StudMeasured().simulate(given), "test_over_prediction") == 1.0


# -- pieces ---------------------------------------------------------------------------------------


def test_tables_are_joined_without_doubles(push_outs: pd.DataFrame) -> None:
    with pytest.raises(InputError, match="stands in two tables"):
        joined([push_outs, push_outs])
    assert len(joined([push_outs, push_outs], unique=False)) == 74
    used, held = split_table(push_outs, validate=("lehigh279",))
    assert len(used) + len(held) == 37
    with pytest.raises(InputError, match="calibrates too"):
        split_table(push_outs, ("lehigh279",), ("lehigh279",))


def test_groups_of_equal_tests_are_evaluated_or_refused(push_outs: pd.DataFrame) -> None:
    groups = evaluate_groups(push_outs, specified_strength=450e6)
    assert sum(group.tests for group in groups) == 26
    assert all("three or more" in group.refusal for group in groups)
    rows = push_outs[push_outs["campaign"] == "provines2019"].iloc[:3].assign(stud_spacing="same")
    spread = rows.assign(shear_kN=[200.0, 205.0, 260.0])
    (group,) = evaluate_groups(spread, specified_strength=450e6)
    assert "must lie within 10 % of the mean; make three more tests" in group.refusal
    (group,) = evaluate_groups(rows.assign(shear_kN=[200.0, 205.0, 210.0]),
                               specified_strength=450e6)  # fmt: skip
    assert group.result is not None
    assert group.result.P_Rk == pytest.approx(180e3)


def test_one_test_per_campaign_is_no_crash() -> None:
    """Scatter within and between campaigns cannot be told apart: the interval is Student's."""
    generator = np.random.default_rng(2)
    ratio = np.exp(0.1 * generator.normal(size=6))
    frame = pd.DataFrame({"campaign": list("abcdef"), "specimen": "s"})
    result = judge(frame, ratio, np.ones(6))
    logs = np.log(ratio)
    half = 2.015048 * np.std(logs, ddof=1) / np.sqrt(6)  # t_5(0.95)
    assert (result.summary["low"], result.summary["high"]) == pytest.approx(
        (np.exp(logs.mean() - half), np.exp(logs.mean() + half)),
        rel=4.5e-8,  # measured 2.3e-8
    )
    single = judge(frame.iloc[:1], ratio[:1], np.ones(1))
    assert (single.summary["low"], single.scalars["test_over_prediction"].width) == (None, None)
    with pytest.raises(InputError, match="holds no test"):
        judge(frame.iloc[:0], ratio[:0], np.ones(0))


def test_results_become_plain() -> None:
    content = {"a": np.float64(np.nan), "b": np.arange(2), "c": (np.inf, Grade.SYNTHETIC),
               "d": pd.DataFrame({"x": [1.0]})}  # fmt: skip
    assert plain(content) == {"a": None, "b": [0, 1], "c": [None, str(Grade.SYNTHETIC)],
                              "d": [{"x": 1.0}]}  # fmt: skip
