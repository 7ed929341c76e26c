"""Unilateral contact with Newton restitution, shared by all impact models."""

from workbench.impact.restitution import (
    Collision,
    collide,
    contact_loss,
    explicit_percussion,
    rebound,
    touches,
)

__all__ = ["Collision", "collide", "contact_loss", "explicit_percussion", "rebound", "touches"]
