"""What is kept of every record of an impact on superelements, read while the state is at hand.

Whole states would be ten times as much to store, and to fetch again.
"""

from typing import NamedTuple

import numpy as np

from workbench.arrays import Array, Flags, Indices
from workbench.compiled import njit
from workbench.structures.kernels import copy


class Places(NamedTuple):
    """Where what is read stands in the states of a structure; all in SI units.

    Of its hinges (hinges,): the element and the `side` of it that each is at, and the sign of its
    moment. Of its elements: where those of each member start, `first` (members + 1,), their
    `lengths`, whether webs `slide`, and `first_order`, see `Bars`. Of its members: dofs u, v of
    both `corners` (members, 4), and what of their movement counts `across` and `along` (members,
    2), over the length; which straight line of members each is in, its `chain`, and the `share` of
    that in 1/m. Of its uprights: dofs that make them drift, from where these `start`, and what of
    each counts for the drift, `sway` (dofs, uprights). Dofs that are `watched`: the first one is
    that of the record, `rest` where it was unloaded.
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
    watched: Indices
    rest: float


class Lost(NamedTuple):
    """Beyond what a structure is lost.

    Movement of the ends of a member across it over its length; `contraction` of a line of members
    over its length; least `length` of an element over its first one.
    """

    sideways: float
    contraction: float
    length: float


class Rows(NamedTuple):
    """What is read of each record (rows, ...).

    Of hinges (rows, hinges); how far the webs of members slide (rows, members), if any; the places
    of the watched dofs (rows, watched), and the `velocity` (rows,) of the first one.
    """

    axial_force: Array
    moment: Array
    plastic_rotation: Array
    sliding: Array
    watched: Array
    velocity: Array


class Pictures(NamedTuple):
    """States that may be drawn: of each turn, of the peak, and the last one (turns + 2, ...).

    `turns` (s), at or after which the first record is kept; `seen` (4,), how many have passed, the
    largest displacement, whether the last one was that, and how many pictures there are but the
    last two; of each the `time`, what dofs have `moved` and the forces `carried` by elements.
    """

    turns: Array
    seen: Array
    time: Array
    moved: Array
    carried: Array


class Reading(NamedTuple):
    """All that is read, `rows` of one stretch of the record and the rest of the whole of it.

    `most` (2, members), the largest shear force in an element of a member so far, and of the mean
    along it where no web slides; the largest `drift` (uprights,) so far; scratch (chains,).
    """

    places: Places
    lost: Lost
    rows: Rows
    pictures: Pictures
    most: Array
    drift: Array
    squashed: Array


@njit(cache=True, error_model="numpy", forceinline=True)
def read(reading, row, time, x, v, state):
    """Read the state of a record at a `time` (s); whether the structure is lost."""
    _picture(reading, time, x, state.carried)
    _hinges(reading.places, reading.rows, row, state)
    watched, start, sway = reading.places.watched, reading.places.start, reading.places.sway
    for i in range(watched.size):
        reading.rows.watched[row, i] = x[watched[i]]
    if watched.size > 0:
        reading.rows.velocity[row] = v[watched[0]]
    swaying, drift = reading.places.swaying, reading.drift
    for u in range(drift.size):
        across_line = 0.0
        for i in range(swaying.size):
            across_line += sway[i, u] * (x[swaying[i]] - start[i])
        drift[u] = max(drift[u], abs(across_line))
    return _members(reading, row, x, state)


@njit(cache=True, error_model="numpy", forceinline=True)
def _hinges(places, rows, row, state):
    local, plastic, lengths = state.local, state.plastic, places.lengths
    hinge, side, sign = places.hinge, places.side, places.sign
    for h in range(hinge.size):
        e, end = hinge[h], side[h]
        rows.axial_force[row, h] = local[e, 0]
        rows.moment[row, h] = sign[h] * local[e, 1 + end]
        turned = plastic[e, 1 + 2 * end] - plastic[e, 4] / lengths[e]
        rows.plastic_rotation[row, h] = sign[h] * turned


@njit(cache=True, error_model="numpy", forceinline=True)
def _members(reading, row, x, state):
    """Read shear and sliding of all members; whether one is lost."""
    places, lost, most, squashed = reading.places, reading.lost, reading.most, reading.squashed
    local, carried, plastic, deformed = state.local, state.carried, state.plastic, state.deformation
    slide, lengths, first, sliding = (
        places.slide,
        places.lengths,
        places.first,
        reading.rows.sliding,
    )
    corners, across, along, chain = places.corners, places.across, places.along, places.chain
    gone, squashed[:] = False, 0.0
    for m in range(first.size - 1):
        largest = total = stretched = slides = 0.0
        for e in range(first[m], first[m + 1]):
            longer = deformed[e, 0]
            if slide[e]:
                shear = (carried[e, 1] + carried[e, 2]) / lengths[e]
                slides += plastic[e, 4]
            else:
                chord = lengths[e] + (0.0 if places.first_order else longer)
                shear = (local[e, 1] + local[e, 2]) / chord
                total += shear
            largest = max(largest, abs(shear))
            stretched += longer
            gone = gone or longer < (lost.length - 1.0) * lengths[e]
        if sliding.size > 0:
            sliding[row, m] = slides
        most[0, m] = max(most[0, m], largest)
        most[1, m] = max(most[1, m], abs(total) / (first[m + 1] - first[m]))
        squashed[chain[m]] -= places.share[m] * stretched
        du = x[corners[m, 2]] - x[corners[m, 0]]
        dv = x[corners[m, 3]] - x[corners[m, 1]]
        apart = abs(du * across[m, 0] + dv * across[m, 1])
        left = 1.0 + du * along[m, 0] + dv * along[m, 1]
        if apart > lost.sideways * min(1.0, abs(left)):  # as good as never
            gone = gone or apart > lost.sideways * min(1.0, np.hypot(apart, left))
    for line in squashed:
        gone = gone or line > lost.contraction
    return gone


@njit(cache=True, error_model="numpy", forceinline=True)
def _picture(reading, time, x, carried):
    """Keep the state where it is the first at or after a turn; one after the largest so far.

    And always as the last one.
    """
    seen, turns, last = reading.pictures.seen, reading.pictures.turns, reading.pictures.turns.size
    if last == 0:
        return
    size = abs(x[reading.places.watched[0]] - reading.places.rest)
    before, passed, rose, count = int(seen[0]), int(seen[0]), seen[2] > 0.0, int(seen[3])
    while passed < last and turns[passed] <= time:
        passed += 1
    if passed > before:
        _draw(reading.pictures, count, time, x, carried)
        count += 1
    rising = size >= seen[1]
    if rose and not rising:
        _draw(reading.pictures, last, time, x, carried)
    _draw(reading.pictures, last + 1, time, x, carried)
    seen[0], seen[1], seen[2], seen[3] = passed, max(seen[1], size), rising, count


@njit(cache=True, error_model="numpy", forceinline=True)
def _draw(pictures, number, time, x, carried):
    pictures.time[number] = time
    copy(x, pictures.moved[number])
    copy(carried, pictures.carried[number])
