"""Stiffness of a connection from its load-slip curve, by the definitions in use.

Chord from 10 to 40 % of the largest load (EN 1994-1-1 and AISC 360 speak of stiffness at such
levels), slope of a line fitted from 5 to 40 %, secants. Levels refer to the largest load.
Units: SI.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError, OutOfDomainError
from workbench.studs.load_slip import LoadSlipLaw
from workbench.studs.quantities import Array


def ascending(slip: ArrayLike, load: ArrayLike) -> tuple[Array, Array]:
    """The ascending branch of a measured curve from the origin: slips (n,) m and loads (n,) N.

    The branch starts at the origin, ends at the largest load, and keeps only points that exceed
    all loads before, so that unloading loops and noise below the envelope drop out. Raises
    `InputError` for fewer than two points or no positive load.
    """
    s, q = np.atleast_1d(np.asarray(slip, float)), np.atleast_1d(np.asarray(load, float))
    if s.shape != q.shape or s.ndim != 1 or len(s) < 2 or not np.all(np.isfinite([s, q])):
        raise InputError("curve", (s.shape, q.shape), "must be two or more points (slip, load)")
    order = np.argsort(s, kind="stable")
    s, q = s[order], q[order]
    end = int(np.argmax(q))
    if q[end] <= 0.0:
        raise InputError("curve", float(q[end]), "must hold a positive load")
    s, q = s[: end + 1], q[: end + 1]
    rising = q > np.concatenate([[0.0], np.maximum.accumulate(q)[:-1]])
    keep = rising & (s >= 0.0)
    return np.concatenate([[0.0], s[keep]]), np.concatenate([[0.0], q[keep]])


def slip_at_level(slip: ArrayLike, load: ArrayLike, level: float) -> float:
    """Slip (m) at which a measured curve first reaches `level` times its largest load.

    Between points the curve is linear. Raises `InputError`.
    """
    s, q = ascending(slip, load)
    if not 0.0 < level <= 1.0:
        raise InputError("level", level, "must lie above 0 up to 1")
    return float(np.interp(level * q[-1], q, s))


def chord_stiffness(slip: ArrayLike, load: ArrayLike, low: float = 0.1, high: float = 0.4) -> float:
    """Slope in N/m of the chord between two levels of the largest load; a secant with `low` = 0.

    Raises `OutOfDomainError` when both levels are reached at one slip.
    """
    _levels(low, high)
    s, q = ascending(slip, load)
    start = slip_at_level(s, q, low) if low > 0.0 else 0.0
    run = slip_at_level(s, q, high) - start
    if run <= 0.0:
        raise OutOfDomainError(f"no slip was measured between {low:g} and {high:g} of the maximum")
    return float((high - low) * q[-1] / run)


def fitted_stiffness(
    slip: ArrayLike, load: ArrayLike, low: float = 0.05, high: float = 0.4
) -> float:
    """Slope in N/m of the least-squares line through the measured points between two levels.

    Raises `OutOfDomainError` for fewer than two points in between.
    """
    _levels(low, high)
    s, q = ascending(slip, load)
    inside = (q >= low * q[-1]) & (q <= high * q[-1])
    if np.sum(inside) < 2 or np.ptp(s[inside]) == 0.0:
        raise OutOfDomainError(
            f"fewer than two points lie between {low:g} and {high:g} of the maximum"
        )
    return float(np.polyfit(s[inside], q[inside], 1)[0])


def law_stiffness(law: LoadSlipLaw, load: float, low: float = 0.1, high: float = 0.4) -> float:
    """Chord stiffness in N/m of a law with the largest `load` in N."""
    _levels(low, high)
    start = law.slip_at(low) if low > 0.0 else 0.0
    return (high - low) * load / (law.slip_at(high) - start)


def _levels(low: float, high: float) -> None:
    if not 0.0 <= low < high < 1.0:
        raise InputError("levels", (low, high), "must rise, from 0 to below 1")
