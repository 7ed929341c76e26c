"""Cross sections: profile catalogue, fibers, exact plastic envelope of axial force and moment."""

from workbench.steel.sections.reading import SECTION as SECTION
from workbench.steel.sections.reading import circular_tube as circular_tube
from workbench.steel.sections.reading import find as find
from workbench.steel.sections.reading import i_section as i_section
from workbench.steel.sections.reading import names as names
from workbench.steel.sections.reading import plate as plate
from workbench.steel.sections.reading import rectangle as rectangle
from workbench.steel.sections.reading import rectangular_tube as rectangular_tube
from workbench.steel.sections.reading import section_from as section_from
from workbench.steel.sections.reading import section_value as section_value
from workbench.steel.sections.reading import square as square
from workbench.steel.sections.reading import square_tube as square_tube
from workbench.steel.sections.section import AXES as AXES
from workbench.steel.sections.section import CircularTube as CircularTube
from workbench.steel.sections.section import ISection as ISection
from workbench.steel.sections.section import Rectangle as Rectangle
from workbench.steel.sections.section import RectangularTube as RectangularTube
from workbench.steel.sections.section import Section as Section
from workbench.steel.sections.section import Shape as Shape
from workbench.steel.sections.section import TurnedISection as TurnedISection
