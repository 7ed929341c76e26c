"""Vogel's frames (1985), the calibration frames of second-order inelastic analysis.

A clamped portal, columns 1/400 out of plumb, and six storeys, 1/450; residual stress of rolled
sections. Ultimate load factors by plastic zones 1.022 and 1.11 (as quoted in textbooks); all frame
models are in the study `vogel_frames`.
"""

from __future__ import annotations

from math import hypot

import pytest

from workbench.extras.frame_models.fiber_frames import BoundingSurface, ModifiedTangentModulus
from workbench.extras.frame_models.hinged_frames import PlasticHinge, RefinedPlasticHinge
from workbench.models import frame_model
from workbench.models.frame_model import FrameModel
from workbench.models.references.fiber_beams import FiberReissner
from workbench.study import load_study

CASES = {case.name: case.scenario for case in load_study("vogel_frames").study.cases}
PORTAL, PLUMB, STOREYS = "portal", "portal, plumb", "six storeys"
PLASTIC_ZONES = {PORTAL: 1.022, PLUMB: 1.022, STOREYS: 1.11}


def over_plastic_zones(model: FrameModel, name: str) -> float:
    """Ultimate load factor of a frame, over that of plastic zones."""
    push = CASES[name]
    response = model.simulate(push)
    assert response.attrs["outcome"] == "ok", response.attrs["message"]
    resultant = hypot(sum(load.x for load in push.loads), sum(load.y for load in push.loads))
    return float(response["resistance"]) / resultant / PLASTIC_ZONES[name]


def fibers(smallest: float) -> FiberReissner:
    mesh = {"smallest_element": smallest, "largest_element": 0.25, "levels": 1}
    return FiberReissner(residual_stress="triangular", **mesh)


@pytest.mark.usefixtures("few_load_steps")
def test_fibers_are_plastic_zones() -> None:
    assert over_plastic_zones(fibers(0.02), PORTAL) == pytest.approx(1.0, abs=2e-3)


@pytest.mark.usefixtures("few_load_steps")
def test_refined_hinges_are_on_the_safe_side_and_sharp_ones_are_not() -> None:
    """The column curve stands for residual stress and crookedness: no tilt on top of it."""
    assert 0.93 < over_plastic_zones(RefinedPlasticHinge(), PLUMB) < 0.97  # measured 0.948
    assert over_plastic_zones(PlasticHinge(), PORTAL) > 1.02  # 1.029


@pytest.mark.thorough
@pytest.mark.usefixtures("few_load_steps")
def test_residual_stress_of_two_surfaces_and_of_the_tangent_modulus() -> None:
    """0.972, 1.027 and 1.028; a sharp hinge on the same surface 1.036."""
    stressed = over_plastic_zones(BoundingSurface(residual_stress="triangular"), PORTAL)
    smooth = over_plastic_zones(BoundingSurface(), PORTAL)
    softened = over_plastic_zones(ModifiedTangentModulus(), PORTAL)
    sharp = over_plastic_zones(PlasticHinge(surface="super-ellipse"), PORTAL)
    assert 0.96 < stressed < 0.985
    assert 1.02 < smooth < softened < sharp - 5e-3


@pytest.mark.thorough
def test_six_storeys(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beams fail, of which all know the strength; 15 load steps, the study has 1000."""
    monkeypatch.setattr(frame_model, "PUSH_STEPS", 15)
    assert over_plastic_zones(fibers(0.01), STOREYS) == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "ratio"), [(BoundingSurface(), 1.007), (ModifiedTangentModulus(), 1.010)]
)
def test_six_storeys_of_sections(
    model: FrameModel, ratio: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(frame_model, "PUSH_STEPS", 40)
    assert over_plastic_zones(model, STOREYS) == pytest.approx(ratio, abs=5e-3)
