"""The error budget of an answer: what each source of error leaves open, and the total.

Terms are changes of the answer on its log scale, where factors add. A term moves the answer by its
`shift` (a measured bias) and leaves it open by `below` and `above`, half-widths of `COVERAGE`.
Together, shifts add and half-widths of what scatters add in quadrature, each side by itself.
A term that only pulls one way, by an unknown part of what is stated, is no scatter: its width
adds in full. Terms that are not known are left out, and the sum says so; without the model form
there is no sum.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from math import exp, expm1, inf, isinf, log, sqrt
from typing import Any

from workbench.evidence import dataset, load
from workbench.evidence.descriptors import (
    DEMAND,
    STRIKER,
    YIELDING,
    beyond,
    descriptors,
    variant_of,
)
from workbench.models.base import Model
from workbench.scenarios import ColumnImpact

PEAK, RESIDUAL = "peak_displacement", "residual_displacement"
REMAINS = 0.1  # of the peak: below, the ratio of residual displacements says nothing
COVERAGE = 0.90
NUMERICAL, MODEL_FORM, RATE = "numerical", "model form", "rate sensitivity"
REFERENCE, TOTAL = "best reference", "total"
SUMS = (REFERENCE, TOTAL)
COLUMNS = ("term", "shift", "low", "high", "least", "most", "reason", "source", "lacks")


@dataclass(frozen=True, slots=True)
class Term:
    """A source of error, or a sum of them: `name`, a one-line `reason`, where it is from.

    `shift`, `below` and `above` are log changes of the answer; `below` and `above` are None where
    nothing is known. `pulls`: it acts one way only, by an unknown part of its width. `lacks`, what
    a sum leaves out, as it is not known.
    """

    name: str
    reason: str
    source: str
    shift: float = 0.0
    below: float | None = 0.0
    above: float | None = 0.0
    pulls: bool = False
    lacks: tuple[str, ...] = ()

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
        values = (shift, *ends, *reached, self.reason, self.source, [*self.lacks])
        return dict(zip(COLUMNS, (self.name, *values), strict=True))


def numerical_term(value: float, width: float | None) -> Term:
    """The numerical uncertainty of an answer `value`, a half-width in its unit (None: unknown)."""
    if width is None or width >= value:
        return Term(NUMERICAL, "its numerical uncertainty is unknown", "", 0.0, None, None)
    share = width / value
    reason = "mesh, fibers and steps of this answer" if width else "not estimated: in model form"
    return Term(NUMERICAL, reason, "", 0.0, -log(1.0 - share), log(1.0 + share))


def varied_term(name: str, value: float, answers: Sequence[float | None], source: str) -> Term:
    """What a varied input does: the `answers` at both ends of its range around `value`.

    An infinite answer is a collapse, None no answer.
    """
    known = [log(answer / value) for answer in answers if answer is not None]
    if len(known) < len(answers):
        return Term(name, "the model gives no answer to it", source, 0.0, None, None)
    fallen = "the structure may collapse" if any(isinf(change) for change in known) else ""
    low, high = min(0.0, *known), max(0.0, *known)
    return Term(name, fallen, source, 0.0, -low, high)


def together(name: str, terms: Iterable[Term]) -> Term:
    """The sum of the terms that are known."""
    listed = list(terms)
    known = [term for term in listed if term.known]
    lacks = tuple(term.name for term in listed if not term.known)
    pulls = [term for term in known if term.pulls]
    scatters = [term for term in known if not term.pulls]
    below, above = (_joined(scatters, pulls, side) for side in ("below", "above"))
    shift = sum(term.shift for term in known)
    names = ", ".join(term.name for term in known)
    reason = f"without {', '.join(lacks)}, not known" if lacks else f"all of it: {names}"
    return Term(name, reason, "", shift, below, above, lacks=lacks)


def _joined(scatters: Sequence[Term], pulls: Sequence[Term], side: str) -> float:
    """Half-width on one side: the root of squares of what scatters, and all that pulls."""
    widths = [float(getattr(term, side)) for term in scatters]
    pulled = sum(float(getattr(term, side)) for term in pulls)
    return inf if inf in widths else sqrt(sum(width**2 for width in widths)) + pulled


TABLE, RANGES = "model-form", "model-form-ranges"
FEWEST = 6  # columns of a region
BOUNDS = (DEMAND, YIELDING, STRIKER)  # descriptors that tell regions apart


@dataclass(frozen=True, slots=True)
class Trend:
    """A straight line through log ratios of a region over V/Vpl, fitted by least squares.

    `bias`, the ratio at the `centre` of the V/Vpl of `count` columns, `slope` of the log ratio;
    `scatter`, its standard deviation about the line; `spread`, the root of the summed squares of
    the distances to the centre.
    """

    count: int
    bias: float
    slope: float
    scatter: float
    centre: float
    spread: float

    def expected(self, demand: float) -> float:
        """The log ratio of a new column."""
        return log(self.bias) + self.slope * (demand - self.centre)

    def half_width(self, demand: float) -> float:
        """Half-width of the interval in which the log ratio of a new column lies."""
        from scipy.stats import t as student

        quantile = float(student.ppf(0.5 * (1.0 + COVERAGE), self.count - 2))
        away = (demand - self.centre) / self.spread
        return quantile * self.scatter * sqrt(1.0 + 1.0 / self.count + away**2)


TREND = tuple(f.name for f in fields(Trend))


def model_form(model: Model, scenario: ColumnImpact, quantity: str) -> Term:
    """What the model form leaves open in a quantity: a prediction interval for a new column.

    The reference is expected where the measured trend puts it.
    """
    title = dataset(TABLE).title
    given = descriptors(scenario)
    outside = beyond(given, RANGES)
    if outside:
        text = f"not measured here: {', '.join(outside)} outside the columns of the study"
        return Term(MODEL_FORM, text, title, 0.0, None, None)
    variant = variant_of(model)
    for row in _rows():
        same = (row["model"], row["options"], row["quantity"]) == (model.name, variant, quantity)
        if same and all(row[f"{name}_low"] <= given[name] < row[f"{name}_high"] for name in BOUNDS):
            trend = Trend(**{name: row[name] for name in TREND})
            off, width = trend.expected(given[DEMAND]), trend.half_width(given[DEMAND])
            source = f"study {row['study']}"
            return Term(MODEL_FORM, _said(row, off, model), source, -off, width, width)
    text = f"not measured here: the study has no {model.name} {variant}".rstrip()
    text += f" with {quantity.replace('_', ' ')} in such columns"
    return Term(MODEL_FORM, text, title, 0.0, None, None)


def _said(row: dict[str, Any], expected: float, model: Model) -> str:
    """Where the numbers of a row are from, and by how much the model is off, in words."""
    off = 100.0 * expm1(expected)
    bias = f"{abs(off):.0f} % {'low' if off < 0 else 'high'}" if abs(off) >= 0.5 else "no bias"
    text = f"{bias}, scatter {100.0 * row['scatter']:.0f} %"
    text += f", {row['count']} columns, {row['region']}"
    if row["outside"]:
        text += f"; {row['outside']} of the references outside their domain"
    if row["model_version"] != model.version:
        text += f"; measured with version {row['model_version']} of the model"
    return text


@lru_cache(maxsize=1)
def _rows() -> tuple[dict[str, Any], ...]:
    table = load(TABLE).fillna({"options": ""})
    return tuple({str(name): v for name, v in row.items()} for row in table.to_dict("records"))
