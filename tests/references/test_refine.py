"""Numerical uncertainty of references: closed ladders, failures, drift, the real beam."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import ClassVar

import pytest

from workbench.assessment import METRICS
from workbench.errors import InputError, SolverError
from workbench.models.base import Model, respond
from workbench.references.fiber_reissner import FiberReissner
from workbench.references.refine import combined, read, refine
from workbench.references.refined import Refined
from workbench.responses import Outcome, build_response, outcome_of, warnings_of
from workbench.scenarios import ColumnPushover
from workbench.study import Case, Study
from workbench.study.comparisons import Answers, compare


@dataclass(frozen=True)
class Known:
    """A push whose work and force have an error of known order in mesh and fibers."""

    refinement: int = 0
    layers: int = 10
    hardening_ratio: float = 1e-6
    growth: float = 0.5
    fails_at: int = -1

    name: ClassVar[str] = "known"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (ColumnPushover.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = ("None.",)
    sources: ClassVar[tuple[str, ...]] = ()

    def domain(self, scenario):
        return []

    def simulate(self, scenario):
        return respond(self, scenario, self._solve)

    def _solve(self, scenario):
        if self.refinement == self.fails_at:
            raise SolverError("step 3", 1.0, "all")
        growth = 0.5 if self.hardening_ratio > 1e-3 else self.growth
        error = 0.08 * growth**self.refinement + 0.2 / self.layers
        final = scenario.displacement
        return build_response(
            {
                "displacement": [0.0, final],
                "force": [0.0, 100.0 * (1.0 + error)],
                "input_energy": 50.0 * (1.0 + error) + 1e3 * self.hardening_ratio,
            },
            steps=2,
        )


@pytest.fixture
def push(thesis_impact) -> ColumnPushover:
    return ColumnPushover("push", thesis_impact.column, 0.1)


def answer(response) -> tuple[dict, dict]:
    attributes = response.attrs
    return json.loads(attributes["numerical_uncertainty"]), json.loads(attributes["refinement"])


def test_first_order_errors_give_widths_by_hand(push) -> None:
    response = refine(Known(), push, ("input_energy", "force at 0.1 m"))
    widths, table = answer(response)
    # mesh: 0.08/4 left, safety 1.25; fibers stay coarse: their error 0.02 and 1.25 * 0.005
    expected = 1.25 * 0.02 + 0.02 + 1.25 * 0.005
    assert widths["force at 0.1 m"] == pytest.approx(100.0 * expected)
    assert widths["input_energy"] == pytest.approx(50.0 * expected)
    assert table["directions"]["input_energy"]["space and time"]["found"]["order"] == (
        pytest.approx(1.0)
    )
    assert table["levels"] == [0, 1, 2]
    assert table["statements"] == []
    assert float(response["input_energy"]) == pytest.approx(50.0 * 1.04 + 1e-3)


def test_the_truth_lies_within_the_width(push) -> None:
    for levels in (2, 3, 4, 5):
        response = refine(Known(hardening_ratio=0.0), push, ("input_energy",), levels)
        widths, _ = answer(response)
        assert abs(float(response["input_energy"]) - 50.0) <= widths["input_energy"]


def test_hardening_sensitivity_is_reported(push) -> None:
    _, table = answer(refine(Known(), push, ("input_energy",)))
    assert table["hardening times 10"]["input_energy"] == pytest.approx(9e-3 / 55.001, rel=1e-6)


def test_a_drifting_sequence_is_stated_and_regularised(push) -> None:
    widths, table = answer(response := refine(Known(growth=1.3), push, ("input_energy",)))
    spread = 50.0 * 0.08 * (1.3**2 - 1.0)
    assert widths["input_energy"] >= 3.0 * spread
    regular = table["regularised"]["input_energy"]["found"]
    assert regular["converging"]
    assert regular["extrapolated"] == pytest.approx(50.0 * 1.02 + 10.0)
    assert "does not converge" in table["statements"][0]
    texts = [f.text for f in warnings_of(response) if f.subject == "refinement"]
    assert any("hardening_ratio" in text for text in texts)


@pytest.mark.parametrize("level", [0, 1])
def test_a_failing_level_leaves_the_width_unknown(push, level) -> None:
    widths, table = answer(refine(Known(fails_at=level), push, ("input_energy",)))
    assert widths == {"input_energy": None}
    assert any("not-converged" in text for text in table["statements"])


def test_a_failing_finest_level_is_the_answer(push) -> None:
    response = refine(Known(fails_at=2), push)
    assert outcome_of(response) is Outcome.NOT_CONVERGED
    assert "numerical_uncertainty" not in response.attrs


def test_an_absent_quantity_is_unknown_not_zero(push) -> None:
    widths, _ = answer(refine(Known(), push, ("peak_displacement", "force at 0.3 m")))
    assert widths == {"peak_displacement": None, "force at 0.3 m": None}


def test_combination() -> None:
    assert combined({"space and time": 3.0, "time": 1.0, "fibers": 0.5}) == 3.5
    assert combined({"space and time": 1.0, "time": 3.0, "fibers": 0.5}) == 3.5
    assert combined({"space and time": 1.0, "fibers": None}) is None


@pytest.mark.parametrize("quantity", ["colour", "force at noon", "force"])
def test_unknown_quantities_are_refused(push, quantity) -> None:
    with pytest.raises(InputError, match="quantities"):
        refine(Known(), push, (quantity,))


def test_too_few_levels_and_unrefinable_models_are_refused(push) -> None:
    with pytest.raises(InputError, match="levels"):
        refine(Known(), push, levels=1)
    with pytest.raises(InputError, match="option"):
        Refined("fiber-shear", (("colour", 1),))


def test_forces_between_steps(push) -> None:
    response = Known().simulate(push)
    end = float(response["force"][-1])
    assert read(response, ["force at 0.025 m"])["force at 0.025 m"] == pytest.approx(0.25 * end)


def test_the_static_beam_is_first_order_and_covers_the_next_level(thesis_impact) -> None:
    column = replace(thesis_impact.column, length_below=2.0, length_above=2.0)
    push = ColumnPushover("push", column, 0.1)
    coarse = FiberReissner(smallest_element=0.1, layers=8)
    response = refine(coarse, push, ("input_energy",))
    widths, table = answer(response)
    joint = table["directions"]["input_energy"]["space and time"]["found"]
    assert joint["order"] == pytest.approx(1.0, abs=0.2)
    finer = replace(coarse, refinement=3).simulate(push)
    gap = abs(float(finer["input_energy"]) - float(response["input_energy"]))
    assert 0.2 * widths["input_energy"] < gap < widths["input_energy"]
    assert set(table["directions"]["input_energy"]) == {"space and time", "fibers"}


def test_an_impact_refines_time_and_fibers_alone(thesis_impact) -> None:
    impact = replace(thesis_impact.at_velocity(5.0), duration=0.02)
    refined = Refined(
        "fiber-reissner", (("smallest_element", 0.2), ("layers", 8), ("largest_element", 0.4)), 2
    )
    assert isinstance(refined, Model)
    widths, table = answer(refined.simulate(impact))
    directions = table["directions"]["peak_displacement"]
    assert set(directions) == {"space and time", "time", "fibers"}
    times = directions["time"]["values"]
    assert times[0] == pytest.approx(directions["space and time"]["values"][0], rel=0.01)
    assert abs(times[1] / times[0] - 1.0) < 0.02
    assert widths["peak_displacement"] > 0.0


def test_comparisons_use_the_width_of_a_refined_answer(push) -> None:
    models = {"plain": Known(growth=0.4), "refined": Known()}
    study = Study(
        "s", "s", "s", (Case("push", push),), models, "plain", quantities=("input_energy",)
    )
    responses = {"plain": models["plain"].simulate(push), "refined": refine(Known(), push)}
    answers = Answers(study, study.cases[0], ("plain", "refined"), responses)
    metric = METRICS["relative_error"]
    assert compare(answers, "refined", "plain", "input_energy", metric).uncertainty is None
    against_itself = replace(study, reference="refined")
    answers = Answers(against_itself, study.cases[0], ("plain", "refined"), responses)
    found = compare(answers, "plain", "refined", "input_energy", metric)
    width = json.loads(responses["refined"].attrs["numerical_uncertainty"])["input_energy"]
    expected = width * found.model_value / found.against_value**2
    assert found.uncertainty == pytest.approx(expected)
    responses["refined"].attrs["numerical_uncertainty"] = json.dumps({"input_energy": None})
    found = compare(answers, "plain", "refined", "input_energy", metric)
    assert found.uncertainty is None
    assert "could not establish" in found.note
