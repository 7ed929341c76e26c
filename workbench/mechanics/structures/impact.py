"""Implicit time steps: the equations of one, the march through a record, forces over time.

A step from t_n to t_n+1 solves M (v1 - v0) / dt + f + damping M (x1 - x0) / dt = p + w P / dt with
v1 = 2 (x1 - x0) / dt - v0. The forces f are the energy-exact ones of the elements. A closed contact
makes the impulse P linear in x1, so that it is eliminated: no penalty, no extra unknown.

Moving ground is a force over time: relative to the supports M x'' + damping M x' + f(x) =
p - M r a(t) with the rigid displacement r of all dofs for a unit displacement of the ground; M
includes point masses, dead loads p stay. The mean acceleration of a step closes the ledger with the
input energy -r . M (x1 - x0) a (Uang and Bertero 1990, relative energy).

**Second part.** Impact driver: implicit time steps with a unilateral contact at one dof.

The midpoint step x1 = x0 + dt (v0 + v1) / 2 with energy-exact element forces, stresses
(1 - weight) old + weight new, and Newton's law of restitution in the velocity form of Moreau,
xi = gamma_1 + restitution gamma_0 = 0 for a closed contact, gamma the velocity of the gap. Other
schemes, on a column and on a frame, are those of the companion `extras.laboratory`.

Sources: Heng 2017, chapter 3 (eqs 3.17-3.30; energy-momentum step 3.31-3.33); Moreau 1988.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import ceil
from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import SolverError
from workbench.mechanics.impact import contact
from workbench.mechanics.impact.contact import TRIES, approach_at, crush_line, force_at, obeys
from workbench.mechanics.impact.integrator import law_of
from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.elements import StepEnergies
from workbench.mechanics.structures.equilibrium import Solution, newton, pieces
from workbench.scenarios import ColumnImpact, FrameImpact, Striker

TOLERANCE = 1e-9  # of the residual over the largest force
MOST_CUTS = 12  # how often a step may be halved when Newton's method fails
MOST_STEPS = 2_000_000  # of a record: more take a day
ITERATIONS = 25
AXES = {"x": "u", "y": "v"}
Spans = Sequence[tuple[float, float]]  # end times and nominal steps of parts of a record, in s


@dataclass(frozen=True)
class PointMass:
    """A striker at one dof: `mass` (kg), `velocity` (m/s), `position` (m), `restitution`.

    Velocity and position are along the strike, the position from where the struck dof is when the
    record starts: 0 is first contact, and less is farther away. `crushing`: the striker of a
    scenario, for its law (None: rigid); `gravity` along the strike (m/s2).
    """

    mass: float
    velocity: float
    restitution: float = 0.0
    position: float = 0.0
    crushing: Striker | None = None
    gravity: float = 0.0

    @classmethod
    def of(cls, scenario: ColumnImpact | FrameImpact) -> "PointMass":
        """The striker of a scenario at first contact."""
        striker, gravity = scenario.striker, scenario.acceleration
        blow = striker.mass, striker.velocity, striker.restitution
        return cls(*blow, crushing=striker, gravity=gravity)

    def moved(self, dt: float, impulse: float) -> tuple["PointMass", float]:
        """The striker after a time (s) and an `impulse` (N s), and the work of gravity (J)."""
        velocity = self.velocity + dt * self.gravity - impulse / self.mass
        way = 0.5 * dt * (self.velocity + velocity)
        moved = replace(self, velocity=velocity, position=self.position + way)
        return moved, self.mass * self.gravity * way

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy, in J."""
        return 0.5 * self.mass * self.velocity**2


class TimeStep(NamedTuple):
    """A committed time step.

    `length` of it in s; `energies` of the structure; `external_work` of the dead loads in the step,
    and `kinetic` energy of the structure at its end, in J; end `time` in s; `evaluations` of the
    residual, and `cuts`, how often the step was halved. Of an impact the `striker` at the end, the
    contact `impulse` of the step in N s and the energy `contact_loss` in J. Of ground motion, all
    relative to the ground, or a force over time: the `input_energy` and `damped` energy in J.
    """

    length: float
    energies: StepEnergies
    external_work: float
    kinetic: float
    time: float = 0.0
    evaluations: int = 0
    cuts: int = 0
    striker: PointMass | None = None
    impulse: float = 0.0
    contact_loss: float = 0.0
    input_energy: float = 0.0
    damped: float = 0.0


class Pull(NamedTuple):
    """A closed contact: P = mass (touch - w . v1) at `dof`, w = `sign` there."""

    dof: int
    sign: float
    mass: float
    touch: float


class SolvedStep(NamedTuple):
    """A solved step: `solution` and end `velocity` (dofs,).

    Of an impact the contact `impulse` in N s, and whether the state of contact is `admissible`.
    """

    solution: Solution
    velocity: Array
    impulse: float = 0.0
    admissible: bool = True


def solve_step(
    assembly: PlanarAssembly,
    dt: float,
    weight: float,
    load: Array,
    tolerance: float,
    *,
    damping: float = 0.0,
    pull: Pull | None = None,
    ahead: Array | None = None,
) -> SolvedStep:
    """Solve one step from the committed state; the trial state stays in the groups.

    Arguments: `dt` in s; `weight` of the end stresses in energy-exact forces; `load` (dofs,) of
    the step in N; `tolerance` of the residual over the largest force; mass-proportional `damping`
    in 1/s; `pull` of a closed contact; `ahead`, displacements (dofs,) by which the step is expected
    to go.
    """
    x0, v0 = assembly.displacement, assembly.velocity
    start_momentum = assembly.mass_times(v0) * (2.0 / dt)
    factor = 2.0 / dt**2 + damping / dt
    given = start_momentum + load

    def evaluate(x: Array) -> Array:
        force = assembly.assemble(x, weight, factor)
        residual = assembly.residual(x - x0, factor, given, force)
        if pull is not None:
            d = pull.dof
            v1 = pull.sign * (2.0 * (x[d] - x0[d]) / dt - v0[d])
            residual[d] -= pull.sign * pull.mass * (pull.touch - v1) / dt
            assembly.add_to_diagonal(d, 2.0 / dt**2 * pull.mass)
        return residual

    assembly.begin_step(dt)
    allow = partial(assembly.allowed_residual, tolerance, x0)
    first = x0 if ahead is None else x0 + ahead
    solution = newton(evaluate, allow, assembly.solve, first, ITERATIONS)
    velocity = 2.0 * (solution.x - x0) / dt - v0
    velocity[assembly.held] = 0.0
    return SolvedStep(solution, velocity)


def commit(
    assembly: PlanarAssembly, dt: float, end: Array, velocity: Array, weight: float
) -> TimeStep:
    """Commit a solved step of `dt` (s) that ends at `end`, with its energies.

    Arguments: displacements `end` and `velocity` (dofs,); `weight` of the end stresses.
    """
    energies = assembly.account(end, weight)
    work = float(assembly.load @ (end - assembly.displacement))
    assembly.commit(end, velocity)
    assembly.stored = energies.stored
    return TimeStep(dt, energies, work, assembly.kinetic_energy())


def check_count(steps: float, time: float = 0.0, residual: float = 0.0) -> None:
    """Raise `SolverError` where a record takes too many steps; the last one as it was left."""
    if not steps <= MOST_STEPS:
        tried = f"{MOST_STEPS} of {steps:.3g} steps; take a shorter duration or a longer time_step"
        raise SolverError(f"time {time:.6g} s", residual, tried)


def march(
    spans: Spans,
    advance: Callable[[float, float], tuple[TimeStep | None, int, float]],
    remedies: str,
) -> Iterator[TimeStep]:
    """Go through a record; steps are halved where they fail and doubled back afterwards.

    Arguments: `spans`; `advance`, takes the start and the length of a step, commits it and gives
    it, or None if it is not solved, with the residual evaluations and the scaled residual; what
    else `advance` tries, for errors.
    Yields the steps with their end `time`, `evaluations` and `cuts`. Raises `SolverError`.
    """
    evaluations = steps = 0
    ends = [0.0, *(end for end, _ in spans)]
    check_count(sum((b - a) / step for a, (b, step) in zip(ends, spans, strict=False)))

    def attempt(
        begin: float, step: float, number: int, done: float, share: float
    ) -> TimeStep | SolverError:
        nonlocal evaluations, steps
        start, length = begin + (number + done) * step, share * step
        taken, spent, residual = advance(start, length)
        evaluations, steps = evaluations + spent, steps + 1
        check_count(steps, start, residual)
        if taken is None:
            tried = f"{remedies}, steps down to {length:.3g} s"
            return SolverError(f"time {start:.6g} s", residual, tried)
        return taken

    begin = 0.0
    for end, nominal in spans:
        if end <= begin:
            continue
        count = max(1, ceil((end - begin) / nominal - 1e-9))
        step = (end - begin) / count
        for number in range(count):
            for taken, done, cuts in pieces(partial(attempt, begin, step, number), MOST_CUTS):
                time = begin + (number + done) * step
                yield taken._replace(time=time, evaluations=evaluations, cuts=cuts)
                evaluations = 0
        begin = end


def follow_force(
    assembly: PlanarAssembly,
    pattern: Array,
    mean: Callable[[float, float], float],
    spans: Spans,
    weight: float,
    damping: float = 0.0,
    tolerance: float = TOLERANCE,
) -> Iterator[TimeStep]:
    """Follow a structure under a `pattern` (dofs,) of forces times a factor over time.

    Arguments: `assembly` at rest under its dead loads; the `mean` factor of a step between two
    times (s); `spans`; `weight` of the end stresses, 1/2 to 1 (1/2 conserves energy
    exactly); mass-proportional `damping` in 1/s; `tolerance` of the residual.
    Yields a `TimeStep` after each commit. Raises `SolverError`.
    """

    def advance(begin: float, dt: float) -> tuple[TimeStep | None, int, float]:
        factor = mean(begin, begin + dt)
        load = assembly.load + factor * pattern
        trial = solve_step(assembly, dt, weight, load, tolerance, damping=damping)
        end, converged, residual, evaluations = trial.solution
        if not converged:
            return None, evaluations, residual
        change = end - assembly.displacement
        damped = damping * float(change @ assembly.mass_times(change)) / dt
        work = factor * float(pattern @ change)
        step = commit(assembly, dt, end, trial.velocity, weight)
        return step._replace(input_energy=work, damped=damped), evaluations, residual

    return march(spans, advance, "line search")


def rigid_displacement(assembly: PlanarAssembly, axis: str) -> Array:
    """Displacements (dofs,) of all nodes when the ground moves by 1 along `axis`, x or y."""
    direction = np.zeros(assembly.size)
    direction[assembly.dofs(range(len(assembly.coordinates)), AXES[axis])] = 1.0
    return direction


COLLISION = 1e-5  # of the striker's first energy: what a resolved collision may turn over
CRUSHED = 256  # least part of a step into which the change of the force of a crush law cuts it
OPENING = 32  # steps from the first contact on before their length is doubled


def impact(
    assembly: PlanarAssembly,
    dof: int,
    striker: PointMass,
    spans: Spans,
    weight: float,
    tolerance: float = TOLERANCE,
    *,
    sign: float = 1.0,
    halvings: int = 0,
) -> Iterator[TimeStep]:
    """Follow an impact at `dof`, in the direction of growing displacement or against it.

    Arguments: `assembly` at rest under its dead loads; `striker`; `spans`; `weight` of the end
    stresses, 1/2 to 1 (1/2 conserves energy exactly, more dissipates grid-scale ringing);
    `tolerance` of the residual; `sign`, -1 for a strike along the negative direction; `halvings`,
    how often steps are halved at the first contact, and at most in a later collision. Bending
    waves spread as the root of time, so that steps may grow with it; and a collision takes along
    what a wave reaches within its step, with the loss of Newton's law: where no mass is lumped,
    that is an error of the step.
    Yields a `TimeStep` after each commit. Raises `SolverError`.
    """
    stepper = _Stepper(assembly, dof, sign, striker, weight, tolerance)
    if halvings:
        end, nominal = spans[0]
        steps = [nominal / 2.0**k for k in range(halvings, 0, -1)]
        spans = [*((min(OPENING * step, end), step) for step in steps), *spans]
        stepper.shortest = steps[0]
    yield from march(spans, stepper.advance, "line search, open and closed contact")


class _Stepper:
    """The state of an impact between the steps, and how one is taken."""

    def __init__(
        self,
        assembly: PlanarAssembly,
        dof: int,
        sign: float,
        striker: PointMass,
        weight: float,
        tolerance: float,
    ) -> None:
        self.assembly, self.dof, self.sign = assembly, dof, sign
        self.striker, self.weight, self.tolerance = striker, weight, tolerance
        self.shortest = np.inf  # step of a collision that is not halved, in s
        self._collision, self._approach = COLLISION * striker.kinetic_energy, striker.velocity
        self._law, self._longest = law_of(striker.crushing), 0.0
        self._origin = sign * float(assembly.displacement[dof])
        self._rate: Array | None = None  # mean velocities of the last step

    def _along(self, values: Array) -> float:
        return self.sign * float(values[self.dof])

    @property
    def gap(self) -> float:
        """Distance from the striker to the struck dof, in m; negative where they overlap."""
        return self._along(self.assembly.displacement) - self._origin - self.striker.position

    def advance(self, _begin: float, dt: float) -> tuple[TimeStep | None, int, float]:
        """Take a step with the right contact state and commit it, if it can be solved."""
        gap, approach = self.gap, self._along(self.assembly.velocity) - self.striker.velocity
        if self._law["points"]:
            return self._crush(dt, approach)
        evaluations, residual = 0, 0.0
        touches = contact.may_touch(gap, approach, dt, 0.0)
        closed, refused = touches and not approach > 0.0, False
        for _ in range(2 if touches else 1):
            trial = self._attempt(dt, closed, approach)
            evaluations += trial.solution.evaluations
            residual = max(trial.solution.residual, residual)  # not a number stays one
            if trial.solution.converged:
                if contact.accepts(trial.admissible, touches, closed, refused):
                    turned = -0.5 * trial.impulse * approach
                    if turned > self._collision and dt >= 2.0 * self.shortest:
                        return None, evaluations, residual
                    return self._commit(trial, dt, approach), evaluations, residual
                refused = True
            closed = not closed
        return None, evaluations, residual

    def _attempt(self, dt: float, closed: bool, approach: float) -> SolvedStep:
        """Solve one step with the contact closed or open; tell whether that was admissible."""
        striker = self.striker
        free = striker.velocity + dt * striker.gravity
        touch = contact.touch_velocity(free, approach, striker.restitution)
        trial = self._solve(dt, Pull(self.dof, self.sign, striker.mass, touch) if closed else None)
        end = self._along(trial.velocity)
        if not closed:
            return trial._replace(admissible=end >= touch)
        impulse = striker.mass * (touch - end)
        return trial._replace(impulse=impulse, admissible=impulse >= 0.0)

    def _solve(self, dt: float, pull: Pull | None) -> SolvedStep:
        """Solve one step with a contact that pulls so, or none."""
        return solve_step(
            self.assembly,
            dt,
            self.weight,
            self.assembly.load,
            self.tolerance,
            pull=pull,
            ahead=None if self._rate is None else dt * self._rate,
        )

    def _crush(self, dt: float, approach: float) -> tuple[TimeStep | None, int, float]:
        """Take a step of a striker that crushes: as `contact_step_of` does.

        Not if the force changes by more work than a collision may turn over, in so many halves.
        """
        law, mass, start, evaluations = self._law, self.striker.mass, -self.gap, 0
        law["crushed"] = max(law["crushed"], start)
        speeds, reached = self.striker.velocity - approach, start - dt * approach
        speeds += dt * self.striker.gravity
        self._longest = max(self._longest, dt)
        wanted, lighter, touch = crush_line(law, start, reached, dt, mass, speeds)
        for _ in range(TRIES):
            pull = Pull(self.dof, self.sign, lighter, touch) if wanted > 0.0 else None
            trial = self._solve(dt, pull)
            evaluations += trial.solution.evaluations
            if not trial.solution.converged:
                break
            end = self._along(trial.velocity)
            impulse = 0.0 if pull is None else lighter * (touch - end)
            reached = approach_at(start, dt, mass, speeds, impulse, end)
            wanted, lighter, touch = crush_line(law, start, reached, dt, mass, speeds)
            if obeys(law, impulse, wanted, mass, self._approach):
                change = force_at(law, reached)[0] - force_at(law, start)[0]
                turned = 0.5 * abs(change * (reached - start))
                if turned > self._collision and dt > self._longest / CRUSHED:
                    break
                return self._commit(trial._replace(impulse=impulse), dt, approach), evaluations, 0.0
        return None, evaluations, trial.solution.residual

    def _commit(self, trial: SolvedStep, dt: float, approach: float) -> TimeStep:
        """Commit a solved step and account for its energies."""
        assembly, striker, end = self.assembly, self.striker, trial.solution.x
        self._rate = (end - assembly.displacement) / dt
        step = commit(assembly, dt, end, trial.velocity, self.weight)
        self.striker, work = striker.moved(dt, trial.impulse)
        departure = self._along(trial.velocity) - self.striker.velocity
        loss = contact.contact_loss(trial.impulse, approach, departure)
        step = step._replace(external_work=step.external_work + work, contact_loss=loss)
        return step._replace(striker=self.striker, impulse=trial.impulse)
