"""Energies that element groups report for a step."""

from __future__ import annotations

from typing import NamedTuple


class StepEnergies(NamedTuple):
    """Energies of one step of a group or a whole structure, in J.

    `stored` at the end of the step; `plastic` and `algorithmic` dissipation of the step; `ideal`,
    the plastic work of stresses that stay at yield: `plastic / ideal` is the yield ratio, which
    falls below 1 where averaged stresses soften the material artificially.
    """

    stored: float
    plastic: float
    algorithmic: float
    ideal: float

    def __add__(self, other: object) -> StepEnergies:
        """Sum of two groups, entry by entry."""
        if not isinstance(other, StepEnergies):
            return NotImplemented
        return StepEnergies(*(a + b for a, b in zip(self, other, strict=True)))
