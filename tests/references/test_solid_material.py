"""Points of the solid: tangents, objectivity, yield surface, hardening, squeeze guard."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from builders import examples
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import polar

from workbench.models.references.solid import kernels
from workbench.models.references.solid.kernels import (
    SQUEEZED,
    Elements,
    PointStates,
    SolidSteel,
    Tensor,
    empty_state,
    respond,
)

Array = NDArray[np.float64]
E, NU, FY = 210e9, 0.3, 355e6


class Point(NamedTuple):
    nominal: Array
    tangent: Array
    strain: Array
    stress: Array


def point(F: Array, plastic: Array | None = None, hardened: float = 0.0, H: float = 0.0) -> Point:
    steel = SolidSteel(E, NU, FY, H)
    result = kernels.stretched(*F)
    start = np.array(result.strain) - (0.0 if plastic is None else plastic)
    back = kernels.return_mapping(Tensor(*start), hardened, steel)
    C, D, K = np.zeros((3, 3)), np.empty((3, 4)), np.empty((4, 4))
    kernels.add_return_tangent(back, steel, C)
    stress = np.array(back.stress)
    if result.area < SQUEEZED:
        stress = stress + np.array(kernels.squeeze(result, E))
        kernels.add_squeeze_tangent(result, E, C)
    nominal = np.array(kernels.nominal_stress(result, Tensor(*stress)))
    kernels.nominal_tangent(result, Tensor(*stress), C, D, K)
    return Point(nominal, K, np.array(result.strain), np.array(back.stress))


def differences(F: Array, step: float, **state) -> Array:
    """Eighth-order central differences of the nominal stress."""
    columns = []
    for i in range(4):
        d = np.zeros(4)
        d[i] = step
        total = np.zeros(4)
        for k, weight in enumerate((4 / 5, -1 / 5, 4 / 105, -1 / 280), start=1):
            pair = point(F + k * d, **state).nominal - point(F - k * d, **state).nominal
            total += weight * pair
        columns.append(total / step)
    return np.array(columns).T


def turned(angle: float, F: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return (np.array([[c, -s], [s, c]]) @ F.reshape(2, 2)).ravel()


def equivalent(T: Array) -> float:
    return float(np.sqrt(T[0] ** 2 - T[0] * T[1] + T[1] ** 2 + 3.0 * T[2] ** 2))


def state(seed: int) -> tuple[Array, Array]:
    """A large rotation with a large strain, and committed plastic strain some yield strains off."""
    random = np.random.default_rng(seed)
    stretch = np.eye(2) + 0.3 * random.uniform(-1.0, 1.0, (2, 2))
    F = turned(random.uniform(-3.0, 3.0), stretch.ravel())
    strain = point(F).strain
    plastic = strain + random.uniform(-4.0, 4.0, 3) * FY / E
    return F, plastic


@pytest.mark.parametrize("hardening", [0.0, 1e-6, 0.02])
@pytest.mark.parametrize("seed", range(12))
def test_tangent_is_the_derivative_of_stress(seed: int, hardening: float) -> None:
    F, plastic = state(seed)
    given_state = {"plastic": plastic, "hardened": 0.01, "H": hardening * E}
    exact = point(F, **given_state).tangent
    measured = differences(F, 2e-5, **given_state)
    scale = np.max(np.abs(exact))
    # 2e-5 is a hundredth of the yield strain; what is left is the round-off of F near 1
    assert np.max(np.abs(measured - exact)) < 1e-10 * scale
    assert np.max(np.abs(exact - exact.T)) < 1e-15 * scale


@pytest.mark.parametrize("seed", range(6))
def test_elastic_tangent_to_round_off(seed: int) -> None:
    F, _ = state(seed)
    state_elastic = {"plastic": point(F).strain}  # no stress: only turning and elasticity
    exact = point(F, **state_elastic).tangent
    measured = differences(F, 1e-4, **state_elastic)
    assert np.max(np.abs(measured - exact)) < 1e-10 * np.max(np.abs(exact))


def test_strain_is_that_of_the_polar_decomposition() -> None:
    for seed in range(20):
        F, _ = state(seed)
        _, stretch = polar(F.reshape(2, 2))
        expected = [stretch[0, 0] - 1.0, stretch[1, 1] - 1.0, 2.0 * stretch[0, 1]]
        np.testing.assert_allclose(point(F).strain, expected, atol=2e-15)


@examples(60)
@given(st.integers(0, 10_000), st.floats(-3.1, 3.1))
def test_nominal_stress_turns_with_the_body(seed: int, angle: float) -> None:
    F, plastic = state(seed)
    expected = turned(angle, point(F, plastic).nominal)
    # strains are differences of numbers near 1: their round-off is 1e-16 against stress / E
    np.testing.assert_allclose(
        point(turned(angle, F), plastic).nominal, expected, rtol=0.0, atol=1e-15 * E
    )


@examples(100)
@given(st.lists(st.floats(-0.5, 0.5), min_size=3, max_size=3), st.floats(0.0, 0.05))
def test_return_is_the_closest_point_on_the_yield_surface(strain: list[float], H: float) -> None:
    steel, C = SolidSteel(E, NU, FY, H * E), np.zeros((3, 3))
    result = kernels.return_mapping(Tensor(*strain), 0.0, steel)
    kernels.add_return_tangent(result, steel, C)
    T, plastic, hardened = np.array(result.stress), np.array(result.flow), result.hardened
    compliance = np.array([[1, -NU, 0], [-NU, 1, 0], [0, 0, 2 * (1 + NU)]]) / E
    np.testing.assert_allclose(compliance @ T + plastic, strain, atol=1e-15)
    strength = FY + H * E * hardened
    assert equivalent(T) <= strength * (1.0 + 1e-13)
    if hardened == 0.0:
        assert not plastic.any()
        return
    assert equivalent(T) == pytest.approx(strength, rel=1e-13)
    normal = 1.5 / equivalent(T) * np.array(
        [(2 * T[0] - T[1]) / 3, (2 * T[1] - T[0]) / 3, 2 * T[2]]
    )  # fmt: skip
    np.testing.assert_allclose(plastic, hardened * normal, rtol=1e-11, atol=1e-16)
    assert np.min(np.linalg.eigvalsh(C)) > -1e-12 * E  # semi-definite: round-off


def test_uniaxial_hardening_has_the_slope_of_the_bar() -> None:
    H = 0.01 * E
    strains = np.array([0.02, 0.04])
    stress = []
    for e in strains:
        low, high = -e, e  # lateral strain with no lateral stress, by bisection
        for _ in range(80):
            lateral = 0.5 * (low + high)
            result = point(np.array([1.0 + lateral, 0.0, 0.0, 1.0 + e]), H=H)
            low, high = (lateral, high) if result.stress[0] < 0.0 else (low, lateral)
        stress.append(result.stress[1])
    slope = (stress[1] - stress[0]) / (strains[1] - strains[0])
    assert slope == pytest.approx(E * H / (E + H), rel=1e-9)
    assert stress[0] == pytest.approx(FY + slope * (0.02 - FY / E), rel=1e-9)


def test_squeezed_point_stiffens_smoothly_and_never_vanishes() -> None:
    tall = 1.4
    short = np.array([0.08, 0.02, 0.1 * SQUEEZED])
    normal = []
    for c in short:
        F = turned(0.7, np.array([c, 0.01, 0.0, tall]))
        plastic = point(F).strain
        exact = point(F, plastic).tangent
        measured = differences(F, 1e-5 * c, plastic=plastic)
        assert np.max(np.abs(measured - exact)) < 1e-9 * np.max(np.abs(exact))  # measured 1.5e-10
        normal.append(point(np.array([c, 0.0, 0.0, tall]), plastic=plastic).nominal[0])
    assert normal[1] < normal[2] < normal[0] < 0.0
    limit = SQUEEZED / tall
    just = [np.array([limit * (1.0 + d), 0.0, 0.0, tall]) for d in (1e-9, -1e-9)]
    before, after = (point(F, plastic=point(just[0]).strain).nominal for F in just)
    np.testing.assert_allclose(after, before, atol=4e-7 * FY)  # measured 1.9e-7


@pytest.mark.parametrize("F", [[-1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 1.0, 0.0], [np.nan, 0, 0, 1]])
def test_material_turned_inside_out_has_no_answer(F: list[float]) -> None:
    # one element with one point and three nodes, whose displacements give any gradient
    gradients = np.array([[[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]])
    elements = Elements(gradients, np.ones((1, 1)), np.arange(6).reshape(1, 6))
    u = np.array([F[0] - 1.0, F[2], F[1], F[3] - 1.0, 0.0, 0.0])
    old, new = empty_state(elements), empty_state(elements)
    steel, force, none = SolidSteel(E, NU, FY, 0.0), np.zeros(6), np.empty((0, 6, 6))
    assert np.isnan(respond(elements, u, old, new, steel, force, none).stored)
    assert isinstance(new, PointStates)
    assert not new.plastic.any()


TENSOR = st.tuples(*[st.floats(-0.05, 0.05)] * 3)


@given(TENSOR, st.floats(0.0, 0.3), st.floats(-9.0, 0.0), st.floats(1.0, 10.0), st.booleans())
@examples(300)
def test_a_return_with_a_rate_meets_the_law(
    strain: tuple[float, ...], hardened: float, size: float, exponent: float, hardens: bool
) -> None:
    """Overstress of the plastic strain of the step, along the normal, and never negative work."""
    H, reference = 0.01 * E if hardens else 0.0, 10.0**size
    steel = SolidSteel(E, NU, FY, H, reference, exponent)
    back = kernels.return_mapping(Tensor(*strain), hardened, steel)
    stress = equivalent(np.array(back.stress))
    p = back.hardened - hardened
    if back.gamma == 0.0:
        assert stress <= (FY + H * hardened) * (1.0 + 1e-12)
        return
    plastic = kernels.return_mapping(Tensor(*strain), hardened, SolidSteel(E, NU, FY, H))
    assert p < plastic.hardened - hardened
    law = FY * (1.0 + (2.0 / 3.0 * back.gamma * stress / reference) ** (1.0 / exponent))
    assert stress == pytest.approx(law + H * back.hardened, rel=1e-10)
    assert np.dot(back.stress, back.flow) == pytest.approx(stress * p, rel=1e-6, abs=1e-9 * FY)


def test_a_steel_of_infinite_reference_rate_is_the_static_one() -> None:
    for strain in ((0.01, -0.002, 0.03), (0.0, 0.0, 0.02)):
        fast = kernels.return_mapping(Tensor(*strain), 0.0, SolidSteel(E, NU, FY, 0.0, 1e24, 5.0))
        still = kernels.return_mapping(Tensor(*strain), 0.0, SolidSteel(E, NU, FY, 0.0))
        np.testing.assert_allclose(fast.stress, still.stress, rtol=0.0, atol=1e-4 * FY)
