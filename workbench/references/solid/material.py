"""Steel at the points of the solid: polar decomposition, plane-stress return, squeeze guard.

Arrays begin with components, all points (...) follow: tensors (11, 22, 12), strains with the
engineering shear 2 e12; deformation gradients and what derives from them (11, 12, 21, 22).
Source: Simo and Hughes 1998, section 3.4.
"""

from typing import NamedTuple

import numpy as np

from workbench.arrays import Array

RETURN_ITERATIONS = 50
CLOSED = 2e-15  # of the yield stress: round-off; the iteration comes from below
SQUEEZED = 0.2  # share of its area below which a point resists being squeezed to nothing
SQUEEZE_STIFFNESS = 0.002  # over Young's modulus


class SolidSteel(NamedTuple):
    """Young's modulus (Pa), Poisson's ratio, yield stress and isotropic hardening modulus (Pa)."""

    modulus: float
    poisson: float
    yield_stress: float
    hardening: float


class State(NamedTuple):
    """`plastic` strain (3, ...), equivalent plastic strain `hardened` (...), `stress` (3, ...)."""

    plastic: Array
    hardened: Array
    stress: Array


class Stretched(NamedTuple):
    """F = R U in the plane.

    Biot `strain` (3, ...) of U and its `derivative` by F (3, 4, ...); `cosine` and `sine` of the
    rotation; `turn` (4, ...), its derivative by F; the `trace` of U; the `area` ratio det F.
    """

    strain: Array
    derivative: Array
    cosine: Array
    sine: Array
    trace: Array
    turn: Array
    area: Array


class Answer(NamedTuple):
    """What points answer: nominal stress (4, ...), its tangent (4, 4, ...), strain, new state."""

    nominal: Array
    tangent: Array
    strain: Array
    state: State


def stretched(F: Array) -> Stretched:
    """Polar decomposition of deformation gradients F (4, ...)."""
    a, b = F[0] + F[3], F[2] - F[1]
    trace = np.sqrt(a * a + b * b)
    c, s, zero = a / trace, b / trace, np.zeros_like(a)
    u11, u22, u12 = c * F[0] + s * F[2], c * F[3] - s * F[1], c * F[1] + s * F[3]
    turn = np.stack([-s, -c, c, -s]) / trace
    rows = np.stack(
        [
            np.stack([c, zero, s, zero]) + u12 * turn,
            np.stack([zero, -s, zero, c]) - u12 * turn,
            np.stack([-s, c, c, s]) + (u22 - u11) * turn,
        ]
    )
    strain = np.stack([u11 - 1.0, u22 - 1.0, 2.0 * u12])
    return Stretched(strain, rows, c, s, trace, turn, F[0] * F[3] - F[1] * F[2])


def turning(found: Stretched, T: Array) -> Array:
    """sum_k T_k d2U_k/dF2 (4, 4, ...): the part of the tangent due to turning under stress T."""
    c, s, turn, strain = found.cosine, found.sine, found.turn, found.strain
    half, apart = 0.5 * (T[0] - T[1]), strain[1] - strain[0]
    lever = (half * strain[2] + T[2] * apart) / found.trace
    stiffening = 0.5 * found.trace * (T[0] + T[1]) + half * apart - T[2] * strain[2]
    across = half * np.stack([-s, c, c, s]) + T[2] * np.stack([-c, -s, -s, c])
    across += 0.5 * stiffening * turn - lever * np.stack([c, -s, s, c])
    return np.asarray(across[:, None] * turn[None] + turn[:, None] * across[None])


def plane_stress_return(strain: Array, old: State, steel: SolidSteel) -> tuple[State, Array]:
    """Simo-Taylor return to the von Mises yield surface in plane stress.

    Arguments: strain (3, ...), committed state `old`. Result: the new state, NaN where the
    iteration does not converge, and the consistent tangent (3, 3, ...).
    """
    E, nu, fy, H = steel
    e1, e2, e3 = strain - old.plastic
    double_shear, bulk = E / (1.0 + nu), E / (1.0 - nu)
    # eigenvectors of elasticity and of the yield function: (1, 1, 0), (-1, 1, 0), (0, 0, 1)
    eta1, eta2, shear = bulk * (e1 + e2), double_shear * (e2 - e1), 0.5 * double_shear * e3
    a, b = 0.25 * eta1**2, 0.75 * eta2**2 + 3.0 * shear**2
    strength = fy + H * old.hardened
    k1, k2 = bulk / 3.0, double_shear
    gamma = np.zeros_like(a)
    # strength / stress(gamma) - 1 + 2/3 H gamma is concave and rises: Newton from 0 is safe
    for _ in range(RETURN_ITERATIONS):
        l1, l2 = 1.0 + k1 * gamma, 1.0 + k2 * gamma
        square = a / l1**2 + b / l2**2
        value = strength / np.sqrt(square) - 1.0 + 2.0 / 3.0 * H * gamma
        outside = ~(value > -CLOSED)
        if not outside.any():
            break
        slope = strength * (a * k1 / l1**3 + b * k2 / l2**3) / square**1.5 + 2.0 / 3.0 * H
        gamma = np.where(outside, gamma - value / slope, gamma)
    gamma = np.where(outside, np.nan, gamma)
    eta1, eta2, shear = eta1 / l1, eta2 / l2, shear / l2
    T = np.stack([0.5 * (eta1 - eta2), 0.5 * (eta1 + eta2), shear])
    normal = np.stack([(2.0 * T[0] - T[1]) / 3.0, (2.0 * T[1] - T[0]) / 3.0, 2.0 * T[2]])
    square = T[0] ** 2 - T[0] * T[1] + T[1] ** 2 + 3.0 * T[2] ** 2
    hardened = old.hardened + 2.0 / 3.0 * gamma * np.sqrt(square)
    x1, x2, zero = bulk / l1, double_shear / l2, np.zeros_like(a)
    C = np.stack(
        [
            np.stack([0.5 * (x1 + x2), 0.5 * (x1 - x2), zero]),
            np.stack([0.5 * (x1 - x2), 0.5 * (x1 + x2), zero]),
            np.stack([zero, zero, 0.5 * x2]),
        ]
    )
    m = np.einsum("ij...,j...->i...", C, normal)
    softening = 4.0 / 9.0 * H * square / (1.0 - 2.0 / 3.0 * H * gamma)
    scale = np.where(a + b > strength**2, 1.0 / (np.sum(normal * m, axis=0) + softening), 0.0)
    C -= scale * m[:, None] * m[None]
    return State(old.plastic + gamma * normal, hardened, T), C


def squeeze(area: Array, strain: Array, modulus: float) -> tuple[Array, Array]:
    """Stress (3, ...) and tangent (3, 3, ...) of the guard k/2 <ln(SQUEEZED / J)>^2, J = det F.

    Perfect plasticity in nominal stress lets a singular corner shrink to no volume at all; the
    guard acts below J = `area` = SQUEEZED only. Arguments: `strain` (3, ...), Young's modulus.
    """
    k = np.where(area < SQUEEZED, SQUEEZE_STIFFNESS * modulus, 0.0)
    logarithm = np.log(SQUEEZED / area)
    pressure = k * logarithm / area
    # derivatives of J = U11 U22 - U12^2 by (U11, U22, 2 U12)
    j = np.stack([1.0 + strain[1], 1.0 + strain[0], -0.5 * strain[2]])
    C = k * (1.0 + logarithm) / area**2 * j[:, None] * j[None]
    C[0, 1] -= pressure
    C[1, 0] -= pressure
    C[2, 2] += 0.5 * pressure
    return -pressure * j, C


def respond_to(F: Array, old: State, steel: SolidSteel) -> Answer | None:
    """What points answer to deformation gradients F (4, ...) from their committed state `old`.

    The stress of the new state is Biot's without the squeeze guard, nominal stress and tangent
    include it. None where a point is turned inside out or its return does not converge.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        found = stretched(F)
        if not np.all((found.trace > 0.0) & (found.area > 0.0)):
            return None
        new, C = plane_stress_return(found.strain, old, steel)
    if not np.isfinite(new.hardened).all():
        return None
    guard, guard_tangent = squeeze(found.area, found.strain, steel.modulus)
    T, D = new.stress + guard, found.derivative
    nominal = np.einsum("ki...,k...->i...", D, T)
    tangent = np.einsum("ki...,km...,mj...->ij...", D, C + guard_tangent, D, optimize=True)
    return Answer(nominal, tangent + turning(found, T), found.strain, new)
