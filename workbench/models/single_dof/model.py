"""The impacted column as one mass on an elasto-plastic spring.

Heng 2017, section 5.2: the four-DOF column with a linear yield surface, small rotations and one
axial force gives an explicit force-displacement curve; it serves as the envelope of a
one-dimensional elasto-plastic law. Mass M_B, a third of the column, meets the striker M_A.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, isnan, pi, sqrt
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from workbench.base.arrays import Array, Flags
from workbench.base.errors import CollapseError
from workbench.base.fields import Number, checked
from workbench.mechanics.impact.pace import Pace
from workbench.mechanics.impact.records import Run, follow, followed
from workbench.models.batch import LOST, SURVIVES, UNKNOWN, Answers
from workbench.models.domain import count_finding
from workbench.models.energy_estimate import energy_to_absorb
from workbench.models.hit_mass import with_hit_mass
from workbench.models.resistance import PANEL, OnCurve, ResistanceCurve, column_curve, columns
from workbench.models.resistance.columns import rows_of
from workbench.models.resistance.given import NOTHING
from workbench.models.single_dof import march
from workbench.models.single_dof.pulse import Pushed, moved_masses, pulse_response
from workbench.models.single_dof.spring import pushed
from workbench.responses import (
    Finding,
    Response,
    build_response,
    finding,
)
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, ColumnScenario, MemberPulse
from workbench.scenarios.pulse import UNIFORM
from workbench.scenarios.varied import spread, take

_PUSH_STEPS = 1000


@dataclass(frozen=True)
class SingleDof(OnCurve):
    """Single-degree-of-freedom column."""

    time_step: float | None = checked(
        Number(1e-8, 1.0, "s"),
        optional=True,
        help="None: by the error, the energy is kept whatever the step",
    )
    radiation_damping: float = checked(
        Number(0.0, 1e12, "N s/m"),
        0.0,
        help="of a dashpot at the mass, of waves that leave (pulses alone)",
    )

    name: ClassVar[str] = "single-dof"
    version: ClassVar[int] = 13
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND, ColumnPushover.KIND, MemberPulse.KIND)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Two rigid bars with elastic-perfectly plastic hinges; linear N-M yield surface, small "
        "rotations, one axial force for both bars, no axial inertia.",
        "Springs of the four-DOF column: the elastic column under a force at the hit point.",
        "The cubic resistance is a reconstruction: the thesis prints no formula, and several "
        "dozen definitions give its published peaks within 0.4 %.",
        "The linear resistance is a choice: the thesis prints neither formula nor number.",
        "Unloading is elastic with the initial stiffness; reverse yielding at the force last "
        "reached is a convention; farther back than it has been forth it meets the same curve.",
        "At most one third of the column's mass acts at the hit point, under a pulse that of the "
        "deflected shape; a head mass is left out.",
        "No shear yielding but with resistance = panel, the static curve of "
        "`four-dof-shear`; no local buckling; strain rate by one factor on the yield stress.",
        "A curve that is given (NAME.csv) stands for the whole member, mass and unloading are as "
        "without it, and behind its last point there is no answer.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017",)
    crushing: ClassVar[bool] = True

    def curve(self, column: Column, uniform: bool = False) -> ResistanceCurve:
        """Resistance of the column at its hit point, to half of a `uniform` load if that acts.

        Raises `OutOfDomainError`.
        """
        return self.curve_at(column, self.given(), uniform)

    def curve_at(
        self, column: Column, given: tuple[str, float], uniform: bool = False
    ) -> ResistanceCurve:
        """Resistance curve with the points and the rate factor that are `given`, see `OnCurve`."""
        spring = self.rotational_stiffness, self.resistance, self.interaction
        return column_curve(column, *spring, uniform, given)

    def with_mass(self, scenario: ColumnImpact) -> ColumnImpact:
        """The impact with the mass (kg) that meets the striker."""
        return with_hit_mass(scenario, self.hit_mass)

    def pushed(self, scenario: MemberPulse) -> Pushed:
        """System that a pulse moves; a line load does half the work of its whole at the hit point.

        The mass is that of the elastic shape, then that of the mechanism.
        """
        column, uniform = scenario.column, scenario.load == UNIFORM
        share, curve = 0.5 if uniform else 1.0, self.curve(column, uniform)
        stages = moved_masses(column, uniform, curve.elastic_limit)
        whole = share * scenario.whole
        return Pushed(curve, stages, whole, not uniform, self.radiation_damping)

    def domain(self, scenario: ColumnScenario) -> list[Finding]:
        """Findings of all member models, and those of the rigid-bar mechanism and the scheme."""
        findings = columns.curve_findings(scenario, self.resistance)
        if isinstance(scenario, ColumnImpact) and self.time_step is not None:
            findings += count_finding(scenario.duration, self.time_step, march.MOST_STEPS)
        if self.radiation_damping > 0.0 and not isinstance(scenario, MemberPulse):
            findings.append(finding("damping-of-pulses", self.radiation_damping))
        law = isinstance(scenario, MemberPulse) and scenario.column.steel.rate
        if law and self.material and self.rate_factor is None:
            findings.append(finding("strain-rate", kind=scenario.KIND))
        return findings

    def stackable(self, scenario: ColumnScenario) -> bool:
        """Whether it answers such impacts in stacks."""
        plain = not self.time_step and not self.radiation_damping
        return plain and self.curve_stacks(scenario)

    def answer_stack(self, scenario: ColumnImpact, refused: Flags) -> Answers:
        """Answers to a stack of impacts, see `models.batch`; none of those that are `refused`."""
        count = len(refused)
        scenario = self.with_mass(scenario)
        column, striker = scenario.column, scenario.striker
        options = self.resistance, self.rotational_stiffness, self.interaction
        rows, exhausted = rows_of(column, count, *options)
        hits = (striker.mass, striker.velocity, striker.restitution, scenario.duration)
        numbers = (*hits, column.properties.impact_mass)
        strikes = np.stack([spread(each, count) for each in numbers], axis=1)
        codes = np.where(exhausted | refused, UNKNOWN, SURVIVES)
        results = np.full((count, len(march.SCALARS)), np.nan)
        march.impacts(rows, strikes, codes, results)
        values = dict(zip(march.SCALARS, results.T, strict=True))
        values["input_energy"] = spread(scenario.input_energy, count)

        def collapse(i: int) -> CollapseError:
            v, time = map(float, results[i, :2])
            return columns.fallen(take(column, i), bool(codes[i] == LOST), v, time)

        return Answers.of(codes, values, collapse)

    def _solve(self, scenario: ColumnScenario) -> Response:
        if isinstance(scenario, ColumnPushover):
            return self._pushover(scenario)
        if isinstance(scenario, MemberPulse):
            return pulse_response(scenario, self.pushed(scenario))
        return self._impact(self.with_mass(scenario), scenario.dead_force)

    def _march(self, scenario: ColumnImpact, weight: float) -> tuple[Run, ResistanceCurve, float]:
        """Follow one impact; its curve, and the displacement (m) under a `weight` (N) before.

        Raises `SolverError`, `OutOfDomainError`, `CollapseError`.
        """
        column, striker = scenario.column, scenario.striker
        given = self.given(scenario)
        curve, limit, pace = _prepared(self, column, scenario.duration, striker.rebounds, given)
        pace = followed(pace, striker, column.properties.impact_mass)
        blow = striker.mass, striker.velocity, striker.restitution, 0.0
        sag, gravity = columns.displacement_under(curve, column, weight), scenario.acceleration
        drive = *blow, curve.elastic_limit, limit, column.properties.impact_mass, weight, sag
        run = follow(march.impact, (curve.pieces,), pace, drive, march.RECORD, striker, gravity)
        if run.collapsed:
            v, w = (float(run.records[name][-1]) for name in ("displacement", "velocity"))
            when, energy = run.progress["time"] - (v + sag - limit) / w, energy_to_absorb(scenario)
            raise columns.collapsed(curve, column, limit - sag, when, energy)
        return run, curve, sag

    def period(self, column: Column) -> float:
        """Shortest period (s) of the impact mass on the resistance. Raises `OutOfDomainError`."""
        steepest = self.curve(column).unloading_stiffness(columns.reach(column))
        return 2.0 * pi * sqrt(column.properties.impact_mass / steepest)

    def pace(self, column: Column, duration: float, bounces: bool) -> Pace:
        """How an impact followed for a `duration` (s) is stepped through."""
        period, step = self.period(column), self.time_step
        if step is None:
            pace: Pace = march.pace_of(period, duration, bounces)
            return pace
        return Pace.equal(duration, duration / max(1, ceil(duration / step)), march.MOST_STEPS)

    def _impact(self, scenario: ColumnImpact, weight: float) -> Response:
        started = perf_counter()
        run, curve, sag = self._march(scenario, weight)
        solved = perf_counter() - started
        values: dict[str, Any] = {**run.histories, "input_energy": scenario.input_energy}
        time, _ = values.pop("time"), values.pop("plastic")
        top = float(values["displacement"].max()) + sag
        values["shear_utilisation"], warnings = columns.reached(curve, scenario.column, top)
        values |= _scalars(scenario, run, curve, sag)
        response = build_response(values, time=time, segments=columns.SEGMENTS, warnings=warnings)
        response.attrs["solve_time"] = solved
        response.attrs |= {"dead_displacement": sag} if sag else {}
        return response

    def _pushover(self, scenario: ColumnPushover) -> Response:
        column, top = scenario.column, scenario.displacement
        curve = self.curve(column)
        if curve.end < top or (curve.shape == PANEL and curve.lost_at <= top):  # points end there
            raise columns.collapsed(curve, column, curve.lost_at)
        # the breakpoints are load steps, so that the quadrature of the force is exact
        inner = curve.starts[1:][curve.starts[1:] < top]
        path = np.union1d(np.linspace(0.0, top, _PUSH_STEPS + 1), inner)
        shear, warnings = columns.reached(curve, column, top)
        force = curve.force(path)
        values: dict[str, Any] = {"displacement": path, "force": force, "shear_utilisation": shear}
        if curve.lost_at <= top:
            warnings.append(finding("resistance-lost", lost_at=curve.lost_at))
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
            values, steps=len(path), hinges=hinges, segments=columns.SEGMENTS, warnings=warnings
        )


@lru_cache(maxsize=256)
def _prepared(
    model: SingleDof, column: Column, duration: float, bounces: bool, given: tuple[str, float]
) -> tuple[ResistanceCurve, float, Pace]:
    """Curve, limit of the displacement (m) and pace of a column, for the next strike."""
    curve = model.curve(column) if given == NOTHING else model.curve_at(column, given)
    return curve, columns.limit_of(curve, column), model.pace(column, duration, bounces)


def _scalars(
    scenario: ColumnImpact, run: Run, curve: ResistanceCurve, sag: float
) -> dict[str, float]:
    """Scalar results of an impact; without a peak in the record only those of the contact."""
    striker, mass = scenario.striker, scenario.column.properties.impact_mass
    spring = curve.pieces, curve.elastic_limit, mass
    numbers = march.scalars(run.records, run.progress, *spring, striker.rebounds, sag)
    return {name: x for name, x in zip(march.SCALARS, numbers, strict=True) if not isnan(x)}


def _pushed_energies(curve: ResistanceCurve, path: Array, force: Array) -> dict[str, Any]:
    """Energies along a push: work by quadrature of the force, the rest from the spring's law."""
    _, elastic, dissipated = pushed(path, curve.elastic_limit, curve.pieces).T
    middle = curve.force(0.5 * (path[1:] + path[:-1]))
    pieces = np.diff(path) * (force[1:] + 4.0 * middle + force[:-1]) / 6.0
    work = np.concatenate([[0.0], np.cumsum(pieces)])
    return {
        "elastic": elastic,
        "dissipated": dissipated,
        "external_work": work,
        "input_energy": work[-1],
    }
