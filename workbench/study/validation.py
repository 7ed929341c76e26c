"""Validation by measured impacts: bias, scatter and coverage of every model over tests.

Bias and scatter are those of test over prediction with the effect of campaigns, by the statistics
that judge the strength of studs; coverage is the share of tests inside the stated interval of the
comparison, numerical and measurement, with its exact binomial interval.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np
import pandas as pd

from workbench.assessment import METRICS
from workbench.errors import InputError, SolverError
from workbench.responses import is_synthetic
from workbench.study.comparisons import Answers, compare
from workbench.study.definition import Study, holds_data
from workbench.study.store import Row

VALIDATION_COLUMNS = (
    *("model", "against", "quantity", "tests", "campaigns", "bias", "low", "high", "scatter"),
    *("measurement", "least", "worst", "covered", "counted", "coverage_low", "coverage_high"),
    "synthetic",
)
CONFIDENCE = 0.95
_TWO_SIDED = 1.96  # standard deviations in a half-width that holds 95 %
MEASURED = "measured"  # name of the model that answers with tests


@dataclass(frozen=True)
class _Pair:
    """A test and what a model says: SI, relative half-widths of the test and of the comparison."""

    case: str
    campaign: str
    test: float
    prediction: float
    measured: float
    error: float
    uncertainty: float | None


def validation_rows(study: Study, answers: Sequence[Answers]) -> Iterator[Row]:
    """A row for every model, measured side and quantity; none where nothing was measured."""
    sides = [label for label, model in study.models.items() if model.name == MEASURED]
    for against in sides:
        given = [each for each in answers if each.ok(against) is not None]
        synthetic = any(is_synthetic(each.responses[against]) for each in given)
        for model in (name for name in study.models if not holds_data(study.models[name])):
            for quantity in study.quantities:
                found = [p for each in given if (p := _pair(each, model, against, quantity))]
                if found:
                    row = {"model": model, "against": against, "quantity": quantity}
                    yield {**row, **_metrics(found), "synthetic": int(synthetic)}


def _pair(answers: Answers, model: str, against: str, quantity: str) -> _Pair | None:
    try:
        found = compare(answers, model, against, quantity, METRICS["relative_error"])
    except InputError:
        return None  # one side has no such number
    test, prediction = found.against_value, found.value
    if test is None or prediction is None or min(test, prediction) <= 0.0:
        return None
    attributes = answers.responses[against].attrs
    width = json.loads(attributes["data_uncertainty"])[quantity]
    campaign = json.loads(attributes["data"])["campaign"]
    numbers = (test, prediction, width / test, found.error, found.uncertainty)
    return _Pair(answers.case.name, campaign, *numbers)


def _metrics(pairs: Sequence[_Pair]) -> Row:
    from scipy.stats import binomtest

    from workbench.studs.fit_protocol import judge

    known = [pair for pair in pairs if pair.uncertainty is not None]
    covered = sum(abs(pair.error) <= (pair.uncertainty or 0.0) for pair in known)
    rms = sqrt(sum(pair.measured**2 for pair in pairs) / len(pairs))
    row: dict[str, object] = {
        "tests": len(pairs),
        "campaigns": len({pair.campaign for pair in pairs}),
        "measurement": rms / _TWO_SIDED,
        "covered": covered,
        "counted": len(known),
    }
    if known:
        share = binomtest(covered, len(known)).proportion_ci(CONFIDENCE, method="exact")
        row |= {"coverage_low": float(share.low), "coverage_high": float(share.high)}
    table = pd.DataFrame([(p.campaign, p.case) for p in pairs], columns=["campaign", "specimen"])
    tests, predictions = (np.array([getattr(p, n) for p in pairs]) for n in ("test", "prediction"))
    try:
        judged = judge(table, tests, predictions, CONFIDENCE)
    except SolverError:
        return row  # the profile of the bias cannot be followed: no interval, no number
    row |= {"bias": judged.bias, "scatter": judged.scatter, "least": judged.least}
    worst = max(pairs, key=lambda pair: abs(pair.error))
    row["worst"] = worst.case
    if judged.interval is not None:
        row |= {"low": judged.interval.low, "high": judged.interval.high}
    return row
