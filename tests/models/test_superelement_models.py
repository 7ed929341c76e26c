"""Superelement models: contract, closed forms, symmetry, joints, ledger, random frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import SQUARE, THESIS_SPRINGS, Answers, absorbed, portal
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.base.errors import InputError
from workbench.mechanics.frames.elastic import dead_load_state
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.references.fiber_beams import FiberReissner, FiberShear
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.responses import Outcome, Response, collapse_of, outcome_of, warnings_of
from workbench.scenarios import (
    Column,
    ColumnImpact,
    ColumnPushover,
    Frame,
    FrameGroundMotion,
    FrameImpact,
    FrameStatic,
    FrameStriker,
    Joint,
    Load,
    Member,
    MemberPulse,
    Node,
    Pulse,
    Striker,
    cyclic_path,
    frame_of,
    regular_frame,
)
from workbench.steel.sections import find, i_section, section_from
from workbench.testing import check_model

MODELS = (RigidSuperelement(), FlexibleSuperelement())
both = pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)


def hit_portal(velocity: float = 10.0, **options: object) -> FrameImpact:
    frame = portal(**options).split("A0-A1", 1.5, "hit")
    return FrameImpact("hit", frame, FrameStriker(1000.0, velocity, node="hit"), 0.04)


def answered(response: Response) -> Response:
    assert outcome_of(response) is Outcome.OK, response.attrs["message"]
    return response


# -- contract --------------------------------------------------------------------------------


@pytest.mark.thorough
@pytest.mark.usefixtures("few_load_steps")
@both
def test_it_keeps_the_contract_of_a_model(model, thesis_impact) -> None:
    dead = (Load("A1", y=-2e5), Load("B1", y=-2e5))
    push = FrameStatic("push", portal(loads=dead), (Load("A1", x=1e3),), "A1", "x", (0.2,))
    shake = FrameGroundMotion(
        "shake", portal(), tuple(5.0 * np.sin(np.arange(60.0))), 0.01, "A1", damping=0.5
    )
    scenarios = [
        hit_portal(loads=dead),
        replace(thesis_impact, duration=0.02),
        push,
        ColumnPushover("push", thesis_impact.column, 0.1),
        shake,
    ]
    check_model(model, scenarios)


@pytest.mark.parametrize(
    "options",
    [
        {"alpha": 0.5},
        {"beta": 0.9},
        {"elements": 0},
        {"regularisation": 1.0},
    ],
    ids=str,
)
def test_bad_options_are_refused(options) -> None:
    with pytest.raises(InputError, match=f"option.{next(iter(options))}"):
        RigidSuperelement(**options)


# -- closed forms ----------------------------------------------------------------------------


def test_rigid_bars_are_exact_in_sway() -> None:
    """A portal with a rigid beam: 24 EI / L^3; its beam a hundred times deeper in stiffness."""
    frame = portal()
    stiff = replace(frame.member("A1-B1"), second_moment=1.0, area=2.0)
    frame = replace(frame, members=(*frame.members[:2], stiff))
    push = FrameStatic("sway", frame, (Load("A1", x=1.0),), "A1", "x", (1e-5,))
    bending = frame.steel.elastic_modulus * SQUARE.second_moment
    expected = 24.0 * bending / 4.0**3
    stiffer = FlexibleSuperelement(alpha=1, beta=1, hinge_stiffness=1e6)
    for model, tolerance in ((RigidSuperelement(), 2e-3), (stiffer, 2e-3)):
        response = answered(model.simulate(push))
        stiffness = float(response["force"][-1] / response["displacement"][-1])
        assert stiffness == pytest.approx(expected, rel=tolerance)  # measured 1.25e-3


def test_storeys_drift_as_a_whole_and_hinges_tell_their_extremes() -> None:
    """Both parts of a split column have the drift of its storey; the beam has none."""
    frame = portal().split("A0-A1", 1.5, "mid")
    push = FrameStatic("sway", frame, (Load("A1", x=1e5),), "A1", "x", (0.4, 0.1))
    response = answered(RigidSuperelement().simulate(push))
    drift = response["drift"].to_series()
    assert set(drift.index) == {"A0-A1/1", "A0-A1/2", "B0-B1"}
    assert drift["A0-A1/1"] == drift["A0-A1/2"] == pytest.approx(0.1, rel=1e-9)
    assert drift["B0-B1"] == pytest.approx(0.1, rel=0.02)
    assert float(response["largest_drift"]) == drift.max()
    turned = np.abs(response["plastic_rotation"].values)
    assert float(response["largest_plastic_rotation"]) == turned.max() > 0.05
    assert float(response["largest_tension"]) == response["axial_force"].values.max()
    assert float(response["largest_compression"]) == -response["axial_force"].values.min()


@pytest.mark.thorough
@both
def test_a_web_that_slides_turns_no_hinge(model) -> None:
    """A stub whose flanges stay elastic slides; a cantilever of four times the length bends."""
    for length, moved in ((0.5, 0.05), (2.0, 0.2)):
        member = Member("m", "root", "tip", section=find("HEB 220"))
        nodes = (Node("root", 0.0, 0.0, support="clamped"), Node("tip", length, 0.0))
        frame = Frame(nodes, (member,), fillets=False)
        push = FrameStatic("tip", frame, (Load("tip", y=1.0),), "tip", "y", (moved,))
        response = answered(model.simulate(push))
        force, path = response["force"].values, response["displacement"].values
        plastic = moved - force[-1] * path[1] / force[1]
        turned, slid = plastic / length, 0.0
        if length == 0.5:
            turned, slid = 0.0, plastic
            shear = frame.properties("m").shear_resistance
            assert force[-1] == pytest.approx(shear, rel=0.25)  # that of the web alone
        value = float(response["largest_plastic_rotation"])
        assert value == pytest.approx(turned, rel=0.02, abs=1e-9)
        assert float(response["largest_sliding"]) == pytest.approx(slid, abs=0.015 * moved)
        assert response["sliding"].dims[0] == "segment"


@pytest.mark.thorough
@pytest.mark.parametrize("joint", [0.0, 1e5, 1e6, 1e7, None])
def test_semi_rigid_joints(joint) -> None:
    """Portal with a beam on springs: k = 12 i / h^2 (1 + 6 r) / (2 + 3 r) and r by the springs."""
    frame = replace(portal(), joints=(Joint("semi", rotational_stiffness=joint),))
    beam = replace(frame.member("A1-B1"), joint_start="semi", joint_end="semi", area=2.0)
    frame = replace(frame, members=(*frame.members[:2], beam))
    bending = frame.steel.elastic_modulus * SQUARE.second_moment
    # antisymmetric bending of the beam: 6 EI / L in series with the spring
    stiffness = 6.0 * bending / 6.0
    if joint is not None:
        stiffness = 1.0 / (1.0 / stiffness + 1.0 / joint) if joint else 0.0
    column = bending / 4.0
    condensed = 12.0 * column - (6.0 * column) ** 2 / (4.0 * column + stiffness)
    expected = 2.0 * condensed / 4.0**2
    push = FrameStatic("sway", frame, (Load("A1", x=1.0),), "A1", "x", (1e-5,))
    response = answered(FlexibleSuperelement(hinge_stiffness=1e6).simulate(push))
    value = float(response["force"][-1] / response["displacement"][-1])
    assert value == pytest.approx(expected, rel=1e-3)  # measured 4.7e-4


def test_a_partial_strength_joint_yields_at_its_own_moment() -> None:
    """A cantilever pushed at its tip; sagging and hogging differ, start and end too."""
    joint = Joint("weak", plastic_moment=2e5, plastic_moment_negative=1e5)
    for clamp, tip in (("start", "end"), ("end", "start")):
        names = (
            {"start": "root", "end": "tip"} if clamp == "start" else {"start": "tip", "end": "root"}
        )
        member = Member("m", section=SQUARE, **names, **{f"joint_{clamp}": "weak"})
        nodes = (Node("root", 0.0, 0.0, support="clamped"), Node("tip", 2.0, 0.0))
        frame = Frame(nodes, (member,), joints=(joint,))
        for direction, looking in (("y", 1.0), ("-y", -1.0)):
            load = (Load("tip", y=1.0 if direction == "y" else -1.0),)
            push = FrameStatic("tip", frame, load, "tip", direction, (0.02,))
            response = answered(RigidSuperelement().simulate(push))
            # upward force on the tip stretches the lower fibers: on the right, looking to the tip
            along = 1.0 if clamp == "start" else -1.0
            bound = 2e5 if looking * along > 0.0 else 1e5
            moment = response["moment"].sel(hinge=f"m:{clamp}").values[-1]
            assert moment == pytest.approx(looking * along * bound, rel=1.4e-4)  # measured 6.9e-5
            rotation = response["plastic_rotation"].sel(hinge=f"m:{clamp}").values[-1]
            assert rotation * moment > 0.0
            # measured 5.6e-5
            assert float(response["force"][-1]) == pytest.approx(bound / 2.0, rel=1.2e-4)
            # measured: none
            assert abs(float(response["moment"].sel(hinge=f"m:{tip}").values[-1])) < 1e-6


def test_a_strut_between_free_ends_shortens() -> None:
    """Both ends may turn: only the axial stiffness EA / L is left."""
    nodes = (Node("a", 0.0, 0.0, support="pinned"), Node("b", 2.0, 0.0, support="roller-x"))
    frame = Frame(nodes, (Member("strut", "a", "b", SQUARE),))
    push = FrameStatic("push", frame, (Load("b", x=-1.0),), "b", "-x", (1e-4,))
    for model in MODELS:
        response = answered(model.simulate(push))
        softer = 1.0 if model is MODELS[0] else 1.1  # hinges ten times as stiff, in series
        expected = 210e9 * SQUARE.area / 2.0 * 1e-4 / softer
        # measured: round-off
        assert float(response["force"][-1]) == pytest.approx(expected, rel=1e-8)


def test_a_pinned_beam_end_carries_no_moment() -> None:
    frame = portal()
    beam = replace(frame.member("A1-B1"), joint_start="pinned")
    frame = replace(frame, members=(*frame.members[:2], beam))
    impact = FrameImpact("hit", frame, FrameStriker(500.0, 10.0, node="A1"), 0.02)
    for model in MODELS:
        response = answered(model.simulate(impact))
        moment = np.abs(response["moment"].sel(hinge="A1-B1:start").values)
        assert moment.max() < 1e-12 * SQUARE.plastic_moment(frame.steel)  # measured: none


def test_a_free_mass_only_moves_on() -> None:
    """Momentum: a bar on rollers hit along its axis."""
    nodes = (
        Node("a", 0.0, 0.0, support="guide-x", spring_x=1.0),
        Node("b", 2.0, 0.0, support="guide-x"),
    )
    frame = Frame(nodes, (Member("bar", "a", "b", SQUARE),))
    impact = FrameImpact("hit", frame, FrameStriker(100.0, 5.0, 1.0, node="a"), 0.01)
    response = answered(RigidSuperelement(time_step=1e-5).simulate(impact))
    given = 100.0 * 5.0
    struck = float(response["percussion"].sum())
    left = 100.0 * float(response["striker_velocity"][-1])
    assert struck + left == pytest.approx(given, rel=1e-9)
    error = np.abs(response["balance_error"]).max() / response["input_energy"]
    assert float(error) < 1e-8


# -- symmetry --------------------------------------------------------------------------------


@both
def test_mirrored_and_turned_frames_answer_alike(model) -> None:
    impact, model = hit_portal(), replace(model, time_step=1e-4)  # steps by error see round-off
    expected = answered(model.simulate(impact))["displacement"].values
    frame = impact.frame
    mirrored = replace(frame, nodes=tuple(replace(n, x=-n.x) for n in frame.nodes))
    turned = replace(frame, nodes=tuple(replace(n, x=-n.y, y=n.x) for n in frame.nodes))
    swapped = replace(
        frame, members=tuple(replace(m, start=m.end, end=m.start) for m in frame.members)
    )
    for other, direction in ((mirrored, "-x"), (turned, "+y"), (swapped, "+x")):
        striker = replace(impact.striker, direction=direction)
        response = answered(model.simulate(replace(impact, frame=other, striker=striker)))
        np.testing.assert_allclose(
            # measured 4.2e-12
            response["displacement"],
            expected,
            atol=1e-8 * np.abs(expected).max(),
        )


def test_moments_turn_their_sign_with_the_member(thesis_impact) -> None:
    frame = hit_portal()
    reversed_ = replace(
        frame.frame,
        members=tuple(replace(m, start=m.end, end=m.start) for m in frame.frame.members),
    )
    model = RigidSuperelement(time_step=1e-4)
    there = answered(model.simulate(frame))
    back = answered(model.simulate(replace(frame, frame=reversed_)))
    for name in ("moment", "plastic_rotation"):
        scale = float(np.abs(there[name]).max())
        for hinge in there["hinge"].values:
            member, end = str(hinge).split(":")
            other = f"{member}:{'end' if end == 'start' else 'start'}"
            np.testing.assert_allclose(
                # measured 2.8e-10
                back[name].sel(hinge=other),
                -there[name].sel(hinge=hinge),
                atol=1e-8 * scale,
            )


# -- columns ---------------------------------------------------------------------------------


BARS_AND_LUMPED = [
    (RigidSuperelement(shear="none", elements=1), FourDof(**THESIS_SPRINGS)),
    (RigidSuperelement(elements=1), FourDofShear(hit_mass="thesis", **THESIS_SPRINGS)),
]


@pytest.mark.parametrize(("bars", "four"), BARS_AND_LUMPED, ids=["none", "panel"])
def test_a_column_is_answered_in_its_own_words(bars, four, thesis_impact) -> None:
    """Two rigid superelements are the four-dof column but for its mass."""
    impact = replace(thesis_impact, duration=0.03)
    frame, lumped = bars.simulate(impact), four.simulate(impact)
    assert list(frame["hinge"].values) == list(lumped["hinge"].values)
    assert list(frame["segment"].values) == list(lumped["segment"].values)
    for name in ("moment", "axial_force", "plastic_rotation", "shortening"):
        scale = float(np.abs(lumped[name]).max())
        known = lumped[name].interp(time=frame["time"].values)
        error = np.abs(frame[name].values - known.values)[..., -40:].mean(axis=-1)
        assert np.max(error) < 0.092 * scale, name  # measured 0.078; 0.046 with panels
    # measured 5.0e-3
    np.testing.assert_allclose(frame["shear_utilisation"], lumped["shear_utilisation"], rtol=1e-2)


@pytest.mark.parametrize(("bars", "four"), BARS_AND_LUMPED, ids=["none", "panel"])
def test_a_pinned_head_and_a_fixed_one(bars, four, thesis_impact) -> None:
    for head in ("pinned", "fixed"):
        column = replace(thesis_impact.column, head=head)
        impact = replace(thesis_impact.at_velocity(10.0), column=column)
        peaks = [
            float(answered(model.simulate(impact))["peak_displacement"]) for model in (bars, four)
        ]
        assert peaks[0] == pytest.approx(peaks[1], rel=2.5e-3)  # measured 0.0012


def test_static_panels_are_those_of_the_four_dof_column(thesis_impact) -> None:
    push = ColumnPushover("push", thesis_impact.column, 0.4)
    at = np.linspace(0.002, 0.4, 30)
    forces = [
        np.interp(at, response["displacement"], response["force"])
        for response in (model.simulate(push) for model in BARS_AND_LUMPED[1])
    ]
    # measured 3.2e-4: the share of elastic stiffness beside the hinges of superelements
    np.testing.assert_allclose(forces[0], forces[1], rtol=6.4e-4)


# -- paths -----------------------------------------------------------------------------------


@pytest.mark.thorough
def test_cycles_of_a_clamped_beam_stretch_it() -> None:
    """Full plastic cycles: dissipation grows all the time, the axial force builds up."""
    nodes = (
        Node("a", 0.0, 0.0, support="clamped"),
        Node("m", 2.0, 0.0),
        Node("b", 4.0, 0.0, support="clamped"),
    )
    frame = Frame(nodes, (Member("l", "a", "m", SQUARE), Member("r", "m", "b", SQUARE)))
    path = cyclic_path((0.1, 0.2))
    scenario = FrameStatic("cycles", frame, (Load("m", y=1.0),), "m", "y", path)
    for model in MODELS:
        response = answered(model.simulate(scenario))
        assert np.min(np.diff(response["dissipated"])) >= -1e-9
        assert float(response["displacement"].max()) == pytest.approx(0.2)
        assert float(response["displacement"].min()) == pytest.approx(-0.2)
        assert float(response["displacement"][-1]) == pytest.approx(0.0, abs=1e-12)
        error = np.abs(response["balance_error"]).max() / response["input_energy"]
        assert float(error) < 5e-7  # measured 2.6e-7


@pytest.mark.thorough
@pytest.mark.parametrize("control", ["displacement", "load", "arc-length"])
def test_all_controls_find_the_same_path(control) -> None:
    frame = portal(loads=(Load("A1", y=-5e5), Load("B1", y=-5e5)))
    pattern = (Load("A1", x=1e3), Load("B1", x=1e3))
    path = (0.03,)
    known = FrameStatic("push", frame, pattern, "B1", "x", path)
    expected = answered(FlexibleSuperelement().simulate(known))
    if control == "load":
        path = (float(expected["load_factor"].values[:500].max()),)
    scenario = replace(known, control=control, path=path)
    response = answered(FlexibleSuperelement().simulate(scenario))
    factor = np.interp(response["displacement"], expected["displacement"], expected["load_factor"])
    np.testing.assert_allclose(response["load_factor"], factor, rtol=1e-8, atol=1e-6)
    force = response["load_factor"] * 2e3
    np.testing.assert_allclose(response["force"], force, rtol=1e-12)


def test_ground_motion_of_an_elastic_portal_is_that_of_an_oscillator() -> None:
    """Damped resonance against the closed form of one degree of freedom."""
    mass = 2e4
    frame = portal(mass_per_length=0.01)
    frame = replace(
        frame,
        nodes=tuple(replace(n, mass=mass) if n.y else n for n in frame.nodes),
        members=(*frame.members[:2], replace(frame.members[2], second_moment=1.0, area=2.0)),
    )
    stiffness = 24.0 * frame.steel.elastic_modulus * SQUARE.second_moment / 4.0**3
    omega = np.sqrt(stiffness / (2.0 * mass))
    damping, amplitude, interval = 2.0 * 0.05 * omega, 0.05, 0.005
    time = np.arange(400) * interval
    motion = FrameGroundMotion(
        "resonance", frame, tuple(amplitude * np.sin(omega * time)), interval, "A1",
        damping=damping,
    )  # fmt: skip
    response = answered(RigidSuperelement().simulate(motion))
    # x'' + c x' + w^2 x = -A sin(w t): x = A/(c w) (cos w t - e^(-c t/2) (cos wd t + ...))
    t = response["time"].values
    decay = 0.5 * damping
    turned = np.sqrt(omega**2 - decay**2)
    free = np.exp(-decay * t) * (np.cos(turned * t) + decay / turned * np.sin(turned * t))
    exact = amplitude / (damping * omega) * (np.cos(omega * t) - free)
    scale = np.abs(exact).max()
    # measured 0.0104
    np.testing.assert_allclose(response["displacement"], exact, atol=0.02 * scale)


# -- snapshots -------------------------------------------------------------------------------


@both
def test_snapshots_show_the_frame(model) -> None:
    impact = hit_portal(20.0)
    response = answered(replace(model, elements=2).simulate(impact))
    count = response.sizes["snapshot"]
    assert 55 <= count <= 61
    at = response["snapshot_at"].values
    assert at[0] == 0.0
    assert at[-1] == response["time"].values[-1]
    assert np.all(np.diff(at) > 0.0)
    peak = float(response["time_of_peak"])
    assert np.min(np.abs(at - peak)) < 2.0 * response.attrs["time_step"]  # measured 1.01
    frame = impact.frame
    for member in frame.members:
        start, end = frame.node(member.start), frame.node(member.end)
        shape = response[["shape_x", "shape_y"]].sel(member=member.name)
        first = shape.isel(snapshot=0)
        np.testing.assert_allclose(first["shape_x"], np.linspace(start.x, end.x, 9), atol=1e-9)
        np.testing.assert_allclose(first["shape_y"], np.linspace(start.y, end.y, 9), atol=1e-9)
    # members that meet at a node meet in every picture, and the hit node is where it says
    hit = response["shape_x"].sel(member="A0-A1/1").values[-1]
    np.testing.assert_allclose(response["shape_x"].sel(member="A0-A1/2").values[0], hit, atol=1e-9)
    moved = np.interp(at, response["time"], response["displacement"])
    np.testing.assert_allclose(hit, moved, atol=1.2e-9)  # measured: round-off
    used = response["utilisation"].values
    assert used.min() >= 0.0
    assert used.max() == pytest.approx(1.0, abs=1e-8)  # measured: round-off


def test_snapshots_of_a_path_are_steps() -> None:
    push = FrameStatic(
        "push", portal(), (Load("A1", x=1.0),), "A1", "x", (0.4,), control="arc-length"
    )
    response = answered(RigidSuperelement().simulate(push))
    at = response["snapshot_at"].values
    assert len(at) <= 61
    assert at[0] == 0.0
    assert at[-1] == response.sizes["step"] - 1
    np.testing.assert_array_equal(at, at.round())


def test_a_path_that_turns_back_is_seen_where_it_turns() -> None:
    """The hinges yield there; a step later they are elastic again."""
    cycles = FrameStatic(
        "cycles", portal(), (Load("A1", x=1.0),), "A1", "x", cyclic_path([0.1, 0.2], 2)
    )
    response = answered(RigidSuperelement().simulate(cycles))
    displacement = response["displacement"].values
    turning = int(np.argmax(displacement > 0.2 - 1e-9))
    assert turning in response["snapshot_at"].values
    seen = response["utilisation"].sel(snapshot=response["snapshot_at"].values == turning)
    assert float(seen.max()) == pytest.approx(1.0, abs=1e-8)  # measured: round-off


def test_a_column_under_pinned_beams_is_a_cantilever() -> None:
    """3 EI/h^3 for each column of a portal whose beam is attached by pins."""
    frame = portal()
    beam = frame.member("A1-B1")
    pinned = replace(beam, joint_start="pinned", joint_end="pinned")
    members = tuple(pinned if member is beam else member for member in frame.members)
    height = frame.node("A1").y
    # measured 4.7e-4 and 0.048
    for model, tolerance in ((RigidSuperelement(), 9.4e-4), (FlexibleSuperelement(), 0.096)):
        push = FrameStatic(
            "push", replace(frame, members=members), (Load("A1", x=1.0),), "A1", "x", (1e-4,)
        )
        response = answered(model.simulate(push))
        column = frame.properties("A0-A1")
        stiffness = 6.0 * frame.steel.elastic_modulus * column.second_moment / height**3
        value = float(response["force"][-1] / response["displacement"][-1])
        # measured 0.048
        assert value == pytest.approx(stiffness, rel=tolerance)  # flexible: hinges in series


def test_a_weak_joint_whose_axial_force_changes_its_sign() -> None:
    """The path goes through the corner of the straight surface of the joint."""
    section, beam = find("HEB 220"), find("IPE 300")
    nodes = (
        Node("a", 0.0, 0.0, support="clamped"),
        Node("b", 0.0, 4.0),
        Node("c", 8.0, 4.0),
        Node("d", 8.0, 0.0, support="pinned"),
    )
    joint = Joint("plate", 2e7, plastic_moment=1.5e5, plastic_moment_negative=0.5e5)
    members = (
        Member("left", "a", "b", section),
        Member("beam", "b", "c", beam, joint_start="plate", joint_end="plate"),
        Member("right", "d", "c", section),
    )
    dead = (Load("b", y=-2e5), Load("c", y=-2e5))
    frame = Frame(nodes, members, joints=(joint,), loads=dead)
    push = FrameStatic("push", frame, (Load("b", x=1e3),), "b", "x", (0.3,))
    forces = []
    for model in (RigidSuperelement(), FlexibleSuperelement()):
        response = answered(model.simulate(push))
        axial = response["axial_force"].sel(hinge="beam:start").values
        assert axial.min() < 0.0 < axial.max()
        forces.append(float(response["force"][-1]))
    assert forces[0] == pytest.approx(forces[1], rel=2.7e-4)  # measured 1.4e-4


def test_a_load_beyond_the_mechanism_is_carried_by_another_shape_and_says_so() -> None:
    frame = portal()
    push = FrameStatic("push", frame, (Load("A1", x=1.0),), "A1", "x", (1.0,), control="load")
    mechanism = 4.0 * frame.properties("A0-A1").plastic_moment / 4.0
    for share, warned in ((0.8, False), (1.5, True)):
        response = answered(RigidSuperelement().simulate(replace(push, path=(share * mechanism,))))
        assert float(response["force"][-1]) == pytest.approx(share * mechanism)
        largest = float(np.abs(response["displacement"]).max())
        assert float(response["peak_displacement"]) == pytest.approx(largest)
        subjects = {finding.subject for finding in warnings_of(response)}
        assert ("large-displacements" in subjects) == warned == (largest > 0.3 * 4.0)


def test_every_striker_finds_the_structure_as_it_was(thesis_impact) -> None:
    """The frame under its dead loads is brought up once and hit by many."""
    model = RigidSuperelement(elements=1)
    impact = replace(thesis_impact, duration=0.01)
    first = answered(model.simulate(impact))
    faster = replace(impact, striker=replace(impact.striker, velocity=20.0))
    assert answered(model.simulate(faster))["displacement"].max() > first["displacement"].max()
    push = answered(model.simulate(ColumnPushover("push", impact.column, 0.05)))
    assert push["force"][0] == 0.0
    again = answered(model.simulate(impact))
    assert first.drop_attrs().identical(again.drop_attrs())


def test_a_mechanism_is_named_before_it_is_pushed() -> None:
    frame = portal(base="pinned", joint_start="pinned", joint_end="pinned")
    push = FrameStatic("push", frame, (Load("A1", x=1e3),), "A1", "x", (0.1,))
    findings = RigidSuperelement().domain(push)
    assert [(f.subject, f.refusal) for f in findings if f.subject == "mechanism"] == [
        ("mechanism", False)
    ]


# -- ledger ----------------------------------------------------------------------------------


@both
@pytest.mark.parametrize("steps", [3000, pytest.param(10_000, marks=pytest.mark.slow)])
def test_ledger_closes_over_thousands_of_steps(model, steps: int) -> None:
    """Impact, large plastic deformation and free vibration."""
    impact = replace(hit_portal(25.0), duration=5e-5 * steps)
    response = answered(replace(model, time_step=5e-5).simulate(impact))
    assert response.sizes["time"] >= steps + 1
    error = np.abs(response["balance_error"]).max() / response["input_energy"]
    assert float(error) < 1e-8  # measured 2.5e-11
    assert float(response["dissipated"][-1]) > 0.3 * float(response["input_energy"])


# -- outside the domain ----------------------------------------------------------------------


def test_a_column_that_is_run_over_collapses() -> None:
    frame = portal(loads=(Load("A1", y=-1e6), Load("B1", y=-1e6)))
    impact = FrameImpact("crash", frame, FrameStriker(2e4, 60.0, node="A1"), 1.0)
    for model in MODELS:
        response = model.simulate(impact)
        assert outcome_of(response) is Outcome.COLLAPSE
        collapse = collapse_of(response)
        assert collapse.mechanism == "geometry"
        assert collapse.parts == ("A0-A1",)
        assert 0.0 < collapse.time < 1.0
        assert collapse.displacement > 0.5 * 4.0


def test_only_members_that_are_rigid_in_shear_are_named() -> None:
    frame = portal(section=find("HEB 220"), height=0.36)
    mixed = [m if m.name != "B0-B1" else replace(m, section=SQUARE) for m in frame.members]
    short = replace(frame, members=tuple(mixed)).split("A0-A1", 0.18, "hit")
    impact = FrameImpact("hit", short, FrameStriker(1000.0, 5.0, node="hit"), 0.02)
    text = " ".join(str(f) for f in RigidSuperelement().domain(impact) if f.subject == "shear")
    assert "B0-B1" in text
    assert "A0-" not in text
    everything = RigidSuperelement(shear="none").domain(impact)
    assert "A0-" in " ".join(str(f) for f in everything if f.subject == "shear")


def test_members_alike_are_told_of_once() -> None:
    """Slender webs: one sentence for the columns, none for squares."""
    frame = portal(section=i_section(0.8, 0.2, 0.006, 0.012))
    mixed = replace(frame, members=(*frame.members[:2], replace(frame.members[2], section=SQUARE)))
    hit = FrameImpact("hit", mixed, FrameStriker(1000.0, 5.0, node="A1"), 0.02)
    (finding,) = (f.text for f in RigidSuperelement().domain(hit) if f.subject == "shear-buckling")
    assert "member A0-A1 (and 1 alike)" in finding


def test_panels_of_default_members_have_the_strength_of_fibers() -> None:
    """Plates alone took 5 % of IPE 240, and a pulse that hardly passes its strength doubled it."""
    column = Column(find("IPE 240"), 2.5, 2.5)
    push = ColumnPushover("push", column, 0.1)
    fibers, *bars = (
        model.simulate(push)
        for model in (FiberReissner(levels=1), RigidSuperelement(), FlexibleSuperelement())
    )
    for response in bars:
        assert not [f for f in warnings_of(response) if f.subject == "plates"]
        # 0.939 with plates alone; measured 0.983
        assert float(response["force"][-1] / fibers["force"][-1]) == pytest.approx(1.0, abs=0.02)


def default_members() -> list[ColumnImpact | MemberPulse]:
    """With their root fillets: a long hit, a low one that slides, a pulse on a line."""
    long = Column(find("IPE 400"), 2.05, 3.62, axial_load=678e3)
    low = Column(find("HEA 300"), 1.34, 1.48, axial_load=671e3)
    held = {"base": "pinned", "head": "pinned", "restraint_stiffness": 1e8}
    blast = Column(find("IPE 400"), 3.17, 3.17, **held)
    return [
        ColumnImpact("long", long, Striker(35279.0, 3.0), 0.3),
        ColumnImpact("low", low, Striker(60000.0, 1.5), 0.2),
        MemberPulse("blast", blast, Pulse("triangular", 9e4, 0.09), "uniform", 0.15),
    ]


@pytest.mark.slow
@pytest.mark.parametrize("scenario", default_members(), ids=lambda each: each.name)
def test_default_members_follow_fibers_that_yield_in_shear(scenario) -> None:
    beam = answered(FiberShear(levels=1).simulate(scenario))
    for model in (*MODELS, FourDofShear()):
        if isinstance(scenario, ColumnImpact) or model in MODELS:
            peak = float(answered(model.simulate(scenario))["peak_displacement"])
            # 1.12 and 1.13 with plates alone; measured 0.98 to 1.043
            assert peak == pytest.approx(float(beam["peak_displacement"]), rel=0.1)


def test_a_short_i_section_member_warns_of_shear(thesis_impact) -> None:
    frame = frame_of(thesis_impact.column)
    impact = FrameImpact("hit", frame, FrameStriker(1500.0, 10.0, node="hit"), 0.03)
    values = {}
    for shear in ("none", "panel"):
        response = answered(RigidSuperelement(shear=shear).simulate(impact))
        values[shear] = {finding.subject for finding in warnings_of(response)}
    # the run has found what the mechanism had announced, and says it alone
    assert "shear" in {result.subject for result in RigidSuperelement(shear="none").domain(impact)}
    assert {"shear", "shear-reached"} & values["none"] == {"shear-reached"}
    assert not {"shear", "shear-reached"} & values["panel"]
    assert float(response["shear_utilisation"].max()) <= 1.0 + 1e-9


def test_exponents_do_not_apply_to_panels_and_it_says_so(thesis_impact) -> None:
    (finding,) = RigidSuperelement(alpha=1.0).domain(thesis_impact)
    assert finding.subject == "exponents"


# -- random frames ---------------------------------------------------------------------------

SECTIONS = [
    SQUARE,
    find("HEB 220"),
    find("IPE 300"),
    section_from({"diameter": 0.2, "wall": 0.01}, "s"),
]


@st.composite
def impacts(draw: st.DrawFn) -> FrameImpact:
    bays = draw(st.lists(st.floats(2.0, 8.0), min_size=1, max_size=4))
    storeys = draw(st.lists(st.floats(2.5, 5.0), min_size=1, max_size=4))
    column, beam = draw(st.sampled_from(SECTIONS)), draw(st.sampled_from(SECTIONS))
    frame = regular_frame(bays, storeys, column, beam, draw(st.sampled_from(["clamped", "pinned"])))
    member = draw(st.sampled_from(frame.members))
    length = frame.length(member)
    frame = frame.split(member, draw(st.floats(0.1, 0.9)) * length, "hit")
    if draw(st.booleans()):
        load = draw(st.floats(1e3, 1e6))
        tops = [n.name for n in frame.nodes if n.y == max(m.y for m in frame.nodes)]
        frame = replace(frame, loads=tuple(Load(name, y=-load) for name in tops))
    upright = member.start[0] == member.end[0]
    striker = FrameStriker(
        draw(st.floats(10.0, 5e3)),
        draw(st.floats(0.5, 80.0)),
        draw(st.sampled_from([0.0, 0.5, 1.0])),
        node="hit",
        direction=draw(st.sampled_from(["+x", "-x"] if upright else ["+y", "-y"])),
    )
    return FrameImpact("random", frame, striker, 0.01)


def bears(impact: FrameImpact) -> bool:
    """Whether the struck member absorbs the energy; dead loads are a matter of the domain.

    But for one on the impact point of a beam, whose bending no check of the domain sees. The hinges
    of the member, and those of the weakest at its ends, are reduced by its axial force.
    """
    frame = impact.frame
    state = dead_load_state(frame)
    if any(load.node == "hit" for load in frame.loads):
        return False
    parts = [i for i, m in enumerate(frame.members) if "hit" in (m.start, m.end)]
    axial = max(-float(state.axial[i]) for i in parts)
    struck = frame.members[parts[0]].section
    left = 1.0 - abs(axial) / struck.squash_load(frame.steel)
    weakest = min(member.section.plastic_moment(frame.steel) for member in frame.members)
    ends = [
        0.0 if frame.node(name).support == "pinned" else left * weakest
        for name in (frame.members[parts[0]].start, frame.members[parts[1]].end)
    ]
    lengths = tuple(frame.length(frame.members[i]) for i in parts)
    moment = left * struck.plastic_moment(frame.steel)
    return impact.input_energy <= absorbed(lengths, moment, tuple(ends), max(axial, 0.0))


@pytest.mark.thorough
@pytest.mark.parametrize("examples", [75, pytest.param(150, marks=pytest.mark.slow)])
def test_random_frames_run_or_end_in_a_typed_outcome(examples: int) -> None:
    answers = Answers()

    @settings(max_examples=examples)
    @given(impacts(), st.sampled_from(MODELS), st.sampled_from(["none", "none", "panel"]))
    def check(impact: FrameImpact, model, shear: str) -> None:
        model = replace(model, time_step=1e-4, shear=shear)
        response = model.simulate(impact)
        if not answers.note(model, impact, response, asked=shear == "none" and bears(impact)):
            typed = Outcome.COLLAPSE, Outcome.OUT_OF_DOMAIN, Outcome.NOT_CONVERGED
            assert outcome_of(response) in typed
            assert len(response.attrs["message"].split()) > 5
            return
        error = np.abs(response["balance_error"]).max() / response["input_energy"]
        assert float(error) < 1e-7  # measured 1.5e-8
        assert np.min(np.diff(response["dissipated"])) >= -1e-9 * impact.input_energy

    check()
    answers.demand()
