"""The impact of a structure of superelements, stepped through in compiled code."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from workbench.arrays import Array
from workbench.errors import SolverError
from workbench.impact.pace import Pace
from workbench.structures.assembly import PlanarAssembly
from workbench.structures.elements import StepEnergies
from workbench.structures.superelements.group import Superelements, SuperelementState
from workbench.structures.superelements.march_kernels import (
    CLOCK,
    GOING,
    NO_CONVERGENCE,
    RECORD,
    TOO_MANY,
    advance,
)
from workbench.structures.superelements.step_kernels import Body, Motion, Work
from workbench.structures.time_steps import PointMass, TimeStep

NUMBERS = 500_000  # of the states that are handed over at a time, at most


def follow_impact(
    assembly: PlanarAssembly,
    dof: int,
    striker: PointMass,
    pace: Pace,
    *,
    sign: float = 1.0,
    tolerance: float = 1e-9,
    calm: float = 0.0,
) -> Iterator[TimeStep]:
    """Follow an impact as `structures.impact.impact` does with its midpoint scheme.

    Arguments as there, but the `pace` of the steps, and the time `calm` (s) before which none is
    long as in a vibration. The only group of the `assembly` are
    superelements. Yields several records at a time, the first one of the start: the numbers of a
    `TimeStep` are arrays (records,), and the displacement, velocity and stored energy of the
    assembly and the states of its elements have the records as their first axis while a step is
    looked at. Raises `SolverError`.
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
    rows = max(8, min(1024, NUMBERS // (2 * x.size + sum(values.size for values in old))))
    status = GOING
    while status == GOING:
        records = np.zeros(rows, RECORD)
        stack = _stack(motion, rows)
        if clock["steps"] == 0:
            start = {"stored": assembly.stored, "kinetic": assembly.kinetic_energy()}
            start |= {"striker_position": striker.position, "striker_velocity": striker.velocity}
            for name, value in start.items():
                records[name][0] = value
        status, count = advance(body, pace, motion, work, clock, records, stack)
        if count:
            group.show(SuperelementState(*(values[:count] for values in stack.old)))
            told = _told(records[:count], striker)
            assembly.show(stack.x[:count], stack.v[:count], told.energies.stored)
            yield told
            group.show(SuperelementState(*(values[count - 1] for values in stack.old)))
            last = float(records["stored"][count - 1])
            assembly.show(stack.x[count - 1], stack.v[count - 1], last)
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


def _stack(motion: Motion, rows: int) -> Motion:
    """Room for so many states."""

    def room(values: Array) -> Array:
        return np.empty((rows, *values.shape))

    old = SuperelementState(*map(room, motion.old))
    return motion._replace(x=room(motion.x), v=room(motion.v), old=old)


def _told(records: Any, striker: PointMass) -> TimeStep:
    """What the records say, as the steps between them."""
    numbers = records.view(np.float64).reshape(len(records), -1).T.copy()
    told = dict(zip(RECORD.names or (), numbers, strict=True))
    told |= {name: records[name].astype(float) for name in ("evaluations", "cuts")}
    energies = StepEnergies(*(told[name] for name in StepEnergies._fields))
    moved = PointMass(
        striker.mass, told["striker_velocity"], striker.restitution, told["striker_position"]
    )
    same = {name: told[name] for name in told.keys() & set(TimeStep._fields)}
    return TimeStep(energies=energies, striker=moved, **same)
