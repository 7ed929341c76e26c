"""The concrete around a stud as an element group of the structures floor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workbench.errors import OutOfDomainError
from workbench.structures.ledger import StepEnergies
from workbench.studs.mechanical import _kernels
from workbench.studs.quantities import Array

Indices = NDArray[np.int64]
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


class Links:
    """All links of a stud, with two state buffers; `factor` and `cap` may be set between steps."""

    def __init__(self, links: list[Link]) -> None:
        self.links = tuple(links)
        count = len(links)
        self.nodes: Indices = np.array(
            [[link.first, link.second] for link in links], dtype=np.int64
        )
        self._sign = np.array([link.sign for link in links])
        self._law: Indices = np.array([link.law for link in links], dtype=np.int64)
        self._parameters = np.array(
            [[link.stiffness, link.strength, link.peak, link.end] for link in links]
        )
        self.factor = np.ones(count)
        self.cap = np.ones(count)
        self._old, self._new = np.zeros((count, 2)), np.zeros((count, 2))
        self._force_old, self._force = np.zeros(count), np.zeros(count)
        self._slope = np.zeros(count)
        self._deformation_old, self._deformation = np.zeros(count), np.zeros(count)
        self._first: Indices = np.zeros(0, dtype=np.int64)
        self._second: Indices = np.zeros(0, dtype=np.int64)

    def place(self, dofs: Indices, chords: Array) -> None:
        """Take the dofs (links, 6) from the assembly; links have no length."""
        component = np.array([link.component for link in self.links])
        grounded = np.array([link.grounded for link in self.links])
        rows = np.arange(len(self.links))
        self._first = dofs[rows, component]
        self._second = np.where(grounded, GROUND, dofs[rows, 3 + component])
        entry = np.stack(
            [7 * component, 6 * component + 3 + component, 6 * (3 + component) + component,
             7 * (3 + component)], axis=1,
        )  # fmt: skip
        self._entry: Indices = entry.astype(np.int64)
        self._rows: Indices = rows[:, None]

    def assemble(
        self,
        force: Array,
        band: Array,
        positions: Indices,
        start: Array,
        end: Array,
        weight: float | None,
    ) -> None:
        """Add forces and tangent at the displacements `end`; statics only."""
        if weight is not None:
            raise OutOfDomainError("the links of a stud are made for statics")
        _kernels.evaluate(
            end, self._first, self._second, self._sign, self._law, self._parameters, self.factor,
            self.cap, self._old, self._new, self._force, self._slope,
        )  # fmt: skip
        joined = np.where(self._second >= 0, end[self._second], 0.0)
        self._deformation = self._sign * (end[self._first] - joined)
        chosen = positions[self._rows, self._entry]
        _kernels.scatter(
            force, band, chosen, self._first, self._second, self._sign, self._force, self._slope
        )

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step by the trapezoidal rule; stored is f^2 / 2 K."""
        work = 0.5 * (self._force + self._force_old) * (self._deformation - self._deformation_old)
        slope = self._parameters[:, 0] * self.factor
        stored = 0.5 * self._force**2 / slope
        before = 0.5 * self._force_old**2 / slope
        lost = float(np.sum(work - (stored - before)))
        return StepEnergies(float(np.sum(stored)), lost, 0.0, lost)

    def commit(self) -> None:
        """Make the trial state the committed one."""
        self._old[:] = self._new
        self._force_old[:] = self._force
        self._deformation_old[:] = self._deformation

    def masses(self) -> tuple[Array, Array]:
        """Links have no mass."""
        return np.zeros(len(self.links)), np.zeros(len(self.links))

    @property
    def forces(self) -> Array:
        """Committed forces (links,) in N."""
        return self._force_old

    @property
    def deformations(self) -> Array:
        """Committed deformations (links,) in m."""
        return self._deformation_old

    @property
    def states(self) -> Array:
        """Committed states (links, 2), see the kernels."""
        return self._old
