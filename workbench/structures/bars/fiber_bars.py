"""Force-based elements with fiber sections at points along the member."""

from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array, Flags
from workbench.structures.bars import fiber_kernels
from workbench.structures.bars.group import Bar, BarElements
from workbench.structures.elements import Bars, MemberElements, StepEnergies
from workbench.structures.fibers import BeamSection, lobatto
from workbench.structures.fibers.section import SectionTables, section_tables


class Rule(NamedTuple):
    """Quadrature along one element: points `xi` in 0..1, `weights`, which are `elastic`."""

    xi: Array
    weights: Array
    elastic: Flags


def lobatto_rule(points: int) -> Rule:
    """Gauss-Lobatto points, fibers at all."""
    return Rule(*lobatto(points), np.zeros(points, dtype=bool))


def hinge_rule(share: float) -> Rule:
    """Fibers at both ends, over a `share` of the length each; elastic points between.

    Two-point Gauss-Radau over four hinge lengths at each end, of which the inner point is elastic,
    and two Gauss points between: exact while all is elastic (Scott and Fenves 2006).
    """
    s = min(share, 0.125)
    half, root = 0.5 - 4.0 * s, 1.0 / np.sqrt(3.0)
    side = [0.0, 8.0 / 3.0 * s, 0.5 - half * root]
    weights = [s, 3.0 * s, half]
    elastic = [False, True, True]
    return Rule(
        np.array([*side, *(1.0 - x for x in reversed(side))]),
        np.array([*weights, *reversed(weights)]),
        np.array([*elastic, *reversed(elastic)]),
    )


class FiberBarState(NamedTuple):
    """State of all elements.

    `local` and `deformation` (e, 3) as of `BarState`; `strains` (e, points, 2), axial strain and
    curvature; `fibers` (e, points, states, f).
    """

    local: Array
    deformation: Array
    strains: Array
    fibers: Array


class FiberBarTables(NamedTuple):
    """What the kernels take besides bars and states.

    `xi`, `weights` and `elastic` (e, points) of the rule; `lengths` (e,); `rest` (e, 3, 3),
    flexibility of joints and shear; `pinned` (e, 2); `scale` (e, 2) of N and M; `modulus`, `area`,
    `second` moment (e,) of the elastic points; `sections` of fibers.
    """

    xi: Array
    weights: Array
    elastic: Flags
    lengths: Array
    rest: Array
    pinned: Flags
    scale: Array
    modulus: Array
    area: Array
    second: Array
    sections: SectionTables


class FiberBars(BarElements):
    """Force-based beams.

    Arguments: as for `BarElements`; `rules` and `sections` (elements,), all rules with as many
    points.
    """

    kernels: ClassVar[Any] = fiber_kernels

    def __init__(
        self,
        nodes: ArrayLike,
        bars: Sequence[Bar],
        rules: Sequence[Rule],
        sections: Sequence[BeamSection],
        first_order: bool = False,
    ) -> None:
        count, points = len(bars), len(rules[0].xi)
        self._rules, self._moduli = rules, [s.law.elastic_modulus for s in sections]
        self._sections = section_tables(np.arange(count), sections)
        states = max(section.law.states for section in sections)
        fibers = np.zeros((count, points, states, self._sections.y.shape[1]))
        wide = np.zeros((count, 3))
        state = FiberBarState(wide, wide.copy(), np.zeros((count, points, 2)), fibers)
        super().__init__(nodes, bars, state, first_order)

    def place(self, bars: Bars) -> None:
        """Take its place in a structure from the assembly."""
        super().place(bars)
        rows, modulus = self._rows, np.array(self._moduli)
        area, second = np.sum(self._sections.area, axis=1), self._sections.second
        rest = np.zeros((len(rows), 3, 3))
        rest[:, 0, 0] = [bar.axial_springs for bar in self._own]
        rest[:, 1:, 1:] = rows["shear"][:, None, None]
        rest[:, 1, 1] += rows["spring1"]
        rest[:, 2, 2] += rows["spring4"]
        depth = 2.0 * np.max(np.abs(self._sections.y), axis=1)
        force = modulus * area * 1e-3
        self._tables = FiberBarTables(
            np.stack([rule.xi for rule in self._rules]),
            np.stack([rule.weights for rule in self._rules]),
            np.stack([rule.elastic for rule in self._rules]),
            self.lengths,
            rest,
            np.stack([rows["pinned1"], rows["pinned4"]], axis=1),
            np.stack([force, force * depth], axis=1),
            modulus,
            area,
            second,
            self._sections,
        )

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step, those of the fibers."""
        return MemberElements.account(self, weight)
