"""Numerical uncertainty of references: closed ladders, failures, drift, the real beams."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

from workbench.base.errors import InputError, SolverError
from workbench.models.base import respond
from workbench.models.references.fiber_beams import FiberCorotational, FiberShear
from workbench.models.references.refine import CurvePoint, default_quantities, read, refined
from workbench.models.references.solid import SolidPlaneStress
from workbench.responses import Finding, Outcome, build_response, outcome_of, warnings_of
from workbench.responses.uncertainty import combined, directions_of, level_names, variants
from workbench.scenarios import ColumnPushover
from workbench.study import Case, Study
from workbench.study.assessment import METRICS
from workbench.study.comparisons import CaseAnswers, compare, ladder_row
from workbench.testing import check_model


@dataclass(frozen=True)
class Known:
    """A push whose work and force have errors of known order in mesh, steps and fibers."""

    refinement: int = 2
    step_refinement: int = 0
    layers: int = 10
    levels: int = 3
    hardening_ratio: float = 1e-6
    growth: float = 0.5
    steps: float = 0.0
    fails_at: int = -9
    warns_at: int = -9
    subject: str = "damping"
    least_size: float = 0.0

    name: ClassVar[str] = "known"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (ColumnPushover.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = ("None.",)
    sources: ClassVar[tuple[str, ...]] = ()

    def domain(self, scenario):
        return []

    def simulate(self, scenario):
        return respond(self, scenario, lambda given: refined(self, given, self._solve))

    def _solve(self, scenario):
        if self.refinement == self.fails_at:
            raise SolverError("step 3", 1.0, "all")
        growth = 0.5 if self.hardening_ratio > 1e-3 else self.growth
        error = 0.08 * growth**self.refinement + 0.2 / self.layers
        error += self.steps * 0.5 ** (self.refinement + self.step_refinement)
        final = scenario.displacement
        warns = self.refinement == self.warns_at
        response = build_response(
            {
                "displacement": [0.0, 0.5 * final, final],
                "force": [0.0, 50.0 * (1.0 + error), 100.0 * (1.0 + error)],
                "input_energy": 50.0 * (1.0 + error) + 1e3 * self.hardening_ratio,
            },
            steps=3,
            warnings=[Finding(self.subject, "it is coarse")] if warns else [],
        )
        response.attrs["smallest_element"] = max(0.5**self.refinement, self.least_size)
        return response


@dataclass(frozen=True)
class Plain:
    """A model of somebody else that can be refined but makes no runs of its own."""

    refinement: int = 2

    name: ClassVar[str] = "plain"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (ColumnPushover.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = ("None.",)
    sources: ClassVar[tuple[str, ...]] = ()

    def domain(self, scenario):
        return []

    def simulate(self, scenario):
        return respond(self, scenario, self._solve)

    def _solve(self, scenario):
        return build_response({"input_energy": 50.0 * (1.0 + 0.08 * 0.5**self.refinement)}, steps=1)


@pytest.fixture
def push(thesis_impact) -> ColumnPushover:
    return ColumnPushover("push", thesis_impact.column, 0.1)


def answer(response) -> tuple[dict, dict]:
    attributes = response.attrs
    return json.loads(attributes["numerical_uncertainty"]), json.loads(attributes["refinement"])


def refinement_warnings(response) -> list[str]:
    return [f.text for f in warnings_of(response) if f.subject == "refinement"]


def test_first_order_errors_give_widths_by_hand(push) -> None:
    widths, table = answer(response := Known().simulate(push))
    # mesh: 0.08/4 left, safety 1.25; fibers: 0.02 left of which 3/4 seen, times 1.25 * 4/3
    expected = 1.25 * 0.02 + 1.25 * 0.02
    assert widths["input_energy"] == pytest.approx(50.0 * expected)
    assert widths["force at 0.025 m"] == pytest.approx(25.0 * expected)
    assert widths["force at 0.1 m"] == pytest.approx(100.0 * expected)
    energy = table["quantities"]["input_energy"]
    assert energy["order"] == pytest.approx(1.0)
    assert energy["parts"]["fibers"] == pytest.approx(50.0 * 0.025)
    assert energy["parts"]["steps"] == 0.0
    assert table["levels"] == [0, 1, 2]
    assert table["statements"] == refinement_warnings(response) == []
    assert float(response["input_energy"]) == pytest.approx(50.0 * 1.04 + 1e-3)


def test_steps_count_alone_if_that_says_more(push) -> None:
    # errors of mesh and steps cancel in the joint sequence, down to a third
    widths, table = answer(Known(steps=-0.0534).simulate(push))
    parts = table["quantities"]["input_energy"]["parts"]
    # 0.0534/4 is left at the finest steps; two levels only: three times that
    assert parts["steps"] == pytest.approx(3.0 * 50.0 * 0.0534 / 4.0)
    assert parts["steps"] > 4.0 * parts["space and steps"]
    assert widths["input_energy"] == pytest.approx(parts["steps"] + parts["fibers"])


@pytest.mark.parametrize("levels", [2, 3, 4, 5])
def test_the_truth_lies_within_the_width(push, levels) -> None:
    model = Known(refinement=levels - 1, steps=0.03, hardening_ratio=0.0, levels=levels)
    response = model.simulate(push)
    widths, _ = answer(response)
    assert abs(float(response["input_energy"]) - 50.0) <= widths["input_energy"]
    assert len(response["run"]) == levels + 1


def test_one_mesh_alone_is_unknown_not_exact(push) -> None:
    response = Known(levels=1).simulate(push)
    widths, table = answer(response)
    assert set(widths.values()) == {None}
    assert "unknown" in table["statements"][0]
    assert warnings_of(response) == []
    assert "run" not in response.coords
    full = Known().simulate(push)
    assert full["force"].equals(response["force"])


def test_without_a_coarser_mesh_the_width_is_unknown(push) -> None:
    response = Known(fails_at=1).simulate(push)
    widths, table = answer(response)
    assert set(widths.values()) == {None}
    assert "not-converged" in table["statements"][0]
    (finding,) = refinement_warnings(response)
    assert "unknown" in finding
    assert "2 h: not-converged" in finding
    assert "run" not in response.coords


def test_a_failing_coarsest_level_leaves_two_with_a_larger_factor(push) -> None:
    response = Known(fails_at=0).simulate(push)
    widths, table = answer(response)
    # first order is assumed over two levels, three times what is left
    assert widths["input_energy"] == pytest.approx(50.0 * (3.0 * 0.02 + 1.25 * 0.02))
    assert "4 h: not-converged" in table["statements"][0]
    assert refinement_warnings(response) == []
    assert list(response["run"].values) == ["2 h", "2 h, more fibers", "2 h, half steps"]


def test_a_failing_finest_level_is_the_answer(push) -> None:
    response = Known(fails_at=2).simulate(push)
    assert outcome_of(response) is Outcome.NOT_CONVERGED
    assert "numerical_uncertainty" not in response.attrs


def test_a_level_that_doubts_itself_is_not_used(push) -> None:
    response = Known(warns_at=1).simulate(push)
    widths, _ = answer(response)
    assert set(widths.values()) == {None}
    assert [f.subject for f in warnings_of(response)] == ["refinement"]
    assert "2 h cannot be relied on, damping: it is coarse" in refinement_warnings(response)[0]
    table = answer(Known(warns_at=0).simulate(push))[1]
    assert "two levels only" in table["quantities"]["input_energy"]["note"]


def test_mesh_warnings_of_coarser_levels_do_not_leak(push) -> None:
    response = Known(warns_at=0, subject="mesh").simulate(push)
    assert warnings_of(response) == []
    assert None not in answer(response)[0].values()


def test_meshes_that_cannot_be_coarser_say_so(push) -> None:
    response = Known(least_size=0.75).simulate(push)
    assert set(answer(response)[0].values()) == {None}
    assert "no larger elements" in refinement_warnings(response)[0]


def test_a_drifting_sequence_is_stated(push) -> None:
    widths, _ = answer(response := Known(growth=1.3).simulate(push))
    spread = 50.0 * 0.08 * (1.3**2 - 1.0)
    assert widths["input_energy"] >= 3.0 * spread
    assert "does not converge" in refinement_warnings(response)[0]


def test_hardening_gives_a_drifting_sequence_a_limit(push) -> None:
    """Perfect plasticity has no length of its own; see the option hardening_ratio."""
    _, table = answer(Known(growth=1.3, hardening_ratio=0.01).simulate(push))
    energy = table["quantities"]["input_energy"]
    assert energy["converging"]
    assert energy["extrapolated"] == pytest.approx(50.0 * 1.02 + 10.0)


def test_combination() -> None:
    assert combined({"space and steps": 3.0, "steps": 1.0, "fibers": 0.5}) == 3.5
    assert combined({"space and steps": 1.0, "steps": 3.0, "fibers": 0.5}) == 3.5
    assert combined({"space": 1.0, "steps": 3.0}) == 4.0
    assert combined({"space and steps": 1.0, "fibers": None}) is None
    assert combined({}) is None
    assert level_names(3) == ("4 h", "2 h", "h")


def test_points_of_static_curves() -> None:
    curve = build_response(
        {"displacement": [0.0, 1.0, 0.5, -2.0, 3.0], "force": [0.0, 10.0, -5.0, -20.0, 30.0]},
        steps=5,
    )
    wanted = {str(at): CurvePoint("force", "displacement", at) for at in (0.5, -1.0, 2.0, 4.0)}
    # first crossings of a cyclic path; what is absent is unknown, not zero
    known = {"0.5": 5.0, "-1.0": -14.0, "2.0": 20.0}
    assert read(curve, {**wanted, "peak_displacement": None}) == pytest.approx(known)
    turning = SimpleNamespace(direction="-rotation", control="displacement")
    assert next(iter(default_quantities(turning, curve))) == "force at 0.75 rad"
    loaded = curve.assign(load_factor=("step", [0.0, 0.5, 1.0, 1.5, 2.0]))
    points = default_quantities(SimpleNamespace(direction="y", control="load"), loaded)
    assert list(points)[-1] == "displacement at load factor 2"
    assert read(loaded, points)["displacement at load factor 0.5"] == 1.0
    history = build_response(
        {"displacement": [0.0, 1.0], "peak_displacement": 1.0}, time=[0.0, 1.0]
    )
    assert default_quantities(turning, history) == {"peak_displacement": None}


def test_every_run_keeps_its_curve(push) -> None:
    response = Known().simulate(push)
    runs = dict(variants(response))
    assert list(runs) == ["2 h", "4 h", "4 h, more fibers", "4 h, half steps", "h"]
    for name, error in (("4 h", 0.10), ("2 h", 0.06), ("4 h, more fibers", 0.085)):
        assert runs[name]["force"].values[-1] == pytest.approx(100.0 * (1.0 + error))
    assert [d.name for d in directions_of(response)] == ["space and steps", "fibers", "steps"]


MODELS = {"plain": Known(growth=0.4, levels=1), "refined": Known()}


def answers(push, reference: str) -> CaseAnswers:
    case = Case("push", push)
    study = Study("s", "s", "s", (case,), MODELS, reference, quantities=("input_energy",))
    return CaseAnswers(study, case, tuple(MODELS), {n: m.simulate(push) for n, m in MODELS.items()})


def test_comparisons_use_the_width_of_a_refined_answer(push) -> None:
    metric = METRICS["relative_error"]
    result = compare(answers(push, "plain"), "refined", "plain", "input_energy", metric)
    assert result.uncertainty is None
    assert "no refinement ladder" in result.note
    known = answers(push, "refined")
    result = compare(known, "plain", "refined", "input_energy", metric)
    assert result.uncertainty is None  # one mesh alone is not exact
    assert "levels = 1" in result.note
    reduced = replace(known, responses={**known.responses, "plain": Plain().simulate(push)})
    result = compare(reduced, "plain", "refined", "input_energy", metric)
    width = json.loads(known.responses["refined"].attrs["numerical_uncertainty"])["input_energy"]
    expected = width * result.value / result.against_value**2
    assert result.uncertainty == pytest.approx(expected)
    assert "observed order 1.00" in result.note
    known.responses["refined"].attrs["numerical_uncertainty"] = json.dumps({"input_energy": None})
    assert compare(reduced, "plain", "refined", "input_energy", metric).uncertainty is None


def test_metrics_of_curves_use_the_curves_of_the_runs(push) -> None:
    known = answers(push, "refined")
    stiff = build_response(
        {"displacement": [0.0, push.displacement], "force": [0.0, 120.0]}, steps=2
    )
    held = replace(known, responses={**known.responses, "plain": stiff})
    result = compare(held, "plain", "refined", "force", METRICS["area_difference"])
    assert result.error == pytest.approx(120.0 / 104.0 - 1.0)
    # the same rule over the metric's value in each run: mesh, and fibers on the coarsest
    by_run = {e: 120.0 / (100.0 * (1.0 + e)) - 1.0 for e in (0.10, 0.06, 0.04, 0.085)}
    order = np.log2((by_run[0.06] - by_run[0.10]) / (by_run[0.04] - by_run[0.06]))
    expected = 1.25 * (by_run[0.04] - by_run[0.06]) / (2.0**order - 1.0)
    expected += 1.25 * 4.0 / 3.0 * (by_run[0.085] - by_run[0.10])
    assert result.uncertainty == pytest.approx(expected)
    alone = compare(known, "plain", "refined", "force", METRICS["area_difference"])
    assert alone.uncertainty is None


def test_the_ladder_table_is_filled_from_the_answer(push) -> None:
    known = answers(push, "refined")
    row = ladder_row(known, "input_energy")
    assert known.study.steps == ("4 h", "2 h", "h")
    assert [row[name] for name in known.study.steps] == pytest.approx([55.001, 53.001, 52.001])
    assert row["order"] == pytest.approx(1.0)
    assert row["uncertainty"] == pytest.approx(2.5)
    assert row["relative"] == pytest.approx(2.5 / 52.001)
    assert ladder_row(answers(push, "plain"), "input_energy") is None


@pytest.mark.thorough
def test_the_static_beam_covers_the_next_level(thesis_impact) -> None:
    column = replace(thesis_impact.column, length_below=2.0, length_above=2.0)
    push = ColumnPushover("push", column, 0.05)
    model = FiberShear(smallest_element=0.05, layers=8)
    response = model.simulate(push)
    widths, table = answer(response)
    finer = replace(model, refinement=1, levels=1).simulate(push)
    gap = abs(float(finer["input_energy"]) - float(response["input_energy"]))
    assert 0.05 * widths["input_energy"] < gap < widths["input_energy"]  # measured 0.36
    assert set(table["quantities"]["input_energy"]["parts"]) == {
        *("space and steps", "fibers", "steps"),
    }


@pytest.mark.thorough
def test_an_impact_keeps_its_numbers_and_the_contract(thesis_impact) -> None:
    impact = replace(thesis_impact.at_velocity(5.0), duration=0.03)
    model = FiberCorotational(refinement=0, layers=8)
    response = model.simulate(impact)
    alone = replace(model, levels=1).simulate(impact)
    for name in alone.data_vars:
        assert response[name].equals(alone[name])
    widths, _ = answer(response)
    # measured 0.11
    assert 0.0 < widths["peak_displacement"] < 0.2 * float(response["peak_displacement"])
    assert widths["input_energy"] == 0.0
    assert "mesh" not in [f.subject for f in warnings_of(response)]
    check_model(replace(model, refinement=-1, levels=2), [impact])


@pytest.mark.thorough
def test_the_solid_refines_space_alone(thesis_impact) -> None:
    push = ColumnPushover("push", thesis_impact.column, 0.02)
    response = SolidPlaneStress().simulate(push)
    widths, table = answer(response)
    parts = table["quantities"]["input_energy"]["parts"]
    assert set(parts) == {"space", "steps"}
    assert widths["input_energy"] == pytest.approx(parts["space"] + parts["steps"])
    assert table["levels"] == [-1, 0]


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        (FiberCorotational, {"levels": 0}),
        (FiberShear, {"levels": 7}),
        (FiberShear, {"refinement": -5}),
        (SolidPlaneStress, {"levels": 3}),
    ],
)
def test_levels_out_of_range_are_refused(kind, options) -> None:
    with pytest.raises(InputError, match="levels"):
        kind(**options)
