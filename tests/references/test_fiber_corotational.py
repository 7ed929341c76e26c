"""The fiber reference: published column, refinement, closed forms, contract, random columns."""

import json
from dataclasses import replace

import numpy as np
import pytest
from builders import Answers
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.base.errors import InputError
from workbench.models.references.fiber_beams import FiberCorotational, FiberReissner
from workbench.responses import Outcome, Response, collapse_of, outcome_of, warnings_of
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, Striker, frame_of
from workbench.steel.sections import find, square
from workbench.testing import check_model

# Heng 2017, section 5.2: converged peaks of an independent Reissner beam with fibers (its own
# uncertainty is 1.2 %)
CONVERGED = {10.0: 0.0915, 15.0: 0.195, 20.0: 0.3245}
STATIC_AT = [0.02, 0.05, 0.1, 0.2, 0.3]
STATIC = [0.811e6, 0.828e6, 0.842e6, 0.919e6, 1.013e6]


def peak(model: FiberCorotational, scenario: ColumnImpact) -> float:
    return peak_of(model.simulate(scenario))


def peak_of(response: Response) -> float:
    assert outcome_of(response) is Outcome.OK, response.attrs["message"]
    return float(response["peak_displacement"])


@pytest.fixture(scope="module")
def slow_hit(thesis_impact) -> tuple[ColumnImpact, Response]:
    """The thesis column hit at 10 m/s, and the default answer."""
    scenario = replace(thesis_impact.at_velocity(10.0), duration=0.03)
    return scenario, FiberCorotational(levels=1).simulate(scenario)


def subjects(response) -> list[str]:
    return [finding.subject for finding in warnings_of(response)]


def elastic_column(**options) -> Column:
    return Column(find("HEB 220"), 2.0, 2.0, **options)


@pytest.mark.thorough
def test_default_answer_for_a_slow_hit(slow_hit):
    assert peak_of(slow_hit[1]) == pytest.approx(CONVERGED[10.0], rel=0.012)


@pytest.mark.claim(
    "model:fiber-corotational", "peak, {velocity} m/s, ratio", "independent code", 1, 0.012
)
@pytest.mark.slow
@pytest.mark.parametrize(("velocity", "duration"), [(15.0, 0.032), (20.0, 0.04)])
def test_default_answer_for_the_thesis_column(thesis_impact, velocity, duration, claim):
    scenario = replace(thesis_impact.at_velocity(velocity), duration=duration)
    claim(peak(FiberCorotational(levels=1), scenario) / CONVERGED[velocity])


@pytest.mark.thorough
def test_refinement_hardly_changes_balanced_elements(thesis_impact):
    scenario = replace(thesis_impact, duration=0.03)
    coarse, middle = (
        peak(FiberCorotational(levels=1, element="balanced", refinement=r), scenario)
        for r in (0, 1)
    )
    assert middle == pytest.approx(coarse, rel=2.5e-3)  # measured 0.0012


def test_refinement_halves_elements_and_steps(thesis_impact):
    scenario = thesis_impact
    halved = FiberCorotational(levels=1, refinement=2)
    assert sum(map(len, halved.lengths(scenario))) == 2 * sum(
        map(len, FiberCorotational(levels=1).lengths(scenario))
    )
    assert (
        halved.time_spans(scenario)[0][1]
        == FiberCorotational(levels=1).time_spans(scenario)[0][1] / 2
    )


@pytest.mark.thorough
def test_classical_element_converges_to_the_same_peak_from_below(thesis_impact, slow_hit):
    scenario = replace(thesis_impact.at_velocity(10.0), duration=0.024)
    peaks = [
        peak(FiberCorotational(levels=1, element="interpolated", smallest_element=h), scenario)
        for h in (0.05, 0.025)
    ]
    extrapolated = 2 * peaks[1] - peaks[0]
    assert peaks[0] < peaks[1] < extrapolated
    # measured 0.0063
    assert peak_of(slow_hit[1]) == pytest.approx(extrapolated, rel=0.01)


@pytest.mark.thorough
def test_clamped_column_of_the_thesis(clamped_impact):
    """Axially fixed ends, 25 m/s: converged 0.5055 m."""
    scenario = replace(clamped_impact, duration=0.042)
    # measured 0.0042
    assert peak(FiberCorotational(levels=1), scenario) == pytest.approx(0.5055, rel=0.008)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("element", "early", "late"), [("interpolated", 0.015, 0.03), ("balanced", 0.005, 0.025)]
)
def test_pushover_of_the_thesis_column(thesis_impact, element, early, late):
    """The first three points lie before, the others in the catenary range."""
    scenario = ColumnPushover("push", thesis_impact.column, 0.3)
    response = FiberCorotational(levels=1, element=element).simulate(scenario)
    force = np.interp(STATIC_AT, response["displacement"], response["force"])
    assert force == pytest.approx(STATIC, rel=late)  # measured 0.98 of it
    assert force[:3] == pytest.approx(STATIC[:3], rel=early)  # measured 0.87 of it
    assert response["displacement"].values[-1] == pytest.approx(0.3)
    assert "shear-reached" in subjects(response)
    assert response["shear_utilisation"].values[0] == pytest.approx(1.8, abs=0.04)  # measured 0.018
    # measured 3.0e-8
    assert np.abs(response["balance_error"]).max() < 6e-8 * response["input_energy"]


@pytest.mark.claim("model:fiber-corotational", "elastic stiffness, ratio", "closed form", 1, 1e-8)
@pytest.mark.usefixtures("few_load_steps")
@pytest.mark.parametrize(("base", "head"), [("clamped", "guided"), ("pinned", "pinned")])
def test_elastic_stiffness(base, head, claim):
    """Bernoulli: 192 EI / L^3 and 48 EI / L^3 at mid-height; shear adds L / 4GA."""
    column = elastic_column(base=base, head=head)
    frame = frame_of(column)
    section = FiberCorotational().section(frame, frame.members[0])
    bending = 210e9 * np.sum(section.y**2 * section.area)
    stiffness = (192.0 if base == "clamped" else 48.0) * bending / 4.0**3
    for sheared in (False, True):
        if sheared:
            stiffness = 1.0 / (1.0 / stiffness + 4.0 / 4.0 / section.shear_stiffness)
        model = FiberCorotational(levels=1, shear_flexible=sheared)
        response = model.simulate(ColumnPushover("elastic", column, 1e-4))
        claim(response["force"].values[-1] / 1e-4 / stiffness)
        assert response.attrs.get("yield_ratio") is None


@pytest.mark.claim("model:fiber-corotational", "shortening over P L / E A", "closed form", 1, 1e-8)
@pytest.mark.usefixtures("few_load_steps")
def test_signs_of_the_watched_sections(thesis_impact, claim):
    response = FiberCorotational(levels=1).simulate(
        ColumnPushover("push", thesis_impact.column, 0.05)
    )
    moment = response["moment"].values[:, -1]
    assert np.all(np.sign(moment) == [1, -1, -1, 1])
    # no moment is applied in between; measured 1.6e-13
    assert moment[1] == pytest.approx(moment[2], rel=1e-8)
    rotation = response["plastic_rotation"].values[:, -1]
    assert rotation[0] == pytest.approx(0.05 / 0.8, rel=0.12)  # measured 0.092
    # measured 2.0e-4
    assert rotation[0] + rotation[1] + rotation[2] + rotation[3] == pytest.approx(0.0, abs=4.1e-4)
    axial = response["axial_force"].values[:, 0]
    assert axial == pytest.approx(-0.5e6, rel=1e-6)
    claim(response["shortening"].values[0] / (0.5e6 * 4.0 / (210e9 * 8.826e-3)))


@pytest.mark.usefixtures("few_load_steps")
def test_fixed_head_is_locked_after_the_axial_load():
    column = elastic_column(head="fixed", axial_load=4e5, restraint_stiffness=1e7)
    response = FiberCorotational(levels=1).simulate(ColumnPushover("push", column, 0.1))
    assert np.ptp(response["shortening"].values) == 0.0
    # measured: round-off
    assert response["axial_force"].values[0, 0] == pytest.approx(-4e5, rel=1e-8)
    assert response["axial_force"].values[0, -1] > 0.0  # catenary


def test_spring_is_unstressed_under_the_axial_load():
    column = elastic_column(axial_load=4e5, restraint_stiffness=1e8)
    model = FiberCorotational(smallest_element=0.25, largest_element=0.25, refinement=0)
    structure = model.structure(ColumnPushover("push", column, 0.1))
    assert structure.members.axial_forces() == pytest.approx(-4e5, rel=1e-9)
    head, sign = structure.dof("head", "-y")
    shortening = sign * structure.assembly.displacement[head]
    assert structure.assembly.stored == pytest.approx(0.5 * 4e5 * shortening, rel=1e-9)


@pytest.mark.thorough
def test_impulse_is_the_momentum_that_the_striker_lost(slow_hit):
    scenario, response = slow_hit
    lost = scenario.striker.mass * (10.0 - response["striker_velocity"].values[-1])
    assert response["impulse"] == pytest.approx(lost, rel=1e-9)
    assert float(response["percussion"].min()) >= 0.0
    assert response.attrs["algorithmic_dissipation"] == 0.0


@pytest.mark.thorough
def test_record_that_ends_before_the_peak(thesis_impact):
    response = FiberCorotational(levels=1).simulate(replace(thesis_impact, duration=0.01))
    assert "no-peak" in subjects(response)
    assert "peak_displacement" not in response
    assert "residual_displacement" not in response


def test_light_striker_is_noticed():
    scenario = ColumnImpact("light", Column(find("IPE 500"), 4.0, 4.0), Striker(200.0, 3.0), 0.01)
    damped = FiberCorotational(levels=1, weight=0.55)
    assert "damping" in subjects(damped.simulate(scenario))


@pytest.mark.thorough
def test_collapse_is_an_answer():
    column = Column(find("HEB 220"), 1.0, 3.0, axial_load=1.5e6)
    impact = ColumnImpact("collapse", column, Striker(3000.0, 15.0), 0.4)
    coarse = FiberCorotational(levels=1, smallest_element=0.2, refinement=-1)
    collapse = collapse_of(coarse.simulate(impact))
    assert (collapse.mechanism, collapse.parts) == ("geometry", ("below",))
    assert 0.0 < collapse.time < 0.4
    # elements that crumple on the way there, on two coarser meshes too, say nothing of the column
    response = FiberCorotational(levels=1).simulate(impact)
    assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
    assert "member below crumples at " in response.attrs["message"]


@pytest.mark.thorough
def test_a_mesh_that_crumples_is_followed_by_a_coarser_one_within_a_percent():
    column = Column(find("HEB 220"), 0.8, 3.2, restraint_stiffness=1e7)
    column = replace(column, axial_load=0.3 * column.properties.squash_load)
    impact = ColumnImpact("crumples", column, Striker(1500.0, 11.0), 0.03)
    response = FiberCorotational(levels=1).simulate(impact)
    (finding,) = (f for f in warnings_of(response) if "crumples" in f.text)
    assert "elements 2 times as long" in finding.text
    assert json.loads(response.attrs["options"])["refinement"] == 1
    beam = FiberReissner(levels=1).simulate(impact)
    peak = float(beam["peak_displacement"])
    assert float(response["peak_displacement"]) == pytest.approx(peak, rel=0.02)  # measured 0.012


def test_overrides_that_fibers_cannot_follow_are_told():
    near = Column(find("HEB 220"), 1.0, 3.0, area=91e-4, second_moment=8091e-8)
    model = FiberCorotational(levels=1)
    assert "section" not in [f.subject for f in model.domain(ColumnPushover("a", near))]
    far = replace(near, plastic_moment=4e5, area=91.9e-4)
    findings = [f for f in model.domain(ColumnPushover("b", far)) if f.subject == "section"]
    assert len(findings) == 1
    assert "plastic_moment = 4e+05 against" in findings[0].text
    assert "area" not in findings[0].text


def test_options_are_checked():
    for options in (
        {"layers": 7},
        {"layers": 2},
        {"weight": 0.4},
        {"refinement": 1.5},
        {"element": "finest"},
        {"smallest_element": 0.0},
    ):
        with pytest.raises(InputError, match="option"):
            FiberCorotational(levels=1, **options)


@pytest.mark.usefixtures("few_load_steps")
def test_contract():
    """Pins, a head mass, restitution: what the columns of the registered models lack."""
    scenarios = [
        ColumnPushover("push", Column(find("IPE 300"), 1.5, 2.5, base="pinned"), 0.15),
        ColumnImpact(
            "bounce",
            Column(find("IPE 200"), 1.0, 2.0, head="pinned", head_mass=100.0),
            Striker(300.0, 8.0, 0.5),
            0.02,
        ),
    ]
    coarse = {"smallest_element": 0.2, "largest_element": 0.4, "refinement": -1}  # on any mesh
    check_model(FiberCorotational(levels=1, **coarse), scenarios)


RANDOM_COLUMNS = given(
    section=st.sampled_from([find("HEB 220"), find("IPE 300"), find("HEA 160"), square(0.1)]),
    length=st.floats(2.0, 8.0),
    position=st.floats(0.1, 0.9),
    base=st.sampled_from(["clamped", "pinned"]),
    head=st.sampled_from(["guided", "pinned", "fixed"]),
    load=st.sampled_from([-0.2, 0.0, 0.1, 0.4]),
    spring=st.sampled_from([0.0, 1e6, 1e8]),
    head_mass=st.sampled_from([0.0, 2000.0]),
    mass=st.floats(30.0, 5000.0),
    velocity=st.floats(1.0, 40.0),
    restitution=st.sampled_from([0.0, 0.5, 1.0]),
)


def columns_balance_their_energy(examples: int, refinement: int) -> None:
    """Energy is kept on any mesh, so that a coarse one serves."""
    answers = Answers()

    @settings(max_examples=examples)
    @RANDOM_COLUMNS
    def check(
        section, length, position, base, head, load, spring, head_mass, mass, velocity, restitution
    ):
        squash = 355e6 * section.area
        column = Column(
            section,
            length * position,
            length * (1.0 - position),
            base=base,
            head=head,
            axial_load=load * squash,
            restraint_stiffness=spring,
            head_mass=head_mass,
        )
        scenario = ColumnImpact("any", column, Striker(mass, velocity, restitution), 0.01)
        model = FiberCorotational(levels=1, refinement=refinement)
        response = model.simulate(scenario)
        collapses = outcome_of(response) is Outcome.COLLAPSE  # an answer, without a ledger
        if not answers.note(model, scenario, response, asked=not collapses):
            typed = Outcome.COLLAPSE, Outcome.OUT_OF_DOMAIN
            assert outcome_of(response) in typed, response.attrs["message"]
            return
        energy = scenario.input_energy
        assert float(np.abs(response["balance_error"]).max()) <= 1e-8 * energy
        assert np.diff(response["dissipated"]).min() >= -1e-9 * energy
        assert np.diff(response["contact_loss"]).min() >= -1e-9 * energy

    check()
    answers.demand()


@pytest.mark.thorough
def test_random_columns_balance_their_energy():
    columns_balance_their_energy(20, refinement=-1)


@pytest.mark.slow
def test_two_hundred_random_columns_balance_their_energy():
    columns_balance_their_energy(200, refinement=1)
