"""The geometrically exact beam as scikit-fem forms: the readable oracle of the compiled kernel.

Virtual work per length, with the director a = (cos phi, sin phi) and its normal b:

  N (a.dr' + t1 dtheta) + V (b.dr' + t2 dtheta) + M dkappa,

t1 = r'.b and t2 = -r'.a at the end of a load step. Over a time step a, b, t1, t2 become those of
the discrete gradient, so that the work over the step is exactly that of the section forces.
Source: Reissner 1972; Simo 1985; Simo, Tarnow and Doblare 1995.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from skfem import BilinearForm, LinearForm
from skfem.helpers import grad

from workbench.structures.elements import Step
from workbench.structures.reissner_beams import ReissnerBeams

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def strain_rates(w: Any, which: str, v: Any) -> tuple[Any, Any, Any]:
    """Variations of Gamma_1, Gamma_2 and kappa for the displacement variation v = (u, v, theta).

    `which` names the directors to use: ``mean`` of the step or ``end``.
    """
    a, b, turn = w[f"{which}_a"], w[f"{which}_b"], w[f"{which}_turn"]
    slope = grad(v)[:, 0]
    along = a[0] * slope[0] + a[1] * slope[1] + turn[0] * v[2]
    across = b[0] * slope[0] + b[1] * slope[1] + turn[1] * v[2]
    return along, across, slope[2]


@LinearForm  # type: ignore[untyped-decorator]
def residual(v: Any, w: Any) -> Any:
    """Virtual work of the section forces N, V, M of the step."""
    rates = strain_rates(w, "mean", v)
    return sum(force * rate for force, rate in zip(w["force"], rates, strict=True))


@BilinearForm  # type: ignore[untyped-decorator]
def material(u: Any, v: Any, w: Any) -> Any:
    """Change of the section forces at the end of the step, at fixed directors."""
    test, trial = strain_rates(w, "mean", v), strain_rates(w, "end", u)
    return sum(test[i] * w["tangent"][i, j] * trial[j] for i in range(3) for j in range(3))


@BilinearForm  # type: ignore[untyped-decorator]
def geometric(u: Any, v: Any, w: Any) -> Any:
    """Change of the directors at fixed section forces of the step."""
    du, dv = grad(u)[:, 0], grad(v)[:, 0]
    by_turn, by_stretch, both = w["by_turn"], w["by_stretch"], w["both"]
    return (
        (by_turn[0] * dv[0] + by_turn[1] * dv[1]) * u[2]
        + v[2] * (by_stretch[0] * du[0] + by_stretch[1] * du[1])
        + v[2] * both * u[2]
    )


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
    """Geometrically exact beams like those of `ReissnerBeams`, assembled by scikit-fem."""

    def assemble(self, step: Step) -> None:
        """Add forces and tangent of a step from the committed state; keep the trial state."""
        tables, basis = self.tables, self.basis
        count = len(tables.measure)
        to_line = np.empty(6 * count, dtype=np.int64)  # frame dof of every line dof: the map T
        to_line[basis.element_dofs.T] = tables.dofs
        old, new, tangent = self.respond(step)
        at = step.start[to_line], step.end[to_line]
        fields = _fields(basis, tables.director.T, *at, step.dynamic)
        share = step.weight
        forces = (1.0 - share) * old.T + share * new.T
        fields["force"] = forces[:, :, None]
        fields["tangent"] = share * np.moveaxis(tangent, 0, -1)[..., None]
        fields.update(_changes(fields, forces, step.dynamic))
        np.add.at(step.force, to_line, residual.assemble(basis, **fields))
        matrix = material.assemble(basis, **fields) + geometric.assemble(basis, **fields)
        # every element owns its line dofs, so that the matrix is a diagonal of 6 x 6 blocks
        entries = matrix.tocoo()
        element, row = np.divmod(_ranks(basis)[entries.row], 6)
        column = _ranks(basis)[entries.col] % 6
        np.add.at(step.band, self.bars.positions[element, 6 * row + column], entries.data)


def _ranks(basis: Any) -> Indices:
    """Place of every line dof in the table of elements (e, 6), read row by row."""
    ranks = np.empty(basis.N, dtype=np.int64)
    ranks[basis.element_dofs.T.reshape(-1)] = np.arange(basis.N)
    return ranks


def _fields(
    basis: Any, initial: Array, start: Array, end: Array, dynamic: bool
) -> dict[str, Array]:
    """Directors at the quadrature points, at the end and, in a time step, in the mean."""
    rotation1, slope1 = _at_points(basis, end)
    stretch1 = initial + slope1
    last = directors(initial, rotation1, stretch1)
    mean = last
    fields: dict[str, Array] = {}
    if dynamic:
        rotation0, slope0 = _at_points(basis, start)
        half = 0.5 * (rotation1 - rotation0)
        mean_stretch = initial + 0.5 * (slope0 + slope1)
        middle = directors(initial, 0.5 * (rotation0 + rotation1), mean_stretch)
        share = np.sinc(half / np.pi)
        mean = Directors(np.cos(half) * middle.a, np.cos(half) * middle.b, share * middle.turn)
        fields.update(middle_a=middle.a, middle_b=middle.b, middle_turn=middle.turn)
        fields.update(share=share, slope=_sinc_slope(half))
    for name, values in (("mean", mean), ("end", last)):
        fields.update({f"{name}_{key}": value for key, value in values._asdict().items()})
    return {name: value[..., None] for name, value in fields.items()}


def _at_points(basis: Any, x: Array) -> tuple[Array, Array]:
    """Rotation (e,) and derivatives of the translations (2, e) at the quadrature points."""
    field = basis.interpolate(x)
    return np.asarray(field)[2, :, 0], np.asarray(field.grad[:2, 0, :, 0])


def _sinc_slope(x: Array) -> Array:
    """Derivative of sin(x)/x."""
    small = np.abs(x) < 1e-3
    safe = np.where(small, 1.0, x)
    slope = (np.cos(safe) - np.sinc(safe / np.pi)) / safe
    return np.asarray(np.where(small, x * (x * x / 30.0 - 1.0 / 3.0), slope))


def _changes(fields: dict[str, Array], forces: Array, step: bool) -> dict[str, Array]:
    """Derivatives of the directors' work at fixed forces, for the geometric tangent."""
    N, V = forces[0, :, None], forces[1, :, None]

    def crossed(name: str) -> Array:
        return np.asarray(N * fields[f"{name}_b"] - V * fields[f"{name}_a"])

    def levers(turn: Array) -> Array:
        """N r'.a + V r'.b from the levers t1 = r'.b and t2 = -r'.a."""
        return np.asarray(V * turn[0] - N * turn[1])

    if not step:
        by_turn = crossed("end")
        return {"by_turn": by_turn, "by_stretch": by_turn, "both": -levers(fields["end_turn"])}
    turn = fields["middle_turn"]
    along = N * turn[0] + V * turn[1]
    return {
        "by_turn": 0.5 * crossed("end"),
        "by_stretch": 0.5 * fields["share"] * crossed("middle"),
        "both": 0.5 * (fields["slope"] * along - fields["share"] * levers(turn)),
    }
