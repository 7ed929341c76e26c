"""Frames in space: alike from every side, mirrored, against fibers, plane and elastic frames."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from math import cos, degrees, pi, radians, sin

import numpy as np
import pytest

from workbench.base.errors import InputError
from workbench.mechanics.frames.elastic import ElasticFrame, dead_load_state
from workbench.models.four_dof import FourDof
from workbench.models.references.fiber_space import FiberSpace, place_frame
from workbench.models.superelement_space import SuperelementSpace
from workbench.models.superelements import FlexibleSuperelement
from workbench.responses import Outcome, energy_error, findings_of, outcome_of
from workbench.scenarios import (
    Frame,
    FrameImpact,
    FramePulse,
    FrameStatic,
    FrameStriker,
    Load,
    Member,
    Node,
    Pulse,
    regular_frame,
    scenario_from,
    to_toml,
)
from workbench.scenarios.files import load_scenario
from workbench.scenarios.frame_events import facing
from workbench.steel.sections import find
from workbench.steel.sections.slenderness import torsion_constants

HEB, IPE = find("HEB 220"), find("IPE 300")
DURATION, SPEED = 0.08, 10.0


def bay(depths=(5.0,), joint="rigid", column=HEB, load=1e5) -> Frame:
    """One bay whose corner column is hit 1.2 m above its base."""
    bare = regular_frame((5.0,), (3.5,), column, IPE, depths=depths, beam_joint=joint)
    corner = "Aa" if depths else "A"
    loads = tuple(Load(node.name, y=-load) for node in bare.nodes if node.y > 0.0)
    return replace(bare, loads=loads).split(f"{corner}0-{corner}1", 1.2, "hit")


def hit(frame: Frame, degrees=0.0, direction="+x", duration=DURATION) -> FrameImpact:
    striker = FrameStriker(1500.0, SPEED, node="hit", direction=direction, angle=radians(degrees))
    return FrameImpact("hit", frame, striker, duration)


def answered(scenario, model=None):
    response = (model or SuperelementSpace()).simulate(scenario)
    assert outcome_of(response) is Outcome.OK, response.attrs["message"]
    assert energy_error(response) < 1e-8
    return response


def peak(scenario, model=None) -> float:
    return float(answered(scenario, model)["peak_displacement"])


OBLIQUE = 30.0


@pytest.fixture(scope="module")
def oblique():
    return answered(hit(bay(), OBLIQUE))


def test_a_plane_frame_is_the_same_structure():
    # beside another N-M surface, and steps of their own
    frame = bay(())
    plane = peak(hit(frame), FlexibleSuperelement(shear="none"))
    in_space = answered(hit(frame))
    assert float(in_space["peak_displacement"]) == pytest.approx(plane, rel=0.02)
    assert np.abs(in_space["shape_z"]).max() < 1e-12


@pytest.mark.thorough
def test_a_plane_frame_that_is_hit_off_its_plane_leans():
    leaning = answered(hit(bay(()), 5.0))
    assert np.abs(leaning["shape_z"]).max() > 0.01
    assert leaning["peak_displacement"] > peak(hit(bay(())))


def test_a_mirrored_frame_answers_mirrored(oblique):
    frame = bay()
    mirrored = replace(frame, nodes=tuple(replace(node, z=-node.z) for node in frame.nodes))
    response = answered(hit(mirrored, -OBLIQUE))
    assert abs(response["peak_displacement"] / oblique["peak_displacement"] - 1.0) < 1e-5
    at_peak = [each["shape_z"].isel(snapshot=20).values for each in (response, oblique)]
    assert np.abs(at_peak[0] + at_peak[1]).max() < 1e-5


def test_a_turned_frame_answers_alike(oblique):
    frame, turn = bay(), 0.7
    c, s = cos(turn), sin(turn)
    nodes = tuple(
        replace(node, x=c * node.x + s * node.z, z=c * node.z - s * node.x) for node in frame.nodes
    )
    members = tuple(
        replace(member, roll=turn) if chord[1] else member
        for member, chord in zip(frame.members, frame.chords, strict=True)
    )
    response = answered(hit(replace(frame, nodes=nodes, members=members), OBLIQUE - degrees(turn)))
    assert abs(response["peak_displacement"] / oblique["peak_displacement"] - 1.0) < 1e-5


@pytest.mark.thorough
def test_a_flight_along_minus_x_is_that_behind_the_plane():
    event = hit(bay(), 150.0)
    assert peak(hit(bay(), OBLIQUE, "-x")) == pytest.approx(peak(event), rel=1e-9)


@pytest.mark.thorough
def test_bars_between_hinges_follow_fibers(oblique):
    fibers = FiberSpace(smallest_element=0.12, largest_element=0.7, layers=6, levels=1)
    coarse = peak(hit(bay(), OBLIQUE, duration=0.06), fibers)
    # measured +2 %: hinges n = 10 are soft, coarse fibers stiff
    assert float(oblique["peak_displacement"]) == pytest.approx(coarse, rel=0.035)


def test_what_is_reported_of_members_are_resultants(oblique):
    assert (oblique["plastic_rotation"] >= 0.0).all()
    assert (oblique["moment"] >= 0.0).all()
    assert {"shape_x", "shape_y", "shape_z"} <= set(oblique)
    assert 0.0 < oblique["largest_drift"] < 0.1
    # the impact point, along the hit and aside
    struck = oblique.sel(member="Aa0-Aa1/2").isel(point=0)
    along = cos(radians(OBLIQUE)) * struck["shape_x"] + sin(radians(OBLIQUE)) * struck["shape_z"]
    shown = np.interp(oblique["snapshot_at"], oblique["time"], oblique["displacement"])
    assert np.abs(along.values - shown).max() < 1e-6


def test_pinned_beams_hold_less_and_carry_no_moment():
    pinned = answered(hit(bay(joint="pinned"), OBLIQUE))
    assert float(np.abs(pinned["moment"].sel(hinge="Aa1-Ba1:start")).max()) < 1e-6
    assert pinned["peak_displacement"] > peak(hit(bay(), OBLIQUE))


def test_a_pulse_presses_a_face_along_z():
    pulse = Pulse("triangular", peak=3e4, length=0.03)
    face = ("Aa0-Aa1/1", "Aa0-Aa1/2", "Ba0-Ba1")
    event = FramePulse("blast", bay(), pulse, node="Aa1", members=face, angle=0.5 * pi)
    response = answered(event)
    moved = response.sel(member="Ba0-Ba1").isel(point=-1)
    aside = np.abs(moved["shape_x"] - 5.0).max()
    assert float(np.abs(moved["shape_z"]).max()) > 10.0 * float(aside)


@pytest.mark.parametrize("axis", [None, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
def test_elastic_frames_in_space_bend_as_bars_do(axis):
    # a leaning cantilever under unit loads along its axis, height and width, and turned by torsion
    along, roll, length = np.array([1.0, 2.0, 2.0]), 0.4, 3.0
    nodes = (Node("base", 0.0, 0.0, "clamped"), Node("tip", *along[:2], z=float(along[2])))
    frame = Frame(nodes, (Member("m", "base", "tip", HEB, roll=roll),))
    elastic, modulus = ElasticFrame(frame), frame.steel.elastic_modulus
    weak = HEB.about("weak")
    softness = np.array([length / (modulus * HEB.area)] + [length**3 / (3.0 * modulus)] * 2)
    softness[1:] /= HEB.second_moment, weak.second_moment
    height = frame.heights[0]
    rows = np.stack([along / length, height, np.cross(along / length, height)])
    load = np.zeros(len(elastic.stiffness))
    if axis is None:
        load[9:12] = along / length
        turned = elastic.displacement(load)[9:12] @ along / length
        twist = frame.steel.shear_modulus * torsion_constants(HEB)[0]
        assert turned == pytest.approx(length / twist, rel=1e-9)
        return
    load[6:9] = np.array(axis) @ rows
    moved = rows @ elastic.displacement(load)[6:9]
    assert moved == pytest.approx(np.array(axis) * softness, rel=1e-9, abs=1e-14)


def test_dead_loads_buckle_the_frame_about_the_weak_axis():
    frame = bay(load=1e5)
    state, plane = dead_load_state(frame), dead_load_state(bay((), load=1e5))
    assert state.axial.min() == pytest.approx(-1e5, rel=0.02)
    assert state.factor < plane.factor


def test_bars_deflect_under_dead_loads_as_the_elastic_frame_does():
    frame = replace(bay(), loads=(Load("Aa1", y=-1e4), Load("Bb1", y=-3e4)))
    model = SuperelementSpace(hinge_stiffness=1e6)
    structure = model.structure(hit(frame))
    elastic = ElasticFrame(frame)
    expected = elastic.displacement(elastic.load(frame.loads))
    for name in ("Aa1", "Bb1", "Ab1", "hit"):
        at = 6 * frame.number[name]
        dofs = [structure.assembly.dof(frame.number[name], c) for c in ("u", "v", "w")]
        found = structure.assembly.displacement[dofs]
        assert found == pytest.approx(expected[at : at + 3], rel=0.02, abs=1e-8)


def test_members_lie_with_their_height_upright_and_roll():
    frame = bay()
    names = [member.name for member in frame.members]
    assert frame.heights[names.index("Aa1-Ab1")] == pytest.approx([0.0, 1.0, 0.0])
    assert frame.heights[names.index("Ba0-Ba1")] == pytest.approx([1.0, 0.0, 0.0])
    rolled = replace(frame.member("Ba0-Ba1"), roll=0.5 * pi)
    weak = replace(frame.member("Ba0-Ba1"), axis="weak")
    for member in (rolled, weak):
        turned = replace(
            frame, members=(member, *(m for m in frame.members if m.name != "Ba0-Ba1"))
        )
        assert np.abs(turned.heights[0]) == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)


def test_a_regular_frame_has_rows_along_z_and_goes_through_files(tmp_path):
    frame = regular_frame((6.0, 6.0), (3.5, 3.0, 3.0), HEB, IPE, depths=(5.0, 4.0))
    assert (len(frame.nodes), len(frame.members)) == (36, 27 + 36)
    assert frame.node("Cc3").z == 9.0
    event = hit(frame.split("Aa0-Aa1", 1.0, "hit"), 20.0)
    assert scenario_from(tomllib.loads(to_toml(event))) == event
    path = tmp_path / "frame.toml"
    path.write_text(
        'kind = "frame-impact"\nname = "corner"\n[frame]\nbays = [6.0]\nstoreys = [3.5]\n'
        'depths = [5.0]\ncolumn = "HEB 220"\nbeam = "IPE 300"\n[[split]]\nmember = "Aa0-Aa1"\n'
        'at = 1.0\nnode = "hit"\n[striker]\nmass = 1500\nvelocity = 10\nnode = "hit"\n'
        'angle = "30 deg"\n'
    )
    assert load_scenario(path).striker.angle == pytest.approx(radians(30.0))


def test_a_plane_file_says_nothing_of_space():
    text = to_toml(hit(bay(())))
    assert [word for word in (" z = ", "roll", "depths", "angle") if word in text] == []


REFUSED = [
    (FlexibleSuperelement(), hit(bay()), "in space"),
    (FlexibleSuperelement(), hit(bay(()), 5.0), "in space"),
    (SuperelementSpace(), hit(replace(bay(), loads=(Load("Aa1", x=1e3),))), "load along x"),
    (SuperelementSpace(), hit(replace(bay(), loads=(Load("Aa1", moment=1e3),))), "moment on node"),
    (FiberSpace(levels=1), hit(bay(joint="pinned")), "joint pinned"),
]


@pytest.mark.parametrize(("model", "event", "why"), REFUSED)
def test_models_refuse_what_they_do_not_know(model, event, why):
    response = model.simulate(event)
    assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
    (refusal,) = (each for each in findings_of(response) if each.refusal)
    assert why in refusal.text


def test_a_push_of_a_frame_in_space_is_no_question_for_them():
    push = FrameStatic("push", bay(), (Load("Aa1", x=1e3),), "Aa1", "x", (0.01,))
    for model in (SuperelementSpace(), FlexibleSuperelement()):
        assert outcome_of(model.simulate(push)) is Outcome.OUT_OF_DOMAIN
    assert "frame" not in " ".join(FourDof.answers)


@pytest.mark.parametrize(
    ("make", "path"),
    [
        (lambda: FrameStriker(1500, 10, node="hit", direction="+y", angle=0.3), "striker.angle"),
        (lambda: regular_frame((6.0,), (3.0,), HEB, IPE, depths=(5000.0,)), "frame.depths.0"),
        (lambda: regular_frame((6.0,), (3.0,), HEB, IPE, depths=(5.0,) * 26), "frame.depths"),
        (lambda: Node("A", 0.0, 0.0, z=2e4), "node.A.z"),
        (lambda: Member("m", "A", "B", HEB, roll=30.0), "member.m.roll"),
        (
            lambda: Frame(
                (Node("A", 0.0, 0.0, "pinned"), Node("B", 0.0, 3.0, z=1.0)),
                (Member("m", "A", "B", HEB),),
            ),
            "node.support",
        ),
    ],
)
def test_bad_parts_are_named(make, path):
    with pytest.raises(InputError) as error:
        make()
    assert error.value.field.endswith(path.rpartition(".")[2])


def test_turning_leaves_plane_hits_alone():
    event = hit(bay())
    assert facing(event) is event
    placed = place_frame(facing(hit(bay(), 90.0)).frame, [np.array([1.0])] * 9)
    assert placed.mesh.coordinates.shape[1] == 3
