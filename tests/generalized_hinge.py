"""One hinge, or a rigid bar with two, by the projection alone: the oracle of whole elements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.steel.hinges import YieldSurface, kernels

BRANCHES = ("elastic", "curve", "corner", "apex", "smooth-apex", "axis")


@dataclass(frozen=True)
class HingeUpdate:
    """Forces (N, M_1, ...), plastic deformations, tangent, and the branch of the projection."""

    forces: np.ndarray
    plastic: np.ndarray
    tangent: np.ndarray
    branch: str


@dataclass(frozen=True)
class GeneralizedHinge:
    """Hinge, or rigid bar with two hinges that share the axial force (series assembly).

    Arguments: `surface`; `axial_stiffness` in N/m (of the whole series); `rotational_stiffness`
    in N m/rad, one of each hinge (0: that hinge is a pin). Source: Heng 2017, section 2.2.
    """

    surface: YieldSurface
    axial_stiffness: float
    rotational_stiffness: tuple[float, ...]

    def return_mapping(self, deformation, plastic) -> HingeUpdate:
        """Backward-Euler step from committed `plastic` to total `deformation`, (1 + hinges,)."""
        total, old = np.asarray(deformation, float), np.asarray(plastic, float)
        stiffness = np.array([self.axial_stiffness, *self.rotational_stiffness])
        surface = self.surface
        trial, size = stiffness * (total - old), len(stiffness)
        branch, all_forces, entries, _ = kernels.project(
            tuple(np.append(stiffness, 0.0)[:3]),  # a pin beside one hinge
            (*surface.axial_bounds, *surface.moment_bounds),
            (surface.alpha, surface.beta),
            tuple(np.append(trial, 0.0)[:3]),
            kernels.ANYWHERE,
        )
        forces, tangent = np.array(all_forces[:size]), np.empty((3, 3))
        tangent[np.triu_indices(3)] = tangent.T[np.triu_indices(3)] = entries
        tangent = tangent[:size, :size]
        elastic = np.divide(forces, stiffness, out=total - old, where=stiffness > 0.0)
        new = old if branch == kernels.ELASTIC else total - elastic
        return HingeUpdate(forces, new, tangent, BRANCHES[branch])
