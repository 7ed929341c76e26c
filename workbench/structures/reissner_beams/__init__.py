"""Geometrically exact beams (Reissner, Simo) with fiber sections, all in one group."""

from typing import Any, ClassVar, NamedTuple

import numpy as np

from workbench.arrays import Array
from workbench.structures.fibers import FiberElements
from workbench.structures.reissner_beams import kernels


class BeamState(NamedTuple):
    """State of all elements: `fibers` (e, states, f); `stress` (e, 3) N, V, M; `strain` (e, 3)."""

    fibers: Array
    stress: Array
    strain: Array


class ReissnerBeams(FiberElements):
    """Two-node geometrically exact beams with one point; arguments those of `FiberElements`."""

    kernels: ClassVar[Any] = kernels
    crumples: ClassVar[bool] = False  # a short one may shorten by more than its length
    _old: BeamState

    def _rest(self, count: int, states: int, fibers: int) -> BeamState:
        stress, strain = np.zeros((2, count, 3))
        return BeamState(np.zeros((count, states, fibers)), stress, strain)

    @property
    def section_forces(self) -> Array:
        """Committed N, V, M of the elements (elements, 3)."""
        return self._old.stress

    @property
    def local_forces(self) -> Array:
        """Committed N and end moments M1, M2 (elements, 3); internal moments are -M1 and M2."""
        force, strain = self._old.stress, self._old.strain
        N, V, M = force.T
        mean = 0.5 * self.lengths * (N * strain[:, 1] - V * (1.0 + strain[:, 0]))
        return np.stack([N, mean - M, mean + M], axis=1)

    @property
    def elongations(self) -> Array:
        """Committed change of length of the axis of the elements (elements,), in m."""
        return np.asarray(self._old.strain[:, 0] * self.lengths)

    @property
    def shear_forces(self) -> Array:
        """Committed shear force of the elements (elements,), in N."""
        return self._old.stress[:, 1]

    @property
    def shear_strains(self) -> Array:
        """Committed shear strain of the elements (elements,)."""
        return self._old.strain[:, 1]

    @property
    def plastic_strains(self) -> Array:
        """Committed plastic strains (elements, fibers), the first state of every law."""
        return self._old.fibers[:, 0]
