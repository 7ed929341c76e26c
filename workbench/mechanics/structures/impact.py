"""Impact driver: implicit time steps with a unilateral contact at one dof.

The midpoint step x1 = x0 + dt (v0 + v1) / 2 with energy-exact element forces, stresses
(1 - weight) old + weight new, and Newton's law of restitution in the velocity form of Moreau,
xi = gamma_1 + restitution gamma_0 = 0 for a closed contact, gamma the velocity of the gap. Other
schemes, on a column and on a frame, are those of the laboratory, see `impact.schemes`.

Sources: Heng 2017, chapter 3 (eqs 3.17-3.30; energy-momentum step 3.31-3.33); Moreau 1988.
"""

from collections.abc import Iterator

import numpy as np

from workbench.base.arrays import Array
from workbench.mechanics.impact import contact
from workbench.mechanics.impact.crushing import TRIES, approach_at, crush_line, force_at, obeys
from workbench.mechanics.impact.records import law_of
from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.time_steps import (
    TOLERANCE,
    PointMass,
    Pull,
    Spans,
    TimeStep,
    Trial,
    commit,
    march,
    solve_step,
)

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

    def _attempt(self, dt: float, closed: bool, approach: float) -> Trial:
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

    def _solve(self, dt: float, pull: Pull | None) -> Trial:
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

    def _commit(self, trial: Trial, dt: float, approach: float) -> TimeStep:
        """Commit a solved step and account for its energies."""
        assembly, striker, end = self.assembly, self.striker, trial.solution.x
        self._rate = (end - assembly.displacement) / dt
        step = commit(assembly, dt, end, trial.velocity, self.weight)
        self.striker, work = striker.moved(dt, trial.impulse)
        departure = self._along(trial.velocity) - self.striker.velocity
        loss = contact.contact_loss(trial.impulse, approach, departure)
        step = step._replace(external_work=step.external_work + work, contact_loss=loss)
        return step._replace(striker=self.striker, impulse=trial.impulse)
