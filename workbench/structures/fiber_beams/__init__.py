"""Co-rotational Bernoulli beams with fiber sections: all elements of a structure in one group."""

from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array
from workbench.structures.fiber_beams import kernels
from workbench.structures.fibers import BeamSection, FiberElements, lobatto


class Points(NamedTuple):
    """Quadrature along the elements, (elements, points): `xi` in 0..1 and `weights`.

    `spread` of the axial strain over the points of balanced elements, else zero.
    """

    xi: Array
    weights: Array
    spread: Array | float = 0.0


def gauss_rule(elements: int, points: int = 2) -> Points:
    """The same Gauss-Legendre points in every element."""
    abscissae, weights = np.polynomial.legendre.leggauss(points)
    tile = (elements, 1)
    return Points(np.tile(0.5 * (1.0 + abscissae), tile), np.tile(0.5 * weights, tile))


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


def lobatto_points(elements: int, points: int = 4) -> Points:
    """The same Gauss-Lobatto points in every element, both ends among them."""
    xi, weights = lobatto(points)
    return Points(np.tile(xi, (elements, 1)), np.tile(weights, (elements, 1)))


class FiberState(NamedTuple):
    """State of all elements.

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

    kernels: ClassVar[Any] = kernels
    _old: FiberState

    def __init__(
        self,
        nodes: ArrayLike,
        section_of: ArrayLike,
        sections: Sequence[BeamSection],
        rule: Points | None = None,
        balanced: bool = False,
    ) -> None:
        rule = gauss_rule(len(np.atleast_1d(section_of))) if rule is None else rule
        spread = np.zeros_like(rule.weights)
        if balanced:
            if rule.weights.shape[1] != 2:
                raise ValueError("the axial force can be balanced between two points only")
            # no mean: sum(w spread) = 0
            spread = rule.weights[:, ::-1] * np.array([1.0, -1.0])
        self._points = rule._replace(spread=spread)
        super().__init__(nodes, section_of, sections)

    def _rest(self, count: int, states: int, fibers: int) -> FiberState:
        points = self._points.xi.shape[1]
        fiber_states = np.zeros((count, points, states, fibers))
        return FiberState(fiber_states, np.zeros((count, 3)), np.zeros((count, 5)))

    @property
    def tables(self) -> tuple[Any, ...]:
        """What the kernels take besides bars and states: points and sections."""
        return self._points, self._sections

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
