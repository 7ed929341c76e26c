"""The Bernoulli beam element with fiber sections: local law, group assembly, energy ledger.

Symbols: eps = u/L - y (b1 theta_1 + b2 theta_2) with b1 = (6 xi - 4)/L and b2 = (6 xi - 2)/L at
the point xi along the element; N = sum(sigma A), M = -sum(sigma y A); fibers are elastic-plastic
with a very small kinematic modulus H that only regularises. Source: Heng 2017, chapter 5; the
return mapping is the one-dimensional case of Simo and Hughes 1998, box 1.5.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from workbench.structures.corotation._kernels import (
    add_force,
    add_tangent,
    chord_rotation,
    end_gradients,
    step_gradients,
)

Vector = NDArray[np.float64]
Indices = NDArray[np.int64]


@njit(cache=True, error_model="numpy")
def section_response(
    strain: float,
    curvature: float,
    y: Vector,
    area: Vector,
    E: float,
    fy: float,
    H: float,
    plastic_old: Vector,
    plastic_new: Vector,
) -> tuple[float, float, float, float, float]:
    """Return mapping of every fiber of a section, always from the committed plastic strains.

    Arguments: `strain` at the axis, `curvature` (1/m); fiber ordinates `y` (f,) in m and `area`
    (f,) in m2; modulus, yield stress and hardening modulus in Pa; `plastic_old` (f,) committed.
    Writes `plastic_new` (f,). Result: N, M, and the stiffnesses C0, C1, C2 of section forces.
    """
    n = 0.0
    m = 0.0
    c0 = 0.0
    c1 = 0.0
    c2 = 0.0
    inverse = 1.0 / (E + H)
    soft = E * H * inverse
    for f in range(y.shape[0]):
        eps = strain - y[f] * curvature
        old = plastic_old[f]
        trial = E * (eps - old) - H * old
        excess = abs(trial) - fy
        if excess > 0.0:
            old += math.copysign(excess * inverse, trial)
            modulus = soft
        else:
            modulus = E
        plastic_new[f] = old
        stress = E * (eps - old) * area[f]
        n += stress
        m -= stress * y[f]
        ka = modulus * area[f]
        c0 += ka
        c1 -= ka * y[f]
        c2 += ka * y[f] * y[f]
    return n, m, c0, c1, c2


@njit(cache=True, error_model="numpy")
def element_law(
    deformation: Vector,
    length: float,
    xi: Vector,
    weights: Vector,
    y: Vector,
    area: Vector,
    steel: Vector,
    plastic_old: NDArray[np.float64],
    plastic_new: NDArray[np.float64],
    local: Vector,
    k: NDArray[np.float64],
) -> None:
    """Local forces (N, M1, M2) and their 3 x 3 tangent for given local deformations.

    Arguments: `deformation` (4,), elongation (m), rotations, and the strain difference (see
    `balance`); `length` in m; points `xi` and `weights` along the
    element; fibers `y`, `area`; `steel` (E, fy, H) in Pa; committed plastic strains (points, f).
    Writes `plastic_new`, `local` (3,) and `k` (3, 3).
    """
    E, fy, H = steel[0], steel[1], steel[2]
    mean = deformation[0] / length
    b11 = (6.0 * xi[0] - 4.0) / length
    b12 = (6.0 * xi[0] - 2.0) / length
    b21 = (6.0 * xi[1] - 4.0) / length
    b22 = (6.0 * xi[1] - 2.0) / length
    kappa1 = b11 * deformation[1] + b12 * deformation[2]
    kappa2 = b21 * deformation[1] + b22 * deformation[2]
    w1, w2 = weights[0], weights[1]
    squash = fy * np.sum(area)
    a = deformation[3]
    low, high = -np.inf, np.inf
    for it in range(60):
        n1, m1, c01, c11, c21 = section_response(
            mean + w2 * a, kappa1, y, area, E, fy, H, plastic_old[0], plastic_new[0]
        )
        n2, m2, c02, c12, c22 = section_response(
            mean - w1 * a, kappa2, y, area, E, fy, H, plastic_old[1], plastic_new[1]
        )
        r = n1 - n2
        slope = w2 * c01 + w1 * c02
        if abs(r) <= 1e-12 * squash:
            break
        if r > 0.0:
            high = a
        else:
            low = a
        new = a - r / slope
        if not (low < new < high):
            if np.isinf(low) or np.isinf(high):
                new = a - r / slope
            else:
                new = 0.5 * (low + high)
        if new == a:
            break
        a = new
    deformation[3] = a
    local[0] = w1 * n1 + w2 * n2
    local[1] = length * (w1 * b11 * m1 + w2 * b21 * m2)
    local[2] = length * (w1 * b12 * m1 + w2 * b22 * m2)
    x0 = w1 * w2 * (c01 - c02)
    x1 = w1 * w2 * length * (b11 * c11 - b21 * c12)
    x2 = w1 * w2 * length * (b12 * c11 - b22 * c12)
    s = 1.0 / (w1 * w2 * length * slope)
    k[0, 0] = (w1 * c01 + w2 * c02) / length - x0 * x0 * s
    k[0, 1] = w1 * b11 * c11 + w2 * b21 * c12 - x0 * x1 * s
    k[0, 2] = w1 * b12 * c11 + w2 * b22 * c12 - x0 * x2 * s
    k[1, 1] = length * (w1 * b11 * b11 * c21 + w2 * b21 * b21 * c22) - x1 * x1 * s
    k[1, 2] = length * (w1 * b11 * b12 * c21 + w2 * b21 * b22 * c22) - x1 * x2 * s
    k[2, 2] = length * (w1 * b12 * b12 * c21 + w2 * b22 * b22 * c22) - x2 * x2 * s
    k[1, 0] = k[0, 1]
    k[2, 0] = k[0, 2]
    k[2, 1] = k[1, 2]


@njit(cache=True, error_model="numpy")
def assemble(
    force: Vector,
    band: Vector,
    q0: Vector,
    q1: Vector,
    weight: float,
    step: bool,
    dofs: NDArray[np.int64],
    positions: NDArray[np.int64],
    chords: NDArray[np.float64],
    lengths: Vector,
    section: Indices,
    ys: NDArray[np.float64],
    areas: NDArray[np.float64],
    steels: NDArray[np.float64],
    xi: NDArray[np.float64],
    weights: NDArray[np.float64],
    plastic_old: NDArray[np.float64],
    local_old: NDArray[np.float64],
    plastic_new: NDArray[np.float64],
    local_new: NDArray[np.float64],
    deformation_new: NDArray[np.float64],
) -> None:
    """Add forces and tangent of all elements of a group.

    Arguments: `force` (dofs,) and flat `band` to add to; displacements `q0` committed and `q1`
    at the end of the step; `weight` of the end state in the forces of the step; `step`, True for
    the energy-exact forces of a time step, False for equilibrium at the end; then the group's
    arrays, and its committed (`_old`) and trial (`_new`) states. Writes the trial states.
    """
    k = np.empty((3, 3))
    work = np.empty((10, 4))
    for e in range(dofs.shape[0]):
        i1, i2, i3, i4, i5, i6 = dofs[e]
        Dx, Dy = chords[e, 0], chords[e, 1]
        L = lengths[e]
        d1x, d1y = Dx + q1[i4] - q1[i1], Dy + q1[i5] - q1[i2]
        l1 = math.sqrt(d1x * d1x + d1y * d1y)
        alpha1 = chord_rotation(Dx, Dy, d1x, d1y, 0.5 * (q1[i3] + q1[i6]))
        deformation = deformation_new[e]
        # l - L without cancellation: elements of centimetres carry strains of 1e-6
        ux, uy = d1x - Dx, d1y - Dy
        deformation[0] = (ux * (d1x + Dx) + uy * (d1y + Dy)) / (l1 + L)
        deformation[1] = q1[i3] - alpha1
        deformation[2] = q1[i6] - alpha1
        s = section[e]
        local = local_new[e]
        element_law(
            deformation,
            L,
            xi[e],
            weights[e],
            ys[s],
            areas[s],
            steels[s],
            plastic_old[e],
            plastic_new[e],
            local,
            k,
        )
        if step:
            d0x, d0y = Dx + q0[i4] - q0[i1], Dy + q0[i5] - q0[i2]
            l0 = math.sqrt(d0x * d0x + d0y * d0y)
            alpha0 = chord_rotation(Dx, Dy, d0x, d0y, 0.5 * (q0[i3] + q0[i6]))
            gradients = step_gradients(d0x, d0y, l0, d1x, d1y, l1, alpha1 - alpha0)
            rest = 1.0 - weight
            N = rest * local_old[e, 0] + weight * local[0]
            M1 = rest * local_old[e, 1] + weight * local[1]
            M2 = rest * local_old[e, 2] + weight * local[2]
        else:
            gradients = end_gradients(d1x, d1y, l1)
            N, M1, M2 = local[0], local[1], local[2]
        add_force(force, dofs[e], N, M1, M2, gradients)
        add_tangent(
            band,
            positions[e],
            k,
            N,
            M1,
            M2,
            weight if step else 1.0,
            gradients,
            d1x / l1,
            d1y / l1,
            l1,
            work,
        )


@njit(cache=True, error_model="numpy")
def account(
    weight: float,
    lengths: Vector,
    section: Indices,
    ys: NDArray[np.float64],
    areas: NDArray[np.float64],
    steels: NDArray[np.float64],
    xi: NDArray[np.float64],
    weights: NDArray[np.float64],
    plastic_old: NDArray[np.float64],
    deformation_old: NDArray[np.float64],
    plastic_new: NDArray[np.float64],
    deformation_new: NDArray[np.float64],
) -> tuple[float, float, float, float]:
    """Energies of a step from the committed to the trial state of a group, in J.

    Result: stored energy at the end; plastic dissipation of the step with stresses weighted as in
    its forces; algorithmic dissipation; and the plastic work f_y |d eps_p| of ideal flow, against
    which the plastic dissipation is judged.
    """
    stored = 0.0
    plastic = 0.0
    algorithmic = 0.0
    ideal = 0.0
    for e in range(lengths.shape[0]):
        s = section[e]
        E, fy, H = steels[s, 0], steels[s, 1], steels[s, 2]
        L = lengths[e]
        for g in range(xi.shape[1]):
            b1 = (6.0 * xi[e, g] - 4.0) / L
            b2 = (6.0 * xi[e, g] - 2.0) / L
            c = weights[e, 1] if g == 0 else -weights[e, 0]
            strain0 = deformation_old[e, 0] / L + c * deformation_old[e, 3]
            strain1 = deformation_new[e, 0] / L + c * deformation_new[e, 3]
            kappa0 = b1 * deformation_old[e, 1] + b2 * deformation_old[e, 2]
            kappa1 = b1 * deformation_new[e, 1] + b2 * deformation_new[e, 2]
            wl = weights[e, g] * L
            for f in range(ys.shape[1]):
                p0 = plastic_old[e, g, f]
                p1 = plastic_new[e, g, f]
                y = ys[s, f]
                elastic0 = strain0 - y * kappa0 - p0
                elastic1 = strain1 - y * kappa1 - p1
                volume = wl * areas[s, f]
                flow = p1 - p0
                stored += 0.5 * volume * (E * elastic1 * elastic1 + H * p1 * p1)
                driving = (1.0 - weight) * (E * elastic0 - H * p0) + weight * (
                    E * elastic1 - H * p1
                )
                plastic += volume * driving * flow
                change = elastic1 - elastic0
                algorithmic += (weight - 0.5) * volume * (E * change * change + H * flow * flow)
                ideal += volume * fy * abs(flow)
    return stored, plastic, algorithmic, ideal


@njit(cache=True, error_model="numpy")
def plastic_rotations(
    lengths: Vector,
    section: Indices,
    ys: NDArray[np.float64],
    areas: NDArray[np.float64],
    weights: NDArray[np.float64],
    plastic: NDArray[np.float64],
    result: Vector,
) -> None:
    """Plastic curvature of each element integrated along it (rad), into `result` (elements,).

    The plastic curvature of a section is -sum(eps_p y A) / sum(y^2 A): what bends the section
    when its stresses are removed.
    """
    for e in range(lengths.shape[0]):
        s = section[e]
        second = 0.0
        for f in range(ys.shape[1]):
            second += ys[s, f] * ys[s, f] * areas[s, f]
        total = 0.0
        for g in range(weights.shape[1]):
            moment = 0.0
            for f in range(ys.shape[1]):
                moment -= plastic[e, g, f] * ys[s, f] * areas[s, f]
            total += weights[e, g] * moment
        result[e] = total * lengths[e] / second
