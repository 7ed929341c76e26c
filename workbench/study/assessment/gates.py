"""The rule of a gate's verdict: `judge` in one case, `GateVerdict` over all.

`study/verdicts` applies it to stored answers, and says there which cases have none to judge.

**Second part.** Bias and scatter over many cases, with intervals.

**Third part.** The error budget of an answer: what each source of error leaves open, and the total.

Terms are changes of the answer on its log scale, where factors add. A term moves the answer by its
`shift` (a measured bias) and leaves it open by `below` and `above`, half-widths of `COVERAGE`.
Together, shifts add and half-widths of what scatters add in quadrature, each side by itself.
The model form is the error to expect of the answer (`evidence/error_model.py`). It
was measured with the meshes and steps of the models and so contains the numerical part, which is
stated by itself and not added. Where a part is not known there is no total.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import exp, expm1, inf, isinf, log, log1p, sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array
from workbench.base.errors import InputError
from workbench.responses import PEAK, RESIDUAL, ExpectedError

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

    Parameters
    ----------
    model, against : str
        Labels in the study: the model judged, and the reference or published series that it is
        held against; of a metric of a response alone the same label.
    quantity : str
        A response variable such as ``peak_displacement``.
    metric : str
        A name in `workbench.study.assessment.METRICS`.
    bound : float
        Largest absolute value of the metric.
    rationale, source : str
        Reason of the bound, and where it comes from.
    cases : tuple of str
        Names of cases; empty: all that the study asks of both labels.

    Examples
    --------
    >>> because = "design margin", "EN 1990"
    >>> wb.Gate("4 dof", "fiber", "peak_displacement", "relative-error", 0.1, *because).name
    '4 dof against fiber: relative-error of peak_displacement'
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


@dataclass(frozen=True, slots=True)
class Bias:
    """Bias and scatter of the ratio of a model to data.

    `count` pairs; `bias`, the expected ratio; `low` and `high`, its 95 % confidence interval, and
    `model_scatter`, the standard deviation of the log ratio (None with fewer than two pairs).
    """

    count: int
    bias: float
    low: float | None = None
    high: float | None = None
    model_scatter: float | None = None


def bias_and_scatter(model: ArrayLike, data: ArrayLike) -> Bias:
    """Bias factor and model scatter as the FDS validation guide defines them.

    Arguments: pairs of `model` and `data` (n,), of one sign, the data without their own scatter.
    With the log ratios' mean and standard deviation u, the bias is exp(mean + u^2/2). The
    interval is Cox's for the mean of a lognormal quantity, with Student quantiles.
    Raises `InputError` for values of different signs, zeros, and values not in pairs.
    """
    from scipy.stats import t as student

    ratio = _log_ratio(model, data)
    n, mean = len(ratio), float(np.mean(ratio))
    if n == 1:
        return Bias(1, float(np.exp(mean)))
    scatter = float(np.std(ratio, ddof=1))
    centre = mean + 0.5 * scatter**2
    width = student.ppf(0.975, n - 1) * np.sqrt(scatter**2 / n + scatter**4 / (2.0 * (n - 1)))
    low, bias, high = (float(x) for x in np.exp([centre - width, centre, centre + width]))
    return Bias(n, bias, low, high, scatter)


def _log_ratio(model: ArrayLike, data: ArrayLike) -> Array:
    values, references = np.atleast_1d(model).astype(float), np.atleast_1d(data).astype(float)
    if values.shape != references.shape or values.ndim != 1 or len(values) == 0:
        shapes = values.shape, references.shape
        raise InputError("model, data", shapes, "must be pairs, one or more")
    ratio = values / np.where(references == 0.0, np.nan, references)
    if not (np.all(np.isfinite(ratio)) and np.all(ratio > 0.0)):
        raise InputError("model, data", ratio.min(), "must be finite and of one sign in each pair")
    logarithm: Array = np.log(ratio)
    return logarithm


REMAINS = 0.1  # of the peak: below, the ratio of residual displacements says nothing
NUMERICAL, MODEL_FORM, RATE = "numerical", "model form", "rate sensitivity"
REFERENCE, TOTAL = "best reference", "total"
SUMS = (REFERENCE, TOTAL)
COLUMNS = ("term", "shift", "low", "high", "least", "most", "reason", "source")


@dataclass(frozen=True, slots=True)
class Term:
    """A source of error, or a sum of them: `name`, a one-line `reason`, where it is from.

    `shift`, `below` and `above` are log changes of the answer; `below` and `above` are None where
    nothing is known.
    """

    name: str
    reason: str
    source: str
    shift: float = 0.0
    below: float | None = 0.0
    above: float | None = 0.0

    @property
    def known(self) -> bool:
        """Whether its size is known."""
        return self.below is not None and self.above is not None

    @property
    def low(self) -> float | None:
        """Lower end as a relative change of the answer: -0.2 where it may be 20 % smaller."""
        return None if self.below is None else expm1(self.shift - self.below)

    @property
    def high(self) -> float | None:
        """Upper end as a relative change of the answer; infinite where it may collapse."""
        return None if self.above is None else exp(self.shift + self.above) - 1.0

    def as_dict(self, value: float) -> dict[str, Any]:
        """The term by the names of `COLUMNS`; what is unknown is None.

        Relative changes of the answer `value`; `least` and `most`, what it is at the ends, in SI.
        """
        shift = expm1(self.shift) if self.known else None
        ends = self.low, self.high
        reached = (None if end is None else value * (1.0 + end) for end in ends)
        values = (shift, *ends, *reached, self.reason, self.source)
        return dict(zip(COLUMNS, (self.name, *values), strict=True))


def numerical_term(value: float, width: float | None) -> Term:
    """The numerical uncertainty of an answer `value`, a half-width in its unit (None: unknown)."""
    if width is None or width >= value:
        return Term(NUMERICAL, "its numerical uncertainty is unknown", "", 0.0, None, None)
    share = width / value
    reason = "mesh, fibers and steps of this answer" if width else "not estimated"
    return Term(NUMERICAL, f"{reason}, in model form", "", 0.0, -log(1.0 - share), log(1.0 + share))


def varied_term(name: str, value: float, answers: Sequence[float | None], source: str) -> Term:
    """Term of a varied input, from the `answers` at both ends of its range around `value`.

    An infinite answer is a collapse, None no answer.
    """
    known = [log(answer / value) for answer in answers if answer is not None]
    if len(known) < len(answers):
        return Term(name, "the model gives no answer to it", source, 0.0, None, None)
    fallen = "the structure may collapse" if any(isinf(change) for change in known) else ""
    low, high = min(0.0, *known), max(0.0, *known)
    return Term(name, fallen, source, 0.0, -low, high)


def together(name: str, terms: Iterable[Term]) -> Term:
    """The sum of terms, all of them known."""
    listed = list(terms)
    below, above = (_joined(listed, side) for side in ("below", "above"))
    reason = f"all of it: {', '.join(term.name for term in listed)}"
    return Term(name, reason, "", sum(term.shift for term in listed), below, above)


def _joined(terms: Sequence[Term], side: str) -> float:
    """Half-width on one side: the root of the squares."""
    widths = [float(getattr(term, side)) for term in terms]
    return inf if inf in widths else sqrt(sum(width**2 for width in widths))


def model_form(error: ExpectedError | None, quantity: str, value: float) -> Term:
    """Term of the model form, from the `error` to expect of an answer; None: it has no advice.

    Of the peak the error is expected, of the residual displacement `value` the ends are known.
    """
    if error is None:
        error = ExpectedError("", reason="not estimated with this answer")
    reason, source = error.reason, f"through {error.anchor}"
    ends = error.residual or (0.0,)
    if quantity == RESIDUAL and ends[0] > 0.0:
        low, high = (log(end / value) for end in ends)
        half = 0.5 * (high - low)
        text = "ends alone, by the residual displacement of the anchor"
        return Term(MODEL_FORM, text, source, low + half, half, half)
    if quantity != PEAK:
        reason = f"not measured of the {quantity.replace('_', ' ')}"
    elif error.expected is not None:
        off, least, most = (log1p(getattr(error, name)) for name in ("expected", "low", "high"))
        reason = f"{error.count} drawn scenarios, {error.cell}"
        return Term(MODEL_FORM, reason, source, -off, most - off, off - least)
    return Term(MODEL_FORM, reason, "", 0.0, None, None)
