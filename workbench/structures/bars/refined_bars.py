"""Bars with refined plastic hinges: their state and tables."""

from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array
from workbench.structures.bars import refined_kernels
from workbench.structures.bars.group import Bar, BarElements, first_order
from workbench.structures.elements import Bars, StepEnergies


class RefinedState(NamedTuple):
    """State of refined plastic hinges.

    `local` and `deformation` (e, 3) as of `BarState`; `plastic` elongation (e,); end moments
    `moment` and the rotations that bend it, `turn` (e, 2).
    """

    local: Array
    deformation: Array
    plastic: Array
    moment: Array
    turn: Array


class RefinedTables(NamedTuple):
    """Bars as arrays for the kernels.

    `rows`, `stiffness` and `eta` as of `BarTables`; `squash` loads (e, 2) in tension and
    compression; `reduction` of E; `scale` (e, 3), deformations at yield.
    """

    rows: Any
    squash: Array
    reduction: float
    scale: Array
    stiffness: Array
    eta: float


class RefinedBars(BarElements):
    """Bars with stability functions, tangent modulus and gradual hinges at both ends.

    Arguments: as for `HingedBars`; `reduction` of the elastic modulus.
    """

    kernels: ClassVar[Any] = refined_kernels

    def __init__(
        self,
        nodes: ArrayLike,
        bars: Sequence[Bar],
        reduction: float = 1.0,
        regularisation: float = 1e-6,
        first_order: bool = False,
    ) -> None:
        count, self.reduction, self.regularisation = len(bars), reduction, regularisation
        widths = ((3,), (3,), (), (2,), (2,))
        state = RefinedState(*(np.zeros((count, *width)) for width in widths))
        super().__init__(nodes, bars, state, first_order)

    def place(self, bars: Bars) -> None:
        """Take its place in a structure from the assembly."""
        super().place(bars)
        ends = [(bar.start, bar.end) for bar in self._own]
        squash = np.array([np.min([end.axial for end in pair], axis=0) for pair in ends])
        turn = np.array([max(*a.moments, *b.moments) for a, b in ends]) * self._rows["bending"]
        self._tables = RefinedTables(
            self._rows,
            squash,
            self.reduction,
            np.stack([squash.max(axis=1) * self._rows["axial"], turn, turn], axis=1),
            np.stack([first_order(row) for row in self._rows]),
            self.regularisation,
        )

    def elastic(self, state: Any) -> tuple[Array, float]:
        """Elastic deformations (elements, 3) of a state, with E_t, and their energy in J."""
        stretch = state.local[:, :1] * self._rows["axial"][:, None]
        deformation = np.concatenate([stretch, state.turn], axis=1)
        return deformation, 0.5 * float(np.sum(state.local * deformation))

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step; what is not stored counts as plastic: no energy stands behind."""
        told = super().account(weight)
        lost = told.plastic + told.algorithmic
        return told._replace(plastic=lost, algorithmic=0.0, ideal=lost)
