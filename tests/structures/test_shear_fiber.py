"""The fiber with normal and shear stress: yield ellipse, limits, tangent, associated flow."""

from __future__ import annotations

import numpy as np
import pytest
from builders import examples
from hypothesis import given
from hypothesis import strategies as st
from section_cases import stress_path

from workbench.errors import InputError
from workbench.structures.fibers.kernels import sheared
from workbench.structures.fibers.section import LinearHardening, ShearYielding

E, FY = 210e9, 355e6
G = E / 2.6
STRAIN = st.floats(-0.3, 0.3)


def equivalent(sigma: float, tau: float) -> float:
    return float(np.hypot(sigma, np.sqrt(3.0) * tau)) / FY


@given(eps=STRAIN, gamma=STRAIN, eps_p=STRAIN, gamma_p=STRAIN, ratio=st.sampled_from([0.0, 1e-6]))
@examples(200)
def test_stress_is_on_the_ellipse_and_flow_is_the_most_dissipative(
    eps, gamma, eps_p, gamma_p, ratio
) -> None:
    H = ratio * E
    sigma, tau, *_, eps_n, gamma_n = sheared(E, G, H, FY, eps, gamma, eps_p, gamma_p)
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
        return np.array(sheared(E, G, ratio * E, FY, e, g, eps_p, gamma_p))

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
        sigma, tau, k11, k12, _, eps_p, gamma_p = sheared(E, G, H, FY, strain, 0.0, eps_p, gamma_p)
        assert sigma == pytest.approx(stress, rel=1e-10)
        assert (tau, k12) == (0.0, 0.0)
        assert k11 == pytest.approx(tangent, rel=1e-9)


def test_pure_shear_yields_at_the_von_mises_stress() -> None:
    sigma, tau, *_ = sheared(E, G, 0.0, FY, 0.0, 0.05, 0.0, 0.0)
    assert (sigma, tau) == (0.0, pytest.approx(FY / np.sqrt(3.0), rel=1e-12))


def test_impossible_laws_are_refused() -> None:
    for wrong in ({"yield_stress": 0.0}, {"shear_modulus": -G}, {"kinematic_modulus": -1.0}):
        values = {"elastic_modulus": E, "shear_modulus": G, "yield_stress": FY} | wrong
        with pytest.raises(InputError):
            ShearYielding(**values)
