"""Meshes of a column for decks of other programs: plane stress, bricks, shells, all quadratic.

The height of the section runs along x, the way of a hit at 0 degrees; the axis of the column along
y, from the base on; the width of the section along -z.
"""

from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array, Flags, Indices
from workbench.base.errors import InputError
from workbench.models.references.shell.mesh import HALF_FLANGE, walls_of
from workbench.models.references.solid.mesh import axial_positions, row_edges
from workbench.scenarios import Column
from workbench.steel.sections import ISection, RectangularTube
from workbench.steel.sections.section import half_integrals

_ROUND, _SIDES = ((-1, -1), (1, -1), (1, 1), (-1, 1)), ((0, -1), (1, 0), (0, 1), (-1, 0))
_FLAT = np.array([*_ROUND, *_SIDES])  # places of eight nodes, those of twenty nodes below
_BRICK = np.array(
    [(*at, z) for ring in (_ROUND, _SIDES) for z in (-1, 1) for at in ring]
    + [(*at, 0) for at in _ROUND]
)
_SHARES = {8: (1.0 / 6.0, 2.0 / 3.0), 20: (-1.0 / 12.0, 1.0 / 3.0)}  # of a corner, of a side
_CORNERS = {8: 4, 20: 8}
_DIGITS = 9  # of places in m


class DeckPart(NamedTuple):
    """Elements of one property: `nodes` (elements, nodes of one), from 0 on.

    `thickness` in m; None of bricks.
    """

    nodes: Indices
    thickness: float | None


class DeckMesh(NamedTuple):
    """A `kind` of element, `places` (nodes, 3) in m, `plates`; `planes`, where a face may press.

    Those are nodes in the middle planes of the plates, in rows and columns without a gap.
    """

    kind: str
    places: Array
    plates: tuple[DeckPart, ...]
    planes: Flags

    @property
    def section(self) -> Array:
        """Places (nodes, 2) along height and width of the section, in m."""
        return self.places[:, [0, 2]] * (1.0, -1.0)

    @property
    def along(self) -> Array:
        """Places (nodes,) along the column, in m."""
        return self.places[:, 1]

    def at(self, level: float) -> Indices:
        """Numbers, from 1 on, of the nodes of the section at a `level` (m)."""
        return np.flatnonzero(np.isclose(self.along, level)) + 1

    def areas(self, level: float) -> Array:
        """Areas (nodes,) of the section at a `level` (m) that belong to its nodes, in m2."""
        areas = np.zeros(len(self.places))
        for nodes, thickness in self.plates:
            corner, side = _SHARES[nodes.shape[1]]
            above = nodes[np.isclose(self.along[nodes].min(axis=1), level)]
            for element in above:
                on = np.isclose(self.along[element], level)
                across = np.ptp(self.section[element[on]], axis=0)
                area = across.prod() if thickness is None else thickness * across.sum()
                is_corner = np.arange(len(element)) < _CORNERS[len(element)]
                areas[element[on]] += area * np.where(is_corner[on], corner, side)
        return areas


def _numbered(kind: str, parts: Iterable[tuple[Array, float | None]]) -> DeckMesh:
    """A mesh of elements whose nodes have these places (elements, nodes of one, 3)."""
    cells, thicknesses = zip(*parts, strict=True)
    every = np.concatenate([each.reshape(-1, 3) for each in cells]).round(_DIGITS) + 0.0
    places, numbers = np.unique(every, axis=0, return_inverse=True)
    ends = np.cumsum([each.shape[0] * each.shape[1] for each in cells])[:-1]
    tables = zip(np.split(numbers.ravel(), ends), cells, thicknesses, strict=True)
    plates = tuple(DeckPart(part.reshape(each.shape[:2]), thick) for part, each, thick in tables)
    corners = np.concatenate([nodes[:, : _CORNERS[nodes.shape[1]]].ravel() for nodes, _ in plates])
    return DeckMesh(kind, places, plates, np.isin(np.arange(len(places)), corners))


def _boxes(template: Array, *edges: Array) -> Array:
    """Places (boxes, nodes, 3) of the nodes of all boxes between `edges` along x, y and z."""
    middle, half = (
        np.stack(np.meshgrid(*sizes, indexing="ij"), axis=-1).reshape(-1, 1, 3)
        for sizes in (
            [0.5 * (each[1:] + each[:-1]) for each in edges],
            [0.5 * np.diff(each) for each in edges],
        )
    )
    return np.asarray(middle + template * half)


def _flat(*edges: Array) -> Array:
    """Places as of `_boxes`, of rectangles: one pair of edges is a place."""
    template = np.insert(_FLAT, [len(each) == 1 for each in edges].index(True), 0, axis=1)
    return _boxes(template, *(np.repeat(each, 2) if len(each) == 1 else each for each in edges))


def plane_stress(column: Column, refinement: int) -> DeckMesh:
    """Layers as thick as the section is wide, those of `solid-plane-stress` (CPS8R)."""
    section, along = column.strength_section, axial_positions(column, None, refinement)
    edges = row_edges(section, refinement)
    areas, _, _ = half_integrals(section.shape.bands, np.abs(edges))
    rows: dict[float, list[Array]] = {}
    for ends, area in zip(pairwise(edges), np.abs(np.diff(areas)), strict=True):
        thickness = round(float(area / np.diff(ends)[0]), _DIGITS)
        rows.setdefault(thickness, []).append(_flat(np.array(ends), along, np.zeros(1)))
    return _numbered("CPS8R", ((np.concatenate(cells), each) for each, cells in rows.items()))


def _counts(ratio: float, refinement: int) -> tuple[int, int]:
    """Elements across half a flange, and over the height, which is `ratio` times the width."""
    times = HALF_FLANGE * 2.0**refinement
    return max(1, round(times)), 2 * max(1, round(ratio * times))


def _no_plates(column: Column, allowed: str) -> InputError:
    return InputError(
        "column.section",
        column.section.name,
        f"must be {allowed} for this mesh",
        "take --mesh plane-stress, which has layers of any section",
    )


def bricks(column: Column, refinement: int) -> DeckMesh:
    """Plates of an I section as bricks (C3D20R), fillets in the thickness of the flanges.

    One brick through a plate, from refinement 1 on two: one of two points has 1.155 times the
    plastic moment of the plate. Raises `InputError` for other sections.
    """
    section, along = (
        column.strength_section.about("strong"),
        axial_positions(column, None, refinement),
    )
    shape = section.shape
    if not isinstance(shape, ISection):
        raise _no_plates(column, "an I section")
    high, wide, thin = 0.5 * shape.height, 0.5 * shape.width, 0.5 * shape.web
    flange = 0.5 * (section.area - 2.0 * high * shape.web) / (shape.width - shape.web)
    half, height = _counts(high / wide, refinement)
    layers = 2 if refinement > 0 else 1
    beside, inner = np.linspace(thin, wide, half + 1), high - flange
    web = np.linspace(-thin, thin, layers + 1)
    across = np.concatenate([-beside[:0:-1], web, beside[1:]])
    through = np.linspace(inner, high, layers + 1)
    plates = [(each, along, across) for each in (through, -through[::-1])]
    plates.append((np.linspace(-inner, inner, height + 1), along, web))
    mesh = _numbered("C3D20R", [(np.concatenate([_boxes(_BRICK, *e) for e in plates]), None)])
    x, y = mesh.section.T
    planes = np.isclose(np.abs(x), high - 0.5 * flange) | ((np.abs(x) < inner) & (y == 0.0))
    # a single brick has the middle of its sides there, and no corner
    return mesh._replace(planes=planes & (mesh.planes | (layers == 1)))


def shells(column: Column, refinement: int) -> DeckMesh:
    """Plates in their middle planes, those of `shell` (S8R). Raises `InputError` for no plates."""
    section, along = (
        column.strength_section.about("strong"),
        axial_positions(column, None, refinement),
    )
    if not isinstance(section.shape, ISection | RectangularTube):
        raise _no_plates(column, "an I section or a rectangular tube")
    walls = walls_of(section)
    high, wide = walls[1].end
    half, height = _counts(high / wide, refinement)
    parts: dict[float, list[Array]] = {}
    for (x, y), (end, other), thickness, _ in walls:
        across = np.linspace(-other, -y, 2 * half + 1) if x == end else np.array([-y])
        upright = np.array([x]) if x == end else np.linspace(x, end, height + 1)
        parts.setdefault(thickness, []).append(_flat(upright, along, across))
    return _numbered("S8R", ((np.concatenate(cells), each) for each, cells in parts.items()))


MESHES: Mapping[str, Callable[[Column, int], DeckMesh]] = {
    "plane-stress": plane_stress,
    "bricks": bricks,
    "shells": shells,
}
