"""The terms of an error budget, how they add up, and where the model form was measured."""

from __future__ import annotations

from dataclasses import replace
from math import exp, inf, log, sqrt

import numpy as np
import pytest
from scipy import stats
from toy_models import Spring, Troubled

from workbench.assessment.budget import (
    COVERAGE,
    MODEL_FORM,
    NUMERICAL,
    PEAK,
    RANGES,
    RATE,
    REFERENCE,
    RESIDUAL,
    TABLE,
    TOTAL,
    Term,
    Trend,
    model_form,
    numerical_term,
    together,
    varied_term,
)
from workbench.assessment.variations import (
    MILD_STEEL,
    SPREADS,
    Budget,
    rate_factor,
    strain_rate,
)
from workbench.errors import InputError
from workbench.evidence import load
from workbench.evidence.descriptors import descriptors
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.references.fiber_reissner import FiberReissner
from workbench.references.solid import SolidPlaneStress
from workbench.responses import build_response
from workbench.scenarios import ColumnImpact, ColumnPushover


def test_shifts_add_scatters_combine_as_squares_and_pulls_add_in_full() -> None:
    bias = Term("bias", "", "", 0.4, 0.3, 0.3)
    input_ = Term("input", "", "", 0.0, 0.4, 0.1)
    pull = Term("pull", "", "", 0.0, 0.2, 0.0, pulls=True)
    total = together("total", [bias, input_, pull])
    assert total.shift == 0.4
    assert total.below == pytest.approx(0.5 + 0.2)
    assert total.above == pytest.approx(sqrt(0.1))
    assert total.low == pytest.approx(exp(0.4 - 0.7) - 1.0)
    assert total.high == pytest.approx(exp(0.4 + sqrt(0.1)) - 1.0)


def test_a_sum_names_what_it_lacks() -> None:
    unknown = Term("model form", "not measured", "", 0.0, None, None)
    total = together("total", [unknown, Term("input", "", "", 0.0, 0.1, 0.1)])
    assert total.lacks == ("model form",)
    assert total.above == pytest.approx(0.1)
    assert unknown.as_dict(0.2)["low"] is None
    assert total.as_dict(0.2)["most"] == pytest.approx(0.2 * exp(0.1))


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
    assert len(runs) == 2 * len(SPREADS) + 1
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


def test_the_rate_is_that_of_the_hinges(thesis_impact: ColumnImpact) -> None:
    assert rate_factor(MILD_STEEL[0]) == 2.0
    shared = 1500.0 / (1500.0 + thesis_impact.column.properties.impact_mass)
    assert strain_rate(thesis_impact) == pytest.approx(0.25 * 15.0 * shared / 0.8)


def test_the_terms_of_an_answer(thesis_impact: ColumnImpact) -> None:
    model, budget = Spring(), Budget("", ())
    runs = {name: model.simulate(each) for name, each in budget.variations(thesis_impact).items()}
    found = budget.terms(model, thesis_impact, model.simulate(thesis_impact), runs)
    terms = {term.name: term for term in found[PEAK]}
    assert list(terms)[:2] == [NUMERICAL, MODEL_FORM]
    assert list(terms)[-1] == RATE  # a toy was measured nowhere: no sum of what is left
    assert terms["velocity ±5 %"].high == pytest.approx(0.05)
    assert terms["mass ±5 %"].low == pytest.approx(sqrt(0.95) - 1.0)
    assert terms[RATE].low == 0.0
    del runs["rate"]
    runs["velocity +5 %"] = Troubled("collapse").simulate(thesis_impact)
    broken = budget.terms(model, thesis_impact, model.simulate(thesis_impact), runs)[PEAK]
    assert broken[2].high == inf
    assert not broken[-1].known
    fallen = Troubled("collapse").simulate(thesis_impact)
    assert budget.terms(model, thesis_impact, fallen, runs) == {}


def test_sums_need_a_model_form_that_was_measured(thesis_impact: ColumnImpact) -> None:
    """Else the best reference was where the answer is, to 0.0 %."""
    fast, budget = thesis_impact.at_velocity(60.0), Budget("", ())
    names = {}
    for hit in (thesis_impact, fast):
        answer = Spring().simulate(hit)
        terms = budget.terms(FourDof(), hit, answer, {})[PEAK]
        names[hit] = [term.name for term in terms[-2:]]
    assert names[thesis_impact] == [REFERENCE, TOTAL]
    assert not {REFERENCE, TOTAL} & set(names[fast])


@pytest.mark.parametrize(("left", "told"), [(0.02, True), (0.0099, False)])
def test_residuals_far_below_the_peak_have_no_budget(thesis_impact, left, told) -> None:
    """Below a tenth of the peak, 0.1 m, their ratios say nothing."""
    answer = build_response({"peak_displacement": 0.1, "residual_displacement": left})
    found = Budget("", ()).terms(Spring(), thesis_impact, answer, {})
    assert set(found) == ({PEAK, RESIDUAL} if told else {PEAK})


def test_a_trend_predicts_as_a_regression_does() -> None:
    x = np.array([1.0, 1.2, 1.5, 1.9, 2.4, 3.0])
    y = np.array([-0.20, -0.22, -0.41, -0.55, -0.80, -1.02])
    line = stats.linregress(x, y)
    rest = y - line.intercept - line.slope * x
    scatter, spread = sqrt(rest @ rest / 4), sqrt(np.sum((x - x.mean()) ** 2))
    trend = Trend(6, exp(y.mean()), line.slope, scatter, float(x.mean()), spread)
    assert trend.expected(2.0) == pytest.approx(line.intercept + 2.0 * line.slope)
    quantile = stats.t.ppf(0.5 + 0.5 * COVERAGE, 4)
    away = (2.0 - x.mean()) ** 2 / spread**2
    assert trend.half_width(2.0) == pytest.approx(quantile * scatter * sqrt(1 + 1 / 6 + away))


def test_models_without_shear_are_far_off_where_webs_yield(thesis_impact: ColumnImpact) -> None:
    off = {model: model_form(model, thesis_impact, PEAK) for model in (FourDof(), FiberReissner())}
    for term in off.values():
        assert 0.3 < (term.low or 0.0) < exp(term.shift) - 1.0 < (term.high or 0.0) < 1.2
    panels = model_form(FourDofShear(), thesis_impact, PEAK)
    assert -0.3 < (panels.low or 0.0) < 0.0 < (panels.high or 0.0) < 0.2
    assert "study shear_columns" in panels.source
    # the number of meshes behind an answer changes none of it
    assert model_form(FiberReissner(levels=2), thesis_impact, PEAK).known


def test_nothing_is_said_of_what_was_not_measured(thesis_impact: ColumnImpact) -> None:
    assert not model_form(FourDof(alpha=1.0), thesis_impact, PEAK).known
    assert not model_form(SolidPlaneStress(), thesis_impact, PEAK).known
    fast = model_form(FourDof(), thesis_impact.at_velocity(60.0), PEAK)
    assert not fast.known
    assert "velocity_over_plastic" in fast.reason
    quick = thesis_impact.at_velocity(24.0)
    light = replace(quick, striker=replace(quick.striker, mass=100.0))
    assert not model_form(FourDof(), light, PEAK).known


def test_the_tables_fit_the_program(thesis_impact: ColumnImpact) -> None:
    assert list(load(RANGES)["descriptor"]) == list(descriptors(thesis_impact))
    rows = load(TABLE)
    assert (rows["count"] >= 6).all()
    # intervals of 90 % hold what they were not made of
    assert 0.85 < rows["held_out"].sum() / rows["count"].sum() < 0.95
    assert set(rows["model"]) >= {"four-dof", "four-dof-shear", "fiber-reissner", "fiber-shear"}
    assert log(rows["bias"].min()) > -1.0
