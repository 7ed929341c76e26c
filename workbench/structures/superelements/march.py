"""The impact of a structure of superelements, stepped through in compiled code."""

from collections.abc import Iterator
from math import inf
from typing import Any, NamedTuple

import numpy as np

from workbench.arrays import Array
from workbench.errors import SolverError
from workbench.impact.pace import Pace
from workbench.structures.assembly import PlanarAssembly
from workbench.structures.elements import StepEnergies
from workbench.structures.superelements.group import Superelements, SuperelementState
from workbench.structures.superelements.march_kernels import (
    CLOCK,
    COLLAPSED,
    GOING,
    NO_CONVERGENCE,
    RECORD,
    TOO_MANY,
    CollapseLimits,
    States,
    advance,
)
from workbench.structures.superelements.step_kernels import Body, Motion, Work
from workbench.structures.time_steps import PointMass, TimeStep

NUMBERS = 500_000  # that are handed over at a time, at most


class Read(NamedTuple):
    """States of several records, and whether the structure has `collapsed` in the last one."""

    states: States
    collapsed: bool


def follow_impact(
    assembly: PlanarAssembly,
    dof: int,
    striker: PointMass,
    pace: Pace,
    limits: CollapseLimits | None = None,
    *,
    sign: float = 1.0,
    tolerance: float = 1e-9,
    calm: float = 0.0,
) -> Iterator[TimeStep]:
    """Follow an impact as `structures.impact.impact` does with its midpoint scheme.

    Arguments as there, but the `pace` of the steps, `limits` beyond which the structure has
    collapsed (None: never), and the time `calm` (s) before which no step is long as in a vibration.
    The only group of the `assembly` are superelements; both stay as they are. Yields several
    records at a time, the first one of the start: the numbers of a `TimeStep` are arrays
    (records,), and its states are `read`. Raises `SolverError`.
    """
    (group,) = assembly.groups
    assert isinstance(group, Superelements)
    body = _body(assembly, group, dof, striker, sign, tolerance)
    old, new = group.states
    x = assembly.displacement.copy()
    motion = Motion(
        x,
        assembly.velocity.copy(),
        assembly.mass_times(assembly.velocity),
        SuperelementState(*(values.copy() for values in old)),
        SuperelementState(*(values.copy() for values in new)),
        np.array([striker.position, striker.velocity]),
        np.zeros_like(x),
        np.zeros_like(x),
        np.zeros_like(x),
        np.zeros(1),
        np.array([assembly.largest_force]),
    )
    scratch: list[Array] = [*np.empty((2, assembly.band.size)), *np.zeros((8, assembly.size))]
    work = Work._make([*scratch, np.zeros(assembly.size, np.int64)])
    clock = np.zeros(1, CLOCK)[0]
    clock["dt"], clock["error"], clock["highest"] = pace.first, pace.error, sign * x[dof]
    clock["calm"] = calm
    lost = limits or _never()
    rows = max(1, min(1024, NUMBERS // (2 * x.size + sum(values.size for values in old))))
    status = GOING
    while status in (GOING, COLLAPSED):
        records = np.zeros(rows, RECORD)
        elements = (np.empty((rows, *values.shape)) for values in old)
        states = States(
            np.empty((rows, x.size)), np.empty((rows, x.size)), SuperelementState(*elements)
        )
        if not clock["begun"]:
            start = {"stored": assembly.stored, "kinetic": assembly.kinetic_energy()}
            start |= {"striker_position": striker.position, "striker_velocity": striker.velocity}
            for name, value in start.items():
                records[name][0] = value
        status, count = advance(body, lost, pace, motion, work, clock, records, states)
        if count:
            shown = SuperelementState(*(values[:count] for values in states.elements))
            states = States(states.x[:count], states.v[:count], shown)
            yield _steps(records[:count], striker, Read(states, status == COLLAPSED))
    if status == NO_CONVERGENCE:
        tried = f"line search, open and closed contact, steps down to {2 * clock['dt']:.3g} s"
        raise SolverError(f"time {clock['time']:.6g} s", float(clock["residual"]), tried)
    if status == TOO_MANY:
        tried = f"{pace.most} steps; a softer or heavier structure needs fewer"
        raise SolverError(f"time {clock['time']:.6g} s", float(clock["residual"]), tried)


def _body(
    assembly: PlanarAssembly,
    group: Superelements,
    dof: int,
    striker: PointMass,
    sign: float,
    tolerance: float,
) -> Body:
    springs = assembly.springs
    (hinges,) = group.tables
    return Body(
        group.bars,
        hinges,
        assembly.mass,
        assembly.width,
        assembly.held,
        assembly.load,
        np.array(list(springs), dtype=np.int64),
        np.array(list(springs.values()), dtype=float).reshape(-1, 2),
        float(assembly.shortest),
        dof,
        sign,
        striker.mass,
        striker.velocity,
        striker.restitution,
        sign * float(assembly.displacement[dof]),
        tolerance,
    )


def _never() -> CollapseLimits:
    """Limits that no structure passes."""
    pairs, none, numbers = np.zeros((0, 2)), np.zeros(0), np.zeros(0, np.int64)
    corners = np.zeros((0, 4), np.int64)
    return CollapseLimits(
        inf, inf, -inf, np.zeros(1, np.int64), corners, pairs, pairs, numbers, none
    )


def _steps(records: Any, striker: PointMass, read: Read) -> TimeStep:
    """The steps between records, as one whose numbers are arrays."""
    columns = records.view(np.float64).reshape(len(records), -1).T.copy()
    values = dict(zip(RECORD.names or (), columns, strict=True))
    values |= {name: records[name].astype(float) for name in ("evaluations", "cuts")}
    energies = StepEnergies(*(values[name] for name in StepEnergies._fields))
    moved = PointMass(
        striker.mass, values["striker_velocity"], striker.restitution, values["striker_position"]
    )
    same = {name: values[name] for name in values.keys() & set(TimeStep._fields)}
    return TimeStep(energies=energies, striker=moved, read=read, **same)
