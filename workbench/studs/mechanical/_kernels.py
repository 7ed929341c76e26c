"""Laws of the concrete around a stud, as scalar links between degrees of freedom.

A link has the deformation s = sign (q_a - q_b) and the force f(s), which acts as sign f on a and
-sign f on b (b < 0: the ground). `factor` scales a link, `cap` limits a slide; both are kept
during a step. States: (largest s, smallest s) of bearings, (largest s, -) of the cone, plastic
slide of the slide. Laws rise as f = F (1 - exp(-K s / F)) and unload with the slope K.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Indices = NDArray[np.int64]

BEARING, CONE, CONTACT, SLIDE = 0, 1, 2, 3
CONE_REST = 0.02  # of the cone's strength, carried by the rubble of a broken cone


@njit(cache=True, error_model="numpy")
def bearing_side(s: float, largest: float, K: float, F: float) -> tuple[float, float]:
    """Force and slope of one side of a bearing at s, pressed to `largest` before.

    Beyond `largest` the envelope; below it a line of slope K, and a gap where that falls to zero.
    """
    if F <= 0.0:
        return 0.0, 0.0
    if s >= largest:
        if s < 0.0:
            return 0.0, 0.0
        if s == 0.0:
            return 0.0, 0.5 * K  # both sides together have the slope K
        lost = math.expm1(-K * s / F)
        return -F * lost, K * (1.0 + lost)
    top = -F * math.expm1(-K * largest / F)
    f = top - K * (largest - s)
    if f <= 0.0:
        return 0.0, 0.0
    return f, K


@njit(cache=True, error_model="numpy")
def bearing(
    s: float, largest: float, smallest: float, K: float, F: float
) -> tuple[float, float, float, float]:
    """Two-sided bearing: force, slope, new largest and smallest s."""
    front, k_front = bearing_side(s, largest, K, F)
    rear, k_rear = bearing_side(-s, -smallest, K, F)
    return front - rear, k_front + k_rear, max(largest, s), min(smallest, s)


@njit(cache=True, error_model="numpy")
def cone_envelope(s: float, F: float, peak: float, end: float) -> tuple[float, float]:
    """First loading of the cone: a parabola up to F at `peak`, then a line to nearly zero at `end`.

    Its initial slope is 2 F / peak. Beyond `end` a small rest is left.
    """
    if s <= 0.0:
        return 0.0, 0.0
    if s <= peak:
        x = s / peak
        return F * x * (2.0 - x), 2.0 * F / peak * (1.0 - x)
    if s >= end:
        return CONE_REST * F, 0.0
    slope = -(1.0 - CONE_REST) * F / (end - peak)
    return F + slope * (s - peak), slope


@njit(cache=True, error_model="numpy")
def cone(
    s: float, largest: float, K: float, F: float, peak: float, end: float
) -> tuple[float, float, float]:
    """Cone in tension with softening: force, slope, new largest s.

    Unloading loses the slope in proportion to the load that is left, so that the crack stays open;
    pressed beyond that, the cone rests on the slab with the slope K.
    """
    if s >= largest and s > 0.0:
        f, k = cone_envelope(s, F, peak, end)
        return f, k, s
    top, _ = cone_envelope(largest, F, peak, end)
    slope = K * top / F if largest > peak else K
    rest = largest - top / slope if slope > 0.0 else largest - F / K
    rest = max(rest, 0.0)
    if s <= rest:
        return K * (s - rest), K, largest
    slope = top / (largest - rest)
    return slope * (s - rest), slope, largest


class Layout(NamedTuple):
    """Dofs `first` and `second` of links, `sign` and `law` (links,); `parameters` (links, 4).

    The parameters are K, F, peak and end.
    """

    first: Indices
    second: Indices
    sign: Vector
    law: Indices
    parameters: NDArray[np.float64]


class State(NamedTuple):
    """`factor`, `cap`, `force` and `slope` of links (links,), `old` and `new` states (links, 2)."""

    factor: Vector
    cap: Vector
    old: NDArray[np.float64]
    new: NDArray[np.float64]
    force: Vector
    slope: Vector


@njit(cache=True, error_model="numpy")
def evaluate(q: Vector, layout: Layout, state: State) -> None:
    """Forces, slopes and new states of all links at displacements `q`."""
    a, b, old, new = layout.first, layout.second, state.old, state.new
    for i in range(a.shape[0]):
        s = q[a[i]] - (q[b[i]] if b[i] >= 0 else 0.0)
        s *= layout.sign[i]
        law, factor = layout.law[i], state.factor[i]
        given = layout.parameters[i]
        K, F = given[0], given[1]
        if law == BEARING:
            f, k, large, small = bearing(s, old[i, 0], old[i, 1], K, F * state.cap[i])
            state.force[i] = factor * f
            state.slope[i] = factor * k
            new[i, 0] = large
            new[i, 1] = small
        elif law == CONE:
            f, k, new[i, 0] = cone(s, old[i, 0], K, F, given[2], given[3])
            state.force[i] = f
            state.slope[i] = k
        elif law == CONTACT:
            state.force[i] = K * s if s > 0.0 else 0.0
            state.slope[i] = K if s > 0.0 else 0.0
        else:
            trial = K * (s - old[i, 0])
            limit = F * state.cap[i]
            if abs(trial) <= limit:
                state.force[i] = trial
                state.slope[i] = K
                new[i, 0] = old[i, 0]
            else:
                state.force[i] = math.copysign(limit, trial)
                state.slope[i] = 0.0
                new[i, 0] = s - state.force[i] / K


@njit(cache=True, error_model="numpy")
def scatter(force: Vector, band: Vector, positions: Indices, layout: Layout, state: State) -> None:
    """Add the link forces to `force` (dofs,) and their slopes to the flat `band`.

    `positions` (links, 4): where the entries (a, a), (a, b), (b, a), (b, b) are.
    """
    a, b, k = layout.first, layout.second, state.slope
    for i in range(a.shape[0]):
        f = layout.sign[i] * state.force[i]
        force[a[i]] += f
        band[positions[i, 0]] += k[i]
        if b[i] >= 0:
            force[b[i]] -= f
            band[positions[i, 1]] -= k[i]
            band[positions[i, 2]] -= k[i]
            band[positions[i, 3]] += k[i]
