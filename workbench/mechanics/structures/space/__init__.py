"""Structures in space: nodes that move and turn in three directions, co-rotational fiber beams."""

from workbench.mechanics.structures.space.beams import SpaceAssembly as SpaceAssembly
from workbench.mechanics.structures.space.beams import SpaceBeams as SpaceBeams
from workbench.mechanics.structures.space.beams import SpaceElements as SpaceElements
from workbench.mechanics.structures.space.beams import SpaceSection as SpaceSection
from workbench.mechanics.structures.space.beams import space_fibers as space_fibers
from workbench.mechanics.structures.space.hinged import SpaceSuperelements as SpaceSuperelements
