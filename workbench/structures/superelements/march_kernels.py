"""Going through an impact of superelements in one call: the length of the steps, and the records.

Steps are as long as two measures allow, or of one length: the error of the displacement of the hit
point, see `workbench.impact.pace`; and what hinges spend to `settle` after a step, which shows
where they begin to flow, ring, or follow the surface around a bend. Velocities jump within the
step of an impact, which is short for that. Axial vibrations of the bars are not resolved: the
midpoint scheme keeps their energy at any step.
"""

from typing import Any, NamedTuple

import numpy as np

from workbench.arrays import Array, Indices
from workbench.compiled import njit
from workbench.impact.pace import aimed, growth, met
from workbench.structures.kernels import copy
from workbench.structures.superelements.kernels import settle
from workbench.structures.superelements.step_kernels import commit, gap_of, solve

CUTS = 4096  # pieces into which the shortest step may be cut where it does not converge
LONGER = 1.5  # times as long a step may be as the one before
BACK = 4.0  # the same on the way back to equal steps, which impacts interrupt
CLOSER = 0.999  # of the way to the next impact: contact closes where a step would end in overlap
GOING, DONE, COLLAPSED, NO_CONVERGENCE, TOO_MANY = range(5)
_NUMBERS = (
    *("time", "length", "striker_position", "striker_velocity", "impulse", "contact_loss"),
    *("stored", "plastic", "algorithmic", "ideal", "external_work", "kinetic"),
)
RECORD = np.dtype([(name, "f8") for name in _NUMBERS] + [("evaluations", "i8"), ("cuts", "i8")])
_CLOCK = (
    *("time", "calm", "dt", "before", "acceleration", "change", "highest", "error", "residual"),
)
CLOCK = np.dtype(
    [(name, "f8") for name in _CLOCK] + [("begun", "?"), ("smooth", "?"), ("steps", "i8")]
)


class States(NamedTuple):
    """Committed states of records: `x` and `v` (records, dofs), and of all elements, `elements`."""

    x: Array
    v: Array
    elements: Any


class CollapseLimits(NamedTuple):
    """Beyond what a structure has collapsed; why it has is for `frames.collapse_watch` to say.

    Movement of the ends of a member `sideways` over its length; `contraction` of a line of members
    over its length; least `length` of an element over its first one. Of each member the number of
    its `first` element (members + 1,); dofs u, v of both `corners` (members, 4), and what of the
    movement of its end counts `across` and `along` (members, 2), over the length; which `chain` of
    members in a straight line it is in, and its `share` of that in 1/m.
    """

    sideways: float
    contraction: float
    length: float
    first: Indices
    corners: Indices
    across: Array
    along: Array
    chain: Indices
    share: Array


@njit(cache=True, error_model="numpy")
def collapsed(limits, lengths, x, deformation):
    """Whether a state with displacements `x` and these element deformations is beyond a limit."""
    first, corners, across, along = limits.first, limits.corners, limits.across, limits.along
    squashed = np.zeros(limits.chain.size)
    for m in range(limits.chain.size):
        stretched = 0.0
        for e in range(first[m], first[m + 1]):
            stretched += deformation[e, 0]
            if deformation[e, 0] < (limits.length - 1.0) * lengths[e]:
                return True
        squashed[limits.chain[m]] -= limits.share[m] * stretched
        du = x[corners[m, 2]] - x[corners[m, 0]]
        dv = x[corners[m, 3]] - x[corners[m, 1]]
        apart = abs(du * across[m, 0] + dv * across[m, 1])
        left = 1.0 + du * along[m, 0] + dv * along[m, 1]
        # a chord that turns over passes all of what is left between its ends, see `CollapseWatch`
        if apart > limits.sideways * min(1.0, np.hypot(apart, left)):
            return True
    return squashed.size > 0 and squashed.max() > limits.contraction


@njit(cache=True, error_model="numpy")
def _keep(states, row, motion):
    """Write the committed state into a row of the states."""
    copy(motion.x, states.x[row])
    copy(motion.v, states.v[row])
    copy(motion.old.plastic, states.elements.plastic[row])
    copy(motion.old.carried, states.elements.carried[row])
    copy(motion.old.local, states.elements.local[row])
    copy(motion.old.deformation, states.elements.deformation[row])


@njit(cache=True, error_model="numpy")
def advance(body, limits, pace, motion, work, clock, records, states):
    """Go on until the records are full or the impact is over; returns (status, records).

    Or until the structure has collapsed, beyond the limits, in the last record. The first record
    of all is that of the start.
    """
    row, d, end = 0, body.dof, pace.duration * (1.0 - 1e-12)
    controlled, scale = pace.error < np.inf, abs(body.speed)
    energy = 0.5 * body.striker * body.speed**2
    if not clock.begun:
        _keep(states, row, motion)
        row, clock.begun = 1, True
    while clock.time < end and row < records.size:
        record = records[row]
        gap, gamma = gap_of(body, motion)
        dt = aimed(pace, clock.time, clock.dt, CLOSER * gap, gamma)
        if gap + dt * gamma <= 0.0 and gamma < -1e-9 * scale and not controlled:
            dt = min(dt, pace.first)
        clock.steps += 1
        if clock.steps > pace.most:
            return TOO_MANY, row
        done, percussion, clock.residual, spent = solve(body, motion, work, dt)
        record.evaluations += spent
        if not done:
            record.cuts += 1
            clock.dt = 0.5 * dt
            if clock.dt < pace.first / CUTS:
                return NO_CONVERGENCE, row
            continue
        moved, v0 = body.sign * (work.x[d] - motion.x[d]), body.sign * motion.v[d]
        v1 = 2.0 * moved / dt - v0
        acceleration = (v1 - v0) / dt
        change = acceleration - clock.acceleration
        if controlled and percussion == 0.0 and dt > pace.first:
            meeting = met(gap, gamma, v1 - motion.striker[1], dt, pace.error * scale * dt)
            if meeting < dt:
                clock.dt = max(meeting, pace.first)
                continue
        energies = settle(0.5, body.hinges, motion.old, motion.new)
        struck = percussion > 0.0 and gamma < -1e-9 * scale
        factor = LONGER if controlled else BACK
        if struck:
            factor, clock.error = 0.0, pace.error
        if controlled and clock.smooth and not struck:
            back = body.sign * work.x[d] < clock.highest and v1 > 0.0 and percussion == 0.0
            if back and clock.time >= clock.calm:
                clock.error = pace.vibration
            trend = abs(change)
            if change * clock.change < 0.0:  # a velocity that rings from step to step keeps ringing
                trend = 0.5 * abs(change + clock.change)
            rate = trend / (0.5 * (dt + clock.before))
            flow = (max(energies[4], 0.0) / energy) ** 0.5
            factor = growth(pace, clock.error * scale, rate, dt, flow)
            if factor < 0.7 and dt > pace.first:
                clock.dt = max(dt * max(factor, 0.2), pace.first)
                continue
            factor = min(max(factor, 0.3), LONGER)
        commit(body, motion, work, dt, percussion, energies, record)
        if not struck:
            clock.change = change if clock.smooth else 0.0
            clock.acceleration = acceleration
        clock.smooth, clock.before, clock.time = not struck, dt, clock.time + dt
        clock.highest = max(clock.highest, body.sign * motion.x[d])
        clock.dt = min(max(dt * factor, pace.first), pace.longest)
        if record.length >= pace.spacing or not clock.time < end:
            record.time = clock.time
            _keep(states, row, motion)
            row += 1
            if collapsed(limits, body.bars.lengths, motion.x, motion.old.deformation):
                return COLLAPSED, row
    return GOING if clock.time < end else DONE, row
