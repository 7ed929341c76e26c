"""Record of a run of a frame at every committed step: histories, and pictures of the frame."""

from operator import attrgetter
from typing import Any, ClassVar

import numpy as np

from workbench.base.arrays import Array, Indices
from workbench.mechanics.frames import collapse
from workbench.mechanics.frames.structure import FrameStructure, upright_names
from workbench.mechanics.structures.paths import PathStep
from workbench.mechanics.structures.time_steps import TimeStep

LEAST_FLOW = 1e-9  # of the stored energy; below it a yield ratio says nothing
FARTHER = 1.0 + 1e-9  # cycles of equal size: the first one counts
EVENLY = 60  # snapshots over the record; one more at the peak
_SHARES = np.linspace(0.0, 1.0 - 1e-9, EVENLY)


class Snapshots:
    """Collects at most `EVENLY` + 1 snapshots while a run passes by.

    Arguments: the `structure`, whose committed state is read; `end` of the record, which starts
    at zero (time in s; None: unknown, snapshots are then even in the number of steps). Evenly
    spaced ones are those of the first step at or after their turn (`turns`, s). That of the peak
    follows the largest displacement by one step in time, and is where a path turns in statics.
    """

    def __init__(self, structure: FrameStructure, end: float | None) -> None:
        self._structure = structure
        self.turns = None if end is None else end * _SHARES
        self._even: list[float] = []
        self._peak: float | None = None
        self._pictures: list[tuple[float, Array, Array]] = []  # times, shapes, utilisation
        self._seen, self._stride, self._next = 0, 1, 0
        self._last: float | None = None
        self._largest = 0.0
        self._rising = False

    def see(self, at: float, displacement: float, *, turns: bool = False) -> None:
        """Look at the committed state at a time (s) or step, with its displacement (m).

        `turns`, whether a static path ends or turns back here.
        """
        size = abs(displacement)
        if self.turns is None:
            drawn = self._count(at, size, turns)
        else:
            drawn = self._follow(self.turns, np.array([at]), np.array([size])).size > 0
        self._last = at
        if drawn:
            self._draw(at)

    def _count(self, at: float, size: float, turns: bool) -> bool:
        """Look at a load step with a displacement of that size; whether it is to be drawn."""
        peak = turns and size > self._largest * FARTHER
        if peak:
            self._largest, self._peak = size, at
        if len(self._even) == 2 * EVENLY:
            self._even = self._even[::2]
            self._stride *= 2
        even = self._seen % self._stride == 0
        if even:
            self._even.append(at)
        self._seen += 1
        return peak or even

    def _follow(self, turns: Array, at: Array, size: Array) -> Indices:
        """Look at times (n,) in s with displacements of that size (m); rows to be drawn."""
        highest = np.maximum.accumulate(np.append(self._largest, size))
        rising = np.append(self._rising, size >= highest[:-1])
        after_peak = np.flatnonzero(rising[:-1] & ~rising[1:])
        passed = np.append(self._next, np.searchsorted(turns, at, side="right"))
        even = np.flatnonzero(passed[1:] > passed[:-1])
        self._largest, self._rising, self._next = float(highest[-1]), rising[-1], passed[-1]
        self._even += at[even].tolist()
        for peak in at[after_peak[-1:]].tolist():
            self._peak = peak
        return np.union1d(even, after_peak[-1:])

    def values(self) -> dict[str, Any]:
        """Variables of the response; the state seen last must still be the committed one."""
        even = self._even
        if self._last is not None and even[-1] != self._last:
            even = [*even, self._last]
        if len(even) > EVENLY:
            even = [even[i] for i in np.linspace(0, len(even) - 1, EVENLY).round().astype(int)]
        shown = even if self._peak is None or self._peak in even else sorted([*even, self._peak])
        if self._last is not None and self._pictures[-1][0] != self._last:
            self._draw(self._last)
        times, shapes, used = zip(*self._pictures, strict=True)
        rows = np.searchsorted(times, shown)
        drawn = np.stack([shapes[row] for row in rows], axis=-1)  # (members, points, 2, pictures)
        return {
            "snapshot_at": shown,
            "shape_x": drawn[:, :, 0],
            "shape_y": drawn[:, :, 1],
            "utilisation": np.stack([used[row] for row in rows], axis=-1),
        }

    def _draw(self, at: float) -> None:
        """Draw a picture of the committed state."""
        members = self._structure.members
        shape = members.shapes(self._structure.assembly)
        self._pictures.append((at, shape, members.utilisation()))


class Record:
    """Histories of a run: numbers of its steps, and the states that they commit.

    Arguments: the `structure` under its dead loads; `node` and `direction` of the displacement;
    `end` of the record in s (None: load steps), see `Snapshots`. Read off as well: `shear_strain`,
    the largest mean one of each member so far (members,), None unless shear yields; `drift`, the
    largest one of each upright member (uprights,).
    """

    pictures: ClassVar[type[Snapshots]] = Snapshots

    def __init__(
        self, structure: FrameStructure, node: str, direction: str, end: float | None
    ) -> None:
        self.structure = structure
        self.watch = collapse.CollapseWatch(structure)
        self._dof, self._sign = structure.dof(node, direction)
        self._timed = end is not None
        self._steps: list[Any] = []
        self._rows: dict[str, list[Any]] = {}
        self._most: Array = np.zeros((2, len(structure.frame.members)))  # shear, that of no panels
        self.drift: Array = np.zeros(len(upright_names(structure.frame)))
        self.shear_strain: Array | None = None
        self._snapshots = self.pictures(structure, end)
        self._begin()

    def _begin(self) -> None:
        """Read the initial state."""
        self._see(0.0, False)

    @property
    def displacement(self) -> Any:
        """Committed displacement since the start, along the direction of the record, in m."""
        structure = self.structure
        moved = structure.assembly.displacement[..., self._dof] - structure.start[self._dof]
        return self._sign * moved

    def take(self, step: TimeStep | PathStep, at: Any, *, turns: bool = False) -> None:
        """Append a step and the state that it has committed, at a time (s) or number of steps.

        `turns`, whether a static path ends or turns back here. Raises `CollapseError` when the
        frame has collapsed, `OutOfDomainError` when an element crumples.
        """
        self._steps.append(step)
        self._see(at, turns)
        self.watch.check(self.displacement, at if self._timed else None)

    def _see(self, at: Any, turns: bool) -> None:
        """Read the committed state, and what it looks like."""
        members, assembly = self.structure.members, self.structure.assembly
        watched, moved = self.structure.watched, self._read(at)
        self._append(
            moment=self.structure.sense * members.moments(),
            dead_work=moved @ assembly.load,
            **{n: sign * assembly.displacement[..., d] for n, (d, sign) in watched.items()},
        )
        for row, shear in enumerate((members.shear_forces(), members.unyielding_shear())):
            np.maximum(self._most[row], _largest(shear), out=self._most[row])
        strains = members.shear_strains()
        if strains is not None:
            known = 0.0 if self.shear_strain is None else self.shear_strain
            self.shear_strain = np.maximum(known, strains)
        self._snapshots.see(at, self._rows["displacement"][-1], turns=turns)

    def _read(self, at: Any) -> Array:
        """Read what the scalars of a response follow from; return the displacements (dofs,)."""
        members, assembly = self.structure.members, self.structure.assembly
        self._append(
            at=at,
            displacement=self.displacement,
            velocity=self._sign * assembly.velocity[..., self._dof],
            elastic=assembly.stored,
            axial_force=members.axial_forces(),
            plastic_rotation=self.structure.sense * members.plastic_rotations(),
            sliding=members.plastic_shear(),
        )
        moved: Array = assembly.displacement - self.structure.start
        self.drift = np.maximum(self.drift, _largest(self.watch.drifts(moved)))
        return moved

    def _append(self, **seen: Any) -> None:
        for name, values in seen.items():
            self._rows.setdefault(name, []).append(values)

    def column(self, name: str) -> Array:
        """History of a scalar (steps,), or of one of each hinge (hinges, steps)."""
        return np.stack(self._rows[name], axis=-1)

    def columns(self, *names: str) -> dict[str, Any]:
        """Histories of several scalars by name."""
        return {name: self.column(name) for name in names}

    def history(self, start: float, name: str) -> Array:
        """History (steps,) of a number of the steps (``energies.plastic``), from `start` on."""
        return np.array([start, *map(attrgetter(name), self._steps)])

    def moving(self, start: float) -> Array:
        """History (steps,) of the kinetic energy of structure and striker (J), from `start`."""
        return self.history(start, "kinetic") + self.history(0.0, "striker.kinetic_energy")

    def total(self, name: str) -> Array:
        """History (steps,) of the sum of that over all steps so far."""
        return np.cumsum(self.history(0.0, name))

    def states(self) -> dict[str, Any]:
        """Variables of hinges, members, watched dofs and snapshots."""
        return {
            **self.columns(*self.structure.watched, "moment"),
            **self.of_parts(),
            "shear_utilisation": self.shear_utilisation(),
            **self._snapshots.values(),
        }

    def of_parts(self) -> dict[str, Any]:
        """Variables of hinges and members that have extremes."""
        webs = () if self._rows["sliding"][0] is None else ("sliding",)
        drift = self.drift if len(self.drift) and not self.structure.is_column else None
        return {**self.columns("axial_force", "plastic_rotation", *webs), "drift": drift}

    def shear_utilisation(self) -> Array:
        """Largest shear force of each member (members,) over its plastic shear resistance."""
        return np.asarray(self._most[0] / self.structure.frame.each("shear_resistance"))

    def unyielding_shear(self) -> Array:
        """Largest mean shear along members where it does not yield (members,), over resistance."""
        return np.asarray(self._most[1] / self.structure.frame.each("shear_resistance"))

    @property
    def dissipated(self) -> Array:
        """History (steps,) of the plastic and algorithmic dissipation, in J."""
        return self.total("energies.plastic") + self.total("energies.algorithmic")

    def yield_ratio(self) -> float | None:
        """Plastic work over that of stresses at yield; None without plastic flow."""
        plastic, ideal = self.total("energies.plastic")[-1], self.total("energies.ideal")[-1]
        if ideal <= LEAST_FLOW * max(self.column("elastic").max(), 1e-300):
            return None
        return float(plastic / ideal)

    def diagnostics(self) -> dict[str, float | int]:
        """Numbers about the solution itself, for the attributes of a response."""
        lengths, structure = self.structure.members.elements.lengths, self.structure
        dead = float(self._sign * structure.start[self._dof])
        sags = any(structure.frame.gravity) or structure.frame.line_loads.any()
        numbers = {
            "dead_displacement": dead if sags else None,
            "elements": len(lengths),
            "smallest_element": float(lengths.min()),
            "newton_iterations": int(self.total("evaluations")[-1]),
            "cut_steps": int(self.total("cuts")[-1]),
            "algorithmic_dissipation": float(self.total("energies.algorithmic")[-1]),
            "largest_shear_strain": None if self.shear_strain is None else self.shear_strain.max(),
            "yield_ratio": self.yield_ratio(),
        }
        return {name: value for name, value in numbers.items() if value is not None}


def _largest(values: Array) -> Array:
    """Of several states (states, n), or of one (n,)."""
    return values if values.ndim == 1 else np.asarray(values.max(axis=0))
