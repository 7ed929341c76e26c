"""Validation by measured impacts: bias, scatter and coverage of every model over tests.

Bias and scatter are those of test over prediction with the effect of campaigns, by the statistics
that judge the strength of studs; coverage is the share of tests inside the stated interval of the
comparison, numerical and measurement, with its exact binomial interval.
"""

from collections.abc import Iterator, Sequence
from math import nan, sqrt

import pandas as pd

from workbench.base.errors import InputError, SolverError
from workbench.responses import attribute, is_synthetic
from workbench.responses.uncertainty import DATA_WIDTHS, INPUT_WIDTHS, uncertainty_of
from workbench.study.assessment import METRICS
from workbench.study.comparisons import CaseAnswers, compare
from workbench.study.definition import Study, holds_data
from workbench.study.tables import Row, counts, numbers, tabled, texts

VALIDATION_COLUMNS = (
    texts("model", "against", "quantity")
    | counts("tests", "campaigns")
    | numbers("bias", "low", "high", "scatter", "measurement", "inputs", "least")
    | texts("worst")
    | counts("covered", "counted")
    | numbers("coverage_low", "coverage_high")
    | counts("synthetic")
)
CONFIDENCE = 0.95
_TWO_SIDED = 1.96  # standard deviations in a half-width that holds 95 %
MEASURED = "measured"  # name of the model that answers with tests


@tabled(VALIDATION_COLUMNS)
def validation(study: Study, answers: Sequence[CaseAnswers]) -> Iterator[Row]:
    """A row for every model, measured side and quantity; none where nothing was measured."""
    sides = [label for label, model in study.models.items() if model.name == MEASURED]
    for against in sides:
        given = [each for each in answers if each.ok(against) is not None]
        synthetic = any(is_synthetic(each.responses[against]) for each in given)
        for model in (name for name in study.models if not holds_data(study.models[name])):
            for quantity in study.quantities:
                pairs = [p for each in given if (p := _pair(each, model, against, quantity))]
                if pairs:
                    row = {"model": model, "against": against, "quantity": quantity}
                    yield {**row, **_metrics(pd.DataFrame(pairs)), "synthetic": int(synthetic)}


def _pair(answers: CaseAnswers, model: str, against: str, quantity: str) -> Row | None:
    """A test and what a model says: SI, relative half-widths of the test and of the comparison."""
    try:
        compared = compare(answers, model, against, quantity, METRICS["relative_error"])
    except InputError:
        return None  # one side has no such number
    test, prediction = compared.against_value, compared.value
    if test is None or prediction is None or min(test, prediction) <= 0.0:
        return None
    measured = answers.responses[against]
    width = attribute(measured, DATA_WIDTHS)[quantity]
    row = {"campaign": attribute(measured, "data")["campaign"], "specimen": answers.case.name}
    inputs: float | None = 0.0
    if INPUT_WIDTHS in answers.responses[model].attrs:
        inputs = uncertainty_of(answers.responses[model], quantity, INPUT_WIDTHS)
    row |= {"test": test, "prediction": prediction, "measurement": width / test}
    row |= {"inputs": nan if inputs is None else inputs / prediction}
    return {**row, "error": compared.error, "uncertainty": compared.uncertainty}


def _metrics(pairs: pd.DataFrame) -> Row:
    from scipy.stats import binomtest

    from workbench.studs.fit_protocol import judge

    known = pairs.dropna(subset="uncertainty")
    covered = int((known["error"].abs() <= known["uncertainty"]).sum())
    parts = {name: sqrt((pairs[name] ** 2).mean()) for name in ("measurement", "inputs")}
    row: dict[str, object] = {
        "tests": len(pairs),
        "campaigns": pairs["campaign"].nunique(),
        **{name: rms / _TWO_SIDED for name, rms in parts.items()},
        "covered": covered,
        "counted": len(known),
    }
    if len(known):
        share = binomtest(covered, len(known)).proportion_ci(CONFIDENCE, method="exact")
        row |= {"coverage_low": float(share.low), "coverage_high": float(share.high)}
    tests, predictions = (pairs[name].to_numpy(float) for name in ("test", "prediction"))
    try:
        judged = judge(pairs[["campaign", "specimen"]], tests, predictions, CONFIDENCE)
    except SolverError:
        return row  # the profile of the bias cannot be followed: no interval, no number
    row |= {name: judged.summary[name] for name in ("scatter", "low", "high")}
    row |= {"bias": judged.summary["test_over_prediction"]}
    row |= {"least": judged.summary["least_test_over_prediction"]}
    row["worst"] = pairs["specimen"].iloc[int(pairs["error"].abs().argmax())]
    return row
