"""Beams with fiber sections, all elements of a structure in one group.

Two local laws: the co-rotational Bernoulli beam, and the geometrically exact beam (Reissner, Simo).
"""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array
from workbench.mechanics.structures.elements import ElementGroup
from workbench.mechanics.structures.fibers import bernoulli_kernels, reissner_kernels
from workbench.mechanics.structures.fibers.section import BeamSection, section_tables


class FiberElements(ElementGroup):
    """Beams with fiber sections.

    Arguments: `nodes` (elements, 2), node numbers; `section_of` (elements,), which of `sections`
    each element has; `sections`.
    """

    def __init__(
        self, nodes: ArrayLike, section_of: ArrayLike, sections: Sequence[BeamSection]
    ) -> None:
        of = np.asarray(section_of, dtype=np.int64)
        self.sections, self._sections = tuple(sections), section_tables(of, sections)
        self.tables = (self._sections,)
        states = max(section.law.states for section in sections)
        state = self._at_rest(len(of), (states, self._sections.y.shape[1]))
        mass = np.array([section.mass_per_length for section in sections])[of]
        radius_squared = np.array([section.radius_squared for section in sections])[of]
        super().__init__(nodes, state, mass, radius_squared)

    @abstractmethod
    def _at_rest(self, count: int, fibers: tuple[int, int]) -> Any:
        """State of so many elements at rest, `fibers` (states, fibers) at each point."""

    @property
    @abstractmethod
    def shear_strains(self) -> Array:
        """Committed shear strain of the elements (elements,)."""

    @property
    @abstractmethod
    def plastic_strains(self) -> Array:
        """Committed plastic strains (elements, fibers), the mean along each element."""

    def plastic_rotations(self) -> Array:
        """Committed plastic curvature integrated over each element (elements,), in rad.

        That of a section is -sum(eps_p y A) / sum(y^2 A): what bends it when its stresses are
        removed.
        """
        tables = self._sections
        lever = (tables.y * tables.area / tables.second[:, None])[tables.of]
        return np.asarray(-self.lengths * np.sum(self.plastic_strains * lever, axis=1))


class Points(NamedTuple):
    """Quadrature along the elements: `xi` in 0..1 and `weights`, (elements, points).

    Also (points,), the same in all. `spread` of the axial strain over the points of balanced
    elements, else zero.
    """

    xi: Array
    weights: Array
    spread: Array | float = 0.0


def gauss_rule(points: int = 2) -> Points:
    """Gauss-Legendre points, alike in every element."""
    abscissae, weights = np.polynomial.legendre.leggauss(points)
    return Points(0.5 * (1.0 + abscissae), 0.5 * weights)


def radau_rule(hinge_at_end: ArrayLike) -> Points:
    """Two Gauss-Radau points: one at the end where a hinge is expected, one a third from the other.

    Argument: `hinge_at_end` (elements,), True for end 2, False for end 1. Elastic stiffness is
    exact as with two Gauss points, and the plastic section is sampled where the moment is
    largest, so that the moment capacity at that end has no error of the order of the length.
    """
    at_end = np.asarray(hinge_at_end, dtype=bool)[:, None]
    abscissae = np.where(at_end, [[1.0 / 3.0, 1.0]], [[0.0, 2.0 / 3.0]])
    weights = np.where(at_end, [[0.75, 0.25]], [[0.25, 0.75]])
    return Points(abscissae, weights)


class FiberState(NamedTuple):
    """State of all co-rotational elements.

    `fibers` (e, points, states, f); `local` (e, 3): N, M1, M2; `inner` (e, 5): elongation, bending
    rotations, shear strain, axial amplitude.
    """

    fibers: Array
    local: Array
    inner: Array


class FiberBeams(FiberElements):
    """Two-node co-rotational Bernoulli beams.

    Arguments: those of `FiberElements` (sections without laws that yield in shear); `rule`,
    points along each element (default: two Gauss points); `balanced`: the axial strain differs
    between the two points such that N is the same (without it the axial displacement is linear, as
    in the classical displacement-based element).
    """

    kernels: Any = bernoulli_kernels
    _old: FiberState

    def __init__(
        self,
        nodes: ArrayLike,
        section_of: ArrayLike,
        sections: Sequence[BeamSection],
        rule: Points | None = None,
        balanced: bool = False,
    ) -> None:
        xi, weights, _ = gauss_rule() if rule is None else rule
        if balanced and weights.shape[-1] != 2:
            raise ValueError("the axial force can be balanced between two points only")
        # no mean: sum(w spread) = 0
        spread = weights[..., ::-1] * [1.0, -1.0] if balanced else np.zeros_like(weights)
        shape = len(np.atleast_1d(section_of)), weights.shape[-1]
        every = (np.broadcast_to(each, shape).copy() for each in (xi, weights, spread))
        self._points = Points(*every)
        super().__init__(nodes, section_of, sections)
        self.tables = self._points, self._sections

    def _at_rest(self, count: int, fibers: tuple[int, int]) -> FiberState:
        points = self._points.xi.shape[1]
        return FiberState(
            np.zeros((count, points, *fibers)), np.zeros((count, 3)), np.zeros((count, 5))
        )

    @property
    def elongations(self) -> Array:
        """Committed change of chord length of the elements (elements,), in m."""
        return self._old.inner[:, 0]

    @property
    def shear_strains(self) -> Array:
        """Committed elastic shear strain of the elements (elements,)."""
        return self._old.inner[:, 3]

    @property
    def plastic_strains(self) -> Array:
        """Committed plastic strains (elements, fibers), the mean along each element."""
        weights = self._points.weights[:, :, None]
        return np.asarray(np.sum(weights * self._old.fibers[:, :, 0], axis=1))


class BeamState(NamedTuple):
    """State of exact beams: `fibers` (e, states, f); `stress` N, V, M and `strain` (e, 3)."""

    fibers: Array
    stress: Array
    strain: Array


class ReissnerBeams(FiberElements):
    """Two-node geometrically exact beams with one point; arguments those of `FiberElements`."""

    kernels: Any = reissner_kernels
    crumples: ClassVar[bool] = False  # a short one may shorten by more than its length
    _old: BeamState

    def _at_rest(self, count: int, fibers: tuple[int, int]) -> BeamState:
        return BeamState(np.zeros((count, *fibers)), *np.zeros((2, count, 3)))

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
