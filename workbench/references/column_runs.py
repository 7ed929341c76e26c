"""Impact and pushover of a column of beams, from the first step to the response."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from workbench.errors import OutOfDomainError
from workbench.frames.accuracy import impact_accuracy
from workbench.references.column_beams import SEGMENTS, WATCHED, ColumnBeams
from workbench.references.history import History
from workbench.responses import Finding, Response, build_response
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, ColumnScenario
from workbench.structures.explicit import explicit_impact
from workbench.structures.impact import PointMass, impact
from workbench.structures.statics import push

Array = NDArray[np.float64]
LEAST_YIELD_RATIO = 0.995
LARGEST_SHEAR_STRAIN = 0.3  # mean of a segment
COLLAPSE_SIDEWAYS = 0.9  # displacement of the hit point over the shorter segment
COLLAPSE_SHORTENING = 0.55  # of the length: the same geometry for a hit at mid-height
COLLAPSE_CONTRACTION = 0.1  # of the length, along the axis: squashed
LEAST_LENGTH = 0.05  # of an element; plastic strains have lost all meaning long before


PUSH_STEPS = 1000  # load steps of a pushover before refinement


def run_column(
    scenario: ColumnScenario,
    build: Callable[[ColumnScenario], ColumnBeams],
    spans: Callable[[ColumnImpact], Sequence[tuple[float, float]]],
    refinement: int,
    weight: float | None,
) -> Response:
    """Build a column and push or hit it.

    Arguments: `build` gives the column under its axial load; `spans` the end times and time steps
    (s) of an impact; `refinement` halves the load steps; `weight` of the end stresses in a time
    step (None: explicit). Raises `SolverError`, `OutOfDomainError`.
    """
    with threadpool_limits(1, user_api="blas"):  # band solves are far too small for threads
        beams = build(scenario)
        if isinstance(scenario, ColumnPushover):
            return run_pushover(scenario, beams, round(PUSH_STEPS * 2.0**refinement))
        return run_impact(scenario, beams, spans(scenario), weight)


def run_impact(
    scenario: ColumnImpact,
    beams: ColumnBeams,
    spans: Sequence[tuple[float, float]],
    weight: float | None,
) -> Response:
    """Hit the column and follow it for the scenario's duration.

    Arguments: `beams` under its axial load; `spans`, end times and time steps of the parts of the
    record (s); `weight` of the end stresses, or None for explicit steps with central differences
    (then the time steps are those of the record, and bounds of the explicit ones).
    Raises `SolverError`, and `OutOfDomainError` when the column collapses.
    """
    assembly, striker = beams.assembly, scenario.striker
    history = History(beams)
    work = loss = 0.0
    history.record(
        time=0.0,
        displacement=0.0,
        velocity=0.0,
        striker_velocity=striker.velocity,
        percussion=0.0,
        kinetic=scenario.input_energy,
        external_work=0.0,
        contact_loss=0.0,
    )
    mass = PointMass(striker.mass, striker.velocity, striker.restitution)
    if weight is None:
        steps = explicit_impact(assembly, beams.hit, mass, spans, spans[0][1])
    else:
        steps = impact(assembly, beams.hit, mass, spans, weight)
    for taken in steps:
        history.add(taken.energies, taken.evaluations, taken.cuts)
        work += taken.external_work
        loss += taken.contact_loss
        history.record(
            time=taken.time,
            displacement=float(assembly.displacement[beams.hit]),
            velocity=float(assembly.velocity[beams.hit]),
            striker_velocity=taken.striker.velocity,
            percussion=taken.percussion,
            kinetic=taken.kinetic + taken.striker.kinetic_energy,
            external_work=work,
            contact_loss=loss,
        )
        _check_standing(beams, taken.time)
    names = ("displacement", "velocity", "striker_velocity", "percussion", "shortening",
             "kinetic", "elastic", "dissipated", "external_work", "contact_loss")  # fmt: skip
    columns = {name: history.column(name) for name in names}
    warnings = _shear_findings(history) + _impact_findings(history, scenario)
    response = build_response(
        {**columns, **_watched(history), "input_energy": scenario.input_energy},
        time=history.column("time"),
        hinges=WATCHED,
        segments=SEGMENTS,
        warnings=warnings,
    )
    response.attrs.update(history.diagnostics(), time_step=spans[0][1])
    return response


def run_pushover(scenario: ColumnPushover, beams: ColumnBeams, steps: int) -> Response:
    """Push the hit point of the column to the scenario's displacement in equal `steps`.

    External work is the trapezoidal sum over the steps. Raises `SolverError`, and
    `OutOfDomainError` when a hinge crumples.
    """
    assembly = beams.assembly
    history = History(beams)
    history.record(displacement=0.0, force=0.0)
    path = np.linspace(0.0, scenario.displacement, steps + 1)[1:]
    for taken in push(assembly, beams.hit, path):
        history.add(taken.energies, taken.evaluations, taken.cuts)
        history.record(displacement=taken.displacement, force=taken.force)
        _check_hinges(beams, f"{taken.displacement:.4g} m")
    names = ("displacement", "force", "shortening", "elastic", "dissipated")
    columns = {name: history.column(name) for name in names}
    force, displacement = columns["force"], columns["displacement"]
    pushed = np.concatenate(
        [[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(displacement))]
    )
    head_load = float(assembly.load[beams.head])
    work = pushed - head_load * (columns["shortening"] - columns["shortening"][0])
    warnings = _shear_findings(history)
    if scenario.displacement > COLLAPSE_SIDEWAYS * _shorter(scenario.column):
        text = (
            f"the push to {scenario.displacement:g} m is more than {COLLAPSE_SIDEWAYS:g} of the "
            "shorter segment: steel would tear before"
        )
        warnings.append(Finding("rotation", text))
    response = build_response(
        {
            **columns,
            **_watched(history),
            "external_work": work,
            "input_energy": pushed[-1],
        },
        steps=steps + 1,
        hinges=WATCHED,
        segments=SEGMENTS,
        warnings=warnings,
    )
    response.attrs.update(history.diagnostics())
    return response


def _impact_findings(history: History, scenario: ColumnImpact) -> list[Finding]:
    """What a finished impact run tells about its own accuracy."""
    ratio = history.yield_ratio()
    softened = []
    if ratio is not None and ratio < LEAST_YIELD_RATIO:
        text = (
            f"yield ratio {ratio:.4f} is below {LEAST_YIELD_RATIO}: averaging over the step "
            "softens yielding fibers"
        )
        remedy = "take a smaller time_step or a larger weight"
        softened.append(Finding("yield-ratio", text, remedy=remedy, number=ratio))
    return impact_accuracy(
        history.column("displacement"),
        history.column("algorithmic"),
        scenario.input_energy,
        softened,
        body="the whole column",
    )


def _watched(history: History) -> dict[str, Array]:
    """The variables of watched sections and segments."""
    names = ("axial_force", "moment", "plastic_rotation")
    tables = {name: history.table(name) for name in names}
    return {**tables, "shear_utilisation": history.shear_utilisation()}


def _shorter(column: Column) -> float:
    return min(column.length_below, column.length_above)


def _shear_findings(history: History) -> list[Finding]:
    """Segments whose shear force has passed the plastic shear resistance, or that slide."""
    findings = []
    if history.shear_yields:
        for segment, strain in zip(SEGMENTS, history.shear_strain(), strict=True):
            if strain > LARGEST_SHEAR_STRAIN:
                text = (
                    f"the segment {segment} the hit point reached a mean shear strain of "
                    f"{strain:.2f}, above {LARGEST_SHEAR_STRAIN}: the model lets it slide without "
                    "stretching and misses the catenary action that then sets in"
                )
                findings.append(Finding("shear-strain", text, number=float(strain)))
        return findings
    for segment, ratio in zip(SEGMENTS, history.shear_utilisation(), strict=True):
        if ratio > 1.0:
            text = (
                f"the segment {segment} the hit point reached V/Vpl = {ratio:.2f}, but shear does "
                "not yield in this model: it overestimates the resistance"
            )
            findings.append(Finding("shear-reached", text, number=float(ratio)))
    return findings


def _check_standing(beams: ColumnBeams, time: float) -> None:
    """Raise `OutOfDomainError` when the column has collapsed."""
    column = beams.column
    sideways = abs(float(beams.assembly.displacement[beams.hit]))
    for name, value, limit in (
        ("the displacement of the hit point", sideways, COLLAPSE_SIDEWAYS * _shorter(column)),
        ("the shortening", beams.shortening(), COLLAPSE_SHORTENING * column.length),
        ("the contraction of the axis", beams.contraction(), COLLAPSE_CONTRACTION * column.length),
    ):
        if value > limit:
            raise OutOfDomainError(
                f"collapse at {time:.4g} s: {name} passes {limit:.4g} m; the model means nothing "
                "beyond"
            )
    _check_hinges(beams, f"{time:.4g} s")


def _check_hinges(beams: ColumnBeams, when: str) -> None:
    """Raise `OutOfDomainError` when a plastic hinge has shortened its element to nothing."""
    if beams.slightest() < LEAST_LENGTH:
        raise OutOfDomainError(
            f"collapse at {when}: a plastic hinge under compression has shortened its element to "
            f"less than {LEAST_LENGTH:g} of its length; the member crumples (a larger "
            "smallest_element puts this off)"
        )
