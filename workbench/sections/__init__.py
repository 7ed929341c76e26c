"""Cross sections: profile catalogue, fibers, exact plastic envelope of axial force and moment."""

from workbench.sections.reading import SECTION as SECTION
from workbench.sections.reading import circular_tube as circular_tube
from workbench.sections.reading import find as find
from workbench.sections.reading import i_section as i_section
from workbench.sections.reading import names as names
from workbench.sections.reading import plate as plate
from workbench.sections.reading import rectangle as rectangle
from workbench.sections.reading import rectangular_tube as rectangular_tube
from workbench.sections.reading import section_from as section_from
from workbench.sections.reading import section_value as section_value
from workbench.sections.reading import square as square
from workbench.sections.reading import square_tube as square_tube
from workbench.sections.section import Section as Section
from workbench.sections.shapes import CircularTube as CircularTube
from workbench.sections.shapes import ISection as ISection
from workbench.sections.shapes import Rectangle as Rectangle
from workbench.sections.shapes import RectangularTube as RectangularTube
from workbench.sections.shapes import Shape as Shape
