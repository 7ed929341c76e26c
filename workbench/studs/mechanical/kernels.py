"""Laws of the concrete around a stud, as scalar links between degrees of freedom.

A link has the deformation s = sign (q_a - q_b) and the force f(s), which acts as sign f on a and
-sign f on b (b < 0: the ground). `factor` scales a link, `cap` limits a slide; both are kept
during a step. States: (largest s, smallest s) of bearings, (largest s, -) of the cone, plastic
slide of the slide. Laws rise as f = F (1 - exp(-K s / F)) and unload with the slope K.
"""

import math

from workbench.base.compiled import njit

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


@njit(cache=True, error_model="numpy")
def evaluate(q, links, factor, cap, old, new):
    """Forces and slopes of all links at displacements `q` (dofs,), from the committed state `old`.

    Arguments: `links`, see `LinkTables`; `factor` and `cap` (links,). Writes the state `new`.
    """
    a, b, sign, law, parameters = links
    for i in range(a.shape[0]):
        s = q[a[i]] - (q[b[i]] if b[i] >= 0 else 0.0)
        s *= sign[i]
        new.deformation[i] = s
        K, F = parameters[i, 0], parameters[i, 1]
        if law[i] == BEARING:
            f, k, large, small = bearing(s, old.inner[i, 0], old.inner[i, 1], K, F * cap[i])
            new.force[i] = factor[i] * f
            new.slope[i] = factor[i] * k
            new.inner[i, 0] = large
            new.inner[i, 1] = small
        elif law[i] == CONE:
            new.force[i], new.slope[i], new.inner[i, 0] = cone(
                s, old.inner[i, 0], K, F, parameters[i, 2], parameters[i, 3]
            )
        elif law[i] == CONTACT:
            new.force[i] = K * s if s > 0.0 else 0.0
            new.slope[i] = K if s > 0.0 else 0.0
        else:
            trial = K * (s - old.inner[i, 0])
            limit = F * cap[i]
            if abs(trial) <= limit:
                new.force[i] = trial
                new.slope[i] = K
                new.inner[i, 0] = old.inner[i, 0]
            else:
                new.force[i] = math.copysign(limit, trial)
                # a trace of the slope keeps the structure stable when all else has yielded
                new.slope[i] = 0.0
                new.inner[i, 0] = s - new.force[i] / K


@njit(cache=True, error_model="numpy")
def scatter(force, band, links, chosen, state):
    """Add the link forces to `force` (dofs,) and their slopes to the flat `band`.

    `chosen` (links, 4): where the entries (a, a), (a, b), (b, a), (b, b) are.
    """
    a, b, sign = links.first, links.second, links.sign
    for i in range(a.shape[0]):
        force[a[i]] += sign[i] * state.force[i]
        band[chosen[i, 0]] += state.slope[i]
        if b[i] >= 0:
            force[b[i]] -= sign[i] * state.force[i]
            band[chosen[i, 1]] -= state.slope[i]
            band[chosen[i, 2]] -= state.slope[i]
            band[chosen[i, 3]] += state.slope[i]
