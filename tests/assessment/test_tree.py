"""Trees find the boxes that made the classes, and stop where nothing is left to find."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from workbench.assessment.bias import grow, impurity, rounded


def drawn(count: int = 400) -> np.ndarray:
    return np.random.default_rng(4).uniform(0.0, 2.0, (count, 3))


def test_boxes_hold_their_lower_bounds_and_leave_no_point_out() -> None:
    points = np.round(drawn(), 1)
    classes = (points[:, 0] >= 1.0).astype(int)
    leaves = list(grow(points, impurity(classes), 2, 10))
    for point, own in zip(points, classes, strict=True):
        (leaf,) = (leaf for leaf in leaves if leaf.holds(point))
        assert np.all(classes[leaf.members] == own)


def test_a_box_is_found_at_its_bounds() -> None:
    points = drawn()
    classes = ((points[:, 0] > 1.0) & (points[:, 2] < 0.5)).astype(int)
    leaves = list(grow(points, impurity(classes), 3, 10))
    assert sorted(np.concatenate([leaf.members for leaf in leaves])) == list(range(400))
    (inside,) = (leaf for leaf in leaves if classes[leaf.members].mean() > 0.9)
    assert set(inside.bounds) == {0, 2}
    assert inside.bounds[0] == (pytest.approx(1.0, abs=0.1), inf)
    assert inside.bounds[2] == (-inf, pytest.approx(0.5, abs=0.1))
    for point, own in zip(points, classes, strict=True):
        (leaf,) = (leaf for leaf in leaves if leaf.holds(point))
        if abs(point[0] - 1.0) > 0.1 and abs(point[2] - 0.5) > 0.1:
            assert np.bincount(classes[leaf.members]).argmax() == own


def test_it_stops_at_its_depth_at_few_points_and_at_one_class() -> None:
    points = drawn()
    checkers = (np.sum(points > 1.0, axis=1) % 2).astype(int)
    assert len(list(grow(points, impurity(checkers), 2, 10))) <= 4
    assert min(len(leaf.members) for leaf in grow(points, impurity(checkers), 9, 25)) >= 25
    (leaf,) = grow(points, impurity(np.ones(400, dtype=int)), 5, 10)
    assert leaf.bounds == {}


def test_any_loss_may_be_lowered() -> None:
    points = drawn()
    value = np.where(points[:, 1] < 0.7, 3.0, -1.0)
    first, second = grow(points, lambda m: float(np.sum((value[m] - value[m].mean()) ** 2)), 1, 10)
    assert set(first.bounds) == {1}
    assert first.bounds[1][1] == pytest.approx(0.7, abs=0.06)
    assert value[second.members].mean() == pytest.approx(-1.0, abs=0.3)


def test_impurity_and_round_bounds() -> None:
    classes = np.array([0, 0, 0, 1, 1])
    assert impurity(classes)(np.arange(3)) == 0.0
    assert impurity(classes)(np.arange(1, 5)) == 2.0  # 4 (1 - 1/4 - 1/4)
    assert [rounded(x) for x in (0.0, 0.12345, 678.0, -3.14159)] == [0.0, 0.12, 680.0, -3.1]
