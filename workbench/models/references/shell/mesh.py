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
from workbench.steel.sections import ISection, RectangularTube, Section

HALF_FLANGE = 2  # elements of the coarsest mesh, of refinement -1
LARGEST = 2.0  # length along the axis over the least one
_GROWTH = 1.2
_SAMPLES = 2000  # of the pressure of a face
CORNER = pi / 4.0  # direction from which on a striker meets the edges of plates, not a flange


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
    high, wide = 0.5 * (shape.height - across), 0.5 * shape.width
    if isinstance(shape, RectangularTube):
        wide -= 0.5 * across
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

    Arguments: `refinement`, how often all elements are halved, from -1 on; initial `bow` out of the
    plane over the length; `tilt`, by which the edges of flanges stand out of their planes, over
    the width, to and fro with half waves as long as the width.
    """
    section = column.strength_section
    walls = walls_of(section, refinement)
    lines: list[tuple[float, float]] = []
    strips, thickness = [], []
    for wall in walls:
        points = np.linspace(wall.start, wall.end, wall.elements + 1).round(12).tolist()
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
    clamped = column.base == "clamped" and column.head != "pinned"
    turn = pi * z / column.length
    place[:, 1] += bow * column.length * (np.sin(turn) ** 2 if clamped else np.sin(turn))
    width = column.section.width
    phase = pi * (z - column.length_below) / width
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


def least_second_moment(section: Section) -> float:
    """Second moment of area (m4) of the plates of a section about its weaker axis."""
    moments = np.zeros(2)
    for wall in walls_of(section):
        start, end = np.array(wall.start), np.array(wall.end)
        area = wall.thickness * float(np.hypot(*(end - start)))
        moments += area * (start**2 + start * end + end**2) / 3.0
    return float(moments.min())


def supports_of(mesh: ShellMesh, column: Column, upright: bool = False) -> Supports:
    """Supports of the plates of a column, whose last unknown is U of the head.

    An end that is pinned is a rigid plate that turns about its centroid both ways, in which walls
    are hinged. `upright`: the middle plane of the section stays what it is, so that the column
    cannot leave it.
    """
    at_base, at_head = mesh.along == 0.0, mesh.along == mesh.along.max()
    held = np.zeros((len(mesh.along), 6), dtype=bool)
    ends = ((at_base, column.base), (at_head, column.head))
    plates: list[PlateMesh] = []
    turning: list[tuple[Indices, Indices, Array]] = []
    for at, kind in ends:
        held[at, : 3 if kind == "pinned" else 6] = True
        if kind == "pinned":
            nodes = np.flatnonzero(at)
            for axis in range(2):
                turning.append((6 * nodes + axis, 6 * nodes + 2, mesh.section[nodes, axis]))
    if upright:
        held[np.ix_(mesh.section[:, 1] == 0.0, [1, 3, 5])] = True
    free = np.flatnonzero(~held.ravel())
    for number, (sideways, lengthwise, places) in enumerate(turning):
        plates.append(PlateMesh(sideways, lengthwise, places, len(free) + number))
    last = len(free) + len(plates)
    head = 6 * np.flatnonzero(at_head) + 2
    rows = np.append(free, head)
    columns = np.append(np.arange(len(free)), np.full(len(head), last))
    tied = csr_array((np.ones(len(rows)), (rows, columns)), shape=(held.size, last + 1))
    return Supports(tied, tuple(plates))


def line_of_hit(direction: float, section: Section, eccentricity: float) -> float:
    """Place (m) across the struck face where the line of a hit meets it.

    That is y on the flange for directions (rad from the height of the section) below 45 degrees,
    else x between the edges of both flanges. `eccentricity` (m) of the line from the shear centre,
    to the left of who flies along it.
    """
    _, across = section.shape.plates
    if direction < CORNER:
        high = 0.5 * (section.height - across)
        return (eccentricity - high * sin(direction)) / cos(direction)
    wide = 0.5 * section.width
    return (wide * cos(direction) - eccentricity) / sin(direction)


def face_of(
    mesh: ShellMesh,
    level: float,
    size: tuple[float, float],
    place: float = 0.0,
    direction: float = 0.0,
    web: bool = False,
) -> tuple[Indices, Array]:
    """Nodes that a face meets, and their shares of its force, which is spread evenly over it.

    Arguments: `level` of its middle above the base and `size` across and along the column, m;
    `place` of its middle across the column, see `line_of_hit`; `direction` (rad); `web`, whether
    it meets the whole height of what stands upright instead. The force stands at `place` whatever
    the mesh: beside an edge the face is narrower.
    """
    flat, (high, wide) = mesh.section, mesh.section.max(axis=0)
    if web:
        in_web = flat[:, 1] == 0.0
        in_web &= np.abs(flat[:, 0]) < high
        on, axis, half = np.abs(flat[:, 1]) == (0.0 if in_web.any() else wide), 0, high
    elif direction < CORNER:
        on, axis, half = flat[:, 0] == -high, 1, min(0.5 * size[0], wide - abs(place))
    else:
        on, axis, half = flat[:, 1] == -wide, 0, min(0.5 * size[0], high - abs(place))
    nodes = np.flatnonzero(on)
    shares = _spread(flat[nodes, axis], place, half)
    shares *= _spread(mesh.along[nodes], level, 0.5 * size[1])
    kept = shares > 0.0
    return nodes[kept], shares[kept] / shares.sum()


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
