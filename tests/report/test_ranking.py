"""What the first page advises over many drawn columns."""

from __future__ import annotations

from types import SimpleNamespace

from pages import assessment

from workbench.models.single_dof import SingleDof
from workbench.report.chapters import choice
from workbench.report.drawing.sheet import Request
from workbench.report.drawing.style import Look
from workbench.report.figures import draw
from workbench.report.page.reading import read
from workbench.report.page.terminal import render_text
from workbench.study import Figure
from workbench.study.assessor import Assessment
from workbench.study.chooser import CORRECTED, SURE

FIRST = {
    **{"group": "slow", "label": "panels", "asked": 64, "judged": 60, "within": 50},
    **{"low": 8, "high": 2, "false_alarm": 0, "false_safe": 1, "refused": 4, "median": 0.98},
    **{"least": 0.85, "most": 1.05, "against": "panels", "pairs": 0, "wins": 0, "chance": None},
}
WORSE = {**FIRST, "label": "bars", "against": "panels", "pairs": 58, "wins": 50, "chance": 1e-8}
EQUAL = {**WORSE, "label": "frames", "wins": 30, "chance": 0.45}


def stored(*rows: dict) -> Assessment:
    return assessment(ranking=rows)


def test_it_says_what_to_take_what_to_expect_and_what_is_not_clearly_worse() -> None:
    text = choice.best_ranked([FIRST, WORSE, EQUAL], {"panels": 0.01})
    assert text.startswith(
        "take panels; peak within 10\u2009% in 50 of 60, expect \u22122.0\u2009% ("
    )
    assert "false safe in 1" in text
    assert "no answer in 4" in text
    assert "Not clearly worse (sign test): frames." in text
    assert "bars" not in text
    assert text.endswith("Time: 1/100 of the reference")


CELL = {
    **{"cell": "light strikers", "anchor": "panels", "reference": "beam", "count": 60, "off": 20},
    **{"held": 54, "collapses": 0, "warned": 1, "median": -0.1, "low": -0.2, "high": 0.1},
    "chance": 0.3,
}
WAY = {"chooses": 1, "count": 120, "within": 90, "reach": 0.14, "seconds": 0.1}


def error_model(*cells: dict) -> Assessment:
    ways = [WAY | {"way": "panels"}, WAY | {"way": CORRECTED, "within": 114, "reach": 0.08}]
    coverage = {"label": "bars", "count": 60, "held": 54, "width": 0.3, "answers": 62, "warned": 30}
    coverage |= {"right": 9, "silent": 1, "apart": 2, "unseen": 0}
    rows = {"error-cells": cells, "coverage": [coverage]}
    rows["chooser"] = [*ways, WAY | {"way": SURE, "within": 120}]
    rows["cost"] = [{"label": "panels", "ratio": 0.01}]
    study = SimpleNamespace(models={"panels": SingleDof(resistance="panel", hit_mass="waves")})
    return assessment(study, **rows)


def test_the_first_page_takes_the_anchor_and_says_when_not_and_why() -> None:
    sure = {**CELL, "cell": "heavy strikers", "warned": 0}
    text = " ".join(render_text(choice.anchored(error_model(CELL, sure))).split())
    asked = "single-dof --option resistance=panel --option hit_mass=waves"
    assert f"Take panels (`{asked}`): peak within 10 % on 75 % of 120" in text
    assert "to be off, on 95 %, below 8 %" in text
    assert "Time: 1/100 of the reference." in text
    assert "(light strikers), take beam: together within 10 % on 100 %" in text
    assert "Why: a light striker" in text
    assert "108 of 120" in text
    assert "When not" not in render_text(choice.anchored(error_model(sure)))
    assert not choice.anchored(assessment())


def test_ways_to_choose_are_drawn() -> None:
    stored = error_model(CELL)
    figure = Figure("cost", "chooser", "cost", "cost")
    drawing = draw(Request(stored.study, figure, stored, ("hit",), (), {"panels": Look("k")}))
    assert drawing.data["way"].tolist() == ["panels", CORRECTED, SURE]
    assert drawing.canvas is not None
    stored.tables["chooser"] = stored.tables["chooser"][:0]
    empty = draw(Request(stored.study, figure, stored, ("hit",), (), {}))
    assert empty.statements == ("No drawn scenario has been judged.",)


def test_the_error_model_by_model_and_by_choice() -> None:
    section = choice.error_model(error_model(CELL))
    text = " ".join(render_text(section).split())
    assert "90 of 120" in text
    assert SURE.split(",")[0] in text
    assert not read(choice.error_model(assessment()))


def test_the_table_counts_pairs() -> None:
    section = choice.ranking(stored(FIRST, WORSE, EQUAL))
    text = " ".join(render_text(section).split())
    assert "50 of 60" in text
    assert "50 of 58 pairs (1e-08)" in text
    assert "itself" in text
    assert not read(choice.ranking(stored()))
