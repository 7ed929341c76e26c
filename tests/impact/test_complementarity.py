"""Contact problems of several contacts: both solvers, dependent contacts, typed failures."""

from __future__ import annotations

import numpy as np
import pytest

from workbench.errors import InputError, SolverError
from workbench.impact.complementarity import METHODS, TOLERANCE, solve_contacts


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
    rng = np.random.default_rng(1)
    answered = 0
    for number in range(count):
        delassus, free, moving = random_problem(rng, number)
        found = []
        for method in METHODS.words:
            try:
                found.append(solve_contacts(delassus, free, method))
            except SolverError as error:
                at_the_limit = error.residual < 1e-9
        if len(found) == 1:
            assert at_the_limit
        assert found or not moving
        if len(found) == 2:
            answered += 1
            assert max(answer.residual for answer in found) <= TOLERANCE
            scale = np.abs(free).max()
            np.testing.assert_allclose(
                found[0].velocities, found[1].velocities, atol=1e-7 * scale, rtol=0.0
            )
            for answer in found:
                assert answer.impulses.min() >= 0.0
                np.testing.assert_allclose(
                    answer.velocities, delassus @ answer.impulses + free, atol=1e-9 * scale
                )
    assert answered > 0.9 * count


def test_both_solvers_agree_on_random_problems() -> None:
    check_random_problems(250)


@pytest.mark.slow
def test_both_solvers_agree_on_ten_thousand_random_problems() -> None:
    check_random_problems(10_000)


@pytest.mark.parametrize("method", METHODS.words)
def test_bodies_that_cannot_be_kept_apart_are_a_typed_failure(method: str) -> None:
    squeezed = np.array([[1.0, -1.0], [-1.0, 1.0]])  # two sides of one body
    with pytest.raises(SolverError, match="contradict each other"):
        solve_contacts(squeezed, np.array([-1.0, -1.0]), method)


@pytest.mark.parametrize("method", METHODS.words)
def test_a_contact_that_nothing_moves_is_no_matter_of_round_off(method: str) -> None:
    with pytest.raises(SolverError, match="contradict each other"):
        solve_contacts(np.diag([1.0, 0.0]), np.array([-1.0, -1.0]), method)


def test_nearly_dependent_contacts_are_not_said_to_contradict_each_other() -> None:
    """Normals that differ by 1e-8, of a motion of the bodies: there is an answer."""
    rng, said = np.random.default_rng(3), []
    for _ in range(12):
        normals = rng.normal(size=(10, 8))
        normals[:, 4:] = normals[:, :4] + 1e-8 * rng.normal(size=(10, 4))
        free = normals.T @ rng.normal(size=10)
        for method in METHODS.words:
            try:
                solve_contacts(normals.T @ normals, free, method)
            except SolverError as error:
                said.append(str(error))
    assert said
    assert all("nearly depend on each other" in line for line in said)
    assert not any("contradict" in line for line in said)


@pytest.mark.parametrize("method", METHODS.words)
def test_the_same_contact_twice_shares_its_impulse(method: str) -> None:
    answer = solve_contacts(np.full((2, 2), 0.5), np.array([-1.0, -1.0]), method)
    assert answer.impulses.sum() == pytest.approx(2.0, rel=1e-12)
    np.testing.assert_allclose(answer.velocities, 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("delassus", "free", "method", "said"),
    [
        (np.eye(2), np.zeros(3), "lemke", "must be square"),
        (np.diag([1.0, -1.0]), np.zeros(2), "lemke", "symmetric without negative diagonal"),
        (np.array([[1.0, 2.0], [0.0, 1.0]]), np.zeros(2), "lemke", "symmetric"),
        (np.eye(1), np.array([np.nan]), "lemke", "finite"),
        (np.eye(1), np.zeros(1), "guess", "lemke, projected"),
    ],
)
def test_bad_problems_get_one_clear_message(delassus, free, method, said) -> None:
    with pytest.raises(InputError, match=said):
        solve_contacts(delassus, free, method)
