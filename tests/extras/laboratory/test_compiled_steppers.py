"""The compiled steppers of the models take the steps of the laboratory's integrators."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from collision import collide

from workbench.extras.laboratory.complementarity import Restitution
from workbench.extras.laboratory.impact_systems import (
    ColumnSystem,
    StructureSystem,
    column_problem,
    frame_problem,
)
from workbench.extras.laboratory.schemes import LAW, SCHEMES, scheme
from workbench.extras.laboratory.schemes.time_stepping import central_differences, energy_midpoint
from workbench.extras.laboratory.systems import run
from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.explicit import explicit_impact
from workbench.mechanics.structures.fibers import BeamSection
from workbench.mechanics.structures.fibers.section import LinearHardening, ReissnerBeams
from workbench.mechanics.structures.impact import PointMass, impact
from workbench.models.four_dof import FourDof
from workbench.models.single_dof import SingleDof
from workbench.models.single_dof import march as kernels
from workbench.scenarios import ColumnImpact, Striker

CLOSE = {"rtol": 0.0, "atol": 1e-10}


class SpringColumn:
    """The spring of the SDOF column and the striker, for the laboratory."""

    def __init__(self, column, striker: float) -> None:
        curve = SingleDof().curve(column)
        self.pieces = curve.pieces
        self.state = kernels.spring_at_rest(curve.elastic_limit, curve.pieces)
        self.mass = np.diag([column.properties.impact_mass, striker])
        self.normals = np.array([[1.0], [-1.0]])

    def forces(self, q):
        f, slope, _ = kernels.spring_path(self.state, q[0], self.pieces)
        return np.array([f, 0.0]), np.diag([slope, 0.0])

    def mean_forces(self, q0, q1):
        _, slope, work = kernels.spring_path(self.state, q1[0], self.pieces)
        moved = q1[0] - q0[0]
        mean = work / moved if moved else self.state.force
        return np.array([mean, 0.0]), np.diag([0.5 * slope, 0.0])

    def surface(self, t):
        return np.zeros(1), np.zeros(1), np.zeros(1)

    def commit(self, q) -> None:
        self.state = kernels.spring_moved(self.state, q[0], self.pieces)

    def energy(self):
        return kernels.spring_energy(self.state, self.pieces), self.state.dissipated


@pytest.mark.parametrize("restitution", [0.0, 0.6])
def test_single_dof(thesis_impact, restitution: float) -> None:
    h, steps = 2e-5, 400
    column = thesis_impact.column
    striker = Striker(1500.0, 15.0, restitution)
    scenario = ColumnImpact("hit", column, striker, duration=h * steps)
    answer = SingleDof(time_step=h).simulate(scenario)
    system = SpringColumn(column, striker.mass)
    first = collide(system.mass[0, 0], striker.mass, striker.velocity, restitution)
    start = np.zeros(2), np.array([first.struck_velocity, first.striker_velocity])
    law = Restitution(restitution)
    result = run(energy_midpoint(1.0), system, law, start, h * steps, h)
    np.testing.assert_allclose(result.q[1:, 0], answer["displacement"].values[1:], **CLOSE)
    np.testing.assert_allclose(result.v[1:, 1], answer["striker_velocity"].values[1:], rtol=1e-9)


@pytest.mark.thorough
@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.6])
def test_four_dof(thesis_impact, restitution: float) -> None:
    h, steps = 2e-5, 1500  # past the peak, and every contact of the way there
    column = replace(thesis_impact.column, head_mass=95.25)
    striker = Striker(1500.0, 15.0, restitution)
    scenario = ColumnImpact("hit", column, striker, duration=h * steps)
    answer = FourDof(time_step=h).simulate(scenario)
    system = ColumnSystem(column, striker.mass)
    start = system.start, np.array([0.0, 0.0, 0.0, striker.velocity])
    law = Restitution(restitution)
    result = run(energy_midpoint(1.0), system, law, start, h * steps, h)
    np.testing.assert_allclose(result.q[:, 0], answer["displacement"].values, **CLOSE)
    np.testing.assert_allclose(result.v[1:, 3], answer["striker_velocity"].values[1:], **CLOSE)
    total = result.energies.sum(axis=1) + np.append(0.0, np.cumsum(result.contact_loss))
    assert np.ptp(total) < 1e-9 * result.energies[0, 0]


def struck_beam() -> tuple[PlanarAssembly, int]:
    """A clamped beam of four elements that yields, and the dof of its middle."""
    depth, area = np.array([-0.08, 0.0, 0.08]), np.full(3, 0.04 / 3.0)
    law = LinearHardening(210e9, 355e6, 2.1e9)
    section = BeamSection(depth, area, law, 314.0, shear_stiffness=2.7e9)
    nodes = np.array([[0, 1], [1, 2], [2, 3], [3, 4]])
    group = ReissnerBeams(nodes, np.zeros(4, dtype=np.int64), [section])
    at = np.stack([np.linspace(0.0, 2.0, 5), np.zeros(5)], axis=1)
    beam = PlanarAssembly(at, [group], lumped=True)
    beam.hold([beam.dof(node, c) for node in (0, 4) for c in ("u", "v", "rotation")])
    return beam, beam.dof(2, "v")


@pytest.mark.parametrize("restitution", [0.0, 0.6])
@pytest.mark.parametrize(
    ("integrator", "stepper"),
    [
        ("midpoint", energy_midpoint(reach=1.0)),
        ("explicit", central_differences()),
    ],
)
def test_structures(integrator: str, stepper, restitution: float) -> None:
    mass, speed, h, steps = 300.0, 4.0, 2e-5, 60
    assembly, dof = struck_beam()
    striker, spans = PointMass(mass, speed, restitution), [(h * steps, h)]
    if integrator == "explicit":
        driver = explicit_impact(assembly, dof, striker, spans, h)
    else:
        driver = impact(assembly, dof, striker, spans, 0.5, 1e-13)
    expected = [(float(assembly.displacement[dof]), s.striker.velocity) for s in driver]
    assert len(expected) == steps
    assembly, dof = struck_beam()
    system = StructureSystem(assembly, dof, mass)
    rest = np.zeros(len(system.start))
    rest[-1] = speed
    result = run(stepper, system, Restitution(restitution), (system.start, rest), h * steps, h)
    place = int(np.flatnonzero(system.free == dof)[0])
    np.testing.assert_allclose(result.q[1:, place], [q for q, _ in expected], **CLOSE)
    np.testing.assert_allclose(result.v[1:, -1], [v for _, v in expected], rtol=1e-8)


def test_classical_contact_makes_the_striker_bounce_on_the_column() -> None:
    given = column_problem()
    values = {
        name: run(scheme(name).stepper, given.system(), given.law, given.start, 0.01, 1e-4)
        for name in ("moreau-jean", "newmark")
    }
    assert values["moreau-jean"].impacts == given.impacts
    assert values["moreau-jean"].chatter < 0.3 < 0.8 < values["newmark"].chatter


@pytest.mark.thorough
@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize("given", [column_problem(), frame_problem()], ids=["column", "frame"])
def test_every_scheme_answers_a_struck_column_and_a_struck_frame(given, name: str) -> None:
    """At steps that explicit schemes stand; those that know the law of the problem agree."""
    duration, h = 0.002, 2.5e-5
    values = [
        run(scheme(each).stepper, given.system(), given.law, given.start, duration, h).q
        for each in (name, "event-driven")
    ]
    assert np.isfinite(values[0]).all()
    if SCHEMES[name].restitution == LAW:
        assert np.abs(values[0] - values[1]).max() < 0.05 * np.abs(values[1]).max()
