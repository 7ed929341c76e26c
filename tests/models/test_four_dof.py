"""Four-DOF column: closed forms, kernels against finite differences, ledger, orders, bad input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import THESIS_SPRINGS, Answers
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.mechanics.structures.kernels import solve_four
from workbench.models.four_dof import FourDof, FourDofShear, statics
from workbench.models.superelements import RigidSuperelement
from workbench.responses import (
    Outcome,
    Response,
    collapse_of,
    findings_of,
    outcome_of,
    survives,
    warnings_of,
)
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, Striker
from workbench.steel.hinges import ShearSurface
from workbench.steel.sections import find

ELASTIC = {"plastic_moment": 9e8, "squash_load": 9e9}


def elastic_column(**changes) -> Column:
    values = {
        "section": find("HEB 220"),
        "length_below": 2.0,
        "length_above": 2.0,
        "area": 91e-4,
        "second_moment": 8091e-8,
        **ELASTIC,
    }
    return Column(**{**values, **changes})


@pytest.mark.parametrize(
    ("base", "head", "factor"),
    [
        # beam closed forms for a midspan load, in EI/L^3
        ("clamped", "guided", 192.0),
        ("pinned", "pinned", 48.0),
    ],
)
def test_elastic_stiffness_at_midspan(base: str, head: str, factor: float) -> None:
    column = elastic_column(base=base, head=head)
    response = FourDof(**THESIS_SPRINGS).simulate(ColumnPushover("elastic", column, 1e-5))
    expected = factor * 210e9 * 8091e-8 / 4.0**3
    measured = float(response["force"][-1] / response["displacement"][-1])
    assert measured == pytest.approx(expected, rel=1e-8)  # measured 1.8e-9


def test_one_pinned_end_gives_the_series_of_its_hinges() -> None:
    # bar a: one hinge 3EI/l at the impact point; bar b: 6EI/l at both ends. Moment balance at the
    # impact point and rigid-bar kinematics give k = sum of end stiffnesses / l^2 + middle in series
    column = elastic_column(base="pinned", length_below=1.0, length_above=3.0)
    stiffness = 210e9 * 8091e-8
    low, high, top = 3 * stiffness / 1.0, 6 * stiffness / 3.0, 6 * stiffness / 3.0
    kappa = 1.0 / 1.0 + 1.0 / 3.0
    expected = kappa**2 / (1.0 / low + 1.0 / high) + top / 3.0**2
    response = FourDof(**THESIS_SPRINGS).simulate(ColumnPushover("elastic", column, 1e-5))
    measured = float(response["force"][-1] / response["displacement"][-1])
    assert measured == pytest.approx(expected, rel=1e-8)  # measured 2.4e-9


def test_elastic_impact_matches_the_oscillator() -> None:
    # spec of the closed form: m_c sticks to m_1, amplitude V / omega
    impact = ColumnImpact("soft", elastic_column(), Striker(1500.0, 0.1), 0.03)
    mass, struck = 1500.0, 7850 * 91e-4 * 4.0 / 3.0
    omega = np.sqrt(192.0 * 210e9 * 8091e-8 / 4.0**3 / (mass + struck))
    exact = 0.1 * mass / (mass + struck) / omega
    errors = []
    for step in (4e-4, 2e-4, 1e-4):
        response = FourDof(time_step=step, **THESIS_SPRINGS).simulate(impact)
        errors.append(exact - float(response["displacement"].max()))
    assert np.abs(errors[-1]) < 1.2e-4 * exact  # measured 6.3e-5
    assert exact == pytest.approx(5.260239e-4, rel=2.3e-6)  # measured 1.1e-6


def test_time_of_peak_and_peak_converge_at_least_first_order(thesis_impact) -> None:
    def peak(step: float) -> float:
        model = FourDof(time_step=step, **THESIS_SPRINGS)
        return float(model.simulate(thesis_impact)["peak_displacement"])

    fine = peak(2.5e-6)
    steps = np.array([4e-4, 2e-4, 1e-4])
    errors = [abs(peak(step) - fine) for step in steps]
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope > 0.9
    assert errors[-1] < 1.2e-4 * fine  # measured 6.1e-5


@pytest.mark.parametrize("shift", [4.0, 0.0])
def test_four_equations_are_solved_with_pivots_where_they_need_them(shift: float) -> None:
    rng = np.random.default_rng(1)
    for _ in range(100):
        A, x = rng.standard_normal((4, 4)) + shift * np.eye(4), rng.standard_normal(4)
        if shift == 0.0:
            A[0, 0] = 0.0
        right = A @ x
        assert solve_four(A, right)
        np.testing.assert_allclose(right, x, rtol=1e-9, atol=1e-9)
    assert not solve_four(np.zeros((4, 4)), np.ones(4))


@pytest.mark.parametrize(
    ("small", "sliding"),
    [
        (False, False),
        (True, False),
        (False, True),
    ],
)
def test_tangent_equals_finite_differences_of_the_internal_forces(
    small: bool, sliding: bool
) -> None:
    rng = np.random.default_rng(7)
    column, work = np.zeros(1, statics.COLUMN)[0], np.zeros(1, statics.WORK)[0]
    column["lengths"], column["stiffness"] = (0.8, 1.1), ((2.4e9, 1.27e8, 1.27e8),) * 2
    column["squash_loads"], column["plastic_moments"] = 3.1e6, 2.8e5
    column["alpha"], column["beta"], column["small_rotations"] = 1.0, 1.3, small
    column["flexibility"][:, [0, 1, 3]] = 1.0 / column["stiffness"]
    column["sliding"], column["web"] = sliding, ShearSurface(find("HEB 220")).record
    state = np.zeros(1, statics.STATE)[0]

    def forces(q: np.ndarray) -> np.ndarray:
        state["q"] = q
        statics.internal_forces(column, state, work)
        return work["F"].copy()

    checked = 0
    for _ in range(100):
        at = np.array([0.1, 0.0, 0.0, 0.0]) + rng.normal(size=4) * [0.05, 5e-3, 0.1, 5e-3]
        state["plastic"] = rng.normal(size=(2, 4)) * [1e-2, 0.1, 0.1, 0.05]
        forces(at)
        tangent = work["K"].copy()
        numeric, half = (
            np.array([(forces(at + h * e) - forces(at - h * e)) / (2 * h) for e in np.eye(4)]).T
            for h in (1e-8, 5e-9)
        )
        if np.max(np.abs(numeric - half)) > 2e-6 * 2.4e9:
            continue  # a kink lies within the step
        np.testing.assert_allclose(tangent, numeric, atol=1e-8 * 2.4e9)  # measured 2.4e-9
        checked += 1
    assert checked > 40


def test_static_energy_balance_is_that_of_the_trapezoidal_rule(thesis_impact) -> None:
    push = ColumnPushover("push", thesis_impact.column, 0.5)
    response = FourDof().simulate(push)
    error = np.abs(response["balance_error"]).max() / response["input_energy"]
    assert float(error) < 7e-7  # measured 3.6e-7


@st.composite
def impacts(draw: st.DrawFn) -> ColumnImpact:
    """Random columns and strikers over the documented domain."""
    names = ("IPE 200", "HEA 160", "HEB 220", "HEB 400", "HEM 260", "IPE 500")
    section = find(draw(st.sampled_from(names)))
    length = draw(st.floats(2.0, 10.0))
    ratio = draw(st.floats(0.1, 0.9))
    column = Column(
        section,
        length * ratio,
        length * (1.0 - ratio),
        base=draw(st.sampled_from(["clamped", "pinned"])),
        head=draw(st.sampled_from(["guided", "pinned", "fixed"])),
        fillets=draw(st.booleans()),
        restraint_stiffness=draw(st.sampled_from([0.0, 1e6, 1e7, 1e9])),
        head_mass=draw(st.sampled_from([0.0, 100.0, 5e3, 1e5])),
    )
    load = draw(st.floats(-0.2, 0.6)) * column.properties.squash_load
    striker = Striker(
        10.0 ** draw(st.floats(1.0, 4.0)),
        draw(st.floats(0.5, 40.0)),
        draw(st.sampled_from([0.0, 0.3, 1.0])),
    )
    return ColumnImpact("random", replace(column, axial_load=load), striker, 0.06)


@pytest.mark.parametrize("examples", [100, pytest.param(250, marks=pytest.mark.slow)])
def test_random_scenarios_conserve_energy_or_end_in_a_typed_outcome(examples: int) -> None:
    answers, model = Answers(), FourDof()

    @settings(max_examples=examples)
    @given(impacts())
    def check(impact: ColumnImpact) -> None:
        response = model.simulate(impact)
        falls = outcome_of(response) is Outcome.COLLAPSE  # nothing bounds the energy
        if not answers.note(model, impact, response, asked=not falls):
            typed = Outcome.COLLAPSE, Outcome.OUT_OF_DOMAIN, Outcome.NOT_CONVERGED
            assert outcome_of(response) in typed
            assert len(response.attrs["message"]) > 40
            assert not response.data_vars
            return
        error = float(np.abs(response["balance_error"]).max()) / impact.input_energy
        assert error < 1e-6
        assert np.all(np.diff(response["dissipated"]) >= -1e-9 * impact.input_energy)
        assert np.all(np.diff(response["contact_loss"]) >= -1e-12 * impact.input_energy)
        assert np.all(response["percussion"] >= 0.0)
        if "peak_displacement" not in response:
            assert "no-peak" in [finding.subject for finding in warnings_of(response)]

    check()
    answers.demand()


def test_a_pinned_base_is_softer_and_a_spring_stiffer(thesis_impact) -> None:
    peak = {}
    for name, changes in {
        "as is": {},
        "pinned": {"base": "pinned"},
        "free head": {"restraint_stiffness": 0.0},
        "fixed head": {"head": "fixed"},
    }.items():
        column = replace(thesis_impact.column, **changes)
        response = FourDof().simulate(replace(thesis_impact, column=column, duration=0.2))
        peak[name] = float(response["peak_displacement"])
    assert peak["pinned"] > peak["as is"]
    assert peak["free head"] > peak["as is"] > peak["fixed head"]


def test_buckling_load_is_refused_and_shear_is_warned_of(thesis_impact) -> None:
    slender = Column(find("IPE 80"), 3.0, 3.0, base="pinned", head="pinned", axial_load=1e5)
    response = FourDof().simulate(ColumnImpact("slender", slender, Striker(10.0, 1.0)))
    assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
    assert "Euler load" in response.attrs["message"]
    thesis = FourDof().simulate(thesis_impact)
    assert "shear" in [finding.subject for finding in warnings_of(thesis)]
    assert float(thesis["shear_utilisation"].sel(segment="below")) > 1.7


def test_a_short_record_has_no_peak_and_says_so(thesis_impact) -> None:
    response = FourDof().simulate(replace(thesis_impact, duration=0.005))
    assert outcome_of(response) is Outcome.OK
    assert "peak_displacement" not in response
    assert "no-peak" in [finding.subject for finding in warnings_of(response)]


def test_collapse_is_an_answer_with_time_place_and_mechanism(thesis_impact, parked) -> None:
    response = FourDof().simulate(replace(thesis_impact.at_velocity(80.0), duration=0.2))
    assert outcome_of(response) is Outcome.COLLAPSE
    assert survives(response) is False
    collapse = collapse_of(response)
    assert (collapse.mechanism, collapse.parts) == ("geometry", ("below",))
    assert collapse.displacement == pytest.approx(0.9 * 0.8, rel=0.01)
    assert 0.0 < collapse.time < 0.2
    bent = replace(parked.at_velocity(10.0), duration=0.2)
    assert collapse_of(FourDof().simulate(bent)).mechanism == "geometry"
    assert survives(FourDof().simulate(bent.at_velocity(5.0))) is True
    # the record of 0.1 s ends while the column still sinks: neither
    assert survives(FourDof().simulate(parked.at_velocity(10.0))) is None


def stocky(head_mass: float, share: float) -> ColumnImpact:
    """HEM 260 of 1 m and 1 m, hit at 5 m/s under this share of its squash load."""
    column = Column(find("HEM 260"), 1.0, 1.0, head_mass=head_mass)
    load = share * column.properties.squash_load
    return ColumnImpact("stocky", replace(column, axial_load=load), Striker(1500.0, 5.0))


@pytest.mark.parametrize("shift", [0.0, 0.4, 1.0, 1.6])
def test_controlled_steps_keep_the_peak_and_the_ledger(thesis_impact, shift: float) -> None:
    """Against equal steps of 5 microseconds, whose Newton iterations are all evaluated."""
    column = replace(thesis_impact.column, length_below=0.8 + shift, length_above=3.2 - shift)
    impact = replace(thesis_impact, column=column, duration=0.05)
    free, fine = FourDof().simulate(impact), FourDof(time_step=5e-6).simulate(impact)
    peak = float(fine["peak_displacement"])
    assert float(free["peak_displacement"]) == pytest.approx(peak, rel=1e-3)
    assert len(free["time"]) < len(fine["time"]) / 20
    assert float(np.abs(free["balance_error"]).max()) < 1e-6 * impact.input_energy


def test_a_bar_that_reaches_its_squash_load_for_a_while_is_followed() -> None:
    bars, frame = FourDof(**THESIS_SPRINGS), RigidSuperelement(shear="none", elements=1)
    mine, theirs = (model.simulate(stocky(1e5, 0.6)) for model in (bars, frame))
    squash = stocky(1e5, 0.6).column.properties.squash_load
    assert float(mine["axial_force"].min()) == pytest.approx(-squash, rel=2e-3)  # at a record
    for name in ("peak_displacement", "residual_displacement"):
        assert float(mine[name]) == pytest.approx(float(theirs[name]), rel=5e-3)  # measured 2.3e-3
    head = float(mine["shortening"].max() - mine["shortening"][0])
    assert head == pytest.approx(4.03e-3, rel=1e-2)  # the frame says the same


def test_bars_that_lose_a_tenth_of_their_length_are_squashed() -> None:
    for model in (FourDof(), RigidSuperelement(shear="none")):
        collapse = collapse_of(model.simulate(stocky(0.0, 0.9)))
        assert (collapse.mechanism, collapse.parts) == ("squash", ("below", "above"))
        assert collapse.displacement < 0.4


@pytest.mark.parametrize("model", [FourDof(), FourDofShear()])
@pytest.mark.parametrize(
    ("stiff", "limit"),
    [
        ({"head_mass": 1e-9}, {"head_mass": 0.0}),
        ({"head_mass": 1.7e-4}, {"head_mass": 0.0}),
        ({"head_mass": 0.1, "restraint_stiffness": 1e14}, {"head": "fixed"}),
    ],
)
def test_steps_do_not_resolve_axial_vibrations_whatever_their_frequency(
    thesis_impact: ColumnImpact, model: FourDof, stiff: dict[str, float], limit: dict[str, object]
) -> None:
    def answer(changed: dict[str, object]) -> Response:
        column = replace(thesis_impact.column, **changed)
        response = model.simulate(replace(thesis_impact, column=column))
        assert outcome_of(response) is Outcome.OK
        return response

    result, expected = answer(stiff), answer(limit)
    assert len(result["time"]) < 1000
    for name in ("peak_displacement", "residual_displacement"):
        assert float(result[name]) == pytest.approx(float(expected[name]), rel=1e-5)  # 5.0e-6


def test_steps_that_no_memory_holds_are_refused_with_what_to_do(thesis_impact) -> None:
    response = FourDof(time_step=1e-8).simulate(thesis_impact)
    assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
    (finding,) = (result for result in findings_of(response) if result.refusal)
    assert finding.subject == "time-step"
    assert finding.number > 1e6
    assert "increase it" in finding.text


TOUCHED = [FourDof(), FourDofShear(), *(RigidSuperelement(elements=n) for n in (1, 3, 4))]


@pytest.mark.parametrize("model", [*TOUCHED, RigidSuperelement(elements=2, shear="none")])
def test_a_touch_under_dead_load_is_answered(thesis_impact: ColumnImpact, model: FourDof) -> None:
    column = replace(thesis_impact.column, axial_load=2e6)
    slow, slower = (
        model.simulate(replace(thesis_impact.at_velocity(v), column=column, duration=0.02))
        for v in (1e-2, 1e-5)
    )
    # measured 6.4e-6, 4.6e-5 with panels, 3e-10 of the frame
    assert 1e3 * float(slower["peak_displacement"]) == pytest.approx(
        float(slow["peak_displacement"]), rel=1e-4
    )
