"""Tension with shear: laws of what is left of one under the other, tests of both, and their fit.

Tension and shear are over the resistances of equal studs under one of them alone. Fitted is the
exponent of t^p + v^p = 1: of a test in the direction (t, v) the law says how far out it lies; the
logarithm of that distance is regressed, with an effect per campaign.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
import pandas as pd

from workbench.base.errors import InputError
from workbench.responses import Finding, finding
from workbench.studs.fit_protocol import (
    Fit,
    Fitted,
    Judgement,
    Summary,
    Tables,
    counted,
    fitted,
    grade_of,
    judge,
    outlier_findings,
)
from workbench.studs.plausibility import suspicions
from workbench.studs.schema import NO_PREDAMAGE
from workbench.studs.statistics.intervals import influence_of, without_each
from workbench.studs.statistics.mixed import LEAST_CAMPAIGNS, fit_robust, problem
from workbench.studs.tables import Array, equal_studs

EXPONENTS = (0.3, 30.0)  # 1: linear; below it damage adds up, far above it nothing interacts
SHARES = np.linspace(0.0, 1.0, 41)  # of the tension resistance, at which the law is given
LEAST_ANGLE = 0.05  # rad, from pure tension or shear: nearer a test tells nothing of both
_SEARCHED = (-12.0, 12.0)  # logarithms of exponents; beyond, profiles run into overflow


def _power(exponent: float) -> Callable[[Array], Array]:
    """t^p + v^p = 1."""
    return lambda t: np.maximum(1.0 - t**exponent, 0.0) ** (1.0 / exponent)


class InteractionLaw(NamedTuple):
    """A law of the books: what it leaves of the shear resistance, its source, its line in figures.

    `shear` (n,) that is left at tensions (n,) from 0 on; none is left beyond the resistance.
    """

    shear: Callable[[Array], Array]
    keys: tuple[str, ...]
    line: str

    def curve(self, points: int) -> tuple[Array, Array]:
        """Tension and shear (points + 1,), down to no shear at the end."""
        tension = np.linspace(0.0, 1.0, points)
        return np.append(tension, 1.0), np.append(self.shear(tension), 0.0)


def _trilinear(tension: Array) -> Array:
    """T + v <= 1.2, of ACI 318 and the PCI handbook (recalled, not read again)."""
    return np.where(tension > 1.0, 0.0, np.clip(1.2 - tension, 0.0, 1.0))


INTERACTIONS: dict[str, InteractionLaw] = {
    "five-thirds": InteractionLaw(_power(5.0 / 3.0), ("aisc360-22",), "-"),  # I8.3c
    "linear": InteractionLaw(_power(1.0), (), "--"),
    "trilinear": InteractionLaw(_trilinear, ("aci318-19",), "-."),
}


def combined_tests(table: pd.DataFrame) -> pd.DataFrame:
    """Rows (campaign, specimen, tension, shear, companions) of the combined tests; may be empty.

    Both are over the mean resistance of the undamaged pull-outs and push-outs of the same campaign
    and diameter, in concrete of about the same strength; a combined test without both is left out.
    `companions`, how many tests the scarcer of the two has.
    """
    usable = table[(table["use_for_fit"] == 1.0) & (table["predamage"] == NO_PREDAMAGE)]
    rows = []
    for _, row in usable[usable["test"] == "combined"].iterrows():
        combined: dict[str, object] = {n: row[n] for n in ("campaign", "specimen", "origin")}
        alike, counts = equal_studs(usable, row), []
        for kind, name in (("pull-out", "tension"), ("push-out", "shear")):
            alone = alike.loc[alike["test"] == kind, f"{name}_kN"].astype(float).dropna()
            counts.append(len(alone))
            combined[name] = float(row[f"{name}_kN"]) / alone.mean()
        rows.append({**combined, "companions": min(counts)})
    names = ["campaign", "specimen", "origin", "tension", "shear", "companions"]
    complete = pd.DataFrame(rows, columns=names).dropna(subset=["tension", "shear"])
    return complete.reset_index(drop=True)


def borne(tests: pd.DataFrame, tension: Array, shear: Array) -> Array:
    """Distance (n,) of a curve (m,) from the origin in the direction of every test.

    Raises `InputError` for tests beside the curve.
    """
    angle = np.arctan2(shear, tension)
    order = np.argsort(angle)
    radius = np.hypot(shear, tension)[order]
    wanted = np.arctan2(tests["shear"].to_numpy(float), tests["tension"].to_numpy(float))
    if wanted.min() < angle.min() - 1e-9 or wanted.max() > angle.max() + 1e-9:
        raise InputError("tests", float(wanted.min()), "lie outside the curve of the law")
    return np.asarray(np.interp(wanted, angle[order], radius))


def log_reach(angle: Array, exponent: float) -> Array:
    """Logarithm (n,) of the distance of the law from the origin in directions `angle` (n,).

    That is atan(v / t), inside the quadrant; the distance itself is zero for small exponents.
    """
    t, v = exponent * np.log(np.cos(angle)), exponent * np.log(np.sin(angle))
    return np.asarray(-np.logaddexp(t, v) / exponent)


@dataclass(frozen=True)
class InteractionFit(Fit):
    """An exponent fitted to combined tests; `laws`, known laws held against the same tests.

    `rows`: tension and shear over the resistances under one of them alone, `companions`, how many
    tests made these resistances.
    """

    fitted: Fitted
    laws: tuple[tuple[str, Judgement], ...]
    grade: str
    law: ClassVar[str] = "power"
    figures: ClassVar[tuple[str, ...]] = ("stud-interaction",)

    @property
    def exponent(self) -> float:
        """The exponent p."""
        return self.fitted.estimates["exponent"]

    def judge(self, table: pd.DataFrame, confidence: float = 0.9) -> Judgement:
        """Hold the law against combined tests that the fit has not used. Raises `InputError`."""
        rows = combined_tests(table)
        if rows.empty:
            raise InputError("validation", 0, "holds no combined test with its companions")
        self.identity.refuse_overlap(rows)
        angle, distance = _polar(rows)
        return judge(
            rows, distance, np.exp(log_reach(angle, self.exponent)), confidence, "tension", "shear"
        )

    def summary(self) -> Summary:
        """The exponent with its interval and scatters."""
        return {
            "law": self.law,
            **self.fitted.parameters["exponent"].columns("exponent"),
            **self.fitted.scatters,
            **counted(self.rows),
            **{"grade": self.grade, "holds": "for these tests"},
        }

    def tables(self, confidence: float = 0.9) -> Tables:
        """Its tests, the fitted law and those of the codes over the tension, how these judge."""
        curves = {name: law.shear(SHARES) for name, law in INTERACTIONS.items()}
        curve = {"tension": SHARES, "shear": _power(self.exponent)(SHARES), **curves}
        laws = [{"law": name, **judged.summary} for name, judged in self.laws]
        return {"tests": self.rows, "curve": pd.DataFrame(curve), "codes": pd.DataFrame(laws)}

    def influence(self) -> pd.DataFrame:
        """How every test moves the exponent."""
        without = np.exp([theta[0] for theta in without_each(self.fitted.estimate)])
        estimate = self.fitted.estimate
        return influence_of(self.rows, estimate, "exponent", self.exponent, without)


def _polar(rows: pd.DataFrame) -> tuple[Array, Array]:
    """Direction (n,) and distance (n,) of tests."""
    t, v = (rows[name].to_numpy(float) for name in ("tension", "shear"))
    return np.arctan2(v, t), np.hypot(t, v)


def fit_interaction(
    table: pd.DataFrame, *, loss: str = "linear", confidence: float = 0.9
) -> InteractionFit:
    """Fit the exponent of t^p + v^p = 1 to the combined tests of a table (schema `TESTS`).

    Tension and shear are over the mean resistances of pull-outs and push-outs of the same campaign
    and diameter. Arguments as in `fit_strength`. Raises `InputError` for fewer than two combined
    tests that tell of both.
    """
    rows = combined_tests(table)
    angle, distance = _polar(rows)
    both = (angle > LEAST_ANGLE) & (angle < 0.5 * np.pi - LEAST_ANGLE)
    if both.sum() < 2:
        reason = "combined tests of tension and shear: two or more are needed"
        advice = "each needs pull-outs and push-outs of its campaign and diameter in the table"
        raise InputError("table", f"{int(both.sum())} usable", reason, advice)
    rows = rows[both].reset_index(drop=True)
    angle, distance = angle[both], distance[both]
    given = problem(
        np.log(distance),
        rows["campaign"],
        lambda theta: log_reach(angle, float(np.exp(np.clip(theta[0], *_SEARCHED)))),
        ("exponent",),
        [np.log(5.0 / 3.0)],
        lower=np.log(EXPONENTS[0]),
        upper=np.log(EXPONENTS[1]),
    )
    estimate = fit_robust(given, loss)
    exponent = fitted(estimate, ("exponent",), confidence=confidence)
    laws = tuple(
        (name, judge(rows, distance, borne(rows, *law.curve(1001)), confidence))
        for name, law in INTERACTIONS.items()
    )
    findings = (
        *suspicions(table),
        *outlier_findings(estimate, rows, lambda value: float(np.exp(value))),
        *_findings(rows, exponent),
    )
    return InteractionFit(
        fitted=exponent,
        laws=laws,
        grade=grade_of(rows, "combined tests"),
        rows=rows,
        findings=findings,
    )


def _findings(rows: pd.DataFrame, estimate: Fitted) -> Iterator[Finding]:
    least = int(rows["companions"].min())
    if least < 3:
        yield finding("stud-few-companions", least=least)
    if (campaigns := rows["campaign"].nunique()) < LEAST_CAMPAIGNS:
        yield finding("stud-few-combined-campaigns", campaigns=campaigns)
    if estimate.at_bound:
        yield finding("stud-exponent-at-bound", low=EXPONENTS[0], high=EXPONENTS[1])
