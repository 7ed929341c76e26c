"""Errors and rankings of drawn columns, from tables whose errors are known."""

from __future__ import annotations

from math import inf

import numpy as np
import pandas as pd
import pytest
from toy_models import Spring

from workbench.responses import Outcome
from workbench.scenarios import ColumnImpact
from workbench.study import Case, Study
from workbench.study.chooser import errors_of, ranking
from workbench.study.tables import numbers, table, texts

COUNT, BOUND = 60, 14.0  # columns; velocity from which the soft model is 30 % too large


@pytest.fixture(scope="module")
def study(thesis_impact: ColumnImpact) -> Study:
    cases = tuple(
        Case(f"{number}", thesis_impact.at_velocity(8.0 + 0.2 * number)) for number in range(COUNT)
    )
    models = {"beam": Spring(), "soft": Spring(stiffness=4e6), "good": Spring(stiffness=4.9e6)}
    groups = {"all": tuple(case.name for case in cases), "few": ("0", "1")}
    return Study("rules", "Rules", "Where?", cases, models, "beam", groups=groups)


def tables_of(study: Study, ends: dict[tuple[str, str], str]) -> dict[str, pd.DataFrame]:
    """Tables in which "soft" errs by +30 % at fast hits, "good" by 2 %; `ends` of some cells."""
    cells, comparisons = [], []
    for case in study.cases:
        fast = case.scenario.striker.velocity > BOUND
        for label in study.models:
            outcome = ends.get((case.name, label), Outcome.OK)
            cells.append(
                {"case": case.name, "label": label, "outcome": outcome, "model_version": 1}
            )
            answered = {outcome, ends.get((case.name, "beam"), Outcome.OK)} == {Outcome.OK}
            if label != "beam" and answered:
                value = {"soft": 1.3 if fast else 1.05, "good": 1.02}[label]
                comparisons.append(
                    {
                        **{"case": case.name, "model": label, "against": "beam"},
                        **{"quantity": "peak_displacement", "metric": "relative_error"},
                        **{"value": value, "against_value": 1.0},
                    }
                )
    references = [{"case": case.name, "label": "beam", "inside": 1} for case in study.cases]
    compared = texts("case", "model", "against", "quantity", "metric")
    return {
        "cells": pd.DataFrame(cells),
        "comparisons": table(comparisons, compared | numbers("value", "against_value")),
        "references": pd.DataFrame(references),
        "findings": table([], texts("case", "label", "subject")),
    }


def test_collapse_on_one_side_is_an_infinite_error(study) -> None:
    ends = {
        ("1", "good"): Outcome.COLLAPSE,
        ("2", "beam"): Outcome.COLLAPSE,
        ("3", "beam"): Outcome.COLLAPSE,
        ("3", "good"): Outcome.COLLAPSE,
        ("4", "good"): Outcome.OUT_OF_DOMAIN,
        ("5", "beam"): Outcome.COLLAPSE,
        ("5", "good"): Outcome.OUT_OF_DOMAIN,
    }
    result = errors_of(study, tables_of(study, ends))["good"]
    assert (result["1"], result["2"], result["3"]) == (inf, -inf, 0.0)
    assert result["0"] == pytest.approx(0.02)
    assert result[["4", "5"]].isna().all()


def test_a_reference_that_is_outside_or_warns_of_its_numbers_judges_nobody(study) -> None:
    tables = tables_of(study, {("7", "beam"): Outcome.COLLAPSE})
    references = tables["references"]
    references["inside"] = (~references["case"].isin(["3", "7"])).astype(int)
    warnings = [("8", "beam", "mesh"), ("9", "good", "mesh"), ("10", "beam", "restitution")]
    tables["findings"] = pd.DataFrame(warnings, columns=["case", "label", "subject"])
    result = errors_of(study, tables)
    judged = {case.name for case in study.cases} - {"3", "7", "8"}
    assert set(result["good"].dropna().index) == judged


def test_ranking_counts_pairs_and_leaves_small_groups(study) -> None:
    tables = tables_of(
        study, {("1", "good"): Outcome.COLLAPSE, ("2", "good"): Outcome.OUT_OF_DOMAIN}
    )
    rows = ranking(study, tables).to_dict("records")
    assert {row["group"] for row in rows} == {"all"}
    first, second = rows
    assert (first["label"], first["within"], first["false_alarm"], first["refused"]) == (
        "good",
        58,
        1,
        1,
    )
    assert first["pairs"] == 0
    assert (second["against"], second["pairs"], second["wins"]) == ("good", 59, 58)
    assert second["chance"] == pytest.approx(60 / 2**59, rel=0.1)  # 59 fair coins, one head or none
    fast = sum(case.scenario.striker.velocity > BOUND for case in study.cases)
    assert (second["low"], second["high"], second["within"]) == (0, fast, COUNT - fast)
    assert second["median"] in (1.05, 1.3)
    assert np.isfinite(second["least"])
