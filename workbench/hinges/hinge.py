"""Generalized elasto-plastic hinge: axial and rotational spring with one N-M yield surface."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array
from workbench.errors import InputError
from workbench.hinges import kernels
from workbench.hinges.surface import YieldSurface


@dataclass(frozen=True)
class HingeUpdate:
    """Result of one return mapping.

    `forces` (N, M_1, ...) in N and N m; `plastic` plastic elongation (m) and rotations (rad);
    `tangent` of the forces with respect to the total deformations; `branch` of the projection:
    elastic, curve, corner, apex, smooth-apex or axis.
    """

    forces: Array
    plastic: Array
    tangent: Array
    branch: str


_BRANCHES = ("elastic", "curve", "corner", "apex", "smooth-apex", "axis")


@dataclass(frozen=True)
class GeneralizedHinge:
    """Hinge, or rigid bar with two hinges that share the axial force (series assembly).

    Arguments: `surface`; `axial_stiffness` in N/m (of the whole series); `rotational_stiffness`
    in N m/rad, one of each hinge (0: that hinge is a pin). Raises `InputError`.
    Source: Heng 2017, section 2.3; closest-point form of the backward-Euler step.
    """

    surface: YieldSurface
    axial_stiffness: float
    rotational_stiffness: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.rotational_stiffness) not in (1, 2):
            reason = "must have one entry of one hinge or two of two hinges"
            raise InputError("hinge.rotational_stiffness", self.rotational_stiffness, reason)
        for name, values in (
            ("axial_stiffness", (self.axial_stiffness,)),
            ("rotational_stiffness", self.rotational_stiffness),
        ):
            for value in values:
                positive = value > 0.0 or (value == 0.0 and name.startswith("rot"))
                if not (np.isfinite(value) and positive):
                    raise InputError(f"hinge.{name}", value, "must be positive and finite")

    def return_mapping(self, deformation: ArrayLike, plastic: ArrayLike) -> HingeUpdate:
        """Backward-Euler step from committed `plastic` to total `deformation`.

        Both are arrays (1 + hinges,): elongation in m, rotations in rad. The result has
        admissible forces for any finite input, however far outside the surface.
        """
        total, old = np.asarray(deformation, float), np.asarray(plastic, float)
        stiffness = np.array([self.axial_stiffness, *self.rotational_stiffness])
        if total.shape != stiffness.shape or old.shape != stiffness.shape:
            raise InputError("hinge.deformation", total.shape, f"must have shape {stiffness.shape}")
        if not (np.all(np.isfinite(total)) and np.all(np.isfinite(old))):
            raise InputError("hinge.deformation", total.tolist(), "must be finite")
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
        return HingeUpdate(forces, new, tangent, _BRANCHES[branch])
