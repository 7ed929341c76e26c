"""Acceptance gates: a metric, a bound and a reason, judged with the numerical uncertainty."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """Result of a gate; inconclusive when the uncertainty straddles the bound."""

    PASS = "pass"
    FAIL = "fail"
    INCONCLUSIVE = "inconclusive"


@dataclass(frozen=True, slots=True)
class Gate:
    """An acceptance criterion on one metric of one quantity for one model of a study.

    Arguments: `model` and `against`, labels in the study (the model judged, and what it is held
    against: the reference or a published series); `quantity`, a response variable such as
    ``peak_displacement``; `metric`, a name in `workbench.assessment.METRICS`; `bound` on the
    absolute value of the metric; `rationale` and `source` for the reader; `cases`, names of the
    cases (empty: all that both models answered). Metrics of a response alone take the same label
    twice.
    """

    model: str
    against: str
    quantity: str
    metric: str
    bound: float
    rationale: str
    source: str
    cases: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """What the gate asks, in one line."""
        if self.model == self.against:
            return f"{self.model}: {self.metric} of {self.quantity}"
        return f"{self.model} against {self.against}: {self.metric} of {self.quantity}"


def judge(value: float, uncertainty: float | None, bound: float) -> Verdict:
    """Pass if the whole interval value +- uncertainty lies within +-bound, fail if none does.

    An unknown uncertainty (None) can fail a gate but not pass it.
    """
    width = 0.0 if uncertainty is None else uncertainty
    if abs(value) - width > bound:
        return Verdict.FAIL
    if uncertainty is None or abs(value) + width > bound:
        return Verdict.INCONCLUSIVE
    return Verdict.PASS
