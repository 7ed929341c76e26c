"""Records of a march, read once for all models: histories, peak, why it ended."""

from math import isnan, pi, prod, sqrt
from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit
from workbench.base.errors import SolverError
from workbench.mechanics.impact.crushing import CRUSH, UNLOADING
from workbench.mechanics.impact.integrator import COLLAPSE, NO_CONVERGENCE, PROGRESS, TOO_MANY
from workbench.mechanics.impact.pace import PIECES, Pace
from workbench.responses.kernels import first_peak, signed_peak
from workbench.scenarios import Striker

RECORDS = 40, 20_000  # of a period in which a striker is crushed, of a whole record at most


class Run(NamedTuple):
    """A followed impact: table of `records`, `progress` at the end, whether it `collapsed`."""

    records: Any
    progress: Any
    collapsed: bool

    @property
    def histories(self) -> dict[str, Array]:
        """The columns of the records."""
        return histories_of(self.records)

    def peak(self, bounces: bool = False) -> dict[str, float]:
        """Largest displacement at which the hit point stood still, and when; empty without one.

        Negative where it swings back farther.
        With `bounces` the column may come as far again: then the time is that of the first peak.
        """
        peak, when = standstill(self.records, self.progress, bounces)
        return {} if isnan(peak) else {"peak_displacement": peak, "time_of_peak": when}


@njit(cache=True, error_model="numpy")
def standstill(records, progress, bounces):
    """Peak (m) of an impact and its time (s), see `Run.peak`; NaN without one."""
    time, v = records["time"], records["displacement"]
    largest, at, grows = signed_peak(time, v)
    if grows or not progress.peak > 0.0:
        return np.nan, np.nan
    if largest < 0.0:
        return largest, at
    when = progress.time_of_peak
    if bounces:
        first = first_peak(time, v)[1]
        if np.searchsorted(time, when) - np.searchsorted(time, first) > 1:
            when = first
    return progress.peak, when


def follow(
    entry: Any,
    tables: tuple[Any, ...],
    pace: Pace,
    drive: tuple[float, ...],
    of: Any,
    striker: Striker | None = None,
    gravity: float = 0.0,
) -> Run:
    """Follow one impact by the compiled `entry` of a model.

    Arguments: the `tables` that it takes first; `pace`; the `drive` after it, see
    `integrator.begin`; the type `of` its records; the `striker`, for the law by which it crushes,
    and the `gravity` (m/s2) along its flight. Raises `SolverError`.
    """
    progress, records = np.zeros(1, PROGRESS), np.empty(pace.records, of)
    progress["gravity"] = gravity
    if striker is not None and striker.crushes:
        progress["crush"] = law_of(striker)
    status, rows = entry(*tables, np.array((*pace, *drive)), progress, records)
    check_end(status, progress[0], pace)
    return Run(records[:rows], progress[0], status == COLLAPSE)


def check_end(status: int, reached: Any, pace: Pace) -> None:
    """Raise `SolverError` where a march has stopped before the end, as far as it has `reached`."""
    if status in (NO_CONVERGENCE, TOO_MANY):
        where = f"time {reached['time']:.6g} s"
        tried = f"open and closed contact, steps down to 1/{PIECES} of the first"
        if status == TOO_MANY:
            tried = f"{pace.most} steps; a softer or heavier structure needs fewer"
        raise SolverError(where, float(reached["residual"]), tried)


def histories_of(records: Any) -> dict[str, Array]:
    """The columns of a table of numbers as arrays of their own, time last."""
    flat = records.view(float).reshape(len(records), -1).T.copy()
    return {
        name: flat[at // 8 : at // 8 + prod(of.shape)].reshape(*of.shape, -1)
        for name, (of, at) in records.dtype.fields.items()
    }


def law_of(striker: Striker | None) -> Any:
    """The law of a striker as a record of CRUSH, not yet crushed; without points if it is rigid."""
    law = np.zeros(1, CRUSH)
    if striker is not None and striker.crushes:
        points = np.array(striker.crush or [(0.0, 0.0)])
        slopes = np.diff(points[:, 1]) / np.diff(points[:, 0])
        law["points"], law["beyond"] = len(points), striker.stiffness or 0.0
        law["strokes"][0, : len(points)], law["forces"][0, : len(points)] = points.T
        law["unloading"] = UNLOADING * max(slopes.max(initial=0.0), law["beyond"][0])
    return law[0]


def followed(pace: Pace, striker: Striker, struck: float) -> Pace:
    """The pace at which the force of a crushing striker on a mass (kg) is recorded as it swings."""
    if not striker.crushes or not pace.error < np.inf:
        return pace
    slope = float(law_of(striker)["unloading"]) / UNLOADING
    period = 2.0 * pi / sqrt(slope * (1.0 / struck + 1.0 / striker.mass))
    spacing = min(pace.spacing, max(period / RECORDS[0], pace.duration / RECORDS[1]))
    return pace._replace(spacing=spacing)
