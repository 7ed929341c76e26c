"""Schemes of one step that hold contact on velocities: implicit, energy-conserving, explicit.

**Time stepping of Moreau and Jean (Jean 1999), the theta-method of the measure equation.**

Over a step M dv + f dt = W dP is integrated with a theta-rule, and impulses are what is left:

    M (v1 - v0) + h (theta f1 + (1 - theta) f0) = W P,   q1 = q0 + h (theta v1 + (1 - theta) v0),
    0 <= P perp gamma_1 + e gamma_0 >= 0   where the gap forecast for the end of the step is closed.

No instant is located, so an impact is misplaced by up to a step: first order, and gaps may end
closed beyond by a step times the velocity of approach.

**The energy-conserving midpoint step (Heng 2017, eqs 3.31-3.33; Simo and Tarnow, Laursen).**

    q1 = q0 + h (v0 + v1) / 2,   M (v1 - v0) + h f_mean = W P,   f_mean . (q1 - q0) = U1 - U0.

Multiplied by (v0 + v1) / 2 = (q1 - q0) / h the step gives T1 + U1 - T0 - U0 = P (gamma_0 +
gamma_1) / 2: a free step keeps energy exactly whatever its length, and an impact of Newton's law
changes it by P (1 - e) gamma_0 / 2 <= 0, which for e = 1 is nothing.

**Moreau's explicit midpoint step as the thesis has it (Heng 2017, eqs 3.26-3.30; Moreau 1988).**

    q_m = q0 + h v0 / 2,   M (v1 - v0) + h f(q_m) = W P,   q1 = q_m + h v1 / 2,

with 0 <= P perp gamma_1 + e gamma_0 >= 0 where the gap at q_m is closed. Two corrections to print:
(3.28) needs r = (W' M^-1 W)^-1, not its inverse, and (3.30) adds v1 alone to q_m (with v1 + v0 a
body at rest in velocity v would move by 3 h v / 2 in a step).

**Explicit central differences with contact impulses (Belytschko, Liu and Moran 2000, 6.2).**

    v+ = v- + h M^-1 (W P / h - f0),   q1 = q0 + h v+,

v- and v+ at the middles of the last and of this step, P from Newton's law between them where the
gap forecast with v- is closed. Velocities at full steps are v+ + h a1 / 2, which makes it the
velocity form of Verlet between impacts.
"""

import numpy as np

from workbench.compiled import register_jitable
from workbench.fields import Number
from workbench.impact.laboratory import (
    REACH,
    State,
    Step,
    Stepper,
    forecast,
    gaps_of,
    implicit,
    impulses_on,
)
from workbench.impact.pace import SLACK
from workbench.impact.system import commit, forces


def moreau_jean(theta: float = 0.5, reach: float = 1.0) -> Stepper:
    """The step; `theta` 1/2 to 1, `reach` the share of a step that gaps are forecast for."""
    theta = Number(0.5, 1.0).check("moreau-jean.theta", theta)
    reach = REACH.check("moreau-jean.reach", reach)

    @register_jitable
    def step(system, law, state, h):
        closed = forecast(system, state, reach * h)
        shift = np.zeros(state.q.size)
        q, v, P, count, residual = implicit(system, law, state, h, theta, shift, closed)
        commit(system, q)
        return Step(State(q, v, state.a, P / h, state.t + h), P, count, residual, np.nan)

    return step


def energy_midpoint(reach: float = 0.5) -> Stepper:
    """The step; `reach`, the share of a step that gaps are forecast for (thesis: 1/2)."""
    reach = REACH.check("midpoint.reach", reach)

    @register_jitable
    def step(system, law, state, h):
        closed = forecast(system, state, reach * h)
        shift = np.zeros(state.q.size)
        q, v, P, count, residual = implicit(system, law, state, h, 0.0, shift, closed)
        commit(system, q)
        return Step(State(q, v, state.a, P / h, state.t + h), P, count, residual, np.nan)

    return step


def moreau_midpoint(at_end: bool = True) -> Stepper:
    """The step; stable up to h = 2 / omega. `at_end`: plastic flow at the end of a step too."""

    @register_jitable
    def step(system, law, state, h):
        middle = state.q + 0.5 * h * state.v
        f, _ = forces(system, middle)
        closed = gaps_of(system, middle, state.t + 0.5 * h) <= SLACK
        commit(system, middle)
        free = state.v - h * np.linalg.solve(system.mass, f)
        t = state.t + h
        v, P, residual = impulses_on(system, law, closed, system.mass, free, state, t)
        q = middle + 0.5 * h * v
        if at_end:
            commit(system, q)
        return Step(State(q, v, state.a, P / h, t), P, 1, residual, np.nan)

    return step


def central_differences() -> Stepper:
    """The step; stable up to h = 2 / omega."""

    @register_jitable
    def step(system, law, state, h):
        before = State(state.q, state.v - 0.5 * h * state.a, state.a, state.force, state.t)
        closed = forecast(system, before, h)
        free = before.v + h * state.a
        t = state.t + h
        half, P, residual = impulses_on(system, law, closed, system.mass, free, before, t)
        q = state.q + h * half
        f, _ = forces(system, q)
        commit(system, q)
        a = -np.linalg.solve(system.mass, f)
        return Step(State(q, half + 0.5 * h * a, a, P / h, t), P, 1, residual, np.nan)

    return step
