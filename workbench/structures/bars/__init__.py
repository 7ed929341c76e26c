"""Beam-columns whose plasticity is lumped at, or told of as that of, their two ends."""

from workbench.structures.bars.fiber_bars import FiberBars, Rule, hinge_rule, lobatto_rule
from workbench.structures.bars.group import (
    NO_INTERACTION,
    Bar,
    BarElements,
    BarState,
    HingedBars,
    PlasticEnd,
)
from workbench.structures.bars.refined_bars import RefinedBars

__all__ = [
    "NO_INTERACTION",
    "Bar",
    "BarElements",
    "BarState",
    "FiberBars",
    "HingedBars",
    "PlasticEnd",
    "RefinedBars",
    "Rule",
    "hinge_rule",
    "lobatto_rule",
]
