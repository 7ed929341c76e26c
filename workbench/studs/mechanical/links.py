"""The concrete around a stud as an element group of the structures floor."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.arrays import Indices
from workbench.errors import OutOfDomainError
from workbench.structures.elements import Bars, ElementGroup, Step, StepEnergies
from workbench.studs.mechanical import kernels
from workbench.studs.quantities import Array

AXIAL, LATERAL = 0, 1  # component u along the stud, v across it
GROUND = -1


@dataclass(frozen=True, slots=True)
class Link:
    """One link: nodes and component it joins, law and parameters.

    `grounded`: the link joins the first node to the ground, and the second is only a neighbour of
    it (an element group of the structures floor has two nodes); `sign` of the deformation s =
    sign (q_first - q_second); `stiffness` K in N/m, `strength` F in N; `peak` and `end`
    deformation of the cone in m.
    """

    law: int
    first: int
    second: int
    component: int
    stiffness: float
    strength: float = np.inf
    sign: float = 1.0
    peak: float = 1.0
    end: float = 2.0
    grounded: bool = False


class LinkState(NamedTuple):
    """States (links, 2), see the kernels; forces in N, their slopes in N/m, deformations in m."""

    inner: Array
    force: Array
    slope: Array
    deformation: Array


class LinkTables(NamedTuple):
    """Links as arrays: dofs (or `GROUND`), sign, law, and `parameters` K, F, peak, end."""

    first: Indices
    second: Indices
    sign: Array
    law: Indices
    parameters: Array


class Links(ElementGroup):
    """All links of a stud; `factor` and `cap` may be set between steps."""

    _old: LinkState
    _new: LinkState

    def __init__(self, links: list[Link]) -> None:
        count = len(links)
        state = LinkState(np.zeros((count, 2)), *np.zeros((3, count)))
        super().__init__([[link.first, link.second] for link in links], state)
        self.links = tuple(links)
        self.factor = np.ones(count)
        self.cap = np.ones(count)

    def place(self, bars: Bars) -> None:
        """Take its place in a structure; links have no length."""
        super().place(bars)
        component = np.array([link.component for link in self.links])
        grounded = np.array([link.grounded for link in self.links])
        rows = np.arange(len(self.links))
        self._tables = LinkTables(
            bars.dofs[rows, component],
            np.where(grounded, GROUND, bars.dofs[rows, 3 + component]),
            np.array([link.sign for link in self.links]),
            np.array([link.law for link in self.links], dtype=np.int64),
            np.array([[k.stiffness, k.strength, k.peak, k.end] for k in self.links]),
        )
        near, far = component, 3 + component
        entry = np.stack([7 * near, 6 * near + far, 6 * far + near, 7 * far], axis=1)
        self._chosen: Indices = bars.positions[rows[:, None], entry]

    def assemble(self, step: Step) -> None:
        """Add forces and tangent of a static step; keep the trial state."""
        if step.dynamic:
            raise OutOfDomainError("the links of a stud are made for statics")
        kernels.evaluate(step.end, self._tables, self.factor, self.cap, self._old, self._new)
        kernels.scatter(step.force, step.band, self._tables, self._chosen, self._new)

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step by the trapezoidal rule; stored is f^2 / 2 K."""
        old, new = self._old, self._new
        work = 0.5 * (new.force + old.force) * (new.deformation - old.deformation)
        slope = self._tables.parameters[:, 0] * self.factor
        stored = 0.5 * new.force**2 / slope
        before = 0.5 * old.force**2 / slope
        lost = float(np.sum(work - (stored - before)))
        return StepEnergies(float(np.sum(stored)), lost, 0.0, lost)

    @property
    def state(self) -> LinkState:
        """The committed state."""
        return self._old
