"""Geometrically exact beams (Reissner, Simo) with fiber sections, on scikit-fem's tables."""

from workbench.structures.reissner_beams.group import ReissnerBeams

__all__ = ["ReissnerBeams"]
