"""Newmark's rule and its relatives with contact at the end of the step.

**Generalized-alpha (Chung and Hulbert 1993), its relatives Newmark and HHT-alpha, and contact.**

    q1 = q0 + h v0 + h^2 ((1/2 - beta) a0 + beta a1),   v1 = v0 + h ((1 - gamma) a0 + gamma a1),
    (1 - am) M a1 + am M a0 + (1 - af) f1 + af f0 = W ((1 - af) l1 + af l0).

Classical contact is Signorini's law of the end position, 0 <= l1 perp g1 >= 0: no restitution, and
the velocity after an impact depends on where in the step it falls (`newmark`). With `impulses` the
smooth step sees no contact, and afterwards velocities jump by M^-1 W P of the law of restitution
and positions by half a step of that (after Chen, Acary, Virlez and Bruls 2013).

**Newmark's rule whose contact keeps energy (Zolghadr Jahromi and Izzuddin 2013; Heng 2017, 3.2).**
Reconstructions from the principle that is told of each, not verified in print. `rates`: contact
asks for gamma_1 = 0 in place of g1 = 0. Its force, W'M^-1 W l1 = -2 gamma_0 / h, acts on in the
next step, where gamma = 0 would need -l1, a pull: the contact opens and the body leaves with
-gamma_0. `energy_penalty`: contact is a spring, U = k min(g, 0)^2 / 2, whose mean force in the
step, -(U1 - U0) / (g1 - g0), does the work that it stores. Both know elastic impacts alone.
"""

from typing import Any

import numpy as np

from workbench.base.arrays import Array
from workbench.base.fields import Number
from workbench.extras.laboratory.complementarity import complementary
from workbench.extras.laboratory.system import System
from workbench.extras.laboratory.systems import (
    RestitutionLaw,
    Stepper,
    SystemState,
    SystemStep,
    forecast,
    gaps_of,
    implicit,
    impulses_on,
    rates_of,
)

_ITERATIONS = 40


def generalized_alpha(radius: float = 0.8, impulses: bool = False) -> Stepper:
    """The step with a spectral radius at infinity of `radius`, 0 to 1."""
    radius = Number(0.0, 1.0).check("generalized-alpha.radius", radius)
    am, af = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
    return alpha_step(am, af, 0.25 * (1.0 - am + af) ** 2, 0.5 - am + af, impulses)


def hht_alpha(alpha: float = 0.1) -> Stepper:
    """The step of Hilber, Hughes and Taylor (1977), contact at the end; `alpha` 0 to 1/3.

    Forces are taken at t1 - alpha h, with gamma = 1/2 + alpha and beta = (1 + alpha)^2 / 4: second
    order, and the highest frequencies damped by (1 - alpha) / (1 + alpha) a step. Damping limits
    what Newmark's contact puts into the grid, but the velocity after an impact is the grid's still.
    """
    alpha = Number(0.0, 1.0 / 3.0).check("hht-alpha.alpha", alpha)
    return alpha_step(0.0, alpha, 0.25 * (1.0 + alpha) ** 2, 0.5 + alpha, False)


def newmark() -> Stepper:
    """The step of Newmark's average acceleration (1959), contact at the end.

    beta = 1/4, gamma = 1/2 make q1 = q0 + h (v0 + v1) / 2. Where a free body at velocity -V meets a
    rigid wall a share s of a step ahead, g1 = 0 asks for v1 = (1 - 2 s) V, whatever restitution,
    with an acceleration 4 (1 - s) V / h that pushes on in the next step. For s < 2/3 the body
    leaves at v = (3 - 4 s) V, else, after a second step of contact, at (8 s - 5) V. In the
    mean over s an impact multiplies the energy by 91/27: repeated ones blow up. In lasting contact
    the same rule leaves the sign of the velocity open: contact forces alternate (chatter).
    """
    return alpha_step(0.0, 0.0, 0.25, 0.5, False)


def newmark_rates() -> Stepper:
    """The step of Newmark's average acceleration with contact on the velocity at the end."""
    return alpha_step(0.0, 0.0, 0.25, 0.5, False, rates=True)


def alpha_step(
    am: float, af: float, beta: float, gamma: float, impulses: bool, rates: bool = False
) -> Stepper:
    """The step of a member of the family."""

    def step(system: System, law: RestitutionLaw, state: SystemState, h: float) -> SystemStep:
        M, W = system.mass, system.normals
        q0, v0, a0, l0, t = state.q, state.v, state.a, state.force, state.t + h
        f0, _ = system.forces(q0)
        Ma0, Wl0 = M @ a0, W @ l0
        a1, l1 = a0.copy(), np.zeros(l0.size)
        residual, count, loss, held = np.inf, 0, np.nan, 0.0
        on = forecast(system, state, h) if rates else np.ones(l0.size, dtype=bool)
        for turn in range(_ITERATIONS):
            q1 = q0 + h * v0 + h * h * ((0.5 - beta) * a0 + beta * a1)
            f1, K = system.forces(q1)
            count += 1
            Ma1, push = M @ a1, (1.0 - af) * (W @ l1) + af * Wl0
            r = (1.0 - am) * Ma1 + am * Ma0 + (1.0 - af) * f1 + af * f0
            size = np.abs(Ma1) + np.abs(Ma0) + np.abs(f1) + np.abs(f0) + np.abs(push)
            before, residual = residual, np.abs(r - push).max() / max(size.max(), 1e-300)
            if turn > 0 and (residual <= 1e-14 or (residual <= 1e-11 and residual >= before)):
                break
            A = (1.0 - am) * M + (1.0 - af) * beta * h * h * K
            a1 = a1 - np.linalg.solve(A, r - af * Wl0)
            if not impulses:
                q1 = q0 + h * v0 + h * h * ((0.5 - beta) * a0 + beta * a1)
                back = (1.0 - af) * np.linalg.solve(A, W[:, on])
                v1 = v0 + h * ((1.0 - gamma) * a0 + gamma * a1)
                lack = (rates_of(system, v1, t) if rates else gaps_of(system, q1, t))[on]
                per_force = h * gamma if rates else h * h * beta
                l1[on], _ = complementary(per_force * (W[:, on].T @ back), lack)
                a1 = a1 + back @ l1[on]
        v1 = v0 + h * ((1.0 - gamma) * a0 + gamma * a1)
        P = h * l1
        if impulses:
            closed = forecast(system, state, h)
            v2, P, unsolved = impulses_on(system, law, closed, M, v1, state, t)
            q1, v1, residual = q1 + 0.5 * h * (v2 - v1), v2, max(residual, unsolved)
            l1 = np.zeros(l0.size)
        if rates:  # kinetic energy that the force will give back in the next step
            reach = W.T @ np.linalg.solve(M, W)
            mean = 0.5 * (rates_of(system, v0, state.t) + rates_of(system, v1, t))
            before, held = (h * h / 8.0 * float(each @ reach @ each) for each in (l0, l1))
            loss = before - held - 0.5 * h * float((l0 + l1) @ mean)
        system.commit(q1)
        return SystemStep(SystemState(q1, v1, a1, l1, t), P, count, residual, loss, held)

    return step


class _Sprung:
    """A system in a step of the trapezoidal rule from `state` on over `h` (s).

    Its contacts are springs of `stiffness` (m,) in N/m.
    """

    def __init__(self, system: System, stiffness: Array, state: SystemState, h: float) -> None:
        self.system, self.stiffness, self.t = system, stiffness, state.t + h
        self.mass, self.normals = system.mass, np.zeros((state.q.size, 0))
        self.force, self.gaps = system.forces(state.q)[0], gaps_of(system, state.q, state.t)

    def push(self, q: Array) -> tuple[Array, Array]:
        """Mean forces (m,) of the springs on the way to `q`, and how they fall with the gaps."""
        gaps = gaps_of(self.system, q, self.t)
        x0, x1 = np.minimum(self.gaps, 0.0), np.minimum(gaps, 0.0)
        mean, slope = -0.5 * self.stiffness * (x0 + x1), 0.5 * self.stiffness * (gaps < 0.0)
        crossing = (self.gaps < 0.0) != (gaps < 0.0)
        moved = np.where(crossing, gaps - self.gaps, 1.0)
        mean = np.where(crossing, mean * (x1 - x0) / moved, mean)
        return mean, np.where(crossing, (mean + self.stiffness * x1) / moved, slope)

    def mean_forces(self, q0: Array, q1: Array) -> tuple[Array, Array]:
        """Mean forces of the trapezoidal rule as in `System`, less the springs."""
        (f1, K), (push, slope), W = self.system.forces(q1), self.push(q1), self.system.normals
        return 0.5 * (self.force + f1) - W @ push, 0.5 * K + W * slope @ W.T


def energy_penalty(stiffness: float = 4.0) -> Stepper:
    """The step; springs of `stiffness` / (h^2 w'M^-1 w): an impact takes pi over its root steps."""
    stiffness = Number(1e-6, 1e6).check("newmark-penalty.stiffness", stiffness)

    def step(system: System, law: RestitutionLaw, state: SystemState, h: float) -> SystemStep:
        t, none, W = state.t + h, law._replace(e=np.zeros(0)), system.normals
        k = stiffness / (h * h * np.sum(W * np.linalg.solve(system.mass, W), axis=0))
        sprung: Any = _Sprung(system, k, state, h)
        shift, closed = np.zeros(state.q.size), np.zeros(0, dtype=bool)
        q, v, _, count, residual = implicit(sprung, none, state, h, 0.0, shift, closed)
        system.commit(q)
        held = 0.5 * float(k @ np.minimum(gaps_of(system, q, t), 0.0) ** 2)
        push = sprung.push(q)[0]
        after = SystemState(q, v, state.a, push, t)
        return SystemStep(after, h * push, count + 1, residual, 0.0, held)

    return step
