"""The laboratory: states and contact of its schemes, and runs with every condition checked.

Schemes of several contacts for comparison; models march with `integrator`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array, Flags, Indices
from workbench.base.errors import InputError, SolverError
from workbench.base.fields import Number
from workbench.extras.laboratory.complementarity import Restitution, percussions
from workbench.extras.laboratory.system import PLACE, SPEED, System, numbers
from workbench.mechanics.impact.pace import SLACK

CONTRADICTION = "no impulses keep all bodies apart, the contacts contradict each other"
REACH = Number(0.0, 1.0)  # share of a step that gaps are forecast for
_ITERATIONS = 40
_TOLERANCE = 1e-14


class SystemState(NamedTuple):
    """Unknowns, velocities, accelerations (n,), contact forces (m,) in N, time in s."""

    q: Array
    v: Array
    a: Array
    force: Array
    t: float


class RestitutionLaw(NamedTuple):
    """Restitution as the steps take it: coefficients (m,) and whether it is Poisson's.

    `turns`, at most, of the fixed point that finds impulses (0: they are found by pivoting).
    """

    e: Array
    poisson: bool
    turns: int = 0


class SystemStep(NamedTuple):
    """A step taken: `state` at its end, `impulses` (m,) in N s, residual evaluations, residual.

    `loss` is the energy (J) lost in its contacts, NaN for minus the work of the impulses on the
    mean gap velocities; `stored` that which the contacts hold at its end.
    """

    state: SystemState
    impulses: Array
    evaluations: int
    residual: float
    loss: float
    stored: float = 0.0


Stepper = Callable[[Any, RestitutionLaw, SystemState, float], SystemStep]


def gaps_of(system: System, q: Array, t: float) -> Array:
    """Gaps (m,) in m."""
    return np.asarray(system.normals.T @ q + system.surface(t)[0])


def rates_of(system: System, v: Array, t: float) -> Array:
    """Gap velocities (m,) in m/s."""
    return np.asarray(system.normals.T @ v + system.surface(t)[1])


def forecast(system: System, state: SystemState, reach: float, slack: float = SLACK) -> Flags:
    """Contacts whose gap, forecast for `reach` in s ahead, is closed: not above `slack` in m."""
    closing = np.minimum(rates_of(system, state.v, state.t), 0.0)
    return np.asarray(gaps_of(system, state.q, state.t) + reach * closing <= slack)


def impulses_on(
    system: System,
    law: RestitutionLaw,
    closed: Flags,
    matrix: Array,
    free: Array,
    state: SystemState,
    t: float,
) -> tuple[Array, Array, float]:
    """Velocities after the impulses of the closed contacts, and those; `free` is without them.

    `matrix` stands for the mass; an impulse P changes the velocities by matrix^-1 W P.
    """
    P = np.zeros(closed.size)
    on: Indices = np.flatnonzero(closed)
    if on.size == 0:
        return free, P, 0.0
    W = np.ascontiguousarray(system.normals[:, on])
    back = np.linalg.solve(matrix, W)
    start = rates_of(system, state.v, state.t)[on]
    gamma = W.T @ free + system.surface(t)[1][on]
    P[on], residual = percussions(W.T @ back, gamma, start, law.e[on], law.poisson, law.turns)
    return free + back @ P[on], P, residual


def implicit(
    system: System,
    law: RestitutionLaw,
    state: SystemState,
    h: float,
    theta: float,
    shift: Array,
    closed: Flags,
) -> tuple[Array, Array, Array, int, float]:
    """Velocities of M (v1 - v0) + h f = W P by Newton's method with the contact law inside.

    With 0 < theta <= 1 the force is theta f1 + (1 - theta) f0 at q1 = q0 + h (theta v1 +
    (1 - theta) v0) + shift; with theta = 0 it is the energy-consistent mean force over
    q1 = q0 + h (v0 + v1) / 2 + shift. Returns q1, v1, impulses, evaluations, residual.
    """
    M, q0, v0 = system.mass, state.q, state.v
    mean = theta == 0.0
    share = 0.5 if mean else theta
    f0 = q0 if mean else system.forces(q0)[0]  # of the theta-rule alone
    v1, P, unsolved = v0.copy(), np.zeros(closed.size), 0.0
    before, push, touching = np.abs(M @ v0), np.zeros(q0.size), closed.any()
    residual, count = np.inf, 1
    for turn in range(_ITERATIONS):
        q1 = q0 + h * (share * v1 + (1.0 - share) * v0) + shift
        if mean:
            f, K = system.mean_forces(q0, q1)
            A = M + 0.5 * h * h * K
        else:
            f1, K = system.forces(q1)
            f = theta * f1 + (1.0 - theta) * f0
            A = M + (h * theta) ** 2 * K
        count += 1
        r = h * f
        if turn > 0:
            size = before + np.abs(M @ v1) + np.abs(r) + np.abs(push)
            r += M @ (v1 - v0)
            last, residual = residual, np.abs(r - push).max() / max(size.max(), 1e-300)
            if residual <= _TOLERANCE or (residual <= 1e-11 and residual >= last):
                break
        v1 = v1 - np.linalg.solve(A, r)
        if touching:
            v1, P, unsolved = impulses_on(system, law, closed, A, v1, state, state.t + h)
            push = system.normals @ P
    q1 = q0 + h * (share * v1 + (1.0 - share) * v0) + shift
    return q1, v1, P, count - (1 if mean else 0), max(float(residual), unsolved)


_MOST_STEPS = 20_000_000
_TIME = Number(0.0, 1e9, "s", low_included=False)
_SOLVED = 1e-9  # scaled residual of a step


class Conditions(NamedTuple):
    """Conditions of the contact law, as the largest violation in a run: all are zero at best.

    `penetration` in m, `pull` in N s, `complementarity` (impulses across open gaps, over the
    largest impulse times the largest approach), `created` energy in the contacts in J.
    """

    penetration: float
    pull: float
    complementarity: float
    created: float


@dataclass(frozen=True)
class SystemRecord:
    """A record at times `t` (k,): `q`, `v` (k, n), `gaps`, `rates`, `impulses` (k, m).

    The impulses are those of the step that ends there. `energies` (k, 3) in J: kinetic, stored
    with loads, dissipated; `losses` (k,) as the integrator tells them. `evaluations` of the forces,
    and `seconds` of the whole run.
    """

    t: Array
    q: Array
    v: Array
    gaps: Array
    rates: Array
    impulses: Array
    energies: Array
    losses: Array
    evaluations: int
    seconds: float

    @cached_property
    def contact_loss(self) -> Array:
        """Energy (J) lost in contact in each step (k - 1,)."""
        mean = 0.5 * (self.rates[1:] + self.rates[:-1])
        work = -np.sum(self.impulses[1:] * mean, axis=1)
        return np.where(np.isnan(self.losses[1:]), work, self.losses[1:])

    @cached_property
    def conditions(self) -> Conditions:
        """The conditions of contact over all steps."""
        if not self.gaps.shape[1]:
            return Conditions(0.0, 0.0, 0.0, 0.0)
        P = self.impulses
        apart = np.minimum(self.gaps[1:], self.gaps[:-1]).clip(0.0)
        reach = np.abs(self.rates).max() * (self.t[1] - self.t[0])
        size = max(float(np.abs(P).max() * reach), 1e-300)
        return Conditions(
            0.0 - min(float(self.gaps.min()), 0.0),
            0.0 - min(float(P.min()), 0.0),
            float(np.abs(P[1:] * np.maximum(apart - reach, 0.0)).max() / size),
            0.0 - min(float(self.contact_loss.min()), 0.0),
        )

    @property
    def impacts(self) -> int:
        """How often a contact began to push."""
        on = self.impulses > 1e-9 * max(float(self.impulses.max(initial=0.0)), 1e-300)
        return int(np.sum(on[1:] & ~on[:-1]))

    @property
    def chatter(self) -> float:
        """Half the total variation of the impulses over their sum; 1 if each second step is off."""
        total = float(np.abs(self.impulses).sum())
        return float(np.abs(np.diff(self.impulses, axis=0)).sum() / (2.0 * total)) if total else 0.0

    @property
    def drift(self) -> float:
        """Largest change of the sum of energies over the largest energy moved (kinetic)."""
        total = self.energies.sum(axis=1)
        return float(np.abs(total - total[0]).max() / max(self.energies[:, 0].max(), 1e-300))


def run(
    stepper: Stepper,
    system: System,
    law: Restitution,
    start: tuple[Sequence[float] | Array, Sequence[float] | Array],
    duration: float,
    h: float,
) -> SystemRecord:
    """Follow a system with one integrator.

    Arguments: `system`, used up by the run where it is plastic; `law`; `start`, q and v (n,);
    `duration` and step `h` in s, which is cut so that whole steps fill the duration.
    Raises `InputError` and `SolverError`.
    """
    for name, value in (("duration", duration), ("time_step", h)):
        _TIME.check(f"problem.{name}", value)
    if duration / h > _MOST_STEPS:
        reason = f"makes {duration / h:.3g} steps, at most {_MOST_STEPS}"
        raise InputError("problem.time_step", h, reason, "take a longer one")
    count = ceil(duration / h - 1e-9)
    h = duration / count
    mass = np.asarray(system.mass)
    if not np.isfinite(mass).all() or np.linalg.eigvalsh(mass).min() <= 0.0:
        raise InputError("problem.masses", None, "must make a positive definite mass matrix")
    q, v = _begin(system, start)
    m = system.normals.shape[1]
    given = RestitutionLaw(law.each(m), law.law == "poisson")
    a = np.asarray(-np.linalg.solve(mass, system.forces(q)[0]), dtype=float)
    system.commit(q)
    states = [SystemState(q, v, a, np.zeros(m), 0.0)]
    impulses, energies = [np.zeros(m)], [(*system.energy(), 0.0)]
    evaluations, begin = 0, perf_counter()
    for n in range(1, count + 1):
        step = stepper(system, given, states[-1], h)
        evaluations += step.evaluations
        if not step.residual <= _SOLVED or not np.isfinite(step.state.q).all():
            tried = "Newton's method with the contact law inside; reduce the step"
            if step.residual == np.inf:  # of the contact problem: a shorter step has the same
                tried = f"the contact law: {CONTRADICTION} (squeezed bodies); change the contacts"
            raise SolverError(f"time {(n - 1) * h:.6g} s (step of {h:.3g} s)", step.residual, tried)
        stored, dissipated = system.energy()
        states.append(step.state)
        impulses.append(step.impulses)
        energies.append((stored + step.stored, dissipated, step.loss))
    seconds = perf_counter() - begin
    t = np.linspace(0.0, duration, count + 1)
    q, v = (np.array([state[i] for state in states]) for i in range(2))
    gaps = np.array([gaps_of(system, *at) for at in zip(q, t, strict=True)])
    rates = np.array([rates_of(system, *at) for at in zip(v, t, strict=True)])
    stored_dissipated, losses = np.split(np.array(energies), [2], axis=1)
    kinetic = 0.5 * np.einsum("ki,ij,kj->k", v, mass, v)
    moved = np.column_stack([kinetic, stored_dissipated])
    return SystemRecord(
        t, q, v, gaps, rates, np.array(impulses), moved, losses[:, 0], evaluations, seconds
    )


def _begin(system: System, start: Any) -> tuple[Array, Array]:
    """Places and velocities of the start. Raises `InputError`."""
    if not isinstance(start, tuple | list) or len(start) != 2:
        raise InputError("problem.start", start, "must be (places in m, velocities in m/s)")
    n = len(system.mass)
    q = numbers("start.q", start[0], PLACE, n, "one per unknown")
    gaps = gaps_of(system, q, 0.0)
    if (gaps < -SLACK).any():
        worst = int(np.argmin(gaps))
        advice = "move the bodies apart"
        reason = f"must leave no gap below 0 m, contact {worst} has {gaps[worst]:.3g} m"
        raise InputError("problem.start.q", start[0], reason, advice)
    return q, numbers("start.v", start[1], SPEED, n, "one per unknown")
