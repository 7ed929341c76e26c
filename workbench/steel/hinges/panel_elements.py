"""Strain rate in yielding: a plastic hinge in closed form, and bars that flow at their points.

Along a straight moment diagram from mu M_p to zero over a distance L, only the sections with more
than M_p flow, each at the rate of its overstress (Cowper and Symonds). The integral of their
curvature rates is the rotation rate of the hinge, which has no length of its own: a faster hinge is
longer. Viscoplastic bars have the gauge of an envelope, overstress, hardening, points, of plates
with the area and the plastic modulus of the section: root fillets are in the flanges, as
`Section.flange_plates` has them, so that N_p and M_p are met. Derivation and checks:
docs/theory/strain-rate.md.

**Second part.** Closest-point projection of a panel in equilibrium, V l = M_1 + M_4: an element
with 3 forces.

The forces (N, M_1, M_4) and arguments are those of two hinges in series with a bar, domain and
symbols those of a panel, both in `panel_kernels`. The angle d of the panel is one more unknown.
"""

from functools import lru_cache
from math import inf, sqrt
from typing import Any

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit
from workbench.steel.hinges.interaction import ShearSurface
from workbench.steel.hinges.kernels import LAW, MOST, newton_in_bracket
from workbench.steel.hinges.panel_kernels import (
    elastic,
    inside,
    moment_capacity,
    point,
    project_panel,
    slides_back,
)
from workbench.steel.materials import CowperSymonds, Steel
from workbench.steel.sections import Rectangle, Section

_ITERATIONS, _LAYERS = 60, 400
_POINTS = MOST // 2  # of each end; with rate, which smooths where flow begins, half of them
_SHEARED = 8  # of each end, of bars whose web yields in shear


@lru_cache(maxsize=256)
def overstress_shape(section: Section, exponent: float) -> float:
    """Overstress moment over that of a section whose fibers all have the rate of its edge.

    c = (2 / h)^(1/q) / W_pl integral |y|^(1 + 1/q) dA; 10/11 of a rectangle with q = 5.
    """
    heights, areas = section.fibers(_LAYERS)
    relative = np.abs(heights) / (0.5 * section.height)
    return float(np.sum(areas * relative ** (1.0 + 1.0 / exponent)) / np.sum(areas * relative))


def rotation_rate(
    overstress: float, length: float, height: float, shape: float, law: CowperSymonds
) -> float:
    """Rotation rate (rad/s) of a hinge whose moment is (1 + `overstress`) M_p.

    Arguments: `length` (m) from the hinge to the zero of moment, `height` of the section (m),
    `shape` of its overstress.
    """
    q, D = law.exponent, law.reference_rate
    share = overstress ** (q + 1.0) / ((q + 1.0) * (1.0 + overstress))
    return float(2.0 * D * length / (height * shape**q) * share)


def hinge_overstress(
    rate: float, length: float, height: float, shape: float, law: CowperSymonds
) -> float:
    """Inverse of `rotation_rate`: mu - 1 at a rotation rate (rad/s)."""
    q, D = law.exponent, law.reference_rate
    with np.errstate(divide="ignore", invalid="ignore"):
        wanted: Any = np.log((q + 1.0) * shape**q * height * rate / (2.0 * D * length))
        logarithm, open_ = wanted / (q + 1.0), True
        for _ in range(_ITERATIONS):  # Newton in ln x: rising, concave, slope between q and q + 1
            x = np.exp(logarithm)
            change = ((q + 1.0) * logarithm - np.log1p(x) - wanted) / (q + 1.0 - x / (1.0 + x))
            logarithm = logarithm - np.where(open_, change, 0.0)[()]
            open_ = np.logical_and(open_, abs(change) > 1e-14 * np.maximum(1.0, abs(logarithm)))
            if not np.any(open_):
                break
        whole: Any = np.where(wanted > -np.inf, np.exp(logarithm), 0.0)
    over: float = whole[()]
    return over


def panel_overstress(rate: float, law: CowperSymonds) -> float:
    """V / V_pl - 1 of a web at the plastic shear strain rate (1/s), uniform along its bar."""
    return law.factor(rate / sqrt(3.0)) - 1.0


def bar_law(section: Section, steel: Steel, squash_load: float, plastic_moment: float) -> Any:
    """The record (`LAW`) of a bar of a section with plane webs, or of a solid rectangle.

    Arguments: `squash_load` (N) and `plastic_moment` (N m), to which the envelope is stretched if
    they are not those of the section.
    """
    law = np.zeros(1, LAW)[0]
    A, W, height = section.area, section.plastic_section_modulus, section.height
    web, (b, flange) = _plates(section)
    clear, lever = height - 2.0 * flange, A / W
    law["strength"] = squash_load, plastic_moment, plastic_moment
    share = web * clear / A
    law["web_share"], law["web_curve"] = inf, web * clear**2 / W / share**2
    if b > 0.0:
        law["web_share"] = share
        y = 0.5 * clear - 0.5 * web * clear / b
        between = 0.25 * height**2 - y**2
        law["flange_moment"], law["flange_curve"] = b * between / W, between * lever**2
        law["flange_lever"] = y * lever
    c, points = 0.0, _POINTS
    if steel.rate is not None:
        q, points = steel.rate.exponent, _POINTS // 2
        law["reference"], law["exponent"] = steel.rate.reference_rate, q
        c = overstress_shape(section, q) * (0.5 * height * lever) ** (1.0 / q)
    growth = section.second_moment * A / W**2
    law["whole"] = 1.0, 1.0, c, _hardening(steel) * growth
    _spread(law, points)
    return law


def panel_law(surface: ShearSurface) -> Any:
    """The record of a bar whose web yields in shear: flanges and web flow at rates of their own.

    Overstress and hardening are exact in a web that slides and in flanges that bend.
    """
    plates, steel = surface.record, surface.steel
    N = plates["flange_axial"] + plates["web_axial"]
    M = plates["flange_moment"] + plates["web_moment"]
    law = bar_law(surface.section, steel, N, M)
    law["shear"], law["half_web"] = plates["shear"], plates["half_web"] * N / M
    law["spread"] = N**2 / (2.0 * plates["flanges"] * M)
    e, a, sliding = plates["half_height"], plates["half_web"], plates["web_axial"]
    sliding /= sqrt(3.0) * plates["shear"]
    bent = 4.0 / 3.0 * (e**3 - a**3) * (e - a) / (e**2 - a**2) ** 2  # I A / W^2 of both flanges
    flanges = web = 0.0
    if steel.rate is not None:
        p = 1.0 / steel.rate.exponent
        flanges = 2.0 * (e ** (2.0 + p) - a ** (2.0 + p)) / ((2.0 + p) * (e**2 - a**2))
        flanges, web = flanges * (2.0 / (e + a)) ** p, sliding**p
    H = _hardening(steel)
    law["flanges"] = plates["flange_axial"] / N, plates["flange_moment"] / M, flanges, H * bent
    law["web"] = plates["web_axial"] / N, plates["web_moment"] / M, web, H * sliding
    _spread(law, _SHEARED)
    return law


def _hardening(steel: Steel) -> float:
    """Hardening modulus over the yield stress."""
    return (steel.hardening_modulus or 0.0) / steel.yield_stress


def _plates(section: Section) -> tuple[float, tuple[float, float]]:
    """Thickness of the webs; width and thickness of the flanges, none of a rectangle (m)."""
    if isinstance(section.shape, Rectangle):
        return section.width, (0.0, 0.0)
    return section.shape.plates[0], section.flange_plates


def _spread(law: Any, points: int) -> None:
    """Write the points of each end and their weights."""
    law["points"] = 2 * points
    law["place"][: 2 * points], law["weight"][: 2 * points] = _quadrature(points)


@lru_cache(maxsize=4)
def _quadrature(count: int) -> tuple[Array, Array]:
    """Places and weights on a bar, `count` points t of Gauss from each end with xi = t^3 / 2."""
    t, weight = np.polynomial.legendre.leggauss(count)
    t, weight = 0.5 * (t + 1.0), 0.5 * weight
    place, weight = 0.5 * t**3, 1.5 * t**2 * weight
    return np.concatenate([place, 1.0 - place]), np.concatenate([weight, weight])


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
