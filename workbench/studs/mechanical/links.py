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
        self.nodes: Indices = np.array([[k.first, k.second] for k in links], dtype=np.int64)
        self._sign = np.array([link.sign for link in links])
        self._law: Indices = np.array([link.law for link in links], dtype=np.int64)
        self._parameters = np.array([[k.stiffness, k.strength, k.peak, k.end] for k in links])
        self.factor, self.cap = np.ones(count), np.ones(count)
        self._state = _kernels.State(
            self.factor, self.cap, *np.zeros((2, count, 2)), *np.zeros((2, count))
        )
        self._force_old = np.zeros(count)
        self._deformation_old, self._deformation = np.zeros(count), np.zeros(count)

    def place(self, dofs: Indices, chords: Array) -> None:
        """Take the dofs (links, 6) from the assembly; links have no length."""
        component = np.array([link.component for link in self.links])
        grounded = np.array([link.grounded for link in self.links])
        rows = np.arange(len(self.links))
        second = np.where(grounded, GROUND, dofs[rows, 3 + component])
        self._layout = _kernels.Layout(
            dofs[rows, component], second, self._sign, self._law, self._parameters
        )
        other = 3 + component
        entry = [7 * component, 6 * component + other, 6 * other + component, 7 * other]
        self._entry: Indices = np.stack(entry, axis=1).astype(np.int64)
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
        layout = self._layout
        _kernels.evaluate(end, layout, self._state)
        joined = np.where(layout.second >= 0, end[layout.second], 0.0)
        self._deformation = self._sign * (end[layout.first] - joined)
        chosen = positions[self._rows, self._entry]
        _kernels.scatter(force, band, chosen, layout, self._state)

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step by the trapezoidal rule; stored is f^2 / 2 K."""
        force, travel = self._state.force, self._deformation - self._deformation_old
        work = 0.5 * (force + self._force_old) * travel
        slope = self._parameters[:, 0] * self.factor
        stored = 0.5 * force**2 / slope
        before = 0.5 * self._force_old**2 / slope
        lost = float(np.sum(work - (stored - before)))
        return StepEnergies(float(np.sum(stored)), lost, 0.0, lost)

    def commit(self) -> None:
        """Make the trial state the committed one."""
        self._state.old[:] = self._state.new
        self._force_old[:] = self._state.force
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
        return self._state.old
