"""Schemes of one step: on velocities, on both constraints, and with contact at the end position.

Over a step M dv + f dt = W dP is integrated with a rule for f, and impulses P are what is left. No
instant is located, so an impact is misplaced by up to a step: first order. "Closed" is a gap that
is forecast so; xi = gamma_1 + e gamma_0, 0 <= P perp xi >= 0 there.

**Moreau and Jean (Jean 1999), the theta-method of the measure equation.**

    M (v1 - v0) + h (theta f1 + (1 - theta) f0) = W P,   q1 = q0 + h (theta v1 + (1 - theta) v0).

**The energy-conserving midpoint step (Heng 2017, eqs 3.31-3.33; Simo and Tarnow, Laursen).**

    q1 = q0 + h (v0 + v1) / 2,   M (v1 - v0) + h f_mean = W P,   f_mean . (q1 - q0) = U1 - U0.

Multiplied by (v0 + v1) / 2 = (q1 - q0) / h the step gives T1 + U1 - T0 - U0 = P (gamma_0 +
gamma_1) / 2: a free step keeps energy exactly whatever its length, and an impact of Newton's law
changes it by P (1 - e) gamma_0 / 2 <= 0, which for e = 1 is nothing.

**Moreau's explicit midpoint step as the thesis has it (Heng 2017, eqs 3.26-3.30; Moreau 1988).**

    q_m = q0 + h v0 / 2,   M (v1 - v0) + h f(q_m) = W P,   q1 = q_m + h v1 / 2,

closed where the gap at q_m is. Two corrections to print: (3.28) needs r = (W' M^-1 W)^-1, not its
inverse, and (3.30) adds v1 alone to q_m (with v1 + v0 a body at rest in velocity v would move by
3 h v / 2 in a step).

**Explicit central differences with contact impulses (Belytschko, Liu and Moran 2000, 6.2).**

    v+ = v- + h M^-1 (W P / h - f0),   q1 = q0 + h v+,

v- and v+ at the middles of the last and of this step, P from Newton's law between them. Velocities
at full steps are v+ + h a1 / 2, which makes it the velocity form of Verlet between impacts.

**Both constraints at once (Gear, Gupta and Leimkuhler 1985; Acary 2013; Heng 2017, 3.34-3.35).**
A second impulse Psi (kg m) moves bodies apart that velocities alone would let overlap:

    q1 = q0 + h (v0 + v1) / 2 + M^-1 W Psi,   0 <= Psi perp g1 >= 0,

in the midpoint step, whose forces see the moved place; the split form moves after it. The mass
weighting M^-1 W Psi keeps the centre of mass; (3.34) prints W Psi. Moving does work against the
forces: energy is not kept.

**Generalized-alpha (Chung and Hulbert 1993), its relatives Newmark and HHT-alpha, and contact.**

    q1 = q0 + h v0 + h^2 ((1/2 - beta) a0 + beta a1),   v1 = v0 + h ((1 - gamma) a0 + gamma a1),
    (1 - am) M a1 + am M a0 + (1 - af) f1 + af f0 = W ((1 - af) l1 + af l0).

Classical contact is Signorini's law of the end position, 0 <= l1 perp g1 >= 0: no restitution, and
the velocity after an impact depends on where in the step it falls (`newmark`). With `impulses` the
smooth step sees no contact, and afterwards velocities jump by M^-1 W P of the law of restitution
and positions by half a step of that (after Chen, Acary, Virlez and Bruls 2013).
"""

import numpy as np

from workbench.arrays import Array, Flags
from workbench.fields import Number
from workbench.impact.complementarity import complementary
from workbench.impact.laboratory import (
    REACH,
    Law,
    State,
    Step,
    Stepper,
    forecast,
    gaps_of,
    implicit,
    impulses_on,
)
from workbench.impact.pace import SLACK
from workbench.impact.system import System

_OVERLAP = 1e-13  # m
_TURNS = 30
_POLISH = 10
_EPS = 1e-15
_ITERATIONS = 40


def moreau_jean(theta: float = 0.5, reach: float = 1.0) -> Stepper:
    """The step; `theta` 1/2 to 1, `reach` the share of a step that gaps are forecast for."""
    theta = Number(0.5, 1.0).check("moreau-jean.theta", theta)
    return _implicit_step(theta, REACH.check("moreau-jean.reach", reach))


def energy_midpoint(reach: float = 0.5) -> Stepper:
    """The step; `reach`, the share of a step that gaps are forecast for (thesis: 1/2)."""
    return _implicit_step(0.0, REACH.check("midpoint.reach", reach))


def _implicit_step(theta: float, reach: float) -> Stepper:
    """The step of the theta-method, or (0) that of the energy-conserving midpoint."""

    def step(system: System, law: Law, state: State, h: float) -> Step:
        closed = forecast(system, state, reach * h)
        shift = np.zeros(state.q.size)
        q, v, P, count, residual = implicit(system, law, state, h, theta, shift, closed)
        system.commit(q)
        return Step(State(q, v, state.a, P / h, state.t + h), P, count, residual, np.nan)

    return step


def moreau_midpoint(at_end: bool = True) -> Stepper:
    """The step; stable up to h = 2 / omega. `at_end`: plastic flow at the end of a step too."""

    def step(system: System, law: Law, state: State, h: float) -> Step:
        middle = state.q + 0.5 * h * state.v
        f, _ = system.forces(middle)
        closed = gaps_of(system, middle, state.t + 0.5 * h) <= SLACK
        system.commit(middle)
        free = state.v - h * np.linalg.solve(system.mass, f)
        t = state.t + h
        v, P, residual = impulses_on(system, law, closed, system.mass, free, state, t)
        q = middle + 0.5 * h * v
        if at_end:
            system.commit(q)
        return Step(State(q, v, state.a, P / h, t), P, 1, residual, np.nan)

    return step


def central_differences() -> Stepper:
    """The step; stable up to h = 2 / omega."""

    def step(system: System, law: Law, state: State, h: float) -> Step:
        before = State(state.q, state.v - 0.5 * h * state.a, state.a, state.force, state.t)
        closed = forecast(system, before, h)
        free = before.v + h * state.a
        t = state.t + h
        half, P, residual = impulses_on(system, law, closed, system.mass, free, before, t)
        q = state.q + h * half
        f, _ = system.forces(q)
        system.commit(q)
        a = np.asarray(-np.linalg.solve(system.mass, f), dtype=float)
        return Step(State(q, half + 0.5 * h * a, a, P / h, t), P, 1, residual, np.nan)

    return step


def move_apart(system: System, gaps: Array, moved: Array, among: Flags) -> tuple[Array, float]:
    """Psi (m,) that closes the overlaps `among` contacts, and residual; `moved` is in `gaps`."""
    psi, on = np.zeros(among.size), np.flatnonzero(among)
    if on.size == 0:
        return psi, 0.0
    W = np.ascontiguousarray(system.normals[:, on])
    G = W.T @ np.linalg.solve(system.mass, W)
    bare = gaps[on] - G @ moved[on]
    closing, residual = complementary(G, bare)
    psi[on] = _exact(G, bare, closing)
    return psi, residual


def _exact(G: Array, bare: Array, psi: Array) -> Array:
    """Solve for the contacts that `psi` has found, each to the round-off of its own gap.

    The complementarity problem is solved to a share of its largest gap: metres where a wall is far.
    """
    for _ in range(_POLISH):
        gap = bare + G @ psi
        on = np.flatnonzero((psi > 0.0) | (gap < 0.0))
        if on.size == 0 or np.abs(gap[on]).max() <= _OVERLAP:
            break
        rows = np.ascontiguousarray(G[on][:, on])
        psi[on] = np.maximum(psi[on] - np.linalg.lstsq(rows, gap[on], _EPS)[0], 0.0)
    return psi


def gear_gupta_leimkuhler(
    reach: float = 1.0, split: bool = False, all_gaps: bool = True
) -> Stepper:
    """The step, simultaneous or `split`; `reach` as in `energy_midpoint`.

    Without `all_gaps` the split form moves only contacts that push, as `four-dof` does: an overlap
    that ends a step without impulse stays for that step.
    """
    reach = REACH.check("ggl.reach", reach)

    def step(system: System, law: Law, state: State, h: float) -> Step:
        closed = forecast(system, state, reach * h)
        t, evaluations, psi, shift = state.t + h, 0, np.zeros(closed.size), np.zeros(state.q.size)
        for _ in range(_TURNS):
            q, v, P, count, residual = implicit(system, law, state, h, 0.0, shift, closed)
            evaluations += count
            if split:
                system.commit(q)
                closed = (P > 0.0) | all_gaps
            gaps, change = gaps_of(system, q, t), np.zeros(q.size)
            if (closed & ((gaps < -_OVERLAP) | (psi > 0.0))).any():
                new, left = move_apart(system, gaps, psi, closed)
                change[:] = np.linalg.solve(system.mass, system.normals @ (new - psi))
                psi, shift, residual = new, shift + change, max(residual, left)
                gaps = gaps_of(system, q + change, t)
            if split:
                q = q + change
                break
            # a contact may meet that the forecast has not seen
            met = (gaps < -_OVERLAP) & ~closed
            if np.abs(change).max() <= _OVERLAP and not met.any():
                break
            closed |= met
        system.commit(q)
        return Step(State(q, v, state.a, P / h, t), P, evaluations, residual, np.nan)

    return step


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


def alpha_step(am: float, af: float, beta: float, gamma: float, impulses: bool) -> Stepper:
    """The step of a member of the family."""

    def step(system: System, law: Law, state: State, h: float) -> Step:
        M, W = system.mass, system.normals
        q0, v0, a0, l0, t = state.q, state.v, state.a, state.force, state.t + h
        f0, _ = system.forces(q0)
        Ma0, Wl0 = M @ a0, W @ l0
        a1, l1 = a0.copy(), np.zeros(l0.size)
        residual, count = np.inf, 0
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
        system.commit(q1)
        return Step(State(q1, v1, a1, l1, t), P, count, residual, np.nan)

    return step
