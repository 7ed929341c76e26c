"""The solid hit by a rigid striker: lumped mass, explicit steps, and the response.

The mass stands at the nodes, by the quadrature rule that samples there (Simpson's, whose weights
are all positive). End plates turn about their centroid, so that the mass of every unknown is
constant: a plate has the inertia sum m X^2, and what couples its turn to the displacement of the
head sums to zero. The steps are those of `structures/explicit`: no longer than the fastest wave
takes through the smallest element, so that fronts, contact and yielding are resolved as far as
the mesh is.
"""

import numpy as np

from workbench.arrays import Array
from workbench.errors import SolverError
from workbench.references.solid.assembly import SolidAssembly
from workbench.references.solid.run import finished, held_unknowns, measures, release
from workbench.responses import Response
from workbench.scenarios import Column, ColumnImpact
from workbench.structures.elements import StepEnergies
from workbench.structures.explicit import explicit_impact
from workbench.structures.time_steps import PointMass

RECORDS = 1000  # of an impact
# shares of an element's mass at its corners, in the middles of its edges, in its centre
SIMPSON = np.repeat([1.0 / 36.0, 4.0 / 36.0, 16.0 / 36.0], [4, 4, 1])


def nodal_mass(solid: SolidAssembly, column: Column) -> Array:
    """Mass at every dof of the mesh (dofs,), in kg: that of the column, spread over its mesh."""
    mesh = solid.mesh
    density = column.properties.mass_per_length / mesh.area
    mass = np.zeros(mesh.size)
    shares = np.repeat(SIMPSON, 2)
    np.add.at(mass, mesh.dofs, density * mesh.weights.sum(1)[:, None] * shares)
    return mass


def unknown_mass(solid: SolidAssembly, column: Column) -> Array:
    """Mass of every unknown (unknowns,) in kg, the head mass among them.

    That of a turning plate is its inertia in kg m2.
    """
    supports, nodal = solid.supports, nodal_mass(solid, column)
    mass = np.asarray(supports.tied.T @ nodal)
    for plate in supports.plates:
        mass[plate.turn] = nodal[plate.vertical] @ plate.places**2
    mass[supports.head] += column.head_mass
    return mass


class MovingSolid:
    """The solid in motion for the explicit driver; dofs are the unknowns q of its supports.

    Arguments: `solid`, in equilibrium under its axial load, which passes to the driver; `column`.
    """

    def __init__(self, solid: SolidAssembly, column: Column) -> None:
        self.solid = solid
        self.size = solid.supports.unknowns
        self.held = held_unknowns(solid, column)
        self.mass = unknown_mass(solid, column)
        self.load = np.zeros(self.size)
        self.load[solid.supports.head], solid.load = solid.load, 0.0
        self.displacement, self.velocity = solid.q, np.zeros(self.size)
        self.stored = solid.stored()

    def mass_times(self, x: Array) -> Array:
        """Product of the mass matrix with x (unknowns,)."""
        return np.asarray(self.mass * x)

    def assemble(self, end: Array, _weight: float | None) -> Array:
        """Internal forces (unknowns,) at `end`; the solid keeps its tangent."""
        return self.solid.residual(end)

    def tangent_times(self, x: Array) -> Array:
        """Product of that tangent with x (unknowns,)."""
        return np.asarray(self.solid.tangent @ x)

    def begin_step(self, _duration: float) -> None:
        """The steel does not depend on rates."""

    def resist(self, end: Array) -> Array:
        """Internal forces (unknowns,) at `end`. Raises `SolverError` where there are none."""
        force = self.solid.residual(end, tangent=False)
        if np.isnan(force[0]):
            at = f"displacement {end[self.solid.supports.hit]:.4g} m"
            strain = self.solid.largest_strain()
            raise SolverError(at, strain, "no more: a point of the solid is turned inside out")
        return force

    def account(self, end: Array, _weight: float) -> StepEnergies:
        """Energies of the step to `end`, with the mean of the stresses at both ends."""
        plastic = self.solid.plastic_work
        return StepEnergies(self.solid.stored(end), plastic, 0.0, plastic)

    def commit(self, end: Array) -> None:
        """Accept the step to `end`."""
        self.solid.commit(end)
        self.displacement = self.solid.q

    def kinetic_energy(self) -> float:
        """Kinetic energy of the unknowns, in J."""
        return 0.5 * float(np.sum(self.mass * self.velocity**2))


def run_impact(scenario: ColumnImpact, solid: SolidAssembly, step: float) -> Response:
    """Follow an impact on the solid under its axial load, with explicit steps of at most `step` s.

    A fixed head is locked, and the restraint spring unstressed, from here on. Raises `SolverError`.
    """
    column, striker = scenario.column, scenario.striker
    plastic_before = release(solid, column)
    moving = MovingSolid(solid, column)
    hit = solid.supports.hit
    hitting = PointMass(striker.mass, striker.velocity, striker.restitution)
    spans = [(scenario.duration, scenario.duration / RECORDS)]
    rows = [(0.0, 0.0, 0.0, scenario.input_energy, striker.velocity, 0.0, 0.0, 0.0)]
    states = [measures(solid, plastic_before)]
    for taken in explicit_impact(moving, hit, hitting, spans, step):
        assert taken.striker is not None
        rows.append(
            (
                taken.time,
                float(solid.q[hit]),
                float(moving.velocity[hit]),
                taken.kinetic + taken.striker.kinetic_energy,
                taken.striker.velocity,
                taken.impulse,
                taken.contact_loss,
                taken.external_work,
            )
        )
        states.append(measures(solid, plastic_before))
    time, displacement, velocity, kinetic, speed, percussion, lost, work = np.array(rows).T
    values = {
        "displacement": displacement,
        "velocity": velocity,
        "kinetic": kinetic,
        "striker_velocity": speed,
        "percussion": percussion,
        "contact_loss": np.cumsum(lost),
        "external_work": np.cumsum(work),
        "input_energy": scenario.input_energy,
    }
    return finished(column, solid, values, states, time=time)
