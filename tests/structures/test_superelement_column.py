"""Superelements in the drivers: the pushed and the struck column of Heng 2017, free flight."""

import numpy as np
import pytest
from superelement_cases import chain, thesis_column

from workbench.mechanics.structures.impact import PointMass, impact
from workbench.mechanics.structures.paths import push

STRIKER = 1500.0  # kg
AT = (0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)  # m
# force in MN of two rigid bars with generalized hinges, by an independent implementation
PUSHED = {
    (1.0, 1.0): (0.739, 0.775, 0.851, 0.860, 0.866, 0.970, 1.260, 1.849, 2.836),
    (1.0, 1.3): (0.786, 0.810, 0.840, 0.896, 0.959, 1.133, 1.484, 2.094, 2.848),
    (1.0, 1.4): (0.797, 0.818, 0.838, 0.901, 0.980, 1.172, 1.535, 2.142, 2.851),
    (1.0, 2.0): (0.831, 0.843, 0.835, 0.889, 1.045, 1.326, 1.745, 2.311, 2.867),
}


@pytest.mark.parametrize("exponents", PUSHED)
def test_pushed_column_of_the_thesis(exponents):
    """Heng 2017, figure 5.8, continued into the catenary range."""
    assembly, _, hit = thesis_column(exponents=exponents)
    stored, start = assembly.stored, assembly.displacement.copy()
    path = np.linspace(0.0, 0.7, 281)
    steps = list(push(assembly, hit, path[1:]))
    force = [1e-6 * steps[round(v / 0.0025) - 1].factor for v in AT]
    assert force == pytest.approx(PUSHED[exponents], rel=2e-3)
    assert sum(step.cuts for step in steps) == 0
    work = np.trapezoid([0.0] + [s.factor for s in steps], path)
    work += assembly.load @ (assembly.displacement - start)
    spent = sum(step.energies.plastic for step in steps) + steps[-1].energies.stored - stored
    assert spent == pytest.approx(work, rel=2e-5)  # measured 9.0e-6


def test_flexible_bar_gives_the_same_force_once_hinges_have_formed():
    forces = []
    for flexible in (False, True):
        assembly, _, hit = thesis_column(flexible=flexible)
        steps = list(push(assembly, hit, np.linspace(0.0, 0.7, 281)[1:]))
        forces.append([step.factor for step in steps[19:]])  # from 0.05 m
    assert forces[1] == pytest.approx(forces[0], rel=3e-3)


def struck(velocity: float, duration: float = 0.06, step: float = 1e-4, node_mass=0.0, **options):
    """Peak, its time, and the largest error of the energy balance over the energy brought in."""
    assembly, _, hit = thesis_column(**options)
    for node in range(3):
        assembly.add_mass(node, node_mass if node == 1 else 0.0, rotary=0.1)
    brought = 0.5 * STRIKER * velocity**2
    start = brought + assembly.stored
    spent = peak = time = error = work = 0.0
    for taken in impact(assembly, hit, PointMass(STRIKER, velocity), [(duration, step)], 0.5):
        spent += taken.energies.plastic + taken.energies.algorithmic + taken.contact_loss
        work += taken.external_work
        kept = taken.kinetic + taken.striker.kinetic_energy + taken.energies.stored
        error = max(error, abs(kept + spent - work - start))
        if assembly.displacement[hit] > peak:
            peak, time = float(assembly.displacement[hit]), taken.time
    return peak, time, error / brought


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("exponents", "node_mass", "mass", "peaks"),
    [
        ((1.0, 1.3), 0.0, 71.4, (0.0899, 0.1909, 0.3219)),
        ((1.0, 1.3), 95.25, 0.0, (0.0900, 0.1910, 0.3232)),
        ((1.0, 1.0), 95.25, 0.0, (0.0932, 0.1937, 0.3341)),
        ((1.5, 1.5), 95.25, 0.0, (0.0878, 0.1910, 0.3192)),
    ],
)
def test_struck_column_of_the_thesis(exponents, node_mass, mass, peaks):
    """Heng 2017, figure 5.9: 1500 kg at 10, 15 and 20 m/s, no rebound."""
    for velocity, expected in zip((10.0, 15.0, 20.0), peaks, strict=True):
        peak, _, error = struck(
            velocity, node_mass=node_mass, exponents=exponents, mass=mass, inertia="nonlinear"
        )
        assert peak == pytest.approx(expected, rel=1.6e-3)  # measured 7.7e-4
        assert error <= 1e-8


def test_rotary_inertia_of_the_bars_hardly_matters():
    """Heng 2017, figure 5.14: linear, nonlinear and none are almost the same."""
    peaks = {
        inertia: struck(20.0, mass=71.4, inertia=inertia)
        for inertia in ("nonlinear", "linear", "none")
    }
    assert peaks["linear"][0] == pytest.approx(peaks["nonlinear"][0], rel=2e-5)  # measured 9.5e-6
    assert peaks["none"][0] == pytest.approx(peaks["nonlinear"][0], rel=1.1e-3)  # measured 5.5e-4
    assert peaks["linear"][0] != peaks["nonlinear"][0] != peaks["none"][0]
    assert max(error for _, _, error in peaks.values()) <= 1e-8


def test_peak_depends_little_on_the_time_step():
    peaks = [struck(15.0, 0.03, step, mass=71.4, inertia="nonlinear")[0] for step in (2e-4, 5e-5)]
    assert peaks[0] == pytest.approx(peaks[1], rel=2e-3)


@pytest.mark.parametrize("inertia", ["none", "nonlinear"])
def test_free_flight_keeps_energy_and_momentum(inertia):
    """A flexible bar, spinning, translating and vibrating elastically, far from any striker."""
    assembly, group = chain(
        [0.5, 0.7], flexible=True, mass=71.4, inertia=inertia, regularisation=0.0
    )
    for node in range(3):
        assembly.add_mass(node, 5.0, rotary=0.5)
    spin = 8.0
    velocity = np.zeros((3, 3))
    velocity[:, 0] = 2.0
    velocity[:, 1] = 1.0 + spin * assembly.coordinates[:, 0] + [0.0, 0.3, 0.0]
    velocity[:, 2] = spin
    assembly.velocity[:] = velocity.ravel()
    first, last = velocity[:-1], velocity[1:]  # chords turn as their nodes move
    group._old.rate[:] = (last - first)[:, 1] / np.diff(assembly.coordinates[:, 0])
    along = np.tile([1.0, 0.0, 0.0], 3), np.tile([0.0, 1.0, 0.0], 3)
    momentum = [float(d @ assembly.mass_times(assembly.velocity)) for d in along]
    energy = assembly.kinetic_energy()
    bystander = PointMass(1.0, -100.0, position=-10.0)
    for taken in impact(assembly, assembly.dof(1, "v"), bystander, [(0.2, 2e-4)], 0.5, 1e-11):
        assert taken.impulse == taken.energies.plastic == 0.0
        kept = taken.kinetic + taken.energies.stored
        assert kept == pytest.approx(energy, rel=2e-9)
    now = [float(d @ assembly.mass_times(assembly.velocity)) for d in along]
    assert now == pytest.approx(momentum, rel=1e-9)
    assert assembly.displacement[2] == pytest.approx(0.2 * spin, abs=0.013)  # measured 0.0065
