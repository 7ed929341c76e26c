"""The shear-yielding reference: published plateau, independent numbers, limits, contract."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from builders import SQUARE, explicit_peak

from workbench.base.errors import CollapseError
from workbench.mechanics.structures.fibers import section_fibers
from workbench.models.four_dof import FourDofShear
from workbench.models.references.fiber_beams import FiberReissner, FiberShear
from workbench.models.strain_rate import with_rate
from workbench.responses import (
    Outcome,
    collapse_of,
    energy_error,
    findings_of,
    outcome_of,
    warnings_of,
)
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, Striker
from workbench.steel.materials import MILD_STEEL, CowperSymonds, Steel
from workbench.steel.sections import find, section_from
from workbench.testing import check_model

FASTEST = CowperSymonds(1e9, 1.0)  # of all steels: hardly feels a rate
AT = [0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]


def force_at(response, displacement) -> np.ndarray:
    assert outcome_of(response) is Outcome.OK, response.attrs["message"]
    return np.interp(displacement, response["displacement"], response["force"]) / 1e6


def subjects(findings) -> set[str]:
    return {finding.subject for finding in findings}


@pytest.mark.usefixtures("few_load_steps")
def test_it_keeps_the_contract_of_a_model(thesis_impact) -> None:
    scenarios = [
        replace(thesis_impact.at_velocity(5.0), duration=0.03),
        ColumnPushover("push", thesis_impact.column, 0.1),
    ]
    check_model(FiberShear(levels=1, smallest_element=0.05), scenarios)


@pytest.mark.claim("model:fiber-shear", "static force, relative error", "independent code", 0, 5e-3)
@pytest.mark.usefixtures("few_load_steps")
def test_static_plateau_of_the_thesis_column(thesis_impact, claim) -> None:
    """An independent solution of the same equations, to three digits; the mesh is not printed."""
    push = ColumnPushover("figure 5.8", thesis_impact.column, 0.7)
    response = FiberShear(levels=1, smallest_element=0.025).simulate(push)
    expected = [0.464, 0.512, 0.510, 0.508, 0.511, 0.521, 0.537, 0.545, 0.548]
    claim(np.abs(force_at(response, AT) / expected - 1.0).max())
    assert {"shear-strain"} <= subjects(warnings_of(response))
    plastic = thesis_impact.column.properties.shear_resistance
    assert 0.9 < float(response["shear_utilisation"][0]) < 1.0  # measured 0.92
    assert force_at(response, 0.2) > plastic / 1e6


def test_impact_peaks_of_the_thesis_column(thesis_impact) -> None:
    for velocity, expected in ((10.0, 0.148), (15.0, 0.327)):
        impact = replace(thesis_impact.at_velocity(velocity), duration=0.06)
        response = FiberShear(levels=1, smallest_element=0.025).simulate(impact)
        # measured 0.0063
        assert float(response["peak_displacement"]) == pytest.approx(expected, rel=0.01)
        error = np.abs(response["balance_error"]).max() / response["input_energy"]
        assert float(error) < 1e-8
        assert ("shear-strain" in subjects(warnings_of(response))) == (velocity >= 10.0)


@pytest.mark.usefixtures("few_load_steps")
def test_slender_segments_agree_with_the_shear_free_beam(thesis_impact) -> None:
    """Segments of 2 m (V / Vpl = 0.72) and the stocky square section (0.22), h = 0.05 m."""
    long = replace(thesis_impact.column, length_below=2.0, length_above=2.0)
    side = SQUARE
    square = replace(
        thesis_impact.column, section=side, area=None, second_moment=None,
        plastic_moment=None, squash_load=None,
    )  # fmt: skip
    for column, at, shearing, plain, tolerance in (
        (long, [0.1, 0.2], [0.522, 0.546], [0.533, 0.547], 0.02),
        (square, [0.1, 0.3], [2.231, 2.557], [2.242, 2.583], 0.005),
    ):
        push = ColumnPushover("push", column, at[-1] + 0.01)
        with_shear, without = (
            force_at(
                model(levels=1, smallest_element=0.05, largest_element=10.0).simulate(push), at
            )
            for model in (FiberShear, FiberReissner)
        )
        assert np.all(with_shear < without)
        np.testing.assert_allclose(with_shear, shearing, rtol=0.42 * tolerance)  # measured 0.21
        np.testing.assert_allclose(without, plain, rtol=tolerance)  # measured 0.0171
        assert np.all(with_shear > 0.97 * without)  # measured 0.978


@pytest.mark.thorough
def test_explicit_steps_check_the_implicit_ones(thesis_impact) -> None:
    impact = replace(thesis_impact.at_velocity(8.0), duration=0.035)
    model = FiberShear(levels=1, smallest_element=0.1, time_step=2e-5)
    implicit = float(model.simulate(impact)["peak_displacement"])
    assert explicit_peak(model, impact)[0] == pytest.approx(implicit, rel=5e-3)


@pytest.mark.thorough
def test_rate_and_hardening_of_the_steel_are_those_of_the_fibers(thesis_impact) -> None:
    """Panels with one factor on their yield stress are an independent form of the same law."""
    column = replace(thesis_impact.column, plastic_moment=None, squash_load=None)
    impact = replace(thesis_impact.at_velocity(10.0), column=column, duration=0.05)
    model, peaks = FiberShear(levels=1, smallest_element=0.05), {}
    steels = {"rate": Steel(rate=MILD_STEEL), "hardening": Steel(hardening_modulus=2.1e9)}
    for name, steel in {"none": Steel(), "fast": Steel(rate=FASTEST), **steels}.items():
        struck = replace(impact, column=replace(column, steel=steel))
        response = model.simulate(struck)
        peaks[name] = float(response["peak_displacement"])
        assert energy_error(response) < 1e-9
        assert np.all(np.diff(response["dissipated"]) >= 0.0)
        assert {"strain-rate", "hardening"}.isdisjoint(subjects(warnings_of(response)))
    as_option = replace(model, hardening_ratio=0.01).simulate(impact)
    assert peaks["hardening"] == float(as_option["peak_displacement"])
    assert peaks["hardening"] < 0.9 * peaks["none"]
    assert peaks["fast"] == pytest.approx(peaks["none"], rel=1e-6)
    panels = FourDofShear().simulate(with_rate(impact, MILD_STEEL))
    assert float(panels["peak_displacement"]) == pytest.approx(peaks["rate"], rel=0.05)


@pytest.mark.usefixtures("few_load_steps")
def test_statics_know_no_rate(thesis_impact) -> None:
    push = ColumnPushover("push", thesis_impact.column, 0.02)
    model = FiberShear(levels=1, smallest_element=0.1)
    forces = [model.simulate(each)["force"].values for each in (push, with_rate(push, MILD_STEEL))]
    np.testing.assert_array_equal(*forces)


def test_shear_is_no_warning_of_its_own(thesis_impact) -> None:
    assert "shear" in subjects(FiberReissner(levels=1).domain(thesis_impact))
    assert "shear" not in subjects(FiberShear(levels=1).domain(thesis_impact))


@pytest.mark.parametrize(
    ("shape", "tolerance"),
    [
        ({"side": 0.2}, 1e-12),
        ({"height": 0.2, "width": 0.1, "wall": 0.01}, 0.06),
        ({"diameter": 0.2, "wall": 0.01}, 5e-3),
    ],
)
def test_shear_shares_add_up_to_the_shear_area(shape, tolerance) -> None:
    """A tube's walls count between its flanges only, its shear area to their middles."""
    section = section_from(shape, "section")
    fibers = section_fibers(section, 20)
    carried = float(np.sum(fibers.area * fibers.share))
    assert carried == pytest.approx(section.shear_area, rel=tolerance)  # measured 0.88 of it
    assert carried <= section.shear_area * (1.0 + 5e-3)  # measured 4.2e-3


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("restraint", "outcome", "strain"),
    [(0.0, Outcome.COLLAPSE, 0.2), (2.6e8, Outcome.OK, 0.5)],  # the second hangs on
)
def test_a_member_that_slides_says_so(restraint: float, outcome: Outcome, strain: float) -> None:
    section = find("IPE 270").without_fillets()
    column = Column(section, 6.0, 0.86, axial_load=4.1e5, restraint_stiffness=restraint)
    impact = ColumnImpact("short segment", column, Striker(2800.0, 15.4), 0.2)
    response = FiberShear(levels=1).simulate(impact)
    assert outcome_of(response) is outcome
    (finding,) = [each for each in findings_of(response) if each.subject == "shear-strain"]
    assert finding.outside
    assert finding.number > strain
    assert "misses the catenary action" in finding.text
    assert ("hangs-on" in subjects(findings_of(response))) == (outcome is Outcome.OK)
    if outcome is Outcome.COLLAPSE:
        collapse = CollapseError(collapse_of(response), "fell", (finding,))
        assert pickle.loads(pickle.dumps(collapse)).findings == (finding,)
