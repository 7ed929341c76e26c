"""Elastic bars with hinges at their ends: what they consist of, their group, its energies."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array
from workbench.mechanics.structures.elements import Bars, HingedElements, StepEnergies

BAR = np.dtype(
    [
        *((name, float) for name in ("axial", "bending", "geometric", "shear")),
        *((name, float) for name in ("spring1", "spring4", "hardening1", "hardening4")),
        *((name, float) for name in ("low1", "high1", "low4", "high4")),
        *((name, bool) for name in ("pinned1", "pinned4")),
    ]
)
NO_INTERACTION = np.array([[0.0, 1e6], [1.0, 1.0]])


@dataclass(frozen=True)
class PlasticEnd:
    """The hinge at one end of a bar, with its joint; SI units.

    Arguments: `axial` resistance in tension and compression; `moments` that it resists, positive
    and negative; `curve` (2, corners), the share of the moment that is left over |N| over its
    resistance, from 0 on; `stiffness` of the joint in N m/rad (0: a pin); `hardening`, kinematic,
    in N m per rad of plastic rotation; `first_yield`, the share of the moments at which an end
    yields first without N, and `spread` (2, points), how much of the way from there to `curve` it
    has hardened over its accumulated plastic rotation in rad (1 and None: at once); `rotation`
    in rad, over which a hinge would spend the energy that takes all its strength (inf: none), and
    its `softness` in rad/(N m), see `kernels.worn`.
    """

    axial: tuple[float, float]
    moments: tuple[float, float]
    curve: Array
    stiffness: float = inf
    hardening: float = 0.0
    first_yield: float = 1.0
    spread: Array | None = None
    rotation: float = inf
    softness: float = 0.0

    def share(self, side: int, axial: Array) -> Array:
        """Share of the plastic moment left at |N| (n,) in tension (side 0) or compression."""
        return np.asarray(np.interp(axial, self.curve[0] * self.axial[side], self.curve[1]))

    def gauge(self, force: float, moment: float) -> float:
        """Radius of (N, M) over that of the yield curve."""
        n = abs(force) / self.axial[0 if force >= 0.0 else 1]
        m = abs(moment) / self.moments[0 if moment >= 0.0 else 1]
        (n0, n1), (m0, m1) = ((v[:-1], v[1:]) for v in self.curve)
        return float(np.max(((m0 - m1) * n + (n1 - n0) * m) / (m0 * n1 - m1 * n0)))


@dataclass(frozen=True)
class Bar:
    """A beam-column between two plastic ends; SI units.

    Arguments: ends `start` and `end`; `axial_stiffness` EA, `bending_stiffness` EI;
    `mass_per_length`; `shear_stiffness` GA (inf: rigid in shear); `axial_springs`, flexibility of
    both joints along the bar in m/N; `second_order`, whether N bends it between its ends.
    """

    start: PlasticEnd
    end: PlasticEnd
    axial_stiffness: float
    bending_stiffness: float
    mass_per_length: float
    shear_stiffness: float = inf
    axial_springs: float = 0.0
    second_order: bool = True

    def row(self, length: float) -> tuple[Any, ...]:
        """Entries of BAR for a `length` in m."""
        one, four = self.start, self.end
        return (
            length / self.axial_stiffness + self.axial_springs,
            length / self.bending_stiffness,
            0.25 * length**2 / self.bending_stiffness if self.second_order else 0.0,
            1.0 / (length * self.shear_stiffness),
            *(1.0 / end.stiffness if end.stiffness > 0.0 else 0.0 for end in (one, four)),
            *(0.0 if end.stiffness == 0.0 else end.hardening for end in (one, four)),
            *(-one.moments[0], one.moments[1], -four.moments[1], four.moments[0]),
            *(end.stiffness == 0.0 for end in (one, four)),
        )

    def corners(self) -> tuple[Array, Array]:
        """|N| with the shares of both moments that are left (corners, 3), tension, compression."""
        sides = []
        for side in range(2):
            ends = (self.start, self.end)
            most = min(end.curve[0, -1] * end.axial[side] for end in ends)
            at = np.unique(np.concatenate([end.curve[0] * end.axial[side] for end in ends]))
            at = np.append(at[at < most * (1.0 - 1e-12)], most)
            sides.append(np.stack([at, *(end.share(side, at) for end in ends)], axis=1))
        return sides[0], sides[1]


class BarElements(HingedElements):
    """Two-node elastic bars; all plastic deformation is reported at their ends.

    The kinds are `hinged_bars`, `refined_bars` and `fiber_bars`: each has its compiled `kernels`,
    its empty `state`, the `tables` of the kernels, made of the rows of BAR and the lengths, and the
    `elastic` deformations (e, 3) under the forces of a state with their energy in J. The first two
    entries of a state are `local` forces N, M_1, M_4 and `deformation`: elongation and end
    rotations against the chord, both (e, 3). The plastic deformation of a bar is what its forces do
    not explain elastically. Arguments: `nodes` (elements, 2); `bars` (elements,); these;
    `first_order`, equilibrium of the undeformed structure; whether the law is `conservative`.
    """

    def __init__(
        self,
        nodes: ArrayLike,
        bars: Sequence[Bar],
        kernels: Any,
        state: Any,
        tables: Callable[[Any, Array], Any],
        elastic: Callable[[Any, Any], tuple[Array, float]],
        first_order: bool,
        conservative: bool = True,
    ) -> None:
        mass = np.array([bar.mass_per_length for bar in bars])
        bends = np.array([1.0 / bar.bending_stiffness for bar in bars])
        super().__init__(nodes, state, mass, bends, first_order)
        self.kernels, self._bars, self._make_tables = kernels, list(bars), tables
        self._elastic, self._conservative = elastic, conservative

    def place(self, bars: Bars) -> None:
        """Take its place in a structure from the assembly."""
        super().place(bars)
        rows = [bar.row(length) for bar, length in zip(self._bars, self.lengths, strict=True)]
        self._rows: Any = np.array(rows, dtype=BAR)
        self.tables = (self._make_tables(self._rows, self.lengths),)

    def elastic(self, state: Any) -> tuple[Array, float]:
        """Elastic deformations (elements, 3) under the forces of a state, and their energy in J."""
        return self._elastic(self._rows, state)

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step from the committed state to the one assembled last.

        What the work of the forces leaves beside stored energy and plastic work is algorithmic,
        but plastic where no energy stands behind the law, and the half of the work that elastic
        springs take as they soften under the old moments. Fibers have their own account.
        """
        if hasattr(self.kernels, "account"):
            return super().account(weight)
        old, new = self._old, self._new
        (before, held), (after, stored) = self.elastic(old), self.elastic(new)
        change = new.deformation - old.deformation
        flow = change - (after - before)
        force = weight * new.local + (1.0 - weight) * old.local
        plastic, ideal = float(np.sum(force * flow)), float(np.sum(new.local * flow))
        if hasattr(new, "strength") and np.any(new.strength != old.strength):
            softer, _ = self.elastic(new._replace(local=old.local))
            damage = 0.5 * float(np.sum((softer - before) * old.local))
            plastic, ideal = plastic + damage, ideal + damage
        lost = float(np.sum(force * change)) - (stored - held)
        if self._conservative:
            return StepEnergies(stored, plastic, lost - plastic, ideal)
        return StepEnergies(stored, lost, 0.0, lost)

    @property
    def elongations(self) -> Array:
        """Committed change of chord length of the elements (elements,), in m."""
        return np.asarray(self._old.deformation[:, 0])

    @property
    def plastic(self) -> Array:
        """Committed plastic deformations (elements, 4), all of the elongation at the start."""
        u, first, last = (self._old.deformation - self.elastic(self._old)[0]).T
        return np.stack([u, first, np.zeros_like(u), last], axis=1)

    @property
    def strength_left(self) -> Array:
        """Committed shares of their strength that worn hinges have left (elements, 2)."""
        whole = np.ones((len(self._bars), 2))
        return np.asarray(getattr(self._old, "left", whole))

    def utilisation(self) -> Array:
        """Radius of N and M over that of the yield curve at both ends (elements, 2)."""
        n, m1, m4 = self._old.local.T
        one, four = np.transpose(getattr(self._old, "strength", self.strength_left))
        return np.array(
            [
                (bar.start.gauge(n, -m1), bar.end.gauge(n, m4))
                for bar, n, m1, m4 in zip(self._bars, n, m1 / one, m4 / four, strict=True)
            ]
        )


def first_order_stiffness(row: Any) -> Array:
    """Elastic stiffness (3, 3) of a row of BAR without axial force."""
    near, far = row["bending"] / 3.0 + row["shear"], -row["bending"] / 6.0 + row["shear"]
    stiffness = np.zeros((3, 3))
    stiffness[0, 0] = 1.0 / row["axial"]
    free = [i for i, end in ((1, "1"), (2, "4")) if not row[f"pinned{end}"]]
    both = np.array([[near + row["spring1"], far], [far, near + row["spring4"]]])
    if free:
        kept = np.array(free)
        stiffness[np.ix_(kept, kept)] = np.linalg.inv(both[np.ix_(kept - 1, kept - 1)])
    return stiffness
