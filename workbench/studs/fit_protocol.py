"""Protocol of every fit to tests: parameters with intervals, findings, and unseen tests.

A `Fit` gives a `summary` (one row) and `tables`, and names the `figures` that its tables feed. The
command line, studies, reports and JSON are made of these alone.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pandas as pd

from workbench.base.errors import InputError
from workbench.responses import Finding, finding
from workbench.studs.statistics.intervals import (
    Interval,
    outliers,
    profile_interval,
    scatter_intervals,
)
from workbench.studs.statistics.mixed import LEAST_CAMPAIGNS, Estimate, fit, location
from workbench.studs.tables import RowIdentity, identity_of

Summary = dict[str, Any]  # one row of a table: numbers, words and flags by column
Tables = dict[str, pd.DataFrame]
# subjects of findings: what may void an answer comes first, what hardly moves it last
_DECISIVE = (
    *("data", "evidence", "fatigue", "outlier", "stud", "tests", "campaigns", "shank"),
    *("range", "bounds", "points", "modulus", "measurement"),
)
_PLACES = {subject: place for place, subject in enumerate(_DECISIVE)}


def ranked(findings: Iterable[Finding]) -> list[Finding]:
    """Findings without repetitions, the decisive ones first."""
    others = _PLACES["bounds"]
    return sorted(dict.fromkeys(findings), key=lambda each: _PLACES.get(each.subject, others))


def plain(value: Any) -> Any:
    """Any nesting of mappings, named tuples, sequences, arrays, frames and numbers as JSON types.

    NaN and infinities become None; a data frame becomes a list of its rows.
    """
    if isinstance(value, pd.DataFrame):
        value = value.to_dict("records")
    elif hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(each) for each in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, str) else value


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


def counted(rows: pd.DataFrame, what: str = "tests") -> Summary:
    """How many rows (`what` they are) of which campaigns, as columns of a summary."""
    return {what: len(rows), "campaigns": ", ".join(sorted(set(rows["campaign"])))}


LITTLE = 0.5  # weight of a test that a loss hardly counts


def outlier_findings(
    estimate: Estimate, rows: pd.DataFrame, shown: Callable[[float], float] = float
) -> Iterator[Finding]:
    """Every test that the others do not expect, and those to which a loss gives little weight.

    `shown` makes of what was fitted what is read.
    """
    names = [f"{c} {s}" for c, s in zip(rows["campaign"], rows["specimen"], strict=True)]
    for row, distance, expected in outliers(estimate):
        value, expected = shown(estimate.problem.y[row]), shown(expected)
        far: Summary = {"distance": abs(distance), "expected": expected}
        yield finding("stud-outlier", distance, test=names[row], value=value, **far)
    weights = estimate.problem.weights
    if len(small := np.flatnonzero(weights < LITTLE)):
        tests = ", ".join(f"{names[row]} ({weights[row]:.2f})" for row in small)
        rest: Summary = {"rest": len(names) - len(small), "all": len(names)}
        yield finding("stud-small-weights", float(len(small)), tests=tests, **rest)


class Parameter(NamedTuple):
    """A fitted parameter, or a standard deviation, and its profile interval (None: open)."""

    value: float
    low: float | None
    high: float | None

    def columns(self, name: str) -> Summary:
        """Its value under a name, and the ends of its interval, as columns of a summary."""
        return dict(zip((name, f"{name}_low", f"{name}_high"), self, strict=True))


@dataclass(frozen=True)
class Fitted:
    """Parameters of an estimate by name; scatter within (`sigma`), between campaigns (`tau`)."""

    estimate: Estimate
    parameters: dict[str, Parameter]
    sigma: Parameter
    tau: Parameter

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
    def scatters(self) -> Summary:
        """Both scatters with their intervals, as columns of a summary."""
        return self.sigma.columns("sigma") | self.tau.columns("tau")

    @property
    def table(self) -> pd.DataFrame:
        """One row per parameter: `parameter`, `value`, `low`, `high`."""
        rows = [{"parameter": n, **each._asdict()} for n, each in self.parameters.items()]
        return pd.DataFrame(rows, columns=["parameter", "value", "low", "high"])


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
        parameters[name] = Parameter(value, *profile)
    ends = scatter_intervals(estimate, confidence)
    sigma, tau = (Parameter(getattr(estimate, n), *ends[n]) for n in ("sigma", "tau"))
    return Fitted(estimate, parameters, sigma, tau)


class Scalar(NamedTuple):
    """A scalar that models are compared by, with its interval over tests (None: not known).

    `width`, its half-width; `ends`, skewed as those of a logarithm are.
    """

    value: float | None
    width: float | None = None
    ends: tuple[float, float] | None = None


@dataclass(frozen=True)
class Judgement:
    """How a prediction meets tests that it has not used.

    `rows`, one per test or curve; `scalars`, what models are compared by; `summary`, all that they
    tell, as one row of a table.
    """

    rows: pd.DataFrame
    scalars: dict[str, Scalar]
    summary: Summary


@dataclass(frozen=True, kw_only=True)
class Fit(ABC):
    """A fit to tests: the `rows` behind it, and what it warns of (`findings`).

    `figures`: kinds of figures that its tables feed.
    """

    rows: pd.DataFrame
    findings: tuple[Finding, ...]
    figures: ClassVar[tuple[str, ...]] = ()

    @cached_property
    def identity(self) -> RowIdentity:
        """The identity of its rows."""
        return identity_of(self.rows)

    @abstractmethod
    def summary(self) -> Summary:
        """The answer, its size and its grade: one row of a table."""

    @abstractmethod
    def tables(self, confidence: float = 0.9) -> Tables:
        """Everything behind the summary (SI); bands at a `confidence`."""

    @abstractmethod
    def judge(self, table: pd.DataFrame, confidence: float = 0.9) -> Judgement:
        """Hold the fit against unseen tests. Raises `InputError` for rows that it has used."""

    @abstractmethod
    def influence(self) -> pd.DataFrame:
        """How every test moves the answer (`influence_of`)."""

    def _repr_html_(self) -> str:
        """Answer, parameters and design values as tables of a notebook, and the findings."""

        def shown(table: pd.DataFrame, header: bool = True) -> str:
            digits = "{:.4g}".format
            return table.to_html(
                header=header, index=False, na_rep="", float_format=digits, border=0
            )

        tables = self.tables()
        parts = [shown(pd.DataFrame(self.summary().items()), header=False)]
        for name in ("parameters", "design"):
            if not tables.get(name, pd.DataFrame()).empty:
                parts.append(f"<p>{name}</p>{shown(tables[name])}")
        parts += [f"<p>{escape(str(each))}</p>" for each in ranked(self.findings)]
        return f"<div><b>{type(self).__name__}</b>{''.join(parts)}</div>"


def answer_tables(
    answer: Summary, tables: Tables, judged: Judgement | None, how: str = "fitted"
) -> Tables:
    """The tables of an answer: its summary is `fit`; judgement and unseen rows where there are any.

    `how`: what the judged prediction is, as it stands or as fitted.
    """
    answered = {"fit": pd.DataFrame([answer]), **tables}
    if judged is not None:
        answered["judgement"] = pd.DataFrame([{"prediction": how, **judged.summary}])
        answered["judged"] = judged.rows
    return answered


@dataclass(frozen=True)
class StudAnswer:
    """The answer to a question: its `tables`, `findings`, how unseen tests judge it, `scalars`.

    `exact`: the scalars are definitions, without uncertainty.
    """

    tables: Tables
    findings: Sequence[Finding] = ()
    judged: Judgement | None = None
    scalars: Mapping[str, float | None] = field(default_factory=dict)
    exact: bool = False


def answer_of(
    fit: Fit, held: pd.DataFrame, confidence: float, how: str = "as fitted", **options: Any
) -> StudAnswer:
    """The answer that a fit is, judged by the rows that are `held` out, if there are any.

    Arguments: `how` as in `answer_tables`; `options` of the judgement. Raises `InputError`.
    """
    judged = None if held.empty else fit.judge(held, confidence, **options)
    tables = answer_tables(fit.summary(), fit.tables(confidence), judged, how)
    return StudAnswer(tables, fit.findings, judged, {"tests_fitted": float(len(fit.rows))})


def stacked(answers: Iterable[tuple[str, Tables]]) -> Tables:
    """The tables of several answers below each other; `of` says which one a row belongs to."""
    parts: dict[str, list[pd.DataFrame]] = {}
    for name, tables in answers:
        for key, table in tables.items():
            parts.setdefault(key, []).append(table.assign(of=name))
    whole = {key: pd.concat(each, ignore_index=True) for key, each in parts.items()}
    return {key: table[["of", *table.columns.drop("of")]] for key, table in whole.items()}


def judge(
    rows: pd.DataFrame, test: Any, prediction: Any, confidence: float = 0.9, *more: str
) -> Judgement:
    """Judge predictions by tests that they have not used: test over prediction.

    Arguments: `rows` with campaign, specimen and the columns `more` that are kept; `test` and
    `prediction` (n,), positive where there is a prediction. The summary has the median ratio with
    its interval `low` to `high`, whose width as a scalar reaches to its farther end, and the
    `scatter` of the log ratio, between campaigns included (None with one test: it tells no
    scatter); the smallest ratio, and `worst`, the test that has it. Where a fit tells them:
    `covered`, share of the tests inside its prediction interval, and `known_campaigns`, campaigns
    that it has seen other specimens of, so that the tests are not independent of it. Raises
    `InputError` without any test that has a prediction.
    """
    judged = rows[["campaign", "specimen", *more]].assign(test=test, prediction=prediction)
    known = np.isfinite(prediction) & (np.asarray(prediction) > 0.0)
    judged = judged[known].reset_index(drop=True)
    if judged.empty:
        raise InputError("validation", 0, "holds no test that the model can answer")
    ratio = judged["test"].to_numpy(float) / judged["prediction"].to_numpy(float)
    judged = judged.assign(ratio=ratio)
    bias, interval, scatter = Scalar(float(ratio[0])), Interval(None, None), None
    if len(ratio) > 1:
        estimate = fit(location(np.log(ratio), judged["campaign"].to_numpy(str)))
        interval = profile_interval(estimate, "median", confidence).exponential()
        scatter = float(np.hypot(estimate.sigma, estimate.tau))
        median, (low, high) = float(np.exp(estimate.theta[0])), interval
        bias = Scalar(median)
        if low is not None and high is not None:
            bias = Scalar(median, max(median - low, high - median), (low, high))
    least = Scalar(float(ratio.min()))
    scalars = {"test_over_prediction": bias, "least_test_over_prediction": least}
    summary = {
        **counted(judged),
        **{name: each.value for name, each in scalars.items()},
        **interval._asdict(),
        "worst": " ".join(judged.loc[int(np.argmin(ratio)), ["campaign", "specimen"]]),
        "scatter": scatter,
        "covered": None,
        "known_campaigns": "",
    }
    return Judgement(judged, scalars, summary)
