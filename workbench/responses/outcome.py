"""How an attempt to answer a scenario ended, and what a model says about its domain."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache
from pathlib import Path
from typing import Any

WARNING, REFUSAL = "warning", "refusal"  # severities of a finding
SYNTHETIC = "synthetic"  # subject of what is said of made numbers, which validate nothing
WARNED = 0.10  # expected loss from which an answer is warned of
TOO_LARGE = 0.2  # loss of an answer more than 10 % too large; of one that much too small it is 1
ERROR = "error"  # subject of a warning of the error model
COLUMNS = ("subject", "severity", "sentence", "remedy", "number", "limit", "instead")

# Subjects of warnings about a run, input that a model takes otherwise, an estimate or data. Every
# other warning, of models from elsewhere too, says that the scenario lies outside the domain.
_NOT_OF_DOMAIN = frozenset(
    (
        *("mesh", "refinement", "time-step", "damping", "yield-ratio", "energy-balance", "no-peak"),
        *(
            "off-web",
            "direction",
            "section",
            "plates",
            "slender-web",
            "exponents",
            "no-residual",
            "light-striker",
        ),
        "hinge-stiffness",
        *(
            "error-not-measured",
            "close-to-collapse",
            "lateral-check",
        ),  # of the error, which may be small
        *("estimate", "ends", "plausibility"),  # a column cut out of its frame is always one
        *("evidence", "series", "campaigns", "bounds", "grade", "measurement", SYNTHETIC),
    )
)


class Outcome(StrEnum):
    """How a model's attempt ended; `advice` says what to do about it."""

    OK = "ok"
    COLLAPSE = "collapse"
    NOT_CONVERGED = "not-converged"
    INVALID_INPUT = "invalid-input"
    OUT_OF_DOMAIN = "out-of-domain"
    TIMED_OUT = "timed-out"
    CRASHED = "crashed"

    @property
    def advice(self) -> str:
        """One sentence: what the user can do."""
        return _ADVICE[self]

    @property
    def is_answer(self) -> bool:
        """Whether it says what becomes of the structure: it survives or it collapses."""
        return self in (Outcome.OK, Outcome.COLLAPSE)

    @property
    def is_failure(self) -> bool:
        """Whether there should be an answer and is none; a refusal, out-of-domain, says why."""
        return not self.is_answer and self is not Outcome.OUT_OF_DOMAIN


_ADVICE = {
    Outcome.OK: "Nothing to do.",
    Outcome.COLLAPSE: "This is an answer: in this model the structure does not survive.",
    Outcome.NOT_CONVERGED: "Take a smaller step or a finer mesh, or look at the state it names.",
    Outcome.INVALID_INPUT: "Correct the input that the message names.",
    Outcome.OUT_OF_DOMAIN: "Take a model whose assumptions cover this, or give the tests it lacks.",
    Outcome.TIMED_OUT: "Allow more time per cell or take a cheaper discretisation.",
    Outcome.CRASHED: "This is a defect of the model: report it with the scenario file.",
}


@dataclass(frozen=True, slots=True)
class Finding:
    """Finding of a model on its own answer: a warning (it still answers) or a refusal.

    Arguments: `subject`, a short key such as ``shear``; `text`, one sentence with the numbers;
    `refusal`, True when the model cannot answer; `remedy`, which model or input to use instead
    (empty: none is known); `number`, the number behind the sentence (V/Vpl = 1.79; None: none);
    `instead`, names of models that answer better (None: none would), of which advice makes the
    remedy when the model is known, see `evidence/advice.py`; `limit` of the number.
    The sentences of the workbench stand in ``findings.toml``, see `finding`.
    """

    subject: str
    text: str
    refusal: bool = False
    remedy: str = ""
    number: float | None = None
    instead: tuple[str, ...] | None = None
    limit: float | None = None

    def __str__(self) -> str:
        return f"{self.text}: {self.remedy}" if self.remedy else self.text

    def taking(self, models: Sequence[str]) -> Finding:
        """The finding with models to take instead as its remedy."""
        return replace(self, remedy=f"take {' or '.join(models)}")

    @property
    def outside(self) -> bool:
        """Whether it warns that the scenario lies outside the domain of the model."""
        return not self.refusal and self.subject not in _NOT_OF_DOMAIN

    @property
    def expects_error(self) -> bool:
        """Whether it warns of the error to expect, which a study that compares measures."""
        return self.subject == ERROR

    def as_dict(self) -> dict[str, Any]:
        """The finding as JSON and tables hold it, by the names of `COLUMNS`."""
        severity = REFUSAL if self.refusal else WARNING
        number = None if self.number is None else float(self.number)
        instead = None if self.instead is None else list(self.instead)
        values = (self.subject, severity, self.text, self.remedy, number, self.limit, instead)
        return dict(zip(COLUMNS, values, strict=True))

    @classmethod
    def from_dict(cls, stored: Mapping[str, Any]) -> Finding:
        """The finding that `as_dict` gave."""
        subject, severity, text, remedy, number, limit, instead = (stored[n] for n in COLUMNS)
        instead = None if instead is None else tuple(instead)
        return cls(subject, text, severity == REFUSAL, remedy, number, instead, limit)


PEAK, RESIDUAL = "peak_displacement", "residual_displacement"  # whose error is measured
COVERAGE = 0.90  # share of true values inside an interval


@dataclass(frozen=True, slots=True)
class ExpectedError:
    """The error of an answer, answer over truth less one, as far as it is known.

    Arguments: `anchor`, its name; `expected` error with the ends `low` and `high` of an interval of
    90 % (-1: of a collapse); `chance` of an error beyond 10 %, or that the structure does what the
    answer denies, and how much of it is `unsafe`: an answer too small; `collapse`, chance that the
    structure collapses; `near_collapse`, whether the anchor nearly does; `cell` in which this was
    measured on `count` scenarios; `reason`, why there is no interval (empty: there is one);
    `residual`, ends (m) of 90 % for the true residual displacement, if known.
    Near a collapse that was not drawn `high` alone is known.
    """

    anchor: str
    expected: float | None = None
    low: float | None = None
    high: float | None = None
    chance: float | None = None
    unsafe: float | None = None
    collapse: float | None = None
    near_collapse: bool = False
    cell: str = ""
    count: int = 0
    reason: str = ""
    residual: tuple[float, float] | None = None

    @property
    def warns(self) -> bool:
        """Whether the loss to expect is large: too small an answer costs more than too large."""
        return self.chance is not None and loss_of(self.chance, self.unsafe or 0.0) > WARNED

    def __str__(self) -> str:
        if self.high is not None and self.low is None:
            return f"at most {round(100.0 * self.high):+d} %; of the displacement {self.reason}"
        if self.expected is None or self.low is None or self.high is None:
            chance = 100.0 * (self.collapse or 0.0)
            more = "" if self.collapse is None else f", chance of collapse {chance:.0f} %"
            return f"{self.reason}{more}"
        middle, *ends = (round(100.0 * share) for share in (self.expected, self.low, self.high))
        if self.low <= -1.0:
            return f"at most {ends[1]:+d} %, or collapse: {round(100.0 * (self.collapse or 0.0))} %"
        return f"expect {middle:+d} %, 90 %: {ends[0]:+d} to {ends[1]:+d} %"


def loss_of(chance: Any, unsafe: Any) -> Any:
    """Loss to expect by the `chance` of an error beyond 10 % and its `unsafe` part, any shape."""
    return unsafe + TOO_LARGE * (chance - unsafe)


def finding(
    name: str,
    /,
    number: float | None = None,
    subject: str = "",
    refusal: bool | None = None,
    parts: Sequence[str] = (),
    **values: Any,
) -> Finding:
    """The finding of this `name` in ``findings.toml``, its sentence filled with the `values`.

    Arguments: the `number` behind it, which the sentence may show too; `subject` and `refusal`,
    where they depend on the values; `parts` of the sentence that not every case has, in order.
    Raises KeyError for a name or value that is missing.
    """
    entry = _sentences()[name]
    known = {"number": number, **values}
    limit, instead = entry.get("limit"), entry.get("instead")
    sentence = "".join((entry["sentence"], *map(entry.get("parts", {}).__getitem__, parts)))
    return Finding(
        subject or entry.get("subject", name),
        sentence.format_map(known),
        entry.get("refusal", False) if refusal is None else refusal,
        entry.get("remedy", "").format_map(known),
        None if number is None else float(number),
        None if instead is None else tuple(instead),
        float(known[limit]) if isinstance(limit, str) else limit,
    )


@cache
def _sentences() -> dict[str, dict[str, Any]]:
    """The table of findings, read once."""
    text = Path(__file__).with_name("findings.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)
