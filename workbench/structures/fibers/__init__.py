"""Fiber sections: strips of a section, their laws as tables, and groups of beams made of them."""

from workbench.structures.fibers.section import BeamSection, FiberElements, lobatto
from workbench.structures.fibers.strips import PATTERNS, SectionFibers, section_fibers

__all__ = ["PATTERNS", "BeamSection", "FiberElements", "SectionFibers", "lobatto", "section_fibers"]
