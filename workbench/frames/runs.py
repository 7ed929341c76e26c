"""Static paths, impact and ground motion of a frame, from the first step to the response."""

from __future__ import annotations

from collections.abc import Iterator
from math import isclose
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.errors import SolverError
from workbench.frames.accuracy import impact_accuracy, shear_reached, softened
from workbench.frames.collapse import COLLAPSE_SIDEWAYS, CollapseWatch
from workbench.frames.record import Record
from workbench.frames.structure import FrameStructure, hinge_names, member_names
from workbench.responses import Finding, Response, build_response
from workbench.scenarios import FrameGroundMotion, FrameImpact, FrameStatic
from workbench.structures.ground_motion import GroundStep
from workbench.structures.impact import TimeStep
from workbench.structures.paths import PathStep

Array = NDArray[np.float64]
GONE_FAR = 0.3  # movement of a member's ends across its axis, over its length
OPEN_LEDGER = 1e-6  # of the input energy; beyond it a run is a failure, not a result


def run_impact(
    scenario: FrameImpact,
    structure: FrameStructure,
    steps: Iterator[TimeStep],
    largest_error: float | None,
    least_yield_ratio: float,
) -> Response:
    """Follow `steps` of the impact driver on a frame under its dead loads.

    Arguments: `largest_error` of the energy ledger over the input energy (None: whatever it is);
    `least_yield_ratio` without a warning. Raises `SolverError`, and `OutOfDomainError` when the
    frame collapses.
    """
    striker = scenario.striker
    record = Record(structure, *structure.dof(striker.node, striker.direction), scenario.duration)
    watch = CollapseWatch(structure)
    work = loss = length = 0.0
    record.record(
        0.0,
        velocity=0.0,
        striker_velocity=striker.velocity,
        percussion=0.0,
        kinetic=scenario.input_energy,
        external_work=0.0,
        contact_loss=0.0,
    )
    for taken in steps:
        record.add(taken.energies, taken.evaluations, taken.cuts)
        work += taken.external_work
        loss += taken.contact_loss
        length = length or taken.length
        record.record(
            taken.time,
            velocity=record.velocity,
            striker_velocity=taken.striker.velocity,
            percussion=taken.percussion,
            kinetic=taken.kinetic + taken.striker.kinetic_energy,
            external_work=work,
            contact_loss=loss,
        )
        watch.check(f"{taken.time:.4g} s")
    columns = record.columns(
        *("displacement", "velocity", "striker_velocity", "percussion", "kinetic", "elastic"),
        *("dissipated", "external_work", "contact_loss"),
    )
    columns["input_energy"] = scenario.input_energy
    warnings = softened(record, least_yield_ratio) + impact_accuracy(record, scenario.input_energy)
    response = _response(record, columns, warnings, time=record.column("at"), time_step=length)
    _check_ledger(response, largest_error)
    return response


def run_static(
    scenario: FrameStatic, structure: FrameStructure, steps: Iterator[PathStep]
) -> Response:
    """Follow `steps` of a static driver on a frame under its dead loads.

    Raises `SolverError`, and `OutOfDomainError` when an element crumples.
    """
    assembly = structure.assembly
    record = Record(structure, *structure.dof(scenario.node, scenario.direction), None)
    watch = CollapseWatch(structure)
    work = pushed = 0.0
    stops = scenario.path
    record.record(0.0, load_factor=0.0, external_work=0.0, pushed=0.0)
    for count, taken in enumerate(steps, 1):
        record.add(taken.energies, taken.evaluations, taken.cuts)
        work += taken.external_work
        dead = float(assembly.load @ (assembly.displacement - structure.start))
        pushed = work - dead
        reached = taken.factor if scenario.control == "load" else record.displacement
        turns = bool(stops) and isclose(reached, stops[0], rel_tol=1e-9, abs_tol=1e-12)
        stops = stops[1:] if turns else stops
        record.record(
            float(count),
            turns=turns,
            load_factor=taken.factor,
            external_work=work,
            pushed=pushed,
        )
        watch.check(f"step {count}", standing=False)
    columns = record.columns(
        "displacement", "load_factor", "elastic", "dissipated", "external_work"
    )
    force = columns["load_factor"] * scenario.magnitude
    values = {
        **columns,
        "force": force,
        "resistance": np.max(np.abs(force)),
        "input_energy": float(np.max(np.abs(record.column("pushed")))),
    }
    if scenario.control == "load":  # the displacement is an answer
        values["peak_displacement"] = np.max(np.abs(columns["displacement"]))
    warnings = _gone_far(watch, structure, imposed=scenario.control != "load")
    return _response(record, values, warnings)


def run_ground_motion(
    scenario: FrameGroundMotion,
    structure: FrameStructure,
    steps: Iterator[GroundStep],
    least_yield_ratio: float,
) -> Response:
    """Follow `steps` of the driver of ground motion on a frame under its dead loads.

    Displacements and kinetic energy are relative to the ground; what damping takes counts as
    dissipated, the work of the ground as external. The input energy is the largest work of the
    ground so far. Raises `SolverError`, and `OutOfDomainError` when the frame collapses.
    """
    record = Record(structure, *structure.dof(scenario.node, scenario.direction), scenario.duration)
    watch = CollapseWatch(structure)
    ground = dead = damped = length = 0.0
    record.record(0.0, velocity=0.0, kinetic=0.0, external_work=0.0, ground=0.0, damped=0.0)
    for taken in steps:
        record.add(taken.energies, taken.evaluations, taken.cuts)
        ground += taken.input_energy
        dead += taken.external_work
        damped += taken.damped
        length = length or taken.length
        record.record(
            taken.time,
            velocity=record.velocity,
            kinetic=taken.kinetic,
            external_work=ground + dead,
            ground=ground,
            damped=damped,
        )
        watch.check(f"{taken.time:.4g} s")
    columns = record.columns(
        "displacement", "velocity", "kinetic", "elastic", "dissipated", "external_work"
    )
    columns["dissipated"] = columns["dissipated"] + record.column("damped")
    columns["input_energy"] = np.max(np.abs(record.column("ground")))
    warnings = softened(record, least_yield_ratio)
    response = _response(record, columns, warnings, time=record.column("at"), time_step=length)
    _check_ledger(response, OPEN_LEDGER)
    return response


def _response(
    record: Record,
    values: dict[str, Any],
    warnings: list[Finding],
    time: Array | None = None,
    **numbers: float,
) -> Response:
    """The response of a finished run, states of hinges and members and their shear included."""
    frame = record.structure.frame
    response = build_response(
        {**values, **record.states()},
        time=time,
        steps=None if time is not None else len(values["displacement"]),
        hinges=hinge_names(frame),
        segments=member_names(frame),
        members=member_names(frame),
        warnings=shear_reached(record) + warnings,
    )
    response.attrs.update(record.diagnostics(), **numbers)
    return response


def _gone_far(watch: CollapseWatch, structure: FrameStructure, imposed: bool) -> list[Finding]:
    """Whether a frame has changed its shape, under a load or by `imposed` displacements."""
    share, worst = watch.sideways()
    if share <= (COLLAPSE_SIDEWAYS if imposed else GONE_FAR):
        return []
    text = (
        f"the ends of member {structure.frame.members[worst].name} have moved apart across its "
        f"axis by {share:.2f} of its length: "
    )
    if imposed:
        return [Finding("rotation", text + "steel would tear before", number=share)]
    text += "this load is carried by another shape of the frame, beyond its plastic mechanism"
    remedy = "displacement control shows the way there"
    return [Finding("large-displacements", text, remedy=remedy, number=share)]


def _check_ledger(response: Response, largest_error: float | None) -> None:
    error = float(np.max(np.abs(response["balance_error"])) / response["input_energy"])
    if largest_error is not None and error > largest_error:
        raise SolverError("the energy balance", error, "the steps of the driver: reduce them")
