"""Kernels of the four-degree-of-freedom column (Heng 2017, section 5.1 and chapter 3).

Degrees of freedom q = (v1, u1, beta1, u2): lateral and axial displacement of the hit point,
rotation of the rigid surface between its two hinges, axial displacement of the head. Two rigid
bars, each an assembly of an end hinge and a mid hinge that share the axial force. Both bars are
the same mirrored element of (v, x, b): bar a has x = L_a + u1, b = beta1; bar b has
x = L_b + u2 - u1, b = -beta1.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from workbench.hinges._kernels import project

V, U1, BETA, U2 = 0, 1, 2, 3
OK, NO_CONVERGENCE, COLLAPSE = 0, 1, 2


@njit(cache=True, error_model="numpy")
def bar(v, x, b, length, stiffness, bounds, exponents, small, plastic, work, stress, force, K):
    """Forces and tangent of one bar over (v, x, b), from committed plastic deformations.

    `stiffness` (3,): k_N, k_end, k_mid; `bounds` (3, 2): N and two M bounds for both signs;
    `exponents` (2,): alpha, beta; `small` selects small-rotation kinematics; `work` (5, 3) is
    scratch. Writes `stress` (N, M_end, M_mid), `force` (3,) and `K` (3, 3).
    """
    trial, D, B = work[0], work[1:4], work[4]
    if small:
        chord, angle = length, v / length
        stretch = (x - length) + 0.5 * v * v / length
        s, c, gv, gx = v / length, 1.0, 1.0 / length, 0.0
    else:
        chord, angle = np.sqrt(x * x + v * v), np.arctan2(v, x)
        stretch = ((x - length) * (x + length) + v * v) / (chord + length)
        s, c = v / chord, x / chord
        gv, gx = x / chord**2, -v / chord**2
    trial[0] = stiffness[0] * (stretch - plastic[0])
    trial[1] = stiffness[1] * (angle - plastic[1])
    trial[2] = stiffness[2] * (b - angle - plastic[2])
    project(
        stiffness[0], stiffness[1:], bounds[0], bounds[1:], exponents[0], exponents[1],
        trial, stress, D,
    )  # fmt: skip
    N, dM = stress[0], stress[1] - stress[2]
    force[0] = N * s + dM * gv
    force[1] = N * c + dM * gx
    force[2] = stress[2]
    # K = B' D B + K_g with the rows of B over (v, x, b): (s, c, 0), (gv, gx, 0), (-gv, -gx, 1)
    for j in range(3):
        B[0] = D[j, 0] * s + (D[j, 1] - D[j, 2]) * gv
        B[1] = D[j, 0] * c + (D[j, 1] - D[j, 2]) * gx
        B[2] = D[j, 2]
        D[j, 0], D[j, 1], D[j, 2] = B[0], B[1], B[2]
    for k in range(3):
        K[0, k] = s * D[0, k] + gv * (D[1, k] - D[2, k])
        K[1, k] = c * D[0, k] + gx * (D[1, k] - D[2, k])
        K[2, k] = D[2, k]
    if small:
        K[0, 0] += N / length
    else:
        l4 = chord**4
        K[0, 0] += N * c * c / chord - dM * 2.0 * x * v / l4
        kvx = -N * s * c / chord + dM * (v * v - x * x) / l4
        K[0, 1] += kvx
        K[1, 0] += kvx
        K[1, 1] += N * s * s / chord + dM * 2.0 * x * v / l4


@njit(cache=True, error_model="numpy")
def internal(q, lengths, stiffness, bounds, exponents, small, head, plastic, work, stress, F, K):
    """Internal forces `F` (4,) and tangent `K` (4, 4) of the column at `q` (4,).

    `head` (3,): axial load P (compression positive), spring stiffness k_s, u2 at which the
    spring is unstressed; the dead load and spring act on u2. `plastic`, `stress`: (2, 3).
    """
    fa, fb, Ka, Kb = work[5], work[6], work[7:10], work[10:13]
    bar(
        q[V], lengths[0] + q[U1], q[BETA], lengths[0], stiffness[0], bounds, exponents, small,
        plastic[0], work, stress[0], fa, Ka,
    )  # fmt: skip
    bar(
        q[V], lengths[1] + q[U2] - q[U1], -q[BETA], lengths[1], stiffness[1], bounds, exponents,
        small, plastic[1], work, stress[1], fb, Kb,
    )  # fmt: skip
    F[V] = fa[0] + fb[0]
    F[U1] = fa[1] - fb[1]
    F[BETA] = fa[2] - fb[2]
    F[U2] = fb[1] + head[1] * (q[U2] - head[2]) + head[0]
    K[V, V] = Ka[0, 0] + Kb[0, 0]
    K[V, U1] = K[U1, V] = Ka[0, 1] - Kb[0, 1]
    K[V, BETA] = K[BETA, V] = Ka[0, 2] - Kb[0, 2]
    K[V, U2] = K[U2, V] = Kb[0, 1]
    K[U1, U1] = Ka[1, 1] + Kb[1, 1]
    K[U1, BETA] = K[BETA, U1] = Ka[1, 2] + Kb[1, 2]
    K[U1, U2] = K[U2, U1] = -Kb[1, 1]
    K[BETA, BETA] = Ka[2, 2] + Kb[2, 2]
    K[BETA, U2] = K[U2, BETA] = -Kb[1, 2]
    K[U2, U2] = Kb[1, 1] + head[1]


@njit(cache=True, error_model="numpy")
def balance_rotation(
    q, lengths, stiffness, bounds, exponents, small, head, plastic, work, stress, F, K
):
    """Rotate the rigid surface until its two hinges balance: F_beta(q) = 0, q[BETA] changed.

    F_beta does not decrease with beta1, and its root lies between the rotations at which the
    trial moment of hinge 2 or of hinge 3 vanishes: safeguarded Newton in that bracket.
    """
    if small:
        psi_a, psi_b = q[V] / lengths[0], q[V] / lengths[1]
    else:
        psi_a = np.arctan2(q[V], lengths[0] + q[U1])
        psi_b = np.arctan2(q[V], lengths[1] + q[U2] - q[U1])
    one, two = psi_a + plastic[0, 2], -psi_b - plastic[1, 2]
    low, high = min(one, two), max(one, two)
    tolerance = 1e-12 * max(bounds[2, 0], bounds[2, 1])
    q[BETA] = min(max(q[BETA], low), high)
    for _ in range(100):
        internal(q, lengths, stiffness, bounds, exponents, small, head, plastic, work, stress, F, K)
        if abs(F[BETA]) <= tolerance or high - low <= 4e-16 * max(1.0, abs(q[BETA])):
            return
        if F[BETA] > 0.0:
            high = q[BETA]
        else:
            low = q[BETA]
        slope = K[BETA, BETA]
        new = q[BETA] - F[BETA] / slope if slope > 0.0 else low - 1.0
        if not (low < new < high):
            new = 0.5 * (low + high)
        if new == q[BETA]:
            return
        q[BETA] = new


@njit(cache=True, error_model="numpy")
def solve_small(A, b, size):
    """Solve A x = b in place by Gaussian elimination with row pivoting; False if singular."""
    for i in range(size):
        pivot = i
        for r in range(i + 1, size):
            if abs(A[r, i]) > abs(A[pivot, i]):
                pivot = r
        if A[pivot, i] == 0.0 or not np.isfinite(A[pivot, i]):
            return False
        if pivot != i:
            for k in range(size):
                A[i, k], A[pivot, k] = A[pivot, k], A[i, k]
            b[i], b[pivot] = b[pivot], b[i]
        for r in range(i + 1, size):
            factor = A[r, i] / A[i, i]
            if factor != 0.0:
                for k in range(i, size):
                    A[r, k] -= factor * A[i, k]
                b[r] -= factor * b[i]
    for i in range(size - 1, -1, -1):
        for k in range(i + 1, size):
            b[i] -= A[i, k] * b[k]
        b[i] /= A[i, i]
    return True


@njit(cache=True, error_model="numpy")
def axial_equilibrium(
    q, free_u1, free_u2, tolerance,
    lengths, stiffness, bounds, exponents, small, head, plastic, work, stress, F, K,
):  # fmt: skip
    """Solve F_u1 = F_u2 = F_beta = 0 at fixed v1 (and fixed u1 or u2 where not free).

    Newton on the axial unknowns with the rotation balanced inside every evaluation, backtracking
    on the larger residual over N_p, and a growing diagonal shift where backtracking fails.
    Returns the residual over N_p that is left; `q` holds the solution.
    """
    Np, kN, kt = bounds[0, 0], stiffness[0, 0], max(stiffness[0, 2], stiffness[1, 2])
    A, step, old = work[13:15], work[15], work[16]
    balance_rotation(
        q, lengths, stiffness, bounds, exponents, small, head, plastic, work, stress, F, K
    )
    norm = max(abs(F[U1]) * free_u1, abs(F[U2]) * free_u2) / Np
    shift = 0.0
    for _ in range(60):
        if norm <= tolerance:
            return norm
        r1, r2 = F[U1], F[U2]
        k11, k12, k22 = K[U1, U1], K[U1, U2], K[U2, U2]
        if K[BETA, BETA] > 1e-13 * kt:
            k11 -= K[U1, BETA] ** 2 / K[BETA, BETA]
            k12 -= K[U1, BETA] * K[U2, BETA] / K[BETA, BETA]
            k22 -= K[U2, BETA] ** 2 / K[BETA, BETA]
        for i in range(3):
            old[i] = q[i + 1]
        better = False
        while not better and shift < 1e3:
            A[0, 0], A[0, 1], A[1, 0], A[1, 1] = k11 + shift * kN, k12, k12, k22 + shift * kN
            step[0], step[1] = -r1, -r2
            if not free_u1:
                A[0, 0], A[0, 1], A[1, 0], step[0] = 1.0, 0.0, 0.0, 0.0
            if not free_u2:
                A[1, 1], A[0, 1], A[1, 0], step[1] = 1.0, 0.0, 0.0, 0.0
            if solve_small(A, step, 2):
                factor = 1.0
                for _half in range(12):
                    q[U1], q[BETA] = old[0] + factor * step[0], old[1]
                    q[U2] = old[2] + factor * step[1]
                    balance_rotation(
                        q, lengths, stiffness, bounds, exponents, small, head, plastic, work,
                        stress, F, K,
                    )  # fmt: skip
                    new = max(abs(F[U1]) * free_u1, abs(F[U2]) * free_u2) / Np
                    if new < norm * (1.0 - 1e-4 * factor):
                        norm, better = new, True
                        break
                    factor *= 0.5
            if better:
                shift = 0.0 if shift < 1e-8 else shift / 30.0
            else:
                shift = 1e-8 if shift == 0.0 else shift * 30.0
        if not better:
            break
    return norm


@njit(cache=True, error_model="numpy")
def commit(q, lengths, stiffness, small, stress, plastic, increments):
    """Plastic deformations from the converged forces: total less elastic; also the increments."""
    for i in range(2):
        x = lengths[0] + q[U1] if i == 0 else lengths[1] + q[U2] - q[U1]
        b = q[BETA] if i == 0 else -q[BETA]
        length = lengths[i]
        if small:
            angle, stretch = q[V] / length, (x - length) + 0.5 * q[V] ** 2 / length
        else:
            angle = np.arctan2(q[V], x)
            chord = np.sqrt(x * x + q[V] ** 2)
            stretch = ((x - length) * (x + length) + q[V] ** 2) / (chord + length)
        for j in range(3):
            total = stretch if j == 0 else (angle if j == 1 else b - angle)
            new = total  # a pin: all of its rotation is free
            if stiffness[i, j] > 0.0:
                new -= stress[i, j] / stiffness[i, j]
            increments[i, j] = new - plastic[i, j]
            plastic[i, j] = new


@njit(cache=True, error_model="numpy")
def elastic_energy(stress, stiffness, head, u2):
    """Energy stored in the hinges and in the restraint spring, in J."""
    energy = 0.5 * head[1] * (u2 - head[2]) ** 2
    for i in range(2):
        for j in range(3):
            if stiffness[i, j] > 0.0:
                energy += 0.5 * stress[i, j] ** 2 / stiffness[i, j]
    return energy


@njit(cache=True, error_model="numpy")
def pushover(
    path, lengths, stiffness, bounds, exponents, small, free_u2, head, q, plastic, records
):
    """Static path under imposed v1 = path[i]; returns (status, last step, residual).

    `records` (steps, 12): v1, u1, beta1, u2, F, stresses (6), dissipation. Increments that do
    not converge are halved down to 1/1024.
    """
    work, stress = np.zeros((18, 3)), np.zeros((2, 3))
    F, K, increments = np.zeros(4), np.zeros((4, 4)), np.zeros((2, 3))
    old_stress = np.zeros((2, 3))
    dissipated, residual = 0.0, 0.0
    for i in range(path.size):
        start = q[V]
        at, stride = 0.0, 1.0
        while at < 1.0:
            before = q.copy()
            stride = min(stride, 1.0 - at)
            q[V] = start + (at + stride) * (path[i] - start)
            residual = axial_equilibrium(
                q, True, free_u2, 1e-10, lengths, stiffness, bounds, exponents, small, head,
                plastic, work, stress, F, K,
            )  # fmt: skip
            if residual <= 1e-10:
                commit(q, lengths, stiffness, small, stress, plastic, increments)
                for a in range(2):
                    for j in range(3):
                        mean = 0.5 * (stress[a, j] + old_stress[a, j])
                        dissipated += mean * increments[a, j]
                        old_stress[a, j] = stress[a, j]
                at += stride
                stride *= 2.0
            else:
                q[:] = before
                stride *= 0.5
                if stride < 1.0 / 1024.0:
                    return NO_CONVERGENCE, i, residual
        records[i, :4] = q
        records[i, 4] = F[V]
        records[i, 5:8] = stress[0]
        records[i, 8:11] = stress[1]
        records[i, 11] = dissipated
    return OK, path.size - 1, residual
