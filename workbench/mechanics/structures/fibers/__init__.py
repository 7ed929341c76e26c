"""Fiber sections and the beams that are made of them."""

from workbench.mechanics.structures.fibers.section import PATTERNS as PATTERNS
from workbench.mechanics.structures.fibers.section import BeamSection as BeamSection
from workbench.mechanics.structures.fibers.section import FiberBeams as FiberBeams
from workbench.mechanics.structures.fibers.section import FiberElements as FiberElements
from workbench.mechanics.structures.fibers.section import ReissnerBeams as ReissnerBeams
from workbench.mechanics.structures.fibers.section import lobatto as lobatto
from workbench.mechanics.structures.fibers.section import section_fibers as section_fibers
