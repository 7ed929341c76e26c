"""The model of this package: the contract of all models, closed forms, where it refuses."""

import pytest
from rigid_plastic_beam.model import RigidPlasticBeam
from rigid_plastic_beam.study import bar, hit

import workbench as wb
from workbench.testing import check_model

HEB = wb.Column("HEB 220", length_below=1.5, length_above=2.5, head="fixed")


def peak(scenario):
    """Peak of the model in m."""
    return float(RigidPlasticBeam().simulate(scenario)["peak_displacement"])


def refusals(column):
    """Subjects of what keeps the model from answering."""
    findings = RigidPlasticBeam().domain(wb.impact(column, mass=500, velocity=8.0))
    return [finding.subject for finding in findings if finding.refusal]


def test_the_contract_is_kept():
    """All inputs count or are named as unused, failures are typed, options survive a file."""
    check_model(RigidPlasticBeam(), [wb.impact(HEB, mass=1500, velocity=15.0), hit])


@pytest.mark.parametrize("velocity", [0.5, 5.0, 30.0])
def test_the_work_up_to_the_peak_is_the_energy(velocity):
    """By trapezoids under P = P_0 (1 + x^2), 2 P_0 x beyond x = 1."""
    scenario, steps = hit.at_velocity(velocity), 20_000
    model, reached = RigidPlasticBeam(), peak(scenario) / 0.05  # depth of the bar
    grid = [reached * i / steps for i in range(steps + 1)]
    force = [1.0 + x * x if x < 1.0 else 2.0 * x for x in grid]
    work = sum(force[1:-1]) + 0.5 * (force[0] + force[-1])
    work *= model.plateau(bar) * 0.05 * reached / steps
    assert work == pytest.approx(model.energy(scenario), rel=1e-6)


def test_slow_hits_only_bend_and_fast_ones_hang_on_a_string():
    """A small peak grows with the energy, a large one with the velocity."""
    assert peak(hit.at_velocity(0.2)) == pytest.approx(4.0 * peak(hit.at_velocity(0.1)), rel=1e-3)
    assert peak(hit.at_velocity(200.0)) == pytest.approx(
        2.0 * peak(hit.at_velocity(100.0)), rel=1e-3
    )


@pytest.mark.parametrize("ends", [{"head": "guided"}, {"base": "pinned"}, {"head": "pinned"}])
def test_ends_that_give_way_are_refused(ends):
    """Without supports that hold there is no tension."""
    assert refusals(bar) == []
    assert refusals(bar.changed(**ends)) == ["ends"]


def test_other_sections_and_elastic_energies_are_warned_of():
    """The numbers stand with the words."""
    warned = {f.subject: f.number for f in RigidPlasticBeam().domain(wb.impact(HEB, 50, 2.0))}
    assert warned["shape"] == pytest.approx(4.0 * 294.0 / 3231.0 / 0.22, rel=0.01)
    assert warned["elastic"] < 3.0
