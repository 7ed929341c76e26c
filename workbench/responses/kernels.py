"""Loops over histories. Imported where these are reduced alone: reading responses needs none."""

import numpy as np

from workbench.base.compiled import njit

_EQUAL = 0.995  # of the largest displacement, which is its peak too
_SAMPLED = 0.95  # of it, the least that samples may show of such a peak: a tenth of a cycle aside


@njit(cache=True, error_model="numpy")
def apex(time, displacement, top):
    """Value and time of the parabola's apex by the highest of three points; NaN: times fall."""
    before, after = time[top - 1] - time[top], time[top + 1] - time[top]
    if not before < 0.0 < after:
        return np.nan, np.nan
    fall_before = (displacement[top - 1] - displacement[top]) / before
    fall_after = (displacement[top + 1] - displacement[top]) / after
    curvature = (fall_after - fall_before) / (after - before)
    slope = fall_after - curvature * after
    shift = 0.0 if curvature >= 0.0 else min(max(-0.5 * slope / curvature, before), after)
    return displacement[top] + (slope + curvature * shift) * shift, time[top] + shift


@njit(cache=True, error_model="numpy")
def first_peak(time, displacement):
    """Peak of a history upwards, and the time of the first one that is as high; see `peak_of`.

    The time is NaN where times do not increase.
    """
    top = np.argmax(displacement)
    if top == 0:
        return displacement[0], time[0]
    largest, at = displacement[top], time[top]
    if top < displacement.size - 1:
        largest, at = apex(time, displacement, top)
    for i in range(1, top):
        before, here, after = displacement[i - 1], displacement[i], displacement[i + 1]
        if here > before and here >= after and here >= _SAMPLED * largest:
            value, earlier = apex(time, displacement, i)
            if not value < _EQUAL * largest:
                return largest, earlier
    return largest, at


@njit(cache=True, error_model="numpy")
def side_of(time, displacement):
    """Sign, 1 or -1, of the value of largest magnitude; of two as large that of the first one."""
    high, first = first_peak(time, displacement)
    low, other = first_peak(time, -displacement)
    if min(high, low) < _EQUAL * max(high, low):
        return 1.0 if high > low else -1.0
    return -1.0 if other < first else 1.0


@njit(cache=True, error_model="numpy")
def signed_peak(time, displacement):
    """Value of largest magnitude with its sign, the time of the first one; see `peak_of`.

    And whether the last value is the largest: then the record shows no peak, it still grows.
    """
    side = side_of(time, displacement)
    upward = side * displacement
    largest, at = first_peak(time, upward)
    return side * largest, at, np.argmax(upward) == displacement.size - 1


@njit(cache=True, error_model="numpy")
def mean_of_cycles(time, displacement, begin=0):
    """Mean over the whole cycles after the peak, between crossings of the mid-level towards it.

    That is of the record after its first turn behind the peak, and behind the row `begin`. NaN if
    there is no whole cycle.
    """
    side, last = side_of(time, displacement), displacement.size - 1
    displacement = side * displacement
    start = max(np.argmax(displacement), begin)
    while start < last and not displacement[start + 1] > displacement[start]:
        start += 1
    high = low = displacement[start]
    for i in range(start, last + 1):
        high, low = max(high, displacement[i]), min(low, displacement[i])
    level, count, area = 0.5 * (high + low), 0, 0.0
    first = final = whole = 0.0
    for i in range(start, last):
        left, right, step = displacement[i], displacement[i + 1], time[i + 1] - time[i]
        full = 0.5 * step * (left + right)
        if left < level <= right:
            part = step * (level - left) / (right - left)
            before = 0.5 * part * (left + level)
            if count == 0:
                first, area = time[i] + part, -before
            final, whole = time[i] + part, area + before
            count += 1
        if count > 0:
            area += full
    return side * whole / (final - first) if count > 1 else np.nan


@njit(cache=True, error_model="numpy")
def largest_window(time, percussion, window):
    """Largest sum of percussions (N s) of steps that end at a `time` (s), within a `window` (s).

    The impulse rises linearly within a step: the best window starts or ends on a step.
    """
    last = percussion.size
    while last > 1 and percussion[last - 1] == 0.0:  # a window that ends later has no more
        last -= 1
    at, impulse = np.empty(last + 1), np.empty(last + 1)
    at[0], impulse[0] = 2.0 * time[0] - time[1] if time.size > 1 else time[0] - window, 0.0
    for i in range(last):
        at[i + 1], impulse[i + 1] = time[i], impulse[i] + percussion[i]
    most, behind, ahead = -np.inf, 0, 0
    for i in range(at.size):
        early, late = at[i] - window, at[i] + window
        while behind < last and at[behind + 1] <= early:
            behind += 1
        while ahead < last and at[ahead + 1] <= late:
            ahead += 1
        ending = impulse[i] - _between(at, impulse, behind, early)
        starting = _between(at, impulse, ahead, late) - impulse[i]
        most = max(most, max(ending, starting))
    return most


@njit(cache=True, error_model="numpy")
def _between(at, values, i, x):
    """Value at `x`, in the interval after the place `i`; constant beyond the ends."""
    if x <= at[i] or i == at.size - 1:
        return values[i]
    slope = (values[i + 1] - values[i]) / (at[i + 1] - at[i])
    return slope * (x - at[i]) + values[i]
