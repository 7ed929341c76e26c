"""Beam-columns whose plasticity is lumped at, or told of as that of, their two ends."""

from workbench.structures.bars.fiber_bars import FiberBars as FiberBars
from workbench.structures.bars.fiber_bars import Rule as Rule
from workbench.structures.bars.fiber_bars import hinge_rule as hinge_rule
from workbench.structures.bars.fiber_bars import lobatto_rule as lobatto_rule
from workbench.structures.bars.group import NO_INTERACTION as NO_INTERACTION
from workbench.structures.bars.group import Bar as Bar
from workbench.structures.bars.group import BarElements as BarElements
from workbench.structures.bars.group import HingedBars as HingedBars
from workbench.structures.bars.group import PlasticEnd as PlasticEnd
from workbench.structures.bars.refined_bars import RefinedBars as RefinedBars
