"""The sentence of the first page: what to take, what is nearest, who sees a collapse."""

from __future__ import annotations

from types import SimpleNamespace

import pandas as pd
import pytest
from pages import assessment
from toy_models import Spring

from workbench.models.superelements import FlexibleSuperelement
from workbench.report.chapters.answer import decisive
from workbench.report.chapters.choice import details, first, trusted
from workbench.responses import PEAK, RESIDUAL
from workbench.study import Figure
from workbench.study.assessor import Assessment, CellState
from workbench.study.chooser import MATRIX_COLUMNS, pooled

MODELS = dict.fromkeys(("near", "far", "sure"), Spring()) | {"anchor": FlexibleSuperelement()}
STUDY = SimpleNamespace(ranked=("beam",), groups={"all": ("hit",)}, cases=(), models=MODELS)
REFERENCE = {"label": "beam", "reference": 2, "known": 0.002}


def row(label: str, worst: float | None = None, within: float | None = None, **more) -> dict:
    """A row of the matrix of two cases."""
    values = {**dict.fromkeys(MATRIX_COLUMNS, 0), "group": "all", "label": label, "asked": 2}
    values |= {"quantity": PEAK, "against": "beam", "known": None, f"{RESIDUAL}_within": None}
    values |= {f"{PEAK}_worst": worst, f"{PEAK}_within": within}
    return {**values, f"{PEAK}_count": 0 if worst is None else 2, **more}


def stored_with(*rows: dict, **numbers: float) -> Assessment:
    stored = assessment(STUDY, matrix=rows)
    known = {f"error_{name}": value for name, value in numbers.items()}
    stored.__dict__["cells"] = {("hit", "anchor"): CellState("hit", "anchor", numbers=known)}
    return stored


def wording(*rows: dict, **numbers: float) -> str:
    stored = stored_with(*rows, **numbers)
    (sentence,) = trusted(STUDY, stored, dict.fromkeys(row["group"] for row in rows))
    return sentence.replace("\u2009", " ")


def test_the_nearest_model_is_named_where_none_is_surely_within() -> None:
    beam = row(**REFERENCE)
    near, far = row("near", -0.03), row("far", 0.4, 0.42)
    none = "no model is shown to be within 10 %"
    nearest = "all: nearest is near (off by up to 3 %"
    assert wording(beam, far, near).startswith(f"{nearest}, numerical error not known); {none}")
    near["outside"] = 2  # a model inside its domain comes first
    assert wording(beam, near, far).startswith(f"all: nearest is far (42 %); {none}")
    outside = "outside its domain in 2 of 2, numerical error not known"
    assert wording(beam, near).startswith(f"{nearest}, {outside}); {none}")
    assert wording({**beam, "known": 0.3}, far).endswith("of the reference alone is up to 30 %.")
    sure = row("sure", 0.05, 0.06)
    assert wording(beam, far, sure).startswith("all: sure, peak within 6 % of beam in 2 cases")
    assert first(STUDY, stored_with(beam, far, sure), "all") == "sure"


def test_the_anchor_comes_first_where_it_is_sure_with_the_error_to_expect() -> None:
    beam, sure, anchor = row(**REFERENCE), row("sure", 0.01, 0.02), row("anchor", 0.05, 0.06)
    error = {"expected": -0.03, "low": -0.09, "high": 0.04, "chance": 0.03}
    text = wording(beam, sure, anchor, **error)
    assert text.startswith("all: anchor, peak within 6 % of beam")
    stored = stored_with(beam, sure, anchor, **error)
    more = details(STUDY, stored, "all", anchor).replace("\u2009", " ")
    assert more.startswith("all: against beam. anchor:")
    assert "the error model: expect -3 %, 90 %: -9 to +4 %. Peak within" in more
    assert more.endswith("inside their domain: sure (2 %).")
    assert first(STUDY, stored_with(beam, sure, anchor), "all") == "anchor"
    unmeasured = details(STUDY, stored_with(beam, sure, anchor), "all", anchor)
    assert "expect" not in unmeasured
    assert wording(beam, sure, row("anchor", 0.2, 0.21)).startswith("all: sure")


def test_groups_of_which_the_same_is_to_be_said_share_a_sentence() -> None:
    slow = [row(**REFERENCE), row("sure", 0.05, 0.06)]
    fast = [{**each, "group": "fast"} for each in (slow[0], row("sure", 0.02, 0.03))]
    assert wording(*slow, *fast) == "all; fast: sure, peak within 6 % of beam in 4 cases."
    open_ones = [{**each, "group": "fast"} for each in (slow[0], row("far", 0.4, 0.42))]
    near = row("near", 0.1, 0.11)
    assert wording(slow[0], near, *open_ones).startswith(
        "all; fast: nearest is near (11 %), far (42 %)"
    )


def test_a_group_of_collapses_is_told_by_who_sees_them() -> None:
    beam = row("beam", collapsed=2)
    sees, blind = row("sees", collapsed=2), row("blind", false_safe=2)
    assert wording(beam, sees) == "all: the reference collapses, and so do all that answer."
    assert wording(beam, sees, blind) == "all: the reference collapses; false safe: blind."


def test_two_cases_give_their_ends_and_no_interval() -> None:
    rows = [
        {"value": value, "against_value": 1.0, "uncertainty": 0.01} for value in (0.9, 1.02, 1.1)
    ]
    pairs = pd.DataFrame(rows)
    assert pooled(pairs)["low"] is not None
    two = pooled(pairs[:2])
    assert (two["low"], two["high"]) == (None, None)
    assert (two["least"], two["most"]) == (pytest.approx(0.9), pytest.approx(1.02))


def test_a_picture_that_could_not_be_drawn_is_replaced_by_one_that_was() -> None:
    kinds = {"frame": "structure", "map": "sweep", "path": "interaction"}
    figures = tuple(Figure(key, kind, key, key) for key, kind in kinds.items())
    study = SimpleNamespace(figures=figures, decisive="map")
    assert decisive(study) == decisive(study, {"frame", "map", "path"}) == "map"
    assert decisive(study, {"frame", "path"}) == "path"
    assert decisive(study, {"frame"}) == "frame"
    assert decisive(study, set()) == ""
