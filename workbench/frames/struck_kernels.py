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
    2), over the length; `chained` (chains, members), see `Lines`. Of its uprights: dofs that make
    them drift, and from where these `start`.
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
    chained: Array
    swaying: Indices
    start: Array


class Lost(NamedTuple):
    """Beyond what a structure is lost: see the constants of `collapse_watch`."""

    sideways: float
    contraction: float
    length: float


@njit(cache=True, error_model="numpy")
def read(places, lost, x, states, tables, most, swayed):
    """Read all records; returns the number of the first one in which the frame is lost, or -1.

    Written: `tables` (3, hinges, records), see `TABLES`; `most` (2, members), the largest shear
    force in an element of a member so far, and of the mean along it where no web slides; `swayed`
    (records, dofs), movements that make uprights drift.
    """
    first, fallen = places.first, -1
    local, carried, plastic = states.local, states.carried, states.plastic
    deformed = states.deformation
    shortened = np.zeros(first.size - 1)
    for r in range(x.shape[0]):
        for h in range(places.hinge.size):
            e, side, sign = places.hinge[h], places.side[h], places.sign[h]
            tables[0, h, r] = local[r, e, 0]
            tables[1, h, r] = sign * local[r, e, 1 + side]
            tables[2, h, r] = sign * (plastic[r, e, 1 + 2 * side] - plastic[r, e, 4])
        for i in range(places.swaying.size):
            swayed[r, i] = x[r, places.swaying[i]] - places.start[i]
        gone = False
        for m in range(first.size - 1):
            largest = total = stretched = 0.0
            for e in range(first[m], first[m + 1]):
                longer = deformed[r, e, 0]
                if places.slide[e]:
                    shear = (carried[r, e, 1] + carried[r, e, 2]) / places.lengths[e]
                else:
                    chord = places.lengths[e] + (0.0 if places.first_order else longer)
                    shear = (local[r, e, 1] + local[r, e, 2]) / chord
                    total += shear
                largest = max(largest, abs(shear))
                stretched += longer
                gone = gone or 1.0 + longer / places.lengths[e] < lost.length
            most[0, m] = max(most[0, m], largest)
            most[1, m] = max(most[1, m], abs(total) / (first[m + 1] - first[m]))
            shortened[m] = -stretched
            u0, v0, u1, v1 = places.corners[m]
            du, dv = x[r, u1] - x[r, u0], x[r, v1] - x[r, v0]
            apart = abs(du * places.across[m, 0] + dv * places.across[m, 1])
            left = 1.0 + du * places.along[m, 0] + dv * places.along[m, 1]
            gone = gone or apart / min(1.0, np.hypot(apart, left)) > lost.sideways
        for chain in range(places.chained.shape[0]):
            squashed = 0.0
            for m in range(first.size - 1):
                squashed += places.chained[chain, m] * shortened[m]
            gone = gone or squashed > lost.contraction
        if gone and fallen < 0:
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
def draw(drawn, along, origin, bends, bars, x, moments, shapes):
    """Write the `shapes` (2, members, points, pictures) in m, as `MemberElements.bent` has them.

    Arguments: of each point of each member the element it is `drawn` on, where `along` that (0..1),
    and the `origin` of the element; flexibility `bends` of all elements; displacements `x`
    (pictures, dofs) and end `moments` (pictures, elements, 2).
    """
    for m in range(drawn.shape[0]):
        for p in range(drawn.shape[1]):
            e, at = drawn[m, p], along[m, p]
            u0, v0, u1, v1 = bars.dofs[e, 0], bars.dofs[e, 1], bars.dofs[e, 3], bars.dofs[e, 4]
            soft = (bars.lengths[e] / 6.0 * bends[e]) * at * (1.0 - at)
            for k in range(x.shape[0]):
                dx = bars.chords[e, 0] + x[k, u1] - x[k, u0]
                dy = bars.chords[e, 1] + x[k, v1] - x[k, v0]
                m1, m4 = moments[k, e, 0], moments[k, e, 1]
                across = soft * ((1.0 - at) * (2.0 * m1 - m4) - at * (2.0 * m4 - m1))
                shapes[0, m, p, k] = origin[m, p, 0] + (x[k, u0] + at * dx - across * dy)
                shapes[1, m, p, k] = origin[m, p, 1] + (x[k, v0] + at * dy + across * dx)
