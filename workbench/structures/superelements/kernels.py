"""Assembly and energies of superelements.

Symbols: local deformations (u, theta_1, theta_4) against the chord, local forces (N, M_1, M_4);
Q, what hinges and bar carry; eta, the share of the elastic stiffness that always acts beside
them and keeps the tangent regular; alpha, rotation of the chord, the only rotation of a rigid
bar that has inertia. Source: Heng 2017, papers III and IV; midpoint form of Hamilton's
principle for the rotary inertia after Simo and Tarnow 1992.
"""

import math

from numba import njit

from workbench.hinges.pair_kernels import Pair, project_pair
from workbench.hinges.panel_elements import project_condensed
from workbench.hinges.panel_kernels import Panel
from workbench.structures.corotation.kernels import add_element, chord_at


@njit(cache=True, error_model="numpy", forceinline=True)
def hinge_bar_law(e, hinges, plastic, new, k, trial, flow):
    """Local forces and tangent of element `e` for its deformations in the `new` state.

    Arguments: `hinges`, see `HingeTables`; committed `plastic` deformations (e, 4). Writes the new
    plastic deformations, the forces carried by the hinges, local forces and their tangent `k`
    (3, 3); scratch `trial` (3,), `flow` (5,).
    """
    eta = hinges.eta
    deformation, carried, local = new.deformation[e], new.carried[e], new.local[e]
    trial[0] = deformation[0] - plastic[e, 0] - plastic[e, 2]
    trial[1] = deformation[1] - plastic[e, 1]
    trial[2] = deformation[2] - plastic[e, 3]
    bending, pinned = hinges.bending[e], hinges.pinned[e]
    if hinges.webs[e].stiffness > 0.0:
        panel = Panel(bending, pinned, hinges.lengths[e], hinges.webs[e])
        project_condensed(panel, trial, carried, k, flow)
    else:
        pair = Pair(bending, hinges.bounds[e], hinges.exponents[e], pinned)
        project_pair(pair, trial, carried, k, flow)
    for i in range(4):
        new.plastic[e, i] = plastic[e, i] + flow[i]
    rest = 1.0 - eta
    for i in range(3):
        local[i] = rest * carried[i]
        for j in range(3):
            k[i, j] *= rest
    kn, k11, k14, k44 = hinges.stiffness[e]
    local[0] += eta * kn * deformation[0]
    local[1] += eta * (k11 * deformation[1] + k14 * deformation[2])
    local[2] += eta * (k14 * deformation[1] + k44 * deformation[2])
    k[0, 0] += eta * kn
    k[1, 1] += eta * k11
    k[1, 2] += eta * k14
    k[2, 1] += eta * k14
    k[2, 2] += eta * k44


@njit(cache=True, error_model="numpy")
def assemble(step, bars, hinges, old, new):
    """Add forces and tangents of all superelements for a `step`; write the state `new`.

    The rotary inertia of the chords acts in time steps of finite duration only.
    """
    k, work, trial, flow = hinges.scratch
    moving = step.dynamic and math.isfinite(step.duration)
    for e in range(bars.dofs.shape[0]):
        chord = chord_at(bars, e, step.end)
        new.deformation[e, 0] = chord.elongation
        new.deformation[e, 1] = step.end[bars.dofs[e, 2]] - chord.rotation
        new.deformation[e, 2] = step.end[bars.dofs[e, 5]] - chord.rotation
        hinge_bar_law(e, hinges, old.plastic, new, k, trial, flow)
        gradients, turn = add_element(step, bars, e, chord, old.local[e], new.local[e], k, work)
        new.rate[e] = 0.0
        if moving and hinges.rotary[e] > 0.0:
            new.rate[e] = 2.0 * turn / step.duration - old.rate[e]
            turn_chord(step, bars, e, chord, gradients, hinges.rotary[e], new.rate[e] - old.rate[e])


@njit(cache=True, error_model="numpy", forceinline=True)
def turn_chord(step, bars, e, chord, gradients, inertia, change):
    """Add the forces that change the angular velocity of a chord by `change`, and their tangent."""
    dofs, positions = bars.dofs[e], bars.positions[e]
    couple = inertia * change / step.duration
    gx, gy = gradients.gx, gradients.gy
    step.force[dofs[0]] -= couple * gx
    step.force[dofs[1]] -= couple * gy
    step.force[dofs[3]] += couple * gx
    step.force[dofs[4]] += couple * gy
    # d alpha / d d_1 = n_1 / l_1
    turn = 2.0 * inertia / (step.duration * step.duration * chord.length)
    e1x, e1y = chord.x / chord.length, chord.y / chord.length
    xx = couple * gradients.gxx - turn * gx * e1y
    xy = couple * gradients.gxy + turn * gx * e1x
    yx = couple * gradients.gyx - turn * gy * e1y
    yy = couple * gradients.gyy + turn * gy * e1x
    for i in range(2):
        for j in range(2):
            sign = 1.0 if i == j else -1.0
            first = 18 * i + 3 * j
            step.band[positions[first]] += sign * xx
            step.band[positions[first + 1]] += sign * xy
            step.band[positions[first + 6]] += sign * yx
            step.band[positions[first + 7]] += sign * yy


@njit(cache=True, error_model="numpy", forceinline=True)
def _quadratic(matrix, x):
    """Quadratic form of x (3,) with [a, 0, 0; 0, b, c; 0, c, d], stored as (a, b, c, d)."""
    axial = matrix[0] * x[0] * x[0]
    bending = matrix[1] * x[1] * x[1] + matrix[3] * x[2] * x[2]
    coupling = 2.0 * matrix[2] * x[1] * x[2]
    return axial + bending + coupling


@njit(cache=True, error_model="numpy")
def account(weight, bars, hinges, old, new):
    """Energies of a step from the committed to the trial state of a group, in J.

    Result: stored energy at the end; plastic dissipation of the step with forces weighted as in
    the step; algorithmic dissipation; and the plastic work of forces that stay at yield.
    """
    stored = plastic = algorithmic = ideal = 0.0
    eta, rest = hinges.eta, 1.0 - hinges.eta
    _, _, change, moved = hinges.scratch
    for e in range(bars.lengths.shape[0]):
        stored += 0.5 * rest * _quadratic(hinges.flexibility[e], new.carried[e])
        stored += 0.5 * eta * _quadratic(hinges.stiffness[e], new.deformation[e])
        for i in range(3):
            change[i] = new.carried[e, i] - old.carried[e, i]
            moved[i] = new.deformation[e, i] - old.deformation[e, i]
        algorithmic += (weight - 0.5) * (
            rest * _quadratic(hinges.flexibility[e], change)
            + eta * _quadratic(hinges.stiffness[e], moved)
        )
        for h in range(4):
            i = 0 if h % 2 == 0 else 1 + h // 2
            flow = new.plastic[e, h] - old.plastic[e, h]
            end = rest * new.carried[e, i]
            plastic += (weight * end + (1.0 - weight) * rest * old.carried[e, i]) * flow
            ideal += end * flow
    return stored, plastic, algorithmic, ideal
