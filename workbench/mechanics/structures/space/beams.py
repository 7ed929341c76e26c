"""Structures in space, and their co-rotational fiber beams, all elements in one group.

Nodes turn by Cayley vectors: over a step the displacements of their rotations are such a vector,
and what has added up is the time integral of the spin, of which only differences count. Their
rotary inertia is the same about every axis, so that spins have no gyroscopic term.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array
from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.elements import Bars
from workbench.mechanics.structures.fibers.section import (
    BeamSection,
    FiberElements,
    Points,
    SectionTables,
    gauss_rule,
)
from workbench.mechanics.structures.space import beam_kernels


class SpaceAssembly(PlanarAssembly):
    """A structure in space: nodes with u, v, w and turns about x, y, z (that about z: rotation)."""

    components: ClassVar[dict[str, int]] = {
        **{"u": 0, "v": 1, "w": 2},
        **{"turn_x": 3, "turn_y": 4, "rotation": 5},
    }
    axes: ClassVar[int] = 3


@dataclass(frozen=True, kw_only=True)
class SpaceSection(BeamSection):
    """Fibers of a section in both directions: `y` along its height, `z` (f,) along its width, in m.

    Beside those of `BeamSection`, whose law must be linear: `torsion`, G I_t in N m2.
    """

    z: Array
    torsion: float


class SpaceTables(NamedTuple):
    """Sections as arrays for the kernels: those in the `plane`, `z` (s, f), `torsion` (s,)."""

    plane: SectionTables
    z: Array
    torsion: Array


class SpaceState(NamedTuple):
    """State of all elements in space.

    `triads` (e, 2, 3, 3) of the nodes, the element's axes at rest turned with them; `chord` (e, 3)
    in m; `deformation` (e, 7) and `forces` (e, 7) of a step, see `frame_kernels`; `fibers` (e,
    points, states, f).
    """

    triads: Array
    chord: Array
    deformation: Array
    forces: Array
    fibers: Array


class SpaceBeams(FiberElements):
    """Two-node co-rotational Bernoulli beams in space, rigid in shear.

    Arguments: those of `FiberElements`; `heights` (elements, 3), directions next to the height of
    each section; `rule`, points along each element (default: two Gauss points); `axes` (elements,
    2, 3, 3), those of the dofs of both nodes as rows (default: the global ones).
    """

    kernels: Any = beam_kernels
    _old: SpaceState

    def __init__(
        self,
        nodes: ArrayLike,
        section_of: ArrayLike,
        sections: Sequence[SpaceSection],
        heights: ArrayLike,
        rule: Points | None = None,
        axes: ArrayLike | None = None,
    ) -> None:
        xi, weights, _ = gauss_rule() if rule is None else rule
        count = len(np.atleast_1d(section_of))
        shape = count, len(xi)
        self._points = Points(*(np.broadcast_to(each, shape).copy() for each in (xi, weights)))
        self._heights = np.broadcast_to(np.asarray(heights, dtype=float), (count, 3))
        given = np.eye(3) if axes is None else np.asarray(axes, dtype=float)
        self._axes = np.broadcast_to(given, (count, 2, 3, 3)).copy()
        super().__init__(nodes, section_of, sections)
        z = np.zeros_like(self._sections.y)
        for row, section in zip(z, sections, strict=True):
            row[: len(section.z)] = section.z
        twist = np.array([section.torsion for section in sections])
        self.tables = self._points, SpaceTables(self._sections, z, twist), self._axes

    def _at_rest(self, count: int, fibers: tuple[int, int]) -> SpaceState:
        points = self._points.xi.shape[1]
        return SpaceState(
            np.zeros((count, 2, 3, 3)),
            np.zeros((count, 3)),
            np.zeros((count, 7)),
            np.zeros((count, 7)),
            np.zeros((count, points, *fibers)),
        )

    def place(self, bars: Bars) -> None:
        """Take its place in a structure; triads at rest have the chord as first axis."""
        super().place(bars)
        along = bars.chords / bars.lengths[:, None]
        across = np.cross(along, self._heights)
        across /= np.linalg.norm(across, axis=1)[:, None]
        triads = np.stack([along, np.cross(across, along), across], axis=2)
        self._old.triads[:] = triads[:, None]
        self._old.chord[:] = bars.chords
        self.rest = triads

    @property
    def elongations(self) -> Array:
        """Committed change of chord length of the elements (elements,), in m."""
        return self._old.deformation[:, 0]

    @property
    def forces(self) -> Array:
        """Committed N, and moments about the axes of the element at both ends (elements, 7)."""
        return self._old.forces

    @property
    def plastic_strains(self) -> Array:
        """Committed plastic strains (elements, fibers), the mean along each element."""
        weights = self._points.weights[:, :, None]
        return np.asarray(np.sum(weights * self._old.fibers[:, :, 0], axis=1))

    @property
    def shear_strains(self) -> Array:
        """Shear strain of the elements (elements,): none."""
        return np.zeros(len(self.nodes))
