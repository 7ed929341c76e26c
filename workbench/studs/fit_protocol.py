"""What every fit to tests is made of: parameters with intervals, findings, and unseen tests.

Strength, factors, load-slip and residual capacity are fitted by functions of their own; all give a
`Fit`, so that the command line, the models of a study and the pages treat them alike.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, is_dataclass
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.responses import Finding
from workbench.studs.statistics.intervals import Interval, profile_interval, scatter_intervals
from workbench.studs.statistics.mixed import Estimate, fit
from workbench.studs.statistics.mixture import LEAST_CAMPAIGNS, Priors
from workbench.studs.statistics.prediction import outliers
from workbench.studs.statistics.problem import location
from workbench.studs.tables import RowIdentity

Content = dict[str, Any]
Ends = tuple[float, float]  # of an interval


def fields_of(value: Any) -> Any:
    """A record (dataclass or named tuple) as the mapping of its fields, anything else as it is."""
    if hasattr(value, "_asdict"):
        return value._asdict()
    return asdict(value) if is_dataclass(value) and not isinstance(value, type) else value


def plain(value: Any) -> Any:
    """Any nesting of mappings, records, sequences, arrays, frames and numbers as JSON types.

    NaN and infinities become None; a data frame becomes a list of its rows.
    """
    if isinstance(value, pd.DataFrame):
        return [plain(row) for row in value.to_dict("records")]
    value = fields_of(value)
    if isinstance(value, Mapping):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(each) for each in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, str) else value


# subjects of findings: what may void an answer comes first, what hardly moves it last
_DECISIVE = (
    *("data", "evidence", "prior", "fatigue", "outlier", "stud", "tests", "campaigns", "shank"),
    *("range", "bounds", "points", "modulus", "measurement"),
)
_PLACES = {subject: place for place, subject in enumerate(_DECISIVE)}


def ranked(findings: Iterable[Finding]) -> list[Finding]:
    """Findings without repetitions, the decisive ones first."""
    others = _PLACES["bounds"]
    return sorted(dict.fromkeys(findings), key=lambda each: _PLACES.get(each.subject, others))


def grade_of(rows: pd.DataFrame, what: str, *, left_out: bool = False) -> str:
    """How well a fit to `what` is supported, by the campaigns of its rows.

    `left_out`: every campaign was predicted from the others.
    """
    if "origin" in rows and (rows["origin"] == "synthetic").any():
        return f"exercise on synthetic {what}: shows the method, is no evidence"
    campaigns = rows["campaign"].nunique()
    if campaigns == 1:
        return f"fitted to {what} of one campaign, not validated on others"
    if campaigns < LEAST_CAMPAIGNS:
        return f"fitted to {what} of two campaigns, too few to validate it"
    how = "cross-validated over campaigns" if left_out else "not cross-validated"
    return f"fitted to {what} of {campaigns} campaigns, {how}"


class Told(NamedTuple):
    """A scalar that models are compared by, with its interval over tests (None: not known).

    `width`, its half-width; `ends`, skewed as those of a logarithm are.
    """

    value: float | None
    width: float | None = None
    ends: Ends | None = None


class Judged(Protocol):
    """How a fit meets tests that it has not used: row by row (`rows`), and what they tell."""

    @property
    def rows(self) -> pd.DataFrame: ...  # noqa: D102

    @property
    def told(self) -> dict[str, Told]: ...  # noqa: D102

    def to_dict(self) -> Content:
        """Everything but the rows."""
        ...


@dataclass(frozen=True, kw_only=True)
class Fit(ABC):
    """A fit to tests: the `rows` behind it, their `identity`, and what it warns of (`findings`)."""

    rows: pd.DataFrame
    findings: tuple[Finding, ...]
    identity: RowIdentity

    @abstractmethod
    def to_dict(self) -> Content:
        """Parameters, intervals, diagnostics: everything but the rows."""

    @abstractmethod
    def judge(self, table: pd.DataFrame, confidence: float = 0.9) -> Judged:
        """Hold the fit against unseen tests. Raises `InputError` for rows that it has used."""

    def parts(self, confidence: float) -> Content:
        """What belongs to the content of the fit beside itself: rows, predictions."""
        return {}

    def influence(self) -> pd.DataFrame:
        """How every test moves the answer (`influence_of`); without rows where none is told."""
        return pd.DataFrame()

    def content(self, judged: Judged | None, confidence: float = 0.9) -> Content:
        """The fit, its parts, and a judgement (or None), for JSON and pages."""
        return {"fit": self.to_dict(), **self.parts(confidence), **judgement_of(judged)}

    def used(self, what: str = "tests") -> Content:
        """What a fit says of the rows behind it; `what`, which they are."""
        return {
            what: len(self.rows),
            "campaigns": sorted(set(self.rows["campaign"])),
            "warnings": [finding.text for finding in ranked(self.findings)],
        }


def outlier_findings(
    estimate: Estimate, rows: pd.DataFrame, shown: Callable[[float], float] = float
) -> Iterator[Finding]:
    """Every test that the others do not expect; `shown` makes of what was fitted what is read."""
    for row, distance, expected in outliers(estimate):
        name = f"{rows['campaign'].iloc[row]} {rows['specimen'].iloc[row]}"
        values = f"{shown(estimate.problem.y[row]):.3g} where the others give {shown(expected):.3g}"
        text = f"outlier: {name}, {values} ({abs(distance):.1f} standard deviations)"
        advice = "check it; --loss huber gives it less weight"
        yield Finding("outlier", f"{text}: {advice}", number=distance)


def prior_findings(priors: Priors) -> Iterator[Finding]:
    """That an answer rests on more than its tests."""
    if priors:
        told = (f"{name} {value:g} ({spread:g})" for name, (value, spread) in priors.items())
        text = f"priors from elsewhere, value and spread: {', '.join(told)}"
        yield Finding("prior", f"{text}; bands and posterior intervals rest on them")


class Parameter(NamedTuple):
    """A fitted parameter and its profile interval."""

    value: float
    profile: Interval


class Scatter(NamedTuple):
    """A standard deviation with its profile interval."""

    value: float
    low: float | None
    high: float | None
    confidence: float
    method: str


@dataclass(frozen=True)
class Fitted:
    """The parameters of an estimate by name; `confidence` of all intervals."""

    estimate: Estimate
    parameters: dict[str, Parameter]
    confidence: float

    @cached_property
    def _scatter(self) -> dict[str, Interval]:
        return scatter_intervals(self.estimate, self.confidence)

    @property
    def sigma(self) -> Scatter:
        """Scatter within campaigns."""
        return Scatter(self.estimate.sigma, *self._scatter["sigma"])

    @property
    def tau(self) -> Scatter:
        """Scatter between campaigns."""
        return Scatter(self.estimate.tau, *self._scatter["tau"])

    @property
    def estimates(self) -> dict[str, float]:
        """Parameters without their intervals."""
        return {name: each.value for name, each in self.parameters.items()}

    @property
    def at_bound(self) -> tuple[str, ...]:
        """Parameters that rest on a bound."""
        names = self.estimate.problem.names
        return tuple(n for n, at in zip(names, self.estimate.at_bound, strict=True) if at)

    @property
    def intervals(self) -> dict[str, Interval]:
        """Profile intervals by parameter."""
        return {name: each.profile for name, each in self.parameters.items()}


def fitted(estimate: Estimate, logarithms: Collection[str] = (), *, confidence: float) -> Fitted:
    """Parameters with profile intervals.

    Arguments: `logarithms`, parameters whose logarithm was fitted; `confidence` of the intervals.
    Raises `SolverError`.
    """
    parameters = {}
    for name in estimate.problem.names:
        value, profile = estimate.parameter(name), profile_interval(estimate, name, confidence)
        if name in logarithms:
            value, profile = float(np.exp(value)), profile.exponential()
        parameters[name] = Parameter(value, profile)
    return Fitted(estimate, parameters, confidence)


@dataclass(frozen=True)
class Judgement:
    """Test over prediction in tests that the prediction has not used.

    `bias`, median ratio with its `interval` (None with one test: it tells no scatter); `least`, the
    smallest ratio, and `worst`, the test that has it; `scatter` of the log ratio, between campaigns
    included (None with one test); `rows`, campaign, specimen, test, prediction and ratio. Where a
    fit tells them: `covered`, share of the tests inside its prediction interval, and
    `known_campaigns`, campaigns that it has seen other specimens of, so that the tests are not
    independent of it.
    """

    bias: float
    interval: Interval | None
    least: float
    worst: str
    scatter: float | None
    rows: pd.DataFrame
    covered: float | None = None
    known_campaigns: tuple[str, ...] = ()

    @property
    def told(self) -> dict[str, Told]:
        """What a model is compared by; the width of the bias reaches to its farther end."""
        low, high = (None, None) if self.interval is None else self.interval[:2]
        bias = Told(self.bias)
        if low is not None and high is not None:
            bias = Told(self.bias, max(self.bias - low, high - self.bias), (low, high))
        return {"test_over_prediction": bias, "least_test_over_prediction": Told(self.least)}

    def to_dict(self) -> Content:
        """Everything but the rows."""
        told = ("interval", "worst", "scatter", "covered", "known_campaigns")
        return {
            "tests": len(self.rows),
            "campaigns": sorted(set(self.rows["campaign"])),
            **{name: each.value for name, each in self.told.items()},
            **{name: getattr(self, name) for name in told},
        }


def judge(
    rows: pd.DataFrame, test: Any, prediction: Any, confidence: float = 0.9, *more: str
) -> Judgement:
    """Judge predictions by tests that they have not used.

    Arguments: `rows` with campaign, specimen and the columns `more` that are kept; `test` and
    `prediction` (n,), positive where there is a prediction. Raises `InputError` without any.
    """
    judged = rows[["campaign", "specimen", *more]].assign(test=test, prediction=prediction)
    known = np.isfinite(prediction) & (np.asarray(prediction) > 0.0)
    judged = judged[known].reset_index(drop=True)
    if judged.empty:
        raise InputError("validation", 0, "holds no test that the model can answer")
    ratio = judged["test"].to_numpy(float) / judged["prediction"].to_numpy(float)
    judged = judged.assign(ratio=ratio)
    bias, interval, scatter = float(ratio[0]), None, None
    if len(ratio) > 1:
        estimate = fit(location(np.log(ratio), judged["campaign"].to_numpy(str)))
        interval = profile_interval(estimate, "median", confidence).exponential()
        scatter = float(np.hypot(estimate.sigma, estimate.tau))
        bias = float(np.exp(estimate.theta[0]))
    worst = " ".join(judged.loc[int(np.argmin(ratio)), ["campaign", "specimen"]])
    return Judgement(bias, interval, float(ratio.min()), worst, scatter, judged)


def judgement_of(judged: Judged | None) -> Content:
    """The content of a judgement (or of None)."""
    if judged is None:
        return {"judgement": None, "judged": None}
    return {"judgement": judged.to_dict(), "judged": judged.rows}
