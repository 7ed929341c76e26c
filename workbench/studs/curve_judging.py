"""Load-slip laws held against curves that no fit has used."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from workbench.errors import InputError, OutOfDomainError
from workbench.studs.curve_fit import misfit
from workbench.studs.judging import Judgement, judge
from workbench.studs.load_slip import LoadSlipLaw
from workbench.studs.load_slip_fit import LoadSlipFit, first_loading
from workbench.studs.quantities import Array
from workbench.studs.stiffness import chord_stiffness, law_stiffness


@dataclass(frozen=True)
class CurveJudgement:
    """A law on unseen curves.

    `curves`, one row per curve: campaign, specimen, points, rms and bias of the load over the
    largest load, share of its points inside the band (`inside`, NaN without a band); `stiffness`,
    test over prediction of the chord stiffness at the measured strength (None where no curve tells
    it); `coverage`, mean of `inside` over the curves (None without a band).
    """

    curves: pd.DataFrame
    stiffness: Judgement | None
    coverage: float | None
    confidence: float

    @property
    def rms(self) -> float:
        """Median root mean square of the misfit over the curves."""
        return float(self.curves["rms"].median())

    @property
    def coverage_half_width(self) -> float | None:
        """Half-width of the interval of the coverage: curves are the observations, not points.

        At least one curve more or less; None with a single curve.
        """
        from scipy.special import stdtrit

        count = len(self.curves)
        if self.coverage is None or count < 2:
            return None
        error = float(self.curves["inside"].std(ddof=1)) / np.sqrt(count)
        width = float(stdtrit(count - 1.0, 0.5 + 0.5 * self.confidence) * error)
        return max(width, 1.0 / count)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the rows, ready for JSON."""
        return {
            "curves": len(self.curves),
            "campaigns": sorted(set(self.curves["campaign"])),
            "median_rms": self.rms,
            "coverage": self.coverage,
            "stiffness": None if self.stiffness is None else self.stiffness.to_dict(),
        }


def judge_curves(
    points: pd.DataFrame,
    law: LoadSlipLaw,
    fit: LoadSlipFit | None = None,
    confidence: float = 0.9,
) -> CurveJudgement:
    """Judge a law by the first loading of every curve of a table (schema `POINTS`).

    Arguments: `law`; the `fit` that it is the median of, whose band is judged and whose own curves
    are refused (None: a law as published, without a band). Raises `InputError`.
    """
    used = first_loading(points, falling=law.name == "rational")
    own = set() if fit is None else set(zip(fit.curves["campaign"], fit.curves["specimen"],
                                            strict=True))  # fmt: skip
    rows: list[dict[str, Any]] = []
    stiffness: list[dict[str, Any]] = []
    for key, curve in used.groupby(["campaign", "specimen"], sort=False):
        if key in own:
            raise InputError(
                "validation", " ".join(map(str, key)), "was used for the fit",
                "validate on curves that the fit has not seen",
            )  # fmt: skip
        slip, load = curve["slip"].to_numpy(float), curve["load"].to_numpy(float)
        if len(curve) < 2 or load.max() <= 0.0:
            continue
        top = float(load.max())
        rms, bias = misfit(law, slip, load / top)
        row = {"campaign": key[0], "specimen": key[1], "points": len(curve), "rms": rms,
               "bias": bias, "inside": _inside(fit, slip, load / top, confidence)}  # fmt: skip
        rows.append(row)
        try:
            measured = chord_stiffness(slip, load)
        except OutOfDomainError:
            continue  # both levels at one slip: the curve does not tell
        stiffness.append({"campaign": key[0], "specimen": key[1], "test": measured,
                          "prediction": law_stiffness(law, top)})  # fmt: skip
    if not rows:
        raise InputError("validation", 0, "holds no curve of two points or more")
    frame = pd.DataFrame(rows)
    return CurveJudgement(
        frame,
        judge(pd.DataFrame(stiffness), confidence) if stiffness else None,
        None if fit is None else float(frame["inside"].mean()),
        confidence,
    )


def _inside(fit: LoadSlipFit | None, slip: Array, ratio: Array, confidence: float) -> float:
    if fit is None:
        return float("nan")
    low, high = fit.band(np.maximum(slip, 0.0), confidence)
    return float(np.mean((ratio >= low) & (ratio <= high)))
