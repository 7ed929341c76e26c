"""Impact driver: energy-exact time steps with a unilateral contact at one dof.

One step from t_n to t_n+1 solves M (v1 - v0)/dt + f = p + w P/dt with v1 = 2 (x1 - x0)/dt - v0 and
energy-exact element forces f whose stresses are (1 - weight) old + weight new. A closed contact
obeys Newton's law in the velocity form of Moreau, xi = gamma_1 + restitution gamma_0 = 0, which
makes the percussion P linear in x1, so that it is eliminated: no penalty, no extra unknown.
Source: Heng 2017, chapter 3 (percussion form) and chapter 5 (energy-momentum step).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.errors import SolverError
from workbench.impact import _kernels as contact
from workbench.structures.assembly import PlanarAssembly
from workbench.structures.ledger import StepEnergies
from workbench.structures.newton import Solution, newton

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PointMass:
    """A rigid striker at one dof: `mass` (kg), `velocity` (m/s), `position` (m), `restitution`.

    The gap is the displacement of the dof less the position; both are zero at first contact.
    """

    mass: float
    velocity: float
    restitution: float = 0.0
    position: float = 0.0

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy, in J."""
        return 0.5 * self.mass * self.velocity**2


class TimeStep(NamedTuple):
    """A committed time step.

    `time` at its end and `length` of it in s; the `striker` at its end; `percussion` of the step
    in N s and the energy `contact_loss` of the step in J; `energies` of the structure;
    `external_work` of the dead loads in the step in J; `kinetic` energy of the structure at its
    end in J; `evaluations` of the residual, and `cuts`, how often the step was halved.
    """

    time: float
    length: float
    striker: PointMass
    percussion: float
    contact_loss: float
    energies: StepEnergies
    external_work: float
    kinetic: float
    evaluations: int
    cuts: int


class _Attempt(NamedTuple):
    solution: Solution
    velocity: Array
    percussion: float
    admissible: bool


def _attempt(
    assembly: PlanarAssembly,
    dof: int,
    striker: PointMass,
    dt: float,
    weight: float,
    closed: bool,
    tolerance: float,
) -> _Attempt:
    """Solve one step with the contact closed or open; tell whether that was admissible."""
    x0, v0 = assembly.displacement, assembly.velocity
    gamma0 = float(v0[dof]) - striker.velocity
    held = assembly.held
    restitution = contact.rebound(gamma0, striker.restitution)
    touch = striker.velocity - restitution * gamma0
    start_momentum = assembly.mass_times(v0) * (2.0 / dt)
    factor = 2.0 / dt**2

    def evaluate(x: Array) -> Array:
        force = assembly.assemble(x, weight, factor)
        inertia = assembly.mass_times(x - x0) * factor - start_momentum
        residual = inertia + force - assembly.load
        if closed:
            v1 = 2.0 * (x[dof] - x0[dof]) / dt - v0[dof]
            residual[dof] -= striker.mass * (touch - v1) / dt
            assembly.add_to_diagonal(dof, factor * striker.mass)
        residual[held] = 0.0
        return residual

    def allow(residual: Array) -> float:
        return assembly.allowed_residual(tolerance, residual, x0)

    assembly.begin_step(dt)
    found = newton(evaluate, allow, assembly.solve, x0, 25)
    v1 = 2.0 * (found.x - x0) / dt - v0
    v1[held] = 0.0
    if closed:
        percussion = striker.mass * (touch - float(v1[dof]))
        return _Attempt(found, v1, percussion, percussion >= 0.0)
    separation = float(v1[dof]) - striker.velocity + restitution * gamma0
    return _Attempt(found, v1, 0.0, separation >= 0.0)


def _solve_step(
    assembly: PlanarAssembly,
    dof: int,
    striker: PointMass,
    dt: float,
    weight: float,
    tolerance: float,
) -> tuple[_Attempt | None, int, float]:
    """One step with the right contact state (None: no convergence), evaluations, residual."""
    gamma0 = float(assembly.velocity[dof]) - striker.velocity
    gap = float(assembly.displacement[dof]) - striker.position
    if gap + dt * min(gamma0, 0.0) > 0.0:
        orders: tuple[bool, ...] = (False,)
    else:
        orders = (False, True) if gamma0 > 0.0 else (True, False)
    evaluations = 0
    residual = 0.0
    refused = False
    for closed in orders:
        tried = _attempt(assembly, dof, striker, dt, weight, closed, tolerance)
        evaluations += tried.solution.evaluations
        residual = max(residual, tried.solution.residual)
        if not tried.solution.converged:
            continue
        # a closed contact that pulls must open, whatever the open solution says of velocities
        if tried.admissible or len(orders) == 1 or (refused and not closed):
            return tried, evaluations, residual
        refused = True
    return None, evaluations, residual


def impact(
    assembly: PlanarAssembly,
    dof: int,
    striker: PointMass,
    spans: Sequence[tuple[float, float]],
    weight: float,
    tolerance: float = 1e-8,
    most_cuts: int = 12,
) -> Iterator[TimeStep]:
    """Follow an impact at `dof` in the direction of growing displacement.

    Arguments: `assembly` at rest under its dead loads; `striker`; `spans`, end times and nominal
    steps of successive parts of the record, both in s; `weight` of the end stresses, 1/2 to 1 (1/2
    conserves energy exactly, more dissipates grid-scale ringing); `tolerance` of the residual over
    the largest force; `most_cuts`, how often a step may be halved when Newton's method fails.
    Yields a `TimeStep` after each commit. Raises `SolverError`.
    """
    begin = 0.0
    for end, nominal in spans:
        if end <= begin:
            continue
        for taken in _span(
            assembly, dof, striker, end - begin, nominal, weight, tolerance, most_cuts, begin
        ):
            striker = taken.striker
            yield taken
        begin = end


def _span(
    assembly: PlanarAssembly,
    dof: int,
    striker: PointMass,
    duration: float,
    nominal: float,
    weight: float,
    tolerance: float,
    most_cuts: int,
    begin: float,
) -> Iterator[TimeStep]:
    """A part of the record with one nominal step; steps are halved and doubled back as needed."""
    count = max(1, ceil(duration / nominal - 1e-9))
    step = duration / count
    level = 0
    index = 0  # in units of step / 2^level
    evaluations = cuts = 0
    while index < count * 2**level:
        dt = step / 2**level
        found, spent, residual = _solve_step(assembly, dof, striker, dt, weight, tolerance)
        evaluations += spent
        if found is None:
            level += 1
            cuts += 1
            index *= 2
            if level > most_cuts:
                raise SolverError(
                    f"time {begin + index * dt / 2:.6g} s",
                    residual,
                    f"line search, open and closed contact, steps down to {dt:.3g} s",
                )
            continue
        index += 1
        taken = _commit(assembly, dof, striker, found, dt, weight)
        yield taken._replace(time=begin + index * dt, evaluations=evaluations, cuts=cuts)
        striker = taken.striker
        evaluations = cuts = 0
        while level > 0 and index % 2 == 0:
            level -= 1
            index //= 2


def _commit(
    assembly: PlanarAssembly,
    dof: int,
    striker: PointMass,
    found: _Attempt,
    dt: float,
    weight: float,
) -> TimeStep:
    """Commit a solved step and account for its energies."""
    end = found.solution.x
    approach = float(assembly.velocity[dof]) - striker.velocity
    energies = assembly.account(end, weight)
    external_work = float(assembly.load @ (end - assembly.displacement))
    assembly.commit(end, found.velocity)
    assembly.stored = energies.stored
    velocity = striker.velocity - found.percussion / striker.mass
    departure = float(found.velocity[dof]) - velocity
    position = striker.position + 0.5 * dt * (striker.velocity + velocity)
    return TimeStep(
        time=0.0,
        length=dt,
        striker=replace(striker, velocity=velocity, position=position),
        percussion=found.percussion,
        contact_loss=contact.contact_loss(found.percussion, approach, departure),
        energies=energies,
        external_work=external_work,
        kinetic=assembly.kinetic_energy(),
        evaluations=0,
        cuts=0,
    )
