"""Rules and rankings of drawn columns, from tables whose errors are known."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
import pandas as pd
import pytest
from toy_models import Spring

from workbench.evidence.descriptors import FEATURES, features
from workbench.responses import Outcome
from workbench.scenarios import ColumnImpact
from workbench.study import Case, Study
from workbench.study.matrix import COST_COLUMNS
from workbench.study.tables import numbers, table, texts
from workbench.study.validity import (
    advice_rows,
    checked,
    errors_of,
    held_out_of,
    ranking_rows,
    validity_rows,
)

COUNT, BOUND = 60, 14.0  # columns; velocity from which the soft model is 30 % too large


@pytest.fixture(scope="module")
def study(thesis_impact: ColumnImpact) -> Study:
    cases = tuple(
        Case(
            f"{number}",
            thesis_impact.at_velocity(8.0 + 0.2 * number),
            parameters={"part": "unseen" if number % 5 == 4 else "rules"},
        )
        for number in range(COUNT)
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
        "cost": table([], COST_COLUMNS),
    }


def test_rules_find_the_bound_name_the_better_model_and_hold_on_unseen_columns(study) -> None:
    tables, unseen = tables_of(study, {}), held_out_of(study)
    assert len(unseen) == COUNT // 5
    found = validity_rows(study, tables, unseen)
    rows = [row for row in found if row["options"] == "stiffness=4000000.0"]
    assert sum(row["count"] for row in rows) == COUNT - len(unseen)
    off = max(rows, key=lambda row: row["high"])
    assert (off["high"], off["low"]) == (off["count"], 0)
    least = sum(row["high"] for row in rows if row["high"] > 0.5 * row["count"])
    assert least >= sum(row["high"] for row in rows) - 2  # beside the bound
    assert off["bias"] == pytest.approx(1.3)
    assert off["better"] == "toy-spring stiffness=4900000.0"
    bound = [name for name in FEATURES if off[f"{name}_low"] > -inf]
    assert bound
    slow, fast = (
        features(study.cases[0].scenario.at_velocity(BOUND + change)) for change in (-1.0, 8.0)
    )
    for name in bound:
        assert slow[name] < off[f"{name}_low"] < fast[name]
    for row in checked(study, tables, unseen):
        assert row["asked"] == len(unseen)
        assert row["right"] >= row["asked"] - 1


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
    found = errors_of(study, tables_of(study, ends))["good"]
    assert (found["1"], found["2"], found["3"]) == (inf, -inf, 0.0)
    assert found["0"] == pytest.approx(0.02)
    assert found[["4", "5"]].isna().all()


def test_a_reference_outside_its_domain_judges_nobody(study) -> None:
    tables = tables_of(study, {("7", "beam"): Outcome.COLLAPSE})
    references = tables["references"]
    references["inside"] = (~references["case"].isin(["3", "7"])).astype(int)
    found = errors_of(study, tables)
    assert set(found["good"].dropna().index) == {case.name for case in study.cases} - {"3", "7"}


@pytest.mark.parametrize("wrong", [0.6, 1.3])
def test_advice_takes_no_model_that_is_as_far_off_to_either_side(study, wrong: float) -> None:
    tables = tables_of(study, {})
    comparisons = tables["comparisons"]
    comparisons["value"] = comparisons["model"].map({"soft": wrong, "good": 1.09})
    (row,) = advice_rows(study, tables)
    assert (row["label"], row["within"], row["count"]) == ("good", row["count"], 48)
    assert row["right"] == row["asked"] == 12
    rules = {row["options"]: row for row in validity_rows(study, tables, held_out_of(study))}
    soft = rules["stiffness=4000000.0"]
    assert (soft["low"], soft["high"]) == ((48, 0) if wrong < 1.0 else (0, 48))


def test_advice_takes_the_model_that_is_right_most_often_the_cheapest_of_equals(study) -> None:
    slow = [case.name for case in study.cases if case.scenario.striker.velocity <= BOUND]
    tables = tables_of(study, {(name, "good"): Outcome.OUT_OF_DOMAIN for name in slow})
    first, second = advice_rows(study, tables)
    assert (first["label"], second["label"]) == ("soft", "good")
    assert first["count"] + second["count"] == COUNT - COUNT // 5
    assert first["asked"] + second["asked"] == COUNT // 5
    for row in (first, second):  # some beside the bound
        assert row["within"] >= row["count"] - 2
        assert row["right"] >= row["asked"] - 1
    assert "below" in first["region"]
    assert second["median"] == pytest.approx(1.02)
    ratios = {"soft": 0.1, "good": 0.5}
    for cheaper in ratios:
        cost = pd.DataFrame({"label": ratios.keys(), "ratio": ratios.values()})
        both = tables_of(study, {(case.name, "beam"): Outcome.COLLAPSE for case in study.cases})
        both["cells"]["outcome"] = Outcome.COLLAPSE.value
        (row,) = advice_rows(study, both | {"cost": cost})
        assert (row["label"], row["region"]) == (cheaper, "")
        ratios = {"soft": 0.5, "good": 0.1}
    assert not list(advice_rows(replace(study, cases=study.cases[:4], groups={}), tables))


def test_ranking_counts_pairs_and_leaves_small_groups(study) -> None:
    tables = tables_of(
        study, {("1", "good"): Outcome.COLLAPSE, ("2", "good"): Outcome.OUT_OF_DOMAIN}
    )
    rows = list(ranking_rows(study, tables))
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
    assert (second["high"], second["within"]) == (fast, COUNT - fast)
    assert second["median"] in (1.05, 1.3)
    assert np.isfinite(second["least"])
