"""Mesh, basis, quadrature and dof tables of the beam elements, from scikit-fem.

Every element owns its two nodes on one parameter line, end to end with gaps, so that members of
a frame may meet in any way: the Boolean map from the dofs of the frame to those of the line is
the element table itself.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, ElementLineP1, ElementVector, MeshLine

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
MIDPOINT = (np.array([[0.5]]), np.array([1.0]))  # one point: no locking of the linear element


class LineTables(NamedTuple):
    """What the kernel needs of the discretisation, one row per element.

    Frame `dofs` (e, 6), in the order of the local basis functions; initial `director` (e, 2);
    at the quadrature point: `values` (e, 2) and `gradients` (e, 2) of the two shape functions,
    and the `measure` (e,), weight times length in m.
    """

    dofs: Indices
    director: Array
    values: Array
    gradients: Array
    measure: Array


def line_basis(lengths: Array) -> Basis:
    """Linear vector basis (u, v, rotation) on disconnected line elements, with one point each."""
    gap = float(np.min(lengths))
    starts = np.concatenate([[0.0], np.cumsum(lengths + gap)[:-1]])
    points = np.stack([starts, starts + lengths], axis=1).reshape(1, -1)
    ends = np.ascontiguousarray(np.arange(2 * len(lengths)).reshape(-1, 2).T)
    mesh = MeshLine(np.ascontiguousarray(points), ends, sort_t=False)
    return Basis(mesh, ElementVector(ElementLineP1(), 3), quadrature=MIDPOINT)


def line_tables(basis: Basis, dofs: Indices, chords: Array) -> LineTables:
    """Tables of a line basis for elements with frame `dofs` (e, 6) and `chords` (e, 2) in m."""
    lengths = np.hypot(chords[:, 0], chords[:, 1])
    ends = [basis.basis[3 * node][0] for node in range(2)]
    return LineTables(
        np.ascontiguousarray(dofs),
        np.ascontiguousarray(chords / lengths[:, None]),
        np.stack([np.asarray(field)[0, :, 0] for field in ends], axis=1),
        np.stack([field.grad[0, 0, :, 0] for field in ends], axis=1),
        np.ascontiguousarray(basis.dx[:, 0]),
    )
