"""Inputs that a test leaves open are propagated through every model and join the comparison."""

from __future__ import annotations

import csv
import json
import pickle
from dataclasses import replace
from math import hypot
from pathlib import Path

import pytest

from workbench.base.catalogue import dataset
from workbench.base.errors import InputError
from workbench.base.tables import plain_rows
from workbench.extras.intake.add import add_table
from workbench.extras.intake.impact_tests import impact_tests
from workbench.extras.intake.impact_tests.measured import Measured
from workbench.extras.intake.impact_tests.propagated import Propagated, over_inputs
from workbench.models.base import Model
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof
from workbench.models.references.fiber_beams import FiberReissner
from workbench.responses.uncertainty import INPUT_WIDTHS, WIDTHS, uncertainty_of
from workbench.study import Case, Study, run_study
from workbench.study.assessor import assess

OPEN = {
    "yield_stress_uncertainty_Pa": "15e6",
    "velocity_uncertainty_m_per_s": "0.1",
    "base_else": "clamped",
    "head_else": "guided",
}
PEAK, RESIDUAL = "peak_displacement", "residual_displacement"


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("WORKBENCH_DATA", raising=False)
    monkeypatch.chdir(tmp_path)


def added(number: int = 0, **changes: str) -> str:
    """A shipped synthetic row as a test of a laboratory, with changes of its cells."""
    text = dataset("synthetic-impacts").path.read_text(encoding="utf-8")
    row = list(csv.DictReader(text.splitlines()))[number]
    row |= {"campaign": "lab", "role": "validate", "source": "R", "specimen": "A", **changes}
    with Path("lab.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(row))
        writer.writeheader()
        writer.writerow(row)
    return add_table(Path("lab.csv"), despite_doubts=True).entry.name


def test_half_widths_are_changes_at_the_ends_of_each_input_added_as_squares() -> None:
    (test,) = impact_tests(added(**OPEN))
    assert list(test.open) == ["yield_stress_Pa", "velocity_m_per_s", "supports"]
    hit, model = test.scenario, FourDof()
    column = hit.column
    ends = [
        [replace(hit, column=column.stronger(factor)) for factor in (340 / 355, 370 / 355)],
        [hit.at_velocity(velocity) for velocity in (3.9, 4.1)],
        [replace(hit, column=replace(column, base="clamped", head="guided"))],
    ]
    (over,) = over_inputs({"4-DOF": model}).values()
    answer = over.simulate(hit)
    plain = model.simulate(hit)
    for quantity in (PEAK, RESIDUAL):
        value = float(plain[quantity])
        widest = [
            max(abs(float(model.simulate(end)[quantity]) - value) for end in both) for both in ends
        ]
        assert min(widest) > 0.0
        width = uncertainty_of(answer, quantity, INPUT_WIDTHS)
        assert width == pytest.approx(hypot(*widest), rel=1e-6)
        assert float(answer[quantity]) == value


def test_another_scenario_and_a_test_without_open_inputs_have_no_such_width() -> None:
    (test,) = impact_tests(added())
    (over,) = over_inputs({"energy": EnergyEstimate()}).values()
    for hit in (test.scenario, test.scenario.at_velocity(5.0)):
        assert INPUT_WIDTHS not in over.simulate(hit).attrs


def test_the_model_is_shown_as_it_is_and_follows_the_tables() -> None:
    before = Propagated("energy-estimate").data_digest
    (over,) = over_inputs({"energy": EnergyEstimate(resistance="panel")}).values()
    assert isinstance(over, Model)
    assert (over.name, json.loads(over.options)["resistance"]) == ("energy-estimate", "panel")
    assert pickle.loads(pickle.dumps(over)) == over
    added(**OPEN)
    assert over.data_digest != before


def _covered(row: dict[str, float]) -> dict[str, float]:
    return {name: row[name] for name in ("covered", "counted", "inputs")}


@pytest.mark.thorough
def test_the_comparison_joins_measured_input_and_numerical_half_widths() -> None:
    (test,) = impact_tests(added(**OPEN, peak_m="0.055", duration_s="0.04"))
    plain = {"beam": FiberReissner(0.1, 0.5, levels=2), "energy": EnergyEstimate()}

    def rows_of(models: dict[str, Model], folder: str) -> dict[str, dict[str, float]]:
        case = Case(test.name, test.scenario)
        study = Study("one", "One", "?", (case,), models, "tests", quantities=(PEAK,))
        run_study(study, Path(folder), jobs=0)
        result = assess(study, Path(folder))
        rows = {row["model"]: row for row in plain_rows(result.tables["validation"])}
        compared = result.records("comparisons", metric="relative_error", against="tests")
        return {row["model"]: {**row, **_covered(rows[row["model"]])} for row in compared}

    bares = rows_of({"tests": Measured(), **plain}, "bare")
    fulls = rows_of({"tests": Measured(), **over_inputs(plain)}, "full")
    for label in plain:
        bare, full = bares[label], fulls[label]
        answer = over_inputs(plain)[label].simulate(test.scenario)
        width = uncertainty_of(answer, PEAK, INPUT_WIDTHS)
        numerical = uncertainty_of(answer, PEAK) if WIDTHS in answer.attrs else 0.0
        own = hypot(numerical, width) / full["against_value"]
        share = full["value"] / full["against_value"]
        expected = hypot(own, share * 0.0028 / 0.055)
        assert full["uncertainty"] == pytest.approx(expected, rel=1e-3)
        assert full["error"] == bare["error"]
        assert bare["inputs"] == 0.0
        assert full["inputs"] == pytest.approx(width / full["value"] / 1.96, rel=1e-3)
        # the error lies outside what is measured and numerical, and inside with the open inputs
        assert bare["uncertainty"] < abs(bare["error"]) <= full["uncertainty"]
        assert (bare["covered"], full["covered"], full["counted"]) == (0, 1, 1)


def test_a_member_that_falls_at_an_end_leaves_the_width_unknown() -> None:
    """The column of the shipped rows, pressed so that the faster hit alone brings it down."""
    name = added(7, velocity_m_per_s="5", velocity_uncertainty_m_per_s="4.9", axial_load_N="6e5")
    (test,) = impact_tests(name)
    (over,) = over_inputs({"4-DOF": FourDof()}).values()
    answer = over.simulate(test.scenario)
    assert answer.attrs["outcome"] == "ok"
    assert json.loads(answer.attrs[INPUT_WIDTHS])[PEAK] is None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"yield_stress_uncertainty_Pa": "4e8"}, r"is no less than yield_stress_Pa, 3\.55e\+08"),
        ({"velocity_uncertainty_m_per_s": "4"}, "velocity_uncertainty_m_per_s.*half of a range"),
        ({"wall_uncertainty_m": "0.001"}, "is no less than wall_m, 0"),
        ({"mass_uncertainty_kg": "-1"}, "mass_uncertainty_kg"),
        ({"base_else": "pinned"}, "base_else.*is base itself; leave it empty"),
        ({"head_else": "welded"}, "head_else.*welded"),
    ],
)
def test_ranges_that_cannot_be_meant_are_refused(changes: dict[str, str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        added(**changes)
