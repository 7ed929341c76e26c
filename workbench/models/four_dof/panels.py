"""Bars whose webs yield in shear and slide: forces of a panel over (v, x, b).

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
from numba import njit

from workbench.hinges.kernels import newton_in_bracket
from workbench.hinges.panel_elements import project_condensed
from workbench.hinges.panel_kernels import Panel, project_panel

RIGID_IN_SHEAR, CHORD, SECTION = 0, 1, 2
_STEEPEST = 1.5  # rad, rotation of a section


@njit(cache=True, error_model="numpy")
def chord_forces(column, bar, stress, work):
    """Forces of a bar for the deformations `work.trial` of its chord, tangent and sliding.

    A panel has both rotations in one sense: that of the middle changes its sign.
    """
    trial, D, length = work.trial, work.D, column.lengths[bar]
    panel = Panel(column.flexibility[bar], column.pinned[bar], length, column.web)
    trial[2], stress[2] = -trial[2], -stress[2]
    project_condensed(panel, trial, stress[:3], D, work.flow[bar])
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
    panel = Panel(column.flexibility[bar], column.pinned[bar], length, column.web)
    stress, plastic, E, Q = state.stress[bar], state.plastic[bar], work.E, work.Q
    B, D, K = work.B, work.D4, work.K4
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
        if last or abs(residual) <= 1e-12 * column.plastic_moments[0, 0]:
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
def section_step_gradients(phi0, phi1):
    """Mean sine and cosine of the direction of N over a step."""
    sine, c = np.sin(0.5 * phi0) + np.sin(0.5 * phi1), np.cos(0.5 * phi0) + np.cos(0.5 * phi1)
    return 0.5 * sine, 0.5 * c
