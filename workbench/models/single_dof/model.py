"""The impacted column as one mass on an elasto-plastic spring.

Heng 2017, section 5.2: the four-DOF column with a linear yield surface, small rotations and one
axial force gives an explicit force-displacement curve; it serves as the envelope of a
one-dimensional elasto-plastic law. Mass M_B, a third of the column, meets the striker M_A.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import reduce
from math import ceil, pi, sqrt
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from workbench.errors import CollapseError, OutOfDomainError, SolverError
from workbench.fields import Choice, Declared, Number, checked
from workbench.impact import collide
from workbench.models.base import respond
from workbench.models.domain import step_finding
from workbench.models.hit_mass import HIT_MASS, THESIS, with_hit_mass
from workbench.models.resistance import INTERACTIONS, SECTION, SHAPES, ResistanceCurve, column_curve
from workbench.models.resistance.limits import (
    SEGMENTS,
    analytic_companion,
    collapsed,
    curve_findings,
    limit_of,
    reach,
    reached_findings,
    shear_utilisation,
)
from workbench.models.resistance.panel import PANEL
from workbench.models.single_dof import kernels
from workbench.models.single_dof.pulse import Pushed, pulse_response
from workbench.responses import (
    Finding,
    Outcome,
    Response,
    build_response,
    peak_contact_force,
    peak_of,
)
from workbench.scenarios import (
    Column,
    ColumnImpact,
    ColumnPushover,
    ColumnScenario,
    MemberPulse,
    Scenario,
)
from workbench.scenarios.pulse import UNIFORM

Array = NDArray[np.float64]
_SCHEMES = {"midpoint": kernels.MIDPOINT, "moreau": kernels.MOREAU}
_STEPS_PER_PERIOD = 16  # of the impact mass alone on the steepest stiffness
_FINE_STEPS = 1000  # repeated impacts converge at first order; Moreau does not keep energy
_FEWEST_STEPS = 100  # of a record
_PUSH_SHARE, _FIRST_STEPS = 0.1, 20  # of the period, in steps that tell the largest force
_MOST_STEPS, _MOST_STEPS_ASKED = 400_000, 4_000_000
_PUSH_STEPS = 1000
_ENDINGS: dict[type[Exception], Outcome] = {
    CollapseError: Outcome.COLLAPSE,
    OutOfDomainError: Outcome.OUT_OF_DOMAIN,
    SolverError: Outcome.NOT_CONVERGED,
}
_BATCH = ("peak_displacement", "time_of_peak", "residual_displacement", "peak_force", "impulse")


class _Run(NamedTuple):
    time: Array
    records: Any
    state: kernels.Spring
    curve: ResistanceCurve


@dataclass(frozen=True)
class SingleDof(Declared, table="option"):
    """Single-degree-of-freedom column.

    Options: `resistance`: envelope of the spring, analytic, cubic, linear (in the axial force)
    or panel (webs yield in shear: the static curve of `four-dof-shear`);
    `integrator`: midpoint (energy conserving) or moreau (explicit); `time_step` in s (None: a
    16th of the shortest period, of that with the striker on while it pushes, a 1000th with
    restitution or Moreau's scheme, at most a 100th of the record; the midpoint scheme keeps the
    energy whatever the step);
    `rotational_stiffness`: factor c of the hinge stiffness c EI / l (the thesis: 6; None: as in
    `four-dof`); `hit_mass`: thesis or waves, as in `four-dof`.
    """

    resistance: str = checked(Choice(SHAPES), "cubic")
    integrator: str = checked(Choice(tuple(_SCHEMES)), "midpoint")
    time_step: float | None = checked(Number(1e-8, 1.0, "s"), optional=True)
    rotational_stiffness: float | None = checked(Number(0.1, 1e6), optional=True)
    interaction: str = checked(Choice(INTERACTIONS), SECTION)
    hit_mass: str = checked(HIT_MASS, THESIS)

    name: ClassVar[str] = "single-dof"
    version: ClassVar[int] = 7
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND, ColumnPushover.KIND, MemberPulse.KIND)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Two rigid bars with elastic-perfectly plastic hinges; linear N-M yield surface, small "
        "rotations, one axial force for both bars, no axial inertia.",
        "Springs of the four-DOF column: the elastic column under a force at the hit point.",
        "The cubic resistance is a reconstruction: the thesis prints no formula, and several "
        "dozen definitions give its published peaks within 0.4 %.",
        "The linear resistance is a choice: the thesis prints neither formula nor number.",
        "Unloading is elastic with the initial stiffness; reverse yielding at the force last "
        "reached is a convention: the model is meant for one push and its rebound.",
        "At most one third of the column's mass acts at the hit point; a head mass is left out.",
        "No shear yielding but with resistance = panel, the static curve of "
        "`four-dof-shear`; no local buckling, no strain-rate effect.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017",)

    def curve(self, column: Column) -> ResistanceCurve:
        """Resistance of the column at its hit point. Raises `OutOfDomainError`."""
        spring = self.rotational_stiffness, self.resistance, self.interaction
        return column_curve(column, *spring)

    def with_mass(self, scenario: ColumnImpact) -> ColumnImpact:
        """The impact with the mass (kg) that meets the striker."""
        return with_hit_mass(scenario, self.hit_mass)

    def pushed(self, scenario: MemberPulse) -> Pushed:
        """What a pulse moves: a line load does half the work of its resultant at the hit point."""
        column = scenario.column
        share = (0.5 if scenario.load == UNIFORM else 1.0) * scenario.whole
        curve = self.curve(column)
        return Pushed(curve, ((0.0, column.properties.impact_mass),), share, True)

    def domain(self, scenario: ColumnScenario) -> list[Finding]:
        """Findings of all member models, and those of the rigid-bar mechanism and the scheme."""
        findings = curve_findings(scenario, self.resistance)
        if isinstance(scenario, ColumnImpact) and self.time_step is not None:
            findings.extend(self._step_findings(scenario, self.time_step))
        return findings

    def _step_findings(self, scenario: ColumnImpact, step: float) -> list[Finding]:
        """Refusals of a time step that the caller has set."""
        findings = []
        if scenario.duration / step > _MOST_STEPS_ASKED:
            text = (
                f"option.time_step = {step:g} s makes {scenario.duration / step:.3g} steps of "
                f"the {scenario.duration:g} s, at most {_MOST_STEPS_ASKED} are kept: increase it"
            )
            findings.append(Finding("time-step", text, refusal=True))
        if self.integrator == "moreau":
            with suppress(OutOfDomainError):  # told by the solution itself
                stable = 2.0 / _frequency(self.curve(scenario.column), scenario.column)
                findings += step_finding(step, stable)
        return findings

    def simulate(self, scenario: Scenario) -> Response:
        """Answer a column pushover or a column impact."""
        return respond(self, scenario, self._solve)

    def simulate_many(self, scenarios: Sequence[ColumnImpact]) -> pd.DataFrame:
        """Scalars of many impacts, the same numbers as `simulate` gives, without histories.

        One row per scenario: peak and residual displacement (m), time of the peak (s), peak force
        (N) and impulse (N s), NaN where a case gives no such number; its `outcome`, and `failure`,
        why it is not ok (else ""). Warnings of the domain are not collected.
        """
        rows: list[dict[str, Any]] = []
        for scenario in scenarios:
            refusals = [str(finding) for finding in self.domain(scenario) if finding.refusal]
            try:
                if refusals:
                    raise OutOfDomainError("; ".join(refusals))
                heavy = self.with_mass(scenario)
                row = {**_scalars(heavy, self._march(heavy)), "outcome": Outcome.OK, "failure": ""}
            except tuple(_ENDINGS) as error:
                row = {"outcome": _ENDINGS[type(error)], "failure": str(error)}
            rows.append(row)
        return pd.DataFrame(rows, columns=[*_BATCH, "outcome", "failure"])

    def _solve(self, scenario: ColumnScenario) -> Response:
        if isinstance(scenario, ColumnPushover):
            return self._pushover(scenario)
        if isinstance(scenario, MemberPulse):
            return pulse_response(scenario, self.pushed(scenario))
        return self._impact(self.with_mass(scenario))

    def _march(self, scenario: ColumnImpact) -> _Run:
        """Follow one impact. Raises `SolverError`, `OutOfDomainError`, `CollapseError`."""
        column, striker = scenario.column, scenario.striker
        curve = self.curve(column)
        pace, scheme = self._pace(scenario, curve), _SCHEMES[self.integrator]
        records = np.zeros(round(scenario.duration / pace.step) + _FIRST_STEPS + 2, kernels.RECORD)
        limit = limit_of(curve, column)
        mass = column.properties.impact_mass
        blow = kernels.Blow(mass, striker.mass, striker.velocity, striker.restitution)
        status, last, residual, state = kernels.impact(
            scheme, pace, blow, curve.elastic_limit, limit, curve.pieces, records
        )
        if status == kernels.NO_CONVERGENCE:
            tried = "Newton with bisection; the resistance may soften too fast for the step"
            where = f"time {records['time'][last - 1]:.4g} s (step of {pace.step:.3g} s)"
            raise SolverError(where, residual, tried)
        if status == kernels.COLLAPSE:
            now = records[last]
            since = (float(now["displacement"]) - limit) / float(now["velocity"])
            raise collapsed(curve, column, limit, float(now["time"]) - since)
        records = records[: last + 1]
        return _Run(records["time"], records, state, curve)

    def _pace(self, scenario: ColumnImpact, curve: ResistanceCurve) -> kernels.Pace:
        duration = scenario.duration
        if self.time_step is not None:
            step = duration / max(1, ceil(duration / self.time_step))
            return kernels.Pace(duration, step, step, step, 0.0)
        column = scenario.column
        period = 2.0 * pi / _frequency(curve, column)
        event_bound = scenario.striker.restitution > 0.0 or self.integrator == "moreau"
        share = _FINE_STEPS if event_bound else _STEPS_PER_PERIOD
        longest = duration / _FEWEST_STEPS
        step = duration / min(ceil(duration / min(period / share, longest)), _MOST_STEPS)
        if event_bound:
            return kernels.Pace(duration, step, step, step, 0.0)
        slower = sqrt(1.0 + scenario.striker.mass / column.properties.impact_mass)
        push = max(step, min(slower * step, longest))
        window = min(_PUSH_SHARE * period, duration)  # which sees the first collision
        return kernels.Pace(duration, step, push, min(step, window / _FIRST_STEPS), window)

    def _impact(self, scenario: ColumnImpact) -> Response:
        started = perf_counter()
        run = self._march(scenario)
        solved = perf_counter() - started
        records, curve = run.records, run.curve
        top = float(records["displacement"].max())
        companion = analytic_companion(curve)
        spent = (records[name] for name in kernels.HISTORIES[-4:])  # energies
        values: dict[str, Any] = {
            **{name: records[name] for name in kernels.HISTORIES},
            "balance_error": reduce(np.subtract, spent, scenario.input_energy),
            "input_energy": scenario.input_energy,
            "shear_utilisation": shear_utilisation(companion, scenario.column, top),
            **_scalars(scenario, run),
        }
        warnings = reached_findings(curve, companion, top)
        response = build_response(values, time=run.time, segments=SEGMENTS, warnings=warnings)
        response.attrs["solve_time"] = solved
        return response

    def _pushover(self, scenario: ColumnPushover) -> Response:
        column, top = scenario.column, scenario.displacement
        curve = self.curve(column)
        if curve.shape == PANEL and curve.lost_at <= top:  # its points end there
            raise collapsed(curve, column, curve.lost_at)
        # the breakpoints are load steps, so that the quadrature of the force is exact
        inner = curve.starts[1:][curve.starts[1:] < top]
        path = np.union1d(np.linspace(0.0, top, _PUSH_STEPS + 1), inner)
        companion = analytic_companion(curve)
        warnings = reached_findings(curve, companion, top)
        force = curve.force(path)
        values: dict[str, Any] = {
            "displacement": path,
            "force": force,
            "shear_utilisation": shear_utilisation(companion, column, top),
        }
        if curve.lost_at <= top:
            text = (
                f"the resistance is lost at {curve.lost_at:.4g} m; beyond, the column must be "
                "held back, and the elasto-plastic law has no energies"
            )
            warnings.append(Finding("resistance-lost", text))
        else:
            values.update(_pushed_energies(curve, path, force))
        hinges: tuple[str, ...] = ()
        if curve.knows_moments:
            hinges = curve.mechanism.groups
            # the sign convention of the four-DOF column: the hinge at the hit point turns back
            sign = np.array([[-1.0 if name == "hit" else 1.0] for name in hinges])
            axial = curve.axial_force(path)
            values["axial_force"] = np.broadcast_to(axial, (len(hinges), len(path)))
            values["moment"] = sign * curve.moments(path)
            values["plastic_rotation"] = sign * curve.plastic_rotations(path)
        return build_response(
            values, steps=len(path), hinges=hinges, segments=SEGMENTS, warnings=warnings
        )


def _frequency(curve: ResistanceCurve, column: Column) -> float:
    """Highest circular frequency of the impact mass on the spring, in rad/s."""
    steepest = curve.unloading_stiffness(reach(column))
    return sqrt(steepest / column.properties.impact_mass)


def _scalars(scenario: ColumnImpact, run: _Run) -> dict[str, float]:
    """Scalar results of an impact; without a peak in the record only those of the contact."""
    percussion, spring = run.records["percussion"].copy(), run.state
    values = peak_of(run.time, run.records["displacement"])
    if values:
        values["residual_displacement"] = run.curve.residual(values["peak_displacement"])
        if spring.yielded:  # what reverse yielding has changed since
            top = spring.top - spring.top_force / spring.stiffness
            now = spring.v - spring.force / spring.stiffness
            values["residual_displacement"] += now - top
    # the first collision is recorded with the first step but happens at time 0
    striker = scenario.striker
    mass = scenario.column.properties.impact_mass
    first = collide(mass, striker.mass, striker.velocity, striker.restitution).percussion
    percussion[:2] = first, percussion[1] - first
    values["peak_force"] = peak_contact_force(run.time, percussion)
    values["impulse"] = float(percussion.sum())
    return values


def _pushed_energies(curve: ResistanceCurve, path: Array, force: Array) -> dict[str, Any]:
    """Energies along a push: work by quadrature of the force, the rest from the spring's law."""
    records = np.zeros(len(path), kernels.RECORD)
    kernels.follow(path, curve.elastic_limit, curve.pieces, records)
    middle = curve.force(0.5 * (path[1:] + path[:-1]))
    pieces = np.diff(path) * (force[1:] + 4.0 * middle + force[:-1]) / 6.0
    work = np.concatenate([[0.0], np.cumsum(pieces)])
    return {
        "elastic": records["elastic"],
        "dissipated": records["dissipated"],
        "external_work": work,
        "input_energy": work[-1],
    }
