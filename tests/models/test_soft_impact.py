"""Soft impact: closed forms of two masses, limits of the rigid and of the soft striker, ledger."""

from dataclasses import replace
from math import inf, pi, sqrt

import numpy as np
import pytest
from scipy.linalg import eigh

from workbench.base.errors import InputError
from workbench.mechanics.impact.integrator import follow
from workbench.mechanics.impact.pace import Pace
from workbench.models.single_dof import SingleDof
from workbench.models.single_dof.march import RECORD
from workbench.models.soft_impact import SoftImpact, crush, impact
from workbench.responses import Outcome, energy_error, outcome_of, survives, warnings_of
from workbench.scenarios import ColumnImpact


@pytest.fixture(scope="module")
def weak(thesis_impact: ColumnImpact) -> ColumnImpact:
    """A hit that leaves the column elastic: its spring is linear, it is free to shorten."""
    column = replace(thesis_impact.column, axial_load=0.0, restraint_stiffness=0.0)
    striker = replace(thesis_impact.striker, velocity=0.1)
    return replace(thesis_impact, column=column, striker=striker, duration=0.02)


@pytest.mark.claim("model:soft-impact", "off its two modes, relative", "closed form", 0, 4e-4)
def test_elastic_masses_move_in_their_two_modes(weak: ColumnImpact, claim) -> None:
    model = SoftImpact(striker_stiffness=2e7)
    response = model.simulate(weak)
    given = model.curve(weak).initial_stiffness
    masses = weak.striker.mass, weak.column.properties.impact_mass
    stiffness = np.array([[2e7, -2e7], [-2e7, 2e7 + given]])
    squares, modes = eigh(stiffness, np.diag(masses))
    omega, part = np.sqrt(squares), modes[0] * masses[0] * weak.striker.velocity
    time = response["time"].values
    exact = (modes * (part / omega)) @ np.sin(np.outer(omega, time))
    together = np.cumsum(exact[0] - exact[1] < 0.0) == 0  # until the spring would pull
    assert together.sum() > 400
    result = response["displacement"].values[together]
    error = np.abs(result - exact[1][together]).max() / exact[1][together].max()
    claim(error)
    assert float(response["residual_displacement"]) == 0.0


def test_a_stiff_striker_is_a_rigid_one_that_bounces(thesis_impact: ColumnImpact) -> None:
    bouncing = replace(thesis_impact, striker=replace(thesis_impact.striker, restitution=1.0))
    rigid = float(SingleDof().simulate(bouncing)["peak_displacement"])
    stiff = SoftImpact(striker_stiffness=1e10).simulate(thesis_impact)
    assert float(stiff["peak_displacement"]) == pytest.approx(rigid, rel=2e-4)  # measured 1e-4


@pytest.mark.claim("model:soft-impact", "force over v (k m)^1/2", "en1991-1-7", 1, 2e-3)
def test_a_soft_striker_pushes_as_the_code_says(thesis_impact: ColumnImpact, claim) -> None:
    stiffness, striker = 3e5, thesis_impact.striker
    response = SoftImpact().simulate(replace(thesis_impact, duration=0.3))
    force = striker.velocity * sqrt(stiffness * striker.mass)  # EN 1991-1-7, C.3
    claim(response["peak_force"] / force)
    assert float(response["impulse"]) == pytest.approx(2.0 * striker.mass * striker.velocity)
    contact = response["time"].values[response["percussion"].values > 0.0]
    assert contact[-1] == pytest.approx(pi * sqrt(striker.mass / stiffness), rel=2e-3)


def test_what_crushes_limits_the_force_and_takes_the_energy(thesis_impact: ColumnImpact) -> None:
    model = SoftImpact(striker_stiffness=1e7, crush_force=1e6)
    response = model.simulate(thesis_impact)
    step = float(np.diff(response["time"])[0])
    assert float(response["percussion"].max()) / step <= 1e6 * (1.0 + 1e-12)
    assert float(response["contact_loss"][-1]) > 5e3
    assert energy_error(response) < 1.1e-5  # measured 5.3e-6
    elastic = replace(model, crush_force=None).simulate(thesis_impact)
    assert float(response["peak_displacement"]) < float(elastic["peak_displacement"])


def test_the_spring_of_the_striker_flows_unloads_and_never_pulls() -> None:
    spring = 2.0, 3.0
    assert crush(1.0, 0.0, *spring) == (2.0, 0.0)
    assert crush(2.0, 0.0, *spring) == (3.0, 0.5)
    assert crush(1.5, 0.5, *spring) == (2.0, 0.5)
    assert crush(0.4, 0.5, *spring) == (0.0, 0.5)
    assert crush(9.0, 0.0, 2.0, inf) == (18.0, 0.0)


def test_steps_are_of_second_order(weak: ColumnImpact) -> None:
    curve = SoftImpact().curve(weak)
    mass, ends = weak.column.properties.impact_mass, []
    blow, weightless = (1500.0, 0.1, 0.0, 0.0), (0.0, 0.0)
    drive = *blow, curve.elastic_limit, 1.0, mass, *weightless, 2e7, inf
    for steps in (40, 80, 160, 1280):
        pace = Pace.equal(0.004, 0.004 / steps, steps)
        run = follow(impact, (curve.pieces,), pace, drive, RECORD)
        ends.append(float(run.records["displacement"][-1]))
    errors = np.abs(np.array(ends[:3]) - ends[3])
    order = np.polyfit(np.log([4.0, 2.0, 1.0]), np.log(errors), 1)[0]
    assert order == pytest.approx(2.0, abs=0.15)


def test_what_has_no_meaning_is_said_or_refused(thesis_impact: ColumnImpact) -> None:
    for options in ({"striker_stiffness": 0.0}, {"crush_force": -1.0}, {"resistance": "cubical"}):
        with pytest.raises(InputError):
            SoftImpact(**options)
    fast = replace(thesis_impact, striker=replace(thesis_impact.striker, mass=9e3, velocity=40.0))
    response = SoftImpact(striker_stiffness=1e8).simulate(fast)
    assert outcome_of(response) is Outcome.COLLAPSE


def test_what_a_run_has_not_reached_is_said_or_left_out(thesis_impact: ColumnImpact) -> None:
    still = replace(thesis_impact, duration=0.0985)  # the car pushes on, the column swings
    response = SoftImpact().simulate(still)
    assert response["displacement"].values.argmax() < response.sizes["time"] - 1
    findings = {finding.subject: finding for finding in warnings_of(response)}
    assert "peak_displacement" not in response
    assert survives(response) is None
    assert "0.22 s" in findings["no-peak"].remedy
    assert "300 kN/m" in findings["estimate"].text
    assert "shear" not in findings  # no mechanism forms
    longer = SoftImpact().simulate(replace(thesis_impact, duration=0.3))
    assert "no-peak" not in {finding.subject for finding in warnings_of(longer)}
    assert float(longer["peak_displacement"]) > float(response["displacement"].max())
    stiff = warnings_of(SoftImpact(striker_stiffness=1e8).simulate(thesis_impact))
    assert "reaches V/Vpl = 1." in next(f.text for f in stiff if f.subject == "shear")
    assert "estimate" not in {finding.subject for finding in stiff}
