"""Newmark's average acceleration (1959) with contact at the end position, for contrast.

beta = 1/4, gamma = 1/2 make q1 = q0 + h (v0 + v1) / 2. Where a free body at velocity -V meets a
rigid wall a share s of a step ahead, g1 = 0 asks for v1 = (1 - 2 s) V, whatever restitution, with
an acceleration 4 (1 - s) V / h that pushes on in the next step. For s < 2/3 the body leaves at
v = (3 - 4 s) V, else, after a second step of contact, at (8 s - 5) V. The energy of one impact is
thus multiplied by a number between 0 and 9 that the grid draws, in the mean over s by

    int_0^2/3 (3 - 4 s)^2 ds + int_2/3^1 (8 s - 5)^2 ds = 91/27 = 3.37:

repeated impacts blow up. In lasting contact the same rule leaves the sign of the velocity open:
contact forces alternate (chatter).
"""

from workbench.impact.schemes.generalized_alpha import alpha_step
from workbench.impact.stepping import Stepper


def newmark() -> Stepper:
    """The step."""
    return alpha_step(0.0, 0.0, 0.25, 0.5, False)


def mean_energy_factor() -> float:
    """By how much one impact multiplies the energy, in the mean over its place in the step."""
    return 91.0 / 27.0
