"""Energies that element groups report for a step, and what a run has added up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

LEAST_FLOW = 1e-9  # of the stored energy; below it a yield ratio says nothing


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


@dataclass
class Tally:
    """Dissipation (J) and solver cost of the steps of a run so far."""

    plastic: float = 0.0
    algorithmic: float = 0.0
    ideal: float = 0.0
    evaluations: int = 0
    cuts: int = 0

    def add(self, energies: StepEnergies, evaluations: int, cuts: int) -> None:
        """Add a step."""
        self.plastic += energies.plastic
        self.algorithmic += energies.algorithmic
        self.ideal += energies.ideal
        self.evaluations += evaluations
        self.cuts += cuts

    @property
    def dissipated(self) -> float:
        """Plastic and algorithmic dissipation, in J."""
        return self.plastic + self.algorithmic

    def yield_ratio(self, most_stored: float) -> float | None:
        """Plastic work over that of stresses at yield; None without plastic flow.

        Argument: the largest energy (J) that was stored, against which flow is judged.
        """
        if self.ideal <= LEAST_FLOW * max(most_stored, 1e-300):
            return None
        return self.plastic / self.ideal

    def diagnostics(self, most_stored: float) -> dict[str, float | int]:
        """Numbers about the solution, for the attributes of a response."""
        numbers: dict[str, float | int] = {
            "newton_iterations": self.evaluations,
            "cut_steps": self.cuts,
            "algorithmic_dissipation": self.algorithmic,
        }
        ratio = self.yield_ratio(most_stored)
        if ratio is not None:
            numbers["yield_ratio"] = ratio
        return numbers
