"""The elastic beam-column between two ends: stability functions, and their derivatives.

Bernoulli's beam under an axial force N (tension positive) and end moments M_1, M_4 bends in two
uncoupled modes, symmetric (M_1 - M_4) and antisymmetric (M_1 + M_4), with the flexibilities

    c_s = L / 2EI A(y),  A = tan h / h,        c_a = L / 2EI B(y),  B = (1 - h cot h) / h^2,

h^2 = y = -N L^2 / 4EI; the conventional S_1 and S_2 are (1/A + 1/B) and (1/B - 1/A) by EI / L.
The shortening by bending is -M F'(N) M / 2, so that forces derive from a complementary energy,
jointly convex in (N, M) above the Euler load of the pin-ended bar, y = (pi / 2)^2.
Source: Livesley and Chandler 1956; Oran 1973 for the shortening.

Refined plastic hinges (Liew et al. 1993) lose stiffness by degrees, on a tangent modulus. State of
an element are its moments M and the rotations t = (t_1, t_4) that bend it; a rotation d of its ends
adds

    dt_1 = phi_1 d_1 - phi_4 (1 - phi_1) (k_14 / k_11) d_4,    dt_4 likewise,

and dM = K(N, E_t) dt + dN (dK/dN) t: the tangent modulus acts on increments. K dt is the matrix of
Heng 2017, eq. 2.9, with Liew's phi: 1 while the force state alpha is below 1/2 or falls,
4 alpha (1 - alpha) above, 0 in a full hinge, where M stays on the surface alpha = 1.
With the double modulus E_t is that of the flanges of an ideal I section, each E_t as its
compression grows and E as it falls, see `both_moduli`. Tables and states: `RefinedTables`,
`RefinedState`.
"""

import math

import numpy as np

from workbench.base.compiled import njit
from workbench.mechanics.structures.kernels import add_element, deform

SMALL = 0.01  # of y; below it series
SERIES_A = (1.0, 1.0 / 3.0, 2.0 / 15.0, 17.0 / 315.0, 62.0 / 2835.0, 1382.0 / 155925.0)
SERIES_B = (1.0 / 3.0, 1.0 / 45.0, 2.0 / 945.0, 1.0 / 4725.0, 2.0 / 93555.0, 1382.0 / 638512875.0)
SUBSTEPS = 8
STEEPEST = 9.6  # of y = h^2; a clamped element buckles at pi^2
LEAST_MODULUS = 1e-3
ELASTIC_LIMIT = 0.39  # of the squash load, equation 2.6
SLOPE = 2.7243  # equation 2.7 with E_t / E on the left, where E / E_t is printed
STATE = 0.5  # force state up to which a hinge is rigid
DIFFERENCE = 1e-7


@njit(cache=True, error_model="numpy", forceinline=True)
def cotangent(y):
    """H cot h for y = h^2; h coth h for negative y, h^2 = -y."""
    if abs(y) < SMALL:
        b = SERIES_B[0] + y * (SERIES_B[1] + y * (SERIES_B[2] + y * SERIES_B[3]))
        return 1.0 - y * b
    h = math.sqrt(abs(y))
    return h / math.tan(h) if y > 0.0 else h / math.tanh(h)


@njit(cache=True, error_model="numpy")
def _series(terms, y):
    """Value, first and second derivative of a power series."""
    value = first = second = 0.0
    for k in range(len(terms) - 1, -1, -1):
        second = second * y + 2.0 * first
        first = first * y + value
        value = value * y + terms[k]
    return value, first, second


@njit(cache=True, error_model="numpy")
def modes(y):
    """A, A', A'' and B, B', B'' at y < (pi / 2)^2."""
    if abs(y) < SMALL:
        return _series(SERIES_A, y), _series(SERIES_B, y)
    a = 1.0 / cotangent(y)
    a1 = (1.0 + y * a * a - a) / (2.0 * y)
    a2 = (a * a + 2.0 * y * a * a1 - 3.0 * a1) / (2.0 * y)
    b = (1.0 - 1.0 / a) / y
    b1 = (a1 / (a * a) - b) / y
    b2 = ((a2 - 2.0 * a1 * a1 / a) / (a * a) - 2.0 * b1) / y
    return (a, a1, a2), (b, b1, b2)


@njit(cache=True, error_model="numpy")
def modulus(n):
    """Tangent modulus over E at a compression n over the squash load (Heng 2017, 2.6 and 2.7)."""
    if n <= ELASTIC_LIMIT:
        return 1.0
    return max(min(-SLOPE * n * math.log(n), 1.0), LEAST_MODULUS) if n < 1.0 else LEAST_MODULUS


@njit(cache=True, error_model="numpy", forceinline=True)
def both_moduli(tangent, shortening, bending):
    """Share of E by which two flanges bend, one of `tangent` E where its compression grows.

    Arguments: elastic strains that a step adds: `shortening` of the axis, `bending` of a flange.
    Between E_t, where both are compressed further (Shanley), and E, where neither is; without
    shortening the double modulus 2 E_t E / (E + E_t) of Engesser and von Karman.
    """
    if bending == 0.0:
        return tangent if shortening >= 0.0 else 1.0
    share = (2.0 * tangent - (1.0 - tangent) * shortening / bending) / (1.0 + tangent)
    return max(min(share, 1.0), tangent)


@njit(cache=True, error_model="numpy", forceinline=True)
def force_state(n, m):
    """Force-state parameter, 1 on the surface of AISC H1-1 (Heng 2017, 2.10 and 2.11)."""
    return max(n + 8.0 / 9.0 * m, 0.5 * n + m)


@njit(cache=True, error_model="numpy")
def stiffness(bar, N, share):
    """k_11, k_14, k_44 of beam, shear and joints at N for a `share` of E."""
    y = min(-bar.geometric * N / share, STEEPEST)
    r = cotangent(y)
    symmetric = 2.0 * share / bar.bending * r
    sway = 6.0 * share / bar.bending
    if abs(y) > 1e-6:
        sway = 2.0 * share / bar.bending * y / (1.0 - r)
    sway /= 1.0 + 2.0 * bar.shear * sway
    near, far = 0.5 * (sway + symmetric), 0.5 * (sway - symmetric)
    f1, f4 = bar.spring1, bar.spring4
    det = (1.0 + near * f1) * (1.0 + near * f4) - far * far * f1 * f4
    first = (near * (1.0 + near * f4) - far * far * f4) / det
    last = (near * (1.0 + near * f1) - far * far * f1) / det
    return first, far / det, last


@njit(cache=True, error_model="numpy", forceinline=True)
def capacity(n, low, high, m):
    """Moment of the sign of `m` that the surface leaves at n."""
    share = max(min(9.0 / 8.0 * (1.0 - n), 1.0 - 0.5 * n), 0.0)
    return share * (high if m > 0.0 else -low)


@njit(cache=True, error_model="numpy")
def soft(n, m, before, pinned):
    """The phi of an end that an elastic increment takes from `before`, (n, m), to n and m.

    An end may load in bending while N falls: it softens by the share of the increment that raises
    the force state, so that forces do not jump where loading turns into unloading.
    """
    if pinned:
        return 0.0
    n0, m0 = before
    old, new = min(force_state(n0, m0), 1.0), force_state(n, m)
    if new <= old or old <= STATE:
        return 1.0
    by_n, by_m = (1.0, 8.0 / 9.0) if 0.5 * n > m / 9.0 else (0.5, 1.0)
    span = by_n * abs(n - n0) + by_m * abs(m - m0)
    share = min((new - old) / span, 1.0)
    return 1.0 - share * (1.0 - 4.0 * old * (1.0 - old))


@njit(cache=True, error_model="numpy")
def refined_law(tables, e, old, end, out):
    """Forces of element `e` at deformations `end` (3,) from its committed state, in substeps.

    Arguments: `tables` and state `old`, see `RefinedTables` and `RefinedState`. Writes N, M_1, M_4
    and the rotations at the end to `out` (5,); result: the new plastic elongation.
    """
    bar, squash, radius = tables.rows[e], tables.squash[e], tables.radius[e]
    start, plastic = old.deformation[e], old.plastic[e]
    t1, t4 = old.turn[e, 0], old.turn[e, 1]
    m1, m4 = old.moment[e, 0], old.moment[e, 1]
    N = (start[0] - plastic) / bar.axial
    share = tables.reduction * modulus(-N / squash[1])
    k1, k, k4 = stiffness(bar, N, share)
    d1, d4 = (end[1] - start[1]) / SUBSTEPS, (end[2] - start[2]) / SUBSTEPS
    bending = radius * max(abs(4.0 * d1 + 2.0 * d4), abs(2.0 * d1 + 4.0 * d4))
    for i in range(1, SUBSTEPS + 1):
        n = abs(N) / squash[0 if N >= 0.0 else 1]
        a1 = n, abs(m1) / (bar.high1 if m1 > 0.0 else -bar.low1)
        a4 = n, abs(m4) / (bar.high4 if m4 > 0.0 else -bar.low4)
        elongation, before = start[0] + (end[0] - start[0]) * i / SUBSTEPS, N
        N = (elongation - plastic) / bar.axial
        N = max(min(N, squash[0]), -squash[1])
        plastic = elongation - N * bar.axial
        n = abs(N) / squash[0 if N >= 0.0 else 1]
        # N acts on the deflection that is there; the new modulus on what is added to it
        s1, s, s4 = stiffness(bar, N, share)
        m1 += (s1 - k1) * t1 + (s - k) * t4
        m4 += (s - k) * t1 + (s4 - k4) * t4
        share = modulus(-N / squash[1])
        if radius > 0.0:
            share = both_moduli(share, (before - N) * bar.axial, bending)
        share *= tables.reduction
        k1, k, k4 = stiffness(bar, N, share)
        e1, e4 = m1 + k1 * d1 + k * d4, m4 + k * d1 + k4 * d4
        p1 = soft(n, abs(e1) / (bar.high1 if e1 > 0.0 else -bar.low1), a1, bar.pinned1)
        p4 = soft(n, abs(e4) / (bar.high4 if e4 > 0.0 else -bar.low4), a4, bar.pinned4)
        by1, by4 = p1 * d1, p4 * d4
        if p1 < 1.0:
            by1 -= p4 * (1.0 - p1) * k / k1 * d4
        if p4 < 1.0:
            by4 -= p1 * (1.0 - p4) * k / k4 * d1
        t1, t4 = t1 + by1, t4 + by4
        m1, m4 = m1 + k1 * by1 + k * by4, m4 + k * by1 + k4 * by4
        # back to the surface by plastic rotations alone: of one end, then of both
        c1 = 0.0 if bar.pinned1 else capacity(n, bar.low1, bar.high1, m1)
        c4 = 0.0 if bar.pinned4 else capacity(n, bar.low4, bar.high4, m4)
        over1, over4 = abs(m1) > c1, abs(m4) > c4
        if over1 or over4:
            b1, b4 = math.copysign(c1, m1), math.copysign(c4, m4)
            alone1, alone4 = m4 - k / k1 * (m1 - b1), m1 - k / k4 * (m4 - b4)
            if over1 and abs(alone1) <= c4:
                t1 -= (m1 - b1) / k1
                m1, m4 = b1, alone1
            elif over4 and abs(alone4) <= c1:
                t4 -= (m4 - b4) / k4
                m1, m4 = alone4, b4
            else:
                b4 = b4 if over4 else math.copysign(c4, alone1)
                b1 = b1 if over1 else math.copysign(c1, alone4)
                det = k1 * k4 - k * k
                t1 += (k4 * (b1 - m1) - k * (b4 - m4)) / det
                t4 += (k1 * (b4 - m4) - k * (b1 - m1)) / det
                m1, m4 = b1, b4
    out[0], out[1], out[2], out[3], out[4] = N, m1, m4, t1, t4
    return plastic


@njit(cache=True, error_model="numpy")
def assemble(step, bars, tables, old, new):
    """Add forces and tangents of all elements for a `step`; write the state `new`."""
    k, work = np.empty((3, 3)), np.empty((7, 4))
    out, moved, end = np.empty(5), np.empty(5), np.empty(3)
    for e in range(bars.dofs.shape[0]):
        chord = deform(bars, e, step.end, new.deformation[e])
        new.plastic[e] = refined_law(tables, e, old, new.deformation[e], out)
        linear = tables.eta * tables.stiffness[e]
        new.local[e] = out[:3] + linear @ new.deformation[e]
        new.moment[e] = out[1:3]
        new.turn[e] = out[3:]
        if step.tangent:
            for j in range(3):
                end[:] = new.deformation[e]
                by = DIFFERENCE * tables.scale[e, j]
                # onwards, so that a step does not look like unloading
                by = -by if end[j] < old.deformation[e, j] else by
                end[j] += by
                refined_law(tables, e, old, end, moved)
                for i in range(3):
                    k[i, j] = (moved[i] - out[i]) / by + linear[i, j]
        add_element(step, bars, e, chord, old.local[e], new.local[e], k, work)
