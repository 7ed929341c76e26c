"""The error budget of an answer: what each source of error leaves open, and the total.

Terms are changes of the answer on its log scale, where factors add. A term moves the answer by its
`shift` (a measured bias) and leaves it open by `below` and `above`, half-widths of `COVERAGE`.
Together, shifts add and half-widths of what scatters add in quadrature, each side by itself.
The model form is the error to expect of the answer (`evidence/error_model.py`). It
was measured with the meshes and steps of the models and so contains the numerical part, which is
stated by itself and not added. Where a part is not known there is no total.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import exp, expm1, inf, isinf, log, log1p, sqrt
from typing import Any

from workbench.study.error_model.error_model import PEAK as PEAK
from workbench.study.error_model.error_model import RESIDUAL as RESIDUAL
from workbench.study.error_model.error_table import COVERAGE as COVERAGE

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


def model_form(error: Mapping[str, Any], quantity: str, value: float) -> Term:
    """Term of the model form, from the `error` to expect of an answer (fields of `ExpectedError`).

    Of the peak the error is expected, of the residual displacement `value` the ends are known.
    """
    reason = str(error.get("reason", "not estimated with this answer"))
    ends = error.get("residual") or (0.0,)
    if quantity == RESIDUAL and ends[0] > 0.0:
        low, high = (log(end / value) for end in ends)
        half = 0.5 * (high - low)
        text = "ends alone, by the residual displacement of the anchor"
        return Term(MODEL_FORM, text, f"through {error['anchor']}", low + half, half, half)
    if quantity != PEAK:
        reason = f"not measured of the {quantity.replace('_', ' ')}"
    elif error.get("expected") is not None:
        off, least, most = (log1p(error[name]) for name in ("expected", "low", "high"))
        reason = f"{error['count']} drawn scenarios, {error['cell']}"
        return Term(MODEL_FORM, reason, f"through {error['anchor']}", -off, most - off, off - least)
    return Term(MODEL_FORM, reason, "", 0.0, None, None)
