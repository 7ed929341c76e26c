"""Static paths, impact and ground motion of a frame, from the first step to the response."""

from collections.abc import Iterator
from math import isclose
from typing import Any

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import CollapseError, OutOfDomainError, SolverError
from workbench.mechanics.frames.collapse import COLLAPSE_SIDEWAYS, sway_collapse, sway_findings
from workbench.mechanics.frames.elastic import slowest_period
from workbench.mechanics.frames.members import SOLID_BOUND, named, shear_reached
from workbench.mechanics.frames.record import Record
from workbench.mechanics.frames.structure import (
    FrameStructure,
    hinge_names,
    member_names,
    upright_names,
)
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
