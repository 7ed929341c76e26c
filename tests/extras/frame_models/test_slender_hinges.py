"""Refined hinges whose plates or members buckle, and whose flanges are relieved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_hinged_frames import HEB, NP, cantilever

from workbench.base.errors import InputError
from workbench.extras.frame_models.hinged_frames import PlasticHinge, RefinedPlasticHinge
from workbench.responses import findings_of
from workbench.scenarios import FrameStatic, regular_frame
from workbench.scenarios.parts import Joint
from workbench.steel.sections import Section, circular_tube, find, i_section, square
from workbench.steel.sections.slenderness import lateral_torsional, shares_by_class

pytestmark = pytest.mark.usefixtures("few_load_steps")
PLATES = i_section(0.6, 0.3, 0.006, 0.010)  # web 97, flange 14.7: class 4 in S355


def of(section: Section, push: float = 0.4) -> FrameStatic:
    """The cantilever of 4 m with another section."""
    scenario = cantilever(4.0, 0.0, push)
    member = replace(scenario.frame.members[0], section=section)
    return replace(scenario, frame=replace(scenario.frame, members=(member,)))


@pytest.mark.parametrize("section", [PLATES, find("HEA 260"), HEB], ids=["4", "3", "1"])
def test_resistance_is_that_of_the_class(section: Section) -> None:
    scenario = of(section)
    plain = {"geometry": "linear", "shear_flexible": False}
    whole = float(RefinedPlasticHinge(**plain).simulate(scenario)["resistance"])
    reduced = RefinedPlasticHinge(local_buckling=True, **plain).simulate(scenario)
    frame = scenario.frame
    _, share = shares_by_class(section, frame.strength_section("leg"), frame.steel)
    moment = share * frame.properties("leg").plastic_moment
    assert whole * 4.0 == pytest.approx(frame.properties("leg").plastic_moment, rel=2e-3)
    assert float(reduced["resistance"]) * 4.0 == pytest.approx(moment, rel=2e-3)
    findings = [f for f in findings_of(reduced) if f.subject == "local-buckling"]
    assert [f.number for f in findings] == ([] if share == 1.0 else [pytest.approx(share)])


def test_compression_squashes_what_plates_leave() -> None:
    """Pulled by its whole section, pressed by the effective one; a weaker joint stays as it is."""
    scenario = of(PLATES)
    frame, whole = scenario.frame, scenario.frame.properties("leg")
    area, moment = shares_by_class(PLATES, PLATES, frame.steel)
    low = 0.3 * whole.plastic_moment
    weak = Joint("weak", plastic_moment=low, plastic_moment_negative=low)
    member = replace(frame.members[0], joint_start="weak")
    jointed = replace(scenario, frame=replace(frame, joints=(weak,), members=(member,)))
    for case, start in ((scenario, moment), (jointed, 0.3)):
        structure = RefinedPlasticHinge(local_buckling=True).structure(case)
        (tables,) = structure.members.elements.tables
        assert tables.squash[0] == pytest.approx(np.array([1.0, area]) * whole.squash_load)
        (row,) = tables.rows
        assert row["high1"] == -row["low1"] == pytest.approx(start * whole.plastic_moment)
        assert row["high4"] == -row["low4"] == pytest.approx(moment * whole.plastic_moment)


def test_circular_tubes_of_class_4_are_refused() -> None:
    thin, stocky = circular_tube(0.5, 0.005), circular_tube(0.3, 0.02)
    model = RefinedPlasticHinge(local_buckling=True)
    (refused,) = (f for f in model.domain(of(thin)) if f.subject == "local-buckling")
    assert refused.refusal
    assert model.simulate(of(thin)).attrs["outcome"] == "out-of-domain"
    assert not [f for f in model.domain(of(stocky)) if f.subject == "local-buckling"]
    assert not [f for f in RefinedPlasticHinge().domain(of(thin)) if "buckling" in f.subject]


@pytest.mark.parametrize(("length", "subject"), [(1.0, "check"), (8.0, "torsional")])
def test_lateral_torsional_buckling_is_told(length: float, subject: str) -> None:
    portal = regular_frame((6.0,), (4.0,), square(0.2), find("IPE 300"))
    push = replace(of(HEB), frame=portal, loads=(replace(of(HEB).loads[0], node="A1"),), node="A1")
    response = RefinedPlasticHinge(unbraced_length=length).simulate(push)
    (finding,) = (f for f in findings_of(response) if f.subject.startswith("lateral"))
    assert finding.subject == f"lateral-{subject}"
    assert finding.outside == (finding.number > 1.0) == (subject == "torsional")
    beam = portal.members[-1]
    at = [i for i, name in enumerate(response["hinge"].values) if name.startswith(beam.name)]
    moment = float(np.abs(response["moment"].values[at]).max())
    strength = portal.properties(beam).plastic_moment
    chi = lateral_torsional(beam.section.shape, portal.steel, length, strength)
    assert finding.number == pytest.approx(moment / chi.resistance)
    assert f"utilisation {finding.number:.2f} of member {beam.name}" in finding.text
    same = RefinedPlasticHinge().simulate(push)
    assert np.array_equal(same["force"].values, response["force"].values)
    solid = replace(push, frame=regular_frame((6.0,), (4.0,), square(0.2), square(0.2)))
    told_of = findings_of(RefinedPlasticHinge(unbraced_length=length).simulate(solid))
    assert not [f for f in told_of if f.subject.startswith("lateral")]


def test_double_modulus_is_between_tangent_modulus_and_elastic() -> None:
    """Under 0.7 of the squash load, bent: 2.24 and 2.87 MN/m, where fibers have 4.0."""
    scenario = cantilever(2.0, 0.7 * NP, 4e-4)
    slopes = []
    for model in (RefinedPlasticHinge(), RefinedPlasticHinge(modulus="double"), PlasticHinge()):
        response = model.simulate(scenario)
        assert response.attrs["outcome"] == "ok", response.attrs["message"]
        slopes.append(float(response["force"][5] / response["displacement"][5]))
    assert slopes == sorted(slopes)
    assert slopes[1] > 1.2 * slopes[0]
    unladen = cantilever(2.0, 0.0, 0.1)
    forces = [
        RefinedPlasticHinge(modulus=m).simulate(unladen)["force"] for m in ("tangent", "double")
    ]
    assert np.array_equal(*forces)


@pytest.mark.parametrize(
    "options", [{"modulus": "reduced"}, {"unbraced_length": 0.0}, {"local_buckling": "class"}]
)
def test_bad_options_are_refused(options: dict[str, object]) -> None:
    (name,) = options
    with pytest.raises(InputError, match=rf"option\.{name}"):
        RefinedPlasticHinge(**options)
