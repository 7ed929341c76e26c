"""Uniaxial steel laws: closed forms, tangents, hysteresis, rate sensitivity."""

from __future__ import annotations

import numpy as np
import pytest
from builders import examples
from hypothesis import given
from hypothesis import strategies as st
from section_cases import stress_path

from workbench.base.errors import InputError
from workbench.mechanics.structures.fibers.section import (
    LinearHardening,
    MenegottoPinto,
)
from workbench.steel.materials import MILD_STEEL, CowperSymonds

E, FY = 210e9, 355e6
YIELD = FY / E
LAWS = (
    LinearHardening(E, FY),
    LinearHardening(E, FY, 0.02 * E),
    LinearHardening(E, FY, 0.01 * E, 0.03 * E),
    LinearHardening(E, FY, 0.0, 0.02 * E, rate=MILD_STEEL),
    MenegottoPinto(E, FY, 0.02),
)


def test_perfect_plasticity_stays_at_yield() -> None:
    stress = stress_path(LinearHardening(E, FY), [0.5 * YIELD, 4 * YIELD, 2.5 * YIELD, -9 * YIELD])
    np.testing.assert_allclose(stress[:, 0], [0.5 * FY, FY, -0.5 * FY, -FY], rtol=1e-12)
    np.testing.assert_array_equal(stress[:, 1], [E, 0.0, E, 0.0])


@pytest.mark.parametrize(("kinematic", "isotropic"), [(0.04, 0.0), (0.0, 0.04), (0.03, 0.01)])
def test_hardening_line_and_range_after_reversal(kinematic, isotropic) -> None:
    law = LinearHardening(E, FY, kinematic * E, isotropic * E)
    slope = 0.04 * E / (1.0 + 0.04)
    top = 6.0 * YIELD
    peak = stress_path(law, [top])[0, 0]
    assert peak == pytest.approx(FY + slope * (top - YIELD), rel=1e-12)
    # the elastic range has grown by the isotropic part only: 2 (fy + H_i a)
    flow = (top - peak / E) * isotropic * E
    reach = 2.0 * (FY + flow) / E
    path = stress_path(law, [top, top - 0.999 * reach, top - 1.001 * reach])
    assert path[1, 1] == E
    assert path[2, 1] == pytest.approx(slope, rel=1e-12)


@given(
    law=st.sampled_from(LAWS),
    strains=st.lists(st.floats(-12.0, 12.0), min_size=1, max_size=6),
)
@examples(150)
def test_tangent_is_the_derivative_of_the_stress(law, strains) -> None:
    path = YIELD * np.array(strains)
    h = 1e-7 * YIELD
    ends = [stress_path(law, [*path[:-1], path[-1] + s * h], 1e-3)[-1, 0] for s in (-1.0, 1.0)]
    low, mid, high = ends[0], *stress_path(law, path, 1e-3)[-1:, 0], ends[1]
    tangent = stress_path(law, path, 1e-3)[-1, 1]
    left, right = (mid - low) / h, (high - mid) / h
    # at a corner of the law the tangent is that of one of its sides
    assert min(abs(tangent - left), abs(tangent - right)) <= 1e-4 * E


@given(strains=st.lists(st.floats(-30.0, 30.0), min_size=2, max_size=12))
@examples(100)
def test_plastic_work_is_never_negative(strains) -> None:
    path = YIELD * np.array([0.0, *strains])
    for law in LAWS[:4]:
        stress = stress_path(law, path, 1e-3)[:, 0]
        flow = np.diff(path - stress / E)
        back = law.kinematic_modulus * (path - stress / E)[1:]
        assert np.all((stress[1:] - back) * flow >= -1e-9 * FY * YIELD)


def test_rate_sensitivity_reaches_the_cowper_symonds_stress() -> None:
    for exponent in (1.0, 3.0, 5.0):
        law = LinearHardening(E, FY, rate=CowperSymonds(40.4, exponent))
        for rate in (1e-3, 1.0, 300.0):
            step = 0.2 * YIELD
            stress = stress_path(law, step * np.arange(1, 4000), step / rate)[-1, 0]
            # measured: round-off
            assert stress == pytest.approx(FY * (1.0 + (rate / 40.4) ** (1.0 / exponent)), rel=1e-8)


def test_without_a_time_the_rate_does_not_count() -> None:
    path = YIELD * np.array([3.0, -2.0, 5.0])
    slow = stress_path(LinearHardening(E, FY, rate=MILD_STEEL), path)
    np.testing.assert_array_equal(slow, stress_path(LinearHardening(E, FY), path))


def test_menegotto_pinto_keeps_to_its_two_lines() -> None:
    law = MenegottoPinto(E, FY, 0.01)
    small, large = stress_path(law, [1e-3 * YIELD]), stress_path(law, [50.0 * YIELD])
    assert small[0, 1] == pytest.approx(E, rel=1e-9)
    # measured: round-off
    assert large[0, 0] == pytest.approx(FY + 0.01 * E * 49.0 * YIELD, rel=1e-8)
    assert large[0, 1] == pytest.approx(0.01 * E, rel=1e-8)  # measured: round-off


TIME = 0.2 * YIELD / 300.0  # s, of a step at 300 /s
# 1 + 2 x 0.02 / 1.02; 0.01 + 0.99 / 2^(1/20); 1 + (300 / 40.4)^(1/5)
BY_HAND = (
    ("linear", "at three yield strains", LAWS[1], [3.0], 1.0392156863),
    ("menegotto-pinto", "at the corner", MenegottoPinto(E, FY, 0.01), [1.0], 0.9662769656),
    ("cowper-symonds", "mild steel at 300 /s", LinearHardening(E, FY, rate=MILD_STEEL),
     0.2 * np.arange(1, 4000), 2.4933031387),
)  # fmt: skip


@pytest.mark.claim("steel:{name}", "stress over yield, {what}", "closed form", "{expected}", 1e-8)
@pytest.mark.parametrize(("name", "what", "law", "strains", "expected"), BY_HAND)
def test_stresses_by_hand(claim, name, what, law, strains, expected) -> None:
    claim(stress_path(law, YIELD * np.array(strains), TIME)[-1, 0] / FY)


def test_menegotto_pinto_is_alike_in_tension_and_compression() -> None:
    """Loops that grow and shrink: the curve goes by the largest strain of its own side."""
    path = YIELD * np.array([0.0, 3.0, -2.0, 8.0, -8.0, 2.0, -1.0, 6.0, -4.0, 9.0])
    law = MenegottoPinto(E, FY, 0.02)
    np.testing.assert_allclose(stress_path(law, -path)[:, 0], -stress_path(law, path)[:, 0])


def test_menegotto_pinto_shows_the_bauschinger_effect_and_a_stable_loop() -> None:
    law = MenegottoPinto(E, FY, 0.01)
    cycle = 5.0 * YIELD * np.sin(np.linspace(0.0, 8.0 * np.pi, 1601))
    stress = stress_path(law, cycle)[:, 0]
    # measured 2.2e-5
    np.testing.assert_allclose(stress[-400:], stress[-800:-400], rtol=0.0, atol=4.4e-5 * FY)
    # halfway down the elastic range the reversed branch has left the elastic line
    top = 100
    fallen = np.flatnonzero(stress[top:] <= stress[top] - 1.5 * FY)[0] + top
    assert cycle[top] - cycle[fallen] > 1.02 * (stress[top] - stress[fallen]) / E


def test_a_huge_strain_does_not_overflow() -> None:
    assert np.all(np.isfinite(stress_path(MenegottoPinto(E, FY), [1e8, -1e8])))


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: LinearHardening(E, 0.0),
        lambda: LinearHardening(-E, FY),
        lambda: LinearHardening(E, FY, -1.0),
        lambda: LinearHardening(E, FY, 0.0, np.nan),
        lambda: MenegottoPinto(E, FY, 1.0),
        lambda: MenegottoPinto(E, FY, 0.01, softening=1.0),
        lambda: CowperSymonds(0.0, 5.0),
        lambda: CowperSymonds(40.4, 0.5),
    ],
)
def test_impossible_laws_are_refused(wrong) -> None:
    with pytest.raises(InputError):
        wrong()
