"""Kinematics of the four-DOF column: two rigid bars, exact for any rotation (Heng 2017, 5.1).

Degrees of freedom (eq. 5.1) q = (v1, u1, beta1, u2): lateral and axial displacement of the impact
point, rotation of the rigid surface between its two hinges, axial displacement of the head. Both
bars are the same element with a hinge at its end and one at the impact point, mirrored:

    bar below, hinges 1 and 2:   v = v1,  x = L_a + u1,       b = beta1
    bar above, hinges 4 and 3:   v = v1,  x = L_b + u2 - u1,  b = -beta1

From length l = sqrt(x^2 + v^2) and angle psi = atan2(v, x) of the chord follow the elongation
e = l - L and the hinge rotations theta_end = psi, theta_mid = b - psi.
With small rotations e = x - L + v^2 / 2L and psi = v / L.

**Second part.** Bars whose webs yield in shear and slide: forces of a panel over (v, x, b).

The sections at the ends of a bar turn by phi, less than the chord by the shear angle d. The
rotations of the hinges are theta_end = phi and theta_mid = b - phi; phi has no mass and balances
inside the bar (derivation: docs/theory/shear-panel.md). N acts along the chord and sliding
stretches the bar, because flanges are continuous, as in a solid. The kinematics stay those above,
with V l = M_end - M_mid for what turns the chord, so that phi can be eliminated in the projection.

**Third part.** Strength of a bar: two hinges on a yield surface, a panel, or a bar that flows point
by point.
"""

import numpy as np
from numba.extending import overload

from workbench.base.compiled import njit
from workbench.steel.hinges.kernels import ELASTIC, flow_of_bar, project
from workbench.steel.hinges.panel_elements import project_condensed
from workbench.steel.hinges.panel_kernels import Panel

V, U1, BETA, U2 = 0, 1, 2, 3
BELOW, ABOVE = 0, 1


@njit(cache=True, error_model="numpy")
def place(q, lengths, bar):
    """Coordinates (v, x, b) of a bar."""
    if bar == BELOW:
        return q[V], lengths[BELOW] + q[U1], q[BETA]
    return q[V], lengths[ABOVE] + q[U2] - q[U1], -q[BETA]


@njit(cache=True, error_model="numpy")
def stretch_and_angle(v, x, length, small):
    """Elongation e (m) and rotation psi (rad) of the chord."""
    if small:
        return (x - length) + 0.5 * v * v / length, v / length
    chord = np.sqrt(x * x + v * v)
    return ((x - length) * (x + length) + v * v) / (chord + length), np.arctan2(v, x)


@njit(cache=True, error_model="numpy")
def gradients(v, x, length, small):
    """Gradients de/dv, de/dx, dpsi/dv, dpsi/dx."""
    if small:
        return v / length, 1.0, 1.0 / length, 0.0
    chord = np.sqrt(x * x + v * v)
    return v / chord, x / chord, x / chord**2, -v / chord**2


@njit(cache=True, error_model="numpy")
def geometric_stiffness(v, x, length, small, N, M):
    """Second derivatives vv, vx, xx of N e + M psi, for forces that do not change."""
    if small:
        return N / length, 0.0, 0.0
    chord = np.sqrt(x * x + v * v)
    s, c, l4 = v / chord, x / chord, chord**4
    vv = N * c * c / chord - M * 2.0 * x * v / l4
    vx = -N * s * c / chord + M * (v * v - x * x) / l4
    return vv, vx, N * s * s / chord + M * 2.0 * x * v / l4


@njit(cache=True, error_model="numpy")
def step_gradients(v0, x0, v1, x1, length, small):
    """Discrete `gradients` over a step from (v0, x0) to (v1, x1).

    de = e_v dv + e_x dx and dpsi = psi_v dv + psi_x dx hold exactly for the differences.
    """
    if small:
        return 0.5 * (v0 + v1) / length, 1.0, 1.0 / length, 0.0
    l0, l1 = np.sqrt(x0 * x0 + v0 * v0), np.sqrt(x1 * x1 + v1 * v1)
    vm, xm = 0.5 * (v0 + v1), 0.5 * (x0 + x1)
    sine = (x0 * v1 - x1 * v0) / (l0 * l1)
    chi = 1.0 + sine * sine / 6.0 if abs(sine) < 1e-4 else np.arcsin(sine) / sine
    return 2.0 * vm / (l0 + l1), 2.0 * xm / (l0 + l1), chi * xm / (l0 * l1), -chi * vm / (l0 * l1)


@njit(cache=True, error_model="numpy")
def chord_forces(column, bar, stress, work):
    """Forces of a bar for the deformations `work.trial` of its chord, tangent and sliding.

    A panel has both rotations in one sense: that of the middle changes its sign.
    """
    trial, D, length = work.trial[:], work.D[bar], column.lengths[bar]
    pinned = column.pinned[bar].view(np.bool_)  # as the panels of frames have them
    panel = Panel(column.flexibility[bar], pinned, length, column.web)
    trial[2], stress[2] = -trial[2], -stress[2]
    project_condensed(panel, trial, stress[:3], D, work.flow[bar])
    work.flow[bar, 3] = work.flow[bar, 4]
    stress[2] = -stress[2]
    stress[3] = (stress[1] - stress[2]) / length
    for j in range(2):
        D[2, j], D[j, 2] = -D[2, j], -D[j, 2]


@njit(cache=True, error_model="numpy")
def wider(state, low, high):
    """The bracket of beta1 where sections turn less than the chords, down to their ends."""
    below, above = state.plastic[0], state.plastic[1]
    one, two = below[1] + below[2], -above[1] - above[2]
    return min(low, min(one, two)), max(high, max(one, two))


_FLOWING = ELASTIC + 1


@njit(cache=True, error_model="numpy", forceinline=True)
def projected(column, bar, elastic, stress, work):
    """Forces of two hinges, or of a panel, that do not know time."""
    if column.sliding:
        trial, D = work.trial[:], work.D[bar]
        trial[0], trial[1], trial[2] = elastic
        chord_forces(column, bar, stress[bar], work)
        return D[0, 0], D[0, 1], D[0, 2], D[1, 1], D[1, 2], D[2, 2]
    k, N, M = column.stiffness, column.squash_loads, column.plastic_moments
    stiffness = k[bar, 0], k[bar, 1], k[bar, 2]
    trial = stiffness[0] * elastic[0], stiffness[1] * elastic[1], stiffness[2] * elastic[2]
    bounds, exponents = (N[0], N[1], M[0], M[1]), (column.alpha, column.beta)
    projected = project(stiffness, bounds, exponents, trial, work.z[bar])
    work.branch[bar], work.z[bar] = projected[0], projected[3]
    stress[bar, 0], stress[bar, 1], stress[bar, 2] = projected[1]
    return projected[2]


@njit(cache=True, error_model="numpy")
def viscoplastic(column, bar, elastic, state, work):
    """Forces of a bar after a step of `work.dt`, from those that the last tangent expects."""
    f, pinned, length = column.flexibility[bar], column.pinned[bar], column.lengths[bar]
    slides = column.sliding
    soft = 1.0 / (length * column.web.stiffness) if slides else 0.0
    last, stress = work.last[bar], state.stress[bar]
    e, a, b = elastic[0] - last[0], elastic[1] - last[1], elastic[2] - last[2]
    stress[0] += last[3] * e + last[4] * a + last[5] * b
    stress[1] += last[4] * e + last[6] * a + last[7] * b
    stress[2] += last[5] * e + last[7] * a + last[8] * b
    flows, tangent, work.flow[bar, 3] = flow_of_bar(
        column.law,
        length,
        (f[0], f[1] + soft, f[2] - soft, f[3] + soft),
        (pinned[0] > 0, pinned[1] > 0),
        elastic,
        work.dt,
        state.plastic[bar, 4:],
        stress,
        work.flow[bar, 4:],
    )
    for i in range(3):
        last[i] = elastic[i]
    for i in range(6):
        last[3 + i] = tangent[i]
    work.branch[bar] = _FLOWING if flows else ELASTIC
    if slides:
        stress[3] = (stress[1] - stress[2]) / length
    return tangent


def hinge_forces(column, bar, elastic, state, work):
    """Forces of a bar from its `elastic` deformations, into `state.stress`, and their tangent.

    The tangent as numbers, NN, N1, N2, 11, 12, 22. Which strength it is, the type of the column
    says when kernels are compiled: what is not used is not compiled.
    """
    raise NotImplementedError


@overload(hinge_forces, jit_options={"error_model": "numpy", "forceinline": True})
def _by_type(column, bar, elastic, state, work):
    if "law" in column.fields:
        return lambda column, bar, elastic, state, work: viscoplastic(
            column, bar, elastic, state, work
        )
    return lambda column, bar, elastic, state, work: projected(
        column, bar, elastic, state.stress, work
    )
