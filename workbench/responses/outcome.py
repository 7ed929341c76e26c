"""How an attempt to answer a scenario ended, and what a model says about its domain."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Outcome(StrEnum):
    """How a model's attempt ended; `advice` says what to do about it."""

    OK = "ok"
    NOT_CONVERGED = "not-converged"
    INVALID_INPUT = "invalid-input"
    OUT_OF_DOMAIN = "out-of-domain"
    TIMED_OUT = "timed-out"
    CRASHED = "crashed"

    @property
    def advice(self) -> str:
        """One sentence: what the user can do."""
        return _ADVICE[self]


_ADVICE = {
    Outcome.OK: "Nothing to do.",
    Outcome.NOT_CONVERGED: "Take a smaller step or a finer mesh, or look at the state it names.",
    Outcome.INVALID_INPUT: "Correct the input that the message names.",
    Outcome.OUT_OF_DOMAIN: "Use a model whose assumptions cover this scenario.",
    Outcome.TIMED_OUT: "Allow more time per cell or take a cheaper discretisation.",
    Outcome.CRASHED: "This is a defect of the model: report it with the scenario file.",
}


@dataclass(frozen=True, slots=True)
class Finding:
    """What a model's domain check found: a warning (it still answers) or a refusal.

    Arguments: `subject`, a short key such as ``shear``; `text`, one sentence with the numbers;
    `refusal`, True when the model cannot answer.
    """

    subject: str
    text: str
    refusal: bool = False
