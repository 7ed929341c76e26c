"""Structures in space, and their co-rotational fiber beams, all elements in one group.

Nodes turn by Cayley vectors: over a step the displacements of their rotations are such a vector,
and what has added up is the time integral of the spin, of which only differences count. Their
rotary inertia is the same about every axis, so that spins have no gyroscopic term.
"""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array
from workbench.mechanics.structures.assembly import SPATIAL, PlanarAssembly
from workbench.mechanics.structures.elements import Bars, ElementGroup
from workbench.mechanics.structures.fibers.section import (
    BeamSection,
    FiberElements,
    Points,
    SectionTables,
    gauss_rule,
)
from workbench.mechanics.structures.space import beam_kernels
from workbench.steel.sections.section import (
    CircularTube,
    ISection,
    Rectangle,
    RectangularTube,
    Section,
    Shape,
)

FILLET = 0.2234  # of the root radius: distance of a fillet's centroid from both plates


class SpaceAssembly(PlanarAssembly):
    """A structure in space: nodes with u, v, w and turns about x, y, z (that about z: rotation)."""

    components: ClassVar[dict[str, int]] = SPATIAL
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


class SpaceElements(ElementGroup):
    """Geometry and assembly that two-node elements in space share, whatever their law.

    `_heights` (elements, 3), directions next to the height of each section, and `_axes` (elements,
    2, 3, 3), those of the dofs of both nodes as rows, see `_orient`. Forces are those of the last
    step at its weighted instant.
    """

    _old: Any

    def _orient(self, count: int, heights: ArrayLike, axes: ArrayLike | None) -> None:
        self._heights = np.broadcast_to(np.asarray(heights, dtype=float), (count, 3))
        given = np.eye(3) if axes is None else np.asarray(axes, dtype=float)
        self._axes: Array = np.broadcast_to(given, (count, 2, 3, 3)).copy()

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

    @abstractmethod
    def plastic_turns(self) -> Array:
        """Committed plastic turns about the height and the width of the section (elements, 2)."""

    def plastic_rotations(self) -> Array:
        """Committed plastic turn about the z axis of the structure (elements,)."""
        return np.asarray(np.sum(self.plastic_turns() * self.rest[:, 2, 1:], axis=-1))

    @property
    def elongations(self) -> Array:
        """Committed change of chord length of the elements (elements,), in m."""
        return np.asarray(self._old.deformation[..., 0])

    @property
    def section_forces(self) -> Array:
        """Committed N, and internal M_y and M_z at both ends (elements, 2, 3)."""
        Q = self._old.forces
        first, second = Q[..., [0, 2, 3]], Q[..., [0, 5, 6]]
        return np.stack([first * [1.0, -1.0, -1.0], second], axis=-2)

    @property
    def local_forces(self) -> Array:
        """Committed N and end moments about the z axis of the structure, by the axes at rest."""
        Q = self._old.forces
        ends = np.stack([Q[..., [2, 3]], Q[..., [5, 6]]], axis=-2)
        moments = np.einsum("...eni,ei->...en", ends, self.rest[:, 2, 1:])
        return np.concatenate([Q[..., :1], moments], axis=-1)

    @property
    def shear_forces(self) -> Array:
        """Committed shear force along the height of the section (elements,), in N."""
        Q = self._old.forces
        return np.asarray((Q[..., 3] + Q[..., 6]) / (self.lengths + self.elongations))


class SpaceBeams(SpaceElements, FiberElements):
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
        self._orient(count, heights, axes)
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

    def plastic_turns(self) -> Array:
        """Committed plastic curvature about both axes of the section, integrated (elements, 2)."""
        tables, strain = self.tables[1], self.lengths[:, None] * self.plastic_strains
        turns = []
        for lever in (tables.z, -tables.plane.y):
            weights = (
                lever * tables.plane.area / np.sum(lever**2 * tables.plane.area, axis=1)[:, None]
            )
            turns.append(np.sum(strain * weights[tables.plane.of], axis=1))
        return np.stack(turns, axis=1)

    @property
    def plastic_strains(self) -> Array:
        """Committed plastic strains (elements, fibers), the mean along each element."""
        weights = self._points.weights[:, :, None]
        return np.asarray(np.sum(weights * self._old.fibers[:, :, 0], axis=1))

    @property
    def shear_strains(self) -> Array:
        """Shear strain of the elements (elements,): none."""
        return np.zeros(len(self.nodes))


class SpaceFibers(NamedTuple):
    """Places `y` along the height and `z` along the width in m, and areas in m2, (f,) each."""

    y: Array
    z: Array
    area: Array


def space_fibers(section: Section, layers: int) -> SpaceFibers:
    """Cut the strips of `Section.fibers` across their width too.

    Arguments: `section`; even number of `layers` over the depth, and across flanges and solid
    sections. Plates that stand upright have two fibers across each; root fillets lie at the
    centroids of their areas; round tubes have two rings of twice as many.
    """
    shape = section.shape
    if isinstance(shape, CircularTube):
        return _rings(shape, 2 * layers)
    rows = []
    for group, z in zip(shape.layers(layers // 2), _across(shape, layers), strict=True):
        for y, area in zip(*group.strips(), strict=True):
            rows += [(side * y, place, area / len(z)) for side in (-1.0, 1.0) for place in z]
    return SpaceFibers(*np.transpose(rows))


def _across(shape: Shape, layers: int) -> list[Array]:
    """Places along the width of the fibers of each group of `Shape.layers`."""
    flange, pair = shape.width * ((np.arange(layers) + 0.5) / layers - 0.5), np.array([-1.0, 1.0])
    if isinstance(shape, Rectangle):
        return [flange]
    if isinstance(shape, RectangularTube):
        walls = np.add.outer(0.5 * (shape.width - shape.wall) * pair, 0.25 * shape.wall * pair)
        return [walls.ravel(), flange]
    assert isinstance(shape, ISection)
    fillets = [(0.5 * shape.web + FILLET * shape.fillet) * pair] if shape.fillet else []
    return [0.25 * shape.web * pair, flange, *fillets]


def _rings(shape: CircularTube, count: int) -> SpaceFibers:
    """Two rings of so many fibers of a round tube, at the centroids of their sectors."""
    edges = 0.5 * shape.diameter - shape.wall * np.array([0.0, 0.5, 1.0])
    area = np.pi / count * -np.diff(edges**2)
    first = 2.0 / 3.0 * np.sin(np.pi / count) * -np.diff(edges**3)
    angle = 2.0 * np.pi * (np.arange(count) + 0.5) / count
    y, z = (
        np.multiply.outer(first / area, each).ravel() for each in (np.cos(angle), np.sin(angle))
    )
    return SpaceFibers(y, z, np.repeat(area, count))
