"""Beam-column between two plastic hinges of zero length: local law and assembly.

Unknown are the forces Q = (N, M_1, M_4). At a given N the moments solve a problem of
complementarity in two unknowns, in closed form (`moments_in_box`); what is left,

    N L / EA + M F'(N) M / 2 + sum |dm_h / dN| |r_h| sign N = elongation - plastic elongation,

rises with N, the last term being the normal plastic flow that goes with the rotations r_h. Moment
capacities are polylines over |N|, so that N lies on one of their corners or between two of them.
Tangent: elastic and geometric stiffness less the plastic reduction matrix of the hinges that flow,
K a a^T K / (a^T K a + h), one after the other. Source: Orbison, McGuire and Abel 1982; the
implicit form is derived in docs/theory/frame-models.md.

Hinges may wear: of their strength a share exp(-W / M_p Lambda) is left, W / M_p the work of bending
over the moment that they still have, which is 1 - E / E_t, E their dissipated energy and E_t =
M_p Lambda (Rahnama and Krawinkler 1993, exponent 1); the moments of a step meet what the steps
before have left.
"""

import math
from typing import NamedTuple

import numpy as np

from workbench.base.compiled import njit
from workbench.extras.frame_models.bars.beam_kernels import modes
from workbench.mechanics.structures.kernels import add_element, deform
from workbench.steel.hinges.kernels import newton_in_bracket
from workbench.steel.hinges.panel_kernels import End, moments_in_box

ITERATIONS = 60
GRADUAL = 60  # iterations of gradual hinges
SETTLED = 1e-12  # change of a plastic rotation over those of the chord
CLOSED = 1e-14  # of the terms that make the gap
LEAST = 1e-6  # of the strength of a worn hinge, which then is a pin


class Flow(NamedTuple):
    """Flow at an axial force: the `gap` of the elongation, and the values that make it.

    Moments, plastic rotations r, bending elongation `bow` and `push` of both hinges (slope of the
    capacity by N times |r|), slopes `a1`, `a4` of the yield conditions by N.
    """

    gap: float
    m1: float
    m4: float
    r1: float
    r4: float
    push: float
    a1: float
    a4: float


@njit(cache=True, error_model="numpy", forceinline=True)
def flexibility(bar, N):
    """f_11, f_14, f_44 of beam and springs at N, their first and their second derivatives by N."""
    (a, a1, a2), (b, b1, b2) = modes(-bar.geometric * N)
    half, by, s = 0.25 * bar.bending, -bar.geometric, bar.shear
    one, two = half * by, half * by * by
    near, far = half * (a + b) + s, half * (b - a) + s
    values = near + bar.spring1, far, near + bar.spring4
    return values, (one * (a1 + b1), one * (b1 - a1)), (two * (a2 + b2), two * (b2 - a2))


@njit(cache=True, error_model="numpy", forceinline=True)
def form(pair, m1, m4):
    """Half the quadratic form of a matrix (p, q; q, p), and its product with (m1, m4)."""
    first, last = pair[0] * m1 + pair[1] * m4, pair[1] * m1 + pair[0] * m4
    return 0.5 * (m1 * first + m4 * last), first, last


@njit(cache=True, error_model="numpy")
def flow_at(bar, trial, back, hard, N, share, slope):
    """The `Flow` at an axial force N, capacities at `share` (2,) with `slope` (2,) by |N|."""
    (f11, f14, f44), first, _ = flexibility(bar, N)
    # kinematic hardening h: M = X + m + h r leaves (F^-1 + h)^-1 m + r = (1 + F h)^-1 (e - F X)
    h1, h4 = hard
    e1 = trial[1] - f11 * back[0] - f14 * back[1]
    e4 = trial[2] - f14 * back[0] - f44 * back[1]
    s1, s4 = 1.0 + f11 * h1, 1.0 + f44 * h4
    det = s1 * s4 - f14 * f14 * h1 * h4
    g11, g14, g44 = (s4 * f11 - f14 * f14 * h4) / det, f14 / det, (s1 * f44 - f14 * f14 * h1) / det
    e1, e4 = (s4 * e1 - f14 * h4 * e4) / det, (s1 * e4 - f14 * h1 * e1) / det
    one = End(0.0, bar.low1, bar.high1, 1.0, 1.0, bar.pinned1, g11, e1)
    four = End(0.0, bar.low4, bar.high4, 1.0, 1.0, bar.pinned4, g44, e4)
    m1, m4, r1, r4, _, _ = moments_in_box(one, four, g14, share[0], share[1])
    m1 += back[0] + h1 * r1
    m4 += back[1] + h4 * r4
    sign = math.copysign(1.0, N)
    a1 = a4 = 0.0
    if r1 != 0.0 and not bar.pinned1:
        a1 = -sign * slope[0] * (bar.high1 if r1 > 0.0 else -bar.low1)
    if r4 != 0.0 and not bar.pinned4:
        a4 = -sign * slope[1] * (bar.high4 if r4 > 0.0 else -bar.low4)
    push = a1 * abs(r1) + a4 * abs(r4)
    bow, _, _ = form(first, m1, m4)
    return Flow(N * bar.axial + bow + push - trial[0], m1, m4, r1, r4, push, a1, a4)


@njit(cache=True, error_model="numpy")
def reduce(k, direction, normal, hardening):
    """Take from the stiffness `k` (3, 3) what a hinge that flows in a `direction` (3,) gives way.

    `normal` (3,), the gradient of its yield condition.
    """
    along, across = k @ direction, normal @ k
    size = normal @ along + hardening
    if size > 0.0:
        for i in range(3):
            for j in range(3):
                k[i, j] -= along[i] * across[j] / size


@njit(cache=True, error_model="numpy")
def tangent(bar, N, flow, hard, turn, fixed, k):
    """Write the tangent `k` (3, 3) at N; `fixed`: N is at a corner of the yield surface.

    `turn` (2,): what the normals turn by as the hinges harden, see `hinged_law`.
    """
    (f11, f14, f44), first, second = flexibility(bar, N)
    bent, _, _ = form(second, flow.m1, flow.m4)
    _, d1, d4 = form(first, flow.m1, flow.m4)
    det = f11 * f44 - f14 * f14
    k[1, 1], k[2, 2] = f44 / det, f11 / det
    k[1, 2] = k[2, 1] = -f14 / det
    u1, u4 = k[1, 1] * d1 + k[1, 2] * d4, k[2, 1] * d1 + k[2, 2] * d4
    k[0, 0] = 1.0 / (bar.axial + bent - d1 * u1 - d4 * u4)
    k[0, 1] = k[1, 0] = -k[0, 0] * u1
    k[0, 2] = k[2, 0] = -k[0, 0] * u4
    k[1, 1] += k[0, 0] * u1 * u1
    k[2, 2] += k[0, 0] * u4 * u4
    k[1, 2] += k[0, 0] * u1 * u4
    k[2, 1] = k[1, 2]
    direction, normal = np.zeros(3), np.zeros(3)
    if bar.pinned1 or flow.r1 != 0.0:
        normal[0], normal[1] = flow.a1, math.copysign(1.0, flow.r1)
        direction[:] = normal
        direction[0] += turn[0]
        reduce(k, direction, normal, hard[0])
    if bar.pinned4 or flow.r4 != 0.0:
        normal[0], normal[1], normal[2] = flow.a4, 0.0, math.copysign(1.0, flow.r4)
        direction[:] = normal
        direction[0] += turn[1]
        reduce(k, direction, normal, hard[1])
    if fixed:
        normal[0], normal[1], normal[2] = 1.0, 0.0, 0.0
        reduce(k, normal, normal, 0.0)


@njit(cache=True, error_model="numpy")
def hinged_law(bar, corners, counts, trial, back, hard, turn, k, flow):
    """Forces of a beam-column and its hinges, for its trial deformations.

    Arguments: `bar`, a row of BAR; `corners` (2, corners, 3), |N| in tension and in compression
    with the shares of both moments left there, and `counts` (2,) of these; elastic `trial`
    deformations (3,); backstresses `back` and hardening `hard` (2,); `turn` (2,), by how much more
    elongation (m/rad) comes with a rotation as hardening turns the surface. Writes the tangent `k`
    (3, 3) and the plastic `flow` (3,); result: N, M_1, M_4.
    """
    rest = flow_at(bar, trial, back, hard, 0.0, corners[0, 0, 1:], np.zeros(2))
    side = 0 if rest.gap < 0.0 else 1
    sign = 1.0 if side == 0 else -1.0
    line = corners[side, : counts[side]]
    last = line.shape[0] - 1
    slopes = (line[1, 1:] - line[0, 1:]) / line[1, 0]
    N, fixed, done = 0.0, False, flow_at(bar, trial, back, hard, 0.0, line[0, 1:], slopes)
    still = np.zeros(2)
    if done.push > 0.0 and abs(rest.gap) <= done.push:
        fixed = True
    else:
        low, high = 0, last  # the first corner at or beyond the root is in (low, high]
        beyond = False
        while high - low > 1:
            middle = (low + high) // 2
            if left_of(bar, trial, back, hard, line, middle, sign) >= 0.0:
                high, beyond = middle, True
            else:
                low = middle
        if not beyond and left_of(bar, trial, back, hard, line, last, sign) < 0.0:
            N, fixed = sign * line[last, 0], True
            slopes = (line[last, 1:] - line[last - 1, 1:]) / (line[last, 0] - line[last - 1, 0])
            done = flow_at(bar, trial, back, hard, N, line[last, 1:], slopes)
        else:
            width = line[high, 0] - line[low, 0]
            slopes = (line[high, 1:] - line[low, 1:]) / width
            a, b = line[low, 0], line[high, 0]
            N = sign * a
            done = flow_at(bar, trial, back, hard, N, line[low, 1:], slopes)
            if low > 0 and sign * done.gap > 0.0:
                fixed = True
            else:
                N = min(max(abs(trial[0]) / bar.axial, a), b)
                stop = False
                for _ in range(ITERATIONS):
                    share = line[low, 1:] + slopes * (N - line[low, 0])
                    done = flow_at(bar, trial, back, hard, sign * N, share, slopes)
                    size = N * bar.axial + done.push + abs(trial[0])
                    if stop or abs(done.gap) <= CLOSED * size:
                        break
                    tangent(bar, sign * N, done, hard, still, False, k)
                    N, a, b, stop = newton_in_bracket(N, sign * done.gap, 1.0 / k[0, 0], a, b)
                N *= sign
    tangent(bar, N, done, hard, turn, fixed, k)
    flow[0] = done.push - done.gap if fixed else done.push
    flow[1], flow[2] = done.r1, done.r4
    return N, done.m1, done.m4


@njit(cache=True, error_model="numpy")
def left_of(bar, trial, back, hard, line, at, sign):
    """Gap of the elongation along the sign of N at a corner, seen from smaller |N|."""
    slopes = (line[at, 1:] - line[at - 1, 1:]) / (line[at, 0] - line[at - 1, 0])
    return sign * flow_at(bar, trial, back, hard, sign * line[at, 0], line[at, 1:], slopes).gap


@njit(cache=True, error_model="numpy", forceinline=True)
def hardened(curve, rotation):
    """Hardened share at an accumulated plastic rotation along `curve` (2, points), its slope."""
    last = curve.shape[1] - 1
    if rotation >= curve[0, last]:
        return 1.0, 0.0
    at = np.searchsorted(curve[0], rotation, "right") - 1
    slope = (curve[1, at + 1] - curve[1, at]) / (curve[0, at + 1] - curve[0, at])
    return curve[1, at] + slope * (rotation - curve[0, at]), slope


@njit(cache=True, error_model="numpy")
def gradual_law(bar, tables, e, trial, spread, k, flow):
    """`hinged_law` of hinges that harden from first yield to the full surface, isotropically.

    Arguments: `bar`, its row of BAR as worn; plastic rotations `spread` (2,) accumulated so far.
    The surface is that at the end of the step: Newton's iteration on the rotations r, in which the
    law itself solves for hinges that harden in proportion from where the last r has brought them,
    M = c + h (r - r_last). As hardening slows down, r rises to the solution from below, in 13 steps
    at most of 40 000 cases.
    """
    counts = tables.counts[e]
    full, first = tables.corners[e], tables.first[e]
    surface, turned = full.copy(), np.zeros(2)
    hard, turn = np.empty(2), np.empty(2)
    N = trial[0] / bar.axial
    for count in range(GRADUAL):
        side = 0 if N >= 0.0 else 1
        line = full[side, : counts[side]]
        at = min(max(np.searchsorted(line[:, 0], abs(N)), 1), len(line) - 1)
        for i in range(2):
            r, (low, high) = turned[i], (bar.low1, bar.high1) if i == 0 else (bar.low4, bar.high4)
            level, slope = hardened(tables.curves[e, i], spread[i] + abs(r))
            if bar.pinned1 if i == 0 else bar.pinned4:
                slope = 0.0
            slope *= -low if r < 0.0 else high
            room = line[:, 1 + i] - first[side, : len(line), i]
            rise = (room[at] - room[at - 1]) / (line[at, 0] - line[at - 1, 0])
            hard[i] = max(room[at] + rise * (abs(N) - line[at, 0]), 0.0) * slope
            turn[i] = -math.copysign(1.0, N) * rise * slope * abs(r)
            surface[:, :, 1 + i] = first[:, :, i] + level * (full[:, :, 1 + i] - first[:, :, i])
        N, m1, m4 = hinged_law(bar, surface, counts, trial, -hard * turned, hard, turn, k, flow)
        off = max(abs(flow[1] - turned[0]), abs(flow[2] - turned[1]))
        if off <= SETTLED * (abs(trial[1]) + abs(trial[2])):
            return N, m1, m4
        turned += (flow[1:] - turned) if count < GRADUAL // 2 else 0.5 * (flow[1:] - turned)
    return math.nan, m1, m4  # no state to go on from: a shorter step may have one


@njit(cache=True, error_model="numpy")
def elastic(rows, local, deformation, stored):
    """Write elastic deformations (e, 3) under the forces `local` (e, 3), and energies (e,) in J."""
    for e in range(rows.shape[0]):
        bar = rows[e]
        N, m1, m4 = local[e]
        (f11, f14, f44), first, _ = flexibility(bar, N)
        bow, _, _ = form(first, m1, m4)
        turn1, turn4 = f11 * m1 + f14 * m4, f14 * m1 + f44 * m4
        deformation[e, 0] = N * bar.axial + bow
        deformation[e, 1] = turn1
        deformation[e, 2] = turn4
        stored[e] = N * (0.5 * N * bar.axial + bow) + 0.5 * (m1 * turn1 + m4 * turn4)


@njit(cache=True, error_model="numpy", forceinline=True)
def worn(tables, e, left, rows):
    """Row of BAR of an element whose hinges have shares `left` (2,) of their strength.

    Their elastic flexibility has grown by softness (1 / left - 1). `rows` (1,), where it is put.
    """
    rows[0] = tables.rows[e]
    bar = rows[0]
    bar.low1 *= left[0]
    bar.high1 *= left[0]
    bar.low4 *= left[1]
    bar.high4 *= left[1]
    bar.spring1 += tables.softness[e, 0] * (1.0 / left[0] - 1.0)
    bar.spring4 += tables.softness[e, 1] * (1.0 / left[1] - 1.0)
    return bar


@njit(cache=True, error_model="numpy", forceinline=True)
def remains(left, moment, turned, low, high, rotation):
    """Share of its strength that is left to a hinge after a plastic rotation at a moment."""
    if moment * turned == 0.0:
        return left
    spent = abs(moment * turned) / (high if moment > 0.0 else -low)
    return max(left * math.exp(-spent / rotation), LEAST)


@njit(cache=True, error_model="numpy")
def assemble(step, bars, tables, old, new):
    """Add forces and tangents of all elements for a `step`; write the state `new`."""
    k, work = np.empty((3, 3)), np.empty((7, 4))
    trial, flow, hard, none = np.empty(3), np.empty(3), np.empty(2), np.zeros(2)
    eta, rows = tables.eta, tables.rows[:1].copy()
    for e in range(bars.dofs.shape[0]):
        left, deformation = old.left[e], new.deformation[e]
        bar = worn(tables, e, left, rows)
        chord = deform(bars, e, step.end, deformation)
        trial[:] = deformation - old.plastic[e]
        if tables.gradual:
            N, m1, m4 = gradual_law(bar, tables, e, trial, old.spread[e], k, flow)
        else:
            hard[0], hard[1] = bar.hardening1, bar.hardening4
            corners, counts = tables.corners[e], tables.counts[e]
            N, m1, m4 = hinged_law(bar, corners, counts, trial, old.back[e], hard, none, k, flow)
            new.back[e] = old.back[e] + hard * flow[1:]
        new.spread[e] = old.spread[e] + np.abs(flow[1:])
        over = tables.rotation[e]
        new.strength[e] = left
        new.left[e, 0] = remains(left[0], m1, flow[1], bar.low1, bar.high1, over[0])
        new.left[e, 1] = remains(left[1], m4, flow[2], bar.low4, bar.high4, over[1])
        new.plastic[e] = old.plastic[e] + flow
        linear = eta * tables.stiffness[e]
        local = linear @ deformation
        local[0] += (1.0 - eta) * N
        local[1] += (1.0 - eta) * m1
        local[2] += (1.0 - eta) * m4
        new.local[e] = local
        k *= 1.0 - eta
        k += linear
        add_element(step, bars, e, chord, old.local[e], new.local[e], k, work)
