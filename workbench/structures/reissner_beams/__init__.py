"""Geometrically exact beams (Reissner, Simo) with fiber sections, on scikit-fem's tables."""

from workbench.structures.reissner_beams.group import ReissnerBeams
from workbench.structures.reissner_beams.section import BeamSection

__all__ = ["BeamSection", "ReissnerBeams"]
