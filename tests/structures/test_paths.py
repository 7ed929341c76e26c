"""Displacement and load control of any dof under any pattern, beside dead loads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from frame_cases import HEIGHT, SPAN, bar, portal
from hypothesis import given
from hypothesis import strategies as st
from reissner_cases import FY, SIDE, E, chain, elastic, square, straight

from workbench.base.errors import InputError, SolverError
from workbench.mechanics.structures.fibers.section import LinearHardening
from workbench.mechanics.structures.paths import (
    PathStep,
    apply_loads,
    follow_displacement,
    follow_load,
    push,
)

PLASTIC_MOMENT = 0.25 * FY * SIDE**3


def loads(frame, names, **forces) -> np.ndarray:
    """A pattern of loads: knee_left_u=1.0 and the like."""
    pattern = np.zeros(frame.size)
    for key, value in forces.items():
        node, component = key.replace("_", "-").rsplit("-", 1)
        pattern[frame.dof(names[node], component)] = value
    return pattern


def mixed(frame, names) -> np.ndarray:
    """Forces at three nodes and a moment; none at the right knee in u."""
    return loads(
        frame, names, knee_left_u=1e5, side_left_u=5e4, crown_v=-1e5, knee_right_rotation=2e4
    )


def balance(start: float, steps: list[PathStep]) -> float:
    """What the ledger of a path lacks, over the work."""
    work = sum(s.external_work for s in steps)
    spent = steps[-1].energies.stored - start + sum(s.energies.plastic for s in steps)
    turned = sum(abs(s.external_work) for s in steps)
    return abs(work - spent) / turned


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("node", "component"),
    [("crown", "v"), ("knee-right", "u"), ("knee-right", "rotation"), ("side-left", "rotation")],
)
def test_a_small_path_is_linear(node, component, sign) -> None:
    """factor = displacement / (K^-1 p), for dofs with and without a load of their own."""
    frame, names = portal()
    pattern = mixed(frame, names)
    dof = frame.dof(names[node], component)
    frame.assemble(frame.displacement, None)
    flexibility = frame.solve(pattern)
    small = 1e-7
    *_, last = follow_displacement(frame, pattern, dof, sign, [small], 0.5 * small)
    assert last.displacement == pytest.approx(small, rel=1e-12)
    assert frame.displacement[dof] == pytest.approx(sign * small, rel=1e-12)
    # measured 4.8e-7
    assert last.factor == pytest.approx(sign * small / flexibility[dof], rel=1e-6)
    np.testing.assert_allclose(
        # measured 1.0e-5
        frame.displacement,
        last.factor * flexibility,
        rtol=0.0,
        atol=2.1e-5 * small,
    )


def test_a_led_rotation_rolls_a_beam_up() -> None:
    """M = EI theta / L on the way round, with the moment as the pattern."""
    beam = straight(4.0, 10, elastic(0.01, bending=5.0))
    beam.hold(range(3))
    end = beam.dof(10, "rotation")
    pattern = np.zeros(beam.size)
    pattern[end] = 2.0
    for step in follow_displacement(beam, pattern, end, -1.0, [2 * np.pi], np.pi / 4, 1e-12):
        assert step.factor == pytest.approx(-0.5 * 5.0 * step.displacement / 4.0, rel=1e-9)
    tip = beam.coordinates[10] + beam.displacement[beam.dofs([10], "u")[0] :][:2]
    assert np.linalg.norm(tip) <= 1e-9
    assert step.displacement == pytest.approx(2 * np.pi, rel=1e-12)


@pytest.mark.parametrize("led", ["knee-left", "knee-right"])
def test_control_by_displacement_and_by_load_agree(led) -> None:
    """The same elastic-plastic state under dead loads, from either side."""
    reached = []
    for control in ("displacement", "load"):
        frame, names = portal()
        frame.load[:] = loads(frame, names, crown_v=-3e5)
        apply_loads(frame)
        begin, pattern = frame.stored, mixed(frame, names)
        dof = frame.dof(names[led], "u")
        if control == "displacement":
            steps = list(follow_displacement(frame, pattern, dof, 1.0, [0.06], 1e-3))
        else:
            steps = list(follow_load(frame, pattern, [reached[0].factor], dof, 1.0, 0.02))
        assert steps[-1].energies.stored > begin
        assert sum(s.energies.plastic for s in steps) > 1e3
        assert balance(begin, steps) < 3e-6  # measured 1.4e-6
        reached.append(steps[-1])
    assert reached[1].factor == pytest.approx(reached[0].factor, rel=1e-12)
    # measured: round-off
    assert reached[1].displacement == pytest.approx(reached[0].displacement, rel=1e-8)


@pytest.mark.parametrize("dead", [False, True])
def test_collapse_of_a_portal_in_the_combined_mechanism(dead) -> None:
    """H h + V l / 2 = 6 Mp; V grows with H, or rests on the beam before. Soft: no P-delta."""
    soft = square()
    soft = replace(soft, law=LinearHardening(E, FY / 50.0, 1e-6 * E))
    sway, crown = PLASTIC_MOMENT / 50.0 / HEIGHT, PLASTIC_MOMENT / 25.0 / SPAN
    factors = []
    for parts in (4, 8, 16):
        frame, names = portal(parts, soft)
        pattern = loads(frame, names, knee_left_u=sway, crown_v=-crown)
        if dead:
            frame.load[:] = loads(frame, names, crown_v=-3.0 * crown)
            apply_loads(frame)
            pattern = loads(frame, names, knee_left_u=sway)
        dof = frame.dof(names["knee-left"], "u")
        steps = list(follow_displacement(frame, pattern, dof, 1.0, [4e-3], 1e-4))
        factors.append(max(s.factor for s in steps))
    # displacement-based elements overestimate in proportion to their size
    limit = factors[2] + (factors[2] - factors[1])
    assert factors[0] > factors[1] > factors[2]
    assert limit == pytest.approx(3.0, rel=0.01)


@pytest.mark.parametrize("hardening", [0.0, 2.1e9])
def test_hysteresis_of_a_bar(hardening) -> None:
    """Force and plastic work of a cycle, in closed form; the strength stays (kinematic)."""
    rod, dof = bar(hardening)
    pattern = np.zeros(rod.size)
    pattern[dof] = 1e3
    yields = FY / 210e9 * 2.0
    amplitude = 4.0 * yields
    tangent = 210e9 * hardening / (210e9 + hardening) * 1e-3 / 2.0
    top = 355e3 + tangent * (amplitude - yields)
    targets = [amplitude, -amplitude, amplitude, -amplitude, amplitude]
    steps = list(follow_displacement(rod, pattern, dof, 1.0, targets, amplitude / 200.0))
    at = {round(s.displacement / amplitude, 9): s.factor * 1e3 for s in steps[400:]}
    assert at[1.0] == pytest.approx(top, rel=1e-8)  # measured: round-off
    assert at[-1.0] == pytest.approx(-top, rel=1e-8)  # measured: round-off
    slip = amplitude - top / (210e9 * 1e-3 / 2.0)
    cycle = sum(s.energies.plastic for s in steps[600:1400])
    work = sum(s.external_work for s in steps[600:1400])
    assert work == pytest.approx(4.0 * 355e3 * slip, rel=1e-8)  # measured: round-off
    assert cycle == pytest.approx(work, rel=1e-8)  # measured: round-off
    assert balance(0.0, steps) < 1e-8  # measured: round-off


def test_a_cyclic_path_of_a_frame_balances_and_meets_its_targets() -> None:
    frame, names = portal()
    frame.load[:] = loads(frame, names, crown_v=-2e5)
    apply_loads(frame)
    begin, dof = frame.stored, frame.dof(names["knee-right"], "u")
    targets = [0.1, -0.1, 0.2, -0.2, 0.0]
    steps = list(follow_displacement(frame, mixed(frame, names), dof, -1.0, targets, 7e-3))
    at = np.array([s.displacement for s in steps])
    for target in targets:
        assert np.min(np.abs(at - target)) <= 1e-15
    assert np.max(np.abs(np.diff(at, prepend=0.0))) <= 7e-3 * (1 + 1e-9)
    assert at.max() == pytest.approx(0.2)
    assert at.min() == pytest.approx(-0.2)
    assert min(s.energies.plastic for s in steps) >= 0.0
    assert balance(begin, steps) < 7e-6  # measured 3.4e-6


@given(
    st.lists(st.floats(-0.01, 0.01).map(lambda x: round(x, 9)), min_size=1, max_size=4),
    st.floats(1e-3, 2e-2),
    st.sampled_from([-1.0, 1.0]),
)
def test_targets_are_met_and_never_passed(targets, increment, sign) -> None:
    rod, dof = bar(2.1e9)
    pattern = np.zeros(rod.size)
    pattern[dof] = -3.0
    at = [0.0]
    at += [s.displacement for s in follow_displacement(rod, pattern, dof, sign, targets, increment)]
    begin, done = 0.0, 1
    for target in targets:
        low, high = min(begin, target) - 1e-15, max(begin, target) + 1e-15
        while done < len(at) and abs(at[done - 1] - target) > 1e-15:
            assert low <= at[done] <= high
            assert abs(at[done] - at[done - 1]) <= increment * (1 + 1e-9)
            done += 1
        assert abs(at[done - 1] - target) <= 1e-15
        begin = target
    assert done == len(at)


def test_push_is_the_path_of_a_single_force() -> None:
    forces = []
    for driver in ("push", "path"):
        frame, names = portal()
        dof = frame.dof(names["side-left"], "u")
        if driver == "push":
            steps = list(push(frame, dof, np.linspace(0.0, 0.3, 61)[1:]))
            forces.append([s.factor for s in steps])
        else:
            pattern = loads(frame, names, side_left_u=1e3)
            steps = follow_displacement(frame, pattern, dof, 1.0, [0.3], 5e-3)
            forces.append([1e3 * s.factor for s in steps])
    np.testing.assert_allclose(forces[0], forces[1], rtol=1e-9)


def test_a_path_goes_on_from_a_loaded_state() -> None:
    """The factor at the start is found, so that the ledger closes across the seam."""
    frame, names = portal()
    pattern, dof = mixed(frame, names), frame.dof(names["knee-right"], "u")
    first = list(follow_displacement(frame, pattern, dof, 1.0, [0.05], 5e-3))
    half = frame.stored
    second = list(follow_displacement(frame, pattern, dof, 1.0, [0.05], 5e-3))
    assert balance(half, second) < 3e-5  # measured 1.3e-5
    frame, names = portal()
    whole = list(follow_displacement(frame, pattern, dof, 1.0, [0.1], 5e-3))
    assert second[-1].factor == pytest.approx(whole[-1].factor, rel=1e-8)  # measured: round-off
    work = sum(s.external_work for s in first + second)
    assert work == pytest.approx(sum(s.external_work for s in whole), rel=1e-9)


def shallow_truss():
    """Two bars of span 1, rise 0.1 and EA = 1e8; the dof of the apex, pushed down."""
    truss = chain([[-0.5, 0.0], [0.0, 0.1], [0.5, 0.0]], elastic(1e-5, bending=1e-2))
    truss.hold([*truss.dofs([0, 2], "u"), *truss.dofs([0, 2], "v")])
    apex = truss.dof(1, "v")
    pattern = np.zeros(truss.size)
    pattern[apex] = -1.0
    return truss, apex, pattern


def limit_of_the_truss() -> float:
    left = np.linspace(0.0, 0.1, 100_001)
    length = np.hypot(0.5, left)
    return float(np.max(2e8 * (1.0 - length / np.hypot(0.5, 0.1)) * left / length))


def test_load_control_ends_at_a_limit_point_and_says_what_to_do() -> None:
    truss, apex, pattern = shallow_truss()
    limit = limit_of_the_truss()
    steps = []
    with pytest.raises(SolverError, match=r"load factor .*displacement control or arc length"):
        steps.extend(follow_load(truss, pattern, [2.0 * limit], apex, -1.0, 0.05 * limit))
    reached = steps[-1].factor
    assert 0.9 * limit < reached <= limit * 1.001
    # the failed step has left the structure at the last committed state: go on from there
    assert -truss.displacement[apex] == pytest.approx(steps[-1].displacement, rel=1e-12)
    onward = list(
        follow_displacement(truss, pattern, apex, -1.0, [0.2 - steps[-1].displacement], 2e-3)
    )
    factors = np.array([s.factor for s in onward])
    assert factors.max() == pytest.approx(limit, rel=2e-3)
    assert factors.min() == pytest.approx(-limit, rel=6e-4)  # measured 3.0e-4
    assert balance(0.0, steps + onward) < 1e-3


def test_loads_back_and_forth() -> None:
    frame, names = portal()
    dof = frame.dof(names["knee-left"], "u")
    steps = list(follow_load(frame, mixed(frame, names), [2.0, -2.0, 0.0], dof, 1.0, 0.25))
    assert [steps[i].factor for i in (7, 23, 31)] == pytest.approx([2.0, -2.0, 0.0], abs=1e-12)
    assert balance(0.0, steps) < 1e-8  # measured: round-off


def test_failures_name_the_place_and_leave_the_last_state() -> None:
    frame, names = portal()
    dof = frame.dof(names["knee-left"], "u")
    path = follow_displacement(frame, mixed(frame, names), dof, 1.0, [0.1], 0.05)
    first = next(path)
    whole, kept = frame.solve, frame.displacement.copy()
    frame.solve = lambda right, held=None: None
    with pytest.raises(SolverError, match=r"displacement 0\.0500\d+ m: residual .* arc length"):
        next(path)
    np.testing.assert_array_equal(frame.displacement, kept)
    frame.solve = whole
    again = list(follow_displacement(frame, mixed(frame, names), dof, 1.0, [0.05], 0.05))
    assert again[-1].displacement + first.displacement == pytest.approx(0.1)
    rotation = frame.dof(names["knee-left"], "rotation")
    frame.load[dof] = np.nan
    with pytest.raises(SolverError, match=r"displacement \S+ rad"):
        list(follow_displacement(frame, mixed(frame, names), rotation, 1.0, [0.1], 0.05))


def test_cut_increments_are_counted_and_summed() -> None:
    frame, names = portal()
    dof, pattern = frame.dof(names["knee-left"], "u"), mixed(frame, names)
    whole, calls = frame.solve, {"left": 3}

    def fails_at_first(right, held=None):
        calls["left"] -= 1
        return None if calls["left"] >= 0 else whole(right, held)

    frame.solve = fails_at_first
    steps = list(follow_displacement(frame, pattern, dof, 1.0, [0.04], 0.02))
    assert [s.displacement for s in steps] == pytest.approx([0.02, 0.04], rel=1e-12)
    assert steps[0].cuts >= 1
    assert balance(0.0, steps) < 1.6e-3  # measured 7.7e-4


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"dof": 0}, "dof"),
        ({"pattern": np.zeros(6)}, "pattern"),
        ({"pattern": np.eye(6)[0]}, "pattern"),
    ],
)
def test_bad_input_is_named(change, field) -> None:
    rod, dof = bar()
    given = {"pattern": np.eye(6)[dof], "dof": dof, "targets": [1e-3], "increment": 1e-4}
    with pytest.raises(InputError) as caught:
        list(follow_displacement(rod, sign=1.0, **{**given, **change}))
    assert caught.value.field == field
