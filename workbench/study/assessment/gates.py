"""The rule of a gate's verdict: `judge` in one case, `GateVerdict` over all.

`study/verdicts` applies it to stored answers, and says there which cases have none to judge.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import inf

_NAMED = 4  # cases that a reason names
_DIFFERENT = "one side collapses and the other survives"
_ALIKE = "both sides collapse, which passes without a number,"
_OPEN = ("no answer", "nothing to judge", "uncertainty unknown", "uncertainty across the bound")


class Verdict(StrEnum):
    """How a gate ends, and how it ends in one case.

    Inconclusive: the uncertainty straddles the bound, there is nothing to judge, or agreement says
    nothing, as what was compared is outside its domain. A case alone may also be refused by one
    side (out of its domain) or remain without an answer (failed, not run). Collapse is an answer:
    a case fails where one side collapses and the other survives, and passes, without a number,
    where both collapse.
    """

    FAIL = "fail"
    UNANSWERED = "unanswered"
    REFUSED = "refused"
    INCONCLUSIVE = "inconclusive"
    PASS = "pass"


@dataclass(frozen=True, slots=True)
class Gate:
    """An acceptance criterion on one metric of one quantity for one model of a study.

    Arguments: `model` and `against`, labels in the study (the model judged, and what it is held
    against: the reference or a published series); `quantity`, a response variable such as
    ``peak_displacement``; `metric`, a name in `workbench.study.assessment.METRICS`; `bound` on the
    absolute value of the metric; `rationale` and `source` for the reader; `cases`, names of the
    cases (empty: all that the study asks of both labels). Metrics of a response alone take the
    same label twice.
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
        """Sentence of the gate: model, reference, metric and quantity."""
        if self.model == self.against:
            return f"{self.model}: {self.metric} of {self.quantity}"
        return f"{self.model} against {self.against}: {self.metric} of {self.quantity}"


def judge(
    value: float,
    uncertainty: float | None,
    bound: float,
    low: float | None = None,
    high: float | None = None,
) -> Verdict:
    """Pass if the whole interval value +- uncertainty lies within +-bound, fail if none does.

    An unknown uncertainty (None) can fail a gate but not pass it. From `low` to `high`, where both
    are given, is the interval instead.
    """
    width = 0.0 if uncertainty is None else uncertainty
    least = value - width if low is None else low
    most = value + width if high is None else high
    if least > bound or most < -bound:
        return Verdict.FAIL
    if uncertainty is None or most > bound or least < -bound:
        return Verdict.INCONCLUSIVE
    return Verdict.PASS


@dataclass(frozen=True, slots=True)
class CaseVerdict:
    """A gate in one case: the `value` of its metric, with `uncertainty`, None without an answer.

    `note` says where the uncertainty comes from, or why there is nothing to judge; `collapsed` are
    the labels whose structure collapses; `doubt`, why what is within the bound is no pass; `low`
    and `high`, the ends of an interval over tests.
    """

    case: str
    verdict: Verdict
    value: float | None
    uncertainty: float | None
    note: str
    collapsed: tuple[str, ...] = ()
    doubt: str = ""
    low: float | None = None
    high: float | None = None

    @property
    def remark(self) -> str:
        """Remark on the case besides a number within or beyond the bound."""
        if self.doubt:
            return self.doubt
        if self.verdict in (Verdict.PASS, Verdict.FAIL):
            alone = _DIFFERENT if self.verdict is Verdict.FAIL else _ALIKE
            return alone if self.collapsed else ""
        if self.verdict is not Verdict.INCONCLUSIVE:
            return _OPEN[0]
        if self.value is None:
            return _OPEN[1]
        return _OPEN[2] if self.uncertainty is None else _OPEN[3]


@dataclass(frozen=True, slots=True)
class GateVerdict:
    """A gate over all `cases` that are asked; `number` is its place in the study, from 1."""

    number: int
    gate: Gate
    cases: tuple[CaseVerdict, ...]

    @property
    def counts(self) -> dict[str, int]:
        """Cases asked, how many of them ended in each verdict, and in how many a side collapses."""
        ends = [case.verdict for case in self.cases]
        collapses = sum(bool(case.collapsed) for case in self.cases)
        verdicts = {each.value: ends.count(each) for each in Verdict}
        return {"asked": len(ends), **verdicts, "collapses": collapses}

    @property
    def verdict(self) -> Verdict:
        """Fail if a case fails, pass if every case that was asked passes, else inconclusive.

        A case without an answer may be the one that matters: nothing passes without it.
        """
        ends = {case.verdict for case in self.cases}
        if Verdict.FAIL in ends:
            return Verdict.FAIL
        return Verdict.PASS if ends == {Verdict.PASS} else Verdict.INCONCLUSIVE

    @property
    def critical(self) -> CaseVerdict | None:
        """The case with that verdict that reaches farthest; None if no case was judged.

        Survival against collapse is beyond every number, collapse on both sides below all.
        """
        judged = [case for case in self.cases if case.value is not None or case.collapsed]
        same = [case for case in judged if case.verdict is self.verdict] or judged

        def reach(case: CaseVerdict) -> float:
            if case.value is None:
                return inf if case.verdict is Verdict.FAIL else -inf
            if case.low is not None and case.high is not None:
                return max(abs(case.low), abs(case.high))
            return abs(case.value) + (case.uncertainty or 0.0)

        return max(same, key=reach, default=None)

    @property
    def reasons(self) -> tuple[str, ...]:
        """Reasons beside numbers: collapse, and all else that keeps the gate from passing."""
        if not self.cases:
            return ("the study asks no case of both sides",)
        kinds: dict[str, list[CaseVerdict]] = {what: [] for what in (*_OPEN, _DIFFERENT, _ALIKE)}
        for case in self.cases:
            if case.remark:
                kinds.setdefault(case.remark, []).append(case)
        return tuple(
            f"{what} in {len(cases)} of {len(self.cases)} asked cases: {_listed(cases)}"
            for what, cases in kinds.items()
            if cases
        )


def _listed(cases: Sequence[CaseVerdict]) -> str:
    names = [case.case for case in cases]
    if not cases[0].doubt:
        names[0] += f" ({cases[0].note.rstrip('.')})"
    more = [f"{len(names) - _NAMED} more"] if len(names) > _NAMED else []
    return ", ".join([*names[:_NAMED], *more])
