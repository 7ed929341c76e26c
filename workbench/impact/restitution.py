"""Newton's law of restitution: the unilateral contact of striker and structure.

Moreau 1988; Heng 2017, section 3.3 and eqs 3.17-3.30. Gap g >= 0, gap velocity gamma = g'; the
percussion P of a step obeys 0 <= P perp xi = gamma_1 + eps gamma_0 >= 0 while the contact is
closed. Explicit steps call `explicit_percussion`; implicit steps write xi = 0 into their equations
(`structures/impact`, `models/four_dof/dynamics`, `models/single_dof`) with the `rebound` given
here. When a gap counts as closed is part of each scheme: forecast for the middle of a midpoint
step (`touches`), for its end in frames, at the position reached in Moreau's.
"""

from typing import NamedTuple

from workbench.compiled import njit


@njit(cache=True, error_model="numpy")
def touches(gap: float, gamma: float, dt: float) -> bool:
    """Whether the gap forecast for the middle of the step is closed."""
    return gap + 0.5 * dt * gamma <= 0.0


@njit(cache=True, error_model="numpy")
def rebound(gamma_start: float, restitution: float) -> float:
    """Restitution that the step uses: eps while approaching, 1 while separating.

    Contact is enforced on velocities, so a drifted gap can be closed while the bodies separate.
    Newton's law with eps < 1 would then do positive work on the mean gap velocity and create
    energy; with 1 the mean gap velocity, and so that work, is zero.
    """
    return 1.0 if gamma_start > 0.0 else restitution


@njit(cache=True, error_model="numpy")
def explicit_percussion(
    gamma_free: float, gamma_start: float, restitution: float, mass: float, striker_mass: float
) -> float:
    """Percussion from the gap velocity without contact; one contact needs no iteration.

    The factor r of Heng 2017, eq. 3.28, must be (w' M^-1 w)^-1, in kg, as here; eq. 3.29 prints
    its inverse.
    """
    xi = gamma_free + rebound(gamma_start, restitution) * gamma_start
    return max(-xi, 0.0) / (1.0 / mass + 1.0 / striker_mass)


@njit(cache=True, error_model="numpy")
def contact_loss(percussion: float, gamma_start: float, gamma_end: float) -> float:
    """Energy lost in the contact during the step: minus the work of P on the mean gap velocity."""
    return -0.5 * percussion * (gamma_start + gamma_end)


class Collision(NamedTuple):
    """Velocities (m/s) of the struck mass and the striker, percussion (N s), energy loss (J)."""

    struck_velocity: float
    striker_velocity: float
    percussion: float
    energy_loss: float


def collide(
    struck_mass: float, striker_mass: float, velocity: float, restitution: float
) -> Collision:
    """Collision of a striker with a free mass at rest (masses in kg, velocity in m/s)."""
    effective = struck_mass * striker_mass / (struck_mass + striker_mass)
    percussion = (1.0 + restitution) * effective * velocity
    return Collision(
        percussion / struck_mass,
        velocity - percussion / striker_mass,
        percussion,
        0.5 * (1.0 - restitution**2) * effective * velocity**2,
    )
