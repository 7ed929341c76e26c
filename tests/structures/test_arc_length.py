"""Arc-length driver: snap-through against closed forms and published limit loads."""

from __future__ import annotations

import numpy as np
import pytest
from reissner_cases import chain, elastic, square

from workbench.errors import SolverError
from workbench.structures.arc_length import follow

LENGTH = 1.2


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
    truss.load[middle] = -1.0
    bar = np.hypot(0.5, rise)
    seen = []
    for step in follow(truss, 2e-3, 120, 4e-3):
        left = rise + truss.displacement[middle]
        length = np.hypot(0.5, left)
        expected = 2.0 * stiffness * (1.0 - length / bar) * left / length
        # log strain and chord strain differ by the turn of the bars; chord strain is (l - L) / L
        assert step.factor == pytest.approx(expected, abs=2e-4 * stiffness * (rise / bar) ** 3)
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
        frame.load[loaded] = -1.0 / LENGTH**2
        factors, work = [], 0.0
        for step in follow(frame, 0.02, 300, 0.15):
            factors.append(step.factor)
            work += step.external_work
            if frame.displacement[loaded] < -0.75 * LENGTH:
                break
        path = np.array(factors)
        bottom = int(np.argmin(path))
        limits.append((extremum(path, int(np.argmax(path[:bottom]))), extremum(path, bottom)))
        assert work == pytest.approx(step.energies.stored, rel=2e-3)
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
    arch.load[middle] = -1e6
    steps = list(follow(arch, 1e-3, 120, 2e-2))
    factors = np.array([step.factor for step in steps])
    top = int(np.argmax(factors))
    assert 5 < top < 115
    assert factors[-1] < 0.98 * factors[top]
    work = sum(step.external_work for step in steps)
    spent = steps[-1].energies.stored + sum(step.energies.plastic for step in steps)
    assert spent == pytest.approx(work, rel=2e-3)


def test_a_mechanism_is_reported() -> None:
    bar = chain([[0.0, 0.0], [1.0, 0.0]], elastic(0.1))
    bar.load[bar.dof(1, "v")] = 1.0  # nothing is held
    with pytest.raises(SolverError, match=r"singular|radii"):
        list(follow(bar, 0.1, 3))
