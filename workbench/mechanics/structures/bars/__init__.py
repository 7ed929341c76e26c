"""Beam-columns with plastic ends: hinges of zero length, refined hinges, fiber sections."""

from workbench.mechanics.structures.bars.group import NO_INTERACTION as NO_INTERACTION
from workbench.mechanics.structures.bars.group import Bar as Bar
from workbench.mechanics.structures.bars.group import BarElements as BarElements
from workbench.mechanics.structures.bars.group import PlasticEnd as PlasticEnd
from workbench.mechanics.structures.bars.kinds import Quadrature as Quadrature
from workbench.mechanics.structures.bars.kinds import fiber_bars as fiber_bars
from workbench.mechanics.structures.bars.kinds import hinge_rule as hinge_rule
from workbench.mechanics.structures.bars.kinds import hinged_bars as hinged_bars
from workbench.mechanics.structures.bars.kinds import lobatto_rule as lobatto_rule
from workbench.mechanics.structures.bars.kinds import refined_bars as refined_bars
