"""Predictions held against tests that no fit has used: bias with its interval, the worst test."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.studs.quantities import Array, Specimens, specimens, undamaged_headed_studs
from workbench.studs.statistics.intervals import Interval, profile_interval
from workbench.studs.statistics.mixed import fit
from workbench.studs.statistics.problem import problem


@dataclass(frozen=True)
class Judgement:
    """Test over prediction in tests that the prediction has not used.

    `bias`, median ratio with its `interval` (None with one test: it tells no scatter); `least`, the
    smallest ratio, and `worst`, the test that has it; `scatter` of the log ratio, between campaigns
    included (None with one test); `rows`, campaign, specimen, test, prediction and ratio.
    """

    bias: float
    interval: Interval | None
    least: float
    worst: str
    scatter: float | None
    rows: pd.DataFrame

    @property
    def half_width(self) -> float | None:
        """Distance of the bias from the farther end of its interval (None: not known)."""
        if self.interval is None or self.interval.low is None or self.interval.high is None:
            return None
        return max(self.bias - self.interval.low, self.interval.high - self.bias)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the rows, ready for JSON."""
        return {
            "tests": len(self.rows),
            "campaigns": sorted(set(self.rows["campaign"])),
            "test_over_prediction": self.bias,
            "interval": None if self.interval is None else self.interval.to_dict(),
            "least_test_over_prediction": self.least,
            "worst": self.worst,
            "scatter": self.scatter,
        }


def judge(rows: pd.DataFrame, confidence: float = 0.9) -> Judgement:
    """Judge predictions: rows with campaign, specimen, test and prediction, all positive.

    Raises `InputError` without rows.
    """
    if rows.empty:
        raise InputError("validation", 0, "holds no test that the model can answer")
    ratio = rows["test"].to_numpy(float) / rows["prediction"].to_numpy(float)
    judged = rows.assign(ratio=ratio).reset_index(drop=True)
    worst = judged.loc[int(np.argmin(ratio))]
    name = f"{worst['campaign']} {worst['specimen']}"
    logarithms = np.log(ratio)
    if len(ratio) < 2:
        return Judgement(float(ratio[0]), None, float(ratio.min()), name, None, judged)
    given = problem(
        logarithms, judged["campaign"].to_numpy(str), None, ("median",),
        [float(np.median(logarithms))], design=np.ones((len(ratio), 1)),
    )  # fmt: skip
    estimate = fit(given)
    found = profile_interval(estimate, "median", confidence)
    low, high = (None if v is None else float(np.exp(v)) for v in (found.low, found.high))
    return Judgement(
        float(np.exp(estimate.theta[0])), Interval(low, high, confidence, found.method),
        float(ratio.min()), name, float(np.hypot(estimate.sigma, estimate.tau)), judged,
    )  # fmt: skip


def judge_formula(
    table: pd.DataFrame, formula: Callable[[Specimens], Array], confidence: float = 0.9
) -> Judgement:
    """Judge a formula of shear resistance by the undamaged headed studs of a table.

    Arguments: `formula` gives the resistance (n,) in N of tests. Raises `InputError` without such
    tests.
    """
    rows = undamaged_headed_studs(table)
    prediction = formula(specimens(rows))
    known = np.isfinite(prediction)
    frame = pd.DataFrame(
        {
            "campaign": rows["campaign"], "specimen": rows["specimen"],
            "test": 1e3 * rows["shear_kN"].astype(float), "prediction": prediction,
        }
    )  # fmt: skip
    return judge(frame[known], confidence)
