"""Explicit central differences with contact impulses (Belytschko, Liu and Moran 2000, 6.2).

    v+ = v- + h M^-1 (W P / h - f0),   q1 = q0 + h v+,

v- and v+ at the middles of the last and of this step, P from Newton's law between them where the
gap forecast with v- is closed. Velocities at full steps are v+ + h a1 / 2, which makes it the
velocity form of Verlet between impacts.
"""

import numpy as np

from workbench.compiled import register_jitable
from workbench.impact.stepping import State, Step, Stepper, forecast, impulses_on
from workbench.impact.system import commit, forces


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
