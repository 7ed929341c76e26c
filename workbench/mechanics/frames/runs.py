"""Record of a run of a frame at every committed step: histories, and pictures of the frame.

**Second part.** Static paths, impact and ground motion of a frame, from the first step to the
response.
"""

from collections.abc import Iterator
from math import isclose
from operator import attrgetter
from typing import Any, ClassVar

import numpy as np

from workbench.base.arrays import Array, Indices
from workbench.base.errors import CollapseError, OutOfDomainError, SolverError
from workbench.mechanics.frames import collapse
from workbench.mechanics.frames.collapse import COLLAPSE_SIDEWAYS, sway_collapse, sway_findings
from workbench.mechanics.frames.elastic import slowest_period
from workbench.mechanics.frames.members import SOLID_BOUND, named, shear_reached
from workbench.mechanics.frames.structure import (
    FrameStructure,
    hinge_names,
    member_names,
    upright_names,
)
from workbench.mechanics.structures.impact import TimeStep
from workbench.mechanics.structures.paths import PathStep
from workbench.responses import (
    SCALARS,
    Finding,
    Response,
    build_response,
    energy_error,
    finding,
    peak_of,
)
from workbench.responses.histories import implied, largest_of, open_share, residual_over, unloaded
from workbench.scenarios import (
    ColumnImpact,
    FrameGroundMotion,
    FrameImpact,
    FramePulse,
    FrameScenario,
    FrameStatic,
)

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
        drawn = np.stack([shapes[row] for row in rows], axis=-1)  # (members, points, axes, times)
        return {
            "snapshot_at": shown,
            **{f"shape_{'xyz'[k]}": drawn[:, :, k] for k in range(drawn.shape[2])},
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


GONE_FAR = 0.3  # movement of a member's ends across its axis, over its length
LARGEST_DAMPING = 0.05  # of the input energy, up to the peak; peaks are then 2 to 5 % too small
LEAST_STEPS_TO_PEAK = 30
LEAST_YIELD_RATIO = 0.99  # plastic work over that of stresses at yield
LARGEST_SHEAR_STRAIN = 0.15  # mean of a member; a solid carries 7 % more from there on
OVER = 0.9, 0.99  # of impulse and plastic work, after which little is left but vibrations
YIELDED = 1e-3  # share of plastic work in all energy from which it counts
OPEN_LEDGER = 1e-6  # of the input energy; beyond it a run is a failure, not a result


def run_impact(
    scenario: FrameImpact,
    record: Record,
    steps: Iterator[Any],
    largest_error: float | None,
) -> Response:
    """Follow `steps` of the impact driver on the structure of a `record`, under its dead loads.

    Argument: `largest_error` of the energy ledger over the input energy (None: whatever it is).
    Raises `SolverError`, and `CollapseError` when the frame collapses.
    """
    striker, structure = scenario.striker, record.structure
    _follow(record, scenario, steps)
    values, warnings = _struck(record, scenario)
    values |= record.columns("velocity")
    values["striker_velocity"] = record.history(striker.velocity, "striker.velocity")
    warnings += _softened(record) + _impact_accuracy(record, scenario.input_energy)
    if not structure.is_column:
        key = f"sway {striker.node} {striker.direction}"
        if key not in structure.kept:
            structure.kept[key] = sway_collapse(scenario)
        warnings += sway_findings(structure.kept[key], record.drift)
    return _timed_response(record, scenario, values, warnings, largest_error)


def measure_impact(
    scenario: FrameImpact,
    record: Record,
    steps: Iterator[Any],
    largest_error: float | None,
) -> dict[str, float]:
    """The scalars of the response of `run_impact`, by themselves; raises as it does."""
    _follow(record, scenario, steps)
    values, _ = _struck(record, scenario)
    values |= record.of_parts()
    derived, _ = implied(values, record.column("at"))
    given, balance = scenario.input_energy, derived["balance_error"]
    _check_ledger(open_share(balance, given, values["elastic"][0]) if given else 0.0, largest_error)
    scalars = {name: value for name, value in (derived | values).items() if name in SCALARS}
    return {name: float(value) for name, value in scalars.items() if value is not None}


def _struck(record: Record, scenario: FrameImpact) -> tuple[dict[str, Any], list[Finding]]:
    """Values behind the scalars of an impact, and findings on the residual displacement."""
    striker, impulses = scenario.striker, record.history(0.0, "impulse")
    residual, warnings = _residual(record, scenario, striker, {"percussion": impulses})
    values = {
        **residual,
        **record.columns("displacement", "elastic"),
        "dissipated": record.dissipated,
        "percussion": impulses,
        "kinetic": record.moving(scenario.input_energy),
        "external_work": record.total("external_work"),
        "contact_loss": record.total("contact_loss"),
        "input_energy": scenario.input_energy,
    }
    return values, warnings


def run_static(
    scenario: FrameStatic, structure: FrameStructure, steps: Iterator[PathStep]
) -> Response:
    """Follow `steps` of a static driver on a frame under its dead loads.

    Raises `SolverError`, and `OutOfDomainError` when an element crumples.
    """
    record = Record(structure, scenario.node, scenario.direction, None)
    leads = scenario.control == "load"
    stops = scenario.path
    for count, step in enumerate(steps, 1):
        reached = step.factor if leads else record.displacement
        turns = bool(stops) and isclose(reached, stops[0], rel_tol=1e-9, abs_tol=1e-12)
        stops = stops[1:] if turns else stops
        record.take(step, float(count), turns=turns)
    factor, work = record.history(0.0, "factor"), record.total("external_work")
    force = factor * scenario.magnitude
    values = {
        **record.columns("displacement", "elastic"),
        "dissipated": record.dissipated,
        "load_factor": factor,
        "external_work": work,
        "force": force,
        "resistance": np.max(np.abs(force)),
        "input_energy": np.max(np.abs(work - record.column("dead_work"))),
    }
    if leads:  # the displacement is an answer
        values["peak_displacement"] = largest_of(values["displacement"])
    return _response(record, scenario, values, _gone_far(record, imposed=not leads))


def run_driven(
    scenario: FrameGroundMotion | FramePulse,
    structure: FrameStructure,
    steps: Iterator[Any],
    whole: float = 1.0,
) -> Response:
    """Follow `steps` of the driver of ground motion or of a pulse on a frame under its dead loads.

    Displacements and kinetic energy are relative to the ground; what damping takes counts as
    dissipated, the work of ground or pulse as external, `whole` the force of a pulse of 1. The
    input energy is the largest of that work so far. Raises `SolverError`, and `CollapseError` when
    the frame collapses.
    """
    record = Record(structure, scenario.node, scenario.direction, scenario.duration)
    _follow(record, scenario, steps)
    work, damped = record.total("input_energy"), record.total("damped")
    values = {
        **record.columns("displacement", "velocity", "elastic"),
        "kinetic": record.history(0.0, "kinetic"),
        "dissipated": record.dissipated + damped,
        "external_work": work + record.total("external_work"),
        "input_energy": np.max(np.abs(work)),
    }
    warnings = _softened(record)
    if isinstance(scenario, FramePulse):
        load = values["load"] = scenario.pulse.force(record.column("at")) * whole
        residual, of_it = _residual(record, scenario, scenario, {"load": load})
        values, warnings = values | residual, of_it + warnings
    return _timed_response(record, scenario, values, warnings, OPEN_LEDGER)


def _residual(
    record: Record, scenario: FrameImpact | FramePulse, place: Any, push: dict[str, Array]
) -> tuple[dict[str, Any], list[Finding]]:
    """The residual displacement of a frame, whose sway is slow; of a column see `histories`.

    All that leaves something has happened once the `push` (steps,) by its name and the plastic work
    are over; none where that stays. Argument: the `place`, with node and direction.
    """
    time, moved, spent = record.column("at"), record.column("displacement"), record.dissipated
    if isinstance(scenario, FrameImpact) and scenario.acceleration > 0.0:
        return resting(scenario)
    if record.structure.is_column or not peak_of(time, moved):
        return {}, []
    begin = unloaded(push)
    if begin is None:
        return {"residual_displacement": None}, []
    period = slowest_period(scenario.frame, place.node, place.direction)
    sums = [np.cumsum(np.abs(each)) for each in push.values()]
    if spent[-1] > YIELDED * (record.column("elastic").max() + spent[-1]):
        sums.append(spent)
    shares = zip(sums, OVER, strict=False)
    starts = (float(time[np.argmax(each >= share * each[-1])]) for each, share in shares)
    residual, warnings = residual_over(time, moved, max(float(time[begin]), *starts), period)
    return {"residual_displacement": residual}, warnings


def resting(scenario: FrameImpact | ColumnImpact) -> tuple[dict[str, Any], list[Finding]]:
    """No residual displacement, and why, of a striker that stays on the structure by its weight."""
    if scenario.acceleration <= 0.0:
        return {}, []
    return {"residual_displacement": None}, [finding("striker-rests")]


def _follow(record: Record, scenario: FrameScenario, steps: Iterator[Any]) -> None:
    """Take all time steps.

    Raises `CollapseError` of what turns over, or has turned when steps fail or the record ends.
    """
    watch, findings = record.watch, None
    try:
        for step in steps:
            record.take(step, step.time)
            if findings is None and watch.turned is not None:
                findings = tuple(_shear_reached(record, scenario))
        if watch.turned is not None and not peak_of(
            record.column("at"), record.column("displacement")
        ):
            raise watch.turned
    except (CollapseError, SolverError, OutOfDomainError) as error:
        fallen = error if isinstance(error, CollapseError) else watch.turned
        if fallen is None:
            raise
        if findings is None:  # members that slid mean little before they fell
            findings = tuple(_shear_reached(record, scenario))
        raise CollapseError(fallen.collapse, fallen.reason, findings) from error


def _timed_response(
    record: Record,
    scenario: FrameScenario,
    values: dict[str, Any],
    warnings: list[Finding],
    largest_error: float | None,
) -> Response:
    """The response of a run in time; refused where its energy ledger stays open."""
    if record.watch.turned is not None:
        warnings = [*warnings, finding("hangs-on", reason=record.watch.turned.reason)]
    response = _response(record, scenario, values, warnings, time=record.column("at"))
    response.attrs["time_step"] = float(record.history(0.0, "length").max())
    _check_ledger(energy_error(response), largest_error)
    return response


def _check_ledger(error: float | None, largest_error: float | None) -> None:
    """Raise `SolverError` where the energy ledger stays open."""
    if error is not None and largest_error is not None and error > largest_error:
        raise SolverError("the energy balance", error, "the steps of the driver: reduce them")


def _response(
    record: Record,
    scenario: FrameScenario,
    values: dict[str, Any],
    warnings: list[Finding],
    time: Array | None = None,
) -> Response:
    """The response of a finished run, states of hinges and members and their shear included."""
    frame, structure = record.structure.frame, record.structure
    response = build_response(
        {**values, **record.states()},
        time=time,
        steps=None if time is not None else len(values["displacement"]),
        hinges=structure.hinges or hinge_names(frame),
        segments=member_names(frame),
        members=member_names(frame),
        uprights=() if structure.is_column else upright_names(frame),
        warnings=_shear_reached(record, scenario) + warnings,
    )
    response.attrs.update(record.diagnostics())
    return response


# -- accuracy and limits of a finished run -----------------------------------------------------


def _gone_far(record: Record, imposed: bool) -> list[Finding]:
    """Whether a frame has changed its shape, under a load or by `imposed` displacements."""
    share, worst = record.watch.sideways()
    if share <= (COLLAPSE_SIDEWAYS if imposed else GONE_FAR):
        return []
    name = record.structure.frame.members[worst].name
    return [finding("rotation" if imposed else "large-displacements", share, member=name)]


def _impact_accuracy(record: Record, input_energy: float) -> list[Finding]:
    """Findings on the time steps up to the peak and their damping; `input_energy` in J."""
    findings = []
    displacement, algorithmic = record.column("displacement"), record.total("energies.algorithmic")
    top = int(np.argmax(np.abs(displacement)))
    if top < min(LEAST_STEPS_TO_PEAK, len(displacement) - 1):
        findings.append(finding("few-steps-to-peak", top))
    damped = float(algorithmic[top] / input_energy)
    if damped > LARGEST_DAMPING:
        findings.append(finding("damping", damped, damped=100.0 * damped))
    return findings


def _softened(record: Record) -> list[Finding]:
    """Whether averaging over the steps has softened what yields, by the yield ratio."""
    ratio, least = record.yield_ratio(), LEAST_YIELD_RATIO
    return [] if ratio is None or ratio >= least else [finding("yield-ratio", ratio, least=least)]


def _shear_reached(record: Record, scenario: FrameScenario) -> list[Finding]:
    """Members that passed their plastic shear resistance or, where shear yields, that slide."""
    names = [member.name for member in record.structure.frame.members]
    strains = record.shear_strain
    if strains is not None:
        worst = [names[i] for i in np.argsort(-strains) if strains[i] > LARGEST_SHEAR_STRAIN]
        if not worst:
            return []
        strain, largest = float(strains.max()), LARGEST_SHEAR_STRAIN
        return [finding("shear-strain", strain, members=named(worst), largest=largest)]
    reached = record.unyielding_shear()
    if not (reached > SOLID_BOUND).any():
        return []
    return shear_reached(scenario, dict(zip(names, reached.tolist(), strict=True)))
