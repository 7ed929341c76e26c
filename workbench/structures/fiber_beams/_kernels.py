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

BALANCE = 1e-13  # of squash load and of 6 EI / L: inner unknowns are solved to round-off
INNER_ITERATIONS = 100


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
def point_sums(
    state: Vector,
    length: float,
    xi: Vector,
    weights: Vector,
    spread: Vector,
    y: Vector,
    area: Vector,
    steel: Vector,
    plastic_old: NDArray[np.float64],
    plastic_new: NDArray[np.float64],
    local: Vector,
    k: NDArray[np.float64],
    coupling: Vector,
) -> float:
    """Sums over the points of an element at a given state.

    Arguments: `state` (5,): elongation (m), bending rotations of both ends (rad), shear strain
    (not used here), and the amplitude a of the strain that `spread` (points,) adds along the
    axis; `length` in m; points `xi` with `weights`; fibers `y`, `area`; `steel` (E, fy, H) in Pa;
    committed plastic strains (points, f). Writes `plastic_new`, `local` (3,) N, M1, M2, its
    tangent `k` (3, 3), and `coupling` (4,): derivatives of the force R_a = L sum(w spread N)
    conjugate to a with respect to the elongation, both rotations and a. Result: R_a.
    """
    E, fy, H = steel[0], steel[1], steel[2]
    local[:] = 0.0
    k[:] = 0.0
    coupling[:] = 0.0
    difference = 0.0
    for g in range(xi.shape[0]):
        b1 = (6.0 * xi[g] - 4.0) / length
        b2 = (6.0 * xi[g] - 2.0) / length
        n, m, c0, c1, c2 = section_response(
            state[0] / length + spread[g] * state[4],
            b1 * state[1] + b2 * state[2],
            y,
            area,
            E,
            fy,
            H,
            plastic_old[g],
            plastic_new[g],
        )
        w = weights[g]
        wl = w * length
        local[0] += w * n
        local[1] += wl * b1 * m
        local[2] += wl * b2 * m
        k[0, 0] += w * c0 / length
        k[0, 1] += w * b1 * c1
        k[0, 2] += w * b2 * c1
        k[1, 1] += wl * b1 * b1 * c2
        k[1, 2] += wl * b1 * b2 * c2
        k[2, 2] += wl * b2 * b2 * c2
        difference += wl * spread[g] * n
        coupling[0] += w * spread[g] * c0
        coupling[1] += wl * b1 * spread[g] * c1
        coupling[2] += wl * b2 * spread[g] * c1
        coupling[3] += wl * spread[g] * spread[g] * c0
    k[1, 0] = k[0, 1]
    k[2, 0] = k[0, 2]
    k[2, 1] = k[1, 2]
    return difference


@njit(cache=True, error_model="numpy")
def inside(new: float, low: float, high: float) -> float:
    """A Newton iterate, or the middle of the bracket if it leaves that; its end if open."""
    if low < new < high:
        return new
    if low == -np.inf:
        return high
    if high == np.inf:
        return low
    return 0.5 * (low + high)


@njit(cache=True, error_model="numpy")
def balanced_law(
    state: Vector,
    length: float,
    xi: Vector,
    weights: Vector,
    spread: Vector,
    y: Vector,
    area: Vector,
    steel: Vector,
    plastic_old: NDArray[np.float64],
    plastic_new: NDArray[np.float64],
    local: Vector,
    k: NDArray[np.float64],
    coupling: Vector,
) -> None:
    """`point_sums` with the amplitude `state[4]` such that N is the same at both points.

    With linear axial displacement alone, a section that yields under N and M cannot shorten or
    lengthen freely, because its element's other section is elastic: N is relieved, and the
    moment capacity overestimated. The force R_a rises with a, so that a safeguarded Newton
    iteration from the last a finds it. Writes the condensed `k` as well.
    """
    tolerance = BALANCE * steel[1] * np.sum(area) * length
    a = state[4]
    low, high = -np.inf, np.inf
    for _ in range(INNER_ITERATIONS):
        state[4] = a
        difference = point_sums(
            state,
            length,
            xi,
            weights,
            spread,
            y,
            area,
            steel,
            plastic_old,
            plastic_new,
            local,
            k,
            coupling,
        )
        if abs(difference) <= tolerance:
            break
        if difference > 0.0:
            high = a
        else:
            low = a
        a = inside(a - difference / coupling[3], low, high)
        if a == state[4]:
            break
    for i in range(3):
        for j in range(3):
            k[i, j] -= coupling[i] * coupling[j] / coupling[3]


@njit(cache=True, error_model="numpy")
def element_law(
    state: Vector,
    theta1: float,
    theta2: float,
    shear_stiffness: float,
    second: float,
    length: float,
    xi: Vector,
    weights: Vector,
    spread: Vector,
    y: Vector,
    area: Vector,
    steel: Vector,
    plastic_old: NDArray[np.float64],
    plastic_new: NDArray[np.float64],
    local: Vector,
    k: NDArray[np.float64],
    coupling: Vector,
) -> None:
    """Local forces (N, M1, M2) and their 3 x 3 tangent for given local deformations.

    Arguments: `state` (5,), the elongation, and from the last trial the bending rotations, the
    shear strain and the axial amplitude, from which the solution starts and into which it is
    written; end rotations `theta1`, `theta2` against the chord; `shear_stiffness` GA in N (0: no
    shear strain); `second` moment of area in m4; `spread` (points,), all zero for linear axial
    displacement; scratch `coupling` (4,); the rest as in `point_sums`.

    The elastic shear strain g, constant along the element, turns both ends against the chord:
    bending rotations are theta + g, and GA L g + M1 + M2 = 0 fixes g.
    """
    balanced = spread[0] != 0.0
    stiffness = shear_stiffness * length
    elastic = 6.0 * steel[0] * second / length
    g = 0.0
    if shear_stiffness > 0.0:
        # exact if all fibers respond elastically from the last trial
        g = state[3]
        change = theta1 + theta2 - (state[1] - g) - (state[2] - g)
        g -= elastic * change / (stiffness + 2.0 * elastic)
    low, high = -np.inf, np.inf
    tolerance = BALANCE * elastic
    for _ in range(INNER_ITERATIONS):
        state[1] = theta1 + g
        state[2] = theta2 + g
        state[3] = g
        if balanced:
            balanced_law(
                state,
                length,
                xi,
                weights,
                spread,
                y,
                area,
                steel,
                plastic_old,
                plastic_new,
                local,
                k,
                coupling,
            )
        else:
            point_sums(
                state,
                length,
                xi,
                weights,
                spread,
                y,
                area,
                steel,
                plastic_old,
                plastic_new,
                local,
                k,
                coupling,
            )
        if shear_stiffness <= 0.0:
            return
        residual = stiffness * g + local[1] + local[2]
        pivot = stiffness + k[1, 1] + 2.0 * k[1, 2] + k[2, 2]
        if abs(residual) <= tolerance:
            break
        # the residual rises with g: Newton's step, kept inside the bracket
        if residual > 0.0:
            high = g
        else:
            low = g
        g = inside(g - residual / pivot, low, high)
        if g == state[3]:
            break
    for i in range(3):
        coupling[i] = k[i, 1] + k[i, 2]
    for i in range(3):
        for j in range(3):
            k[i, j] -= coupling[i] * coupling[j] / pivot


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
    shear: Vector,
    second: Vector,
    xi: NDArray[np.float64],
    weights: NDArray[np.float64],
    spread: NDArray[np.float64],
    plastic_old: NDArray[np.float64],
    local_old: NDArray[np.float64],
    state_old: NDArray[np.float64],
    plastic_new: NDArray[np.float64],
    local_new: NDArray[np.float64],
    state_new: NDArray[np.float64],
) -> None:
    """Add forces and tangent of all elements of a group.

    Arguments: `force` (dofs,) and flat `band` to add to; displacements `q0` committed and `q1`
    at the end of the step; `weight` of the end state in the forces of the step; `step`, True for
    the energy-exact forces of a time step, False for equilibrium at the end; then the group's
    arrays, and its committed (`_old`) and trial (`_new`) states. Writes the trial states.
    """
    k = np.empty((3, 3))
    coupling = np.empty(4)
    work = np.empty((10, 4))
    for e in range(dofs.shape[0]):
        i1, i2, i3, i4, i5, i6 = dofs[e]
        Dx, Dy = chords[e, 0], chords[e, 1]
        L = lengths[e]
        d1x, d1y = Dx + q1[i4] - q1[i1], Dy + q1[i5] - q1[i2]
        l1 = math.sqrt(d1x * d1x + d1y * d1y)
        alpha1 = chord_rotation(Dx, Dy, d1x, d1y, 0.5 * (q1[i3] + q1[i6]))
        state = state_new[e]
        # l - L without cancellation: elements of centimetres carry strains of 1e-6
        ux, uy = d1x - Dx, d1y - Dy
        state[0] = (ux * (d1x + Dx) + uy * (d1y + Dy)) / (l1 + L)
        if not (math.isfinite(state[3]) and math.isfinite(state[4])):
            state[1:] = state_old[e, 1:]  # a wild trial must not spoil the next one
        s = section[e]
        local = local_new[e]
        element_law(
            state,
            q1[i3] - alpha1,
            q1[i6] - alpha1,
            shear[s],
            second[s],
            L,
            xi[e],
            weights[e],
            spread[e],
            ys[s],
            areas[s],
            steels[s],
            plastic_old[e],
            plastic_new[e],
            local,
            k,
            coupling,
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
    shear: Vector,
    xi: NDArray[np.float64],
    weights: NDArray[np.float64],
    spread: NDArray[np.float64],
    plastic_old: NDArray[np.float64],
    state_old: NDArray[np.float64],
    plastic_new: NDArray[np.float64],
    state_new: NDArray[np.float64],
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
        sheared = state_new[e, 3]
        change = sheared - state_old[e, 3]
        stored += 0.5 * shear[s] * L * sheared * sheared
        algorithmic += (weight - 0.5) * shear[s] * L * change * change
        for g in range(xi.shape[1]):
            b1 = (6.0 * xi[e, g] - 4.0) / L
            b2 = (6.0 * xi[e, g] - 2.0) / L
            strain0 = state_old[e, 0] / L + spread[e, g] * state_old[e, 4]
            strain1 = state_new[e, 0] / L + spread[e, g] * state_new[e, 4]
            kappa0 = b1 * state_old[e, 1] + b2 * state_old[e, 2]
            kappa1 = b1 * state_new[e, 1] + b2 * state_new[e, 2]
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

    That of a section is -sum(eps_p y A) / sum(y^2 A): what bends it when its stresses are removed.
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
