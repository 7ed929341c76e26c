"""How the supports tie the dofs of the solid: u = u(q) with few independent unknowns q.

Unknowns, in this order: dofs of free nodes; turn of a pinned base; turn of a pinned head; axial
displacement U of the head; lateral displacement v of the hit section. A pinned end is a rigid
plate that turns about the centroid, exactly: its nodes at X move by R(turn) X - X.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from workbench.references.solid.mesh import SolidMesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def gathered(places: Indices, values: Array, size: int) -> Array:
    """Sum `values` at their `places` into an array (size,)."""
    return np.asarray(np.bincount(places, values, size), dtype=float)


@dataclass(frozen=True)
class Plate:
    """A rigid end plate: its x and y dofs, places X of its nodes (m), unknown of its turn."""

    horizontal: Indices
    vertical: Indices
    places: Array
    turn: int


@dataclass(frozen=True)
class Supports:
    """The map u(q) of `size` dofs from `unknowns`, and its derivative T = du/dq.

    `rows` and `columns` are the places of the entries of T, sorted by rows; `plates` the pinned
    ends, whose entries change with the turn. The last unknown is v, the one before it U.
    """

    size: int
    unknowns: int
    rows: Indices
    columns: Indices
    plates: tuple[Plate, ...]

    @property
    def hit(self) -> int:
        """The unknown v."""
        return self.unknowns - 1

    @property
    def head(self) -> int:
        """The unknown U."""
        return self.unknowns - 2

    def expand(self, q: Array) -> Array:
        """Displacements u (size,) of unknowns q (unknowns,), in m."""
        u = np.zeros(self.size)
        u[self.rows[self._plain]] = q[self.columns[self._plain]]
        for plate in self.plates:
            turn = q[plate.turn]
            u[plate.horizontal] += (np.cos(turn) - 1.0) * plate.places
            u[plate.vertical] += np.sin(turn) * plate.places
        return u

    @cached_property
    def _plain(self) -> NDArray[np.bool_]:
        """Entries of T that are constant, 1."""
        turns = [plate.turn for plate in self.plates]
        return ~np.isin(self.columns, turns)

    def derivative(self, q: Array) -> Array:
        """Values of the entries of T = du/dq."""
        values = np.ones(len(self.rows))
        for plate in self.plates:
            turn = q[plate.turn]
            moved = np.zeros(self.size)
            moved[plate.horizontal] = -np.sin(turn) * plate.places
            moved[plate.vertical] = np.cos(turn) * plate.places
            mine = self.columns == plate.turn
            values[mine] = moved[self.rows[mine]]
        return values

    def curvature(self, q: Array, force: Array) -> list[tuple[int, float]]:
        """Terms f . d2u/dq2 of the tangent: diagonal entry and value of each plate."""
        terms = []
        for plate in self.plates:
            turn = q[plate.turn]
            pull = np.cos(turn) * force[plate.horizontal] + np.sin(turn) * force[plate.vertical]
            terms.append((plate.turn, -float(pull @ plate.places)))
        return terms


def supports_of(mesh: SolidMesh, base: str, head: str) -> Supports:
    """Supports of a column.

    Arguments: `mesh`; `base` clamped or pinned; `head` guided, pinned or fixed (which is guided
    until U is held).
    """
    free = np.ones(mesh.size, dtype=bool)
    tied = (*mesh.base, mesh.hit[0], *mesh.head)
    free[np.concatenate(tied)] = False
    moving = np.flatnonzero(free)
    entries = [(moving, np.arange(len(moving)))]
    unknowns = len(moving)
    plates = []
    for end, kind in ((mesh.base, base), (mesh.head, head)):
        if kind == "pinned":
            plates.append(Plate(*end, mesh.places[0, end[1]], unknowns))
            dofs = np.concatenate(end)
            entries.append((dofs, np.full(len(dofs), unknowns)))
            unknowns += 1
    for dofs in (mesh.head[1], mesh.hit[0]):
        entries.append((dofs, np.full(len(dofs), unknowns)))
        unknowns += 1
    rows, columns = (np.concatenate(parts) for parts in zip(*entries, strict=True))
    order = np.lexsort((columns, rows))
    return Supports(mesh.size, unknowns, rows[order], columns[order], tuple(plates))


@dataclass(frozen=True)
class Pattern:
    """Where entries of the element matrices go in the sparse tangent of the unknowns.

    One item for each entry of an element matrix and each pair of entries of T that it meets:
    `entry` of the flattened element matrices, `left` and `right` entries of T, `slot` in the data
    of the sparse matrix with `pointers` and `indices` (compressed columns).
    """

    entry: Indices
    left: Indices
    right: Indices
    slot: Indices
    pointers: Indices
    indices: Indices

    @classmethod
    def of(cls, dofs: Indices, supports: Supports) -> Pattern:
        """The pattern of elements with the dofs (elements, dofs of one)."""
        count = dofs.shape[1]
        first = np.searchsorted(supports.rows, np.arange(supports.size + 1))
        number = np.diff(first)
        row = np.repeat(dofs, count, axis=1).ravel()
        column = np.tile(dofs, (1, count)).ravel()
        pairs = number[row] * number[column]
        entry = np.repeat(np.arange(row.size), pairs)
        place = np.arange(entry.size) - np.repeat(np.cumsum(pairs) - pairs, pairs)
        left = first[row[entry]] + place // number[column[entry]]
        right = first[column[entry]] + place % number[column[entry]]
        key = supports.columns[right] * supports.unknowns + supports.columns[left]
        # every diagonal entry is there: supports hold unknowns by a one on the diagonal
        diagonal = np.arange(supports.unknowns) * (supports.unknowns + 1)
        unique, slot = np.unique(np.concatenate([diagonal, key]), return_inverse=True)
        counts = np.bincount(unique // supports.unknowns, minlength=supports.unknowns)
        return cls(
            entry=entry,
            left=left,
            right=right,
            slot=slot[supports.unknowns :],
            pointers=np.concatenate([[0], np.cumsum(counts)]),
            indices=unique % supports.unknowns,
        )

    @cached_property
    def columns(self) -> Indices:
        """Column of each entry of the sparse matrix."""
        return np.repeat(np.arange(len(self.pointers) - 1), np.diff(self.pointers))

    @cached_property
    def diagonal(self) -> Indices:
        """Place of the diagonal entries in the data of the sparse matrix."""
        return np.flatnonzero(self.indices == self.columns)

    def assemble(self, stiffness: Array, derivative: Array) -> Array:
        """Data of T' K T from element matrices and the values of T."""
        values = stiffness.ravel()[self.entry] * derivative[self.left] * derivative[self.right]
        return gathered(self.slot, values, len(self.indices))

    def matrix(self, data: Array) -> csc_array:
        """The sparse matrix with these data."""
        size = len(self.pointers) - 1
        return csc_array((data, self.indices, self.pointers), shape=(size, size))
