"""Mistakes in a study are found when it is loaded, before a cell runs."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan
from typing import Any

import pytest
from toy_models import Spring

from workbench.base.errors import InputError
from workbench.scenarios import ColumnImpact
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

GATE = Gate("b", "a", "peak_displacement", "relative_error", 0.05, "why", "where")
FIGURE = Figure("history", "history", "title", "caption")


@pytest.fixture
def study(thesis_impact: ColumnImpact) -> Study:
    return Study(
        name="plain",
        title="title",
        question="question",
        cases=(Case("one", thesis_impact),),
        models={"a": Spring(), "b": Spring(error=0.1)},
        reference="a",
        gates=(GATE,),
        figures=(FIGURE,),
    )


@pytest.mark.parametrize(
    ("field", "change"),
    [
        ("study.name", {"name": "../elsewhere"}),
        ("study.quantities", {"quantities": ("peak_dsplacement",)}),
        ("study.models", {"models": {"a": Spring(), "b" * 200: Spring()}, "gates": ()}),
        ("study.gates", {"gates": ("within 5 %",)}),
        ("study.figures", {"figures": (GATE,)}),
        ("gate.quantity", {"gates": (replace(GATE, quantity="peek"),)}),
        *(
            ("gate.bound", {"gates": (replace(GATE, bound=bound),)})
            for bound in (nan, inf, 0.0, -0.05, "5 %")
        ),
        ("figure.key", {"figures": (FIGURE, FIGURE)}),
        ("figure.key", {"figures": (replace(FIGURE, key="a/../b"),)}),
        ("figure.key", {"figures": (replace(FIGURE, key=""),)}),
    ],
)
def test_a_mistake_is_named_with_its_field(study: Study, field: str, change: Any) -> None:
    with pytest.raises(InputError, match=field):
        replace(study, **change)


@pytest.mark.parametrize(
    ("field", "change"),
    [
        ("case.name", {"name": "x" * 121}),
        ("case.name", {"name": " "}),
        ("case.parameters", {"parameters": {"": 1.0}}),
        ("case.parameters", {"parameters": {"velocity": nan}}),
    ],
)
def test_a_case_that_cannot_be_meant_is_refused(study: Study, field: str, change: Any) -> None:
    with pytest.raises(InputError, match=field):
        replace(study, cases=(replace(study.cases[0], **change),))


def test_a_near_miss_is_helped(study: Study) -> None:
    with pytest.raises(InputError, match="peak_displacement"):
        replace(study, quantities=("peak_dsplacement",))
