"""Beam-columns with plastic ends: hinges of zero length, refined hinges, fiber sections."""

from workbench.extras.frame_models.bars.group import NO_INTERACTION as NO_INTERACTION
from workbench.extras.frame_models.bars.group import Bar as Bar
from workbench.extras.frame_models.bars.group import BarElements as BarElements
from workbench.extras.frame_models.bars.group import PlasticEnd as PlasticEnd
from workbench.extras.frame_models.bars.kinds import Quadrature as Quadrature
from workbench.extras.frame_models.bars.kinds import fiber_bars as fiber_bars
from workbench.extras.frame_models.bars.kinds import hinge_rule as hinge_rule
from workbench.extras.frame_models.bars.kinds import hinged_bars as hinged_bars
from workbench.extras.frame_models.bars.kinds import lobatto_rule as lobatto_rule
from workbench.extras.frame_models.bars.kinds import refined_bars as refined_bars
