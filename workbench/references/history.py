"""What a reference run records at every committed step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from workbench.references.column_beams import ColumnBeams
from workbench.structures.ledger import StepEnergies, Tally

Array = NDArray[np.float64]


class History:
    """Records of a column run; the caller adds the energies of each step before recording it.

    Argument: `beams`, the column whose committed state is recorded.
    """

    def __init__(self, beams: ColumnBeams) -> None:
        self._beams = beams
        self._rows: dict[str, list[float]] = {}
        self._tables: dict[str, list[Array]] = {
            "axial_force": [],
            "moment": [],
            "plastic_rotation": [],
            "shear": [],
            "shear_strain": [],
        }
        self._tally = Tally()

    def add(self, energies: StepEnergies, evaluations: int, cuts: int) -> None:
        """Add the dissipation and the solver cost of a step."""
        self._tally.add(energies, evaluations, cuts)

    def record(self, **values: float) -> None:
        """Append the committed state, with further `values` of the driver by name."""
        beams = self._beams
        values.update(
            shortening=beams.shortening(),
            elastic=beams.assembly.stored,
            dissipated=self._tally.dissipated,
            algorithmic=self._tally.algorithmic,
        )
        for name, value in values.items():
            self._rows.setdefault(name, []).append(value)
        self._tables["axial_force"].append(beams.axial_forces())
        self._tables["moment"].append(beams.moments())
        self._tables["plastic_rotation"].append(beams.plastic_rotations())
        self._tables["shear"].append(beams.shear_forces())
        self._tables["shear_strain"].append(beams.shear_strains())

    def column(self, name: str) -> Array:
        """History of a scalar (steps,)."""
        return np.array(self._rows[name])

    def table(self, name: str) -> Array:
        """History at the watched sections (sections, steps)."""
        return np.stack(self._tables[name], axis=1)

    def shear_utilisation(self) -> Array:
        """Largest mean shear force of each segment (2,) over the plastic shear resistance."""
        largest = np.max(np.abs(self.table("shear")), axis=1)
        return np.asarray(largest / self._beams.column.properties.shear_resistance)

    @property
    def shear_yields(self) -> bool:
        """Whether the shear force is limited by yielding."""
        return self._beams.shear_yields

    def shear_strain(self) -> Array:
        """Largest mean shear strain of each segment (2,)."""
        return np.asarray(np.max(np.abs(self.table("shear_strain")), axis=1))

    def yield_ratio(self) -> float | None:
        """Plastic work over that of stresses at yield; None without plastic flow."""
        return self._tally.yield_ratio(self.column("elastic").max())

    def diagnostics(self) -> dict[str, float | int]:
        """Numbers about the solution itself, for the attributes of a response."""
        return {
            "largest_shear_strain": float(self.shear_strain().max()),
            "elements": len(self._beams.beams.lengths),
            "smallest_element": float(self._beams.beams.lengths.min()),
            **self._tally.diagnostics(self.column("elastic").max()),
        }
