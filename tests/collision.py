"""Closed form of the collision of two free masses, which tests of several rooms share."""

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
    """Collision of a striker with a free mass at rest (masses in kg, velocity in m/s)."""
    effective = struck_mass * striker_mass / (struck_mass + striker_mass)
    percussion = (1.0 + restitution) * effective * velocity
    return Collision(
        percussion / struck_mass,
        velocity - percussion / striker_mass,
        percussion,
        0.5 * (1.0 - restitution**2) * effective * velocity**2,
    )
