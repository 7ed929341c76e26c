"""Force-based elements against fine displacement-based ones, and hinges of fibers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_hinged_frames import MP, cantilever

from workbench.extras.frame_models.fiber_frames import FiberHinge, ForceBasedBeam
from workbench.extras.frame_models.hinged_frames import PlasticHinge
from workbench.models.references.fiber_beams import FiberCorotational
from workbench.responses import Outcome, outcome_of
from workbench.scenarios import FrameImpact, FrameStriker, Load, regular_frame
from workbench.steel.sections import find

pytestmark = pytest.mark.usefixtures("few_load_steps")
FINE = {"smallest_element": 0.05, "largest_element": 0.2, "levels": 1, "refinement": 0}


def test_one_element_reaches_the_fine_mesh_where_steel_hardens() -> None:
    scenario = cantilever(4.0, 0.0, 0.3)
    fine = FiberCorotational(hardening_ratio=0.02, **FINE).simulate(scenario)
    model = ForceBasedBeam(hardening_ratio=0.02, points=8)
    response = np.interp([0.03, 0.1, 0.3], *_curve(model.simulate(scenario)))
    assert response == pytest.approx(np.interp([0.03, 0.1, 0.3], *_curve(fine)), rel=0.01)


@pytest.mark.claim("model:force-based-beam model:fiber-hinge", "F L / M_p", "closed form", 1, 2e-3)
def test_perfectly_plastic_resistance_is_that_of_the_section(claim) -> None:
    scenario = cantilever(4.0, 0.0, 0.2)
    for model in (ForceBasedBeam(geometry="linear"), FiberHinge(geometry="linear")):
        response = model.simulate(scenario)
        claim(response["resistance"] / (MP / 4.0))
        # rotation of the plastic hinge: that of the chord less the elastic one
        elastic = MP / 4.0 * 0.2 / float(response["force"][10]) * 10.0 / 200.0
        expected = (0.2 - elastic) / 4.0
        assert float(response["largest_plastic_rotation"]) == pytest.approx(expected, rel=0.02)


def test_cycles_dissipate_as_on_a_fine_mesh() -> None:
    scenario = replace(cantilever(4.0, 0.0, 0.2), path=(0.2, -0.2, 0.2))
    fine = float(FiberCorotational(**FINE).simulate(scenario)["dissipated"][-1])
    for model in (ForceBasedBeam(), FiberHinge()):
        response = model.simulate(scenario)
        assert float(response["dissipated"][-1]) == pytest.approx(fine, rel=0.03)
        assert np.abs(response["balance_error"].values).max() < 1e-4 * fine


def test_displacement_based_elements_with_lobatto_points_overestimate_as_told() -> None:
    """Their end moment is a mean over the points: resistance Mp / (L - 0.32 h), order 1 in h."""
    for size in (1.0, 0.5):
        mesh = {"smallest_element": size, "largest_element": size, "levels": 1, "refinement": 0}
        model = FiberCorotational(element="lobatto", **mesh)
        response = model.simulate(cantilever(4.0, 0.0, 0.2))
        expected = MP / (4.0 - model.sampled * size)
        assert float(response["resistance"]) == pytest.approx(expected, rel=0.01)


@pytest.mark.thorough
def test_fibers_that_switch_at_one_strain_do_not_end_a_run() -> None:
    """A laden portal falls sideways, as fiber-reissner and plastic-hinge say; steps stalled."""
    portal = regular_frame((4.59,), (4.72,), find("HEB 300"), find("IPE 240"))
    loads = tuple(Load(name, y=-1920334.8656668947) for name in ("A1", "B1"))
    frame = replace(portal, loads=loads).split("B0-B1", 3.266, "hit")
    hit = FrameImpact("falls", frame, FrameStriker(7591.3, 5.32, node="hit"), 0.1519)
    for model in (FiberHinge(), PlasticHinge()):
        assert outcome_of(model.simulate(hit)) is Outcome.COLLAPSE


def _curve(response) -> tuple[np.ndarray, np.ndarray]:
    return response["displacement"].values, response["force"].values
