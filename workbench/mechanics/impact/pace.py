"""How an impact is stepped through: as long as the error allows, or steps of one length.

The midpoint rule errs by dt^3 / 12 times the rate of the acceleration of the impact point in its
displacement. A step ends at an impact, and a very short first step follows. Once the structure
has swung back below its largest displacement only the phase of a vibration is at stake, and longer
steps are taken; `late_peak` says whether that was too early. All constants of the integrator stand
here.
"""

from math import ceil, inf
from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit

# Tolerances: too small to move a peak, too large to be round-off.
SLACK = 1e-9  # m; in explicit steps a smaller gap is round-off and opens no lasting contact
LASTING = 1e-6  # of the way of the striker in one of equal steps: the same in implicit steps
CLOSE = 1e-8  # of the way of the striker in the first step, below which a gap is closed
CLOSER = 0.999  # of the gap, which a step may close before the short step of an impact
APART = 1e-9  # of the striker's first velocity; bodies that approach slower do not collide
SOFT = 1e-3  # of the striker's first velocity; what would rebound slower stays in contact
RELEASED = 0.95  # of a step in which a contact opens; one that opens later opens at its end
SLOWEST = 1e-3  # of the striker's first velocity: the impact point's by which steps err, at least
AT_REST = 1e-4  # of the velocity that the hit gives; a step that ends slower has met the peak
SHORTEST = 1e-6  # of the first step: the shortest step up to a collision at an instant
# Control of the length: a repeated step costs as much as a good one, so a miss of 30 % is kept.
REPEATED = 0.7  # a step that should have been shorter than this share of it is taken again
CUT, SUCCESSOR = 0.1, 0.3  # least shares of a length: of a repeated step, of the next step
LONGER = 2.0  # times as long a step may be as the one before, if a model says nothing else
PIECES = 4096  # into which the first step may be cut where equations have no solution
NEARLY = 0.99  # of the peak; long steps may have missed what is higher
EPS = 2.220446049250313e-16


class Pace(NamedTuple):
    """How an impact is stepped through; times in s.

    `duration` of the record; `first` step, after every impact too; `longest` step; `error` of the
    displacement of a step over the way that the impact point goes in it at the velocity of the hit
    (infinite: equal steps, each the `longest`), and that once the structure only vibrates; `flow`,
    how much hinges may flow in a step, in the measure of the model; shortest time between two
    records, `spacing`; steps at `most`.
    """

    duration: float
    first: float
    longest: float
    error: float
    vibration: float
    flow: float
    spacing: float
    most: int

    @classmethod
    def equal(cls, duration: float, step: float, most: int) -> "Pace":
        """Equal steps of a `step` (s), which are all recorded."""
        return cls(duration, step, step, inf, inf, inf, 1.001 * step, most)

    @property
    def records(self) -> int:
        """How many records it takes at most: of three, the outer ones are a spacing apart."""
        if not self.error < inf:
            return ceil(self.duration / self.longest) + 4
        return 2 * ceil(self.duration / self.spacing) + 4


def late_peak(
    pace: Pace,
    vibration_start: float,
    time: Array,
    displacement: Array,
    velocity: Array,
    percussion: Array,
) -> float:
    """Time (s) of a peak that came, or nearly came again, in the long steps of a vibration; else 0.

    Of the impact point, of all records (n,) of an impact that went at this pace, with long steps
    not before the time `vibration_start`, in SI units.
    """
    top = int(np.flatnonzero(displacement >= NEARLY * displacement.max())[-1])
    if not pace.error < inf:
        return 0.0
    below = displacement[1 : top + 1] < np.maximum.accumulate(displacement[:top])
    rising = (velocity[1 : top + 1] > 0.0) & (percussion[1 : top + 1] == 0.0)
    return float(time[top]) if (below & rising & (time[:top] >= vibration_start)).any() else 0.0


@njit(cache=True, error_model="numpy")
def next_step_size(pace, time, dt, gap, gamma):
    """`dt` (s), at most to the end of the record, the next of equal steps or the next impact."""
    if not pace.error < np.inf:
        ahead = (np.floor(time / pace.longest + 1e-6) + 1.0) * pace.longest - time
        return ahead if dt > (1.0 - 1e-6) * ahead else dt
    dt = min(dt, pace.duration - time)
    if gap > 0.0 and gamma < 0.0:
        return min(dt, max(-gap / gamma, pace.first))
    return dt


@njit(cache=True, error_model="numpy")
def contact_time(gap, start, end, dt, allowed):
    """Time (s) after which the gap (m) closes in an open step of `dt`.

    Arguments: velocities of the gap at both ends of the step, `start` and `end` (m/s). Infinite
    where the overlap grows by no more than is `allowed` (m).
    """
    if gap + 0.5 * dt * (start + end) > min(gap, 0.0) - allowed:
        return np.inf
    bend = (end - start) / dt
    above = max(gap, 0.0)
    if bend >= 0.0:
        return above / max(-start, 1e-300)
    return (start + (start * start - 2.0 * bend * above) ** 0.5) / -bend


@njit(cache=True, error_model="numpy")
def growth(pace, error, rate, dt, flow):
    """By which factor a smooth step of `dt` may be longer; below `REPEATED` it is repeated.

    Arguments: tolerated `error` of the displacement over dt (m/s); `rate` of the acceleration
    (m/s3); the measured `flow` of the hinges.
    """
    factor = 0.9 * (error / max(dt * dt / 12.0 * rate, 1e-300)) ** 0.5
    return min(factor, 0.9 * pace.flow / max(flow, 1e-300))


@njit(cache=True, error_model="numpy")
def step_factor(progress, pace, longer, cut, dt, change, free, flow):
    """The error controller: factor of the next step over one of `dt` (s); below 0: repeat this one.

    Arguments: `progress`, of `integrator.PROGRESS`; how much `longer` a step may be; least share of
    a repeated one, `cut`; `change` of the acceleration (m/s2) since the last step; whether
    the structure only vibrates, `free`; the measured `flow`. Writes the tolerated error into the
    progress.
    """
    if not (progress.smooth and pace.error < np.inf):
        return longer
    if free and progress.time >= progress.vibration_start:
        progress.error = pace.vibration
    trend = abs(change)
    if change * progress.change < 0.0:  # a velocity that rings from step to step keeps ringing
        trend = 0.5 * abs(change + progress.change)
    rate = trend / (0.5 * (dt + progress.before))
    factor = growth(pace, progress.error * progress.scale, rate, dt, flow)
    if factor < REPEATED and dt > pace.first:
        return -max(factor, cut)
    return min(max(factor, SUCCESSOR), longer)
