"""What a run of a frame records at every committed step."""

from collections.abc import Callable
from typing import Any

import numpy as np

from workbench.arrays import Array
from workbench.frames.collapse_watch import CollapseWatch
from workbench.frames.snapshots import Snapshots
from workbench.frames.structure import FrameStructure
from workbench.structures.paths import PathStep
from workbench.structures.time_steps import TimeStep

LEAST_FLOW = 1e-9  # of the stored energy; below it a yield ratio says nothing


class Record:
    """Histories of a run: what its steps tell, and the states that they commit.

    Arguments: the `structure` under its dead loads; `node` and `direction` of the displacement;
    `end` of the record in s (None: load steps), see `Snapshots`. Read off as well: `shear_strain`,
    the largest mean one of each member so far (members,), None unless shear yields.
    """

    def __init__(
        self, structure: FrameStructure, node: str, direction: str, end: float | None
    ) -> None:
        self.structure = structure
        self.watch = CollapseWatch(structure)
        self._dof, self._sign = structure.dof(node, direction)
        self._timed = end is not None
        self._steps: list[Any] = []
        self._rows: list[dict[str, float]] = []
        self._tables: dict[str, list[Array]] = {
            name: [] for name in ("axial_force", "moment", "plastic_rotation")
        }
        self._shear = np.zeros(len(structure.frame.members))
        self._drift = self.watch.drifts(self._moved)
        self.shear_strain: Array | None = None
        self._snapshots = Snapshots(structure, end)
        self._see(0.0, False)

    @property
    def displacement(self) -> float:
        """Committed displacement since the start, along the direction of the record, in m."""
        return self._sign * float(self._moved[self._dof])

    @property
    def _moved(self) -> Array:
        return self.structure.assembly.displacement - self.structure.start

    def take(self, step: TimeStep | PathStep, at: float, *, turns: bool = False) -> None:
        """Append a step and the state that it has committed, at a time (s) or number of steps.

        `turns`, whether a static path ends or turns back here. Raises `CollapseError` when the
        frame has collapsed, `OutOfDomainError` when an element crumples.
        """
        self._steps.append(step)
        self._see(at, turns)
        self.watch.check(self.displacement, at if self._timed else None)

    def _see(self, at: float, turns: bool) -> None:
        members, assembly = self.structure.members, self.structure.assembly
        watched = self.structure.watched.items()
        self._rows.append(
            {
                "at": at,
                "displacement": self.displacement,
                "velocity": self._sign * float(assembly.velocity[self._dof]),
                "elastic": assembly.stored,
                "dead_work": float(assembly.load @ self._moved),
                **{name: sign * float(assembly.displacement[dof]) for name, (dof, sign) in watched},
            }
        )
        self._tables["axial_force"].append(members.axial_forces())
        self._tables["moment"].append(members.moments())
        self._tables["plastic_rotation"].append(members.plastic_rotations())
        self._shear = np.maximum(self._shear, members.shear_forces())
        self._drift = np.maximum(self._drift, self.watch.drifts(self._moved))
        strains = members.shear_strains()
        if strains is not None:
            self.shear_strain = np.maximum(
                0.0 if self.shear_strain is None else self.shear_strain, strains
            )
        self._snapshots.see(at, self.displacement, turns=turns)

    def column(self, name: str) -> Array:
        """History of a scalar (steps,)."""
        return np.array([row[name] for row in self._rows])

    def columns(self, *names: str) -> dict[str, Any]:
        """Histories of several scalars by name."""
        return {name: self.column(name) for name in names}

    def told(self, start: float, read: Callable[[Any], float]) -> Array:
        """History (steps,) of what is `read` off a step, from `start`."""
        return np.array([start, *map(read, self._steps)])

    def total(self, read: Callable[[Any], float]) -> Array:
        """History (steps,) of the sum of what is `read` off all steps so far."""
        return np.cumsum(self.told(0.0, read))

    def states(self) -> dict[str, Any]:
        """Variables of hinges, members, watched dofs and snapshots."""
        tables = {name: np.stack(rows, axis=1) for name, rows in self._tables.items()}
        return {
            **self.columns(*self.structure.watched),
            **tables,
            "shear_utilisation": self.shear_utilisation(),
            "drift": self._drift if len(self._drift) else None,
            **self._snapshots.values(),
        }

    def shear_utilisation(self) -> Array:
        """Largest shear force of each member (members,) over its plastic shear resistance."""
        frame = self.structure.frame
        resistance = [frame.properties(member).shear_resistance for member in frame.members]
        return np.asarray(self._shear / np.array(resistance))

    def spent(self, name: str) -> Array:
        """History (steps,) of an entry of `StepEnergies`, summed over all steps so far, in J."""
        return self.total(lambda step: getattr(step.energies, name))

    @property
    def dissipated(self) -> Array:
        """History (steps,) of the plastic and algorithmic dissipation, in J."""
        return self.spent("plastic") + self.spent("algorithmic")

    def yield_ratio(self) -> float | None:
        """Plastic work over that of stresses at yield; None without plastic flow."""
        plastic, ideal = self.spent("plastic")[-1], self.spent("ideal")[-1]
        if ideal <= LEAST_FLOW * max(self.column("elastic").max(), 1e-300):
            return None
        return float(plastic / ideal)

    def diagnostics(self) -> dict[str, float | int]:
        """Numbers about the solution itself, for the attributes of a response."""
        lengths = self.structure.members.elements.lengths
        numbers = {
            "elements": len(lengths),
            "smallest_element": float(lengths.min()),
            "newton_iterations": sum(step.evaluations for step in self._steps),
            "cut_steps": sum(step.cuts for step in self._steps),
            "algorithmic_dissipation": float(self.spent("algorithmic")[-1]),
            "largest_shear_strain": None if self.shear_strain is None else self.shear_strain.max(),
            "yield_ratio": self.yield_ratio(),
        }
        return {name: value for name, value in numbers.items() if value is not None}
