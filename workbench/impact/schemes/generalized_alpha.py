"""Generalized-alpha (Chung and Hulbert 1993), its relatives Newmark and HHT-alpha, and contact.

    q1 = q0 + h v0 + h^2 ((1/2 - beta) a0 + beta a1),   v1 = v0 + h ((1 - gamma) a0 + gamma a1),
    (1 - am) M a1 + am M a0 + (1 - af) f1 + af f0 = W ((1 - af) l1 + af l0).

Classical contact is Signorini's law of the end position, 0 <= l1 perp g1 >= 0: no restitution, and
the velocity after an impact depends on where in the step it falls (`newmark`). With `impulses` the
smooth step sees no contact, and afterwards velocities jump by M^-1 W P of the law of restitution
and positions by half a step of that (after Chen, Acary, Virlez and Bruls 2013).
"""

import numpy as np

from workbench.compiled import register_jitable
from workbench.fields import Number
from workbench.impact.complementarity import complementary
from workbench.impact.laboratory import State, Step, Stepper, forecast, gaps_of, impulses_on
from workbench.impact.system import commit, forces

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
    leaves at v = (3 - 4 s) V, else, after a second step of contact, at (8 s - 5) V. Repeated
    impacts blow up, see `mean_energy_factor`. In lasting contact the same rule leaves the sign of
    the velocity open: contact forces alternate (chatter).
    """
    return alpha_step(0.0, 0.0, 0.25, 0.5, False)


def mean_energy_factor() -> float:
    """By how much one impact of `newmark` multiplies the energy, in the mean over the share s.

    A number between 0 and 9 that the grid draws: the integral of (3 - 4 s)^2 up to s = 2/3 and of
    (8 s - 5)^2 from there to 1.
    """
    return 91.0 / 27.0


def alpha_step(am: float, af: float, beta: float, gamma: float, impulses: bool) -> Stepper:
    """The step of a member of the family."""

    @register_jitable
    def step(system, law, state, h):
        M, W = system.mass, system.normals
        q0, v0, a0, l0, t = state.q, state.v, state.a, state.force, state.t + h
        f0, _ = forces(system, q0)
        Ma0, Wl0 = M @ a0, W @ l0
        a1, l1 = a0.copy(), np.zeros(l0.size)
        residual, count = np.inf, 0
        for turn in range(_ITERATIONS):
            q1 = q0 + h * v0 + h * h * ((0.5 - beta) * a0 + beta * a1)
            f1, K = forces(system, q1)
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
                back = (1.0 - af) * np.linalg.solve(A, W)
                l1, _ = complementary(h * h * beta * (W.T @ back), gaps_of(system, q1, t))
                a1 = a1 + back @ l1
        v1 = v0 + h * ((1.0 - gamma) * a0 + gamma * a1)
        P = h * l1
        if impulses:
            closed = forecast(system, state, h)
            v2, P, known = impulses_on(system, law, closed, M, v1, state, t)
            q1, v1, residual = q1 + 0.5 * h * (v2 - v1), v2, max(residual, known)
            l1 = np.zeros(l0.size)
        commit(system, q1)
        return Step(State(q1, v1, a1, l1, t), P, count, residual, np.nan)

    return step
