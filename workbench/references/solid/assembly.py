"""The discretised column with its state: residual, tangent, energies, commit."""

import numpy as np
from scipy.sparse import coo_array, csc_array, diags_array
from scipy.sparse.linalg import splu

from workbench.arrays import Array, Indices
from workbench.materials import POISSON_RATIO, Steel
from workbench.references.solid.kernels import Elements, Energies, empty_state, respond
from workbench.references.solid.material import SolidSteel
from workbench.references.solid.mesh import SolidMesh
from workbench.references.solid.supports import Supports


class SolidAssembly:
    """Equilibrium of the solid in the unknowns q of its supports.

    Arguments: `mesh`; `supports`; `steel`; `hardening_ratio`, isotropic hardening modulus over
    Young's modulus. Public state: `q` (unknowns,), committed; `load` on the head along y and
    `spring` (stiffness and unstressed position of the head), in N, N/m and m; `squash_load` and
    `round_off` of forces in N; of the last evaluation internal forces `force` (dofs,) and
    `tangent` (unknowns, unknowns); `dissipated`, plastic work so far, in J.
    """

    def __init__(
        self, mesh: SolidMesh, supports: Supports, steel: Steel, hardening_ratio: float
    ) -> None:
        self.mesh, self.supports = mesh, supports
        modulus = steel.elastic_modulus
        self.steel = SolidSteel(
            modulus, POISSON_RATIO, steel.yield_stress, hardening_ratio * modulus
        )
        self.hardening_ratio = hardening_ratio
        self.squash_load = steel.yield_stress * mesh.area
        # strain is a difference of numbers near 1
        self.round_off = 8.0 * np.finfo(float).eps * modulus * mesh.area
        self.q = np.zeros(supports.unknowns)
        self.load, self.spring = 0.0, (0.0, 0.0)
        self.force = np.zeros(mesh.size)
        self.tangent = csc_array((supports.unknowns, supports.unknowns))
        self.dissipated = 0.0
        self.elements = Elements(mesh.gradients, mesh.weights, mesh.dofs)
        self._old, self._new = empty_state(self.elements), empty_state(self.elements)
        self._matrices = np.empty((len(mesh.dofs), mesh.dofs.shape[1], mesh.dofs.shape[1]))
        self._energies = Energies(0.0, 0.0)

    def residual(self, q: Array, tangent: bool = True) -> Array:
        """Out-of-balance forces (unknowns,) at q; all NaN where the material has no answer.

        Prepares the tangent, if it is wanted. The unknowns that are imposed carry their reactions.
        """
        mesh, supports = self.mesh, self.supports
        self.force = np.zeros(mesh.size)
        matrices = self._matrices if tangent else self._matrices[:0]
        u = supports.expand(q)
        self._energies = respond(
            self.elements, u, self._old, self._new, self.steel, self.force, matrices
        )
        if np.isnan(self._energies.stored):
            return np.full(supports.unknowns, np.nan)
        spring, unstressed = self.spring
        residual = supports.gather(q, self.force)
        residual[supports.head] += spring * (q[supports.head] - unstressed) - self.load
        if tangent:
            rows = np.repeat(mesh.dofs, mesh.dofs.shape[1], axis=1).ravel()
            places = rows, np.tile(mesh.dofs, (1, mesh.dofs.shape[1])).ravel()
            stiffness = coo_array((matrices.ravel(), places), shape=(mesh.size, mesh.size)).tocsr()
            derivative = supports.derivative(q)
            diagonal = supports.curvature(q, self.force)
            diagonal[supports.head] += spring
            self.tangent = (derivative.T @ stiffness @ derivative + diags_array(diagonal)).tocsc()
        return residual

    def solve(self, right: Array, held: Indices) -> Array | None:
        """Tangent^-1 times `right` with the unknowns `held` kept; None if it is singular."""
        free = np.delete(np.arange(len(self.q)), held)
        try:
            factors = splu(
                self.tangent[free][:, free],
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.01,
                options={"SymmetricMode": True},
            )
        except RuntimeError:  # exactly singular
            return None
        solution = np.zeros(len(self.q))
        solution[free] = factors.solve(right[free])
        return solution if np.all(np.isfinite(solution)) else None

    @property
    def stress(self) -> Array:
        """Biot stress (elements, points, 3) of the last evaluation, squeeze guard left out."""
        return self._new.stress

    @property
    def plastic_work(self) -> float:
        """Plastic work of the step to the last evaluation, in J."""
        return self._energies.plastic

    def commit(self, q: Array) -> None:
        """Accept the state of the last evaluation, which was at q."""
        self.dissipated += self.plastic_work
        self.q = q.copy()
        self._old, self._new = self._new, self._old

    def stored(self, q: Array | None = None) -> float:
        """Elastic energy at the last evaluation, spring and squeeze guard included, in J.

        It was at `q` (None: the committed unknowns).
        """
        stiffness, unstressed = self.spring
        pulled = (self.q if q is None else q)[self.supports.head] - unstressed
        return self._energies.stored + 0.5 * stiffness * float(pulled) ** 2

    def area_ratio(self) -> Array:
        """Det U, the share of its area that a point keeps, of all points of the committed state."""
        e1, e2, e3 = np.moveaxis(self._old.strain, 2, 0)
        return np.asarray((1.0 + e1) * (1.0 + e2) - 0.25 * e3**2)

    def largest_strain(self) -> float:
        """Largest principal nominal strain (magnitude) of the committed state."""
        e1, e2, e3 = np.moveaxis(self._old.strain, 2, 0)
        centre, radius = 0.5 * (e1 + e2), np.hypot(0.5 * (e1 - e2), 0.5 * e3)
        return float(np.max(np.abs(centre) + radius))
