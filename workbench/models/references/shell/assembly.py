"""The discretised column of shells with its state, as the explicit driver sees it."""

import numpy as np

from workbench.base.arrays import Array, Indices
from workbench.base.errors import SolverError
from workbench.mechanics.structures.elements import StepEnergies
from workbench.mechanics.structures.explicit import SAFETY, Face, stable_step
from workbench.models.references.shell.kernels import ShellState, StepWork, respond
from workbench.models.references.shell.mesh import ShellMesh, shell_mesh, supports_of
from workbench.models.references.solid.kernels import LumpedAssembly, SolidSteel
from workbench.models.references.solid.mesh import Supports
from workbench.scenarios import Column
from workbench.steel.materials import POISSON_RATIO, Steel

SMALL = 1e-7  # largest displacement (m, rad) at which the elastic stiffness is probed
MOST_STEPS = 200_000  # until it is at rest


class ShellAssembly(LumpedAssembly):
    """Shells for explicit steps, whose dofs are the unknowns of their supports.

    A call of `resist` takes them to the end of a step and is always followed by `commit`.
    Arguments: `mesh`; `supports`; `steel`; `mass` of the dofs of all nodes (nodes, 6), kg and kg
    m2. Public state as of `SolidAssembly`; `hourglass`, work against hourglass modes in J, part of
    `stored`; `nodal` displacements and rotations (nodes, 6).
    """

    def __init__(self, mesh: ShellMesh, supports: Supports, steel: Steel, mass: Array) -> None:
        self.mesh, self.supports, self.rate = mesh, supports, steel.rate
        hardening = steel.hardening_modulus or 0.0
        self.steel = SolidSteel(steel.elastic_modulus, POISSON_RATIO, steel.yield_stress, hardening)
        self.size = supports.unknowns
        self.displacement, self.velocity, self.load = np.zeros((3, self.size))
        self.nodal_mass = mass
        self.mass = np.asarray(supports.gathering @ mass.ravel())
        for plate in supports.plates:
            self.mass[plate.turn] = mass.ravel()[plate.vertical] @ plate.places**2
        self.held: Indices = np.zeros(0, dtype=np.int64)
        self.spring = (0.0, 0.0)
        self.stored = self.dissipated = self.hourglass = 0.0
        self.nodal = np.zeros((len(mesh.place), 6))
        self.state = ShellState.of(len(mesh.shells.thickness))
        self._work = StepWork(0.0, 0.0, 0.0)

    @property
    def head(self) -> int:
        """The unknown U."""
        return self.size - 1

    def press(self, stress: float) -> None:
        """Let all elements carry a stress (Pa) along the column; the mesh stands under it."""
        self.state.linear[:, 1] += stress / self.steel.modulus
        self.state.linear[:, 0] -= POISSON_RATIO * stress / self.steel.modulus

    def attach(self, face: Face, mass: float) -> None:
        """Attach a mass (kg) to the dofs of a face, by their shares."""
        shares = np.abs(face.shares)
        self.mass[face.dofs] += mass * shares / shares.sum()

    def weigh(self, acceleration: float, direction: float = 0.0) -> None:
        """Let all mass weigh by an `acceleration` (m/s2) across the column, in a direction."""
        weight = np.zeros_like(self.nodal_mass)
        weight[:, 0] = np.cos(direction) * acceleration * self.nodal_mass[:, 0]
        weight[:, 1] = np.sin(direction) * acceleration * self.nodal_mass[:, 1]
        self.load = self.load + self.supports.gathering @ weight.ravel()

    def resist(self, end: Array) -> Array:
        """Internal forces (unknowns,) at `end`, to which the state goes."""
        nodal = self.supports.expand(end).reshape(-1, 6)
        step, self.nodal = nodal - self.nodal, nodal
        force = np.zeros_like(nodal)
        place = self.mesh.place + nodal[:, :3]
        self._work = respond(self.mesh.shells, place, step, self.state, self.steel, force)
        gathered = self.supports.gather(end, force.ravel())
        stiffness, unstressed = self.spring
        gathered[self.head] += stiffness * (end[self.head] - unstressed)
        return gathered

    def assemble(self, end: Array, _weight: float | None = None) -> Array:
        """Prepare the tangent, which is that of the straight elastic column, whatever `end`."""
        return end

    def tangent_times(self, x: Array) -> Array:
        """Product of the elastic stiffness of the straight column with x (unknowns,)."""
        scale = SMALL / max(float(np.max(np.abs(x))), 1e-300)
        step = self.supports.tied @ (scale * x)
        for plate in self.supports.plates:
            step[plate.vertical] += plate.places * scale * x[plate.turn]
        step, force = step.reshape(-1, 6), np.zeros_like(self.nodal)
        place, state = self.mesh.place + step[:, :3], ShellState.of(len(self.state.yielded))
        strong = self.steel._replace(yield_stress=np.inf)
        respond(self.mesh.shells, place, step, state, strong, force)
        gathered = self.supports.gather(0.0 * x, force.ravel()) / scale
        gathered[self.head] += self.spring[0] * x[self.head]
        return np.asarray(gathered)

    def account(self, end: Array, _weight: float) -> StepEnergies:
        """Energies of the step to `end`, with the mean of the stresses at both ends."""
        stiffness, unstressed = self.spring
        pulled = [float(q[self.head]) - unstressed for q in (self.displacement, end)]
        self._stored = self.stored + 0.5 * stiffness * (pulled[1] ** 2 - pulled[0] ** 2)
        self._stored += self._work.elastic + self._work.hourglass
        return StepEnergies(self._stored, self._work.plastic, 0.0, self._work.plastic)

    def commit(self, end: Array) -> None:
        """Accept the state of the last evaluation, which was at `end`."""
        self.stored = self._stored
        self.dissipated += self._work.plastic
        self.hourglass += self._work.hourglass
        self.displacement = end

    def settle(self, tolerance: float) -> int:
        """Come to rest under the loads: motion is stopped whenever it slows down.

        `tolerance`, largest unbalanced force over that at the start. Result: number of steps.
        Raises `SolverError`.
        """
        dt, inverse = SAFETY * stable_step(self), 1.0 / self.mass
        inverse[self.held] = 0.0
        velocity, energy, allowed = np.zeros(self.size), np.inf, 0.0
        for count in range(MOST_STEPS):
            end = self.displacement + dt * velocity
            residual = (self.load - self.resist(end)) * (inverse > 0.0)
            self.account(end, 0.5)
            self.commit(end)
            largest = float(np.max(np.abs(residual)))
            allowed = allowed or tolerance * largest
            if largest <= allowed:
                return count
            if not np.isfinite(largest):
                break
            gained = dt * inverse * residual
            velocity = velocity + gained
            kinetic = float(self.mass @ velocity**2)
            if not kinetic > energy:  # from rest, half a step
                velocity, kinetic = 0.5 * gained, 0.0
            energy = kinetic
        tried = "dynamic relaxation; is the load below the buckling load?"
        raise SolverError(f"step {count}", largest / allowed, tried)

    def face(self, nodes: Indices, shares: Array, direction: float = 0.0) -> Face:
        """Face that meets these nodes with these shares of its force, along a `direction` (rad)."""
        across = np.zeros(self.nodal.shape)
        across[nodes, 0], across[nodes, 1] = np.cos(direction) * shares, np.sin(direction) * shares
        pattern = np.asarray(self.supports.tied.T @ across.ravel())
        dofs = np.flatnonzero(pattern)
        return Face(dofs, pattern[dofs])


def shell_column(
    column: Column,
    refinement: int = 0,
    bow: float = 0.0,
    tilt: float = 0.0,
    upright: bool = False,
) -> ShellAssembly:
    """The shells of a column, at rest under its axial load; arguments as of `shell_mesh`.

    The mass is that of the column, spread over its elements; turning, a node has as much as it
    takes for its rotations not to shorten the step. `upright` as of
    `supports_of`.
    """
    mesh = shell_mesh(column, refinement, bow, tilt)
    supports = supports_of(mesh, column, upright)
    shells, weight = mesh.shells, mesh.areas * mesh.shells.thickness
    weight *= column.properties.mass_per_length * column.length / weight.sum()
    turning = np.maximum(mesh.areas / 8.0, shells.thickness**2 / 12.0)
    nodal = np.zeros((len(mesh.place), 6))
    for first, share in ((0, weight / 4.0), (3, weight / 4.0 * turning)):
        at = np.bincount(shells.nodes.ravel(), np.repeat(share, 4))
        nodal[:, first : first + 3] = at[:, None]
    assembly = ShellAssembly(mesh, supports, column.steel, nodal)
    head = assembly.head
    assembly.mass[head] += column.head_mass
    assembly.load[head] = -column.axial_load
    assembly.press(-column.axial_load / column.strength_section.area)
    return assembly
