"""A column on its resistance curve under a force over time: steps, histories, response."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from workbench.arrays import Array
from workbench.errors import SolverError
from workbench.models.resistance import ResistanceCurve
from workbench.models.resistance.limits import collapsed, limit_of, reach
from workbench.models.single_dof import kernels
from workbench.models.single_dof.pulse_kernels import pushed
from workbench.responses import peak_of
from workbench.scenarios import Column, Pulse

_STEPS_PER_PERIOD = 64  # of the lightest mass on the steepest stiffness
_FEWEST_STEPS, _MOST_STEPS = 400, 1_000_000
_PUSHED = ("displacement", "velocity", "force", "kinetic", "elastic", "dissipated")


class Push(NamedTuple):
    """A finished run: `time` (s), the `values` of its response, and where the spring ended."""

    time: Array
    values: dict[str, Any]
    spring: kernels.Spring


def push(
    curve: ResistanceCurve,
    column: Column,
    stages: Sequence[tuple[float, float]],
    pulse: Pulse,
    share: float,
    duration: float,
) -> Push:
    """Follow a column at rest under `share` times a pulse for `duration` (s).

    `stages`: displacement (m) from which on a mass (kg) moves with the point of the force, the
    first from 0 on. Raises `SolverError`, and `CollapseError` where the column collapses.
    """
    lightest = min(mass for _, mass in stages)
    stiffest = curve.unloading_stiffness(reach(column))
    period = 2.0 * np.pi * np.sqrt(lightest / stiffest)
    longest = min(period / _STEPS_PER_PERIOD, duration / _FEWEST_STEPS)
    steps = min(int(np.ceil(duration / longest)), _MOST_STEPS)
    step = duration / steps
    time = np.linspace(0.0, duration, steps + 1)
    records = np.zeros(steps + 1, kernels.RECORD)
    status, last, residual, spring, works = pushed(
        step,
        np.array(stages),
        share * pulse.means(time),
        curve.elastic_limit,
        limit_of(curve, column),
        curve.pieces,
        records,
    )
    if status == kernels.NO_CONVERGENCE:
        where = f"time {last * step:.4g} s (step of {step:.3g} s)"
        raise SolverError(where, residual, "Newton with bisection")
    if status == kernels.COLLAPSE:
        raise collapsed(curve, column, float(records["displacement"][last]), last * step)
    top = peak_of(time, records["displacement"])
    plastic = spring.v - spring.force / spring.stiffness if spring.yielded else 0.0
    values = {
        **{name: records[name] for name in _PUSHED},
        **top,
        "residual_displacement": plastic if top else None,
        "external_work": works,
        "input_energy": np.max(np.abs(works)),
    }
    return Push(time, values, spring)
