"""The mesh of a column as a plane continuum of variable thickness, taken from scikit-fem.

The section's height runs along x, the column's axis along y. Thickness is the width b(x) of the
section; rows of elements end where the section's plates do, so that no element sees a jump.

Supports tie the dofs, u = u(q) with few independent unknowns q, in this order: dofs of free nodes;
turn of a pinned base; turn of a pinned head; axial displacement U of the head; lateral displacement
v of the hit section. A pinned end is a rigid plate that turns about the centroid, exactly: its
nodes at X move by R(turn) X - X.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from skfem import Basis, ElementQuad2, ElementVector, MeshQuad

from workbench.base.arrays import Array, Flags, Indices
from workbench.mechanics.structures.assembly import graded_lengths, halved
from workbench.scenarios import Column
from workbench.steel.sections import Section
from workbench.steel.sections.section import half_integrals

_ROWS = 4  # per height of the section, before refinement; a flange has at least one
SMALLEST, LARGEST = 1.0 / 6.0, 1.0  # element lengths over the section's height
_GROWTH = 1.4
_ORDER = 5  # 3 x 3 Gauss points


@dataclass(frozen=True)
class SolidMesh:
    """Tables of the discretised column, all in SI units.

    `area` of the section, `lengths` below and above the hit section, `smallest` length of an
    element along the axis; `gradients` (elements, points, 2, nodes of one) of the shape functions
    by x and y; `weights` (elements, points), thickness times area; `dofs` (elements, dofs of one),
    x and y of its nodes in turn; `size`, number of dofs; `places` (2, size), where the
    node of each dof is, in m; `base`, `hit` and `head`: x dofs and y dofs of these sections, both
    from left to right.
    """

    area: float
    lengths: tuple[float, float]
    smallest: float
    gradients: Array
    weights: Array
    dofs: Indices
    size: int
    places: Array
    base: tuple[Indices, Indices]
    hit: tuple[Indices, Indices]
    head: tuple[Indices, Indices]


def row_edges(section: Section, refinement: int = 0) -> Array:
    """Heights (m, rising) of the mesh lines across the section.

    They hold the faces of all plates, and the ends of fillets; `refinement` halves each row so
    many times (negative: half as many rows, but one per plate at least).
    """
    faces = {edge for band in section.shape.bands for edge in (band.bottom, band.top)}
    upper = [0.0]
    for low, high in pairwise(sorted(faces)):
        wanted = (high - low) / section.height * _ROWS * 2.0 ** min(refinement, 0)
        rows = max(1, round(wanted)) * 2 ** max(refinement, 0)
        upper.extend(float(x) for x in np.linspace(low, high, rows + 1)[1:])
    return np.array([-x for x in upper[:0:-1]] + upper)


def axial_positions(column: Column, smallest: float | None = None, refinement: int = 0) -> Array:
    """Positions (m, rising) of the mesh lines along the column, dense at ends and hit section.

    Arguments: `smallest` element length in m (None: a sixth of the section's height);
    `refinement`, how often all elements are halved (negative: doubled).
    """
    coarser = 2.0 ** max(-refinement, 0)
    least = coarser * (smallest or SMALLEST * column.section.height)
    largest = max(coarser * LARGEST * column.section.height, least)
    parts = [
        halved(graded_lengths(length, least, largest, _GROWTH), max(refinement, 0))
        for length in (column.length_below, column.length_above)
    ]
    return np.concatenate([[0.0], np.cumsum(np.concatenate(parts))])


def solid_mesh(column: Column, smallest: float | None = None, refinement: int = 0) -> SolidMesh:
    """Mesh the column with nine-node quadrilaterals.

    Arguments: `column`, of which the section that gives the strength is meshed; `smallest`
    element length in m; `refinement`, how often all elements are halved in both directions
    (negative: doubled).
    """
    section = column.strength_section
    along = axial_positions(column, smallest, refinement)
    mesh = MeshQuad.init_tensor(row_edges(section, refinement), along)
    basis = Basis(mesh, ElementVector(ElementQuad2()), intorder=_ORDER)
    # of x displacements by x and y: (nodes, 2, elements, points)
    gradients = np.stack([shape[0].grad[0] for shape in basis.basis[0::2]])
    horizontal = np.zeros(basis.N, dtype=bool)
    horizontal[basis.element_dofs[0::2]] = True
    hit = along[np.argmin(np.abs(along - column.length_below))]
    return SolidMesh(
        area=section.area,
        lengths=(column.length_below, column.length_above),
        smallest=float(np.diff(along).min()),
        gradients=gradients.transpose(2, 3, 1, 0).copy(),
        weights=basis.dx * _thickness(section, mesh, basis),
        dofs=basis.element_dofs.T.astype(np.int64, order="C"),
        size=int(basis.N),
        places=basis.doflocs,
        base=_section_dofs(basis.doflocs, horizontal, along[0]),
        hit=_section_dofs(basis.doflocs, horizontal, hit),
        head=_section_dofs(basis.doflocs, horizontal, along[-1]),
    )


def _thickness(section: Section, mesh: MeshQuad, basis: Basis) -> Array:
    """Width of the section at the quadrature points, scaled to the exact area of each row."""
    width = section.width_at(np.asarray(basis.global_coordinates())[0])
    ends = np.abs(mesh.p[0][mesh.t])  # no element straddles the centroid
    area, _, _ = half_integrals(section.shape.bands, np.stack([ends.min(0), ends.max(0)]))
    length = np.ptp(mesh.p[1][mesh.t], axis=0)
    scale = (area[1] - area[0]) * length / np.sum(basis.dx * width, axis=1)
    thickness: Array = width * scale[:, None]
    return thickness


def _section_dofs(places: Array, horizontal: Flags, at: float) -> tuple[Indices, Indices]:
    """Horizontal and vertical dofs of the nodes of a section, both from left to right."""
    there = np.abs(places[1] - at) < 1e-9
    pair = []
    for direction in (horizontal, ~horizontal):
        dofs = np.flatnonzero(there & direction)
        pair.append(dofs[np.argsort(places[0, dofs])])
    return pair[0], pair[1]


class PlateMesh(NamedTuple):
    """A rigid end plate: its x and y dofs, places X of its nodes (m), unknown of its turn."""

    horizontal: Indices
    vertical: Indices
    places: Array
    turn: int


@dataclass(frozen=True)
class Supports:
    """The map u(q): `tied` (dofs, unknowns), its linear part, and the `plates` of pinned ends.

    The last unknown is v, the one before it U.
    """

    tied: csr_array
    plates: tuple[PlateMesh, ...] = ()

    @cached_property
    def gathering(self) -> csr_array:
        """Transpose of `tied`, made once: it takes longer than a product with it."""
        return self.tied.T.tocsr()

    @property
    def unknowns(self) -> int:
        """Number of unknowns."""
        return int(self.tied.shape[1])

    @property
    def hit(self) -> int:
        """The unknown v."""
        return self.unknowns - 1

    @property
    def head(self) -> int:
        """The unknown U."""
        return self.unknowns - 2

    def expand(self, q: Array) -> Array:
        """Displacements u (dofs,) of unknowns q (unknowns,), in m."""
        u = self.tied @ q
        for plate in self.plates:
            turn = q[plate.turn]
            u[plate.horizontal] += (np.cos(turn) - 1.0) * plate.places
            u[plate.vertical] += np.sin(turn) * plate.places
        return np.asarray(u)

    def gather(self, q: Array, force: Array) -> Array:
        """Forces (unknowns,) of nodal forces (dofs,) at q: (du/dq)' f."""
        gathered = np.asarray(self.gathering @ force)
        for plate in self.plates:
            turn = q[plate.turn]
            across, along = force[plate.horizontal], force[plate.vertical]
            gathered[plate.turn] += (np.cos(turn) * along - np.sin(turn) * across) @ plate.places
        return gathered

    def derivative(self, q: Array) -> csr_array:
        """T = du/dq (dofs, unknowns)."""
        result = self.tied
        for plate in self.plates:
            turn = q[plate.turn]
            moved = np.append(-np.sin(turn) * plate.places, np.cos(turn) * plate.places)
            rows = np.append(plate.horizontal, plate.vertical)
            columns = np.full(len(rows), plate.turn)
            result = result + csr_array((moved, (rows, columns)), shape=result.shape)
        return result

    def curvature(self, q: Array, force: Array) -> Array:
        """Terms f . d2u/dq2 (unknowns,) of the tangent's diagonal under forces f (dofs,)."""
        terms = np.zeros(len(q))
        for plate in self.plates:
            turn = q[plate.turn]
            pull = np.cos(turn) * force[plate.horizontal] + np.sin(turn) * force[plate.vertical]
            terms[plate.turn] = -pull @ plate.places
        return terms


def supports_of(mesh: SolidMesh, base: str, head: str) -> Supports:
    """Supports of a column.

    Arguments: `mesh`; `base` clamped or pinned; `head` guided, pinned or fixed (which is guided
    until U is held).
    """
    tied = np.concatenate([*mesh.base, mesh.hit[0], *mesh.head])
    moving = np.setdiff1d(np.arange(mesh.size), tied)
    pinned = [end for end, kind in ((mesh.base, base), (mesh.head, head)) if kind == "pinned"]
    plates = [
        PlateMesh(*end, mesh.places[0, end[1]], len(moving) + k) for k, end in enumerate(pinned)
    ]
    last = len(moving) + len(plates)
    rows = [moving, mesh.head[1], mesh.hit[0]]
    columns = np.append(
        np.arange(len(moving)), np.repeat([last, last + 1], [len(mesh.head[1]), len(mesh.hit[0])])
    )
    ones = np.ones(len(columns))
    shape = (mesh.size, last + 2)
    return Supports(csr_array((ones, (np.concatenate(rows), columns)), shape=shape), tuple(plates))
