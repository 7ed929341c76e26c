"""Stress update of a fiber with normal stress sigma and shear stress tau.

Symbols: eps, gamma strains, p their plastic parts; xi = (sigma - H eps_p, tau - H gamma_p / 3)
the stress from the centre of the yield ellipse xi_1^2 + 3 xi_2^2 = fy^2; flow (xi_1, 3 xi_2) lam.
Source: closest-point projection, Simo and Hughes 1998, section 3.3, for these two components.
"""

from __future__ import annotations

import math

from numba import njit

ITERATIONS = 60


@njit(cache=True, error_model="numpy")
def multiplier(first, second, a, b, fy):
    """Solve (first / (1 + a lam))^2 + (second / (1 + b lam))^2 = fy^2 for lam > 0.

    The inverse of the equivalent stress is nearly linear in lam (exactly so for one component
    alone): Newton's method on it, kept inside the bracket.
    """
    size = math.sqrt(first * first + second * second) / fy - 1.0
    low, high = size / max(a, b), size / min(a, b)
    lam = 0.5 * (low + high)
    for _ in range(ITERATIONS):
        u = first / (1.0 + a * lam)
        v = second / (1.0 + b * lam)
        square = u * u + v * v
        q = math.sqrt(square)
        # d(1/q)/dlam = (u^2 a/(1 + a lam) + v^2 b/(1 + b lam)) / q^3
        slope = (u * u * a / (1.0 + a * lam) + v * v * b / (1.0 + b * lam)) / (square * q)
        value = 1.0 / q - 1.0 / fy
        if value < 0.0:
            low = lam
        else:
            high = lam
        change = value / slope
        lam -= change
        if not low <= lam <= high:
            lam = 0.5 * (low + high)
        if abs(change) <= 4e-16 * (lam + 1.0 / max(a, b)):
            break
    return lam


@njit(cache=True, error_model="numpy")
def sheared(E, G, H, fy, eps, gamma, eps_p, gamma_p):
    """Stresses, tangent (11, 12, 22) and new plastic strains of a fiber.

    Arguments: moduli and yield stress in Pa; strains; committed plastic strains. Result:
    sigma, tau, three tangent moduli, plastic strain and plastic shear strain.
    """
    sigma = E * (eps - eps_p)
    tau = G * (gamma - gamma_p)
    first = sigma - H * eps_p
    second = tau - H * gamma_p / 3.0
    if first * first + 3.0 * second * second <= fy * fy:
        return sigma, tau, E, 0.0, G, eps_p, gamma_p
    a, b = E + H, 3.0 * G + H
    lam = multiplier(first, math.sqrt(3.0) * second, a, b, fy)
    one, two = 1.0 / (1.0 + a * lam), 1.0 / (1.0 + b * lam)
    first *= one
    second *= two
    eps_p += lam * first
    gamma_p += 3.0 * lam * second
    # d(xi) = X W d(strain) - u (u . W d(strain)) / (n . u) with X = diag(a one, b two / 3),
    # W = diag(E / a, 3 G / b), n = (xi_1, 3 xi_2), u = X n; and
    # d(stress) = (D - D W) d(strain) + W d(xi) with D = diag(E, G)
    w1, w2 = E / a, 3.0 * G / b
    u1, u2 = a * one * first, b * two * second
    across = first * u1 + 3.0 * second * u2
    k11 = E * (1.0 - w1) + w1 * w1 * (a * one - u1 * u1 / across)
    k12 = -w1 * w2 * u1 * u2 / across
    k22 = G * (1.0 - w2) + w2 * w2 * (b * two / 3.0 - u2 * u2 / across)
    return E * (eps - eps_p), G * (gamma - gamma_p), k11, k12, k22, eps_p, gamma_p
