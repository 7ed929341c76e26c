"""Measured impacts answer the scenarios that were tested, and synthetic ones say that they are."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import pytest

from workbench.base.catalogue import dataset
from workbench.base.errors import InputError
from workbench.extras.intake.add import add_table
from workbench.extras.intake.impact_tests import impact_tests
from workbench.extras.intake.impact_tests.measured import Measured
from workbench.responses import Outcome, collapse_of, findings_of, outcome_of


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("WORKBENCH_DATA", raising=False)
    monkeypatch.chdir(tmp_path)


def added(*changes: dict[str, str]) -> str:
    """The first shipped synthetic row as tests of a laboratory, one with each of the changes."""
    text = dataset("synthetic-impacts").path.read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    base = {**rows[0], "campaign": "lab", "role": "validate", "source": "R", "specimen": "A"}
    base["collapse"] = "none"
    with Path("lab.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(base))
        writer.writeheader()
        writer.writerows({**base, **change} for change in changes)
    return add_table(Path("lab.csv"), despite_doubts=True).entry.name


@pytest.mark.claim("model:measured", "peak of a row of the table, m", "property", 0.0467, 1e-12)
def test_shipped_rows_answer_their_scenario_and_say_that_they_are_made(claim) -> None:
    test = impact_tests("synthetic-impacts")[0]
    assert (test.name, test.synthetic) == ("SYNTHETIC beams B1", True)
    response = Measured().simulate(replace(test.scenario, duration=0.1, name="other"))
    claim(response["peak_displacement"])
    widths = json.loads(response.attrs["data_uncertainty"])
    assert widths == {"peak_displacement": 0.0028, "residual_displacement": 0.0034}
    assert json.loads(response.attrs["data"])["datasets"][0]["role"] == "synthetic"
    (finding,) = findings_of(response)
    assert finding.text.startswith("SYNTHETIC: made numbers, no test")
    assert not finding.outside
    refused = Measured().simulate(test.scenario.at_velocity(4.1))
    assert outcome_of(refused) is Outcome.OUT_OF_DOMAIN
    assert "workbench data add" in findings_of(refused)[0].remedy


def test_tests_of_a_laboratory_stand_before_synthetic_rows() -> None:
    before = Measured().data_digest
    name = added({"peak_m": "0.05"})
    scenario = impact_tests(name)[0].scenario
    assert Measured().data_digest != before
    response = Measured().simulate(scenario)
    assert float(response["peak_displacement"]) == 0.05
    assert findings_of(response) == []
    assert float(Measured("synthetic-impacts").simulate(scenario)["peak_displacement"]) == 0.0467


def test_equal_tests_are_one_answer_that_holds_them_all() -> None:
    name = added({"peak_m": "0.04"}, {"specimen": "B", "peak_m": "0.05", "residual_m": ""})
    (test,) = impact_tests(name)
    assert test.name == "lab A and 1 equal"
    assert test.measured["peak_displacement"] == pytest.approx((0.045, 0.005))
    assert test.measured["residual_displacement"] == (0.0342, 0.0034)


def test_a_member_that_did_not_survive_is_an_answer() -> None:
    fallen = {"collapse": "buckling", "residual_m": "", "residual_uncertainty_m": ""}
    name = added(fallen, {"specimen": "B", "velocity_m_per_s": "4.5"})
    test, other = impact_tests(name)
    response = Measured(name).simulate(test.scenario)
    collapse = collapse_of(response)
    assert (collapse.mechanism, collapse.displacement) == ("buckling", 0.0467)
    assert "the member did not survive the test" in response.attrs["message"]
    assert outcome_of(Measured(name).simulate(other.scenario)) is Outcome.OK
    with pytest.raises(InputError, match=r"residual_m = 0\.0342: is no result of a collapse"):
        added({"collapse": "buckling"})
    with pytest.raises(InputError, match=r"peak_m.*the displacement reached in the collapse"):
        added({**fallen, "peak_m": ""})


def test_equal_tests_that_ended_differently_are_refused() -> None:
    fallen = {"collapse": "squash", "residual_m": "", "residual_uncertainty_m": ""}
    name = added({}, {**fallen, "specimen": "B"})
    (test,) = impact_tests(name)
    refused = Measured(name).simulate(test.scenario)
    assert outcome_of(refused) is Outcome.OUT_OF_DOMAIN
    assert "ended differently: 1 of 2 collapsed" in refused.attrs["message"]


def test_simulate_says_that_a_number_is_made(capsys: pytest.CaptureFixture[str]) -> None:
    from workbench.cli import run
    from workbench.scenarios import to_toml

    text = to_toml(impact_tests("synthetic-impacts")[0].scenario)
    Path("hit.toml").write_text(text, encoding="utf-8")
    assert run(["simulate", "hit.toml", "--model", "measured"]) == 0
    output = " ".join(capsys.readouterr().out.split())
    assert "warning (synthetic): SYNTHETIC: made numbers, no test" in output
    assert "46.7" in output


def test_only_tables_of_impacts_can_be_asked() -> None:
    with pytest.raises(InputError, match="holds no impact tests; there are synthetic-impacts"):
        Measured("stud-push-out")
    with pytest.raises(InputError, match="did you mean synthetic-impacts"):
        Measured("synthetic-impact")
