"""Cross sections: profile catalogue, fibers, exact plastic envelope of axial force and moment."""

from workbench.sections.reading import (
    SECTION,
    circular_tube,
    find,
    i_section,
    names,
    plate,
    rectangle,
    rectangular_tube,
    section_from,
    square,
    square_tube,
)
from workbench.sections.section import Section
from workbench.sections.shapes import CircularTube, ISection, Rectangle, RectangularTube, Shape

__all__ = [
    "SECTION",
    "CircularTube",
    "ISection",
    "Rectangle",
    "RectangularTube",
    "Section",
    "Shape",
    "circular_tube",
    "find",
    "i_section",
    "names",
    "plate",
    "rectangle",
    "rectangular_tube",
    "section_from",
    "square",
    "square_tube",
]
