"""Moreau's explicit midpoint step as the thesis has it (Heng 2017, eqs 3.26-3.30; Moreau 1988).

    q_m = q0 + h v0 / 2,   M (v1 - v0) + h f(q_m) = W P,   q1 = q_m + h v1 / 2,

with 0 <= P perp gamma_1 + e gamma_0 >= 0 where the gap at q_m is closed. Two corrections to print:
(3.28) needs r = (W' M^-1 W)^-1, not its inverse, and (3.30) adds v1 alone to q_m (with v1 + v0 a
body at rest in velocity v would move by 3 h v / 2 in a step).
"""

import numpy as np

from workbench.compiled import register_jitable
from workbench.impact.pace import SLACK
from workbench.impact.stepping import State, Step, Stepper, gaps_of, impulses_on
from workbench.impact.system import commit, forces


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
