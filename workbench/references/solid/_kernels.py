"""Kernels of the solid: polar decomposition, plane-stress return, squeeze guard, element loop.

Tensors are in the components (11, 22, 12), strains with the engineering shear 2 e12; deformation
gradients and their derivatives are ordered (11, 12, 21, 22).
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

RETURN_ITERATIONS = 50
CLOSED = 2e-15  # of the yield stress: round-off; the iteration comes from below
SQUEEZED = 0.2  # share of its area below which a point resists being squeezed to nothing
SQUEEZE_STIFFNESS = 0.002  # over Young's modulus


class Tables(NamedTuple):
    """Elements of a mesh.

    `gradients` (elements, points, nodes, 2); `weights` (elements, points), thickness times area;
    `dofs` (elements, 2 nodes).
    """

    gradients: Any
    weights: Any
    dofs: Any


class State(NamedTuple):
    """State of all points: `plastic` strain and `stress` (elements, points, 3), `hardened` by."""

    plastic: Any
    hardened: Any
    stress: Any


@njit(cache=True, error_model="numpy")
def stretch(F, strain, D):
    """Biot strain of F = R U and D = d(U11, U22, 2 U12)/dF.

    Arguments: F (4,); results: strain (3,), D (3, 4). Returns (c, s, r): the rotation's cosine
    and sine, and r = tr U, which is not positive where the material is turned inside out.
    """
    a, b = F[0] + F[3], F[2] - F[1]
    r = np.sqrt(a * a + b * b)
    c, s = a / r, b / r
    u11, u22 = c * F[0] + s * F[2], -s * F[1] + c * F[3]
    u12 = c * F[1] + s * F[3]
    strain[0], strain[1], strain[2] = u11 - 1.0, u22 - 1.0, 2.0 * u12
    # p = d(angle of R)/dF
    p0, p1, p2, p3 = -s / r, -c / r, c / r, -s / r
    D[0, 0], D[0, 1], D[0, 2], D[0, 3] = c + u12 * p0, u12 * p1, s + u12 * p2, u12 * p3
    D[1, 0], D[1, 1], D[1, 2], D[1, 3] = -u12 * p0, -s - u12 * p1, -u12 * p2, c - u12 * p3
    d = u22 - u11
    D[2, 0], D[2, 1], D[2, 2], D[2, 3] = -s + d * p0, c + d * p1, c + d * p2, s + d * p3
    if F[0] * F[3] - F[1] * F[2] <= 0.0:
        r = -1.0
    return c, s, r


@njit(cache=True, error_model="numpy")
def geometric(c, s, r, strain, D, T, A):
    """Add sum_k T_k d(D_k)/dF to A (4, 4): the part of the tangent due to turning."""
    u12, d = 0.5 * strain[2], strain[1] - strain[0]
    p = (-s / r, -c / r, c / r, -s / r)
    t = (c, -s, s, c)
    w1 = (-s, 0.0, c, 0.0)
    w2 = (0.0, -c, 0.0, -s)
    w3 = (-c, -s, -s, c)
    for i in range(4):
        for j in range(4):
            dp = -(t[i] * p[j] + p[i] * t[j]) / r
            half = 0.5 * D[2, j]
            first = w1[i] * p[j] + p[i] * half + u12 * dp
            second = w2[i] * p[j] - p[i] * half - u12 * dp
            third = w3[i] * p[j] + p[i] * (D[1, j] - D[0, j]) + d * dp
            A[i, j] += T[0] * first + T[1] * second + T[2] * third


@njit(cache=True, error_model="numpy")
def plane_stress_return(strain, plastic0, hardened0, E, nu, fy, H, plastic1, T, C):
    """Simo-Taylor return to the von Mises yield surface in plane stress.

    Arguments: strain (3,), committed plastic strain (3,) and equivalent plastic strain,
    constants with the isotropic hardening modulus H; results: plastic1 (3,), T (3,), consistent
    tangent C (3, 3). Returns the new equivalent plastic strain, NaN without convergence.
    """
    e1, e2, e3 = strain[0] - plastic0[0], strain[1] - plastic0[1], strain[2] - plastic0[2]
    mu2 = E / (1.0 + nu)  # 2 mu
    bulk = E / (1.0 - nu)
    # eigenvectors of elasticity and of the yield function: (1, 1, 0), (-1, 1, 0), (0, 0, 1)
    eta1, eta2, shear = bulk * (e1 + e2), mu2 * (e2 - e1), 0.5 * mu2 * e3
    a, b = 0.25 * eta1 * eta1, 0.75 * eta2 * eta2 + 3.0 * shear * shear
    strength = fy + H * hardened0
    gamma = 0.0
    hardened1 = hardened0
    k1 = bulk / 3.0
    plastic = a + b > strength * strength
    if plastic:
        # strength / stress(gamma) - 1 + 2/3 H gamma is concave and rises: Newton from 0 is safe
        done = False
        for _ in range(RETURN_ITERATIONS):
            l1, l2 = 1.0 + k1 * gamma, 1.0 + mu2 * gamma
            square = a / (l1 * l1) + b / (l2 * l2)
            stress = np.sqrt(square)
            value = strength / stress - 1.0 + 2.0 / 3.0 * H * gamma
            if value > -CLOSED:
                done = True
                break
            slope = strength * (a * k1 / l1**3 + b * mu2 / l2**3) / (square * stress)
            gamma -= value / (slope + 2.0 / 3.0 * H)
        if not done:
            return np.nan
        eta1, eta2, shear = eta1 / l1, eta2 / l2, shear / l2
    T[0], T[1], T[2] = 0.5 * (eta1 - eta2), 0.5 * (eta1 + eta2), shear
    x1, x2 = bulk / (1.0 + k1 * gamma), mu2 / (1.0 + mu2 * gamma)
    C[0, 0] = C[1, 1] = 0.5 * (x1 + x2)
    C[0, 1] = C[1, 0] = 0.5 * (x1 - x2)
    C[2, 2] = 0.5 * x2
    C[0, 2] = C[2, 0] = C[1, 2] = C[2, 1] = 0.0
    n0, n1, n2 = (2.0 * T[0] - T[1]) / 3.0, (2.0 * T[1] - T[0]) / 3.0, 2.0 * T[2]
    plastic1[0] = plastic0[0] + gamma * n0
    plastic1[1] = plastic0[1] + gamma * n1
    plastic1[2] = plastic0[2] + gamma * n2
    if plastic:
        square = T[0] * T[0] - T[0] * T[1] + T[1] * T[1] + 3.0 * T[2] * T[2]
        hardened1 = hardened0 + 2.0 / 3.0 * gamma * np.sqrt(square)
        m0 = C[0, 0] * n0 + C[0, 1] * n1
        m1 = C[1, 0] * n0 + C[1, 1] * n1
        m2 = C[2, 2] * n2
        beta = 4.0 / 9.0 * H * square / (1.0 - 2.0 / 3.0 * H * gamma)
        scale = 1.0 / (n0 * m0 + n1 * m1 + n2 * m2 + beta)
        m = (m0, m1, m2)
        for i in range(3):
            for j in range(3):
                C[i, j] -= scale * m[i] * m[j]
    return hardened1


@njit(cache=True, error_model="numpy")
def squeeze(area, strain, E, T, C):
    """Add the guard k/2 <ln(SQUEEZED / J)>^2 of a squeezed point to the stress and its tangent.

    Perfect plasticity in nominal stress lets a singular corner shrink to no volume at all; the
    guard acts below J = `area` = det F = SQUEEZED only. Arguments as in the return.
    """
    if area >= SQUEEZED:
        return
    k = SQUEEZE_STIFFNESS * E
    logarithm = np.log(SQUEEZED / area)
    pressure = k * logarithm / area
    stiffness = k * (1.0 + logarithm) / area**2
    # derivatives of J = U11 U22 - U12^2 by (U11, U22, 2 U12)
    j = (1.0 + strain[1], 1.0 + strain[0], -0.5 * strain[2])
    for a in range(3):
        T[a] -= pressure * j[a]
        for b in range(3):
            C[a, b] += stiffness * j[a] * j[b]
    C[0, 1] -= pressure
    C[1, 0] -= pressure
    C[2, 2] += 0.5 * pressure


@njit(cache=True, error_model="numpy")
def point(F, plastic0, hardened0, steel, strain, plastic1, stress, P, A, work):
    """Nominal stress P (4,) and its tangent A (4, 4) at one quadrature point.

    Arguments: F (4,) and the committed state; `steel` (E, nu, fy, H); `work` (3, 8), scratch.
    Results: Biot strain (3,), new plastic strain (3,), Biot stress (3,) without the squeeze
    guard, P and A with it. Returns the new equivalent plastic strain, NaN where there is none.
    """
    D, C, T = work[:, :4], work[:, 4:7], work[:, 7]
    c, s, r = stretch(F, strain, D)
    if not r > 0.0:
        return np.nan
    hardened1 = plane_stress_return(
        strain, plastic0, hardened0, steel[0], steel[1], steel[2], steel[3], plastic1, stress, C
    )
    T[:] = stress
    squeeze(F[0] * F[3] - F[1] * F[2], strain, steel[0], T, C)
    for i in range(4):
        P[i] = T[0] * D[0, i] + T[1] * D[1, i] + T[2] * D[2, i]
        for j in range(4):
            total = 0.0
            for k in range(3):
                for m in range(3):
                    total += D[k, i] * C[k, m] * D[m, j]
            A[i, j] = total
    geometric(c, s, r, strain, D, T, A)
    return hardened1


@njit(cache=True, error_model="numpy")
def elements(tables, u, steel, old, new, strain, force, stiffness):
    """Forces and stiffness of all elements.

    Arguments: `tables`, displacements u, steel (E, nu, fy, H) and the committed state `old`.
    Results: state `new`, Biot strain (elements, points, 3), force (elements, 2 nodes), stiffness
    (elements, 2 nodes, 2 nodes). Returns False if a point has no answer.
    """
    gradients, weights, dofs = tables
    count, points, nodes, _ = gradients.shape
    F, P, A = np.empty(4), np.empty(4), np.empty((4, 4))
    work, half = np.empty((3, 8)), np.empty((4, 2))
    for e in range(count):
        force[e] = 0.0
        stiffness[e] = 0.0
        for g in range(points):
            F[0], F[1], F[2], F[3] = 1.0, 0.0, 0.0, 1.0
            for n in range(nodes):
                ux, uy = u[dofs[e, 2 * n]], u[dofs[e, 2 * n + 1]]
                g0, g1 = gradients[e, g, n, 0], gradients[e, g, n, 1]
                F[0] += ux * g0
                F[1] += ux * g1
                F[2] += uy * g0
                F[3] += uy * g1
            value = point(
                *(F, old.plastic[e, g], old.hardened[e, g], steel),
                *(strain[e, g], new.plastic[e, g], new.stress[e, g], P, A, work),
            )
            if not np.isfinite(value):
                return False
            new.hardened[e, g] = value
            w = weights[e, g]
            for n in range(nodes):
                g0, g1 = w * gradients[e, g, n, 0], w * gradients[e, g, n, 1]
                force[e, 2 * n] += g0 * P[0] + g1 * P[1]
                force[e, 2 * n + 1] += g0 * P[2] + g1 * P[3]
                for i in range(4):
                    half[i, 0] = A[i, 0] * g0 + A[i, 1] * g1
                    half[i, 1] = A[i, 2] * g0 + A[i, 3] * g1
                for m in range(n + 1):
                    h0, h1 = gradients[e, g, m, 0], gradients[e, g, m, 1]
                    for j in range(2):
                        stiffness[e, 2 * m, 2 * n + j] += h0 * half[0, j] + h1 * half[1, j]
                        stiffness[e, 2 * m + 1, 2 * n + j] += h0 * half[2, j] + h1 * half[3, j]
        for i in range(2 * nodes):
            for j in range(i):
                stiffness[e, i, j] = stiffness[e, j, i]
    return True
