"""Arc-length driver: snap-through against closed forms and published limit loads."""

from __future__ import annotations

import numpy as np
import pytest
import superelement_cases
from frame_cases import portal
from reissner_cases import chain, elastic, square

from workbench.base.errors import InputError, SolverError
from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.fibers.section import ReissnerBeams
from workbench.mechanics.structures.paths import apply_loads, follow_arc, follow_displacement
from workbench.mechanics.structures.superelements import Superelements

LENGTH = 1.2


def one(assembly: PlanarAssembly, dof: int, load: float) -> np.ndarray:
    """A pattern of one load."""
    pattern = np.zeros(assembly.size)
    pattern[dof] = load
    return pattern


def extremum(values: np.ndarray, top: int) -> float:
    a, b, c = np.polyfit([-1.0, 0.0, 1.0], values[top - 1 : top + 2], 2)
    return float(c - b * b / (4.0 * a))


def test_a_shallow_truss_snaps_through() -> None:
    """Two bars of span 1, rise h: P = 2 EA (1 - l / L) (h - v) / l with l the bar's length."""
    rise, stiffness = 0.1, 1e8
    section = elastic(1e-5, bending=stiffness * 1e-10)
    truss = chain([[-0.5, 0.0], [0.0, rise], [0.5, 0.0]], section)
    truss.hold(truss.dofs([0, 2], "u"))
    truss.hold(truss.dofs([0, 2], "v"))
    middle = truss.dof(1, "v")
    bar = np.hypot(0.5, rise)
    seen = []
    for step in follow_arc(truss, one(truss, middle, -1.0), middle, -1.0, 0.25, 4e-3):
        left = rise + truss.displacement[middle]
        length = np.hypot(0.5, left)
        expected = 2.0 * stiffness * (1.0 - length / bar) * left / length
        # log strain and chord strain differ by the turn of the bars; chord strain is (l - L) / L
        # measured 1.9e-7
        assert step.factor == pytest.approx(expected, abs=4e-7 * stiffness * (rise / bar) ** 3)
        seen.append(step.factor)
    assert truss.displacement[middle] < -2.0 * rise
    assert min(seen) < 0.0 < seen[-1]


def test_lee_frame() -> None:
    """Limit load 18.55 EI/L2 and the minimum behind it (Schweizerhof and Wriggers 1986)."""
    limits = []
    for n in (10, 20, 40):
        column = np.stack([np.zeros(n + 1), np.linspace(0.0, LENGTH, n + 1)], axis=1)
        beam = np.stack([np.linspace(0.0, LENGTH, n + 1)[1:], np.full(n, LENGTH)], axis=1)
        frame = chain(np.concatenate([column, beam]), elastic(LENGTH / 240.0, shear=100.0))
        frame.hold([frame.dof(node, c) for node in (0, 2 * n) for c in ("u", "v")])
        loaded = frame.dof(n + n // 5, "v")
        pattern = one(frame, loaded, -1.0 / LENGTH**2)
        factors, work = [], 0.0
        for step in follow_arc(frame, pattern, loaded, -1.0, 0.75 * LENGTH, 0.01 * LENGTH):
            factors.append(step.factor)
            work += step.external_work
        path = np.array(factors)
        bottom = int(np.argmin(path))
        limits.append((extremum(path, int(np.argmax(path[:bottom]))), extremum(path, bottom)))
        assert work == pytest.approx(step.energies.stored, rel=2e-4)  # measured 9.4e-5
    ladder = np.array(limits)
    extrapolated = ladder[-1] + (ladder[-1] - ladder[-2]) / 3.0
    assert ladder[-1, 0] == pytest.approx(18.56, rel=1e-3)
    np.testing.assert_allclose(extrapolated, [18.56, -9.43], rtol=0.0, atol=0.02)


def test_a_plastic_path_is_followed_past_its_limit() -> None:
    """A stocky arch of the elastic-plastic square loses load after its mechanism has formed."""
    x = np.linspace(-1.0, 1.0, 17)
    arch = chain(np.stack([x, 0.3 * (1.0 - x**2)], axis=1), square())
    arch.hold([arch.dof(node, c) for node in (0, 16) for c in ("u", "v", "rotation")])
    middle = arch.dof(8, "v")
    # the target comes before it hangs like a rope
    steps = list(follow_arc(arch, one(arch, middle, -1e6), middle, -1.0, 0.25, 1e-3))
    factors = np.array([step.factor for step in steps])
    top = int(np.argmax(factors))
    assert 5 < top < len(factors) - 5
    assert factors[-1] < 0.6 * factors[top]
    work = sum(step.external_work for step in steps)
    spent = steps[-1].energies.stored + sum(step.energies.plastic for step in steps)
    assert spent == pytest.approx(work, rel=4e-6)  # measured 2.0e-6


def test_a_mechanism_is_reported() -> None:
    bar = chain([[0.0, 0.0], [1.0, 0.0]], elastic(0.1))
    tip = bar.dof(1, "v")  # nothing is held
    with pytest.raises(SolverError, match=r"singular|radii"):
        list(follow_arc(bar, one(bar, tip, 1.0), tip, 1.0, 1.0, 0.1))


def shallow(rise: float = 0.1):
    """Two bars of EA = 1e8, span 1 m: the truss, the dof of its apex, force over way down."""
    truss = chain([[-0.5, 0.0], [0.0, rise], [0.5, 0.0]], elastic(1e-5, bending=1e-2))
    truss.hold([*truss.dofs([0, 2], "u"), *truss.dofs([0, 2], "v")])
    bar = np.hypot(0.5, rise)

    def force(down):
        left = rise - down
        return 2e8 * (1.0 - np.hypot(0.5, left) / bar) * left / np.hypot(0.5, left)

    return truss, truss.dof(1, "v"), force


def test_a_pattern_beside_dead_loads_snaps_through_to_the_target() -> None:
    """Dead load and factor times pattern together are the force of the truss."""
    truss, apex, force = shallow()
    peak = float(np.max(force(np.linspace(0.0, 0.1, 10_001))))
    truss.load[apex] = -0.4 * peak
    apply_loads(truss, tolerance=1e-13)
    begin, sunk = truss.stored, -float(truss.displacement[apex])
    pattern = np.zeros(truss.size)
    pattern[apex] = -1e4
    steps = list(follow_arc(truss, pattern, apex, -1.0, 0.21, 2e-3))
    down = sunk + np.array([s.displacement for s in steps])
    factors = np.array([s.factor for s in steps])
    np.testing.assert_allclose(
        # measured 1.6e-7
        0.4 * peak + 1e4 * factors,
        force(down),
        rtol=0.0,
        atol=3.2e-7 * 1e8 * 0.2**3,
    )
    assert steps[-1].displacement == pytest.approx(0.21, rel=1e-12)
    assert np.all(np.diff(down) > 0.0)
    assert np.max(np.diff(down)) <= 2.1e-3
    work = sum(s.external_work for s in steps)
    # measured 6.0e-5
    assert steps[-1].energies.stored - begin == pytest.approx(work, abs=1.2e-4 * peak * 0.2)


def snapping_back():
    """The truss hangs on a bar that is softer than the truss's steepest descent.

    Pulling the free end of the bar down by w moves the apex by v with w = v + F(v) / k.
    """
    stiff, soft = elastic(1e-5, bending=1e-2), elastic(1e-5, bending=4e6 * 1e-10)
    points = [[-0.5, 0.0], [0.0, 0.1], [0.5, 0.0], [0.0, -0.9]]
    group = ReissnerBeams([[0, 1], [1, 2], [1, 3]], np.array([0, 0, 1]), [stiff, soft])
    truss = PlanarAssembly(points, [group])
    truss.hold([*truss.dofs([0, 2], "u"), *truss.dofs([0, 2], "v"), truss.dof(3, "u")])
    truss.hold([truss.dof(1, "u")])
    pattern = np.zeros(truss.size)
    end = truss.dof(3, "v")
    pattern[end] = -1.0
    return truss, end, truss.dof(1, "v"), pattern


def test_snap_back_is_followed_where_displacement_control_ends() -> None:
    truss, end, apex, pattern = snapping_back()
    force = shallow()[2]
    seen = []
    for step in follow_arc(truss, pattern, end, -1.0, 0.3, 2e-3):
        seen.append((step.displacement, -float(truss.displacement[apex]), step.factor))
        assert step.factor == pytest.approx(force(seen[-1][1]), abs=0.26)  # measured 0.13
    pulled, sunk, factors = np.array(seen).T
    # measured: round-off
    np.testing.assert_allclose(pulled, sunk + factors / 4e6, rtol=0.0, atol=2.6e-9)
    assert np.any(np.diff(pulled) < 0.0)  # snap-back
    assert factors.min() < 0.0 < factors[-1]
    truss, end, apex, pattern = snapping_back()
    reached = []
    with pytest.raises(SolverError, match="arc length"):
        reached.extend(follow_displacement(truss, pattern, end, -1.0, [0.3], 2e-3))
    first_turn = pulled[int(np.argmax(np.diff(pulled) < 0.0))]
    assert reached[-1].displacement == pytest.approx(first_turn, abs=2e-3)  # measured 9.4e-4


def test_arc_length_and_displacement_control_agree_on_a_plastic_frame() -> None:
    ends = []
    for control in ("arc", "displacement"):
        frame, names = portal()
        frame.load[frame.dof(names["crown"], "v")] = -2e5
        apply_loads(frame)
        begin = frame.stored
        dof = frame.dof(names["knee-left"], "u")
        pattern = np.zeros(frame.size)
        pattern[dof] = 1e5
        pattern[frame.dof(names["crown"], "v")] = -5e4
        pattern[frame.dof(names["knee-right"], "rotation")] = 2e4
        if control == "arc":
            steps = list(follow_arc(frame, pattern, dof, 1.0, 0.3, 2e-3))
        else:
            steps = list(follow_displacement(frame, pattern, dof, 1.0, [0.3], 2e-3))
        work = sum(s.external_work for s in steps)
        spent = steps[-1].energies.stored - begin + sum(s.energies.plastic for s in steps)
        assert spent == pytest.approx(work, rel=1e-6)  # measured 5.0e-7
        ends.append((steps[-1].factor, max(s.factor for s in steps), steps[-1].displacement))
    assert ends[0] == pytest.approx(ends[1], rel=1e-5)


def hinged_portal():
    """A portal of rigid bars with plastic hinges, a dead load on its crown; dof and pattern."""
    points = [[0.0, 0.0], [0.0, 4.0], [3.0, 4.0], [6.0, 4.0], [6.0, 0.0]]
    bars = [superelement_cases.bar(length) for length in (4.0, 3.0, 3.0, 4.0)]
    nodes = [[0, 1], [1, 2], [2, 3], [3, 4]]
    group = Superelements(nodes, bars)
    frame = PlanarAssembly(points, [group])
    frame.hold([frame.dof(node, c) for node in (0, 4) for c in ("u", "v", "rotation")])
    frame.load[frame.dof(2, "v")] = -1e5
    apply_loads(frame)
    pattern = np.zeros(frame.size)
    pattern[frame.dof(1, "u")], pattern[frame.dof(2, "v")] = 1e5, -5e4
    return frame, frame.dof(1, "u"), pattern


def test_a_mechanism_of_plastic_hinges_costs_arc_length_little_more() -> None:
    frame, dof, pattern = hinged_portal()
    arc = list(follow_arc(frame, pattern, dof, 1.0, 0.4, 5e-3))
    frame, dof, pattern = hinged_portal()
    led = list(follow_displacement(frame, pattern, dof, 1.0, [0.4], 5e-3))
    assert arc[-1].factor == pytest.approx(led[-1].factor, rel=7e-8)  # measured 3.1e-8
    # measured 6.0e-4
    assert max(s.factor for s in arc) == pytest.approx(max(s.factor for s in led), rel=1.3e-3)
    assert sum(s.evaluations for s in arc) < 4 * sum(s.evaluations for s in led)


def test_an_unreachable_target_is_reported() -> None:
    truss, apex, _ = shallow()
    pattern = np.zeros(truss.size)
    pattern[apex] = -1.0
    with pytest.raises(SolverError, match=r"7 steps of arc length on the way to 0\.3"):
        list(follow_arc(truss, pattern, apex, -1.0, 0.3, 1e-3, most_steps=7))


def test_a_dof_that_does_not_move_is_named() -> None:
    truss, apex, _ = shallow()
    truss.hold([truss.dof(1, "u")])
    pattern = np.zeros(truss.size)
    pattern[apex] = -1.0
    with pytest.raises(InputError) as caught:
        list(follow_arc(truss, pattern, 3, -1.0, 0.1, 1e-3))
    assert caught.value.field == "dof"
