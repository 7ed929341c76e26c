"""The error model over drawn columns: cells, coverage and ways to choose, from known errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from toy_models import Spring

from workbench.models.strain_rate import with_rate
from workbench.models.superelements import FlexibleSuperelement
from workbench.responses import Outcome
from workbench.scenarios import ColumnImpact
from workbench.steel.materials import GRADES
from workbench.study import Case, Study
from workbench.study.chooser import CORRECTED, FEWEST, QUICK, SURE, error_tables
from workbench.study.error_model.error_table import COLUMNS, ends_of
from workbench.study.tables import table, texts

COUNT = 60
SCATTER = np.random.default_rng(5).normal(-0.1, 0.05, COUNT)  # ln(anchor / truth)
SECONDS = {"beam": 1.0, "anchor": 0.1, "low": 0.01, "lower": 0.02}


@pytest.fixture(scope="module")
def study(thesis_impact: ColumnImpact) -> Study:
    """Columns in one cell; the reference answers 1 m, one model 20 and one 50 % less."""
    hits = (thesis_impact.at_velocity(14.0 + 0.02 * number) for number in range(COUNT))
    cases = tuple(Case(f"{number}", hit) for number, hit in enumerate(hits))
    models = {"beam": Spring(), "anchor": FlexibleSuperelement()}
    models |= {"low": Spring(stiffness=4e6), "lower": Spring(stiffness=3e6)}
    return Study("drawn", "", "", cases, models, "beam")


def tables_of(
    study: Study, fallen: set[tuple[str, str]] = frozenset(), lower: float = 0.5
) -> dict[str, pd.DataFrame]:
    """Tables of the study; `fallen` cells collapse; what the model `lower` answers."""
    rows = [
        {"case": case.name, "model": label, "against": "beam", "quantity": "peak_displacement"}
        | {"metric": "relative_error", "value": float(value), "against_value": 1.0}
        for case, scatter in zip(study.cases, SCATTER, strict=True)
        for label, value in (("anchor", np.exp(scatter)), ("low", 0.8), ("lower", lower))
        if not {(case.name, label), (case.name, "beam")} & fallen
    ]
    cells = [
        {"case": case.name, "label": label, "wall_time": seconds, "cold": 0}
        | {"outcome": Outcome.COLLAPSE if (case.name, label) in fallen else Outcome.OK}
        for case in study.cases
        for label, seconds in SECONDS.items()
    ]
    references = [{"case": case.name, "label": "beam", "inside": 1} for case in study.cases]
    made = {"comparisons": rows, "cells": cells, "references": references}
    findings = table([], texts("case", "label", "subject"))
    return {name: pd.DataFrame(each) for name, each in made.items()} | {"findings": findings}


def test_a_cell_has_the_order_statistics_of_the_anchor(study: Study) -> None:
    (row,) = error_tables(study, tables_of(study))["error-cells"].to_dict("records")
    errors = np.sort(np.exp(SCATTER) - 1.0)
    low, high = ends_of(COUNT)
    assert row["cell"] == COLUMNS.cell(COLUMNS.features(study.cases[0].scenario))
    assert (row["low"], row["high"]) == pytest.approx((errors[low], errors[high]))
    assert row["median"] == pytest.approx(np.median(errors))
    assert row["off"] == np.count_nonzero(np.abs(errors) > 0.1)
    assert (row["count"], row["warned"], row["collapses"]) == (COUNT, 1, 0)
    assert (row["anchor"], row["reference"]) == ("anchor", "beam")
    first, last = ends_of(COUNT - 1)  # of the others: the case itself is none of them
    assert 0.85 * COUNT <= row["held"] == last - first < COUNT


def test_intervals_hold_alike_for_every_model_and_warn_of_those_that_are_off(study: Study) -> None:
    rows = error_tables(study, tables_of(study))["coverage"].set_index("label")
    assert set(rows["held"]) == {rows.loc["anchor", "held"]}
    assert rows.loc["low", ["answers", "warned", "right", "silent", "apart"]].tolist() == [
        *(COUNT, COUNT, 0, 0, 0)
    ]
    assert rows.loc["anchor", "right"] > 0
    assert rows.loc["low", "width"] > rows.loc["anchor", "width"]  # of a smaller answer


def test_collapse_goes_by_the_anchor(study: Study) -> None:
    fallen = {("1", "low"), *(("2", label) for label in SECONDS), ("3", "beam"), ("4", "anchor")}
    tables = error_tables(study, tables_of(study, fallen))
    rows = tables["coverage"].set_index("label")
    assert rows.loc["low", ["apart", "unseen"]].tolist() == [2, 1]  # 1 told; 3 by nobody
    assert rows.loc["anchor", ["apart", "unseen"]].tolist() == [2, 2]
    assert rows.loc["lower", ["apart", "unseen"]].tolist() == [1, 1]
    assert rows.loc["lower", "warned"] >= 1  # of 4, where it stands and is told to fall
    (cell,) = tables["error-cells"].to_dict("records")
    assert (cell["count"], cell["collapses"]) == (COUNT - 3, 2)


def test_ways_to_choose_by_error_and_cost(study: Study) -> None:
    rows = error_tables(study, tables_of(study))["chooser"].set_index("way")
    given, corrected, sure, quick = (rows.loc[n] for n in ("anchor", CORRECTED, SURE, QUICK))
    errors = np.abs(np.exp(SCATTER) - 1.0)
    assert given["within"] == np.count_nonzero(errors <= 0.1)
    assert np.mean(errors <= given["reach"]) >= 0.9
    assert corrected["within"] > given["within"]
    assert corrected["reach"] < given["reach"]
    assert (sure["within"], sure["reach"]) == (COUNT, 0.0)  # all are warned of
    assert sure["seconds"] == pytest.approx(1.1)
    assert (quick["reach"], quick["seconds"]) == (pytest.approx(0.2), pytest.approx(0.01))
    assert rows["chooses"].sum() == 3
    tables = error_tables(study, tables_of(study, lower=0.95))
    quick = tables["chooser"].set_index("way").loc[QUICK]
    assert (quick["within"], quick["seconds"]) == (COUNT, pytest.approx(0.02))


def test_without_anchor_or_with_few_columns_nothing_is_said(study: Study) -> None:
    few = replace(study, cases=study.cases[: FEWEST - 1])
    tables = tables_of(study)
    few_tables = {
        name: each[~each["case"].isin([c.name for c in study.cases[FEWEST - 1 :]])]
        for name, each in tables.items()
    }
    bare = replace(study, models={n: m for n, m in study.models.items() if n != "anchor"})
    tables["cells"] = tables["cells"][tables["cells"]["label"] != "anchor"]
    for each, of in ((few, few_tables), (bare, tables)):
        assert all(result.empty for result in error_tables(each, of).values())


def test_steel_that_feels_its_rate_is_no_data_of_the_error_model(study: Study) -> None:
    """A study may hit a drawn column once more with a rate law; ratios are of the static one."""
    law = GRADES["S355"][1]
    fast = {case.name for case in study.cases[: COUNT // 3]}
    mixed = replace(
        study,
        cases=tuple(
            replace(case, scenario=with_rate(case.scenario, law)) if case.name in fast else case
            for case in study.cases
        ),
    )
    (row,) = error_tables(mixed, tables_of(mixed))["error-cells"].to_dict("records")
    assert row["count"] == COUNT - len(fast)
