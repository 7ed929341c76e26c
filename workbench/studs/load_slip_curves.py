"""Load-slip curves of a table: those of first loading, and how a law meets them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.studs.fit_protocol import Content, Judgement, Told, judge
from workbench.studs.load_slip import Law, chord_stiffness, law_stiffness, misfit
from workbench.studs.quantities import Array

Band = Callable[[Array, float], tuple[Array, Array]]  # bounds at slips (m) for a share of points
Curve = tuple[dict[str, str], Array, Array]  # names, slips (m), loads (N)


def first_loading(points: pd.DataFrame, *, falling: bool) -> pd.DataFrame:
    """Points that belong to the first loading of single specimens, with loads and slips in SI.

    Unloading readings, mean curves and doubtful points (`use_for_fit` 0) are left out, and the
    `falling` branch unless it is wanted. Raises `InputError` if nothing is left.
    """
    kept = (points["single_specimen"] == 1.0) & (points["on_envelope"] == 1.0)
    kept &= points["use_for_fit"] == 1.0
    kept &= ~points["branch"].isin(["low-load reading", "later loading"])
    if not falling:
        kept &= points["branch"] != "post-peak"
    if not kept.any():
        raise InputError("points", len(points), "hold no point of a first loading to be fitted")
    rows = points[kept]
    slip, load = 1e-3 * rows["slip_mm"].astype(float), 1e3 * rows["load_kN"].astype(float)
    return rows[["campaign", "specimen"]].assign(slip=slip, load=load)


def curves_of(
    points: pd.DataFrame, *, falling: bool
) -> Iterator[tuple[dict[str, str], Array, Array]]:
    """Names, slips (m) and loads (N) of every curve of a table (schema `POINTS`)."""
    used = first_loading(points, falling=falling)
    for (campaign, specimen), curve in used.groupby(["campaign", "specimen"], sort=False):
        names = {"campaign": str(campaign), "specimen": str(specimen)}
        yield names, curve["slip"].to_numpy(float), curve["load"].to_numpy(float)


@dataclass(frozen=True)
class CurveJudgement:
    """A law on curves that no fit has used.

    `rows`, one per curve: campaign, specimen, points, rms and bias of the load over the largest
    load, share of its points inside the band (`inside`, NaN without a band); `stiffness`, test over
    prediction of the chord stiffness at the measured strength (None where no curve tells it);
    `coverage`, mean of `inside` over the curves (None without a band).
    """

    rows: pd.DataFrame
    stiffness: Judgement | None
    coverage: float | None
    confidence: float

    @property
    def coverage_half_width(self) -> float | None:
        """Half-width of the interval of the coverage over curves; None with a single one.

        At least one curve more or less.
        """
        from scipy.special import stdtrit

        count = len(self.rows)
        if self.coverage is None or count < 2:
            return None
        error = float(self.rows["inside"].std(ddof=1)) / np.sqrt(count)
        width = float(stdtrit(count - 1.0, 0.5 + 0.5 * self.confidence) * error)
        return max(width, 1.0 / count)

    @property
    def told(self) -> dict[str, Told]:
        """What a model is compared by; a coverage stays between none and all."""
        coverage, width, stiffness = Told(self.coverage), self.coverage_half_width, Told(None)
        if self.coverage is not None and width is not None:
            ends = max(self.coverage - width, 0.0), min(self.coverage + width, 1.0)
            coverage = Told(self.coverage, width, ends)
        if self.stiffness is not None:
            stiffness = self.stiffness.told["test_over_prediction"]
        return {"coverage": coverage, "stiffness_test_over_prediction": stiffness}

    def to_dict(self) -> Content:
        """Everything but the rows."""
        return {
            "curves": len(self.rows),
            "campaigns": sorted(set(self.rows["campaign"])),
            "median_rms": float(self.rows["rms"].median()),
            "coverage": self.coverage,
            "stiffness": None if self.stiffness is None else self.stiffness.to_dict(),
        }


def judge_curves(
    points: pd.DataFrame, law: Law, band: Band | None = None, confidence: float = 0.9
) -> CurveJudgement:
    """Judge a law by the first loading of every curve of a table (schema `POINTS`).

    Arguments: `law`; the `band` of the fit that it is the median of (None: a law as published,
    without a band). Raises `InputError`.
    """
    rows: list[dict[str, Any]] = []
    stiffness: list[dict[str, Any]] = []
    for name, slip, load in curves_of(points, falling=law.name == "rational"):
        top = float(load.max())
        if len(slip) < 2 or top <= 0.0:
            continue
        ratio = load / top
        rms, bias = misfit(law, slip, ratio)
        inside = float("nan")
        if band is not None:
            low, high = band(np.maximum(slip, 0.0), confidence)
            inside = float(np.mean((ratio >= low) & (ratio <= high)))
        rows.append({**name, "points": len(slip), "rms": rms, "bias": bias, "inside": inside})
        measured = chord_stiffness(slip, load)
        if np.isfinite(measured):
            stiffness.append({**name, "test": measured, "prediction": law_stiffness(law, top)})
    if not rows:
        raise InputError("validation", 0, "holds no curve of two points or more")
    frame, stiff, told = pd.DataFrame(rows), pd.DataFrame(stiffness), None
    if stiffness:
        told = judge(stiff, stiff["test"], stiff["prediction"], confidence)
    coverage = None if band is None else float(frame["inside"].mean())
    return CurveJudgement(frame, told, coverage, confidence)
