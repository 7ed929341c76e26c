"""Schemes of one step, on velocities and on both constraints.

Over a step M dv + f dt = W dP is integrated with a rule for f, and impulses P are what is left. No
instant is located, so an impact is misplaced by up to a step: first order. "Closed" is a gap that
is forecast so; xi = gamma_1 + e gamma_0, 0 <= P perp xi >= 0 there.

**Moreau and Jean (Jean 1999), the theta-method of the measure equation.**

    M (v1 - v0) + h (theta f1 + (1 - theta) f0) = W P,   q1 = q0 + h (theta v1 + (1 - theta) v0).

**The energy-conserving midpoint step (Heng 2017, eqs 3.31-3.33; Simo and Tarnow, Laursen).**

    q1 = q0 + h (v0 + v1) / 2,   M (v1 - v0) + h f_mean = W P,   f_mean . (q1 - q0) = U1 - U0.

Multiplied by (v0 + v1) / 2 = (q1 - q0) / h the step gives T1 + U1 - T0 - U0 = P (gamma_0 + gamma_1)
/ 2: a free step keeps energy exactly, an impact changes it by P (1 - e) gamma_0 / 2 <= 0.

**Moreau's explicit midpoint step as the thesis has it (Heng 2017, eqs 3.26-3.30; Moreau 1988).**

    q_m = q0 + h v0 / 2,   M (v1 - v0) + h f(q_m) = W P,   q1 = q_m + h v1 / 2,

closed where the gap at q_m is. Two corrections to print: (3.28) needs r = (W' M^-1 W)^-1, not its
inverse, and (3.30) adds v1 alone to q_m (v1 + v0 would move a free body by 3 h v / 2 in a step).

**Explicit central differences with contact impulses (Belytschko, Liu and Moran 2000, 6.2).**

    v+ = v- + h M^-1 (W P / h - f0),   q1 = q0 + h v+,

v- and v+ at the middles of steps, P from Newton's law between them; v+ + h a1 / 2 at full steps.

**Both constraints at once (Gear, Gupta and Leimkuhler 1985; Acary 2013; Heng 2017, 3.34-3.35).**
A second impulse Psi (kg m) moves bodies apart that velocities alone would let overlap:

    q1 = q0 + h (v0 + v1) / 2 + M^-1 W Psi,   0 <= Psi perp g1 >= 0,

in the midpoint step, whose forces see the moved place; the split form moves after it. The mass
weighting M^-1 W Psi keeps the centre of mass; (3.34) prints W Psi. Moving does work against the
forces: energy is not kept. Acary constrains whatever contact would end overlapped; Studer's first
form, `late` false, those alone that the forecast finds overlapped (reconstruction, not verified in
print: Heng 2017 says only that it oscillates), not a gap just closed: a body at rest falls for a
step, then is caught.
"""

import numpy as np

from workbench.base.arrays import Array, Flags
from workbench.base.fields import Number
from workbench.extras.laboratory.complementarity import complementary
from workbench.extras.laboratory.system import System
from workbench.extras.laboratory.systems import (
    REACH,
    RestitutionLaw,
    Stepper,
    SystemState,
    SystemStep,
    forecast,
    gaps_of,
    implicit,
    impulses_on,
)
from workbench.mechanics.impact.pace import SLACK

_OVERLAP = 1e-13  # m
_TURNS = 30
_POLISH = 10
_EPS = 1e-15


def moreau_jean(theta: float = 0.5, reach: float = 1.0) -> Stepper:
    """The step; `theta` 1/2 to 1, `reach` the share of a step that gaps are forecast for."""
    theta = Number(0.5, 1.0).check("moreau-jean.theta", theta)
    return _implicit_step(theta, REACH.check("moreau-jean.reach", reach))


def energy_midpoint(reach: float = 0.5, turns: int = 0) -> Stepper:
    """The step; `reach`, the share of a step that gaps are forecast for (thesis: 1/2).

    Impulses by pivoting, or in at most so many `turns` of the fixed point (Heng 2017, eq. 3.28).
    """
    return _implicit_step(0.0, REACH.check("midpoint.reach", reach), turns)


def _implicit_step(theta: float, reach: float, turns: int = 0) -> Stepper:
    """The step of the theta-method, or (0) that of the energy-conserving midpoint."""

    def step(system: System, law: RestitutionLaw, state: SystemState, h: float) -> SystemStep:
        law = law._replace(turns=turns)
        closed = forecast(system, state, reach * h)
        shift = np.zeros(state.q.size)
        q, v, P, count, residual = implicit(system, law, state, h, theta, shift, closed)
        system.commit(q)
        return SystemStep(
            SystemState(q, v, state.a, P / h, state.t + h), P, count, residual, np.nan
        )

    return step


def moreau_midpoint() -> Stepper:
    """The step; stable up to h = 2 / omega. Plastic flow in the middle and at the end of a step."""

    def step(system: System, law: RestitutionLaw, state: SystemState, h: float) -> SystemStep:
        middle = state.q + 0.5 * h * state.v
        f, _ = system.forces(middle)
        closed = gaps_of(system, middle, state.t + 0.5 * h) <= SLACK
        system.commit(middle)
        free = state.v - h * np.linalg.solve(system.mass, f)
        t = state.t + h
        v, P, residual = impulses_on(system, law, closed, system.mass, free, state, t)
        q = middle + 0.5 * h * v
        system.commit(q)
        return SystemStep(SystemState(q, v, state.a, P / h, t), P, 1, residual, np.nan)

    return step


def central_differences() -> Stepper:
    """The step; stable up to h = 2 / omega."""

    def step(system: System, law: RestitutionLaw, state: SystemState, h: float) -> SystemStep:
        before = SystemState(state.q, state.v - 0.5 * h * state.a, state.a, state.force, state.t)
        closed = forecast(system, before, h)
        free = before.v + h * state.a
        t = state.t + h
        half, P, residual = impulses_on(system, law, closed, system.mass, free, before, t)
        q = state.q + h * half
        f, _ = system.forces(q)
        system.commit(q)
        a = np.asarray(-np.linalg.solve(system.mass, f), dtype=float)
        return SystemStep(SystemState(q, half + 0.5 * h * a, a, P / h, t), P, 1, residual, np.nan)

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


def gear_gupta_leimkuhler(reach: float = 1.0, split: bool = False, late: bool = True) -> Stepper:
    """The step, simultaneous or `split`; `reach` as in `energy_midpoint`.

    Without `late` no contact joins that the forecast does not find overlapped (Studer).
    """
    reach = REACH.check("ggl.reach", reach)

    def step(system: System, law: RestitutionLaw, state: SystemState, h: float) -> SystemStep:
        closed = forecast(system, state, reach * h, SLACK if late else -_OVERLAP)
        t, evaluations, psi, shift = state.t + h, 0, np.zeros(closed.size), np.zeros(state.q.size)
        for _ in range(_TURNS):
            q, v, P, count, residual = implicit(system, law, state, h, 0.0, shift, closed)
            evaluations += count
            if split:
                system.commit(q)
                closed = np.ones(P.size, bool)
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
            contact_time = (gaps < -_OVERLAP) & ~closed & late
            if np.abs(change).max() <= _OVERLAP and not contact_time.any():
                break
            closed |= contact_time
        system.commit(q)
        return SystemStep(SystemState(q, v, state.a, P / h, t), P, evaluations, residual, np.nan)

    return step
