"""What a run of a frame records at every committed step."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.frames.snapshots import Snapshots
from workbench.frames.structure import FrameStructure
from workbench.structures.ledger import StepEnergies, Tally

Array = NDArray[np.float64]


class Record:
    """Histories of a run; the caller adds the energies of each step before recording it.

    Arguments: the `structure` whose committed state is read; `dof` and `sign` of its displacement;
    `end` of the record, see `Snapshots`.
    """

    def __init__(self, structure: FrameStructure, dof: int, sign: float, end: float | None) -> None:
        self.structure = structure
        self._dof, self._sign = dof, sign
        self._rows: dict[str, list[float]] = {}
        self._tables: dict[str, list[Array]] = {
            "axial_force": [],
            "moment": [],
            "plastic_rotation": [],
        }
        self._shear = np.zeros(len(structure.frame.members))
        self._strains: Array | None = None
        self._snapshots = Snapshots(structure, end)
        self._tally = Tally()

    @property
    def displacement(self) -> float:
        """Committed displacement since the start, along the direction of the record, in m."""
        assembly = self.structure.assembly
        moved = assembly.displacement[self._dof] - self.structure.start[self._dof]
        return self._sign * float(moved)

    @property
    def velocity(self) -> float:
        """Committed velocity along the direction of the record, in m/s."""
        return self._sign * float(self.structure.assembly.velocity[self._dof])

    def add(self, energies: StepEnergies, evaluations: int, cuts: int) -> None:
        """Add the dissipation and the solver cost of a step."""
        self._tally.add(energies, evaluations, cuts)

    def record(self, at: float, *, turns: bool = False, **values: float) -> None:
        """Append the committed state at a time (s) or step, with further `values` by name.

        `turns`, whether a static path ends or turns back here.
        """
        members, assembly = self.structure.members, self.structure.assembly
        for name, (dof, sign) in self.structure.watched.items():
            values[name] = sign * float(assembly.displacement[dof])
        values.update(
            at=at,
            displacement=self.displacement,
            elastic=assembly.stored,
            dissipated=self._tally.dissipated,
            algorithmic=self._tally.algorithmic,
        )
        for name, value in values.items():
            self._rows.setdefault(name, []).append(value)
        self._tables["axial_force"].append(members.axial_forces())
        self._tables["moment"].append(members.moments())
        self._tables["plastic_rotation"].append(members.plastic_rotations())
        self._shear = np.maximum(self._shear, members.shear_forces())
        strains = members.shear_strains()
        if strains is not None:
            self._strains = np.maximum(0.0 if self._strains is None else self._strains, strains)
        self._snapshots.see(at, self.displacement, turns=turns)

    def column(self, name: str) -> Array:
        """History of a scalar (steps,)."""
        return np.array(self._rows[name])

    def columns(self, *names: str) -> dict[str, Any]:
        """Histories of several scalars by name."""
        return {name: self.column(name) for name in names}

    def states(self) -> dict[str, Any]:
        """Variables of hinges, members, watched dofs and snapshots."""
        tables: dict[str, Any] = {
            name: np.stack(rows, axis=1) for name, rows in self._tables.items()
        }
        tables["shear_utilisation"] = self.shear_utilisation()
        watched = self.columns(*self.structure.watched)
        return {**watched, **tables, **self._snapshots.values()}

    def shear_utilisation(self) -> Array:
        """Largest shear force of each member (members,) over its plastic shear resistance."""
        frame = self.structure.frame
        resistance = [frame.properties(member).shear_resistance for member in frame.members]
        return np.asarray(self._shear / np.array(resistance))

    @property
    def shear_strain(self) -> Array | None:
        """Largest mean shear strain of each member (members,); None unless shear yields."""
        return self._strains

    def yield_ratio(self) -> float | None:
        """Plastic work over that of stresses at yield; None without plastic flow."""
        return self._tally.yield_ratio(self.column("elastic").max())

    def diagnostics(self) -> dict[str, float | int]:
        """Numbers about the solution itself, for the attributes of a response."""
        strain = {} if self._strains is None else {"largest_shear_strain": self._strains.max()}
        return {
            "elements": self.structure.elements,
            "smallest_element": self.structure.smallest,
            **strain,
            **self._tally.diagnostics(self.column("elastic").max()),
        }
