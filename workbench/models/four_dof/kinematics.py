"""Kinematics of the four-DOF column: two rigid bars, exact for any rotation (Heng 2017, 5.1).

Degrees of freedom (eq. 5.1) q = (v1, u1, beta1, u2): lateral and axial displacement of the hit
point, rotation of the rigid surface between its two hinges, axial displacement of the head. Both
bars are the same element with a hinge at its end and one at the hit point, mirrored:

    bar below, hinges 1 and 2:   v = v1,  x = L_a + u1,       b = beta1
    bar above, hinges 4 and 3:   v = v1,  x = L_b + u2 - u1,  b = -beta1

From length l = sqrt(x^2 + v^2) and angle psi = atan2(v, x) of the chord follow the elongation
e = l - L and the hinge rotations theta_end = psi, theta_mid = b - psi.
With small rotations e = x - L + v^2 / 2L and psi = v / L.

Bars whose webs yield in shear and slide: forces of a panel over (v, x, b).

The sections at the ends of a bar turn by phi, less than the chord by the shear angle d. The
rotations of the hinges are theta_end = phi and theta_mid = b - phi; phi has no mass and balances
inside the bar. Two kinematics (derivation: docs/theory/shear-panel.md):

*chord*: N acts along the chord and sliding stretches the bar, because flanges are continuous, as
in a solid. The kinematics stay those of `kinematics`, with V l = M_end - M_mid for what turns the
chord, so that phi can be eliminated in the projection.

*section*: N and V are normal to and in a section turned by phi / 2, the middle of a hinge, where
a one-point Reissner element samples; a sliding bar does not stretch, as in `fiber-shear`:
e = X cos + Y sin, s = Y cos - X sin of phi / 2, with X = x - l cos phi, Y = v - l sin phi.
"""

import numpy as np

from workbench.base.compiled import njit
from workbench.steel.hinges.kernels import newton_in_bracket
from workbench.steel.hinges.panel_elements import project_condensed
from workbench.steel.hinges.panel_kernels import Panel, project_panel

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


RIGID_IN_SHEAR, CHORD, SECTION = 0, 1, 2
_STEEPEST = 1.5  # rad, rotation of a section


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
def section_deformations(v, x, length, phi):
    """Elongation e and sliding s of a bar whose section is turned by phi (m)."""
    X, Y = x - length * np.cos(phi), v - length * np.sin(phi)
    c, sine = np.cos(0.5 * phi), np.sin(0.5 * phi)
    return X * c + Y * sine, Y * c - X * sine


@njit(cache=True, error_model="numpy")
def section_forces(column, bar, place, state, work):
    """Forces `work.f` and tangent `work.k` over (v, x, b) of a bar at its `place`.

    The rotation `state.turn` of its sections is that of f_phi = N e_phi + V s_phi + M_end - M_mid
    = 0, in a bracket.
    """
    (v, x, b), length = place, column.lengths[bar]
    pinned = column.pinned[bar].view(np.bool_)  # as the panels of frames have them
    panel = Panel(column.flexibility[bar], pinned, length, column.web)
    stress, plastic, E, Q = state.stress[bar], state.plastic[bar], work.E[:], work.Q[:]
    B, D, K = work.B, work.D4[:], work.K4
    low, high, last, phi = -_STEEPEST, _STEEPEST, False, state.turn[bar]
    for _ in range(100):
        e, s = section_deformations(v, x, length, phi)
        c, sine = np.cos(0.5 * phi), np.sin(0.5 * phi)
        e_phi, s_phi = length * sine + 0.5 * s, -length * c - 0.5 * e
        E[0], E[1] = e - plastic[0], s - plastic[3]
        E[2], E[3] = phi - plastic[1], b - phi - plastic[2]
        Q[0], Q[1], Q[2], Q[3] = stress[0], stress[3], stress[1], stress[2]
        project_panel(panel, E, Q, D)
        stress[0], stress[3], stress[1], stress[2] = Q[0], Q[1], Q[2], Q[3]
        N, V = Q[0], Q[1]
        residual = N * e_phi + V * s_phi + Q[2] - Q[3]
        B[0, 0], B[0, 1], B[0, 3] = sine, c, e_phi
        B[1, 0], B[1, 1], B[1, 3] = c, -sine, s_phi
        B[2, 3], B[3, 2], B[3, 3] = 1.0, 1.0, -1.0
        for i in range(4):
            for j in range(4):
                K[i, j] = 0.0
                for m in range(4):
                    for n in range(4):
                        K[i, j] += B[m, i] * D[m, n] * B[n, j]
        turned = 0.5 * (N * c - V * sine), -0.5 * (N * sine + V * c)
        for i in range(2):
            K[i, 3] += turned[i]
            K[3, i] += turned[i]
        K[3, 3] -= 0.25 * (N * e + V * s)
        if last or abs(residual) <= 1e-12 * column.plastic_moments[0]:
            break
        phi, low, high, last = newton_in_bracket(phi, residual, K[3, 3], low, high)
    state.turn[bar] = phi
    f, k = work.f[bar], work.k[bar]
    f[0], f[1], f[2] = N * sine + V * c, N * c - V * sine, Q[3]
    for i in range(3):
        for j in range(3):
            k[i, j] = K[i, j]
            if K[3, 3] > 0.0:
                k[i, j] -= K[i, 3] * K[3, j] / K[3, 3]


@njit(cache=True, error_model="numpy")
def section_mean_forces(bar, state, work):
    """Mean forces of a step over v and x: averaged N and V in their mean direction."""
    phi0, phi1, a, b = work.turn0[bar], state.turn[bar], work.stress0[bar], state.stress[bar]
    sine = 0.5 * (np.sin(0.5 * phi0) + np.sin(0.5 * phi1))
    c = 0.5 * (np.cos(0.5 * phi0) + np.cos(0.5 * phi1))
    N, V = 0.5 * (a[0] + b[0]), 0.5 * (a[3] + b[3])
    work.f[bar, 0], work.f[bar, 1] = N * sine + V * c, N * c - V * sine


@njit(cache=True, error_model="numpy")
def wider(column, state, low, high):
    """The bracket of beta1 where sections turn less than the chords, down to their ends."""
    below, above = state.plastic[0], state.plastic[1]
    one, two = below[1] + below[2], -above[1] - above[2]
    low, high = min(low, min(one, two)), max(high, max(one, two))
    if column.sliding == SECTION:  # and N turns them further
        low, high = low - 0.5 * (high - low) - 1e-3, high + 0.5 * (high - low) + 1e-3
    return low, high


@njit(cache=True, error_model="numpy")
def commit_sliding(column, bar, place, total, start, state, work):
    """Plastic sliding of a bar from its converged forces, and what it dissipates.

    `total`: elongation and rotations of the hinges against the chord. Result: those that are left
    to elongation and bending.
    """
    stretch, end, mid = total
    length, plastic = column.lengths[bar], state.plastic[bar]
    elastic = state.stress[bar, 3] * length / column.web.stiffness
    if column.sliding == CHORD:  # its work is in that of the moments, whose rotations it adds to
        plastic[3] += work.flow[bar, 3]
        return stretch, end - elastic / length, mid + elastic / length
    (v, x, b), phi = place, state.turn[bar]
    stretch, slide = section_deformations(v, x, length, phi)
    mean = 0.5 * (start[bar, 3] + state.stress[bar, 3])
    state.dissipated += mean * (slide - elastic - plastic[3])
    plastic[3] = slide - elastic
    return stretch, phi, b - phi
