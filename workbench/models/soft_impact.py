"""The column hit by a striker that crushes: two masses on two springs, of Eibl and the CEB.

Comité Euro-International du Béton 1988; Heng 2017, chapter 3, figure 3.1.

    m_A x''  + R_1(x - v) = 0            striker, with the spring R_1 of what crushes
    m_B v''  - R_1(x - v) + R_2(v) = 0   impact mass of the column on its resistance R_2

R_1 is linear up to the crush force, flows there, unloads with its stiffness and cannot pull; or it
is the law by which the striker of the scenario crushes (`impact.crushing`). The
leapfrog rule steps through: of second order, its energy bounded below the stability limit.
"""

from dataclasses import dataclass
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from workbench.base.arrays import Flags
from workbench.base.compiled import njit, register_jitable
from workbench.base.errors import CollapseError, SolverError
from workbench.base.fields import Number, checked
from workbench.mechanics.impact.contact import UNLOADING, force_at, uncounted
from workbench.mechanics.impact.integrator import (
    COLLAPSE,
    DONE,
    DRIVE,
    PROGRESS,
    StepFunctions,
    begin,
    follow,
    law_of,
    march_of,
    no_flow,
)
from workbench.mechanics.impact.pace import Pace
from workbench.models.batch import COLLAPSES, LOST, SURVIVES, UNKNOWN, BatchAnswers
from workbench.models.domain import shear_warnings
from workbench.models.hit_mass import with_hit_mass
from workbench.models.resistance import PANEL, OnCurve, ResistanceCurve, column_curve, columns
from workbench.models.resistance.kernels import unloading_stiffness
from workbench.models.resistance.shapes import curve_of
from workbench.models.single_dof import march as one_mass
from workbench.models.single_dof.march import spring_moved
from workbench.responses import Finding, Response, build_response, energy_error, finding
from workbench.responses.histories import FORCE_WINDOW, open_share, unbalanced
from workbench.responses.kernels import largest_window, signed_peak
from workbench.scenarios import ColumnImpact, ColumnScenario
from workbench.scenarios.pulse import VEHICLE_STIFFNESS
from workbench.scenarios.varied import spread, take

_STEPS_PER_PERIOD = 100  # of the highest frequency of both springs
_FEWEST_STEPS, _MOST_STEPS = 500, 1_000_000
_BALANCE = 1e-3  # of the input energy, which the ledger may be open
SCALARS = ("peak_displacement", "time_of_peak", "residual_displacement", "peak_force", "impulse")
_unbalanced, _open_share = register_jitable(unbalanced), register_jitable(open_share)


class TwoMasses(NamedTuple):
    """System: as `single_dof.march.OneMass`; stiffness (N/m) and force (N) of what crushes."""

    states: Any
    pieces: Any
    limit: float
    stiffness: float
    crush_force: float


@njit(cache=True, error_model="numpy")
def crush(approach, crushed, stiffness, crush_force):
    """Contact force and crushed length of an `approach` x - v (m), `crushed` before."""
    force = max(stiffness * (approach - crushed), 0.0)
    if force > crush_force:
        return crush_force, approach - crush_force / stiffness
    return force, crushed


@uncounted
def step(s, progress, dt, can_touch):
    """A leapfrog step."""
    now, new = s.states[0], s.states[1]
    mass, striker = now.mass, progress.mass
    half = now.w + 0.5 * dt * (now.contact + now.weight - now.force) / mass
    spring = spring_moved(one_mass.spring_of(now), now.v + dt * half, s.pieces)
    faster = dt * (progress.gravity - now.contact / striker)
    new.x = now.x + dt * (progress.velocity + 0.5 * faster)
    approach, law = new.x - spring.v, progress.crush
    if law.points > 0:
        law.crushed = max(law.crushed, now.x - now.v)
        new.contact = force_at(law, approach)[0]
        lost = 0.5 * (now.contact + new.contact) * (approach - now.x + now.v)
    else:
        new.contact, new.crushed = crush(approach, now.crushed, s.stiffness, s.crush_force)
        lost = s.crush_force * (new.crushed - now.crushed) if new.crushed > now.crushed else 0.0
    one_mass.put(new, spring)
    new.w = half + 0.5 * dt * (new.contact + now.weight - spring.force) / mass
    return True, 0.5 * dt * (now.contact + new.contact), new.w, lost


@uncounted
def accept(s, dt):
    """Accept the trial state of the step."""
    now, new = s.states[0], s.states[1]
    one_mass.put(now, one_mass.spring_of(new))
    now.w, now.x, now.contact, now.crushed = new.w, new.x, new.contact, new.crushed


@uncounted
def write(s, records, n):
    """Write a record of one mass, with the energy of the striker's spring."""
    one_mass.write(s, records, n)
    records[n].elastic += 0.5 * s.states[0].contact ** 2 / s.stiffness


_march = march_of(
    StepFunctions(one_mass.hit, None, no_flow, accept, write, one_mass.lost, step=step)
)


@njit(cache=True, error_model="numpy")
def impact(pieces, drive, progress, records):
    """Follow an impact as `single_dof.march.impact`; the drive goes on with stiffness and force.

    The stiffness is infinite, so that nothing is stored, where the striker crushes by its own law.
    """
    states, numbers = one_mass.at_rest(drive, pieces), drive[DRIVE:]
    states[0].x = states[0].sag
    s = TwoMasses(states, pieces, numbers[1], numbers[5], numbers[6])
    return _march(s, begin(drive, progress[0]), progress[0], records)


@njit(cache=True, error_model="numpy")
def steps_of(duration, column, striker):
    """How many steps a record of a `duration` (s) takes, and step times highest frequency.

    Arguments: mass (kg) and steepest stiffness (N/m) of the column, and of the striker.
    """
    (mass, slope), (light, unloading) = column, striker
    frequency = ((slope + unloading) / mass + unloading / light) ** 0.5
    steps = np.ceil(duration * frequency * _STEPS_PER_PERIOD / (2.0 * np.pi))
    count = int(min(max(steps, _FEWEST_STEPS), _MOST_STEPS))
    return count, duration / count * frequency


@njit(cache=True, error_model="numpy")
def read(records, given, numbers):
    """Write the `numbers` of an impact, as SCALARS has them; how far its ledger is open.

    Argument: the energy `given` (J).
    """
    time, v, percussion = records["time"], records["displacement"], records["percussion"]
    numbers[0] = numbers[1] = np.nan
    if percussion[-1] > 0.0 and records["striker_velocity"].min() > 0.0:  # it still pushes
        numbers[2] = np.nan
    else:
        numbers[2] = records["plastic"][-1]
        largest, when, grows = signed_peak(time, v)
        if not grows:
            numbers[0], numbers[1] = largest, when
    numbers[3] = largest_window(time[1:], percussion[1:], FORCE_WINDOW) / FORCE_WINDOW
    numbers[4] = percussion.sum()
    balance = np.empty(records.size)
    for n in range(records.size):
        row = records[n]
        brought, gained = given + row.external_work, row.elastic - records[0].elastic
        balance[n] = _unbalanced(brought, row.kinetic, gained, row.dissipated, row.contact_loss)
    return _open_share(balance, given, records[0].elastic)


@njit(cache=True, error_model="numpy", nogil=True)
def impacts(rows, strikes, spring, codes, numbers):
    """Follow impacts on many columns: writes their `codes` and `numbers` (n, SCALARS).

    Of one that collapses displacement (m) and time (s). Arguments: `rows` of mechanisms; `strikes`
    (n, 5), mass (kg), velocity (m/s) and energy (J) of the striker, duration (s), impact mass (kg);
    `spring` of what crushes, stiffness (N/m) and force (N).
    """
    stiffness, force = spring
    records = np.empty(1024, one_mass.RECORD)
    for i in range(codes.size):
        if codes[i] != SURVIVES:
            continue
        striker, velocity, energy, duration, mass = strikes[i]
        pieces, elastic_limit, lost, unloads = curve_of(rows, i)
        slope = unloading_stiffness(pieces, rows.reach[i])
        count, turned = steps_of(duration, (mass, slope), (striker, stiffness))
        codes[i] = UNKNOWN
        if unloads or turned > 1.0:
            continue
        limit, length = min(rows.reach[i], lost), duration / count
        drive = np.array(
            [
                *(duration, length, length, np.inf, np.inf, np.inf, 1.001 * length, float(count)),
                *(striker, velocity, 0.0, 0.0, elastic_limit, limit, mass, 0.0, 0.0),
                *(stiffness, force),
            ]
        )
        if records.size < count + 4:
            records = np.empty(count + 4, one_mass.RECORD)
        status, n = impact(pieces, drive, np.zeros(1, PROGRESS), records[: count + 4])
        if status == COLLAPSE:
            codes[i] = LOST if lost <= rows.reach[i] else COLLAPSES
            numbers[i, 0], numbers[i, 1] = records[n - 1].displacement, records[n - 1].time
        elif status == DONE and read(records[:n], energy, numbers[i]) <= _BALANCE:
            codes[i] = SURVIVES


@dataclass(frozen=True)
class SoftImpact(OnCurve):
    """Two masses on two springs: what of the vehicle crushes, and the column as of single-dof."""

    striker_stiffness: float = checked(
        Number(1.0, 1e12, "N/m"),
        VEHICLE_STIFFNESS,
        help="of what crushes (cars, EN 1991-1-7, Annex C), if the striker has no law of its own",
    )
    crush_force: float | None = checked(
        Number(1.0, 1e12, "N"), optional=True, help="at which it flows, likewise (None: elastic)"
    )

    name: ClassVar[str] = "soft-impact"
    version: ClassVar[int] = 6
    judged: ClassVar[bool] = False
    unused: ClassVar[tuple[str, ...]] = ("column.head_mass", "striker.restitution")
    crushing: ClassVar[bool] = True
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "The striker is a mass behind one spring, linear up to its crush force, that cannot pull; "
        "what it crushes is massless and comes back with the same stiffness.",
        "Restitution is what the spring gives back; that of the scenario has no part in it.",
        "Resistance of the single-DOF column: two rigid bars with plastic hinges, small rotations, "
        "springs of the elastic column; with resistance = panel the "
        "static curve of `four-dof-shear`.",
        "At most one third of the column's mass acts at the impact point; a head mass is left out.",
        "No local buckling; strain rate by one factor.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017", "ceb1988", "en1991-1-7")

    def curve(self, scenario: ColumnImpact) -> ResistanceCurve:
        """Resistance of the column at its impact point. Raises `OutOfDomainError`."""
        spring, given = (self.rotational_stiffness, self.resistance), self.given(scenario)
        return column_curve(scenario.column, *spring, self.interaction, given=given)

    def domain(self, scenario: ColumnImpact) -> list[Finding]:
        """Findings of all models on a resistance curve, of shear those of the run."""
        findings = [
            f for f in columns.curve_findings(scenario, self.resistance) if f.subject != "shear"
        ]
        if self.striker_stiffness == VEHICLE_STIFFNESS and not scenario.striker.crushes:
            findings.append(finding("stiffness-of-cars", stiffness=VEHICLE_STIFFNESS / 1e3))
        return findings

    def stackable(self, scenario: ColumnScenario) -> bool:
        """Whether it answers such impacts in stacks."""
        return self.curve_stacks(scenario)

    def answer_stack(self, scenario: ColumnImpact, refused: Flags) -> BatchAnswers:
        """Answers to a stack of impacts, see `models.batch`; none of those that are `refused`."""
        count = len(refused)
        scenario = with_hit_mass(scenario, self.hit_mass)
        column, striker = scenario.column, scenario.striker
        options = self.resistance, self.rotational_stiffness, self.interaction
        rows, exhausted = columns.rows_of(column, count, *options)
        codes = np.where(exhausted | refused, UNKNOWN, SURVIVES)
        energy = spread(scenario.input_energy, count)
        hits = striker.mass, striker.velocity, energy, scenario.duration
        strikes = np.stack([spread(x, count) for x in (*hits, column.properties.impact_mass)], 1)
        numbers = np.full((count, len(SCALARS)), np.nan)
        force = np.inf if self.crush_force is None else self.crush_force
        impacts(rows, strikes, (self.striker_stiffness, force), codes, numbers)
        values = dict(zip(SCALARS, numbers.T, strict=True)) | {"input_energy": energy}

        def collapse(i: int) -> CollapseError:
            v, time = map(float, numbers[i, :2])
            return columns.fallen(take(column, i), bool(codes[i] == LOST), v, time)

        return BatchAnswers.of(codes, values, collapse)

    def _solve(self, scenario: ColumnImpact) -> Response:
        started, weight = perf_counter(), scenario.dead_force
        scenario = with_hit_mass(scenario, self.hit_mass)
        column, curve = scenario.column, self.curve(scenario)
        mass, striker = column.properties.impact_mass, scenario.striker
        law, loading = law_of(striker), self.striker_stiffness
        if striker.crushes:
            loading = float(law["unloading"]) / UNLOADING
        unloading = float(law["unloading"]) if striker.crushes else loading
        steepest = curve.unloading_stiffness(columns.reach(column))
        bodies = (mass, steepest), (striker.mass, unloading)
        count, turned = steps_of(scenario.duration, *bodies)
        step = scenario.duration / count
        if turned > 1.0:
            where = f"steps of {step:.2g} s, at most {_MOST_STEPS:.0e} are kept"
            raise SolverError(where, turned, "a softer striker or a shorter record")
        force = np.inf if self.crush_force is None else self.crush_force
        stiffness = np.inf if striker.crushes else self.striker_stiffness
        blow, limit = (striker.mass, striker.velocity, 0.0, 0.0), columns.limit_of(curve, column)
        sag, gravity = columns.displacement_under(curve, column, weight), scenario.acceleration
        drive = *blow, curve.elastic_limit, limit, mass, weight, sag, stiffness, force
        pace = Pace.equal(scenario.duration, step, count)
        run = follow(impact, (curve.pieces,), pace, drive, one_mass.RECORD, striker, gravity)
        records = run.records
        if run.collapsed:
            reached, when = float(records["displacement"][-1]), float(records["time"][-1])
            raise columns.collapsed(curve, column, reached, when)
        solved = perf_counter() - started
        top = float(records["displacement"].max()) + sag
        shear, warnings = columns.reached(curve, column, top)
        values: dict[str, Any] = {
            **run.histories,
            "input_energy": scenario.input_energy,
            "shear_utilisation": shear,
            "residual_displacement": float(records["plastic"][-1]),
        }
        time, _ = values.pop("time"), values.pop("plastic")
        if shear is not None and self.resistance != PANEL:
            warnings += shear_warnings(column, dict(zip(columns.SEGMENTS, shear, strict=True)))
        if records["percussion"][-1] > 0.0 and records["striker_velocity"].min() > 0.0:
            values |= dict.fromkeys(("peak_displacement", "time_of_peak", "residual_displacement"))
            if not signed_peak(records["time"], records["displacement"])[2]:
                longer = float(np.pi * np.sqrt(striker.mass / loading))
                warnings.append(finding("still-pushing", duration=scenario.duration, longer=longer))
        response = build_response(values, time=time, segments=columns.SEGMENTS, warnings=warnings)
        error = energy_error(response)
        if error is not None and error > _BALANCE:
            raise SolverError("the energy balance", error, f"steps of {step:.2g} s")
        response.attrs["solve_time"] = solved
        response.attrs |= {"dead_displacement": sag} if sag else {}
        return response
