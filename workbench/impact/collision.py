"""Closed forms of the collision of two free masses with Newton restitution."""

from __future__ import annotations

from typing import NamedTuple


class Collision(NamedTuple):
    """Velocities (m/s) of the struck mass and the striker, percussion (N s), energy loss (J)."""

    struck_velocity: float
    striker_velocity: float
    percussion: float
    energy_loss: float


def collide(
    struck_mass: float, striker_mass: float, velocity: float, restitution: float
) -> Collision:
    """Collision of a striker with a mass at rest (masses in kg, velocity in m/s).

    Newton's law gamma_1 = -eps gamma_0 and conservation of momentum (Heng 2017, section 3.3).
    """
    effective = struck_mass * striker_mass / (struck_mass + striker_mass)
    percussion = (1.0 + restitution) * effective * velocity
    return Collision(
        percussion / struck_mass,
        velocity - percussion / striker_mass,
        percussion,
        0.5 * (1.0 - restitution**2) * effective * velocity**2,
    )
