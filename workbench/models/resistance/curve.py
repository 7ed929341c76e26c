"""A resistance curve: a piecewise polynomial force over displacement with named events."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from workbench.errors import OutOfDomainError
from workbench.models.resistance import _kernels
from workbench.models.resistance.mechanism import Mechanism

Array = NDArray[np.float64]


class Event(NamedTuple):
    """Something that happens along a curve: its name, displacement (m) and force (N)."""

    name: str
    displacement: float
    force: float


@dataclass(frozen=True, eq=False)
class ResistanceCurve:
    """Monotonic resistance of the column at its hit point.

    Arguments: `shape`, its name; `mechanism` it belongs to; `starts` (n,), displacements (m) at
    which the pieces begin, the last one without end; `coefficients` (n, 4) of the force in
    x = v - start (N, N/m, ...); `elastic_limit`, displacement of the first yielding (m); `names`
    of the events at the starts from the second on (empty: no event); `axial` (n, 3), coefficients
    of the axial force, and `plastic` (n, groups), which groups are plastic, where the shape
    knows them. Negative displacements mirror the curve.
    """

    shape: str
    mechanism: Mechanism
    starts: Array
    coefficients: Array
    elastic_limit: float
    names: tuple[str, ...]
    axial: Array | None = None
    plastic: NDArray[np.bool_] | None = None

    @property
    def initial_stiffness(self) -> float:
        """Slope k_0 at no displacement, in N/m."""
        return float(self.coefficients[0, 1])

    @property
    def breakpoints(self) -> Array:
        """Displacements at which one piece meets the next, in m."""
        return self.starts[1:]

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """What happens along the curve, in order."""
        places = zip(self.names, self.breakpoints.tolist(), strict=True)
        return tuple(Event(name, v, float(self.force(v))) for name, v in places if name)

    @cached_property
    def table(self) -> Array:
        """The curve as the kernels take it (n, columns)."""
        table: Array = _kernels.tabulate(self.starts, self.coefficients)
        return table

    @cached_property
    def lost_at(self) -> float:
        """Displacement at which the resistance falls to zero, in m (inf: it never does)."""
        return float(_kernels.lost_at(self.table))

    def _local(self, displacement: ArrayLike) -> tuple[NDArray[np.intp], Array, Array]:
        v = np.asarray(displacement, dtype=float)
        piece = np.searchsorted(self.starts, np.abs(v), side="right") - 1
        return piece, np.abs(v) - self.starts[piece], np.sign(v)

    def force(self, displacement: ArrayLike) -> Array:
        """Force (N) at displacements (m), any shape."""
        piece, x, sign = self._local(displacement)
        c = np.moveaxis(self.coefficients[piece], -1, 0)
        return np.asarray(sign * (c[0] + x * (c[1] + x * (c[2] + x * c[3]))))

    def tangent(self, displacement: ArrayLike) -> Array:
        """Slope (N/m) at displacements (m), any shape; at a breakpoint that of the piece after."""
        piece, x, _ = self._local(displacement)
        c = np.moveaxis(self.coefficients[piece], -1, 0)
        return np.asarray(c[1] + x * (2.0 * c[2] + 3.0 * x * c[3]))

    def work(self, displacement: ArrayLike) -> Array:
        """Work (J) of the force from the origin to displacements (m), any shape."""
        piece, x, _ = self._local(displacement)
        c = np.moveaxis(self.coefficients[piece], -1, 0)
        within = x * (c[0] + x * (c[1] / 2.0 + x * (c[2] / 3.0 + x * c[3] / 4.0)))
        return np.asarray(self.table[piece, _kernels.WORK] + within)

    def unloading_stiffness(self, displacement: float) -> float:
        """Slope (N/m) of the unloading from a displacement (m) that has yielded.

        The initial slope, as Heng 2017 has it; where the curve has been steeper than that (a
        slender column in tension), its steepest slope, or unloading would return more energy
        than was put in.
        """
        return float(_kernels.unloading_stiffness(self.table, abs(displacement)))

    def residual(self, displacement: float) -> float:
        """Permanent displacement (m) after unloading from `displacement` (m)."""
        if displacement <= self.elastic_limit:
            return 0.0
        return displacement - float(self.force(displacement)) / self.unloading_stiffness(
            displacement
        )

    def displacement_at(self, energy: float) -> float:
        """Displacement (m) at which the work reaches `energy` (J).

        Raises `OutOfDomainError` if the resistance is lost before.
        """
        if energy <= 0.0:
            return 0.0
        lost = self.lost_at
        if np.isfinite(lost) and energy >= self.work(lost):
            raise OutOfDomainError(
                f"the resistance of the column is lost at {lost:.4g} m, after "
                f"{float(self.work(lost)) / 1e3:.4g} kJ of the {energy / 1e3:.4g} kJ to absorb"
            )
        return float(_kernels.displacement_at(self.table, energy, lost))

    def axial_force(self, displacement: ArrayLike) -> Array:
        """Axial force (N, tension positive) at displacements (m) on the curve.

        Raises ValueError for a shape that does not know it.
        """
        if self.axial is None:
            raise ValueError(f"the {self.shape} resistance does not know the axial force")
        piece, x, _ = self._local(displacement)
        c = np.moveaxis(self.axial[piece], -1, 0)
        return np.asarray(c[0] + x * (c[1] + x * c[2]))

    def moments(self, displacement: ArrayLike) -> Array:
        """Moments (N m) of the groups, (groups, ...), at displacements (m) >= 0 on the curve.

        All are positive; raises ValueError for a shape that does not know them.
        """
        if self.plastic is None:
            raise ValueError(f"the {self.shape} resistance does not know the hinge moments")
        v = np.asarray(displacement, dtype=float)
        piece, _, _ = self._local(v)
        share = np.abs(self.axial_force(v)) / self.mechanism.squash_load
        capacity = self.mechanism.plastic_moment * (1.0 - share)
        elastic = np.multiply.outer(self.mechanism.moments_per_displacement, v)
        plastic = np.moveaxis(self.plastic[piece], -1, 0)
        return np.where(plastic, capacity, elastic)

    def plastic_rotations(self, displacement: ArrayLike) -> Array:
        """Plastic rotations (rad) of the groups, (groups, ...), as `moments`."""
        v = np.asarray(displacement, dtype=float)
        flexibility = self.mechanism.flexibilities.reshape((-1,) + (1,) * v.ndim)
        turned = np.multiply.outer(self.mechanism.rotation_rates, v)
        return np.asarray(turned - flexibility * self.moments(v))

    def largest_shear(self, displacement: float) -> Array:
        """Largest shear force (N) of the bars below and above met up to `displacement` (m).

        V = (sum of the moments at both ends) / length; piecewise quadratic, so its extremes lie
        at the breakpoints or at extremes of the axial force. Raises ValueError as `moments`.
        """
        if self.axial is None:
            raise ValueError(f"the {self.shape} resistance does not know the hinge moments")
        n1, n2 = self.axial[:, 1], self.axial[:, 2]
        curved = n2 > 0.0
        extremes = self.starts[curved] - 0.5 * n1[curved] / n2[curved]
        places = np.concatenate([self.starts, extremes, [displacement]])
        places = places[(places >= 0.0) & (places <= displacement)]
        # a breakpoint belongs to the piece after it; moments are continuous there
        groups, moments = self.mechanism.groups, self.moments(places)
        shear = np.empty(2)
        for bar, (end, length) in enumerate(
            zip(("base", "head"), self.mechanism.lengths, strict=True)
        ):
            both = moments[groups.index("hit")].copy()
            if end in groups:
                both += moments[groups.index(end)]
            shear[bar] = both.max() / length
        return shear
