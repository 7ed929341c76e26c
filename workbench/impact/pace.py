"""How an impact is stepped through: as long as the error allows, or steps of one length.

What the models that step by error share. The trapezoidal rule errs by dt^3 / 12 times the rate of
the acceleration of the hit point in its displacement. An impact is stepped on to and followed by a
first, very short step, so that its instant is found. After the first rebound only the phase of an
elastic vibration is at stake, and longer steps are taken; `late_peak` tells where more was.
"""

from math import ceil, inf
from typing import NamedTuple

import numpy as np

from workbench.arrays import Array
from workbench.compiled import njit

NEARLY = 0.99  # of the peak; long steps may have missed what is higher
PIECES = 64  # into which the shortest step may be cut where it does not converge


class Pace(NamedTuple):
    """How an impact is stepped through; times in s.

    `duration` of the record; `first` step, after every impact too; `longest` step; `error` of the
    displacement of a step over the way that the striker goes in it (infinite: equal steps, each
    the `longest`), and that once the structure only vibrates; `flow`, how much hinges may flow in a
    step, in the measure of the model; shortest time between two records, `spacing`; steps at
    `most`.
    """

    duration: float
    first: float
    longest: float
    error: float
    vibration: float
    flow: float
    spacing: float
    most: int

    @property
    def records(self) -> int:
        """How many records it takes at most: of three, the outer ones are a spacing apart."""
        return 2 * ceil(self.duration / self.spacing) + 4


def late_peak(
    pace: Pace, calm: float, time: Array, displacement: Array, velocity: Array, percussion: Array
) -> float:
    """Time (s) of a peak that came, or nearly came again, in the long steps of a vibration; else 0.

    Of the hit point, of all records (n,) of an impact that went at this pace, with long steps not
    before the time `calm`, in SI units.
    """
    top = int(np.flatnonzero(displacement >= NEARLY * displacement.max())[-1])
    if not pace.error < inf:
        return 0.0
    below = displacement[1 : top + 1] < np.maximum.accumulate(displacement[:top])
    rising = (velocity[1 : top + 1] > 0.0) & (percussion[1 : top + 1] == 0.0)
    return float(time[top]) if (below & rising & (time[:top] >= calm)).any() else 0.0


@njit(cache=True, error_model="numpy")
def aimed(pace, time, dt, gap, gamma):
    """The step that does not go beyond the end, the next of equal steps, or the next impact."""
    dt = min(dt, pace.duration - time)
    if not pace.error < np.inf:
        return min(dt, (np.floor(time / pace.longest + 1e-6) + 1.0) * pace.longest - time)
    if gap > 0.0 and gamma < 0.0:
        return min(dt, max(-gap / gamma, pace.first))
    return dt


@njit(cache=True, error_model="numpy")
def met(gap, start, end, dt, allowed):
    """When the gap (m) closes in an open step of `dt`, whose ends see it grow by `start` and `end`.

    Infinite where the overlap grows by no more than is `allowed` (m).
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
    """By which factor a smooth step of `dt` may be longer; below 0.7 it is repeated.

    Arguments: tolerated `error` of the displacement over dt (m/s); `rate` of the acceleration
    (m/s3); the measured `flow` of the hinges.
    """
    factor = 0.9 * (error / max(dt * dt / 12.0 * rate, 1e-300)) ** 0.5
    return min(factor, 0.9 * pace.flow / max(flow, 1e-300))
