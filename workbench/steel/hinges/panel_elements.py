"""Closest-point projection of a panel in equilibrium, V l = M_1 + M_4: an element with 3 forces.

The forces (N, M_1, M_4) and arguments are those of `pair_kernels`; domain and symbols those of
`panel_kernels`. The angle d of the panel is one more unknown.
"""

import numpy as np

from workbench.base.compiled import njit
from workbench.steel.hinges.kernels import newton_in_bracket
from workbench.steel.hinges.panel_kernels import (
    elastic,
    inside,
    moment_capacity,
    point,
    project_panel,
    slides_back,
)

ELASTIC, SLIDING, CURVE, NESTED, APEX = 0, 1, 2, 3, 4


@njit(cache=True, error_model="numpy")
def _write(panel, e, N, moments, d, rotations, forces, flow):
    """Forces, and what of the deformations is not elastic; hinges share the elongation as r."""
    f_n, f11, f14, f44 = panel.flexibility
    m1, m4 = moments
    slide = (m1 + m4) / (panel.length * panel.web.stiffness)  # the elastic part of d
    forces[0], forces[1], forces[2] = N, m1, m4
    r1, total = abs(rotations[0]), abs(rotations[0]) + abs(rotations[1])
    stretched = e[0] - f_n * N
    flow[0] = stretched * (r1 / total if total > 0.0 else 0.5)
    flow[2] = stretched - flow[0]
    flow[1] = e[1] - f14 * m4 - slide - (0.0 if panel.pinned[0] else f11 * m1)
    flow[3] = e[2] - f14 * m1 - slide - (0.0 if panel.pinned[1] else f44 * m4)
    flow[4] = panel.length * (d - slide)


@njit(cache=True, error_model="numpy")
def _with_elastic_moments(panel, e, forces, tangent, flow):
    """The branches in which no hinge flows: elastic, or a web that slides. Whether it is one."""
    B11, B14, B44 = elastic(panel)
    S1, S4 = B11 + B14, B14 + B44
    length, stiff, T = panel.length, panel.web.stiffness, abs(e[0]) / panel.flexibility[0]
    m1, m4 = B11 * e[1] + B14 * e[2], B14 * e[1] + B44 * e[2]
    resists = stiff * length + S1 + S4
    d = (m1 + m4) / resists
    V, branch = stiff * d, ELASTIC
    if abs(V) > panel.web.shear:
        V, resists, branch = np.copysign(panel.web.shear, d), S1 + S4, SLIDING
        d = (m1 + m4 - V * length) / resists
        if stiff * abs(d) < panel.web.shear:
            return -1
    share = abs(V) / panel.web.shear
    rho = np.sqrt((1.0 - share) * (1.0 + share))
    if panel.web.flange_axial + rho * panel.web.web_axial < T:
        return -1
    C, m1, m4 = moment_capacity(panel.web, T, rho)[0], m1 - S1 * d, m4 - S4 * d
    if abs(m1) > C or abs(m4) > C:
        return -1
    _write(panel, e, e[0] / panel.flexibility[0], (m1, m4), d, (0.0, 0.0), forces, flow)
    tangent[:] = 0.0
    tangent[0, 0] = 1.0 / panel.flexibility[0]
    tangent[1, 1], tangent[2, 2] = B11 - S1 * S1 / resists, B44 - S4 * S4 / resists
    tangent[1, 2] = tangent[2, 1] = B14 - S1 * S4 / resists
    if branch == ELASTIC:
        flow[0] = flow[2] = flow[4] = 0.0
        flow[1], flow[3] = (
            (flow[1] if panel.pinned[0] else 0.0),
            (flow[3] if panel.pinned[1] else 0.0),
        )
    return branch


@njit(cache=True, error_model="numpy")
def _at_apex(panel, size):
    """Whether the whole section flows in N, without moments and hence without shear."""
    top = panel.web.flange_axial + panel.web.web_axial
    turned = 0.0 if panel.pinned[0] else abs(size[1])
    turned += 0.0 if panel.pinned[1] else abs(size[2])
    return size[0] - panel.flexibility[0] * top >= panel.web.half_height * turned


@njit(cache=True, error_model="numpy")
def project_condensed(panel, e, forces, tangent, flow):
    """Nearest admissible (N, M_1, M_4) of a panel in equilibrium, V l = M_1 + M_4.

    Arguments as of `project_pair`: `e` (3,): elongation (m) and end rotations, less what is
    plastic. `forces` (3,) also are where the search begins. Writes `forces`, `tangent` (3, 3) and
    `flow` (5,): plastic elongation and rotation of hinge 1, then of hinge 4, both turned by the
    sliding of the web too, and that sliding (m). Returns the branch.
    """
    branch = _with_elastic_moments(panel, e, forces, tangent, flow)
    if branch >= 0:
        return branch
    size, sign = (abs(e[0]), e[1], e[2]), 1.0 if e[0] >= 0.0 else -1.0
    if _at_apex(panel, size):
        top = panel.web.flange_axial + panel.web.web_axial
        _write(panel, e, sign * top, (0.0, 0.0), 0.0, (e[1], e[2]), forces, flow)
        tangent[:] = 0.0
        return APEX
    length, top = panel.length, panel.web.flange_axial + panel.web.web_axial
    B11, B14, B44 = elastic(panel)
    S1, S4 = B11 + B14, B14 + B44
    # Newton over N, a and d together, from the last forces
    N = min(abs(forces[0]), size[0] / panel.flexibility[0])
    a = np.arcsin(min(max((forces[1] + forces[2]) / (length * panel.web.shear), -0.999), 0.999))
    low, high, last = min(e[1], e[2], 0.0), max(e[1], e[2], 0.0), False
    d = (S1 * e[1] + S4 * e[2] - panel.web.shear * np.sin(a) * length) / (S1 + S4)
    d = min(max(d, low), high)
    for _ in range(12):  # equilibrium first, piecewise linear in d
        at = point(panel, size, N, a, d)
        if last or abs(at.residual[2]) <= 1e-6 * at.capacity[0]:
            break
        slope = at.block[0] + 2.0 * at.block[1] + at.block[2]
        d, low, high, last = newton_in_bracket(d, at.residual[2], slope, low, high)
    turned = abs(e[1]) + abs(e[2])
    for _ in range(30):
        at = point(panel, size, N, a, d)
        (C, CN, Ca), (p1, p4), (V, Va), (B11, B14, B44) = at.capacity, at.slopes, at.shear, at.block
        (JNN, JNa, Jaa), (gN, ga, gd) = at.hessian, at.residual
        S1, S4 = B11 + B14, B14 + B44
        det = JNN * Jaa - JNa * JNa
        j1, j2 = (p1 + p4) * CN, (p1 + p4) * Ca - length * Va
        b1, b2 = (Jaa * j1 - JNa * j2) / det, (JNN * j2 - JNa * j1) / det
        schur = S1 + S4 + j1 * b1 + j2 * b2
        if not (det > 0.0 and schur > 0.0):
            break
        dd = -(gd + b1 * gN + b2 * ga) / schur
        dN = (JNa * ga - Jaa * gN) / det - b1 * dd
        da = (JNa * gN - JNN * ga) / det - b2 * dd
        factor = 1.0  # the part of the step that stays inside
        while not inside(panel.web, N + factor * dN, a + factor * da) and factor > 1e-3:
            factor *= 0.5
        N, a, d = N + factor * dN, a + factor * da, d + factor * dd
        still = abs(dN) <= 1e-11 * top and abs(da) <= 1e-11 and abs(dd) <= 1e-10 * turned
        if still and abs(gd) <= 1e-10 * C:
            if slides_back(panel.web, V, a, d):
                break
            dC = CN * dN + Ca * da
            m1, m4 = at.moments[0] + p1 * dC - S1 * dd, at.moments[1] + p4 * dC - S4 * dd
            _write(panel, e, sign * N, (m1, m4), d, at.rotations, forces, flow)
            tangent[:] = 0.0
            tangent[1, 1], tangent[1, 2], tangent[2, 1], tangent[2, 2] = B11, B14, B14, B44
            for j in range(3):
                p, w = (0.0, p1, p4)[j], (0.0, S1, S4)[j]
                x, y = sign if j == 0 else p * CN, p * Ca
                dd = (w + b1 * x + b2 * y) / schur
                dN = (Jaa * x - JNa * y) / det - b1 * dd
                dC = CN * dN + Ca * ((JNN * y - JNa * x) / det - b2 * dd)
                tangent[0, j] += sign * dN
                tangent[1, j] += p1 * dC - S1 * dd
                tangent[2, j] += p4 * dC - S4 * dd
            return CURVE
    return _by_angle(panel, e, forces, tangent, flow)


@njit(cache=True, error_model="numpy")
def _by_angle(panel, e, forces, tangent, flow):
    """Solve `project_condensed` safely: the angle d in a bracket, with `project_panel` inside.

    The sum of the moments changes sign between the rotations of the ends, and V has the sign of d.
    """
    length, four, D, given = panel.length, np.zeros(4), np.zeros((4, 4)), np.zeros(4)
    four[0], four[1] = forces[0], (forces[1] + forces[2]) / length
    low, high, last = min(e[1], e[2], 0.0), max(e[1], e[2], 0.0), False
    d, slope = 0.5 * (low + high), 0.0
    given[0] = e[0]
    sums = np.zeros(4)  # of D with the row (0, length, -1, -1)
    for _ in range(200):
        given[1], given[2], given[3] = length * d, e[1] - d, e[2] - d
        project_panel(panel, given, four, D)
        gd = four[1] * length - four[2] - four[3]
        for j in range(4):
            sums[j] = length * D[1, j] - D[2, j] - D[3, j]
        slope = length * sums[1] - sums[2] - sums[3]
        if last or gd == 0.0:
            break
        d, low, high, last = newton_in_bracket(d, gd, slope, low, high)
    f = panel.flexibility
    r1 = 0.0 if panel.pinned[0] else e[1] - d - f[1] * four[2] - f[2] * four[3]
    r4 = 0.0 if panel.pinned[1] else e[2] - d - f[2] * four[2] - f[3] * four[3]
    _write(panel, e, four[0], (four[2], four[3]), d, (r1, r4), forces, flow)
    for i in range(3):
        for j in range(3):
            p, q = (i + 1 if i else 0), (j + 1 if j else 0)
            tangent[i, j] = D[p, q] - (sums[p] * sums[q] / slope if slope > 0.0 else 0.0)
    return NESTED
