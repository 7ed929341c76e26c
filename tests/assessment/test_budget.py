"""The terms of an error budget, and how they add up."""

from __future__ import annotations

import json
from dataclasses import replace
from math import exp, expm1, inf, sqrt

import pytest
from toy_models import Spring, Troubled

from workbench.base.errors import InputError
from workbench.models.references.fiber_beams import FiberReissner
from workbench.models.strain_rate import with_rate
from workbench.responses import PEAK, RESIDUAL, build_response
from workbench.scenarios import ColumnImpact, ColumnPushover
from workbench.steel.materials import GRADES, CowperSymonds
from workbench.study.assessment.gates import (
    MODEL_FORM,
    NUMERICAL,
    RATE,
    REFERENCE,
    TOTAL,
    Term,
    numerical_term,
    together,
    varied_term,
)
from workbench.study.assessment.variations import (
    RATED,
    SPREADS,
    STATIC,
    Budget,
    rate_law,
)


def test_shifts_add_and_widths_combine_as_squares() -> None:
    bias = Term("bias", "", "", 0.4, 0.3, 0.3)
    input_ = Term("input", "", "", 0.0, 0.4, 0.1)
    total = together("total", [bias, input_])
    assert total.shift == 0.4
    assert total.below == pytest.approx(0.5)
    assert total.above == pytest.approx(sqrt(0.1))
    assert total.low == pytest.approx(exp(0.4 - 0.5) - 1.0)
    assert total.high == pytest.approx(exp(0.4 + sqrt(0.1)) - 1.0)


def test_what_is_unknown_has_no_ends() -> None:
    unknown = Term("model form", "not measured", "", 0.0, None, None)
    assert not unknown.known
    assert unknown.as_dict(0.2)["low"] is None
    input_ = together("total", [Term("input", "", "", 0.0, 0.1, 0.1)])
    assert input_.as_dict(0.2)["most"] == pytest.approx(0.2 * exp(0.1))


def test_a_numerical_term_is_its_half_width() -> None:
    term = numerical_term(0.2, 0.01)
    assert (term.low, term.high) == (pytest.approx(-0.05), pytest.approx(0.05))
    assert not numerical_term(0.2, None).known
    assert not numerical_term(0.2, 0.3).known


def test_a_varied_input_may_end_in_a_collapse_or_without_an_answer() -> None:
    assert varied_term("v", 0.2, (0.1, inf), "").high == inf
    assert not varied_term("v", 0.2, (0.1, None), "").known
    same_side = varied_term("v", 0.2, (0.21, 0.22), "")
    assert same_side.low == 0.0
    assert same_side.high == pytest.approx(0.1)


def test_an_input_is_varied_with_all_that_hangs_on_it(thesis_impact: ColumnImpact) -> None:
    runs = Budget("", ()).variations(thesis_impact)
    assert len(runs) == 2 * len(SPREADS) + 1 + 2 * len(SPREADS) + 2  # the real column, both ends
    real = runs[f"{RATED}, yield_stress +5 %"].column
    assert real.steel.rate == runs[RATED].column.steel.rate == GRADES["S355"][1]
    assert real.steel.yield_stress == pytest.approx(1.05 * 355e6)
    strong, given = runs["yield_stress +5 %"].column, thesis_impact.column
    assert strong.steel.yield_stress == pytest.approx(1.05 * given.steel.yield_stress)
    assert strong.plastic_moment == pytest.approx(1.05 * (given.plastic_moment or 0.0))
    assert strong.squash_load == pytest.approx(1.05 * (given.squash_load or 0.0))
    assert strong.area == given.area
    free = replace(thesis_impact, column=replace(given, restraint_stiffness=0.0))
    assert not [name for name in Budget("", ()).variations(free) if "restraint" in name]
    wide = Budget("", (), {"velocity": 0.2, "mass": 0.0}).variations(thesis_impact)
    assert wide["velocity -20 %"].striker.velocity == pytest.approx(12.0)
    assert not [name for name in wide if name.startswith("mass")]


def test_bad_spreads_and_other_scenarios_are_refused(thesis_impact: ColumnImpact) -> None:
    with pytest.raises(InputError, match="velocity"):
        Budget("", (), {"velocty": 0.1})
    with pytest.raises(InputError, match=r"spread\.mass"):
        Budget("", (), {"mass": -0.1})
    push = ColumnPushover("push", thesis_impact.column, 0.1)
    with pytest.raises(InputError, match="column-impact alone"):
        Budget("", ()).variations(push)


def test_what_is_open_is_the_sensitivity_of_the_steel(thesis_impact: ColumnImpact) -> None:
    """Without a law that of the grade with the nearest yield stress; with one its D alone."""
    assert rate_law(thesis_impact) == GRADES["S355"][1]
    runs = Budget("", ()).variations(thesis_impact)
    names = (RATED, f"{RATED}, rate slow", f"{RATED}, rate fast")
    laws = [runs[name].column.steel.rate for name in names]
    assert [law.reference_rate for law in laws if law] == [500.0, 100.0, 7000.0]
    assert "rate slow" not in runs  # the static yield stress has no D
    measured = with_rate(thesis_impact, CowperSymonds(40.4, 5.0))
    assert not [name for name in Budget("", ()).variations(measured) if "rate" in name]
    graded = with_rate(thesis_impact, GRADES["S235"][1])
    assert RATED not in Budget("", ()).variations(graded)
    runs = {
        name: answered(graded, peak) for name, peak in (("rate slow", 0.09), ("rate fast", 0.12))
    }
    term = {t.name: t for t in Budget("", ()).terms(graded, answered(graded), runs)[PEAK]}[RATE]
    assert (term.shift, term.low) == (0.0, pytest.approx(-0.1))
    assert term.high == pytest.approx(0.2)
    answer = answered(measured)
    term = {t.name: t for t in Budget("", ()).terms(measured, answer, {})[PEAK]}[RATE]
    assert not term.known
    assert "D_range" in term.reason


def answered(scenario: ColumnImpact, peak: float = 0.1, **scalars: float):
    """An answer that is told to be 20 % low, from -28 to -4 %."""
    answer = build_response({PEAK: peak, **scalars})
    error = {"anchor": "a", "expected": -0.2, "low": -0.28, "high": -0.04, "chance": 0.9}
    error |= {"near_collapse": False, "cell": "cell", "count": 90, "reason": ""}
    answer.attrs["error"] = json.dumps(error)
    return answer


def test_the_terms_of_an_answer(thesis_impact: ColumnImpact) -> None:
    model, budget = Spring(), Budget("", ())
    real = with_rate(thesis_impact, GRADES["S355"][1])
    runs = {name: model.simulate(each) for name, each in budget.variations(real).items()}
    answer = model.simulate(real)
    answer.attrs["error"] = answered(real).attrs["error"]
    for name, share in (("rate slow", 0.7), ("rate fast", 0.9)):
        runs[name] = answered(real, share * float(answer[PEAK]))
    terms = {term.name: term for term in budget.terms(real, answer, runs)[PEAK]}
    assert list(terms)[:2] == [NUMERICAL, MODEL_FORM]
    assert list(terms)[-3:] == [RATE, REFERENCE, TOTAL]
    assert terms["velocity ±5 %"].high == pytest.approx(0.05)
    assert terms["mass ±5 %"].low == pytest.approx(sqrt(0.95) - 1.0)
    assert (terms[RATE].low, terms[RATE].high) == (pytest.approx(-0.3), 0.0)
    form, total = terms[MODEL_FORM], terms[TOTAL]
    assert expm1(form.shift) == pytest.approx(1.0 / 0.8 - 1.0)
    assert (form.low, form.high) == (pytest.approx(1.0 / 0.96 - 1), pytest.approx(1.0 / 0.72 - 1))
    assert (terms[REFERENCE].low, terms[REFERENCE].high) == (form.low, form.high)
    assert total.low < form.low
    assert total.shift == form.shift  # the range of D moves nothing
    assert RATE not in {t.name for t in budget.terms(thesis_impact, answer, runs)[PEAK]}


def test_the_real_column_stands_beside_the_static_yield_stress(thesis_impact: ColumnImpact) -> None:
    """Two budgets, each with an answer, a model form and inputs of its own; D once."""
    budget = Budget("", ())
    peaks = {RATED: 0.08, f"{RATED}, rate slow": 0.07, f"{RATED}, rate fast": 0.09}
    peaks[f"{RATED}, velocity +5 %"] = 0.1
    runs = {
        name: answered(each, peaks.get(name, 0.08 if name.startswith(RATED) else 0.1))
        for name, each in budget.variations(thesis_impact).items()
    }
    rows = list(budget.rows(thesis_impact, answered(thesis_impact), runs))
    assert list(dict.fromkeys(row["form"] for row in rows)) == [RATED, STATIC]
    real, static = ({r["term"]: r for r in rows if r["form"] == form} for form in (RATED, STATIC))
    assert (real[TOTAL]["value"], static[TOTAL]["value"]) == (0.08, 0.1)
    assert set(real) - set(static) == {RATE}
    assert real[RATE]["least"] == pytest.approx(0.07)
    assert real["velocity ±5 %"]["most"] == pytest.approx(0.1)
    assert static["velocity ±5 %"]["most"] == pytest.approx(0.1)
    assert real[MODEL_FORM]["most"] == pytest.approx(0.08 / 0.72)
    runs[RATED].attrs["error"] = json.dumps({"anchor": "four-dof", "reason": "not measured here"})
    rows = list(budget.rows(thesis_impact, answered(thesis_impact), runs))
    assert [row["form"] for row in rows if row["term"] == TOTAL] == [STATIC]
    graded = with_rate(thesis_impact, GRADES["S355"][1])
    rows = list(budget.rows(graded, answered(graded), {}))
    assert {row["form"] for row in rows} == {RATED}


@pytest.mark.parametrize("lost", ["rate slow", "mass -5 %", MODEL_FORM])
def test_without_a_part_there_is_no_total(thesis_impact: ColumnImpact, lost: str) -> None:
    model, budget = Spring(), Budget("", ())
    real = with_rate(thesis_impact, GRADES["S355"][1])
    runs = {name: model.simulate(each) for name, each in budget.variations(real).items()}
    answer = answered(real)
    runs.pop(lost, None)
    if lost == MODEL_FORM:
        answer.attrs["error"] = json.dumps({"anchor": "four-dof", "reason": "not measured here"})
    names = {term.name: term for term in budget.terms(real, answer, runs)[PEAK]}
    assert TOTAL not in names
    assert (REFERENCE in names) == (lost != MODEL_FORM)
    assert names[MODEL_FORM].known == (lost != MODEL_FORM)


def test_the_real_column_is_answered_with_its_numerical_uncertainty() -> None:
    """Its variations are differences: references answer them on one mesh."""
    budget, reference = Budget("", ()), FiberReissner(levels=3)
    assert budget.solver(RATED, reference).levels == 3
    assert budget.solver(f"{RATED}, rate slow", reference).levels == 1


def test_a_varied_run_may_collapse(thesis_impact: ColumnImpact) -> None:
    runs = {"velocity +5 %": Troubled("collapse").simulate(thesis_impact)}
    runs["velocity -5 %"] = Spring().simulate(thesis_impact)
    answer = answered(thesis_impact)
    terms = {t.name: t for t in Budget("", ()).terms(thesis_impact, answer, runs)[PEAK]}
    assert terms["velocity ±5 %"].high == inf
    fallen = Troubled("collapse").simulate(thesis_impact)
    assert Budget("", ()).terms(thesis_impact, fallen, runs) == {}


@pytest.mark.parametrize(("left", "stated"), [(0.02, True), (0.0099, False)])
def test_residuals_far_below_the_peak_have_no_budget(thesis_impact, left, stated) -> None:
    """Below a tenth of the peak, 0.1 m, their ratios say nothing."""
    answer = answered(thesis_impact, residual_displacement=left)
    result = Budget("", ()).terms(thesis_impact, answer, {})
    assert set(result) == ({PEAK, RESIDUAL} if stated else {PEAK})
    if stated:  # the error is measured of the peak alone
        assert not result[RESIDUAL][1].known
        assert result[RESIDUAL][1].reason == "not measured of the residual displacement"
        error = json.loads(answer.attrs["error"]) | {"residual": (0.5 * left, 2.0 * left)}
        answer.attrs["error"] = json.dumps(error)
        form = Budget("", ()).terms(thesis_impact, answer, {})[RESIDUAL][1]
        assert (form.low, form.high) == (pytest.approx(-0.5), pytest.approx(1.0))
