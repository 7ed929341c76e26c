"""The hinge in space: exact plastic domain of a section under N, My and Mz, and its projection.

Powell and Chen 1986 lump N, My, Mz (and an elastic torque) at the ends of a bar; the domain here is
that of the plates themselves. A flow d = (e, k_y, k_z) strains the section by s, the sum of e,
k_y y and k_z z, and D(d) = f_y int |s| dA is the support function of the domain: it is convex, and
its gradient is the point of the surface with the normal d.

All forces are over the plastic ones, all deformations times them (J). A rectangle of which s is
c in the centre and changes by u and v to two sides has the mean of |s|, with w, b the smaller and
the larger of |u|, |v|:

    |c|                                if the neutral axis misses it,             |c| >= w + b
    (c^2 + w^2 / 3 + b^2) / 2b         if it leaves by opposite sides,            |c| <= b - w
    |c| + (w + b - |c|)^3 / (12 w b)   if it cuts off a corner.

None of them cancels, and D is twice continuously differentiable away from zero. A round tube is a
disc less a disc, of which a mean is a function of e and of the length of (k_y, k_z) alone.

Two hinges in series with a bar, forces Q = (N, M_y1, M_z1, M_y2, M_z2), stiffness K, elastic
deformations E before they flow by p = (p_1, p_2): the dual of the closest-point projection,

    min over p of J = (E - B p)' K (E - B p) / 2 + D(p_1) + D(p_2),     Q = K (E - B p),

in which corners and ridges of the surface are directions without curvature, of which K takes care.
"""

import math

import numpy as np

from workbench.base.compiled import njit

MOST = 7  # rectangles: three plates, four fillets
SURFACE = np.dtype(
    [
        ("count", int),  # of rectangles; 0: a round tube
        # share of the area; centre and half sides over those of a unit flow
        *((name, float, MOST) for name in ("share", "y", "z", "half_y", "half_z")),
        ("discs", float, (2, 2)),  # of a round tube: share of the area, radius in the same measure
    ]
)
ROOM = np.dtype(
    [
        ("force", float, 5),  # of both hinges, over the plastic forces
        ("tangent", float, (5, 5)),
        ("flow", float, 6),  # of the first and of the second hinge, J
        # normals that were met last, where the next search begins; gradient and Hessian of D there
        *(("aim", float, (2, 3)), ("met", float, (2, 3)), ("hessian", float, (2, 3, 3))),
        *((name, float, 6) for name in ("old", "step", "gradient", "column")),
        *(("matrix", float, (6, 6)), ("half", float, (5, 6))),
        ("iterations", int),  # of the last projection
    ]
)
PLACE = np.array([0, 1, 2, 0, 3, 4])  # of the forces of both hinges among the five of a bar
FAILED, ELASTIC = -1, 0  # else 1, 2 or 3: the first hinge flows, the second one, both
_THIRD = 1.0 / 3.0  # divisions take most of the time of a support function
_SHARED = 1e-9  # of the axial stiffness: holds how an elongation is shared by two hinges that flow
_TINY, _NOTHING = 1e-14, 1e-100  # of the diagonal; forces over the plastic ones
_OUTSIDE = 1.0 + 1e-10  # gauge from which on a hinge flows
_TOLERANCE, _ACCEPTED = 1e-9, 1e-6  # residual, over the plastic forces: wanted, taken
_ITERATIONS, _SEARCHES, _SETS, _REST_EVERY = 100, 10, 8, 4


@njit(cache=True, error_model="numpy")
def _of_rectangle(c, u, v):
    """Mean of |c + u x + v t| over |x|, |t| <= 1; derivatives c, u, v, cc, cu, cv, uu, uv, vv."""
    w, b, a = abs(u), abs(v), abs(c)
    swapped = w > b
    if swapped:
        w, b = b, w
    sc, su, sv = math.copysign(1.0, c), math.copysign(1.0, u), math.copysign(1.0, v)
    if swapped:
        su, sv = sv, su
    if a >= w + b:
        return a, sc, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if a <= b - w:
        cc, third, square = 1.0 / b, w * _THIRD, c * c + w * w * _THIRD
        mean, of_c, of_w = 0.5 * (square * cc + b), c * cc, su * third * cc
        bb = square * cc * cc
        of_b, bb = sv * (0.5 - 0.5 * bb), bb * cc
        cw, cb, ww, wb = 0.0, -sv * of_c * cc, _THIRD * cc, -sv * of_w * cc
    else:
        cut, one_w, one_b = w + b - a, 1.0 / w, 1.0 / b
        p, q = cut * one_w, cut * one_b  # both below 2
        quarter, sixth, twelfth = 0.25 * p * q, 0.5 * _THIRD, 0.25 * _THIRD
        mean, of_c = a + _THIRD * quarter * cut, sc * (1.0 - quarter)
        of_w, of_b = su * quarter * (1.0 - _THIRD * p), sv * quarter * (1.0 - _THIRD * q)
        cc = 0.5 * p * one_b
        cw, cb = -sc * su * (0.5 * q - quarter) * one_w, -sc * sv * (0.5 * p - quarter) * one_b
        ww = q * (0.5 - 0.5 * p + p * p * sixth) * one_w
        bb = p * (0.5 - 0.5 * q + q * q * sixth) * one_b
        wb = su * sv * p * (0.5 - 0.25 * q - 0.25 * p + p * q * twelfth) * one_b
    if swapped:
        return mean, of_c, of_b, of_w, cc, cb, cw, bb, wb, ww
    return mean, of_c, of_w, of_b, cc, cw, cb, ww, wb, bb


@njit(cache=True, error_model="numpy")
def _of_disc(c, k):
    """Mean of |c + k x| over the unit disc, k > 0; derivatives c, k, cc, ck, kk."""
    at = c / k
    if abs(at) >= 1.0:
        return abs(c), math.copysign(1.0, c), 0.0, 0.0, 0.0, 0.0
    root = math.sqrt(1.0 - at * at)
    arc = math.asin(at)
    mean, slope = 2.0 / math.pi * (at * arc + root * (2.0 + at * at) / 3.0), arc + at * root
    slope *= 2.0 / math.pi
    bend = 4.0 / math.pi * root / k
    return k * mean, slope, mean - at * slope, bend, -at * bend, at * at * bend


@njit(cache=True, error_model="numpy")
def support(surface, flow, g, H):
    """D (J) of a `flow` (3,); writes its gradient `g` (3,), a point of the surface, and Hessian."""
    e, y, z = flow[0], flow[1], flow[2]
    D = 0.0
    g[0] = g[1] = g[2] = 0.0
    h00 = h01 = h02 = h11 = h12 = h22 = 0.0
    for i in range(surface.count):
        share, at_y, at_z = surface.share[i], surface.y[i], surface.z[i]
        a, b = surface.half_y[i], surface.half_z[i]
        mean, c, u, v, cc, cu, cv, uu, uv, vv = _of_rectangle(e + y * at_y + z * at_z, y * a, z * b)
        D += share * mean
        g[0] += share * c
        g[1] += share * (c * at_y + u * a)
        g[2] += share * (c * at_z + v * b)
        of_y, of_z = cc * at_y + cu * a, cc * at_z + cv * b
        h00 += share * cc
        h01 += share * of_y
        h02 += share * of_z
        h11 += share * (of_y * at_y + (cu * at_y + uu * a) * a)
        h12 += share * (of_y * at_z + (cv * at_y + uv * a) * b)
        h22 += share * (of_z * at_z + (cv * at_z + vv * b) * b)
    if surface.count == 0:
        length = math.hypot(y, z)
        y, z = (y / length, z / length) if length > 0.0 else (1.0, 0.0)
        for i in range(2):
            share, radius = surface.discs[i, 0], surface.discs[i, 1]
            if length * radius <= abs(e):
                D += share * abs(e)
                g[0] += share * math.copysign(1.0, e)
                continue
            mean, c, k, cc, ck, kk = _of_disc(e, length * radius)
            D += share * mean
            g[0] += share * c
            along, turned = share * k * radius, share * k * radius / length
            g[1] += along * y
            g[2] += along * z
            h00 += share * cc
            h01 += share * ck * radius * y
            h02 += share * ck * radius * z
            bend = share * kk * radius * radius - turned
            h11 += bend * y * y + turned
            h12 += bend * y * z
            h22 += bend * z * z + turned
    H[0, 0], H[1, 1], H[2, 2] = h00, h11, h22
    H[0, 1] = H[1, 0] = h01
    H[0, 2] = H[2, 0] = h02
    H[1, 2] = H[2, 1] = h12
    return D


@njit(cache=True, error_model="numpy")
def factorise(A, n):
    """Factor the first n rows of the symmetric A into L D L' in place; whether D > 0."""
    for j in range(n):
        pivot = A[j, j]
        for k in range(j):
            pivot -= A[j, k] * A[j, k] * A[k, k]
        if not pivot > 0.0:
            return False
        A[j, j] = pivot
        for i in range(j + 1, n):
            left = A[i, j]
            for k in range(j):
                left -= A[i, k] * A[j, k] * A[k, k]
            A[i, j] = left / pivot
    return True


@njit(cache=True, error_model="numpy")
def substitute(A, b, n):
    """Solve L D L' x = b in place, n rows."""
    for i in range(n):
        left = b[i]
        for k in range(i):
            left -= A[i, k] * b[k]
        b[i] = left
    for at in range(n):
        i = n - 1 - at
        left = b[i] / A[i, i]
        for k in range(i + 1, n):
            left -= A[k, i] * b[k]
        b[i] = left


@njit(cache=True, error_model="numpy")
def gauge(surface, q, aim, g, H, room, decide):
    """How far out the forces `q` (3,) are, 1 on the surface: the largest q.d / D(d).

    The least of D^2 / 2 - q.d, by damped Newton from the normal `aim` (3,), which becomes the one
    found, as long as the gauge; writes gradient `g` (3,) and Hessian of D there. `decide`: end once
    it is known whether the gauge is above 1.
    """
    A, d, step = room.matrix, room.old, room.step
    size = abs(q[0]) + abs(q[1]) + abs(q[2])
    if size < _NOTHING:
        return 0.0
    if not q[0] * aim[0] + q[1] * aim[1] + q[2] * aim[2] > 0.0:
        aim[0], aim[1], aim[2] = q[0], q[1], q[2]
    D = support(surface, aim, g, H)
    ratio = (q[0] * aim[0] + q[1] * aim[1] + q[2] * aim[2]) / (D * D)
    for i in range(3):
        aim[i] *= ratio
        for j in range(3):
            H[i, j] /= ratio
    D *= ratio
    damping, value = 1e-9, -0.5 * D * D
    for _ in range(200):
        left = most = 0.0
        for i in range(3):
            step[i] = D * g[i] - q[i]
            left += abs(step[i])
            most = max(most, abs(step[i]))
        work = q[0] * aim[0] + q[1] * aim[1] + q[2] * aim[2]
        if decide and (D + left <= 1.0 or work > _OUTSIDE * D):
            break
        if most <= 1e-12 * max(1.0, size):
            break
        for i in range(3):
            for j in range(i + 1):
                A[i, j] = D * H[i, j] + g[i] * g[j]
            A[i, i] += damping
        slope = -(step[0] * step[0] + step[1] * step[1] + step[2] * step[2])
        if factorise(A, 3):
            g0, g1, g2 = step[0], step[1], step[2]
            substitute(A, step, 3)
            slope = -(g0 * step[0] + g1 * step[1] + g2 * step[2])
        for i in range(3):
            d[i] = aim[i]
            aim[i] -= step[i]
        D = support(surface, aim, g, H)
        new = 0.5 * D * D - (q[0] * aim[0] + q[1] * aim[1] + q[2] * aim[2])
        if new <= value + 1e-4 * slope + 1e-15:
            value, damping = new, max(0.1 * damping, 1e-13)
            continue
        for i in range(3):
            aim[i] = d[i]
        D = support(surface, aim, g, H)
        if -slope < 1e-15 or damping > 1e6:
            break
        damping = max(10.0 * damping, 1e-8)
    return max(D, (q[0] * aim[0] + q[1] * aim[1] + q[2] * aim[2]) / D)


@njit(cache=True, error_model="numpy")
def _is_outside(surface, n, y, z, hinge, room):
    """Whether a hinge flows under its forces; its `aim` turns towards the normal there."""
    if abs(n) + abs(y) + abs(z) <= 1.0:
        return False
    q, aim, met = room.column, room.aim[hinge], room.met[hinge]
    q[0], q[1], q[2] = n, y, z
    beyond = 0.0
    for i in range(3):
        beyond += (q[i] - _OUTSIDE * met[i]) * aim[i]
    return beyond > 0.0 or gauge(surface, q, aim, met, room.hessian[hinge], room, True) > _OUTSIDE


@njit(cache=True, error_model="numpy")
def _meet(surface, low, high, room):
    """Write gradient and Hessian of D at the flow of the hinges that do."""
    for hinge in range(low // 3, high // 3):
        flow = room.flow[3 * hinge : 3 * hinge + 3]
        support(surface, flow, room.met[hinge], room.hessian[hinge])


@njit(cache=True, error_model="numpy")
def _evaluate(K, trial, low, high, room):
    """Forces at the flow and gradient of J over what flows, whose D is met; the largest of that."""
    p, force, g, most = room.flow, room.force, room.gradient, 0.0
    e0, e1, e2, e3, e4 = trial[0], trial[1], trial[2], trial[3], trial[4]
    if low == 0:
        e0, e1, e2 = e0 - p[0], e1 - p[1], e2 - p[2]
    if high == 6:
        e0, e3, e4 = e0 - p[3], e3 - p[4], e4 - p[5]
    for i in range(5):
        force[i] = K[i, 0] * e0 + K[i, 1] * e1 + K[i, 2] * e2 + K[i, 3] * e3 + K[i, 4] * e4
    for i in range(low, high):
        g[i] = room.met[i // 3, i % 3] - force[PLACE[i]]
    if high - low == 6:
        apart = _SHARED * K[0, 0] * (p[0] - p[3])
        g[0] += apart
        g[3] -= apart
    for i in range(low, high):
        if K[PLACE[i], PLACE[i]] == 0.0:
            g[i] = 0.0
        most = max(most, abs(g[i]))
    return most


@njit(cache=True, error_model="numpy")
def _assemble(K, low, high, damping, room):
    """The Hessian of J over what flows, factored; whether it is positive."""
    A, n = room.matrix, high - low
    for i in range(n):
        row = PLACE[low + i]
        for j in range(i + 1):
            A[i, j] = K[row, PLACE[low + j]]
        A[i, i] += damping * K[row, row]
    for at in range(0, n, 3):
        H = room.hessian[(low + at) // 3]
        for i in range(3):
            for j in range(i + 1):
                A[at + i, at + j] += H[i, j]
    if high - low == 6:
        A[0, 0] += _SHARED * K[0, 0]
        A[3, 3] += _SHARED * K[0, 0]
        A[3, 0] -= _SHARED * K[0, 0]
    for i in range(n):
        if K[PLACE[low + i], PLACE[low + i]] == 0.0:  # a pin about this axis: it turns freely
            for j in range(n):
                A[i, j] = A[j, i] = 0.0
            A[i, i] = 1.0
    return factorise(A, n)


@njit(cache=True, error_model="numpy")
def _along(K, a, first, b, second):
    """Work a'Kb of the flows `a` (3,) of the hinge `first` and `b` (3,) of the hinge `second`."""
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += a[i] * K[PLACE[3 * first + i], PLACE[3 * second + j]] * b[j]
    return total


@njit(cache=True, error_model="numpy")
def _set_off(K, flows, room):
    """First guess of the flow of the hinges that do: along their aims, so far that J is least."""
    force, p, aim, met = room.force, room.flow, room.aim, room.met
    long0, long1, work0, work1 = 0.0, 0.0, 0.0, 0.0
    if flows[0]:
        work0 = aim[0, 0] * force[0] + aim[0, 1] * force[1] + aim[0, 2] * force[2]
        D = aim[0, 0] * met[0, 0] + aim[0, 1] * met[0, 1] + aim[0, 2] * met[0, 2]
        work0 = max(work0 - D, 1e-6 * D)
        long0 = work0 / _along(K, aim[0], 0, aim[0], 0)
    if flows[1]:
        work1 = aim[1, 0] * force[0] + aim[1, 1] * force[3] + aim[1, 2] * force[4]
        D = aim[1, 0] * met[1, 0] + aim[1, 1] * met[1, 1] + aim[1, 2] * met[1, 2]
        work1 = max(work1 - D, 1e-6 * D)
        long1 = work1 / _along(K, aim[1], 1, aim[1], 1)
    if flows[0] and flows[1]:
        stiff0, stiff1 = work0 / long0, work1 / long1
        both = _along(K, aim[0], 0, aim[1], 1)
        whole = stiff0 * stiff1 - both * both
        joint0 = (work0 * stiff1 - work1 * both) / whole
        joint1 = (work1 * stiff0 - work0 * both) / whole
        good = whole > 1e-6 * stiff0 * stiff1 and joint0 > 0.0 and joint1 > 0.0
        long0, long1 = (joint0, joint1) if good else (0.5 * long0, 0.5 * long1)
    for i in range(6):
        if flows[i // 3]:
            long = (long0, long1)[i // 3]
            aim[i // 3, i % 3] *= long
            for j in range(3):
                room.hessian[i // 3, i % 3, j] /= long
            p[i] = aim[i // 3, i % 3] if K[PLACE[i], PLACE[i]] > 0.0 else 0.0


@njit(cache=True, error_model="numpy")
def _rests(surface, K, hinge, room):
    """Whether the forces of a hinge would be inside if it did not flow."""
    at, force, p = 3 * hinge, room.force, room.flow
    n, y, z = force[0], force[PLACE[at + 1]], force[PLACE[at + 2]]
    for j in range(3):
        n += K[0, PLACE[at + j]] * p[at + j]
        y += K[PLACE[at + 1], PLACE[at + j]] * p[at + j]
        z += K[PLACE[at + 2], PLACE[at + j]] * p[at + j]
        room.aim[hinge, j] = p[at + j]
    if not _is_outside(surface, n, y, z, hinge, room):
        return True
    _meet(surface, at, at + 3, room)
    return False


@njit(cache=True, error_model="numpy")
def _bounds(first, second):
    """Range of the unknowns that flow."""
    return 0 if first else 3, 6 if second else 3


@njit(cache=True, error_model="numpy")
def _minimise(surface, K, trial, flows, room):
    """The flow of the hinges that may flow; which ones still do, and the residual."""
    first, second = flows
    low, high = _bounds(first, second)
    p, g, old, step = room.flow, room.gradient, room.old, room.step
    most = _evaluate(K, trial, low, high, room)
    damping = _TINY
    for count in range(_ITERATIONS):
        if most < _TOLERANCE:
            break
        room.iterations += 1
        slope = 0.0
        n = high - low
        for i in range(n):
            step[i] = -g[low + i]
        if _assemble(K, low, high, damping, room):
            substitute(room.matrix, step, n)
        for i in range(n):
            slope += step[i] * g[low + i]
            old[i] = p[low + i]
        share, from_, to, slope_from, slope_to = 1.0, 0.0, np.nan, slope, np.nan
        cut = False
        for _ in range(_SEARCHES):
            for i in range(n):
                p[low + i] = old[i] + share * step[i]
            _meet(surface, low, high, room)
            most = _evaluate(K, trial, low, high, room)
            new = 0.0
            for i in range(n):
                new += step[i] * g[low + i]
            if new <= -0.5 * slope and (not cut or new >= 0.5 * slope):
                break
            cut = True
            if new > 0.0:
                to, slope_to = share, new
            else:
                from_, slope_from = share, new
            share = from_ - slope_from * (to - from_) / (slope_to - slope_from)
            share = min(max(share, from_ + 0.05 * (to - from_)), to - 0.05 * (to - from_))
        damping = max(100.0 * damping, 1e-6) if cut else max(0.05 * damping, _TINY)
        if cut or count % _REST_EVERY == _REST_EVERY - 1:
            if first and _rests(surface, K, 0, room):
                first = False
            elif second and _rests(surface, K, 1, room):
                second = False
            if not (first or second):
                return first, second, 0.0
            if _bounds(first, second) != (low, high):
                low, high = _bounds(first, second)
                most = _evaluate(K, trial, low, high, room)
    return first, second, most


@njit(cache=True, error_model="numpy")
def project(surface, K, trial, room):
    """Project two hinges in series with a bar: which ones flow, or `FAILED`.

    Arguments: `surface` of both; stiffness `K` (5, 5), zero of a pin; elastic deformations `trial`
    (5,), before the hinges flow. Writes forces, tangent and flow of the `room`, and the normals
    from which the next projection begins. A hinge that is a pin about both axes does not flow.
    """
    force, C = room.force, room.tangent
    for i in range(5):
        force[i] = 0.0
        for j in range(5):
            force[i] += K[i, j] * trial[j]
            C[i, j] = K[i, j]
    room.iterations = 0
    for i in range(6):
        room.flow[i] = 0.0
    turns = K[1, 1] + K[2, 2] > 0.0, K[3, 3] + K[4, 4] > 0.0
    first = turns[0] and _is_outside(surface, force[0], force[1], force[2], 0, room)
    second = turns[1] and _is_outside(surface, force[0], force[3], force[4], 1, room)
    if not (first or second):
        return ELASTIC
    _set_off(K, (first, second), room)
    low, high, most = 0, 0, np.inf
    for _ in range(_SETS):
        first, second, most = _minimise(surface, K, trial, (first, second), room)
        low, high = _bounds(first, second)
        joined = False
        if not first and turns[0] and _is_outside(surface, force[0], force[1], force[2], 0, room):
            _set_off(K, (True, False), room)
            first = joined = True
        free = not joined and not second and turns[1]
        if free and _is_outside(surface, force[0], force[3], force[4], 1, room):
            _set_off(K, (False, True), room)
            second = joined = True
        if not joined:
            break
    p = room.flow
    for hinge in range(2):
        flows = (first, second)[hinge]
        for i in range(3):
            if flows:
                room.aim[hinge, i] = p[3 * hinge + i]
            else:
                p[3 * hinge + i] = 0.0
    if not most < _ACCEPTED:
        return FAILED
    _assemble(K, low, high, _TINY, room)
    A, half, soft, n = room.matrix, room.half, room.column, high - low
    for j in range(n):
        soft[j] = 1.0 / A[j, j]
    for i in range(5):
        for j in range(n):
            left = K[i, PLACE[low + j]]
            for k in range(j):
                left -= A[j, k] * half[i, k]
            half[i, j] = left
        for k in range(i + 1):
            left = C[i, k]
            for j in range(n):
                left -= half[i, j] * half[k, j] * soft[j]
            C[i, k] = C[k, i] = left
    return (1 if first else 0) + (2 if second else 0)
