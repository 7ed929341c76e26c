"""Reading many records of superelements at once: what a response holds of them, in SI units."""

from typing import NamedTuple

import numpy as np
from numba import njit

from workbench.arrays import Array, Flags, Indices

TABLES = ("axial_force", "moment", "plastic_rotation")


class Places(NamedTuple):
    """Where what is read stands in the states of a frame.

    Of its hinges (hinges,): the element and the `side` of it that each is at, and the sign of its
    moment. Of its elements: where those of each member start, `first` (members + 1,), their
    `lengths`, whether webs `slide`, and `first_order`, see `Bars`. Of its members: dofs u, v of
    both `corners` (members, 4), and what of their movement counts `across` and `along` (members,
    2), over the length; which straight line of members each is in, its `chain`, and the `share` of
    that in 1/m. Of its uprights: dofs that make them drift, from where these `start`, and what of
    each counts for the drift, `sway` (dofs, uprights).
    """

    hinge: Indices
    side: Indices
    sign: Array
    first: Indices
    lengths: Array
    slide: Flags
    first_order: bool
    corners: Indices
    across: Array
    along: Array
    chain: Indices
    share: Array
    swaying: Indices
    start: Array
    sway: Array


class Lost(NamedTuple):
    """Beyond what a structure is lost: see the constants of `collapse_watch`."""

    sideways: float
    contraction: float
    length: float


@njit(cache=True, error_model="numpy")
def read(places, lost, x, states, tables, slid, most, drift):
    """Read all records; returns the number of the first one in which the frame is lost, or -1.

    Written: `tables` (3, hinges, records), see `TABLES`; how far the webs of members have `slid`
    (members, records); `most` (2, members), the largest shear force in an element of a member so
    far, and of the mean along it where no web slides; the largest `drift` (uprights,) so far.
    """
    local, carried, plastic = states.local, states.carried, states.plastic
    deformed, slide, lengths, first = states.deformation, places.slide, places.lengths, places.first
    hinge, side, sign, corners = places.hinge, places.side, places.sign, places.corners
    across, along, chain, share = places.across, places.along, places.chain, places.share
    swaying, start, sway = places.swaying, places.start, places.sway
    fallen, squashed = -1, np.zeros(first.size - 1)
    for r in range(x.shape[0]):
        for h in range(hinge.size):
            e, end = hinge[h], side[h]
            tables[0, h, r] = local[r, e, 0]
            tables[1, h, r] = sign[h] * local[r, e, 1 + end]
            tables[2, h, r] = sign[h] * (plastic[r, e, 1 + 2 * end] - plastic[r, e, 4] / lengths[e])
        for u in range(drift.size):
            across_line = 0.0
            for i in range(swaying.size):
                across_line += sway[i, u] * (x[r, swaying[i]] - start[i])
            drift[u] = max(drift[u], abs(across_line))
        gone, squashed[:] = False, 0.0
        for m in range(first.size - 1):
            largest = total = stretched = slides = 0.0
            for e in range(first[m], first[m + 1]):
                longer = deformed[r, e, 0]
                if slide[e]:
                    shear = (carried[r, e, 1] + carried[r, e, 2]) / lengths[e]
                    slides += plastic[r, e, 4]
                else:
                    chord = lengths[e] + (0.0 if places.first_order else longer)
                    shear = (local[r, e, 1] + local[r, e, 2]) / chord
                    total += shear
                largest = max(largest, abs(shear))
                stretched += longer
                gone = gone or longer < (lost.length - 1.0) * lengths[e]
            if slid.size > 0:
                slid[m, r] = slides
            most[0, m] = max(most[0, m], largest)
            most[1, m] = max(most[1, m], abs(total) / (first[m + 1] - first[m]))
            squashed[chain[m]] -= share[m] * stretched
            du = x[r, corners[m, 2]] - x[r, corners[m, 0]]
            dv = x[r, corners[m, 3]] - x[r, corners[m, 1]]
            apart = abs(du * across[m, 0] + dv * across[m, 1])
            left = 1.0 + du * along[m, 0] + dv * along[m, 1]
            if apart > lost.sideways * min(1.0, abs(left)):  # as good as never
                gone = gone or apart > lost.sideways * min(1.0, np.hypot(apart, left))
        if fallen < 0 and (gone or squashed.max() > lost.contraction):
            fallen = r
    return fallen


@njit(cache=True, error_model="numpy")
def choose(times, displacement, turns, seen, even, kept):
    """Which records are drawn: `even` ones, each the first at or after its turn, and the peak's.

    Of records at `times` (s) with a `displacement` (m). `seen` (3,) goes on from the records
    before: how many `turns` (s) have passed, the largest displacement, and whether the last one was
    that. Written: flags of the `even` ones and of all that are `kept`. Returns the number of the
    peak's, one after the last that is largest so far; -1, if there is none.
    """
    peak, last = -1, turns.size
    passed, largest, rising = int(seen[0]), seen[1], seen[2] > 0.0
    for r in range(times.size):
        before, size, rose = passed, abs(displacement[r]), rising
        while passed < last and turns[passed] <= times[r]:
            passed += 1
        even[r] = kept[r] = passed > before
        rising = size >= largest
        if rose and not rising:
            peak = r
        largest = max(largest, size)
    kept[times.size - 1] = True  # which may be all there are
    if peak >= 0:
        kept[peak] = True
    seen[0], seen[1], seen[2] = passed, largest, rising
    return peak


@njit(cache=True, error_model="numpy")
def draw(drawn, along, origin, bends, bars, x, carried, shapes):
    """Write the `shapes` (2, members, points, pictures) in m, as `MemberElements.bent` has them.

    Arguments: of each point of each member the element it is `drawn` on, where `along` that (0..1),
    and the `origin` of the element; flexibility `bends` of all elements; displacements `x` (dofs,
    pictures) and forces `carried` (elements, 3, pictures), axial force and end moments.
    """
    for m in range(drawn.shape[0]):
        for p in range(drawn.shape[1]):
            e, at = drawn[m, p], along[m, p]
            u0, v0, u1, v1 = bars.dofs[e, 0], bars.dofs[e, 1], bars.dofs[e, 3], bars.dofs[e, 4]
            soft = (bars.lengths[e] / 6.0 * bends[e]) * at * (1.0 - at)
            Dx, Dy, x0, y0 = bars.chords[e, 0], bars.chords[e, 1], origin[m, p, 0], origin[m, p, 1]
            for k in range(x.shape[1]):
                dx = Dx + x[u1, k] - x[u0, k]
                dy = Dy + x[v1, k] - x[v0, k]
                m1, m4 = carried[e, 1, k], carried[e, 2, k]
                across = soft * ((1.0 - at) * (2.0 * m1 - m4) - at * (2.0 * m4 - m1))
                shapes[0, m, p, k] = x0 + (x[u0, k] + at * dx - across * dy)
                shapes[1, m, p, k] = y0 + (x[v0, k] + at * dy + across * dx)
