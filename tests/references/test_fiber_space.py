"""The reference in space: its plane limits, symmetry, hits from every side against other codes."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from workbench.mechanics.structures.space import space_fibers
from workbench.models.references.fiber_beams import FiberCorotational
from workbench.models.references.fiber_space import FiberSpace
from workbench.responses import (
    Outcome,
    energy_error,
    findings_of,
    outcome_of,
)
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.materials import CowperSymonds
from workbench.steel.sections import find
from workbench.steel.sections.section import CircularTube, Rectangle, RectangularTube, Section
from workbench.testing import check_model

SHS = Section("SHS 200x10", RectangularTube(0.2, 0.2, 0.01))
HEB_HIT = ColumnImpact(
    "HEB 220, 0.8 + 3.2 m",
    Column("HEB 220", 0.8, 3.2, axial_load=0.5e6, restraint_stiffness=1e7, fillets=False),
    Striker(1500.0, 15.0),
    0.06,
)
IPE_HIT = ColumnImpact(
    "IPE 300, 1.2 + 2.3 m",
    Column("IPE 300", 1.2, 2.3, axial_load=0.15e6, restraint_stiffness=5e6, fillets=False),
    Striker(800.0, 8.0),
    0.08,
)
SHS_HIT = ColumnImpact(
    "SHS 200x10, 1.0 + 2.5 m",
    Column(SHS, 1.0, 2.5, axial_load=0.2e6, restraint_stiffness=5e6),
    Striker(1200.0, 12.0),
    0.06,
)
COARSE = FiberSpace(levels=1, refinement=-2)


def at(hit: ColumnImpact, degrees: float, **changes) -> ColumnImpact:
    striker = replace(hit.striker, angle=np.radians(degrees))
    return replace(hit, striker=striker, **changes)


def peak_of(model, hit) -> float:
    response = model.simulate(hit)
    assert outcome_of(response) is Outcome.OK, response.attrs["message"]
    assert energy_error(response) < 1e-7
    return float(response["peak_displacement"])


@pytest.mark.claim("model:fiber-space", "peak in the plane, ratio", "independent code", 1, 1e-5)
def test_hits_along_the_web_are_those_of_the_plane_beam(claim):
    plane = FiberCorotational(levels=1, refinement=-2, layers=12, shear_flexible=False)
    hit = replace(HEB_HIT, striker=Striker(1500.0, 10.0))
    response = COARSE.simulate(hit)
    beam = plane.simulate(hit)
    peak = float(beam["peak_displacement"])
    claim(response["peak_displacement"] / peak)
    for name in ("moment", "axial_force", "plastic_rotation", "utilisation"):
        scale = float(np.abs(beam[name]).max())
        ends = [float(each[name].values[:, -1].max()) for each in (response, beam)]
        assert ends[0] == pytest.approx(ends[1], abs=0.02 * scale), name
    assert float(np.abs(response["sideways"]).max()) < 1e-9


@pytest.mark.thorough
def test_hits_along_the_flanges_are_those_of_the_plane_beam_about_the_weak_axis():
    # fibers lie differently in the two: 12 strips across a flange in both, the web as one or two
    plane = FiberCorotational(levels=1, refinement=-2, layers=12, shear_flexible=False)
    hit = replace(HEB_HIT, striker=Striker(1500.0, 10.0))
    weak = replace(hit, column=hit.column.changed(axis="weak"))
    here = peak_of(COARSE, at(hit, 90.0))
    assert here == pytest.approx(peak_of(plane, weak), rel=2e-3)
    assert peak_of(COARSE, weak) == pytest.approx(here, rel=1e-7)


@pytest.mark.thorough
def test_a_square_is_alike_on_both_sides():
    square = Section("square", Rectangle(0.2, 0.2))
    hit = replace(SHS_HIT, column=SHS_HIT.column.changed(section=square))
    sides = [peak_of(COARSE, at(hit, degrees)) for degrees in (0.0, 30.0, 60.0, 90.0)]
    assert sides[3] == pytest.approx(sides[0], rel=1e-6)
    # the frame follows the second axes of the nodes, not the third: measured 6e-6 on this mesh
    assert sides[2] == pytest.approx(sides[1], rel=2e-5)
    assert sides[1] > 1.01 * sides[0]


@pytest.mark.thorough
def test_ends_may_differ_about_both_axes():
    hit = replace(HEB_HIT, striker=Striker(1500.0, 8.0))
    pinned = replace(hit, column=hit.column.changed(base_weak="pinned"))
    assert peak_of(COARSE, pinned) == pytest.approx(peak_of(COARSE, hit), rel=1e-9)
    weak = replace(pinned, column=pinned.column.changed(axis="weak"))
    assert peak_of(COARSE, at(pinned, 90.0)) == pytest.approx(peak_of(COARSE, weak), rel=1e-7)
    clamped, turned = (peak_of(COARSE, at(each, 45.0)) for each in (hit, pinned))
    assert turned > 1.02 * clamped


def test_friction_and_weak_buckling_are_refused():
    rough = replace(HEB_HIT, striker=replace(HEB_HIT.striker, friction=0.3))
    response = COARSE.simulate(rough)
    assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
    assert "friction" in {each.subject for each in findings_of(response)}
    column = Column("IPE 300", 3.0, 5.0, axial_load=8e5, head="pinned", base="pinned")
    response = COARSE.simulate(ColumnImpact("slender", column, Striker(800.0, 2.0)))
    assert outcome_of(response) is Outcome.OUT_OF_DOMAIN


@pytest.mark.thorough
def test_it_keeps_the_contract_of_a_model():
    check_model(COARSE, [at(HEB_HIT, 30.0, duration=0.02), at(SHS_HIT, 45.0, duration=0.02)])


@pytest.mark.thorough
def test_rate_and_hardening_stiffen_it():
    static = peak_of(COARSE, at(HEB_HIT, 45.0))
    steel = HEB_HIT.column.steel
    rated = replace(steel, rate=CowperSymonds(40.4, 5.0))
    hard = steel.changed(hardening_modulus=2.1e9)
    for each in (rated, hard):
        hit = replace(HEB_HIT, column=HEB_HIT.column.changed(steel=each))
        assert peak_of(COARSE, at(hit, 45.0)) < 0.97 * static


@pytest.mark.parametrize("layers", [8, 20])
def test_fibers_make_up_the_section(layers):
    for section in (
        find("HEB 220"),
        find("IPE 300").without_fillets(),
        SHS,
        Section("tube", CircularTube(0.2191, 0.01)),
        Section("bar", Rectangle(0.2, 0.1)),
    ):
        fibers = space_fibers(section, layers)
        weak = section.about("weak")
        assert np.sum(fibers.area) == pytest.approx(section.area, rel=1e-9)
        for lever, whole in ((fibers.y, section), (fibers.z, weak)):
            second = float(np.sum(lever**2 * fibers.area))
            plastic = float(np.sum(np.abs(lever) * fibers.area))
            loss = 1.3 / layers**2  # of strips that are points
            assert second == pytest.approx(whole.second_moment, rel=max(loss, 0.004))
            assert plastic == pytest.approx(whole.plastic_section_modulus, rel=max(loss, 0.004))
            assert float(np.sum(lever * fibers.area)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.thorough
def test_meshes_behind_an_answer_say_how_far_off_it_is():
    model = FiberSpace(levels=2, refinement=-1)
    response = model.simulate(at(SHS_HIT, 45.0))
    width = json.loads(response.attrs["numerical_uncertainty"])["peak_displacement"]
    peak = float(response["peak_displacement"])
    assert 0.0 < width < 0.1 * peak
    assert abs(peak - peak_of(replace(model, levels=1, refinement=0), at(SHS_HIT, 45.0))) < width


# OpenSees, 60 corotational displacement-based elements, no shear, no warping, a joined striker,
# while IPE 300 throws 800 kg off and meets it again: with a joined one -2.5 % at most
OPENSEES = {
    HEB_HIT: ({0: 0.1897, 30: 0.2805, 45: 0.3098, 60: 0.3331, 90: 0.3554}, 0.01),
    IPE_HIT: ({0: 0.0498, 30: 0.1347, 45: 0.1799, 60: 0.2158, 90: 0.2459}, 0.035),
    SHS_HIT: ({0: 0.1604, 45: 0.1699}, 0.015),
}


@pytest.mark.claim("model:fiber-space", "peak over that of OpenSees", "another program", 1, 0.035)
@pytest.mark.slow
@pytest.mark.parametrize("hit", OPENSEES, ids=lambda hit: hit.name)
def test_hits_from_every_side_against_opensees(hit, claim):
    peaks, bound = OPENSEES[hit]
    for degrees, expected in peaks.items():
        peak = peak_of(FiberSpace(levels=1, refinement=0, layers=20), at(hit, degrees))
        assert peak == pytest.approx(expected, rel=bound)  # measured +0.6, -3.3, +1.1 %
        claim(peak / expected)
