"""The impacted column as one mass on an elasto-plastic spring.

Heng 2017, section 5.2: the four-DOF column with a linear yield surface, small rotations and one
axial force gives an explicit force-displacement curve; it serves as the envelope of a
one-dimensional elasto-plastic law. Mass M_B, a third of the column, meets the striker M_A.

**Second part.** A column on its resistance curve under a force over time: steps, histories,
response.

Without a striker, under a force over time,

    M(v) v'' + c v' + R(v) = F(t),

the mass belongs to a shape of deflection that changes once the spring has come to the next stage
(Biggs), and the velocity by a factor that the stage brings; the kinetic energy that this leaves is
dissipated.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, isnan, pi, sqrt
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from workbench.base.arrays import Array, Flags
from workbench.base.compiled import njit
from workbench.base.errors import CollapseError
from workbench.base.fields import Number, checked
from workbench.mechanics.impact.contact import uncounted
from workbench.mechanics.impact.integrator import (
    DRIVE,
    FollowedImpact,
    StepFunctions,
    begin,
    follow,
    followed,
    march_of,
    no_flow,
)
from workbench.mechanics.impact.pace import Pace
from workbench.models.batch import LOST, SURVIVES, UNKNOWN, BatchAnswers
from workbench.models.domain import count_finding
from workbench.models.energy_estimate import energy_to_absorb
from workbench.models.hit_mass import with_hit_mass
from workbench.models.resistance import PANEL, OnCurve, ResistanceCurve, column_curve, columns
from workbench.models.resistance.columns import NOTHING, rows_of
from workbench.models.resistance.shapes import beam_of
from workbench.models.single_dof import march
from workbench.models.single_dof.march import pushed, solve_midpoint
from workbench.responses import Finding, Response, build_response, finding
from workbench.responses.histories import largest_of, peak_of, unloaded
from workbench.scenarios import (
    Column,
    ColumnImpact,
    ColumnPushover,
    ColumnScenario,
    MemberPulse,
    Pulse,
)
from workbench.scenarios.pulse import UNIFORM
from workbench.scenarios.varied import spread, take

_STEPS_PER_PERIOD = 64  # of the lightest mass on the steepest stiffness
_FEWEST_STEPS, _MOST_STEPS = 400, 1_000_000


class PushedMass(NamedTuple):
    """System as `OneMass`; mean forces (N) of the steps, their length (s).

    And stages (n, 3) of displacement (m), mass (kg) and factor on the velocity, `damping` in N s/m.
    """

    states: Any
    pieces: Any
    limit: float
    means: Any
    length: float
    stages: Any
    damping: float


class Pushed(NamedTuple):
    """System that a pulse moves: the resistance `curve`, and the `share` of the pulse on it.

    `stages`: displacement (m) from which on a mass (kg) moves, the first from 0 on, and the
    velocity that it begins with over that before; whether force and resistance are those `at_hit`,
    at the impact point, so that energies are those of the member; `damping` of the mass in N s/m.
    """

    curve: ResistanceCurve
    stages: tuple[tuple[float, float, float], ...]
    share: float
    at_hit: bool
    damping: float = 0.0


@uncounted
def solve_pushed(s, dt, closed, touch, striker):
    """The step of the mass under the pulse."""
    now = s.states[0]
    now.push = s.means[min(int(now.time / s.length + 1e-6), s.means.size - 1)]
    spring, impulse = march.spring_of(now), dt * (s.damping * now.w - now.push - now.weight)
    damped = now.mass + 0.5 * dt * s.damping  # the dashpot feels the mean velocity
    w1, residual = solve_midpoint(dt, now.w, damped, impulse, spring, s.pieces)
    s.states[1].w = w1
    return residual <= 1e-9, w1, residual, 1


@uncounted
def accept_pushed(s, dt):
    """Move the spring; the work of pulse and dashpot; what the next stage changes."""
    now, before = s.states[0], s.states[0].v
    march.accept(s, dt)
    now.time += dt
    now.dissipated += s.damping * (now.v - before) ** 2 / dt
    now.work += now.push * (now.v - before)
    while now.stage + 1 < s.stages.shape[0] and abs(now.v) >= s.stages[now.stage + 1, 0]:
        now.stage += 1
        kinetic = 0.5 * now.mass * now.w**2
        now.mass, now.w = s.stages[now.stage, 1], s.stages[now.stage, 2] * now.w
        now.dissipated += kinetic - 0.5 * now.mass * now.w**2


_march = march_of(
    StepFunctions(march.hit, solve_pushed, no_flow, accept_pushed, march.write, march.lost)
)


def no_striker(
    elastic_limit: float, limit: float, mass: float, weight: float = 0.0, sag: float = 0.0
) -> tuple[float, ...]:
    """The drive of a pulse after its pace, as `march.impact`; the mass is that at first (kg)."""
    return 0.0, 0.0, 0.0, 0.0, elastic_limit, limit, mass, weight, sag


@njit(cache=True, error_model="numpy")
def under_pulse(pieces, stages, means, damping, drive, progress, records):
    """Follow a pulse in equal steps: (status, rows), as `impact`.

    Arguments: `stages` (n, 3), displacement (m) from which on a mass (kg) moves and the factor on
    the velocity there, the first from 0 on; `means` (steps,) of the force; `damping` in N s/m.
    """
    pace = begin(drive, progress[0])
    states, limit = march.at_rest(drive, pieces), drive[DRIVE + 1]
    s = PushedMass(states, pieces, limit, means, pace.longest, stages, damping)
    return _march(s, pace, progress[0], records)


@lru_cache(maxsize=256)
def moved_masses(
    column: Column, uniform: bool, limit: float
) -> tuple[tuple[float, float, float], ...]:
    """Stages of a column that moves in its elastic shape up to a `limit` (m), then as a mechanism.

    Rigid bars take over the momentum that the elastic shape has in their own, so that hardly any
    energy is lost. An impact mass that is given counts as it is.
    """
    if column.impact_mass is not None:
        return ((0.0, column.impact_mass, 1.0),)
    elastic, *_, rigid = beam_of(column, uniform).stages(np.ones(3))
    total = column.properties.mass_per_length * column.length
    masses = [total * rigid.load_factor * stage.load_mass_factor for stage in (elastic, rigid)]
    carried = elastic.shape.momentum(rigid.shape) / rigid.mass_factor
    return ((0.0, masses[0], 1.0), (limit, masses[1], carried))


def push(
    pushed: Pushed, column: Column, pulse: Pulse, duration: float, weight: float = 0.0
) -> tuple[Array, dict[str, Any]]:
    """Follow a column at rest under a pulse for `duration` (s): time (s) and values of a response.

    Argument: its `weight` at the impact point (N), under which it lies. Raises `SolverError`, and
    `CollapseError` where the column collapses.
    """
    curve = pushed.curve
    lightest = min(mass for _, mass, _ in pushed.stages)
    stiffest = curve.unloading_stiffness(columns.reach(column))
    period = 2.0 * np.pi * np.sqrt(lightest / stiffest)
    longest = min(period / _STEPS_PER_PERIOD, duration / _FEWEST_STEPS)
    steps = min(int(np.ceil(duration / longest)), _MOST_STEPS)
    step = duration / steps
    time = np.linspace(0.0, duration, steps + 1)
    means = pushed.share * pulse.means(time)
    tables = curve.pieces, np.array(pushed.stages), means, pushed.damping
    limit = columns.limit_of(curve, column)
    sag = columns.displacement_under(curve, column, weight)
    drive = no_striker(curve.elastic_limit, limit, pushed.stages[0][1], weight, sag)
    run = follow(under_pulse, tables, Pace.equal(duration, step, steps), drive, march.RECORD)
    records = run.records
    if run.collapsed:
        reached, when = float(records["displacement"][-1]), float(records["time"][-1])
        brought = float(records["external_work"][-1])
        raise columns.collapsed(curve, column, reached, when, brought)
    values: dict[str, Any] = {name: records[name] for name in ("displacement", "velocity", "force")}
    if pushed.at_hit:
        values |= {name: records[name] for name in ("kinetic", "elastic", "dissipated")}
        works = records["external_work"]
        pulsed = works - weight * records["displacement"]
        values |= {"external_work": works, "input_energy": np.max(np.abs(pulsed))}
    values["load"] = pushed.share * pulse.force(time)
    over = unloaded(values) is not None and peak_of(time, records["displacement"])
    values["residual_displacement"] = float(records["plastic"][-1]) if over else None
    return time, values


def pulse_response(
    scenario: MemberPulse,
    pushed: Pushed,
    further: Callable[[dict[str, Any]], Mapping[str, Any]] | None = None,
) -> Response:
    """The answer to a member under a pulse; `further`: values read off the others."""
    started = perf_counter()
    column, weight = scenario.column, scenario.dead_force
    time, values = push(pushed, column, scenario.pulse, scenario.duration, weight)
    solved = perf_counter() - started
    curve, sag = pushed.curve, columns.displacement_under(pushed.curve, column, weight)
    top = abs(largest_of(values["displacement"] + sag))
    shear, warnings = columns.reached(curve, column, top)
    warnings = [*warnings, *columns.of_one_shape(scenario, curve, pushed.stages[0][1], top)]
    values["load"] = scenario.whole * scenario.pulse.force(time)
    if scenario.load != UNIFORM:  # a line load makes shear of its own
        values["shear_utilisation"] = shear
    if further is not None:
        values |= further(values)
    response = build_response(values, time=time, segments=columns.SEGMENTS, warnings=warnings)
    response.attrs["solve_time"] = solved
    response.attrs |= {"dead_displacement": sag} if sag else {}
    return response


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
        "Springs of the four-DOF column: the elastic column under a force at the impact point.",
        "The cubic resistance is a reconstruction: the thesis prints no formula, and several "
        "dozen definitions give its published peaks within 0.4 %.",
        "The linear resistance is a choice: the thesis prints neither formula nor number.",
        "Unloading is elastic with the initial stiffness; reverse yielding at the force last "
        "reached is a convention; farther back than it has been forth it meets the same curve.",
        "At most one third of the column's mass acts at the impact point, under a pulse that of "
        "the deflected shape; a head mass is left out.",
        "No shear yielding but with resistance = panel, the static curve of "
        "`four-dof-shear`; no local buckling; strain rate by one factor on the yield stress.",
        "A curve that is given (NAME.csv) stands for the whole member, mass and unloading are as "
        "without it, and behind its last point there is no answer.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017",)
    crushing: ClassVar[bool] = True

    def curve(self, column: Column, uniform: bool = False) -> ResistanceCurve:
        """Resistance of the column at its impact point, to half of a `uniform` load if that acts.

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
        """System that a pulse moves; a line load does half of its work at the impact point.

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

    def answer_stack(self, scenario: ColumnImpact, refused: Flags) -> BatchAnswers:
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

        return BatchAnswers.of(codes, values, collapse)

    def _solve(self, scenario: ColumnScenario) -> Response:
        if isinstance(scenario, ColumnPushover):
            return self._pushover(scenario)
        if isinstance(scenario, MemberPulse):
            return pulse_response(scenario, self.pushed(scenario))
        return self._impact(self.with_mass(scenario), scenario.dead_force)

    def _march(
        self, scenario: ColumnImpact, weight: float
    ) -> tuple[FollowedImpact, ResistanceCurve, float]:
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
            # the sign convention of the four-DOF column: the hinge at the impact point turns back
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
    scenario: ColumnImpact, run: FollowedImpact, curve: ResistanceCurve, sag: float
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
