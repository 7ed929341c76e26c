"""A column on its resistance curve under a force over time: steps, histories, response."""

from collections.abc import Callable, Mapping
from functools import lru_cache
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from workbench.arrays import Array
from workbench.impact.pace import Pace
from workbench.impact.records import follow
from workbench.models.practice.deflected_shape import beam_of
from workbench.models.resistance import ResistanceCurve, columns
from workbench.models.single_dof import march
from workbench.responses import Response, build_response
from workbench.scenarios import Column, MemberPulse, Pulse
from workbench.scenarios.pulse import UNIFORM

_STEPS_PER_PERIOD = 64  # of the lightest mass on the steepest stiffness
_FEWEST_STEPS, _MOST_STEPS = 400, 1_000_000


class Pushed(NamedTuple):
    """What a pulse moves: the resistance `curve`, and the `share` of the pulse that acts on it.

    `stages`: displacement (m) from which on a mass (kg) moves, the first from 0 on, and the
    velocity that it begins with over that before; whether force and resistance are those `at_hit`,
    at the hit point, so that energies are those of the member; `damping` of the mass in N s/m.
    """

    curve: ResistanceCurve
    stages: tuple[tuple[float, float, float], ...]
    share: float
    at_hit: bool
    damping: float = 0.0


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
    pushed: Pushed, column: Column, pulse: Pulse, duration: float
) -> tuple[Array, dict[str, Any]]:
    """Follow a column at rest under a pulse for `duration` (s): time (s) and values of a response.

    Raises `SolverError`, and `CollapseError` where the column collapses.
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
    drive = march.no_striker(curve.elastic_limit, limit, pushed.stages[0][1])
    run = follow(march.pulse, tables, Pace.equal(duration, step, steps), drive, march.RECORD)
    records = run.records
    if run.collapsed:
        reached, when = float(records["displacement"][-1]), float(records["time"][-1])
        raise columns.collapsed(curve, column, reached, when)
    values: dict[str, Any] = {name: records[name] for name in ("displacement", "velocity", "force")}
    if pushed.at_hit:
        values |= {name: records[name] for name in ("kinetic", "elastic", "dissipated")}
        works = records["external_work"]
        values |= {"external_work": works, "input_energy": np.max(np.abs(works))}
    values["load"] = pushed.share * pulse.force(time)
    if int(np.argmax(records["displacement"])) < steps:  # there is a peak to come back from
        values["residual_displacement"] = float(records["plastic"][-1])
    return time, values


def pulse_response(
    scenario: MemberPulse,
    pushed: Pushed,
    further: Callable[[dict[str, Any]], Mapping[str, Any]] | None = None,
) -> Response:
    """The answer to a member under a pulse; `further`: values read off the others."""
    started = perf_counter()
    time, values = push(pushed, scenario.column, scenario.pulse, scenario.duration)
    solved = perf_counter() - started
    curve, top = pushed.curve, float(values["displacement"].max())
    shear, warnings = columns.reached(curve, scenario.column, top)
    values["load"] = scenario.whole * scenario.pulse.force(time)
    if scenario.load != UNIFORM:  # a line load makes shear of its own
        values["shear_utilisation"] = shear
    if further is not None:
        values |= further(values)
    response = build_response(values, time=time, segments=columns.SEGMENTS, warnings=warnings)
    response.attrs["solve_time"] = solved
    return response
