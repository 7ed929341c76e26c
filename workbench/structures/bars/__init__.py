"""Beam-columns whose plasticity is lumped at, or told of as that of, their two ends."""

from workbench.structures.bars.group import (
    NO_INTERACTION,
    Bar,
    BarElements,
    BarState,
    HingedBars,
    PlasticEnd,
    RefinedBars,
)

__all__ = [
    "NO_INTERACTION",
    "Bar",
    "BarElements",
    "BarState",
    "HingedBars",
    "PlasticEnd",
    "RefinedBars",
]
