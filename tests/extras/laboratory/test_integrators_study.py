"""Integrators as models, their study and its page, on problems of a few steps."""

from __future__ import annotations

import json
import tomllib

import numpy as np
import pytest
from pages import views

from workbench.base.errors import InputError
from workbench.extras.laboratory.impact_systems import PROBLEMS as STRUCTURES
from workbench.extras.laboratory.models import ImpactExact, ImpactIntegrator
from workbench.extras.laboratory.problems import PROBLEMS as BUILT
from workbench.extras.laboratory.scenario import PROBLEMS, ImpactProblem
from workbench.report.build import document
from workbench.report.gallery import draw_all
from workbench.responses import outcome_of
from workbench.scenarios import scenario_from, to_toml
from workbench.study import Case, Figure, Study, run_study
from workbench.study.assessor import Assessment, assess, read_assessment

LABELS = ("event-driven", "midpoint", "newmark")


@pytest.fixture(scope="module")
def stored(tmp_path_factory) -> Assessment:
    """Two problems by three schemes."""
    figures = (
        Figure("precision", "work-precision", "Work", "Errors."),
        Figure("time", "work-precision", "Time", "Errors.", options={"time": True}),
        Figure("records", "place", "Places", "Records."),
    )
    study = Study(
        name="small",
        title="Small",
        question="Which?",
        cases=tuple(Case(n, ImpactProblem(n, n)) for n in ("two-masses", "grazing")),
        models={"exact": ImpactExact(4)} | {n: ImpactIntegrator(n, 3) for n in LABELS},
        reference="exact",
        quantities=("relative_error",),
        figures=figures,
    )
    root = tmp_path_factory.mktemp("integrators")
    directory = run_study(study, root, jobs=0).directory
    assess(study, root)
    return read_assessment(directory, study)


def test_scenarios_name_the_problems_of_the_laboratory() -> None:
    assert (*BUILT, *STRUCTURES) == PROBLEMS
    scenario = ImpactProblem("mine", "ball")
    assert scenario_from(tomllib.loads(to_toml(scenario))) == scenario
    with pytest.raises(InputError, match=r"impact.problem = 'bal': must be one of ball, "):
        ImpactProblem("mine", "bal")
    with pytest.raises(InputError, match=r"option.scheme = 'euler': must be one of moreau-jean"):
        ImpactIntegrator("euler")


def test_a_ladder_is_stored_with_its_errors_and_cost(stored: Assessment) -> None:
    response = stored.response("two-masses", "midpoint")
    assert response is not None
    error = response["ladder.error"].values
    np.testing.assert_allclose(error[:-1] / error[1:], 2.0, rtol=1e-6)
    assert float(response["observed_order"]) == pytest.approx(1.0, abs=1e-6)
    assert response["ladder.evaluations"].values.tolist() == [80.0, 160.0, 320.0]
    assert stored.number("two-masses", "event-driven", "relative_error") < 1e-12
    assert "observed_order" not in stored.response("two-masses", "event-driven")
    assert stored.number("two-masses", "newmark", "relative_error") > 1.0
    assert "observed_order" not in stored.response("two-masses", "newmark")  # nothing converges


def test_an_exact_answer_states_its_uncertainty() -> None:
    exact = ImpactExact(2).simulate(ImpactProblem("x", "ball"))
    assert outcome_of(exact) == "ok"
    assert json.loads(exact.attrs["data_uncertainty"])["relative_error"] == 0.0


def test_the_page_says_which_scheme_for_which_problem(stored: Assessment) -> None:
    plates = draw_all(stored.study, stored)
    drawn = {plate.figure.key: plate.drawing for plate in plates}
    timed, counted = (drawn[key].data for key in ("time", "precision"))
    assert set(counted["label"]) == set(timed["label"]) == set(LABELS)
    rows = [n for n, label in enumerate(timed["label"]) if label == "midpoint"][:3]
    times, counts = timed["solving, ms"], counted["evaluations of the forces"]
    assert times[rows[-1]] / times[rows[0]] == pytest.approx(counts[rows[-1]] / counts[rows[0]])
    assert {"time", "place"} <= set(drawn["records"].data)
    page = document(stored.study, stored, [])
    section = next(part for part in page.sections if part.key == "answer")
    table = views(section, "table")[0]
    assert table.titles == ["scheme", "two-masses", "grazing"]
    rows = {row[0].text: row[1:] for row in table.rows}
    assert rows["newmark"][0].tone == "bad"
    assert rows["newmark"][1].tone == "good"
    assert rows["event-driven"][0].text == "≤\u202f240\nexact"
    assert rows["newmark"][0].text.startswith("never\n1.6 times")
    values = [text for view in views(section, "bullets") for text in view.items]
    assert any(text.startswith("two-masses: ") for text in values)
    reached = [text for text in values if text.startswith("An error of 1 % is reached on 2 of 2")]
    assert len(reached) == 1
    assert "newmark" not in reached[0].split(";")[0]
    lost = [text for text in values if text.startswith("More than 10 %")]
    assert lost == [
        "More than 10 % of the largest place off on two-masses: newmark, at worst by 1.6 times."
    ]


@pytest.mark.claim("model:impact-integrator", "order on a ball", "closed form", 1, 0.08)
@pytest.mark.thorough
def test_the_order_on_a_ball_is_that_of_many_starts(claim) -> None:
    """Of one start it depends on where in its step an impact falls: 0.66 for the midpoint."""
    given = ImpactProblem("ball", "ball")
    for scheme in ("moreau-midpoint", "ggl"):
        response = ImpactIntegrator(scheme).simulate(given)
        claim(response["observed_order"])
