"""Inputs that a scenario sets: each model uses them, or says that it does not."""

from __future__ import annotations

from dataclasses import replace

import pytest

from workbench.evidence.advice import advised, doubts
from workbench.registry import make_model
from workbench.responses import findings_of
from workbench.scenarios import frame_scenario
from workbench.scenarios.codec import set_inputs


def unused(response) -> list[str]:
    return [f.text for f in findings_of(response) if f.subject == "unused-input"]


def test_inputs_that_are_set_are_known_by_their_paths(thesis_impact) -> None:
    frame = frame_scenario(thesis_impact)
    first, *others = frame.frame.nodes
    nodes = (replace(first, rotary_inertia=3.0), *others)
    frame = replace(frame, frame=replace(frame.frame, nodes=nodes))
    inputs = set_inputs(frame)
    assert str(inputs["node.rotary_inertia"]) == "node.base.rotary_inertia = 3 kg m2"
    assert "node.mass" not in inputs
    assert "node.x" not in inputs  # it has no default
    assert "steel.yield_stress" not in inputs or frame.frame.steel.yield_stress != 355e6


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("name", ["energy-estimate", "hand-estimate"])
def test_energies_say_that_they_do_not_know_a_restitution(
    thesis_impact, name: str, restitution: float
) -> None:
    striker = replace(thesis_impact.striker, restitution=restitution, velocity=5.0)
    scenario = replace(thesis_impact, striker=striker)
    texts = unused(make_model(name).simulate(scenario))
    says = any("striker.restitution = 0.5 is not used" in text for text in texts)
    assert says == (restitution == 0.5)


def test_a_model_that_uses_the_input_is_named(thesis_impact) -> None:
    column = replace(thesis_impact.column, head_mass=500.0)
    scenario = replace(thesis_impact.at_velocity(5.0), column=column)
    model = make_model("single-dof")
    response = advised(model, scenario, model.simulate(scenario))
    (finding,) = [f for f in findings_of(response) if f.subject == "unused-input"]
    assert finding.text.startswith("column.head_mass = 500 kg is not used by this model")
    assert finding.remedy == "take flexible-superelement"
    assert any("column.head_mass" in doubt for doubt in doubts("single-dof", scenario))
