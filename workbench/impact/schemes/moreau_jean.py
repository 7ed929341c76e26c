"""Time stepping of Moreau and Jean (Jean 1999), the theta-method of the measure equation.

Over a step M dv + f dt = W dP is integrated with a theta-rule, and impulses are what is left:

    M (v1 - v0) + h (theta f1 + (1 - theta) f0) = W P,   q1 = q0 + h (theta v1 + (1 - theta) v0),
    0 <= P perp gamma_1 + e gamma_0 >= 0   where the gap forecast for the end of the step is closed.

No instant is located, so an impact is misplaced by up to a step: first order, and gaps may end
closed beyond by a step times the velocity of approach.
"""

import numpy as np

from workbench.compiled import register_jitable
from workbench.fields import Number
from workbench.impact.stepping import REACH, State, Step, Stepper, forecast, implicit
from workbench.impact.system import commit


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
