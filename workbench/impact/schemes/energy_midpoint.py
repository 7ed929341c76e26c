"""The energy-conserving midpoint step (Heng 2017, eqs 3.31-3.33; Simo and Tarnow, Laursen).

    q1 = q0 + h (v0 + v1) / 2,   M (v1 - v0) + h f_mean = W P,   f_mean . (q1 - q0) = U1 - U0.

Multiplied by (v0 + v1) / 2 = (q1 - q0) / h the step gives T1 + U1 - T0 - U0 = P (gamma_0 +
gamma_1) / 2: a free step keeps energy exactly whatever its length, and an impact of Newton's law
changes it by P (1 - e) gamma_0 / 2 <= 0, which for e = 1 is nothing.
"""

import numpy as np

from workbench.compiled import register_jitable
from workbench.impact.stepping import REACH, State, Step, Stepper, forecast, implicit
from workbench.impact.system import commit


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
