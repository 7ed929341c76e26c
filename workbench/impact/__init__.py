"""Unilateral contact with Newton restitution, shared by all impact models."""

from workbench.impact.collision import Collision, collide

__all__ = ["Collision", "collide"]
