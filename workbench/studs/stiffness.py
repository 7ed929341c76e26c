"""Stiffness of a connection from its load-slip curve; unloading, permanent slip and reloading.

Chord from 10 to 40 % of the largest load (EN 1994-1-1 and AISC 360 speak of stiffness at such
levels), slope of a line fitted from 5 to 40 %, secants. A stud unloads along a straight line and
leaves a permanent slip; reloading follows the same line back to the envelope of first loading,
which then goes on as if nothing had happened. This is what the markers of the Lehigh push-outs show
below failure; it says nothing about fatigue. Units: SI.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.errors import InputError, OutOfDomainError
from workbench.fields import Declared, Number, checked
from workbench.studs.load_slip import Law
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


def chord_stiffness(slip: ArrayLike, load: ArrayLike, low: float = 0.1, high: float = 0.4) -> float:
    """Slope in N/m of the chord between two levels of the largest load; a secant with `low` = 0.

    Between points the curve is linear, and a level counts where it is first reached. Raises
    `OutOfDomainError` when both levels are reached at one slip.
    """
    _levels(low, high)
    s, q = ascending(slip, load)
    start, end = np.interp(np.array([low, high]) * q[-1], q, s)
    run = end - start
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


def law_stiffness(law: Law, load: float, low: float = 0.1, high: float = 0.4) -> float:
    """Chord stiffness in N/m of a law with the largest `load` in N."""
    _levels(low, high)
    start = law.slip_at(low) if low > 0.0 else 0.0
    return (high - low) * load / (law.slip_at(high) - start)


def _levels(low: float, high: float) -> None:
    if not 0.0 <= low < high < 1.0:
        raise InputError("levels", (low, high), "must rise, from 0 to below 1")


_ABSCISSAE, _WEIGHTS = np.polynomial.legendre.leggauss(24)


class CyclicState(NamedTuple):
    """What a stud remembers: the largest slip reached, and the slip at which it is free of load."""

    largest_slip: float
    permanent_slip: float


@dataclass(frozen=True)
class UnloadingLaw(Declared, table="law"):
    """An envelope with straight unloading and reloading.

    Arguments: `envelope`, a law of first loading; `strength`, its largest load in N;
    `stiffness_ratio`, slope of unloading over the 10-40 % chord stiffness of the envelope. The
    slope is never so low that slip is regained beyond the origin, or more work than was done.
    """

    envelope: Law
    strength: float = checked(Number(1.0, 1e8, "N", advice="loads are in N: 100 kN is 100e3"))
    stiffness_ratio: float = checked(Number(0.05, 20.0), 1.0)

    @property
    def slope(self) -> float:
        """Slope of unloading in N/m, before the limit by the secant."""
        return self.stiffness_ratio * law_stiffness(self.envelope, self.strength)

    def permanent_slip(self, largest_slip: float) -> float:
        """Slip (m) that is left when the stud is unloaded from `largest_slip` (m)."""
        load = self._load(largest_slip)
        if largest_slip <= 0.0 or load <= 0.0:
            return max(largest_slip, 0.0)
        regained = min(load / self.slope, 2.0 * self._work(largest_slip) / load)
        return max(largest_slip - regained, 0.0)

    def load(self, slip: float, state: CyclicState) -> tuple[float, CyclicState]:
        """Load (N) at a slip (m) and the new state, from the state before.

        Raises `OutOfDomainError` below the permanent slip, where the stud would be pushed the
        other way.
        """
        if slip >= state.largest_slip:
            return self._load(slip), CyclicState(slip, self.permanent_slip(slip))
        if slip < state.permanent_slip:
            raise OutOfDomainError(
                f"slip {slip:g} m lies below the permanent slip {state.permanent_slip:g} m: "
                "reversed loading is outside the law"
            )
        top = self._load(state.largest_slip)
        share = (slip - state.permanent_slip) / (state.largest_slip - state.permanent_slip)
        return top * share, state

    def follow(self, path: ArrayLike) -> Array:
        """Loads (n,) in N along a path of slips (n,) in m that starts undamaged."""
        state = CyclicState(0.0, 0.0)
        loads = np.empty(len(np.asarray(path)))
        for i, slip in enumerate(np.asarray(path, float)):
            loads[i], state = self.load(float(slip), state)
        return loads

    def _work(self, slip: float) -> float:
        """Work (J) of first loading to a slip (m)."""
        # points at slip t^2: the slope at zero may be infinite
        t = 0.5 * (1.0 + _ABSCISSAE)
        loads = self.strength * self.envelope.ratio(slip * t * t)
        return float(np.sum(_WEIGHTS * loads * t) * slip)

    def _load(self, slip: float) -> float:
        return self.strength * float(self.envelope.ratio(slip))


def unloadings(points: pd.DataFrame) -> pd.DataFrame:
    """The unloadings among the points of a table (schema `POINTS`) with inferred starts.

    Columns: campaign, specimen; slips in m and loads in N of the start (`start_slip`,
    `start_load`) and of a reading on the way down (`slip`, `load`); `slope` in N/m; and the line
    extended to zero load, `permanent_slip` in m and its `ratio` to the start. Of several readings
    of one start the lowest load counts: others may lie on the way of reloading. Raises
    `InputError` when there is none.
    """
    needed = ["probable_unloading_slip_mm", "probable_unloading_load_kN"]
    known = points[np.isfinite(points[needed].to_numpy(float)).all(axis=1)]
    equal = ["campaign", "specimen", needed[0]]
    lowest = known.sort_values("load_kN", kind="stable").drop_duplicates(equal).sort_index()
    rows = lowest[["campaign", "specimen"]].assign(
        start_slip=1e-3 * lowest[needed[0]],
        start_load=1e3 * lowest[needed[1]],
        slip=1e-3 * lowest["slip_mm"],
        load=1e3 * lowest["load_kN"],
    )
    # otherwise there is no way down: the inferred start does not belong to the reading
    rows = rows[(rows["slip"] < rows["start_slip"]) & (rows["load"] < rows["start_load"])]
    if rows.empty:
        raise InputError("points", len(points), "hold no unloading with a known start")
    slope = (rows["start_load"] - rows["load"]) / (rows["start_slip"] - rows["slip"])
    left = rows["start_slip"] - rows["start_load"] / slope
    ratio = left / rows["start_slip"]
    found: pd.DataFrame = rows.assign(slope=slope, permanent_slip=left, ratio=ratio)
    return found
