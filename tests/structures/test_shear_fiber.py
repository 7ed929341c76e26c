"""The fiber with normal and shear stress: yield ellipse, limits, tangent, associated flow."""

from __future__ import annotations

import numpy as np
import pytest
from builders import examples
from hypothesis import given
from hypothesis import strategies as st
from section_cases import stress_path

from workbench.base.errors import InputError
from workbench.mechanics.structures.fibers import kernels
from workbench.mechanics.structures.fibers.section import LinearHardening, ShearYielding
from workbench.steel.materials import MILD_STEEL, CowperSymonds

E, FY = 210e9, 355e6
G = E / 2.6
STRAIN = st.floats(-0.3, 0.3)
STILL = np.inf
SENSITIVE = st.builds(CowperSymonds, st.floats(1.0, 1e4), st.floats(1.0, 10.0))
LASTING = st.floats(-7.0, 1.0).map(lambda exponent: 10.0**exponent)


def sheared(H: float, strains, plastic, rate: CowperSymonds | None = None, duration=STILL):
    """Result of the kernel for a fiber with kinematic hardening H."""
    p = ShearYielding(E, G, FY, H, rate).parameters()
    return kernels.sheared(p, duration, *strains, *plastic)


def equivalent(sigma: float, tau: float) -> float:
    return float(np.hypot(sigma, np.sqrt(3.0) * tau)) / FY


@given(eps=STRAIN, gamma=STRAIN, eps_p=STRAIN, gamma_p=STRAIN, ratio=st.sampled_from([0.0, 1e-2]))
@examples(200)
def test_stress_is_on_the_ellipse_and_flow_is_the_most_dissipative(
    eps, gamma, eps_p, gamma_p, ratio
) -> None:
    H = ratio * E
    sigma, tau, *_, eps_n, gamma_n = sheared(H, (eps, gamma), (eps_p, gamma_p))
    xi = np.array([sigma - H * eps_n, tau - H * gamma_n / 3.0])
    assert equivalent(*xi) <= 1.0 + 1e-10
    flow = np.array([eps_n - eps_p, gamma_n - gamma_p])
    angle = np.linspace(0.0, 2.0 * np.pi, 37)
    others = FY * np.stack([np.cos(angle), np.sin(angle) / np.sqrt(3.0)])
    assert np.all(flow @ others <= flow @ xi + 1e-9 * FY * np.abs(flow).sum())


@given(eps=STRAIN, gamma=STRAIN, eps_p=STRAIN, gamma_p=STRAIN, ratio=st.sampled_from([0.0, 1e-2]))
@examples(200)
def test_tangent_is_the_derivative(eps, gamma, eps_p, gamma_p, ratio) -> None:
    def stress(e: float, g: float) -> np.ndarray:
        return np.array(sheared(ratio * E, (e, g), (eps_p, gamma_p)))

    _, _, k11, k12, k22, *_ = stress(eps, gamma)
    h = 1e-7
    by_eps = [(s * (stress(eps + s * h, gamma) - stress(eps, gamma)) / h)[:2] for s in (1.0, -1.0)]
    by_gamma = [
        (s * (stress(eps, gamma + s * h) - stress(eps, gamma)) / h)[:2] for s in (1.0, -1.0)
    ]
    tolerance = 2e-4 * E  # of first order in h near the ellipse
    assert min(np.abs(d - [k11, k12]).max() for d in by_eps) <= tolerance
    assert min(np.abs(d - [k12, k22]).max() for d in by_gamma) <= tolerance


def test_without_shear_it_is_the_uniaxial_law() -> None:
    H = 1e-3 * E
    strains = FY / E * np.array([0.5, 3.0, -4.0, 20.0])
    expected = stress_path(LinearHardening(E, FY, H), strains)
    eps_p = gamma_p = 0.0
    for strain, (stress, tangent) in zip(strains, expected, strict=True):
        sigma, tau, k11, k12, _, eps_p, gamma_p = sheared(H, (strain, 0.0), (eps_p, gamma_p))
        assert sigma == pytest.approx(stress, rel=1e-10)
        assert (tau, k12) == (0.0, 0.0)
        assert k11 == pytest.approx(tangent, rel=1e-9)


def test_pure_shear_yields_at_the_von_mises_stress() -> None:
    sigma, tau, *_ = sheared(0.0, (0.0, 0.05), (0.0, 0.0))
    assert (sigma, tau) == (0.0, pytest.approx(FY / np.sqrt(3.0), rel=1e-12))


# --- strain rate ----------------------------------------------------------------------------


@given(
    strains=st.tuples(STRAIN, STRAIN), plastic=st.tuples(STRAIN, STRAIN), law=SENSITIVE,
    duration=LASTING, ratio=st.sampled_from([0.0, 1e-6, 1e-2]),
)  # fmt: skip
@examples(300)
def test_overstress_is_that_of_the_plastic_strain_of_the_step(
    strains, plastic, law, duration, ratio
) -> None:
    """On the grown ellipse, flow along its normal and never against the stress."""
    H = ratio * E
    sigma, tau, *moduli, eps_p, gamma_p = sheared(H, strains, plastic, law, duration)
    still = sheared(H, strains, plastic)
    xi = np.array([sigma - H * eps_p, tau - H * gamma_p / 3.0])
    flow = np.array([eps_p, gamma_p]) - plastic
    stress, strain = equivalent(*xi) * FY, float(np.hypot(flow[0], flow[1] / np.sqrt(3.0)))
    if tuple(still[5:]) == plastic:
        assert (eps_p, gamma_p) == plastic  # inside the static ellipse nothing flows
        return
    ends = (max(strain - 2e-16, 0.0), strain + 2e-16)  # differences of numbers near 1
    low, high = (FY * law.factor(end / duration) for end in ends)
    assert low * (1.0 - 1e-11) <= stress <= high * (1.0 + 1e-11)  # measured 1.1e-12
    normal = np.array([xi[0], 3.0 * xi[1]]) / stress
    np.testing.assert_allclose(flow, strain * normal, rtol=0.0, atol=1e-12)  # measured 2e-14
    assert xi @ flow >= 0.0
    k11, k12, k22 = moduli
    assert min(k11, k22, k11 * k22 - k12 * k12) >= -1e-12 * E


@given(
    strains=st.tuples(STRAIN, STRAIN), plastic=st.tuples(STRAIN, STRAIN), law=SENSITIVE,
    duration=LASTING, ratio=st.sampled_from([0.0, 1e-2]),
)  # fmt: skip
@examples(200)
def test_tangent_with_rate_is_the_derivative(strains, plastic, law, duration, ratio) -> None:
    def stress(eps: float, gamma: float) -> np.ndarray:
        return np.array(sheared(ratio * E, (eps, gamma), plastic, law, duration))

    eps, gamma = strains
    k11, k12, k22 = stress(eps, gamma)[2:5]
    h = 1e-7
    by_eps = (stress(eps + h, gamma) - stress(eps - h, gamma))[:2] / (2.0 * h)
    by_gamma = (stress(eps, gamma + h) - stress(eps, gamma - h))[:2] / (2.0 * h)
    # measured on 16 000 states: median 5e-11, 99 % 6e-9, worst 1.4e-5, where flow sets in
    assert np.abs(by_eps - [k11, k12]).max() <= 1e-4 * E
    assert np.abs(by_gamma - [k12, k22]).max() <= 1e-4 * E


@pytest.mark.parametrize("H", [0.0, 1e-2 * E])
def test_one_stress_alone_follows_its_law(H: float) -> None:
    """Without shear the uniaxial law; in pure shear tau = fy (1 + (g' / 3^1/2 D)^1/q) / 3^1/2."""
    path, duration = 2e-3 * np.arange(1, 30), 1e-4
    expected = stress_path(LinearHardening(E, FY, H, rate=MILD_STEEL), path, duration)
    plastic = slid = (0.0, 0.0)
    for strain, (stress, modulus) in zip(path, expected, strict=True):
        sigma, tau, k11, k12, _, *plastic = sheared(H, (strain, 0.0), plastic, MILD_STEEL, duration)
        assert (tau, k12) == (0.0, 0.0)
        assert (sigma, k11) == pytest.approx((stress, modulus), rel=1e-11)
        before = slid
        sigma, tau, *_, eps_p, gamma_p = sheared(H, (0.0, strain), slid, MILD_STEEL, duration)
        slid = eps_p, gamma_p
    assert sigma == eps_p == 0.0
    rate = (gamma_p - before[1]) / duration / np.sqrt(3.0)
    assert H > 0.0 or rate == pytest.approx(2e-3 / duration / np.sqrt(3.0), rel=1e-9)
    yielding = FY * MILD_STEEL.factor(rate) + H * gamma_p / np.sqrt(3.0)
    assert tau == pytest.approx(yielding / np.sqrt(3.0), rel=1e-12)


def test_impossible_laws_are_refused() -> None:
    for wrong in ({"yield_stress": 0.0}, {"shear_modulus": -G}, {"kinematic_modulus": -1.0}):
        values = {"elastic_modulus": E, "shear_modulus": G, "yield_stress": FY} | wrong
        with pytest.raises(InputError):
            ShearYielding(**values)
