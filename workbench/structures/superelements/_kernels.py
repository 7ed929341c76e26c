"""Assembly and energies of superelements.

Symbols: local deformations (u, theta_1, theta_4) against the chord, local forces (N, M_1, M_4);
Q, what hinges and bar carry; eta, the share of the elastic stiffness that always acts beside
them and keeps the tangent regular; alpha, rotation of the chord, the only rotation of a rigid
bar that has inertia. Source: Heng 2017, papers III and IV; midpoint form of Hamilton's
principle for the rotary inertia after Simo and Tarnow 1992.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from workbench.hinges._pair_kernels import Pair, project_pair
from workbench.structures.corotation._kernels import (
    add_force,
    add_tangent,
    chord_rotation,
    end_gradients,
    initial_gradients,
    step_gradients,
)

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Indices = NDArray[np.int64]


@njit(cache=True, error_model="numpy")
def _add_chord_block(
    band: Vector, positions: Indices, xx: float, xy: float, yx: float, yy: float
) -> None:
    """Add the derivative of a force pair on the chord by the chord to the translations."""
    for i in range(2):
        for j in range(2):
            sign = 1.0 if i == j else -1.0
            first = 18 * i + 3 * j
            band[positions[first]] += sign * xx
            band[positions[first + 1]] += sign * xy
            band[positions[first + 6]] += sign * yx
            band[positions[first + 7]] += sign * yy


@njit(cache=True, error_model="numpy")
def hinge_bar_law(
    deformation: Vector,
    flexibility: Vector,
    stiffness: Vector,
    bounds: Matrix,
    exponents: Matrix,
    pinned: NDArray[np.bool_],
    eta: float,
    plastic_old: Vector,
    plastic_new: Vector,
    carried: Vector,
    local: Vector,
    k: Matrix,
    trial: Vector,
    flow: Vector,
) -> None:
    """Local forces and tangent of one superelement for given local deformations (3,).

    Arguments: `flexibility` (4,) as in `project_pair` and its inverse `stiffness` (4,), zero for
    pins; bounds, exponents and pins of the hinges; share `eta` of elastic stiffness; committed
    `plastic_old` (4,): u, theta of hinge 1, then of hinge 4. Writes `plastic_new`, the forces
    `carried` (3,) by the hinges, `local` (3,) forces and their tangent `k` (3, 3); scratch
    `trial` (3,), `flow` (4,).
    """
    trial[0] = deformation[0] - plastic_old[0] - plastic_old[2]
    trial[1] = deformation[1] - plastic_old[1]
    trial[2] = deformation[2] - plastic_old[3]
    project_pair(Pair(flexibility, bounds, exponents, pinned), trial, carried, k, flow)
    for i in range(4):
        plastic_new[i] = plastic_old[i] + flow[i]
    rest = 1.0 - eta
    for i in range(3):
        local[i] = rest * carried[i]
        for j in range(3):
            k[i, j] *= rest
    kn, k11, k14, k44 = stiffness
    local[0] += eta * kn * deformation[0]
    local[1] += eta * (k11 * deformation[1] + k14 * deformation[2])
    local[2] += eta * (k14 * deformation[1] + k44 * deformation[2])
    k[0, 0] += eta * kn
    k[1, 1] += eta * k11
    k[1, 2] += eta * k14
    k[2, 1] += eta * k14
    k[2, 2] += eta * k44


@njit(cache=True, error_model="numpy")
def assemble(
    force: Vector,
    band: Vector,
    q0: Vector,
    q1: Vector,
    weight: float,
    step: bool,
    duration: float,
    eta: float,
    first_order: bool,
    dofs: Indices,
    positions: Indices,
    chords: Matrix,
    lengths: Vector,
    flexibility: Matrix,
    stiffness: Matrix,
    bounds: NDArray[np.float64],
    exponents: NDArray[np.float64],
    pinned: NDArray[np.bool_],
    rotary: Vector,
    plastic_old: Matrix,
    local_old: Matrix,
    rate_old: Vector,
    plastic_new: Matrix,
    carried_new: Matrix,
    local_new: Matrix,
    deformation_new: Matrix,
    rate_new: Vector,
) -> None:
    """Add forces and tangents of all superelements between the displacements `q0` and `q1`.

    With `step` the forces are the energy-exact ones of a time step of `duration` (s) and stresses
    are weighted; otherwise they are those of equilibrium at `q1`, and chords are at rest. With
    `first_order` equilibrium and deformations are those of the undeformed structure.
    `rotary` (elements,) is the inertia of the turning chord in kg m2. State arrays ending in
    _old are committed, those ending in _new are written.
    """
    k = np.empty((3, 3))
    work = np.empty((10, 4))
    trial = np.empty(3)
    flow = np.empty(4)
    moving = step and math.isfinite(duration)
    for e in range(dofs.shape[0]):
        i1, i2, i3, i4, i5, i6 = dofs[e]
        Dx, Dy = chords[e, 0], chords[e, 1]
        L = lengths[e]
        ux, uy = q1[i4] - q1[i1], q1[i5] - q1[i2]
        deformation = deformation_new[e]
        if first_order:
            d1x, d1y, l1 = Dx, Dy, L
            alpha1 = (Dx * uy - Dy * ux) / (L * L)
            deformation[0] = (ux * Dx + uy * Dy) / L
        else:
            d1x, d1y = Dx + ux, Dy + uy
            l1 = math.sqrt(d1x * d1x + d1y * d1y)
            alpha1 = chord_rotation(Dx, Dy, d1x, d1y, 0.5 * (q1[i3] + q1[i6]))
            # l - L without cancellation
            deformation[0] = (ux * (d1x + Dx) + uy * (d1y + Dy)) / (l1 + L)
        deformation[1] = q1[i3] - alpha1
        deformation[2] = q1[i6] - alpha1
        local = local_new[e]
        hinge_bar_law(
            deformation,
            flexibility[e],
            stiffness[e],
            bounds[e],
            exponents[e],
            pinned[e],
            eta,
            plastic_old[e],
            plastic_new[e],
            carried_new[e],
            local,
            k,
            trial,
            flow,
        )
        u0x, u0y = q0[i4] - q0[i1], q0[i5] - q0[i2]
        alpha0 = alpha1
        if first_order:
            alpha0 = (Dx * u0y - Dy * u0x) / (L * L)
            gradients = initial_gradients(Dx, Dy, L)
        elif step:
            d0x, d0y = Dx + u0x, Dy + u0y
            l0 = math.sqrt(d0x * d0x + d0y * d0y)
            alpha0 = chord_rotation(Dx, Dy, d0x, d0y, 0.5 * (q0[i3] + q0[i6]))
            gradients = step_gradients(d0x, d0y, l0, d1x, d1y, l1, alpha1 - alpha0)
        else:
            gradients = end_gradients(d1x, d1y, l1)
        if step:
            rest = 1.0 - weight
            N = rest * local_old[e, 0] + weight * local[0]
            M1 = rest * local_old[e, 1] + weight * local[1]
            M4 = rest * local_old[e, 2] + weight * local[2]
        else:
            N, M1, M4 = local[0], local[1], local[2]
        add_force(force, dofs[e], N, M1, M4, gradients)
        e1x, e1y = d1x / l1, d1y / l1
        share = weight if step else 1.0
        add_tangent(band, positions[e], k, N, M1, M4, share, gradients, e1x, e1y, l1, work)
        rate_new[e] = 0.0
        if moving and rotary[e] > 0.0:
            rate_new[e] = 2.0 * (alpha1 - alpha0) / duration - rate_old[e]
            couple = rotary[e] * (rate_new[e] - rate_old[e]) / duration
            gx, gy = gradients[2], gradients[3]
            force[i1] -= couple * gx
            force[i2] -= couple * gy
            force[i4] += couple * gx
            force[i5] += couple * gy
            turn = 2.0 * rotary[e] / (duration * duration * l1)  # d alpha / d d_1 = n_1 / l_1
            _add_chord_block(
                band,
                positions[e],
                couple * gradients[8] - turn * gx * e1y,
                couple * gradients[9] + turn * gx * e1x,
                couple * gradients[10] - turn * gy * e1y,
                couple * gradients[11] + turn * gy * e1x,
            )


@njit(cache=True, error_model="numpy")
def _quadratic(matrix: Vector, x: Vector) -> float:
    """Quadratic form of x (3,) with [a, 0, 0; 0, b, c; 0, c, d], stored as (a, b, c, d)."""
    axial: float = matrix[0] * x[0] * x[0]
    bending: float = matrix[1] * x[1] * x[1] + matrix[3] * x[2] * x[2]
    coupling: float = 2.0 * matrix[2] * x[1] * x[2]
    return axial + bending + coupling


@njit(cache=True, error_model="numpy")
def account(
    weight: float,
    eta: float,
    flexibility: Matrix,
    stiffness: Matrix,
    plastic_old: Matrix,
    carried_old: Matrix,
    deformation_old: Matrix,
    plastic_new: Matrix,
    carried_new: Matrix,
    deformation_new: Matrix,
) -> tuple[float, float, float, float]:
    """Energies of a step from the committed to the trial state of a group, in J.

    Result: stored energy at the end; plastic dissipation of the step with forces weighted as in
    the step; algorithmic dissipation; and the plastic work of forces that stay at yield.
    """
    stored = 0.0
    plastic = 0.0
    algorithmic = 0.0
    ideal = 0.0
    rest = 1.0 - eta
    change = np.empty(3)
    moved = np.empty(3)
    for e in range(flexibility.shape[0]):
        stored += 0.5 * rest * _quadratic(flexibility[e], carried_new[e])
        stored += 0.5 * eta * _quadratic(stiffness[e], deformation_new[e])
        for i in range(3):
            change[i] = carried_new[e, i] - carried_old[e, i]
            moved[i] = deformation_new[e, i] - deformation_old[e, i]
        algorithmic += (weight - 0.5) * (
            rest * _quadratic(flexibility[e], change) + eta * _quadratic(stiffness[e], moved)
        )
        for h in range(4):
            i = 0 if h % 2 == 0 else 1 + h // 2
            flow = plastic_new[e, h] - plastic_old[e, h]
            end = rest * carried_new[e, i]
            plastic += (weight * end + (1.0 - weight) * rest * carried_old[e, i]) * flow
            ideal += end * flow
    return stored, plastic, algorithmic, ideal
