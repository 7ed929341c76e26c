"""The geometrically exact beam as a scikit-fem form: the readable oracle of the compiled kernel.

Virtual work per length, with the director a = (cos phi, sin phi) and its normal b:

  N (a.dr' + t1 dtheta) + V (b.dr' + t2 dtheta) + M dkappa,

t1 = r'.b and t2 = -r'.a at the end of a load step. Over a time step a, b, t1, t2 become those of
the discrete gradient, so that the work over the step is exactly that of the section forces. The
tangent only steers Newton's method and is that of the kernel.
Source: Reissner 1972; Simo 1985; Simo, Tarnow and Doblare 1995.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from skfem import Basis, ElementLineP1, ElementVector, LinearForm, MeshLine
from skfem.helpers import grad

from workbench.base.arrays import Array
from workbench.mechanics.structures.elements import Bars, StepRequest
from workbench.mechanics.structures.fibers.section import ReissnerBeams
from workbench.models.references.fiber_beams import FiberReissner


@LinearForm
def residual(v: Any, w: Any) -> Any:
    """Virtual work of the section forces N, V, M of the step for v = (u, v, theta)."""
    slope = grad(v)[:, 0]
    along = w["a"][0] * slope[0] + w["a"][1] * slope[1] + w["turn"][0] * v[2]
    across = w["b"][0] * slope[0] + w["b"][1] * slope[1] + w["turn"][1] * v[2]
    force = w["force"]
    return force[0] * along + force[1] * across + force[2] * slope[2]


class Directors(NamedTuple):
    """Direction a (2, e), its normal b (2, e) and the lever of a turn (2, e): t1, t2."""

    a: Array
    b: Array
    turn: Array


def directors(initial: Array, rotation: Array, stretch: Array) -> Directors:
    """Directors after a `rotation` (e,) from `initial` (2, e), and levers for r' = `stretch`."""
    c, s = np.cos(rotation), np.sin(rotation)
    a = np.stack([initial[0] * c - initial[1] * s, initial[1] * c + initial[0] * s])
    b = np.stack([-a[1], a[0]])
    return Directors(a, b, np.stack([np.sum(stretch * b, axis=0), -np.sum(stretch * a, axis=0)]))


class ReissnerForms(ReissnerBeams):
    """Geometrically exact beams like those of `ReissnerBeams`, their forces from scikit-fem."""

    def place(self, bars: Bars) -> None:
        """Take its place in a structure from the assembly."""
        super().place(bars)
        self.basis = line_basis(bars.lengths)

    def assemble(self, step: StepRequest) -> None:
        """Add forces, and the kernel's tangent, of a step from the committed state."""
        super().assemble(step._replace(force=np.zeros_like(step.force)))
        basis, bars = self.basis, self.bars
        to_line = np.empty(bars.dofs.size, dtype=np.int64)  # frame dof of every line dof
        to_line[basis.element_dofs.T] = bars.dofs
        at = step.start[to_line], step.end[to_line]
        fields = _fields(basis, (bars.chords / bars.lengths[:, None]).T, *at, step.dynamic)
        fields["force"] = self._new.stress.T[:, :, None]
        np.add.at(step.force, to_line, residual.assemble(basis, **fields))


@dataclass(frozen=True)
class FormsReissner(FiberReissner):
    """The reference of record, assembled by scikit-fem forms."""

    beams = ReissnerForms


def line_basis(lengths: Array) -> Basis:
    """Linear vector basis (u, v, rotation) with one point each, which leaves no locking.

    Every element owns its two nodes on one parameter line, end to end with gaps, so that members
    of a frame may meet in any way.
    """
    gap = float(np.min(lengths))
    starts = np.concatenate([[0.0], np.cumsum(lengths + gap)[:-1]])
    points = np.stack([starts, starts + lengths], axis=1).reshape(1, -1)
    ends = np.ascontiguousarray(np.arange(2 * len(lengths)).reshape(-1, 2).T)
    mesh = MeshLine(np.ascontiguousarray(points), ends, sort_t=False)
    middle = np.array([[0.5]]), np.array([1.0])
    return Basis(mesh, ElementVector(ElementLineP1(), 3), quadrature=middle)


def _fields(
    basis: Any, initial: Array, start: Array, end: Array, dynamic: bool
) -> dict[str, Array]:
    """Directors at the quadrature points, at the end or, in a time step, in the mean."""
    rotation, slope = _at_points(basis, end)
    if not dynamic:
        result = directors(initial, rotation, initial + slope)
    else:
        rotation0, slope0 = _at_points(basis, start)
        half = 0.5 * (rotation - rotation0)
        middle = directors(initial, 0.5 * (rotation0 + rotation), initial + 0.5 * (slope0 + slope))
        share = np.sinc(half / np.pi)
        result = Directors(np.cos(half) * middle.a, np.cos(half) * middle.b, share * middle.turn)
    return {name: value[..., None] for name, value in result._asdict().items()}


def _at_points(basis: Any, x: Array) -> tuple[Array, Array]:
    """Rotation (e,) and derivatives of the translations (2, e) at the quadrature points."""
    field = basis.interpolate(x)
    return np.asarray(field)[2, :, 0], np.asarray(field.grad[:2, 0, :, 0])
