"""The mesh of a column as folded plates, its supports, and what a striker meets of it.

The section's height runs along x, the way of a hit at 0 degrees; its width along y; the axis along
z. Plates stand in the middle planes of those of the section. Every node has six dofs, three
displacements and three rotations; supports tie them to independent unknowns, see `Supports` of the
solid, of which the last one here is U of the head.
"""

from itertools import pairwise
from math import cos, pi, sin
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from workbench.base.arrays import Array, Indices
from workbench.mechanics.structures.assembly import graded_lengths, halved
from workbench.models.references.shell.kernels import Shells
from workbench.models.references.solid.mesh import PlateMesh, Supports
from workbench.scenarios import Column
from workbench.steel.sections import AXES, ISection, RectangularTube, Section

HALF_FLANGE = 2  # elements of the coarsest mesh, of refinement -1
LARGEST = 2.0  # length along the axis over the least one
_GROWTH = 1.2
DIGITS = 12  # of places (m) across the column, so that those of two plates are the same
_SAMPLES = 2000  # of the pressure of a face
_ALONG = 1e-9  # cosine or sine of directions along the sides of the section


class Wall(NamedTuple):
    """A plate of a section: both edges (x, y) and its thickness in m, elements across it."""

    start: tuple[float, float]
    end: tuple[float, float]
    thickness: float
    elements: int


class ShellMesh(NamedTuple):
    """Tables of the folded plates in SI units.

    `place` (nodes, 3); `section`, `along` (nodes,): x and y in the straight section, and z; the
    `shells`, with the area of each element, `areas`; `smallest` side of an element.
    """

    place: Array
    section: Array
    along: Array
    shells: Shells
    areas: Array
    smallest: float


def walls_of(section: Section, refinement: int = 0) -> tuple[Wall, ...]:
    """Plates of an I section or rectangular tube, whose area is that of the section.

    The web runs from middle plane to middle plane; flanges are so thick that the area is right.
    """
    shape, times = section.shape, 2 ** (refinement + 1)
    upright, across = shape.plates
    box = across if isinstance(shape, RectangularTube) else 0.0
    high = round(0.5 * (shape.height - across), DIGITS)
    wide = round(0.5 * (shape.width - box), DIGITS)
    flange = (section.area - 2.0 * high * upright) / (4.0 * wide)
    flanges = 2 * HALF_FLANGE * times
    webs = max(2, 2 * round(HALF_FLANGE * high / wide)) * times
    edges = [(-high, -wide), (-high, wide), (high, -wide), (high, wide)]
    walls = [Wall(edges[0], edges[1], flange, flanges), Wall(edges[2], edges[3], flange, flanges)]
    if isinstance(shape, ISection):
        return (*walls, Wall((-high, 0.0), (high, 0.0), upright, webs))
    sides = [Wall(edges[k], edges[k + 2], 0.5 * upright, webs) for k in (0, 1)]
    return (*walls, *sides)


def shell_mesh(
    column: Column, refinement: int = 0, bow: float = 0.0, tilt: float = 0.0
) -> ShellMesh:
    """Mesh of a column of an I section or a rectangular tube.

    Arguments: `refinement`, how often all elements are halved, from -1 on; initial `bow` along the
    width of the section, over the length; `tilt`, by which the edges of flanges stand out of their
    planes, over the width, to and fro with half waves as long as the width.
    """
    section = column.strength_section.about("strong")
    walls = walls_of(section, refinement)
    lines: list[tuple[float, float]] = []
    strips, thickness = [], []
    for wall in walls:
        points = np.linspace(wall.start, wall.end, wall.elements + 1).round(DIGITS).tolist()
        numbers = [_number(lines, (x, y)) for x, y in points]
        strips += [*pairwise(numbers)]
        thickness += wall.elements * [wall.thickness]
    least = 2.0 ** (refinement + 1) * min(_width(wall) for wall in walls)
    lengths = [
        halved(graded_lengths(length, least, LARGEST * least, _GROWTH), refinement + 1)
        for length in (column.length_below, column.length_above)
    ]
    along = np.concatenate([[0.0], np.cumsum(np.concatenate(lengths))])
    rows, count = len(along) - 1, len(lines)
    across = np.array(strips)
    first = across[None] + count * np.arange(rows)[:, None, None]
    nodes = np.concatenate([first, first[:, :, ::-1] + count], axis=2).reshape(-1, 4)
    flat, z = np.tile(np.array(lines), (rows + 1, 1)), np.repeat(along, count)
    place = np.column_stack([flat, z])
    clamped = "pinned" not in column.ends_about("weak")
    turn = pi * z / column.length
    place[:, 1] += bow * column.length * (np.sin(turn) ** 2 if clamped else np.sin(turn))
    phase = pi * (z - column.length_below) / section.width
    place[:, 0] += 2.0 * tilt * flat[:, 1] * np.cos(phase)
    sides = np.array([_width(wall) for wall in walls for _ in range(wall.elements)])
    shells = Shells(nodes.astype(np.int64), np.tile(thickness, rows))
    areas = np.outer(np.diff(along), sides).ravel()
    return ShellMesh(place, flat, z, shells, areas, min(sides.min(), np.diff(along).min()))


def _number(lines: list[tuple[float, float]], line: tuple[float, float]) -> int:
    """Number of a line of nodes along the column; a new one is added."""
    if line not in lines:
        lines.append(line)
    return lines.index(line)


def _width(wall: Wall) -> float:
    """Width of an element across a wall, in m."""
    return float(np.hypot(*np.subtract(wall.end, wall.start))) / wall.elements


def supports_of(mesh: ShellMesh, column: Column, upright: bool = False) -> Supports:
    """Supports of the plates of a column, whose last unknown is U of the head.

    An end that is pinned about an axis is a rigid plate that turns about its centroid that way, in
    which walls are hinged. `upright`: the middle plane of the section is held, so that the column
    cannot leave it.
    """
    at_head = mesh.along == mesh.along.max()
    held = np.zeros((len(mesh.along), 6), dtype=bool)
    turning: list[tuple[Indices, Indices, Array]] = []
    for end, at in enumerate((mesh.along == 0.0, at_head)):
        kinds = [column.ends_about(axis)[end] for axis in AXES]
        held[at, : 3 if "pinned" in kinds else 6] = True
        nodes = np.flatnonzero(at)
        for axis, kind in enumerate(kinds):
            if kind == "pinned":
                turning.append((6 * nodes + axis, 6 * nodes + 2, mesh.section[nodes, axis]))
    if upright:
        held[np.ix_(mesh.section[:, 1] == 0.0, [1, 3, 5])] = True
    free = np.flatnonzero(~held.ravel())
    plates = [PlateMesh(*each, len(free) + number) for number, each in enumerate(turning)]
    last = len(free) + len(plates)
    head = 6 * np.flatnonzero(at_head) + 2
    rows = np.append(free, head)
    columns = np.append(np.arange(len(free)), np.full(len(head), last))
    tied = csr_array((np.ones(len(rows)), (rows, columns)), shape=(held.size, last + 1))
    return Supports(tied, tuple(plates))


class FaceTarget(NamedTuple):
    """Line in the plane of the section that a face meets, and what of it.

    Number of the coordinate that is the same on it (0: x, of a flange; 1: y, of the edges of both
    flanges), its `level` (m); `place` (m) on it where the line of the hit meets it, and the way
    from there to the nearer end, `room` (m), negative beside it.
    """

    fixed: int
    level: float
    place: float
    room: float

    @property
    def corner(self) -> tuple[float, float]:
        """The end of the line that is nearer to the hit, x and y in m."""
        end = np.copysign(self.room + abs(self.place), self.place)
        return (self.level, end) if self.fixed == 0 else (end, self.level)


def target_of(section: Section, direction: float, eccentricity: float) -> FaceTarget:
    """Part of a section that a hit meets first.

    Arguments: `direction` (rad) off the height of the section; `eccentricity` (m) of its line from
    the shear centre, to the left of who flies along it.
    """
    high, wide = np.max([wall.end for wall in walls_of(section)], axis=0)
    c, s = cos(direction), sin(direction)
    y = (eccentricity - high * s) / c if c > _ALONG else -np.inf
    if abs(y) <= wide or s < _ALONG:
        return FaceTarget(0, -high, y, wide - abs(y))
    x = (wide * c + eccentricity) / -s
    return FaceTarget(1, -wide, x, high - abs(x))


def face_of(
    mesh: ShellMesh, level: float, size: tuple[float, float], target: FaceTarget | None
) -> tuple[Indices, Array]:
    """Nodes that a face meets, and their shares of its force, which is spread evenly over it.

    Arguments: `level` of its middle above the base and `size` across and along the column, m; the
    `target` that it meets (None: the whole height of what stands upright). The force stands at its
    place whatever the mesh: beside an edge the face is narrower.
    """
    flat, (high, wide) = mesh.section, mesh.section.max(axis=0)
    if target is None:
        is_web = np.any((flat[:, 1] == 0.0) & (np.abs(flat[:, 0]) < high))
        on, axis = np.abs(flat[:, 1]) == (0.0 if is_web else wide), 0
        shares = _spread(flat[on, axis], 0.0, high)
    else:
        on, axis = flat[:, target.fixed] == target.level, 1 - target.fixed
        shares = _spread(flat[on, axis], target.place, min(0.5 * size[0], target.room))
    shares *= _spread(mesh.along[on], level, 0.5 * size[1])
    return np.flatnonzero(on)[shares > 0.0], shares[shares > 0.0] / shares.sum()


def _spread(at: Array, middle: float, half: float) -> Array:
    """Share (nodes,) of each node in an even pressure around a place, linear between nodes."""
    places = np.unique(at)
    samples = np.linspace(middle - half, middle + half, _SAMPLES)
    number = np.clip(np.searchsorted(places, samples) - 1, 0, len(places) - 2)
    upper = (samples - places[number]) / (places[number + 1] - places[number])
    upper = np.clip(upper, 0.0, 1.0)
    shares = np.bincount(number, 1.0 - upper, len(places))
    shares += np.bincount(number + 1, upper, len(places))
    return np.asarray(shares[np.searchsorted(places, at)] / _SAMPLES)
