"""How the supports tie the dofs of the solid: u = u(q) with few independent unknowns q.

Unknowns, in this order: dofs of free nodes; turn of a pinned base; turn of a pinned head; axial
displacement U of the head; lateral displacement v of the hit section. A pinned end is a rigid
plate that turns about the centroid, exactly: its nodes at X move by R(turn) X - X.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from workbench.arrays import Array, Indices
from workbench.references.solid.mesh import SolidMesh


class Plate(NamedTuple):
    """A rigid end plate: its x and y dofs, places X of its nodes (m), unknown of its turn."""

    horizontal: Indices
    vertical: Indices
    places: Array
    turn: int


class Supports(NamedTuple):
    """The map u(q): `tied` (dofs, unknowns), its linear part, and the `plates` of pinned ends.

    The last unknown is v, the one before it U.
    """

    tied: csr_array
    plates: tuple[Plate, ...] = ()

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
        gathered = np.asarray(self.tied.T @ force)
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
    plates = [Plate(*end, mesh.places[0, end[1]], len(moving) + k) for k, end in enumerate(pinned)]
    last = len(moving) + len(plates)
    rows = [moving, mesh.head[1], mesh.hit[0]]
    columns = np.append(
        np.arange(len(moving)), np.repeat([last, last + 1], [len(mesh.head[1]), len(mesh.hit[0])])
    )
    ones = np.ones(len(columns))
    shape = (mesh.size, last + 2)
    return Supports(csr_array((ones, (np.concatenate(rows), columns)), shape=shape), tuple(plates))
