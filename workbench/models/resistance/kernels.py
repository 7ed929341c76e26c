"""Piecewise cubic curves of force over displacement: evaluation, work, inversion.

A curve is an array of PIECE with rising starts; the force of a piece is c0 + c1 x + c2 x^2 +
c3 x^3 in x = v - start, and the last piece has no end.
"""

import numpy as np

from workbench.base.compiled import njit

PIECE = np.dtype(
    [
        ("start", float),  # displacement, m
        ("c", float, 4),  # coefficients of the force
        ("work", float),  # up to the start, J
        ("steepest", float),  # slope up to the start, N/m
        ("bound", float),  # of all slopes of the curve, N/m
        ("axial", float, 3),  # coefficients of the axial force
        ("event", int),  # with which the piece begins
        ("group", int),  # of hinges to which that happens
        ("plastic", np.int8, 3),  # whether a group is plastic
    ]
)
_FAR = 1e3  # m, beyond any displacement that a model may reach


@njit(cache=True, error_model="numpy")
def roots(a0, a1, a2):
    """Roots of a0 + a1 x + a2 x^2 without cancellation (inf, or zero: there is none)."""
    square = a1 * a1 - 4.0 * a0 * a2
    if square < 0.0:
        return np.inf, np.inf
    q = -0.5 * (a1 + (np.sqrt(square) if a1 >= 0.0 else -np.sqrt(square)))
    return q / a2 if a2 != 0.0 else np.inf, a0 / q if q != 0.0 else 0.0


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
    one, two = roots(a0, a1, a2)
    best = one if one > 0.0 else np.inf
    return two if 0.0 < two < best else best


@njit(cache=True, error_model="numpy")
def piece_of(pieces, v):
    """Index of the piece that holds v >= 0."""
    i = pieces.size - 1
    while i > 0 and v < pieces[i].start:
        i -= 1
    return i


@njit(cache=True, error_model="numpy")
def force_in(piece, x):
    """Force of a piece at x from its start."""
    c = piece.c
    return c[0] + x * (c[1] + x * (c[2] + x * c[3]))


@njit(cache=True, error_model="numpy")
def tangent_in(piece, x):
    """Slope of a piece at x from its start."""
    c = piece.c
    return c[1] + x * (2.0 * c[2] + 3.0 * x * c[3])


@njit(cache=True, error_model="numpy")
def on_curve(pieces, v):
    """Force and slope at v >= 0."""
    piece = pieces[piece_of(pieces, v)]
    x = v - piece.start
    return force_in(piece, x), tangent_in(piece, x)


@njit(cache=True, error_model="numpy")
def steepest_in(piece, x):
    """Largest slope of a piece from its start to x."""
    c = piece.c
    largest = max(c[1], tangent_in(piece, x))
    if c[3] < 0.0:
        top = -c[2] / (3.0 * c[3])
        if 0.0 < top < x:
            largest = max(largest, tangent_in(piece, top))
    return largest


@njit(cache=True, error_model="numpy")
def work_between(pieces, a, b):
    """Work of the force from a to b, 0 <= a <= b; Simpson's rule is exact for cubic pieces."""
    total, i = 0.0, piece_of(pieces, a)
    while True:
        piece, start = pieces[i], pieces[i].start
        last = i + 1 == pieces.size or b <= pieces[i + 1].start
        end = b if last else pieces[i + 1].start
        middle = force_in(piece, 0.5 * (a + end) - start)
        ends = force_in(piece, a - start) + force_in(piece, end - start)
        total += (end - a) * (ends + 4.0 * middle) / 6.0
        if last:
            return total
        a = end
        i += 1


@njit(cache=True, error_model="numpy")
def sum_up(pieces):
    """Write work and slopes of a curve from its starts and coefficients."""
    n = pieces.size
    pieces[0].steepest = pieces[0].c[1]
    for i in range(1, n):
        old, new = pieces[i - 1], pieces[i]
        new.work = old.work + work_between(pieces[:i], old.start, new.start)
        new.steepest = max(old.steepest, steepest_in(old, new.start - old.start))
    last = pieces[n - 1]
    stiffens = last.c[2] > 0.0 or last.c[3] > 0.0
    bound = np.inf if stiffens else max(last.steepest, last.c[1])
    for i in range(n):
        pieces[i].bound = bound


@njit(cache=True, error_model="numpy")
def unloading_stiffness(pieces, v):
    """Steepest slope of the curve over [0, v]: the initial slope, unless the curve stiffens."""
    if pieces[0].bound <= pieces[0].steepest:
        return pieces[0].steepest
    piece = pieces[piece_of(pieces, v)]
    return max(piece.steepest, steepest_in(piece, v - piece.start))


@njit(cache=True, error_model="numpy")
def residual(pieces, elastic_limit, v):
    """Displacement (m) that is left after unloading from v."""
    if v <= elastic_limit:
        return 0.0
    return v - on_curve(pieces, v)[0] / unloading_stiffness(pieces, v)


@njit(cache=True, error_model="numpy")
def lost_at(pieces):
    """First displacement > 0 at which the force falls to zero (inf: it never does)."""
    n = pieces.size
    for i in range(n):
        piece, start, c = pieces[i], pieces[i].start, pieces[i].c
        end = (pieces[i + 1].start if i + 1 < n else max(_FAR, 2.0 * start)) - start
        # the cubic is monotonic between the roots of its slope
        one, two = roots(c[1], 2.0 * c[2], 3.0 * c[3])
        inner = min(max(min(one, two), 0.0), end), min(max(max(one, two), 0.0), end)
        low = 0.0
        for high in (inner[0], inner[1], end):
            if high <= low or force_in(piece, high) > 0.0:
                low = max(low, high)
                continue
            if force_in(piece, low) <= 0.0 and start + low > 0.0:
                return start + low
            for _ in range(200):
                middle = 0.5 * (low + high)
                if middle <= low or middle >= high:
                    break
                if force_in(piece, middle) > 0.0:
                    low = middle
                else:
                    high = middle
            return start + high
    return np.inf


@njit(cache=True, error_model="numpy")
def displacement_at(pieces, energy, limit):
    """Displacement at which the work reaches `energy` > 0; the force is positive below `limit`."""
    n, i = pieces.size, 0
    while i + 1 < n and pieces[i + 1].start < limit and pieces[i + 1].work < energy:
        i += 1
    piece, start, done = pieces[i], pieces[i].start, pieces[i].work
    low, high = start, limit
    if i + 1 < n:
        high = min(pieces[i + 1].start, limit)
    elif limit == np.inf:
        high = max(2.0 * low, 1e-6)
        while done + work_between(pieces, start, high) < energy:
            low, high = high, 2.0 * high
            if high > 1e9:
                return np.inf
    v = 0.5 * (low + high)
    for _ in range(200):
        excess = done + work_between(pieces, start, v) - energy
        if excess > 0.0:
            high = v
        else:
            low = v
        force = force_in(piece, v - start)
        new = v - excess / force if force > 0.0 else 0.5 * (low + high)
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - v) <= 4e-16 * v or new <= low or new >= high:
            return new
        v = new
    return v
