"""Frames of sections known by N and M: sharp limit, fibers, cycles, impact, column curve."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt, tan

import numpy as np
import pytest
from test_hinged_frames import EI, MP, NP, cantilever, guided

from workbench.base.errors import InputError
from workbench.extras.frame_models.fiber_frames import BoundingSurface, ModifiedTangentModulus
from workbench.extras.frame_models.hinged_frames import PlasticHinge
from workbench.models.references.fiber_beams import FiberCorotational
from workbench.responses import findings_of
from workbench.scenarios import FrameImpact, FrameStriker, Load, regular_frame
from workbench.steel.sections import find, square
from workbench.study import load_study

pytestmark = pytest.mark.usefixtures("few_load_steps")
FINE = {"smallest_element": 0.03, "largest_element": 0.1, "levels": 1, "refinement": 0}


@pytest.mark.thorough
def test_bounding_surface_goes_to_the_sharp_hinge() -> None:
    """Force at every drift of a cantilever with 0.3 N_p: off by 1.6, 1.2, 0.12 %, then nothing."""
    scenario = cantilever(4.0, 0.3 * NP, 0.2)
    plain = {"geometry": "linear", "elements": 1}
    sharp = PlasticHinge(surface="super-ellipse", **plain).simulate(scenario)["force"].values
    for model, most in (
        (BoundingSurface(inner=0.9, **plain), 0.018),
        (BoundingSurface(inner=0.99, **plain), 0.013),
        (BoundingSurface(inner=0.999, **plain), 0.002),
        (BoundingSurface(inner=1.0, **plain), 5e-4),
        (ModifiedTangentModulus(**plain), 1e-3),
    ):
        force = model.simulate(scenario)["force"].values
        assert np.abs(force - sharp).max() < most * sharp.max(), model


@pytest.mark.claim("model:bounding-surface", "force off fibers", "independent code", 0, 0.02)
def test_bounding_surface_spreads_as_fibers_do(claim) -> None:
    scenario = guided(0.06)
    fine = FiberCorotational(shear_flexible=False, **FINE).simulate(scenario)["force"].values
    plain = {"geometry": "linear", "shear_flexible": False, "elements": 4}
    smooth = BoundingSurface(**plain).simulate(scenario)["force"].values
    sharp = PlasticHinge(**plain).simulate(scenario)["force"].values
    assert np.abs(sharp[1:] / fine[1:] - 1.0).max() > 0.04
    claim(np.abs(smooth[1:] / fine[1:] - 1.0).max())


@pytest.mark.thorough
def test_cycles_dissipate_as_fibers_do_and_never_give_back() -> None:
    for axial, most in ((0.0, 0.03), (0.3 * NP, 0.04)):
        scenario = replace(cantilever(4.0, axial, 0.1), path=(0.1, -0.1, 0.1))
        fine = float(FiberCorotational(**FINE).simulate(scenario)["dissipated"][-1])
        for model in (BoundingSurface(), ModifiedTangentModulus()):
            response = model.simulate(scenario)
            spent = response["dissipated"].values
            assert spent[-1] == pytest.approx(fine, rel=most)
            assert np.diff(spent).min() > -1e-9 * fine
            assert np.abs(response["balance_error"].values).max() < 3e-4 * fine


@pytest.mark.thorough
def test_energy_of_a_hit_is_accounted_for() -> None:
    portal = regular_frame((5.0,), (4.0,), find("HEB 220"), find("IPE 300"))
    loads = tuple(Load(name, y=-6e5) for name in ("A1", "B1"))
    frame = replace(portal, loads=loads).split("A0-A1", 2.0, "hit")
    hit = FrameImpact("hit", frame, FrameStriker(1500.0, 10.0, node="hit"), 0.1)
    for model in (BoundingSurface(residual_stress="triangular"), ModifiedTangentModulus()):
        response = model.simulate(hit)
        assert response.attrs["outcome"] == "ok"
        assert np.abs(response["balance_error"].values).max() < 1e-4 * hit.input_energy
        assert np.diff(response["dissipated"].values).min() > -1e-9 * hit.input_energy


@pytest.mark.claim("model:modified-tangent-modulus", "stiffness at {p} N_p", "ziemian2002", 1, 0.01)
@pytest.mark.thorough
@pytest.mark.parametrize("p", [0.4, 0.6, 0.75])
def test_stiffness_of_a_column_is_that_of_its_tangent_modulus(p: float, claim) -> None:
    """EI times (1 + 2 p)(1 - p); at (1 + 2 p)(1 - p) / p = lambda^2 it vanishes."""
    share = min(1.0, (1.0 + 2.0 * p) * (1.0 - p))
    height = 0.8 * sqrt(share * EI / (p * NP)) * np.pi / 2.0  # 0.64 of the critical load
    u = 0.8 * np.pi / 2.0
    exact = share * EI / height**3 * u**3 / (tan(u) - u)
    scenario = cantilever(height, p * NP, 1e-4 * height)
    model = ModifiedTangentModulus(shear_flexible=False, elements=24)
    response = model.simulate(scenario)
    claim(response["force"][-1] / (1e-4 * height * exact))


def test_residual_stress_lowers_a_column_and_is_refused_elsewhere() -> None:
    scenario = cantilever(4.0, 0.4 * NP, 0.1)
    plain, stressed = (
        float(BoundingSurface(residual_stress=pattern).simulate(scenario)["resistance"])
        for pattern in ("none", "triangular")
    )
    assert 0.7 * plain < stressed < 0.9 * plain
    frame = scenario.frame
    leg = replace(frame.members[0], section=square(0.2))
    other = replace(scenario, frame=replace(frame, members=(leg,)))
    refused = BoundingSurface(residual_stress="parabolic").simulate(other)
    assert refused.attrs["outcome"] == "out-of-domain"
    assert any(f.subject == "residual-stress" for f in findings_of(refused))
    for model, options in (
        (BoundingSurface, {"inner": 0.4}),
        (ModifiedTangentModulus, {"minor_weight": 2.0}),
    ):
        with pytest.raises(InputError, match="must be"):
            model(**options)


def test_moment_about_the_minor_axis_softens() -> None:
    scenario = cantilever(4.0, 0.2 * NP, 0.03)
    major, minor = (
        ModifiedTangentModulus(minor_weight=weight).simulate(scenario)["force"].values
        for weight in (0.0, 0.65)
    )
    assert np.all(minor[1:] <= major[1:] * (1.0 + 1e-9))
    assert minor[-1] < 0.975 * major[-1]
    assert float(major.max()) < MP / 4.0


@pytest.mark.slow
def test_no_answer_on_drawn_frames_is_far_off_in_silence() -> None:
    """Peaks more than 10 % off the web-yielding frame come with a warning, on 60 drawn frames."""
    drawn = load_study("drawn_frames").study
    for case in drawn.cases[:60]:
        reference = drawn.models[drawn.reference].simulate(case.scenario)
        if reference.attrs["outcome"] != "ok":
            continue
        for model in (BoundingSurface(), ModifiedTangentModulus()):
            response = model.simulate(case.scenario)
            peak = float(response.get("peak_displacement", np.nan))
            error = peak / float(reference["peak_displacement"]) - 1.0
            assert abs(error) < 0.1 or findings_of(response), (case.name, model.name, error)
