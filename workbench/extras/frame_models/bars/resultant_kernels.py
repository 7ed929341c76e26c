"""Sections known by N and M alone: a tangent modulus, then two surfaces; tangent and energies.

The outer, bounding surface B is the super-ellipse of the fully plastic section. The inner, yield
surface is r B about a centre a. Flow is normal to it; the centre moves towards the point s' of B
with the same normal, da = dmu ((1 - r) s' - a) for s = a + r s' (Mroz 1967), so that the surfaces
touch there and never cross. With the distance delta = n (s' - s) along the normal n, of which
n s' = 1, the plastic modulus is delta^2 / g. Backward Euler: s lies on (r + t (1 - r)) B about
(1 - t) a_0, and s and t in 0..1 are where the convex

    (s - s_tr) K^-1 (s - s_tr) / 2 + g (-t - ln(1 - t))

is least: the closest point at a given t, then one equation in q = t / (1 - t). The tangent is
symmetric. Before that, the modulus E min(1, (1 + 2 p) (1 - p - w m)), p = |N| / N_p and
m = |M| / M_p, acts on what N and M grow by beyond the largest so far; what lies within is elastic.
State (5, 2) of a section: plastic strain and curvature; N and M of the centre; N and M; largest M
and -M; largest |N|, and how far off the centre was when this yielding began, over the bounds.
Derivation and sources: docs/theory/frame-models.md.
"""

import math

import numpy as np

from workbench.base.compiled import njit
from workbench.steel.hinges.kernels import ANYWHERE, ELASTIC, newton_in_bracket, project

RESULTANT = np.dtype(
    [
        *((name, float) for name in ("axial", "bending", "squash", "moment", "alpha", "beta")),
        *((name, float) for name in ("beside", "inner", "lag", "minor")),
        ("softens", bool),
    ]
)
STATES = 5
ITERATIONS = 60
CLOSED = 1e-13  # of the terms that make the gap
LEAST_MODULUS = 1e-3
SAME = 1e-9  # of a force, that is not below another
FLAGS = 4  # N and M beyond their largest or not


@njit(cache=True, error_model="numpy", forceinline=True)
def modulus(p, rest):
    """Tangent modulus over E at p = |N| / N_p; `rest`, 1 - w m."""
    return max(min((1.0 + 2.0 * p) * (rest - p), 1.0), LEAST_MODULUS)


@njit(cache=True, error_model="numpy")
def on_surfaces(row, stiffness, trial, centre, lag):
    """Forces on or within the yield surface, and where it has moved to.

    Arguments: a row of RESULTANT; `stiffness` (N, N m2) and `trial` forces (N, N m); committed
    `centre`; `lag`, the g (J/m) of the plastic modulus. Result: N, M, tangent NN, NM, MM,
    the share t of its way that the centre has gone, whether the section yields.
    """
    k0, k1 = stiffness
    a0, a1 = centre
    apart = 1.0 - row.inner
    q, low, high, stop, z = 0.0, 0.0, -1.0, False, ANYWHERE
    for _ in range(ITERATIONS):
        left = 1.0 / (1.0 + q)
        size = row.inner + q * left * apart
        t0, t1 = trial[0] - left * a0, trial[1] - left * a1
        n_most, m_most = size * row.squash, size * row.moment
        branch, (n, m, _), (nn, nm, _, mm, _, _), z = project(
            (k0, k1, 0.0),
            (n_most, n_most, m_most, m_most),
            (row.alpha, row.beta),
            (t0, t1, 0.0),
            z,
        )
        if branch == ELASTIC and q == 0.0:
            return trial[0], trial[1], k0, 0.0, k1, 0.0, False
        # way to the bounding surface; flow times it; movement of the forces with t
        grow = apart / size
        y0, y1 = grow * n - a0, grow * m - a1
        gap0, gap1 = (t0 - n) / k0, (t1 - m) / k1
        pull = gap0 * y0 + gap1 * y1
        u0, u1 = (grow * t0 - a0) / k0, (grow * t1 - a1) / k1
        v0, v1 = y0 - nn * u0 - nm * u1, y1 - nm * u0 - mm * u1
        bend = v0 * y0 / k0 + v1 * y1 / k1 - grow * (gap0 * (v0 - y0) + gap1 * (v1 - y1))
        off = lag * q - pull
        if high < 0.0:
            high = pull / lag if lag > 0.0 else 0.0
        if stop or high <= 0.0 or abs(off) <= CLOSED * (lag * q + pull):
            break
        q, low, high, stop = newton_in_bracket(q, off, lag + bend * left * left, low, high)
    if lag > 0.0:
        by = 1.0 / (lag / (left * left) + bend)
        nn, nm, mm = nn + by * v0 * v0, nm + by * v0 * v1, mm + by * v1 * v1
    return n + left * a0, m + left * a1, nn, nm, mm, 1.0 - left, True


@njit(cache=True, error_model="numpy")
def resultant_response(row, strain, old, new):
    """N, M and tangent NN, NM, MM of a section at `strain` (2,): axial strain and curvature.

    Arguments: a row of RESULTANT; committed state `old` (5, 2). Writes the trial state `new`.
    """
    whole, elastic, most = np.array([row.axial, row.bending]), np.empty(2), np.empty(2)
    for i in range(2):
        elastic[i] = whole[i] * (strain[i] - old[0, i])
    most[0], most[1] = old[4, 0], old[3, 0] if elastic[1] >= 0.0 else old[3, 1]
    share = 1.0
    if row.softens:
        share = modulus(abs(old[2, 0]) / row.squash, 1.0 - row.minor * abs(old[2, 1]) / row.moment)
    off = 1.0 + old[4, 1] / (1.0 - row.inner) if row.inner < 1.0 else 1.0
    lag, centre = row.lag * off * off, (old[1, 0], old[1, 1])
    k, trial, soft = whole.copy(), elastic.copy(), np.abs(elastic) >= (1.0 - SAME) * most
    for _ in range(FLAGS):
        for i in range(2):
            k[i], trial[i] = whole[i], elastic[i]
            if soft[i]:
                beyond = math.copysign(1.0, elastic[i]) * (abs(elastic[i]) - most[i])
                k[i], trial[i] = share * whole[i], elastic[i] - (1.0 - share) * beyond
        n, m, nn, nm, mm, moved, yields = on_surfaces(
            row, (k[0], k[1]), (trial[0], trial[1]), centre, lag
        )
        # what flow brings back to the largest force so far is elastic after all
        on0, on1 = abs(n) >= (1.0 - SAME) * most[0], abs(m) >= (1.0 - SAME) * most[1]
        if share == 1.0 or (on0 == soft[0] and on1 == soft[1]):
            break
        soft[0], soft[1] = on0, on1
    new[:] = old
    new[0, 0], new[0, 1] = strain[0] - n / row.axial, strain[1] - m / row.bending
    new[2, 0], new[2, 1] = n, m
    new[3, 0], new[3, 1] = max(old[3, 0], m), max(old[3, 1], -m)
    new[4, 0] = max(old[4, 0], abs(n))
    if yields:
        # s = (1 - t) a + (r + t (1 - r)) s', and s' is where the centre goes
        way = moved * (1.0 - row.inner) / (row.inner + moved * (1.0 - row.inner))
        for i, force in ((0, n), (1, m)):
            kept = (1.0 - moved) * old[1, i]
            new[1, i] = kept + way * (force - kept)
    else:
        away = abs(old[1, 0]) / row.squash + abs(old[1, 1]) / row.moment
        new[4, 1] = min(away, 1.0 - row.inner)
    rest = 1.0 - row.beside
    return (
        rest * n + row.beside * row.axial * strain[0],
        rest * m + row.beside * row.bending * strain[1],
        rest * nn + row.beside * row.axial,
        rest * nm,
        rest * mm + row.beside * row.bending,
    )


@njit(cache=True, error_model="numpy")
def resultant_energies(row, weight, dx, before, after, old, new):
    """Energies of a piece `dx` (m) of a beam in a step, in J, as of `section_energies`.

    The last is the plastic work of the forces at the end. Work that moves the inner surface counts
    as plastic.
    """
    stored = plastic = algorithmic = ideal = 0.0
    for i, stiffness in ((0, row.axial), (1, row.bending)):
        change = after[i] - before[i]
        flow, force = new[0, i] - old[0, i], (1.0 - row.beside) * new[2, i]
        last, beside = (1.0 - row.beside) * old[2, i], row.beside * stiffness
        elastic = (1.0 - row.beside) * stiffness * (change - flow) ** 2 + beside * change**2
        stored += 0.5 * dx * (force * new[2, i] / stiffness + beside * after[i] ** 2)
        plastic += dx * ((1.0 - weight) * last + weight * force) * flow
        algorithmic += (weight - 0.5) * dx * elastic
        ideal += dx * force * flow
    return stored, plastic, algorithmic, ideal
