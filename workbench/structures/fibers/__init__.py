"""Fiber sections and the beams that are made of them."""

from workbench.structures.fibers.beams import FiberBeams as FiberBeams
from workbench.structures.fibers.beams import FiberElements as FiberElements
from workbench.structures.fibers.beams import ReissnerBeams as ReissnerBeams
from workbench.structures.fibers.section import PATTERNS as PATTERNS
from workbench.structures.fibers.section import BeamSection as BeamSection
from workbench.structures.fibers.section import lobatto as lobatto
from workbench.structures.fibers.section import section_fibers as section_fibers
