"""The impact of a structure of superelements, stepped through in compiled code."""

from collections.abc import Iterator
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
    GOING,
    LOST,
    NO_CONVERGENCE,
    RECORD,
    TOO_MANY,
    advance,
)
from workbench.structures.superelements.reading_kernels import Lost, Pictures, Places, Reading, Rows
from workbench.structures.superelements.step_kernels import Body, Motion, Work
from workbench.structures.time_steps import PointMass, TimeStep

NUMBERS = 500_000  # that are handed over at a time, at most


class Read(NamedTuple):
    """What was read of several records, and whether the structure was `lost` in the last one."""

    rows: Rows
    lost: bool


def reading_of(
    assembly: PlanarAssembly, places: Places, lost: Lost | None = None, turns: Array | None = None
) -> Reading:
    """What is read of the records of one impact on a structure, empty.

    Arguments: `places` of it; beyond what it is `lost` (None: never); `turns` (s) of its pictures
    (None: there are none).
    """
    at = np.zeros(0) if turns is None else turns
    states, members = len(at) + 2, len(places.first) - 1
    elements = len(assembly.groups[0].nodes)
    moved, carried = np.zeros((states, assembly.size)), np.zeros((states, elements, 3))
    return Reading(
        places,
        lost or Lost(np.inf, np.inf, -np.inf),
        _room(places, 0),
        Pictures(at, np.zeros(4), np.full(states, np.nan), moved, carried),
        np.zeros((2, members)),
        np.zeros(places.sway.shape[1]),
        np.zeros(members),
    )


def _room(places: Places, rows: int) -> Rows:
    """Room for what is read of so many records."""
    hinges, members = len(places.hinge), len(places.first) - 1 if places.slide.any() else 0
    counts = hinges, hinges, hinges, members, len(places.watched)
    return Rows._make([*(np.empty((rows, count)) for count in counts), np.empty(rows)])


def follow_impact(
    assembly: PlanarAssembly,
    dof: int,
    striker: PointMass,
    pace: Pace,
    reading: Reading,
    *,
    sign: float = 1.0,
    tolerance: float = 1e-9,
    calm: float = 0.0,
) -> Iterator[TimeStep]:
    """Follow an impact as `structures.impact.impact` does with its midpoint scheme.

    Arguments as there, but the `pace` of the steps, what is read of the records, see `reading_of`,
    and the time `calm` (s) before which none is long as in a vibration. The only group of the
    `assembly` are superelements. Yields several records at a time, the first one of the start: the
    numbers of a `TimeStep` are arrays (records,), and it holds what was `read`; assembly and
    elements show the state of the last one. Raises `SolverError`.
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
    rows = max(1, min(1024, NUMBERS // (3 * len(reading.places.hinge) + 1)))
    status = GOING
    group.show(motion.old)
    while status in (GOING, LOST):
        records = np.zeros(rows, RECORD)
        own = reading._replace(rows=_room(reading.places, rows))
        if not clock["begun"]:
            start = {"stored": assembly.stored, "kinetic": assembly.kinetic_energy()}
            start |= {"striker_position": striker.position, "striker_velocity": striker.velocity}
            for name, value in start.items():
                records[name][0] = value
        status, count = advance(body, pace, motion, work, clock, records, own)
        if count:
            assembly.show(motion.x, motion.v, float(records["stored"][count - 1]))
            read = Rows(*(values[:count] for values in own.rows))
            yield _told(records[:count], striker, Read(read, status == LOST))
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


def _told(records: Any, striker: PointMass, read: Read) -> TimeStep:
    """What the records say, as the steps between them."""
    numbers = records.view(np.float64).reshape(len(records), -1).T.copy()
    told = dict(zip(RECORD.names or (), numbers, strict=True))
    told |= {name: records[name].astype(float) for name in ("evaluations", "cuts")}
    energies = StepEnergies(*(told[name] for name in StepEnergies._fields))
    moved = PointMass(
        striker.mass, told["striker_velocity"], striker.restitution, told["striker_position"]
    )
    same = {name: told[name] for name in told.keys() & set(TimeStep._fields)}
    return TimeStep(energies=energies, striker=moved, read=read, **same)
