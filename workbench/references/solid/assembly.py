"""The discretised column with its state: residual, tangent, energies, commit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from workbench.materials import Steel
from workbench.references.solid import _kernels
from workbench.references.solid.mesh import SolidMesh
from workbench.references.solid.supports import Pattern, Supports, gathered

Array = NDArray[np.float64]

POISSON = 0.3


class SolidAssembly:
    """Equilibrium of the solid in the unknowns q of its supports.

    Arguments: `mesh`; `supports`; `steel`; `hardening_ratio`, isotropic hardening modulus over
    Young's modulus. Public state: `q` (unknowns,), committed; `load` on the head along y and
    `spring` (stiffness and unstressed position of the head), in N, N/m and m; `squash_load` and
    `round_off` of forces in N; `force` (size,), internal forces of the last evaluation;
    `dissipated`, plastic work so far, in J.
    """

    def __init__(
        self, mesh: SolidMesh, supports: Supports, steel: Steel, hardening_ratio: float
    ) -> None:
        self.mesh, self.supports = mesh, supports
        modulus = steel.elastic_modulus
        self.steel = np.array([modulus, POISSON, steel.yield_stress, hardening_ratio * modulus])
        self.hardening_ratio = hardening_ratio
        self.squash_load = steel.yield_stress * mesh.area
        # strain is a difference of numbers near 1
        self.round_off = 8.0 * np.finfo(float).eps * modulus * mesh.area
        self.pattern = Pattern.of(mesh.dofs, supports)
        elements, points = mesh.weights.shape
        nodal = mesh.dofs.shape[1]
        self.q = np.zeros(supports.unknowns)
        self.load, self.spring = 0.0, (0.0, 0.0)
        self.force = np.zeros(mesh.size)
        self.dissipated = 0.0
        tensor = (elements, points, 3)
        self._tables = _kernels.Tables(mesh.gradients, mesh.weights, mesh.dofs)
        self._old, self._new = (
            _kernels.State(np.zeros(tensor), np.zeros(tensor[:2]), np.zeros(tensor))
            for _ in range(2)
        )
        self._strain = np.zeros(tensor)
        self._element_force = np.zeros((elements, nodal))
        self._element_stiffness = np.zeros((elements, nodal, nodal))
        self._data = np.zeros(0)

    def residual(self, q: Array) -> Array:
        """Out-of-balance forces (unknowns,) at q; all NaN where the material has no answer.

        Prepares the tangent. The unknowns that are imposed carry their reactions.
        """
        mesh, supports = self.mesh, self.supports
        possible = _kernels.elements(
            *(self._tables, supports.expand(q), self.steel, self._old, self._new),
            *(self._strain, self._element_force, self._element_stiffness),
        )
        if not possible:
            return np.full(supports.unknowns, np.nan)
        self.force = gathered(mesh.dofs.ravel(), self._element_force.ravel(), mesh.size)
        derivative = supports.derivative(q)
        pulled = derivative * self.force[supports.rows]
        residual = gathered(supports.columns, pulled, supports.unknowns)
        stiffness, unstressed = self.spring
        residual[supports.head] += stiffness * (q[supports.head] - unstressed) - self.load
        self._data = self.pattern.assemble(self._element_stiffness, derivative)
        diagonal = self.pattern.diagonal
        self._data[diagonal[supports.head]] += stiffness
        for unknown, value in supports.curvature(q, self.force):
            self._data[diagonal[unknown]] += value
        return residual

    def tangent_times(self, vector: Array) -> Array:
        """The tangent prepared last times a vector (unknowns,)."""
        return np.asarray(self.pattern.matrix(self._data) @ vector)

    def solve(self, right: Array, held: NDArray[np.int64]) -> Array | None:
        """Tangent^-1 times `right` with the unknowns `held` kept; None if it is singular."""
        pattern, data = self.pattern, self._data.copy()
        fixed = np.zeros(len(self.q), dtype=bool)
        fixed[held] = True
        data[fixed[pattern.indices] | fixed[pattern.columns]] = 0.0
        data[pattern.diagonal[held]] = 1.0
        right = np.where(fixed, 0.0, right)
        try:
            factors = splu(
                pattern.matrix(data),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.01,
                options={"SymmetricMode": True},
            )
        except RuntimeError:  # exactly singular
            return None
        solution: Array = factors.solve(right)
        return solution if np.all(np.isfinite(solution)) else None

    @property
    def stress(self) -> Array:
        """Biot stress (elements, points, 3) of the last evaluation, squeeze guard left out."""
        return np.asarray(self._new.stress)

    def commit(self, q: Array) -> None:
        """Accept the state of the last evaluation, which was at q."""
        plastic_step = self._new.plastic - self._old.plastic
        mean = 0.5 * (self._old.stress + self._new.stress)
        self.dissipated += self._integrate(np.sum(mean * plastic_step, axis=2))
        self.q = q.copy()
        self._old, self._new = self._new, self._old

    def stored(self) -> float:
        """Elastic energy of the committed state, spring and squeeze guard included, in J."""
        modulus = self.steel[0]
        t1, t2, t3 = np.moveaxis(self._old.stress, 2, 0)
        density = 0.5 / modulus * (t1**2 + t2**2 - 2 * POISSON * t1 * t2)
        density += (1.0 + POISSON) / modulus * t3**2
        squeezed = np.maximum(np.log(_kernels.SQUEEZED / self._area_ratio()), 0.0)
        density += 0.5 * _kernels.SQUEEZE_STIFFNESS * modulus * squeezed**2
        stiffness, unstressed = self.spring
        pulled = self.q[self.supports.head] - unstressed
        return self._integrate(density) + 0.5 * stiffness * float(pulled) ** 2

    def _area_ratio(self) -> Array:
        """Det U of all points at the last evaluation."""
        e1, e2, e3 = np.moveaxis(self._strain, 2, 0)
        return np.asarray((1.0 + e1) * (1.0 + e2) - 0.25 * e3**2)

    def least_area_ratio(self) -> float:
        """Smallest share of its area that a point keeps in the last evaluation."""
        return float(np.min(self._area_ratio()))

    def largest_strain(self) -> float:
        """Largest principal nominal strain (magnitude) of the last evaluation."""
        e1, e2, e3 = np.moveaxis(self._strain, 2, 0)
        centre, radius = 0.5 * (e1 + e2), np.hypot(0.5 * (e1 - e2), 0.5 * e3)
        return float(np.max(np.abs(centre) + radius))

    def _integrate(self, density: Array) -> float:
        return float(np.sum(self.mesh.weights * density))
