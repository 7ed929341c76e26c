"""Resistance curves of the column as piecewise polynomials: construction and evaluation.

A curve is `starts` (n,), rising displacements at which pieces begin, and `coefficients` (n, 4)
of the force in x = v - start; the last piece has no end. Evaluation goes by one `table`
(n, COLUMNS): the coefficients, START, work and steepest slope up to START, and in BOUND the
steepest slope of the whole curve. Source of the mechanics: Heng 2017, section 5.2 (linear yield
surface, small rotations, one axial force N for both bars).
Hinge groups g: rotation per displacement s_g, elastic moment per displacement K_g, flexibility
phi_g; kappa = 1/L_a + 1/L_b; r = M_p / N_p; c_ax axial flexibility (infinite: free to shorten).
"""

from __future__ import annotations

import numpy as np
from numba import njit

NO_EVENT, GROUP_YIELDS, AXIAL_FORCE_VANISHES, TENSION_GROWS, CATENARY = 0, 1, 2, 3, 4
MAX_PIECES = 40
START, WORK, STEEPEST, BOUND, COLUMNS = 4, 5, 6, 7, 8
_FAR = 1e3  # m, beyond any displacement that a model may reach


@njit(cache=True, error_model="numpy")
def falling_root(a0, a1, a2, tolerance):
    """Smallest x >= 0 at which a0 + a1 x + a2 x^2, not negative at 0, falls to zero (or inf)."""
    if a0 <= tolerance:
        # at zero already: it falls now, or it first rises and may come back
        if a1 < 0.0 or (a1 == 0.0 and a2 < 0.0):
            return 0.0
        return -a1 / a2 if a2 < 0.0 else np.inf
    if a2 == 0.0:
        return -a0 / a1 if a1 < 0.0 else np.inf
    square = a1 * a1 - 4.0 * a0 * a2
    if square < 0.0:
        return np.inf
    # the root formula without cancellation, by the sign of a1
    q = -0.5 * (a1 + (np.sqrt(square) if a1 >= 0.0 else -np.sqrt(square)))
    best = np.inf
    if q / a2 > 0.0:
        best = q / a2
    if q != 0.0 and 0.0 < a0 / q < best:
        best = a0 / q
    return best


@njit(cache=True, error_model="numpy")
def analytic_curve(s, K, phi, kappa, Mp, Np, N0, c_ax):
    """Exact event-driven curve; `s`, `K`, `phi` (groups,); `N0` axial force, tension positive.

    Returns (n, starts, coefficients, axial (n, 3), active (n, groups), events (n,), group (n,),
    unloads): per piece the force and axial-force polynomials, the plastic groups, the event with
    which it begins and the group of that event; `unloads` if a plastic hinge would unload, which
    the derivation excludes.
    """
    groups = s.size
    starts, coefficients = np.zeros(MAX_PIECES), np.zeros((MAX_PIECES, 4))
    axial = np.zeros((MAX_PIECES, 3))
    active = np.zeros((MAX_PIECES, groups), np.bool_)
    events, which = np.zeros(MAX_PIECES, np.int64), np.full(MAX_PIECES, -1)
    plastic = np.zeros(groups, np.bool_)
    r, v, N, hold, caught, unloads = Mp / Np, 0.0, N0, False, False, False
    sigma = 1.0 if N0 >= 0.0 else -1.0
    event, group, n = NO_EVENT, -1, 0
    for _ in range(MAX_PIECES):
        s_plastic, C, w_elastic = 0.0, c_ax, 0.0
        for g in range(groups):
            if plastic[g]:
                s_plastic += s[g]
                C += r * r * phi[g]
            else:
                w_elastic += s[g] * K[g]
        if not caught and not hold and N == 0.0:
            # the corner of the yield surface holds N = 0 while hinges stretch faster than chords
            hold = kappa * v < r * s_plastic * (1.0 - 1e-12)
            sigma = 1.0
        if caught:
            n0, n1, n2 = Np, 0.0, 0.0
        elif hold:
            n0, n1, n2 = 0.0, 0.0, 0.0
        else:
            n0, n1, n2 = N, (kappa * v - sigma * r * s_plastic) / C, 0.5 * kappa / C
        m0, m1, m2 = Mp - sigma * r * n0, -sigma * r * n1, -sigma * r * n2
        # next event
        x, next_event, next_group = np.inf, NO_EVENT, -1
        if not caught:
            for g in range(groups):
                if not plastic[g]:
                    at = falling_root(m0 - K[g] * v, m1 - K[g], m2, 1e-13 * Mp)
                    if at < x:
                        x, next_event, next_group = at, GROUP_YIELDS, g
            if hold:
                at = r * s_plastic / kappa - v
                if at < x:
                    x, next_event, next_group = max(at, 0.0), TENSION_GROWS, -1
            else:
                at = falling_root(sigma * n0, sigma * n1, sigma * n2, 0.0) if n0 != 0.0 else np.inf
                if at < x:
                    x, next_event, next_group = at, AXIAL_FORCE_VANISHES, -1
                at = falling_root(Np - n0, -n1, -n2, 0.0)
                if at < x:
                    x, next_event, next_group = at, CATENARY, -1
        if x > 1e-13 * (v + r):
            starts[n], events[n], which[n] = v, event, group
            coefficients[n, 0] = s_plastic * m0 + w_elastic * v + kappa * n0 * v
            coefficients[n, 1] = s_plastic * m1 + w_elastic + kappa * (n0 + n1 * v)
            coefficients[n, 2] = s_plastic * m2 + kappa * (n1 + n2 * v)
            coefficients[n, 3] = kappa * n2
            axial[n, 0], axial[n, 1], axial[n, 2] = n0, n1, n2
            active[n] = plastic
            n += 1
            if not caught:
                # plastic rotation of a group grows at the rate (K_g - dM/dv) phi_g
                last = n1 if x == np.inf else n1 + 2.0 * n2 * x
                slowest = min(sigma * r * n1, sigma * r * last)
                for g in range(groups):
                    if plastic[g] and K[g] + slowest < -1e-9 * K[g]:
                        unloads = True
            if x == np.inf:
                break
            N = n0 + x * (n1 + x * n2)
            v += x
        event, group = next_event, next_group
        if event == GROUP_YIELDS:
            plastic[group] = True
        elif event == AXIAL_FORCE_VANISHES:
            N = 0.0
        elif event == TENSION_GROWS:
            hold, N, sigma = False, 0.0, 1.0
        elif event == CATENARY:
            caught, N, sigma = True, Np, 1.0
    return n, starts, coefficients, axial, active, events, which, unloads


@njit(cache=True, error_model="numpy")
def simplified_points(s, K, phi, kappa, Mp, Np, N0, c_ax):
    """Points that both simplifications share: (F0, k_e, v_y, v_b, v_nd, v_c).

    F0 mechanism load at the initial axial force, k_e elastic stiffness, v_y = F0 / k_e, v_b
    last hinge, v_nd axial force gone, v_c catenary (infinite without axial restraint).
    """
    r, total = Mp / Np, np.sum(s)
    Mr = Mp * (1.0 - abs(N0) / Np)
    F0, ke = total * Mr, np.sum(s * K)
    vy = F0 / ke
    vb = max(Mr / np.min(K), vy)
    v_hat = r * total / kappa
    C = c_ax + r * r * np.sum(phi)
    q = kappa / C
    if q == 0.0:
        return F0, ke, vy, vb, (vb if N0 == 0.0 else np.inf), np.inf
    push = N0 / q  # q ((v^2 - v_b^2) / 2 -+ v_hat (v - v_b)) is the growth of N after v_b
    N_b = 0.0
    if N0 <= 0.0:
        v_nd = -v_hat + np.sqrt(v_hat * v_hat - 2.0 * push + vb * vb + 2.0 * v_hat * vb)
        v_pd = max(v_nd, v_hat)
    elif vb < v_hat:
        # initial tension falls first; at v_hat the force is that of N = 0 whatever N is
        left = (v_hat - vb) ** 2 - 2.0 * push
        v_nd, v_pd = v_hat - np.sqrt(max(left, 0.0)), v_hat
        N_b = max(-0.5 * q * left, 0.0)
    else:
        v_nd, v_pd, N_b = vb, vb, N0
    rest = (Np - N_b) / q
    v_c = v_hat + np.sqrt((v_pd - v_hat) ** 2 + 2.0 * rest)
    return F0, ke, vy, vb, v_nd, v_c


@njit(cache=True, error_model="numpy")
def cubic_curve(s, K, phi, kappa, Mp, Np, N0, c_ax):
    """Simplification 1: (n, starts (4,), coefficients (4, 4)); a reconstruction."""
    F0, ke, vy, vb, v_nd, v_c = simplified_points(s, K, phi, kappa, Mp, Np, N0, c_ax)
    starts, coefficients = np.array([0.0, vy, vb, v_c]), np.zeros((4, 4))
    coefficients[0, 1] = ke
    coefficients[1:, 0] = F0
    if v_c == np.inf:
        return 3, starts, coefficients
    x1, x2 = v_nd - vb, v_c - vb
    rise1, rise2 = np.sum(s) * Mp - F0, kappa * Np * v_c - F0
    c1, c3 = 0.0, rise2 / x2**3
    if x1 >= 1e-9:
        slope1, slope2 = rise1 / x1, rise2 / x2
        c3_both = (slope2 - slope1) / ((x2 - x1) * (x2 + x1))
        c1_both = slope1 - c3_both * x1 * x1
        if c1_both >= 0.0:
            c1, c3 = c1_both, c3_both
    coefficients[2, 1], coefficients[2, 3] = c1, c3
    coefficients[3, 0], coefficients[3, 1] = kappa * Np * v_c, kappa * Np
    return 4, starts, coefficients


@njit(cache=True, error_model="numpy")
def linear_curve(s, K, phi, kappa, Mp, Np, N0, c_ax):
    """Simplification 2: (n, starts (5,), coefficients (5, 4), axial (5, 3)); a choice."""
    F0, ke, vy, vb, _, v_c = simplified_points(s, K, phi, kappa, Mp, Np, N0, c_ax)
    starts, coefficients, axial = np.zeros(5), np.zeros((5, 4)), np.zeros((5, 3))
    F_plastic, r = np.sum(s) * Mp, Mp / Np
    coefficients[0, 1] = ke + kappa * N0
    starts[1], coefficients[1, 0], coefficients[1, 1] = vy, F0 + kappa * N0 * vy, kappa * N0
    axial[:2, 0] = N0
    if v_c == np.inf:
        return 2, starts, coefficients, axial
    rate = (Np - N0) / (v_c - vb)
    n, v, N = 2, vb, N0
    while True:
        sigma = -1.0 if N < 0.0 else 1.0
        starts[n] = v
        axial[n, 0], axial[n, 1] = N, rate
        coefficients[n, 0] = F_plastic - np.sum(s) * sigma * r * N + kappa * N * v
        coefficients[n, 1] = -np.sum(s) * sigma * r * rate + kappa * (N + rate * v)
        coefficients[n, 2] = kappa * rate
        n += 1
        if N >= 0.0:
            break
        v, N = v - N / rate, 0.0
    starts[n], axial[n, 0] = v_c, Np
    coefficients[n, 0], coefficients[n, 1] = kappa * Np * v_c, kappa * Np
    return n + 1, starts, coefficients, axial


@njit(cache=True, error_model="numpy")
def piece_of(table, v):
    """Index of the piece that holds v >= 0."""
    i = table.shape[0] - 1
    while i > 0 and v < table[i, START]:
        i -= 1
    return i


@njit(cache=True, error_model="numpy")
def force_in(table, i, x):
    """Force c0 + c1 x + c2 x^2 + c3 x^3 of piece i at x from its start."""
    return table[i, 0] + x * (table[i, 1] + x * (table[i, 2] + x * table[i, 3]))


@njit(cache=True, error_model="numpy")
def tangent_in(table, i, x):
    """Slope of piece i at x from its start."""
    return table[i, 1] + x * (2.0 * table[i, 2] + 3.0 * x * table[i, 3])


@njit(cache=True, error_model="numpy")
def steepest_in(table, i, x):
    """Largest slope of piece i from its start to x."""
    largest = max(table[i, 1], tangent_in(table, i, x))
    if table[i, 3] < 0.0:
        top = -table[i, 2] / (3.0 * table[i, 3])
        if 0.0 < top < x:
            largest = max(largest, tangent_in(table, i, top))
    return largest


@njit(cache=True, error_model="numpy")
def work_between(table, a, b):
    """Work of the force from a to b, 0 <= a <= b; Simpson's rule is exact for cubic pieces."""
    total, i = 0.0, piece_of(table, a)
    while True:
        start = table[i, START]
        last = i + 1 == table.shape[0] or b <= table[i + 1, START]
        end = b if last else table[i + 1, START]
        middle = force_in(table, i, 0.5 * (a + end) - start)
        ends = force_in(table, i, a - start) + force_in(table, i, end - start)
        total += (end - a) * (ends + 4.0 * middle) / 6.0
        if last:
            return total
        a = end
        i += 1


@njit(cache=True, error_model="numpy")
def tabulate(starts, coefficients):
    """Table (n, COLUMNS) of a curve from its starts (n,) and coefficients (n, 4)."""
    n = starts.size
    table = np.zeros((n, COLUMNS))
    table[:, :4] = coefficients
    table[:, START] = starts
    table[0, STEEPEST] = table[0, 1]
    for i in range(1, n):
        table[i, WORK] = table[i - 1, WORK] + work_between(table[:i], starts[i - 1], starts[i])
        slope = steepest_in(table, i - 1, starts[i] - starts[i - 1])
        table[i, STEEPEST] = max(table[i - 1, STEEPEST], slope)
    bound = max(table[n - 1, STEEPEST], table[n - 1, 1])
    if table[n - 1, 2] > 0.0 or table[n - 1, 3] > 0.0:
        bound = np.inf
    table[:, BOUND] = bound
    return table


@njit(cache=True, error_model="numpy")
def unloading_stiffness(table, v):
    """Steepest slope of the curve over [0, v]: the initial slope, unless the curve stiffens."""
    if table[0, BOUND] <= table[0, STEEPEST]:
        return table[0, STEEPEST]
    i = piece_of(table, v)
    return max(table[i, STEEPEST], steepest_in(table, i, v - table[i, START]))


@njit(cache=True, error_model="numpy")
def lost_at(table):
    """First displacement > 0 at which the force falls to zero (inf: it never does)."""
    n = table.shape[0]
    for i in range(n):
        start = table[i, START]
        end = (table[i + 1, START] if i + 1 < n else max(_FAR, 2.0 * start)) - start
        # the cubic is monotonic between the roots of its slope
        cuts = np.array([0.0, end, end, end])
        A, B, D = 3.0 * table[i, 3], 2.0 * table[i, 2], table[i, 1]
        square = B * B - 4.0 * A * D
        if square > 0.0 and (A != 0.0 or B != 0.0):
            q = -0.5 * (B + (np.sqrt(square) if B >= 0.0 else -np.sqrt(square)))
            one = q / A if A != 0.0 else np.inf
            two = D / q if q != 0.0 else 0.0
            cuts[1], cuts[2] = min(max(min(one, two), 0.0), end), min(max(max(one, two), 0.0), end)
        for j in range(3):
            low, high = cuts[j], cuts[j + 1]
            if high <= low or force_in(table, i, high) > 0.0:
                continue
            if force_in(table, i, low) <= 0.0 and start + low > 0.0:
                return start + low
            for _ in range(200):
                middle = 0.5 * (low + high)
                if middle <= low or middle >= high:
                    break
                if force_in(table, i, middle) > 0.0:
                    low = middle
                else:
                    high = middle
            return start + high
    return np.inf


@njit(cache=True, error_model="numpy")
def displacement_at(table, energy, limit):
    """Displacement at which the work reaches `energy` > 0; the force is positive below `limit`."""
    n, i = table.shape[0], 0
    while i + 1 < n and table[i + 1, START] < limit and table[i + 1, WORK] < energy:
        i += 1
    start, done = table[i, START], table[i, WORK]
    low, high = start, limit
    if i + 1 < n:
        high = min(table[i + 1, START], limit)
    elif limit == np.inf:
        high = max(2.0 * low, 1e-6)
        while done + work_between(table, start, high) < energy:
            low, high = high, 2.0 * high
            if high > 1e9:
                return np.inf
    v = 0.5 * (low + high)
    for _ in range(200):
        excess = done + work_between(table, start, v) - energy
        if excess > 0.0:
            high = v
        else:
            low = v
        force = force_in(table, i, v - start)
        new = v - excess / force if force > 0.0 else 0.5 * (low + high)
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - v) <= 4e-16 * v or new <= low or new >= high:
            return new
        v = new
    return v
