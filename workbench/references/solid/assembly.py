"""The discretised column with its state: residual, tangent, energies, commit."""

import numpy as np
from scipy.sparse import coo_array, csc_array, diags_array
from scipy.sparse.linalg import splu

from workbench.arrays import Array, Indices
from workbench.materials import POISSON_RATIO, Steel
from workbench.references.solid.material import (
    SQUEEZE_STIFFNESS,
    SQUEEZED,
    SolidSteel,
    State,
    respond_to,
)
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
        tensor = np.zeros((3, *mesh.weights.shape))
        self._old = self._new = State(tensor, tensor[0], tensor)
        self._strain = tensor

    def residual(self, q: Array) -> Array:
        """Out-of-balance forces (unknowns,) at q; all NaN where the material has no answer.

        Prepares the tangent. The unknowns that are imposed carry their reactions.
        """
        mesh, supports = self.mesh, self.supports
        F = np.einsum("egad,ed->aeg", mesh.gradients, supports.expand(q)[mesh.dofs])
        F[[0, 3]] += 1.0
        found = respond_to(F, self._old, self.steel)
        if found is None:
            return np.full(supports.unknowns, np.nan)
        self._strain, self._new = found.strain, found.state
        weighted = mesh.gradients * mesh.weights[:, :, None, None]
        forces = np.einsum("egad,aeg->ed", weighted, found.nominal)
        self.force = np.zeros(mesh.size)
        np.add.at(self.force, mesh.dofs, forces)
        # of each element G' A G, gradients of all its points in one column
        elements, _, _, nodal = weighted.shape
        stiff = np.einsum("abeg,egbd->egad", found.tangent, weighted)
        columns = mesh.gradients.reshape(elements, -1, nodal)
        matrices = columns.transpose(0, 2, 1) @ stiff.reshape(columns.shape)
        rows = np.repeat(mesh.dofs, nodal, axis=1).ravel()
        places = rows, np.tile(mesh.dofs, (1, nodal)).ravel()
        stiffness = coo_array((matrices.ravel(), places), shape=(mesh.size, mesh.size)).tocsr()
        derivative = supports.derivative(q)
        spring, unstressed = self.spring
        diagonal = supports.curvature(q, self.force)
        diagonal[supports.head] += spring
        self.tangent = (derivative.T @ stiffness @ derivative + diags_array(diagonal)).tocsc()
        residual = np.asarray(derivative.T @ self.force)
        residual[supports.head] += spring * (q[supports.head] - unstressed) - self.load
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
        """Biot stress (3, elements, points) of the last evaluation, squeeze guard left out."""
        return self._new.stress

    def commit(self, q: Array) -> None:
        """Accept the state of the last evaluation, which was at q."""
        plastic_step = self._new.plastic - self._old.plastic
        mean = 0.5 * (self._old.stress + self._new.stress)
        self.dissipated += self._integrate(np.sum(mean * plastic_step, axis=0))
        self.q = q.copy()
        self._old = self._new

    def stored(self) -> float:
        """Elastic energy of the committed state, spring and squeeze guard included, in J."""
        modulus = self.steel.modulus
        t1, t2, t3 = self._old.stress
        density = 0.5 / modulus * (t1**2 + t2**2 - 2 * POISSON_RATIO * t1 * t2)
        density += (1.0 + POISSON_RATIO) / modulus * t3**2
        squeezed = np.maximum(np.log(SQUEEZED / self.area_ratio()), 0.0)
        density += 0.5 * SQUEEZE_STIFFNESS * modulus * squeezed**2
        stiffness, unstressed = self.spring
        pulled = self.q[self.supports.head] - unstressed
        return self._integrate(density) + 0.5 * stiffness * float(pulled) ** 2

    def area_ratio(self) -> Array:
        """Det U, the share of its area that a point keeps, of all points at the last evaluation."""
        e1, e2, e3 = self._strain
        return np.asarray((1.0 + e1) * (1.0 + e2) - 0.25 * e3**2)

    def largest_strain(self) -> float:
        """Largest principal nominal strain (magnitude) of the last evaluation."""
        e1, e2, e3 = self._strain
        centre, radius = 0.5 * (e1 + e2), np.hypot(0.5 * (e1 - e2), 0.5 * e3)
        return float(np.max(np.abs(centre) + radius))

    def _integrate(self, density: Array) -> float:
        return float(np.sum(self.mesh.weights * density))
