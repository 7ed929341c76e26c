"""Meta-tests: nothing registered may go untested or undocumented."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import pandas as pd
import pytest

from workbench.extras.intake.add import add_table
from workbench.extras.intake.impact_tests import impact_tests
from workbench.extras.intake.mapping import Mapping
from workbench.extras.laboratory.scenario import ImpactProblem
from workbench.extras.laboratory.schemes import SCHEMES
from workbench.models.base import Model, make_model, model_kind, model_names
from workbench.models.published import Published
from workbench.scenarios import (
    Column,
    ColumnImpact,
    ColumnPushover,
    MemberPulse,
    Pulse,
    Striker,
    StudTests,
    frame_scenario,
)
from workbench.steel.sections import rectangle
from workbench.testing import check_model

ROOT = Path(__file__).resolve().parents[1]
QUESTIONS = {
    "stud-load-slip": "load-slip",
    "stud-interaction": "interaction",
    "stud-residual": "residual-strength",
}

ELSEWHERE = ("remote", "opensees")  # held to it where their programs are, tests/extras/exchange
COARSE = {"smallest_element": 0.2, "largest_element": 0.4}  # the contract holds on any mesh
OPTIONS = {
    "fiber-corotational": {**COARSE, "refinement": -1},
    "fiber-space": {**COARSE, "refinement": -1},
    "fiber-reissner": COARSE,
    "fiber-shear": COARSE,
    "solid-plane-stress": {"refinement": -1},
    "shell": {"refinement": -1},
    "published": {"dataset": "heng2017-figure-5-9", "series": "4-DOF nonlinear yield surface"},
}
# external work by trapezoids over few, large load steps: second order in the step
# the refined hinge derives from no energy: N changes its moments, but bending does not shorten it
# the ledger of shells counts work over steps
LEDGER = {"solid-plane-stress": 2e-5, "refined-plastic-hinge": 5e-5, "shell": 1e-4}


def model_of(name: str) -> Model:
    """A registered model; references answer on one mesh, as repeating it is not asked here."""
    options = dict(OPTIONS.get(name, {}))
    if "levels" in {field.name for field in fields(model_kind(name))}:
        options["levels"] = 1
    return make_model(name, options)


@pytest.mark.thorough
@pytest.mark.usefixtures("few_load_steps")
@pytest.mark.parametrize("name", [name for name in model_names() if name not in ELSEWHERE])
def test_every_model_keeps_the_contract(
    name: str, thesis_impact, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = model_of(name)
    thesis_impact = replace(thesis_impact, duration=0.03)  # past the peak
    pulse = Pulse("triangular", 1e6, 0.01)
    if name == "solid-plane-stress":  # a bar of few plates
        bar = Column(rectangle(0.1, 0.05), 1.0, 1.0)
        thesis_impact = ColumnImpact("strike", bar, Striker(30.0, 10.0), 0.003)
        pulse = Pulse("triangular", 1e5, 0.01)
    scenarios = [
        thesis_impact.at_velocity(10.0),
        ColumnPushover("push", thesis_impact.column, 0.05),
        MemberPulse("pulse", thesis_impact.column, pulse, "uniform", 0.012),
    ]
    if name == "imported":  # an answer of which to answer
        monkeypatch.setenv("WORKBENCH_DATA", str(tmp_path / "own"))
        response = make_model("four-dof").simulate(scenarios[0])
        history = pd.DataFrame({"time_s": response.time, "displacement_m": response.displacement})
        history.to_csv(tmp_path / "theirs.csv", index=False)
        said = Mapping(title="theirs", source="a test", licence="MIT", role="verify")
        add_table(tmp_path / "theirs.csv", mapping=said, scenario=scenarios[0], kind="answers")
    if name == "measured":
        scenarios = [impact_tests("synthetic-impacts")[0].scenario, *scenarios]
    if name not in ("published", "measured", "imported"):
        pinned = replace(thesis_impact.column, base="pinned", axial_load=0.0)
        scenarios.append(replace(thesis_impact.at_velocity(5.0), column=pinned))
    studs = {"calibrate": ("provines2019",), "validate": ("lehigh279",)}
    question = QUESTIONS.get(name, "strength")
    scenarios.append(StudTests("studs", question, curves=("stud-load-slip",), **studs))
    if name == "column-of-frame":  # answers frames only
        scenarios.append(frame_scenario(thesis_impact.at_velocity(10.0)))
    scenarios.append(ImpactProblem("two masses", "two-masses"))
    answered = [s for s in scenarios if s.KIND in model.answers]
    check_model(model, answered, LEDGER.get(name, 1e-6))


def introduced(page: Path) -> str:
    """What a theory page is about: its first lines beside the summary, and its headings."""
    lines = page.read_text(encoding="utf-8").splitlines()
    lines = [line for line in lines if line and not line.startswith("|")]
    return "\n".join([*lines[:4], *(line for line in lines[4:] if line.startswith("#"))])


@pytest.mark.parametrize("name", model_names())
def test_every_model_has_a_theory_page(name: str) -> None:
    model = model_of(name)
    pages = (ROOT / "docs" / "theory").glob("*.md")
    assert any(f"`{name}`" in introduced(page) for page in pages), "write docs/theory/NAME.md"
    assert len(model.assumptions) >= 1


@pytest.mark.parametrize("name", [*model_names(), *SCHEMES])
def test_the_page_of_the_thesis_names_every_model_and_integrator(name: str) -> None:
    page = (ROOT / "docs" / "thesis.md").read_text(encoding="utf-8")
    assert f"`{name}`" in page, "give it a line in docs/thesis.md"


def test_published_series_are_all_readable() -> None:
    from workbench.base.catalogue import datasets, load

    seen = 0
    for entry in datasets():
        if not entry.scenario:
            continue
        for series in dict.fromkeys(load(entry.name)["series"]):
            assert Published(entry.name, series).sources == (entry.key,)
            seen += 1
    assert seen >= 5
