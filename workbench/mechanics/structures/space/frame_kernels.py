"""The co-rotational frame of a two-node element in space, shared by every local law.

Deformations d = (l - L, theta_1, theta_2): elongation of the chord and the rotation vectors of both
nodes against the element frame, seven numbers; conjugate forces Q = (N, M_1, M_2). The frame has
r1 along the chord, and r2 next to the mean of the second axes of both nodes. Motions m = (x_1,
spin_1, x_2, spin_2), twelve; B = dd/dm and the geometric part d(B'Q)/dm are closed forms.

Time step: nodes turn by R_1 = cay(psi) R_0 with omega_0 + omega_1 = 2 psi / dt. The force of a step
is B'Q at its middle (mean place, half the rotation) plus what is missing to the exact work, along
the part of the step that is no rigid motion: energy, momentum and angular momentum are exact.

Triads (3, 3) have their axes as columns. Vectors are in element axes unless said.
Sources: Battini and Pacoste 2002 (frame); Simo and Tarnow 1992, Gonzalez 1996 (discrete gradient).
"""

import math
from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit
from workbench.mechanics.structures.kernels import copy

SMALL = 1e-2  # rad; below it the coefficients of the inverse tangent map are taken from series
LEAST_GAP = 1e-13  # strain of a step times its turn squared, below which rounding is all there is


class SpaceFrame(NamedTuple):
    """An element's frame and deformations at one place, as `take_frame` writes it.

    `axes` (3, 3), r1 to r3 as columns; chord length and 1 / q_y in `sizes` (2,); deformations `d`
    (7,); triads of the nodes against the frame, `turned` (2, 3, 3), with second axes `q` (2, 3);
    inverse tangent maps `inverse` (2, 3, 3); spin of the frame `spin` (3, 12) and of the nodes
    against it `against` (2, 3, 12) per motion; `B` (7, 12) per motion in global axes.
    """

    axes: Array
    sizes: Array
    d: Array
    turned: Array
    q: Array
    inverse: Array
    spin: Array
    against: Array
    B: Array


@njit(cache=True, error_model="numpy")
def empty_frame():
    """A frame to write into."""
    return SpaceFrame(
        np.zeros((3, 3)), np.zeros(2), np.zeros(7), np.zeros((2, 3, 3)), np.zeros((2, 3)),
        np.zeros((2, 3, 3)), np.zeros((3, 12)), np.zeros((2, 3, 12)), np.zeros((7, 12)),
    )  # fmt: skip


@njit(cache=True, error_model="numpy", forceinline=True)
def cross(a, b, result):
    """Vector product of a and b."""
    result[0] = a[1] * b[2] - a[2] * b[1]
    result[1] = a[2] * b[0] - a[0] * b[2]
    result[2] = a[0] * b[1] - a[1] * b[0]


@njit(cache=True, error_model="numpy")
def turn(psi, share, triad, result):
    """Triad turned by the Cayley map of `share` times `psi`."""
    x, y, z = share * psi[0], share * psi[1], share * psi[2]
    a = 1.0 / (1.0 + 0.25 * (x * x + y * y + z * z))
    for j in range(3):
        p, q, r = triad[0, j], triad[1, j], triad[2, j]
        u, v, w = y * r - z * q, z * p - x * r, x * q - y * p
        result[0, j] = p + a * (u + 0.5 * (y * w - z * v))
        result[1, j] = q + a * (v + 0.5 * (z * u - x * w))
        result[2, j] = r + a * (w + 0.5 * (x * v - y * u))


@njit(cache=True, error_model="numpy", forceinline=True)
def half_share(psi):
    """Share of `psi` that is half of its rotation: 1 / (1 + sqrt(1 + |psi|^2 / 4))."""
    return 1.0 / (
        1.0 + math.sqrt(1.0 + 0.25 * (psi[0] * psi[0] + psi[1] * psi[1] + psi[2] * psi[2]))
    )


@njit(cache=True, error_model="numpy")
def spin_map(psi, share, result):
    """Derivative (3, 3) of the spin of the Cayley map with respect to its vector.

    Of the whole `psi` (share 1), or of half its rotation with `share` = `half_share(psi)`.
    """
    square = psi[0] * psi[0] + psi[1] * psi[1] + psi[2] * psi[2]
    root = math.sqrt(1.0 + 0.25 * square)
    # d(share psi) = share d(psi) - psi (psi . d(psi)) share^2 / (4 root) for the half; and
    # spin = (v + psi x v / 2) / (1 + |psi|^2 / 4) for a change v of psi
    slope = 0.0 if share == 1.0 else share * share / (4.0 * root)
    x, y, z = share * psi[0], share * psi[1], share * psi[2]
    a = 1.0 / (1.0 + 0.25 * (x * x + y * y + z * z))
    for j in range(3):
        p, q, r = -slope * psi[0] * psi[j], -slope * psi[1] * psi[j], -slope * psi[2] * psi[j]
        if j == 0:
            p += share
        elif j == 1:
            q += share
        else:
            r += share
        result[0, j] = a * (p + 0.5 * (y * r - z * q))
        result[1, j] = a * (q + 0.5 * (z * p - x * r))
        result[2, j] = a * (r + 0.5 * (x * q - y * p))


@njit(cache=True, error_model="numpy", forceinline=True)
def tangent_numbers(angle):
    """Factor eta of the inverse tangent map 1 - hat / 2 + eta hat^2, and eta' / angle."""
    s = angle * angle
    if angle < SMALL:
        eta = 1.0 / 12.0 + s * (1.0 / 720.0 + s * (1.0 / 30240.0 + s / 1209600.0))
        return eta, 1.0 / 360.0 + s * (1.0 / 7560.0 + s / 201600.0)
    half = 0.5 * angle
    sine, cosine = math.sin(half), math.cos(half)
    eta = (1.0 - half * cosine / sine) / s
    slope = (-2.0 / s + 0.5 * cosine / (sine * angle) + 0.25 / (sine * sine)) / s
    return eta, slope


@njit(cache=True, error_model="numpy")
def take_frame(chord, initial, length, first, second, frame):
    """Write the `frame` of an element, its deformations and B.

    Arguments: present and `initial` chord (3,) and initial `length` in m; triads of both nodes.
    """
    R, q, d, W, B = frame.axes, frame.q, frame.d, frame.spin, frame.B
    long = math.sqrt(chord[0] ** 2 + chord[1] ** 2 + chord[2] ** 2)
    stretch = 0.0
    for k in range(3):
        R[k, 0] = chord[k] / long
        R[k, 1] = 0.5 * (first[k, 1] + second[k, 1])
        stretch += (chord[k] - initial[k]) * (chord[k] + initial[k])
    d[0] = stretch / (long + length)
    cross(R[:, 0], R[:, 1], R[:, 2])
    size = math.sqrt(R[0, 2] ** 2 + R[1, 2] ** 2 + R[2, 2] ** 2)
    for k in range(3):
        R[k, 2] /= size
    cross(R[:, 2], R[:, 0], R[:, 1])
    for node in range(2):
        triad, t = first if node == 0 else second, frame.turned[node]
        for i in range(3):
            for j in range(3):
                t[i, j] = R[0, i] * triad[0, j] + R[1, i] * triad[1, j] + R[2, i] * triad[2, j]
            q[node, i] = t[i, 1]
        x, y, z = 0.5 * (t[2, 1] - t[1, 2]), 0.5 * (t[0, 2] - t[2, 0]), 0.5 * (t[1, 0] - t[0, 1])
        sine = math.sqrt(x * x + y * y + z * z)
        angle = math.atan2(sine, 0.5 * (t[0, 0] + t[1, 1] + t[2, 2] - 1.0))
        share = angle / sine if sine > 1e-9 else 1.0
        x, y, z = share * x, share * y, share * z
        d[1 + 3 * node], d[2 + 3 * node], d[3 + 3 * node] = x, y, z
        eta, _ = tangent_numbers(angle)
        inverse, square = frame.inverse[node], angle * angle
        inverse[0, 0] = 1.0 + eta * (x * x - square)
        inverse[1, 1] = 1.0 + eta * (y * y - square)
        inverse[2, 2] = 1.0 + eta * (z * z - square)
        inverse[0, 1], inverse[1, 0] = eta * x * y + 0.5 * z, eta * x * y - 0.5 * z
        inverse[0, 2], inverse[2, 0] = eta * x * z - 0.5 * y, eta * x * z + 0.5 * y
        inverse[1, 2], inverse[2, 1] = eta * y * z + 0.5 * x, eta * y * z - 0.5 * x
    mean = 0.5 * (q[0, 0] + q[1, 0]), 0.5 * (q[0, 1] + q[1, 1])
    upright = 1.0 / mean[1]
    frame.sizes[0], frame.sizes[1] = long, upright
    # spin of the frame: r1 turns with the chord, about it q_z = 0 stays
    W[:] = 0.0
    W[2, 1], W[2, 7] = -1.0 / long, 1.0 / long
    W[1, 2], W[1, 8] = 1.0 / long, -1.0 / long
    W[0, 2], W[0, 8] = mean[0] * upright / long, -mean[0] * upright / long
    for node in range(2):
        at = 3 + 6 * node
        W[0, at], W[0, at + 1] = 0.5 * q[node, 1] * upright, -0.5 * q[node, 0] * upright
    for j in range(3):
        B[0, j], B[0, 6 + j] = -R[j, 0], R[j, 0]
        B[0, 3 + j] = B[0, 9 + j] = 0.0
    for node in range(2):
        against, inverse = frame.against[node], frame.inverse[node]
        for i in range(3):
            for j in range(12):
                against[i, j] = -W[i, j]
            against[i, 3 + 6 * node + i] += 1.0
        for i in range(3):
            a, b, c = inverse[i, 0], inverse[i, 1], inverse[i, 2]
            row = 1 + 3 * node + i
            for block in range(3, 12, 3):
                one = a * against[0, block] + b * against[1, block] + c * against[2, block]
                at = block + 1
                two = a * against[0, at] + b * against[1, at] + c * against[2, at]
                at = block + 2
                three = a * against[0, at] + b * against[1, at] + c * against[2, at]
                for j in range(3):
                    B[row, block + j] = one * R[j, 0] + two * R[j, 1] + three * R[j, 2]
            for j in range(3):
                B[row, j] = -B[row, 6 + j]


@njit(cache=True, error_model="numpy")
def geometric(frame, Q, K):
    """Derivative of B'Q at constant forces Q (7,) by the global motions, see `rotate_blocks`."""
    R, W, q, d = frame.axes, frame.spin, frame.q, frame.d
    long, upright = frame.sizes
    k = np.empty((12, 12))
    slope, bent, shift, against = (
        np.empty((3, 3)),
        np.empty((3, 12)),
        np.empty((2, 3)),
        frame.against,
    )
    moments, changes = np.empty((2, 3)), np.empty((2, 3, 12))  # m_i = inverse' M_i, and dm_i
    for node in range(2):
        at = 1 + 3 * node
        theta, M, inverse = d[at : at + 3], Q[at : at + 3], frame.inverse[node]
        square = theta[0] ** 2 + theta[1] ** 2 + theta[2] ** 2
        eta, steep = tangent_numbers(math.sqrt(square))
        along = theta[0] * M[0] + theta[1] * M[1] + theta[2] * M[2]
        for i in range(3):
            moments[node, i] = inverse[0, i] * M[0] + inverse[1, i] * M[1] + inverse[2, i] * M[2]
            for j in range(3):
                slope[i, j] = eta * (theta[i] * M[j] - 2.0 * M[i] * theta[j])
                slope[i, j] += steep * (theta[i] * along - square * M[i]) * theta[j]
            slope[i, i] += eta * along
        slope[0, 1] += 0.5 * M[2]
        slope[1, 0] -= 0.5 * M[2]
        slope[0, 2] -= 0.5 * M[1]
        slope[2, 0] += 0.5 * M[1]
        slope[1, 2] += 0.5 * M[0]
        slope[2, 1] -= 0.5 * M[0]
        product(inverse, against[node], bent)
        product(slope, bent, changes[node])
    mx = moments[0, 0] + moments[1, 0]
    my, mz = moments[0, 1] + moments[1, 1], moments[0, 2] + moments[1, 2]
    mean = 0.5 * (q[0, 0] + q[1, 0])
    lean = mean * upright  # q_x / q_y
    force = np.array([Q[0], -mz / long, (my + mx * lean) / long])
    for j in range(3, 12):  # translations of the start are those of the end, reversed
        dx = changes[0, 0, j] + changes[1, 0, j]
        dy = changes[0, 1, j] + changes[1, 1, j]
        dz = changes[0, 2, j] + changes[1, 2, j]
        longer = 1.0 / long if j == 6 else 0.0
        # changes of the second axes of the nodes: (omega_i - w) x q_i
        along = across = 0.0
        for node in range(2):
            y, z = against[node, 1, j], against[node, 2, j]
            shift[node, 0] = y * q[node, 2] - z * q[node, 1]
            shift[node, 1] = z * q[node, 0] - against[node, 0, j] * q[node, 2]
            along += 0.5 * shift[node, 0]
            across += 0.5 * shift[node, 1] * upright
        leaning = along * upright - lean * across
        wx, wy, wz = W[0, j], W[1, j], W[2, j]
        k[6, j] = wy * force[2] - wz * force[1]
        k[7, j] = -dz / long - force[1] * longer + wz * force[0] - wx * force[2]
        k[8, j] = (dy + dx * lean + mx * leaning) / long - force[2] * longer
        k[8, j] += wx * force[1] - wy * force[0]
        for node in range(2):
            half, at = 0.5 * upright, 3 + 6 * node
            nx = moments[node, 0] - half * mx * q[node, 1]
            ny = moments[node, 1] + half * mx * q[node, 0]
            nz = moments[node, 2]
            fall = (dx - mx * across) * half
            k[at, j] = changes[node, 0, j] - fall * q[node, 1] - half * mx * shift[node, 1]
            k[at + 1, j] = changes[node, 1, j] + fall * q[node, 0] + half * mx * shift[node, 0]
            k[at + 2, j] = changes[node, 2, j] + wx * ny - wy * nx
            k[at, j] += wy * nz - wz * ny
            k[at + 1, j] += wz * nx - wx * nz
    rotate_blocks(R, k, K)


@njit(cache=True, error_model="numpy", forceinline=True)
def product(a, b, result):
    """Product of a (3, 3) and b (3, n)."""
    for j in range(b.shape[1]):
        for i in range(3):
            result[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]


@njit(cache=True, error_model="numpy")
def rotate_blocks(R, k, K):
    """Blocks of 3 x 3 of k (12, 12) turned by R into K, but those of translations of the start."""
    for a in range(3, 12, 3):
        for i in range(3):
            r0, r1, r2 = R[i, 0], R[i, 1], R[i, 2]
            for b in range(3, 12, 3):
                h0 = r0 * k[a, b] + r1 * k[a + 1, b] + r2 * k[a + 2, b]
                h1 = r0 * k[a, b + 1] + r1 * k[a + 1, b + 1] + r2 * k[a + 2, b + 1]
                h2 = r0 * k[a, b + 2] + r1 * k[a + 1, b + 2] + r2 * k[a + 2, b + 2]
                for j in range(3):
                    K[a + i, b + j] = h0 * R[j, 0] + h1 * R[j, 1] + h2 * R[j, 2]


@njit(cache=True, error_model="numpy", forceinline=True)
def reverse_start(K):
    """Write what translations of the start take in K (12, 12): that of the end, reversed."""
    for i in range(3, 12):
        for j in range(3):
            K[i, j] = -K[i, 6 + j]
    for i in range(3):
        for j in range(12):
            K[i, j] = -K[6 + i, j]


@njit(cache=True, error_model="numpy")
def columns_by(matrix, first, second):
    """Columns of spins of `matrix` (n, 12) turned into those of the vectors of both nodes."""
    for i in range(matrix.shape[0]):
        for at in (3, 9):
            spins = first if at == 3 else second
            x, y, z = matrix[i, at], matrix[i, at + 1], matrix[i, at + 2]
            for j in range(3):
                matrix[i, at + j] = x * spins[0, j] + y * spins[1, j] + z * spins[2, j]


@njit(cache=True, error_model="numpy")
def straining_part(step, chord, length, rest):
    """Square of the part of a `step` (12,) that is no rigid motion about a `chord`.

    Rotations count with the `length`. Writes the part times the metric into `rest` (12,): a force
    along it has neither a resultant nor a moment.
    """
    hx, hy, hz = 0.5 * chord[0], 0.5 * chord[1], 0.5 * chord[2]
    rx, ry, rz = 0.5 * (step[6] - step[0]), 0.5 * (step[7] - step[1]), 0.5 * (step[8] - step[2])
    square, half = length * length, 0.5 * length * length
    x = hy * rz - hz * ry + half * (step[3] + step[9])
    y = hz * rx - hx * rz + half * (step[4] + step[10])
    z = hx * ry - hy * rx + half * (step[5] + step[11])
    along = (hx * x + hy * y + hz * z) / square
    whole = square + hx * hx + hy * hy + hz * hz
    x, y, z = (x + hx * along) / whole, (y + hy * along) / whole, (z + hz * along) / whole
    rest[6], rest[7], rest[8] = rx - y * hz + z * hy, ry - z * hx + x * hz, rz - x * hy + y * hx
    size = 0.0
    for node in (3, 9):
        one, two, three = step[node] - x, step[node + 1] - y, step[node + 2] - z
        rest[node], rest[node + 1], rest[node + 2] = square * one, square * two, square * three
        size += square * (one * one + two * two + three * three)
    for k in range(3):
        rest[k] = -rest[6 + k]
        size += 2.0 * rest[k] * rest[k]
    return size


@njit(cache=True, error_model="numpy")
def add_straining(alpha, chord, length, K):
    """Add `alpha` times the derivative of `straining_part` to K, as `rotate_blocks` fills it."""
    unit, column = np.zeros(12), np.empty(12)
    for j in range(3, 12):
        unit[j] = 1.0
        straining_part(unit, chord, length, column)
        unit[j] = 0.0
        for i in range(3, 12):
            K[i, j] += alpha * column[i]


@njit(cache=True, error_model="numpy")
def element_step(step, dofs, axes, moved):
    """Step `moved` (12,) of an element in global axes: places and Cayley vectors of both nodes.

    `axes` (2, 3, 3): those of the dofs of both nodes, as rows.
    """
    for node in range(2):
        for i in range(0, 6, 3):
            at = 6 * node + i
            for j in range(3):
                value = 0.0
                for c in range(3):
                    dof = dofs[at + c]
                    value += axes[node, c, j] * (step.end[dof] - step.start[dof])
                moved[at + j] = value


@njit(cache=True, error_model="numpy")
def move_element(step, bars, e, axes, old, new, moved, end):
    """Move element `e` to the end of a `step`: its state `new`, its step `moved` and its frame.

    B of the frame at the `end` is that by the vectors of the step.
    """
    element_step(step, bars.dofs[e], axes, moved)
    maps = np.empty((2, 3, 3))
    for node in range(2):
        psi = moved[6 * node + 3 : 6 * node + 6]
        turn(psi, 1.0, old.triads[e, node], new.triads[e, node])
        spin_map(psi, 1.0, maps[node])
    for k in range(3):
        new.chord[e, k] = old.chord[e, k] + (moved[6 + k] - moved[k])
    chord, triads = bars.chords[e], new.triads[e]
    take_frame(new.chord[e], chord, bars.lengths[e], triads[0], triads[1], end)
    columns_by(end.B, maps[0], maps[1])
    copy(end.d, new.deformation[e])


@njit(cache=True, error_model="numpy")
def add_element(step, dofs, positions, axes, force, K):
    """Add the force (12,) and the tangent `K` (12, 12) of an element in global axes to a `step`.

    Arguments: its `dofs` (12,) and `positions` (144,) in the band; `axes`, see `element_step`.
    """
    half = np.empty((3, 3))
    plain = axes[0, 0, 0] == axes[0, 1, 1] == axes[1, 0, 0] == axes[1, 1, 1] == 1.0
    for a in range(0, 12, 3):
        rows = axes[a // 6]
        for i in range(3):
            value = 0.0
            for c in range(3):
                value += rows[i, c] * force[a + c]
            step.force[dofs[a + i]] += value
        if not step.tangent:
            continue
        for b in range(0, 12, 3):
            columns, block = axes[b // 6], K[a : a + 3, b : b + 3]
            if not plain:
                product(rows, block, half)
            for i in range(3):
                for j in range(3):
                    value = block[i, j]
                    if not plain:
                        value = half[i, 0] * columns[j, 0] + half[i, 1] * columns[j, 1]
                        value += half[i, 2] * columns[j, 2]
                    step.band[positions[12 * (a + i) + b + j]] += value


@njit(cache=True, error_model="numpy")
def add_moved_element(step, bars, e, axes, old, moved, end, middle, Q, C):
    """Add the force and the tangent of element `e` for a `step`.

    Arguments: `axes`, see `element_step`; state `old`; its step `moved` (12,); its frame at the
    `end`, B by the vectors of the step, and one for the `middle` to write into; forces `Q` (7,) of
    the step and their tangent `C` (7, 7) by the deformations at the weighted instant.
    """
    L, at, here = bars.lengths[e], middle, np.empty((2, 3, 3))
    maps, chord, gap = np.empty((2, 3, 3)), np.empty(3), np.zeros(7)
    rest, force, missing = np.empty(12), np.empty(12), np.zeros(12)
    share, way = (step.weight, 0.5) if step.dynamic else (1.0, 1.0)
    for node in range(2):  # equilibrium is that at the end
        psi = moved[6 * node + 3 : 6 * node + 6]
        part = half_share(psi) if step.dynamic else 1.0
        turn(psi, part, old.triads[e, node], here[node])
        spin_map(psi, part, maps[node])
    for k in range(3):
        chord[k] = old.chord[e, k] + way * (moved[6 + k] - moved[k])
    take_frame(chord, bars.chords[e], L, here[0], here[1], at)
    alpha = size = 0.0
    if step.dynamic:
        size = straining_part(moved, chord, L, rest)
        for i in range(7):
            gap[i] = end.d[i] - old.deformation[e, i]
            for j in range(12):
                gap[i] -= at.B[i, j] * moved[j]
            alpha += Q[i] * gap[i]
    turned = 0.0
    for k in range(3):
        turned += moved[3 + k] ** 2 + moved[9 + k] ** 2
    corrected = math.sqrt(size) * (turned + size / (L * L)) > LEAST_GAP * L
    alpha = alpha / size if corrected else 0.0
    for j in range(12):
        force[j] = alpha * rest[j] if corrected else 0.0
    for i in range(7):
        q = Q[i]
        for j in range(12):
            force[j] += at.B[i, j] * q
    K = np.empty((12, 12))
    if step.tangent:  # without translations of the start, see `reverse_start`
        CB = np.zeros((7, 12))
        for i in range(7):
            for c in range(7):
                stiffness = share * C[i, c]
                if stiffness != 0.0:
                    for j in range(3, 12):
                        CB[i, j] += stiffness * end.B[c, j]
        geometric(at, Q, K)
        columns_by(K[3:], maps[0], maps[1])
        for i in range(3, 12):
            for j in range(6, 9):
                K[i, j] *= way
        if corrected:  # the work that is missing, then the square of the straining part
            for j in range(3, 12):
                missing[j] = -2.0 * alpha * rest[j]
            for i in range(7):
                g, q = gap[i], Q[i]
                for j in range(3, 12):
                    missing[j] += g * CB[i, j] + q * (end.B[i, j] - at.B[i, j])
            for i in range(3, 12):
                motion = moved[i] - moved[i - 6] if 6 <= i < 9 else moved[i]
                for j in range(3, 12):
                    missing[j] -= motion * K[i, j]
            add_straining(alpha, chord, L, K)
            for i in range(3, 12):
                ratio = rest[i] / size
                for j in range(3, 12):
                    K[i, j] += ratio * missing[j]
        for c in range(7):
            for i in range(3, 12):
                gradient = at.B[c, i]
                for j in range(3, 12):
                    K[i, j] += gradient * CB[c, j]
        reverse_start(K)
    add_element(step, bars.dofs[e], bars.positions[e], axes, force, K)
