"""HHT-alpha (Hilber, Hughes and Taylor 1977) with contact at the end position, for contrast.

Forces are taken at t1 - alpha h, with gamma = 1/2 + alpha and beta = (1 + alpha)^2 / 4: second
order, and the highest frequencies damped by (1 - alpha) / (1 + alpha) a step. Damping limits what
Newmark's contact puts into the grid, but the velocity after an impact is the grid's still.
"""

from workbench.fields import Number
from workbench.impact.schemes.generalized_alpha import alpha_step
from workbench.impact.stepping import Stepper


def hht_alpha(alpha: float = 0.1) -> Stepper:
    """The step; `alpha` 0 to 1/3."""
    alpha = Number(0.0, 1.0 / 3.0).check("hht-alpha.alpha", alpha)
    return alpha_step(0.0, alpha, 0.25 * (1.0 + alpha) ** 2, 0.5 + alpha, False)
