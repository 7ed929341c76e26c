"""A column on its resistance curve under a force over time: steps, histories, response.

Without a striker, under a force over time,

    M(v) v'' + c v' + R(v) = F(t),

the mass belongs to a shape of deflection that changes once the spring has come to the next stage
(Biggs), and the velocity by a factor that the stage brings; the kinetic energy that this leaves is
dissipated.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit
from workbench.mechanics.impact.contact import uncounted
from workbench.mechanics.impact.integrator import DRIVE, Model, begin, march_of, no_flow
from workbench.mechanics.impact.pace import Pace
from workbench.mechanics.impact.records import follow
from workbench.models.resistance import ResistanceCurve, columns
from workbench.models.resistance.deflected_shape import beam_of
from workbench.models.single_dof import march
from workbench.models.single_dof.spring import solve_midpoint
from workbench.responses import Response, build_response
from workbench.responses.histories import largest_of, peak_of, unloaded
from workbench.scenarios import Column, MemberPulse, Pulse
from workbench.scenarios.pulse import UNIFORM

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
    at the hit point, so that energies are those of the member; `damping` of the mass in N s/m.
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


_march = march_of(Model(march.hit, solve_pushed, no_flow, accept_pushed, march.write, march.lost))


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

    Argument: its `weight` at the hit point (N), under which it lies. Raises `SolverError`, and
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
