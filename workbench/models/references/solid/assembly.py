"""The discretised column with its state, as the drivers of structures see it."""

import numpy as np
from scipy.sparse import coo_array, csc_array, diags_array
from scipy.sparse.linalg import splu

from workbench.base.arrays import Array, Indices
from workbench.base.errors import SolverError
from workbench.mechanics.structures.elements import StepEnergies
from workbench.models.references.solid.kernels import Elements, Energies, empty_state, respond
from workbench.models.references.solid.material import SolidSteel
from workbench.models.references.solid.mesh import SolidMesh, Supports, solid_mesh, supports_of
from workbench.scenarios import Column
from workbench.steel.materials import POISSON_RATIO, Steel

# shares of an element's mass at its corners, in the middles of its edges, in its centre
SIMPSON = np.repeat([1.0 / 36.0, 4.0 / 36.0, 16.0 / 36.0], [4, 4, 1])


class SolidAssembly:
    """A structure (see `equilibrium.Structure`) whose dofs are the unknowns q of its supports.

    Arguments: `mesh`; `supports`; `steel`; `hardening_ratio`, isotropic hardening modulus over
    Young's modulus; `mass` of every unknown (unknowns,), only needed in motion. Public state:
    `displacement` (unknowns,), committed, and `velocity`; `load` (unknowns,) in N; unknowns that
    are `held`; `spring` (stiffness and unstressed position of the head) in N/m and m;
    `squash_load` and `round_off` of forces in N; of the last evaluation internal forces `force`
    (dofs,) and `tangent` (unknowns, unknowns); energy `stored` and plastic work so far,
    `dissipated`, in J.
    """

    def __init__(
        self,
        mesh: SolidMesh,
        supports: Supports,
        steel: Steel,
        hardening_ratio: float,
        mass: Array | None = None,
    ) -> None:
        self.mesh, self.supports, modulus = mesh, supports, steel.elastic_modulus
        hardening = steel.hardening_modulus or hardening_ratio * modulus
        self.rate, self.hardening_ratio = steel.rate, hardening / modulus
        self.steel = SolidSteel(modulus, POISSON_RATIO, steel.yield_stress, hardening)
        self.squash_load = steel.yield_stress * mesh.area
        # strain is a difference of numbers near 1
        self.round_off = 8.0 * np.finfo(float).eps * modulus * mesh.area
        self.size = supports.unknowns
        self.displacement, self.velocity, self.load = np.zeros((3, self.size))
        self.mass = np.zeros(self.size) if mass is None else mass
        self.held: Indices = np.zeros(0, dtype=np.int64)
        self.spring = (0.0, 0.0)
        self.force = np.zeros(mesh.size)
        self.tangent = csc_array((self.size, self.size))
        self.stored = self.dissipated = 0.0
        self.elements = Elements(mesh.gradients, mesh.weights, mesh.dofs)
        self._old, self._new = empty_state(self.elements), empty_state(self.elements)
        self._matrices = np.empty((len(mesh.dofs), mesh.dofs.shape[1], mesh.dofs.shape[1]))
        self._energies = Energies(0.0, 0.0)

    def _forces(self, q: Array, tangent: bool) -> Array:
        """Internal forces (unknowns,) at q, all NaN where the material has no answer."""
        mesh, supports = self.mesh, self.supports
        self.force = np.zeros(mesh.size)
        matrices = self._matrices if tangent else self._matrices[:0]
        u = supports.expand(q)
        self._energies = respond(
            self.elements, u, self._old, self._new, self.steel, self.force, matrices
        )
        if np.isnan(self._energies.stored):
            return np.full(self.size, np.nan)
        stiffness, unstressed = self.spring
        force = supports.gather(q, self.force)
        force[supports.head] += stiffness * (q[supports.head] - unstressed)
        if tangent:
            rows = np.repeat(mesh.dofs, mesh.dofs.shape[1], axis=1).ravel()
            places = rows, np.tile(mesh.dofs, (1, mesh.dofs.shape[1])).ravel()
            matrix = coo_array((matrices.ravel(), places), shape=(mesh.size, mesh.size)).tocsr()
            derivative = supports.derivative(q)
            diagonal = supports.curvature(q, self.force)
            diagonal[supports.head] += stiffness
            self.tangent = (derivative.T @ matrix @ derivative + diags_array(diagonal)).tocsc()
        return force

    def assemble(self, end: Array, _weight: float | None = None) -> Array:
        """Internal forces (unknowns,) at `end`, NaN where there are none; prepares the tangent."""
        return self._forces(end, True)

    def resist(self, end: Array) -> Array:
        """Internal forces (unknowns,) at `end`. Raises `SolverError` where there are none."""
        force = self._forces(end, False)
        if np.isnan(force[0]):
            at = f"displacement {end[self.supports.hit]:.4g} m"
            tried = "no more: a point of the solid is turned inside out"
            raise SolverError(at, self.largest_strain(), tried)
        return force

    def solve(self, right: Array, held: Indices | None = None) -> Array | None:
        """Tangent^-1 times `right` (unknowns,), `held` ones at zero; None if it is singular."""
        free = np.delete(np.arange(self.size), self.held if held is None else held)
        try:
            factors = splu(
                self.tangent[free][:, free],
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.01,
                options={"SymmetricMode": True},
            )
        except RuntimeError:  # exactly singular
            return None
        solution = np.zeros_like(right)
        solution[free] = factors.solve(right[free])
        return solution if np.all(np.isfinite(solution)) else None

    def tangent_times(self, x: Array) -> Array:
        """Product of the tangent with x (unknowns,)."""
        return np.asarray(self.tangent @ x)

    def tangent_row(self, dof: int) -> tuple[Array, Indices]:
        """Row of an unknown in the tangent, which is symmetric, and its columns."""
        first, last = self.tangent.indptr[dof : dof + 2]
        return self.tangent.data[first:last], self.tangent.indices[first:last]

    def allowed_residual(self, tolerance: float, _start: Array, _residual: Array) -> float:
        """Largest residual entry (N) of a solved step: a wild start must not loosen it."""
        scale = max(*(float(np.max(np.abs(x))) for x in (self.force, self.load)), 1e-6)
        return max(tolerance * min(scale, self.squash_load), self.round_off)

    def mass_times(self, x: Array) -> Array:
        """Product of the mass matrix with x (unknowns,)."""
        return np.asarray(self.mass * x)

    def begin_step(self, duration: float) -> None:
        """Let the steel flow at a rate from now on, in explicit steps of that `duration` (s)."""
        if self.rate is not None:
            flow, exponent = self.rate.reference_rate * duration, self.rate.exponent
            self.steel = self.steel._replace(reference_flow=flow, exponent=exponent)

    def account(self, end: Array, _weight: float) -> StepEnergies:
        """Energies of the step to `end`, with the mean of the stresses at both ends."""
        stiffness, unstressed = self.spring
        stored, plastic = self._energies
        pulled = float(end[self.supports.head]) - unstressed
        return StepEnergies(stored + 0.5 * stiffness * pulled**2, plastic, 0.0, plastic)

    def commit(self, end: Array) -> None:
        """Accept the state of the last evaluation, which was at `end`."""
        self.dissipated += self._energies.plastic
        self.displacement = end.copy()
        self._old, self._new = self._new, self._old

    def kinetic_energy(self) -> float:
        """Kinetic energy of the unknowns, in J."""
        return 0.5 * float(np.sum(self.mass * self.velocity**2))

    @property
    def stress(self) -> Array:
        """Biot stress (elements, points, 3) of the last evaluation, squeeze guard left out."""
        return self._new.stress

    def area_ratio(self) -> Array:
        """Det U, the share of its area that a point keeps, of all points of the committed state."""
        e1, e2, e3 = np.moveaxis(self._old.strain, 2, 0)
        return np.asarray((1.0 + e1) * (1.0 + e2) - 0.25 * e3**2)

    def largest_strain(self) -> float:
        """Largest principal nominal strain (magnitude) of the committed state."""
        e1, e2, e3 = np.moveaxis(self._old.strain, 2, 0)
        centre, radius = 0.5 * (e1 + e2), np.hypot(0.5 * (e1 - e2), 0.5 * e3)
        return float(np.max(np.abs(centre) + radius))

    def segment_shear(self) -> tuple[float, float]:
        """Shear force of the segments below and above the hit section, committed, in N.

        The part of the reaction of its end across the chord of the deformed segment: at rest that
        is the force in all of its sections, in motion that of its end.
        """
        mesh, u = self.mesh, self.supports.expand(self.displacement)
        shears = []
        for end, length in ((mesh.base, mesh.lengths[0]), (mesh.head, -mesh.lengths[1])):
            across, along = self.force[end[0]].sum(), self.force[end[1]].sum()
            dx = u[mesh.hit[0]].mean() - u[end[0]].mean()
            dy = length + u[mesh.hit[1]].mean() - u[end[1]].mean()
            shears.append(float((across * dy - along * dx) / np.hypot(dx, dy)))
        return shears[0], shears[1]


def solid_column(
    column: Column,
    smallest: float | None = None,
    refinement: int = 0,
    hardening_ratio: float = 1e-6,
) -> SolidAssembly:
    """The solid of a column with its mass, before any load; arguments as of `solid_mesh`.

    End plates turn about their centroid, so that the mass of every unknown is constant: a plate has
    the inertia sum m X^2, and what couples its turn to the displacement of the head sums to zero.
    """
    mesh = solid_mesh(column, smallest, refinement)
    supports = supports_of(mesh, column.base, column.head)
    nodal = nodal_mass(mesh, column)
    mass = np.asarray(supports.tied.T @ nodal)
    for plate in supports.plates:
        mass[plate.turn] = nodal[plate.vertical] @ plate.places**2
    mass[supports.head] += column.head_mass
    mass[supports.hit] += column.attached_mass
    return SolidAssembly(mesh, supports, column.steel, hardening_ratio, mass)


def nodal_mass(mesh: SolidMesh, column: Column) -> Array:
    """Mass at every dof of the mesh (dofs,), in kg: that of the column, spread over its mesh.

    It stands at the nodes by the quadrature rule that samples there, Simpson's, whose weights are
    all positive.
    """
    density = column.properties.mass_per_length / mesh.area
    mass = np.zeros(mesh.size)
    shares = density * mesh.weights.sum(1)[:, None] * np.repeat(SIMPSON, 2)
    np.add.at(mass, mesh.dofs, shares)
    return mass
