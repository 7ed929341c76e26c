"""Steel at a point of the solid: polar decomposition, plane-stress return, squeeze guard.

Compiled, one point at a time. Tensors are (11, 22, 12), strains with the engineering shear 2 e12;
deformation gradients and what derives from them (11, 12, 21, 22).
Source: Simo and Hughes 1998, section 3.4.
"""

from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit

RETURN_ITERATIONS = 50
CLOSED = 2e-15  # of the yield stress: round-off; the iteration comes from below
SQUEEZED = 0.2  # share of its area below which a point resists being squeezed to nothing
SQUEEZE_STIFFNESS = 0.002  # over Young's modulus


class SolidSteel(NamedTuple):
    """Young's modulus (Pa), Poisson's ratio, yield stress and isotropic hardening modulus (Pa).

    Of a step with strain rate: `reference_flow` D dt, equivalent plastic strain at which the
    overstress is the yield stress, infinite without a rate; `exponent` q of the law.
    """

    modulus: float
    poisson: float
    yield_stress: float
    hardening: float
    reference_flow: float = np.inf
    exponent: float = 1.0


class Tensor(NamedTuple):
    """Stress (Pa), or strain with the engineering shear."""

    t11: float
    t22: float
    t12: float


class Stretched(NamedTuple):
    """F = R U in the plane.

    Biot `strain` U - I; `cosine` and `sine` of the rotation; the `trace` of U; the `area` ratio
    det F.
    """

    strain: Tensor
    cosine: float
    sine: float
    trace: float
    area: float


class Returned(NamedTuple):
    """Result of the return mapping.

    `stress`; multiplier `gamma`, 0 where elastic, NaN where the iteration does not converge; the
    step of plastic strain `flow` and the equivalent plastic strain `hardened` at its end.
    """

    stress: Tensor
    gamma: float
    flow: Tensor
    hardened: float


@njit(cache=True, error_model="numpy")
def stretched(f11: float, f12: float, f21: float, f22: float) -> Stretched:
    """Polar decomposition of a deformation gradient."""
    a, b = f11 + f22, f21 - f12
    trace = np.sqrt(a * a + b * b)
    c, s = a / trace, b / trace
    u11, u22, u12 = c * f11 + s * f21, c * f22 - s * f12, c * f12 + s * f22
    area = f11 * f22 - f12 * f21
    return Stretched(Tensor(u11 - 1.0, u22 - 1.0, 2.0 * u12), c, s, trace, area)


@njit(cache=True, error_model="numpy")
def von_mises_squared(stress: Tensor) -> float:
    """Square of the equivalent stress in plane stress."""
    t1, t2, t3 = stress
    return t1**2 - t1 * t2 + t2**2 + 3.0 * t3**2


@njit(cache=True, error_model="numpy")
def _multiplier(a: float, b: float, strength: float, k1: float, k2: float, H: float) -> float:
    """Multiplier of the return to a surface of that `strength` and hardening; NaN: none found.

    The square of the equivalent stress is a / (1 + k1 gamma)^2 + b / (1 + k2 gamma)^2.
    """
    gamma = 0.0
    # strength / stress(gamma) - 1 + 2/3 H gamma is concave and rises: Newton from 0 is safe
    for _ in range(RETURN_ITERATIONS):
        l1, l2 = 1.0 + k1 * gamma, 1.0 + k2 * gamma
        square = a / l1**2 + b / l2**2
        value = strength / np.sqrt(square) - 1.0 + 2.0 / 3.0 * H * gamma
        if value > -CLOSED:
            return gamma
        slope = strength * (a * k1 / l1**3 + b * k2 / l2**3) / square**1.5 + 2.0 / 3.0 * H
        gamma -= value / slope
    return np.nan


@njit(cache=True, error_model="numpy")
def _overstress(
    a: float, b: float, strength: float, k1: float, k2: float, steel: SolidSteel
) -> float:
    """Overstress x over the yield stress at the end of a step; NaN where none is found.

    p(x), the plastic strain of the return to the surface grown by it, is D dt x^q: the difference
    falls and is concave but for round-off, so that Newton comes down from an upper bound.
    """
    fy, H, flow, q = steel.yield_stress, steel.hardening, steel.reference_flow, steel.exponent
    x = (np.sqrt(a + b) - strength) / fy
    for k in range(RETURN_ITERATIONS):
        gamma = _multiplier(a, b, strength + (fy * x if k else 0.0), k1, k2, H)
        l1, l2 = 1.0 + k1 * gamma, 1.0 + k2 * gamma
        stress = np.sqrt(a / l1**2 + b / l2**2)
        p = 2.0 / 3.0 * gamma * stress
        if k == 0:  # without any overstress: the largest plastic strain
            x = min(x, (p / flow) ** (1.0 / q))
            continue
        fall = (a * k1 / l1**3 + b * k2 / l2**3) / stress  # - d stress / d gamma
        growth = 2.0 / 3.0 * (stress / fall - gamma)  # - dp / d stress
        step = (p - flow * x**q) / (growth * fy / (1.0 + H * growth) + q * flow * x ** (q - 1.0))
        x = max(x + step, 0.0)
        if abs(step) <= 4.0 * CLOSED * (1.0 + x):
            return float(x)
    return np.nan


@njit(cache=True, error_model="numpy")
def return_mapping(elastic: Tensor, hardened: float, steel: SolidSteel) -> Returned:
    """Simo-Taylor return to the von Mises yield surface in plane stress, grown by strain rate.

    Arguments: strain less the plastic strain at the start, `elastic`; equivalent plastic strain
    `hardened` at the start; `steel`. With a rate the strength is fy (1 + x) + H times the
    equivalent plastic strain, x = (p / D dt)^(1/q) by that of the step, p: Perzyna's form of the
    law of Cowper and Symonds, backward Euler.
    """
    E, nu, fy, H = steel.modulus, steel.poisson, steel.yield_stress, steel.hardening
    e1, e2, e3 = elastic
    double_shear, bulk = E / (1.0 + nu), E / (1.0 - nu)
    # eigenvectors of elasticity and of the yield function: (1, 1, 0), (-1, 1, 0), (0, 0, 1)
    eta1, eta2, shear = bulk * (e1 + e2), double_shear * (e2 - e1), 0.5 * double_shear * e3
    a, b = 0.25 * eta1**2, 0.75 * eta2**2 + 3.0 * shear**2
    strength = fy + H * hardened
    k1, k2 = bulk / 3.0, double_shear
    if steel.reference_flow < np.inf and a + b > strength**2:
        strength += fy * _overstress(a, b, strength, k1, k2, steel)
    gamma = _multiplier(a, b, strength, k1, k2, H)
    eta1, eta2 = eta1 / (1.0 + k1 * gamma), eta2 / (1.0 + k2 * gamma)
    shear /= 1.0 + k2 * gamma
    stress = Tensor(0.5 * (eta1 - eta2), 0.5 * (eta1 + eta2), shear)
    n1, n2, n3 = normal(stress)
    flow = Tensor(gamma * n1, gamma * n2, gamma * n3)
    hardened += 2.0 / 3.0 * gamma * np.sqrt(von_mises_squared(stress))
    return Returned(stress, gamma, flow, hardened)


@njit(cache=True, error_model="numpy")
def normal(stress: Tensor) -> Tensor:
    """Direction of plastic flow: derivative of half the square of the equivalent stress by 2/3."""
    t1, t2, t3 = stress
    return Tensor((2.0 * t1 - t2) / 3.0, (2.0 * t2 - t1) / 3.0, 2.0 * t3)


@njit(cache=True, error_model="numpy")
def add_return_tangent(back: Returned, steel: SolidSteel, C: Array) -> None:
    """Add the consistent tangent of a return without strain rate to C (3, 3)."""
    E, nu, H = steel.modulus, steel.poisson, steel.hardening
    gamma = back.gamma
    double_shear, bulk = E / (1.0 + nu), E / (1.0 - nu)
    x1 = bulk / (1.0 + bulk / 3.0 * gamma)
    x2 = double_shear / (1.0 + double_shear * gamma)
    C[0, 0] += 0.5 * (x1 + x2)
    C[1, 1] += 0.5 * (x1 + x2)
    C[0, 1] += 0.5 * (x1 - x2)
    C[1, 0] += 0.5 * (x1 - x2)
    C[2, 2] += 0.5 * x2
    if gamma == 0.0:
        return
    n1, n2, n3 = normal(back.stress)
    m = (
        0.5 * (x1 + x2) * n1 + 0.5 * (x1 - x2) * n2,
        0.5 * (x1 - x2) * n1 + 0.5 * (x1 + x2) * n2,
        0.5 * x2 * n3,
    )
    square = von_mises_squared(back.stress)
    softening = 4.0 / 9.0 * H * square / (1.0 - 2.0 / 3.0 * H * gamma)
    scale = 1.0 / (n1 * m[0] + n2 * m[1] + n3 * m[2] + softening)
    for i in range(3):
        for j in range(3):
            C[i, j] -= scale * m[i] * m[j]


@njit(cache=True, error_model="numpy")
def squeeze(stretch: Stretched, modulus: float) -> Tensor:
    """Stress of the guard k/2 <ln(SQUEEZED / J)>^2, J = det F.

    Perfect plasticity in nominal stress lets a singular corner shrink to no volume at all; the
    guard acts below J = SQUEEZED only.
    """
    e1, e2, e3 = stretch.strain
    pressure = SQUEEZE_STIFFNESS * modulus * np.log(SQUEEZED / stretch.area) / stretch.area
    # derivatives of J = U11 U22 - U12^2 by (U11, U22, 2 U12)
    return Tensor(-pressure * (1.0 + e2), -pressure * (1.0 + e1), 0.5 * pressure * e3)


@njit(cache=True, error_model="numpy")
def add_squeeze_tangent(stretch: Stretched, modulus: float, C: Array) -> None:
    """Add the tangent of the squeeze guard to C (3, 3)."""
    e1, e2, e3 = stretch.strain
    k, logarithm = SQUEEZE_STIFFNESS * modulus, np.log(SQUEEZED / stretch.area)
    j = (1.0 + e2, 1.0 + e1, -0.5 * e3)
    for i in range(3):
        for n in range(3):
            C[i, n] += k * (1.0 + logarithm) / stretch.area**2 * j[i] * j[n]
    pressure = k * logarithm / stretch.area
    C[0, 1] -= pressure
    C[1, 0] -= pressure
    C[2, 2] += 0.5 * pressure


@njit(cache=True, error_model="numpy")
def nominal_stress(stretch: Stretched, stress: Tensor) -> tuple[float, float, float, float]:
    """Nominal stress (11, 12, 21, 22), conjugate to F, of the Biot stress conjugate to U."""
    c, s = stretch.cosine, stretch.sine
    e1, e2, e3 = stretch.strain
    t1, t2, t3 = stress
    lever = (0.5 * (t1 - t2) * e3 + t3 * (e2 - e1)) / stretch.trace
    return (
        c * t1 - s * t3 - lever * s,
        c * t3 - s * t2 - lever * c,
        s * t1 + c * t3 + lever * c,
        s * t3 + c * t2 - lever * s,
    )


@njit(cache=True, error_model="numpy")
def nominal_tangent(stretch: Stretched, stress: Tensor, C: Array, D: Array, K: Array) -> None:
    """Derivative K (4, 4) of the nominal stress by F.

    Arguments: tangent C (3, 3) of the Biot stress by the strain; D (3, 4), room for the derivative
    of the strain by F.
    """
    c, s = stretch.cosine, stretch.sine
    e1, e2, e3 = stretch.strain
    t1, t2, t3 = stress
    turn = (-s / stretch.trace, -c / stretch.trace, c / stretch.trace, -s / stretch.trace)
    fixed = ((c, 0.0, s, 0.0), (0.0, -s, 0.0, c), (-s, c, c, s))
    half, apart = 0.5 * (t1 - t2), e2 - e1
    lever = (half * e3 + t3 * apart) / stretch.trace
    stiffening = 0.5 * stretch.trace * (t1 + t2) + half * apart - t3 * e3
    along, across, rest = (-s, c, c, s), (-c, -s, -s, c), (c, -s, s, c)
    for i in range(4):
        D[0, i] = fixed[0][i] + 0.5 * e3 * turn[i]
        D[1, i] = fixed[1][i] - 0.5 * e3 * turn[i]
        D[2, i] = fixed[2][i] + apart * turn[i]
    for i in range(4):
        # due to turning, sum_k T_k d2U_k / dF2
        turning_i = half * along[i] + t3 * across[i] + 0.5 * stiffening * turn[i] - lever * rest[i]
        for j in range(4):
            turning_j = half * along[j] + t3 * across[j] + 0.5 * stiffening * turn[j]
            turning_j -= lever * rest[j]
            K[i, j] = turning_i * turn[j] + turn[i] * turning_j
            for k in range(3):
                for n in range(3):
                    K[i, j] += D[k, i] * C[k, n] * D[n, j]
