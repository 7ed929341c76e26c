"""Contact problems of several contacts: their conditions, dependent contacts, contradictions."""

from __future__ import annotations

import numpy as np
import pytest

from workbench.extras.laboratory.complementarity import TOLERANCE, complementary, fixed_point


def random_problem(rng: np.random.Generator, number: int):
    """Delassus matrix and free gap velocities; contacts often depend on each other."""
    contacts, bodies = rng.integers(1, 21), rng.integers(1, 25)
    normals = rng.normal(size=(bodies, contacts))
    if number % 3 == 0:
        normals[:, -1] = normals[:, 0] * rng.choice([-1.0, 1.0, 2.0])
    if number % 7 == 0:
        normals = np.round(normals)
    delassus = normals.T @ (normals / 10 ** rng.uniform(-2.0, 3.0, bodies)[:, None])
    # of a motion of the bodies, which always has an answer; now and then of none
    moving = number % 5 > 0
    free = normals.T @ rng.normal(size=bodies) if moving else rng.normal(size=contacts)
    return delassus, free, moving


def check_random_problems(count: int) -> None:
    """Impulses push, gaps do not close, and one of both is zero at every contact."""
    rng = np.random.default_rng(1)
    answered = 0
    for number in range(count):
        delassus, free, moving = random_problem(rng, number)
        impulses, residual = complementary(delassus, free)
        assert residual < 1e-9 or not moving
        if residual <= TOLERANCE:
            answered += 1
            velocities = delassus @ impulses + free
            roots = np.sqrt(np.maximum(np.diagonal(delassus), 1e-300))
            scale = np.abs(free / roots).max()
            assert impulses.min() >= 0.0
            lacking = np.minimum(impulses * roots, velocities / roots)
            np.testing.assert_allclose(lacking, 0.0, atol=1e-9 * scale)
    assert answered > 0.8 * count


def test_the_conditions_of_contact_hold_on_random_problems() -> None:
    check_random_problems(250)


@pytest.mark.slow
def test_the_conditions_of_contact_hold_on_ten_thousand_random_problems() -> None:
    check_random_problems(10_000)


def test_the_fixed_point_meets_the_pivots_at_the_rate_of_the_largest_eigenvalue() -> None:
    """One contact takes one turn; of a chain of n balls the error shrinks by (1 + cos a) / 2."""
    impulses, residual, turns = fixed_point(np.array([[2.0]]), np.array([-3.0]), 9)
    assert (impulses[0], residual, turns) == (1.5, 0.0, 1)
    for n in (3, 5, 10):  # contacts, G = (2, -1), the row sums 4; pi / (n + 1) the lowest mode
        G = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
        q = -np.linspace(1.0, 2.0, n)
        exact = complementary(G, q)[0]
        errors = [np.abs(fixed_point(G, q, turns)[0] - exact).max() for turns in (80, 81)]
        rate = 0.5 * (1.0 + np.cos(np.pi / (n + 1)))
        assert errors[1] / errors[0] == pytest.approx(rate, abs=1e-4)
        impulses, residual, turns = fixed_point(G, q, 10_000)
        assert residual <= 1e-11
        np.testing.assert_allclose(impulses, exact, rtol=1e-9)
    _, residual, turns = fixed_point(G, q, 20)
    assert turns == 20
    assert residual > 1e-3


def test_the_fixed_point_meets_the_pivots_on_random_problems() -> None:
    rng = np.random.default_rng(4)
    for _ in range(100):
        W = rng.normal(size=(8, rng.integers(1, 6)))
        G, free = W.T @ W, W.T @ rng.normal(size=8)
        impulses, residual, _ = fixed_point(G, free, 100_000)
        assert residual <= 1e-11
        np.testing.assert_allclose(impulses, complementary(G, free)[0], rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("delassus", [[[1.0, -1.0], [-1.0, 1.0]], np.diag([1.0, 0.0])])
def test_bodies_that_cannot_be_kept_apart_have_no_impulses(delassus) -> None:
    """The two sides of one body; a contact that nothing moves."""
    _, residual = complementary(np.array(delassus), np.array([-1.0, -1.0]))
    assert not residual <= 1e-6


def test_nearly_dependent_contacts_are_solved_or_tell_their_round_off() -> None:
    """Normals that differ by 1e-8, of a motion of the bodies: there is an answer."""
    rng = np.random.default_rng(3)
    for _ in range(12):
        normals = rng.normal(size=(10, 8))
        normals[:, 4:] = normals[:, :4] + 1e-8 * rng.normal(size=(10, 4))
        _, residual = complementary(normals.T @ normals, normals.T @ rng.normal(size=10))
        assert residual < 1e-6


def test_the_same_contact_twice_shares_its_impulse() -> None:
    impulses, _ = complementary(np.full((2, 2), 0.5), np.array([-1.0, -1.0]))
    assert impulses.sum() == pytest.approx(2.0, rel=1e-12)
    np.testing.assert_allclose(0.5 * impulses.sum() - 1.0, 0.0, atol=1e-12)
