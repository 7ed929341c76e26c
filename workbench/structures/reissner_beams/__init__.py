"""Geometrically exact beams (Reissner, Simo) with fiber sections."""

from workbench.structures.reissner_beams.group import ReissnerBeams

__all__ = ["ReissnerBeams"]
