"""Fit of a given strength formula to tests: bias, trends, scatter within and between campaigns.

The logarithm of test over prediction is regressed: ln(P / P_model) = ln b + sum c_k ln(x_k / x_k0)
+ u_campaign + e. So b is the median ratio, c_k an exponent that the formula misses in variable x_k.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from workbench.base.errors import InputError
from workbench.base.fields import Choice
from workbench.responses import finding
from workbench.studs.damaged import studs_in_words
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
from workbench.studs.formulas import Formula, characteristic_strength, strength_formula
from workbench.studs.plausibility import (
    measurement_of,
    slab_findings,
    strength_findings,
    suspicions,
)
from workbench.studs.series import D8, evaluate_d8, sensitivities_of
from workbench.studs.statistics.intervals import (
    LeftOut,
    Part,
    coverage,
    influence_of,
    leave_one_campaign_out,
    predictive_quantiles,
    tails_of,
    without_each,
)
from workbench.studs.statistics.mixed import NEW, Problem, fit_robust, problem
from workbench.studs.tables import (
    Array,
    RowIdentity,
    Specimens,
    identity_of,
    specimens,
    undamaged_headed_studs,
)

TRENDS = ("diameter", "concrete_strength", "concrete_modulus", "ultimate_strength", "slenderness")
# coefficients of variation of structures to come: assumptions, to be replaced by one's own
VARIATIONS = {
    "diameter": 0.01,
    "concrete_strength": 0.15,
    "concrete_modulus": 0.10,
    "ultimate_strength": 0.05,
}
_SIZES = (*TRENDS[:-1], "height", "embedment", "head_diameter")
OWN = ("own_factor", "own_low", "own_high")
LEFT_OUT = ["campaign", "count", "bias", "rms", "covered"]
LARGEST_SPECIFIED = 500e6  # Pa, of f_u in the design function, EN 1994-1-1, 6.6.3.1


@dataclass(frozen=True)
class StrengthFit(Fit):
    """A strength formula judged by tests.

    `model`; `fitted`: ``bias`` (median of test over prediction), the exponents of the trends asked
    for, and the scatters of the log ratio; `left_out`, campaigns predicted from the others; `d8`,
    EN 1990 D.8 on the same rows (which takes all tests as independent) at the `reference` stud;
    `new_campaign_factor`, 5 % fractile of test over the formula for a new test of a new campaign
    (None with fewer than three); `own`, the same of this laboratory alone with the band of a new
    test, where there is one campaign; `measurement`, relative standard uncertainty of the measured
    loads (None if not reported); `grade` of the evidence, and the studs that it `holds` for, in a
    `slab`; `kept`, its rows of the table, and `rows`, test, prediction, ratio and variables in SI.
    """

    model: Formula
    fitted: Fitted
    left_out: tuple[LeftOut, ...]
    d8: D8
    reference: dict[str, float]
    new_campaign_factor: float | None
    own: dict[str, float | None]
    measurement: float | None
    grade: str
    holds: str
    slab: str
    kept: pd.DataFrame
    figures: ClassVar[tuple[str, ...]] = ("stud-scatter", "stud-residuals")

    @cached_property
    def identity(self) -> RowIdentity:
        """The identity of the rows of the table."""
        return identity_of(self.kept)

    @property
    def bias(self) -> float:
        """Median of test over prediction at the middle of the variables."""
        return self.fitted.parameters["bias"].value

    @property
    def model_scatter(self) -> float | None:
        """Scatter of the formula itself, with that of the measurement taken out of it."""
        if self.measurement is None:
            return None
        total = self.fitted.sigma.value**2 + self.fitted.tau.value**2
        return float(np.sqrt(max(total - self.measurement**2, 0.0)))

    @property
    def _trends(self) -> tuple[str, ...]:
        return tuple(self.fitted.parameters)[1:]

    def predict(self, tests: Specimens) -> Array:
        """Median resistance (n,) in N of studs in a new campaign, with the fitted correction."""
        design = _design(tests, self._trends, self.reference)
        return np.asarray(self.model.of(tests) * np.exp(design @ self.fitted.estimate.theta))

    def judge(
        self, table: pd.DataFrame, confidence: float = 0.9, *, corrected: bool = False
    ) -> Judgement:
        """Judge the formula by undamaged headed studs that the fit has not used.

        Arguments: `corrected`, predict with the fitted bias and trends. Raises `InputError`, also
        when a row was used for the fit.
        """
        self.identity.refuse_overlap(table)
        rows = undamaged_headed_studs(table, self.slab, self.model.load)
        tests = specimens(rows)
        prediction = self.predict(tests) if corrected else self.model.of(tests)
        judged = judge(rows, tests.quantity(self.model.load), prediction, confidence)
        kept, known = _complete(rows, self.model)
        held = _problem(known, self.model, self._trends, self.reference)
        seen = {str(c).strip().casefold() for c in kept["campaign"]} & self.identity.campaigns
        inside = coverage(self.fitted.estimate, held, confidence)
        more = {"covered": inside, "known_campaigns": ", ".join(sorted(seen))}
        return replace(judged, summary=judged.summary | more)

    def summary(self) -> Summary:
        """The median of test over prediction, its scatters, what they rest on."""
        names = ("new_campaign_factor", "measurement", "model_scatter", "grade", "holds", "slab")
        return {
            **{"model": self.model.name, "title": self.model.title, "load": self.model.load},
            **counted(self.rows),
            **self.fitted.parameters["bias"].columns("bias"),
            **self.fitted.scatters,
            **{name: getattr(self, name) for name in names},
            **self.own,
        }

    def tables(self, confidence: float = 0.9) -> Tables:
        """Parameters, tests, campaigns left out, EN 1990 D.8 with the stud that it is for."""
        return {
            "parameters": self.fitted.table,
            "tests": self.rows,
            "left_out": pd.DataFrame(map(asdict, self.left_out), columns=LEFT_OUT),
            "d8": pd.DataFrame([asdict(self.d8) | self.reference]),
        }

    def influence(self) -> pd.DataFrame:
        """How every test moves the median of test over prediction."""
        estimate = self.fitted.estimate
        others = np.exp(without_each(estimate)[:, 0])
        return influence_of(self.rows, estimate, "test over prediction", self.bias, others)


def fit_strength(
    table: pd.DataFrame,
    model: str | Formula = "roik-mean",
    *,
    trends: Sequence[str] = (),
    loss: str = "linear",
    confidence: float = 0.9,
    variations: Mapping[str, float] = VARIATIONS,
    specified_strength: float | None = None,
    slab: str = "solid",
    known_between: float | None = None,
) -> StrengthFit:
    """Fit a strength formula to the undamaged headed studs of a table (schema `TESTS`).

    Arguments: `model`, a name in `FORMULAS` or a `Formula`, of shear or tension; `trends`,
    variables out of `TRENDS` whose missing exponents are fitted; `loss`, ``linear``, ``huber`` or
    ``bisquare``; `confidence` of the intervals; `variations`, see `evaluate_d8` (default
    `VARIATIONS`); `specified_strength` of the stud material in Pa, for
    gamma_M* (None: the mean of the tests); `slab`, solid or deck; `known_between`, scatter of the
    logarithm between campaigns that earlier tests have shown. Raises `InputError`, `SolverError`.
    """
    chosen = strength_formula(model) if isinstance(model, str) else model
    for trend in trends:
        Choice(TRENDS).check("trends", trend)
    usable = undamaged_headed_studs(table, slab, chosen.load)
    kept, tests = _complete(usable, chosen)
    reference = {
        name: float(np.exp(np.mean(np.log(getattr(tests, name)))))
        for name in dict.fromkeys((*TRENDS, *_SIZES))
    }
    given = _problem(tests, chosen, tuple(trends), reference)
    given = replace(given, between=known_between)
    estimate = fit_robust(given, loss)
    missing_exponents = dict(zip(trends, estimate.theta[1:].tolist(), strict=True))
    left_out: tuple[LeftOut, ...] = ()
    others = given.count - max(np.bincount(given.groups))  # than those of the largest campaign
    if given.campaigns > 1 and others > len(given.names):
        left_out = tuple(leave_one_campaign_out(given))
    foretold: list[float | None] = [None] * 3
    if given.foretold:
        parts, shares = [Part(1.0, estimate, given)], (0.05, *tails_of(confidence))
        values = predictive_quantiles(parts, shares)
        foretold = [float(np.exp(np.mean(each))) for each in values]
    own = dict(zip(OWN, [None] * 3 if given.foretold == NEW else foretold, strict=True))
    missing = len(usable) - len(kept)
    unknown: dict[str, Any] = {"count": missing, "tests": len(usable), "title": chosen.title}
    return StrengthFit(
        model=chosen,
        fitted=fitted(estimate, ("bias",), confidence=confidence),
        left_out=left_out,
        d8=_d8(tests, chosen, reference, variations, specified_strength, missing_exponents),
        reference=reference,
        new_campaign_factor=foretold[0] if given.foretold == NEW else None,
        own=own,
        measurement=measurement_of(kept, chosen.load),
        grade=grade_of(kept, "undamaged tests", left_out=bool(left_out)),
        holds=f"for studs {studs_in_words(kept)}, as tested"
        + ", in profiled decks" * (slab == "deck"),
        slab=slab,
        kept=kept,
        rows=_rows(kept, tests, chosen),
        findings=(
            *(each for each in suspicions(table) if each.subject != "outlier"),  # by the fit itself
            *slab_findings(table, kept, slab, chosen),
            *outlier_findings(estimate, kept, lambda ratio: float(np.exp(ratio))),
            *([finding("stud-without-value", **unknown)] if missing else []),
            *strength_findings(kept, tests, chosen, given),
        ),
    )


def _complete(rows: pd.DataFrame, model: Formula) -> tuple[pd.DataFrame, Specimens]:
    """Rows for which the formula has a value."""
    known = np.isfinite(model.of(specimens(rows)))
    if not known.any():
        reason = f"holds no test with all values that {model.title} needs"
        advice = "fill diameter_mm, height_mm, fcm_MPa and fu_MPa"
        raise InputError("table", f"{len(rows)} rows", reason, advice)
    kept = rows[known].reset_index(drop=True)
    return kept, specimens(kept)


def _design(tests: Specimens, trends: tuple[str, ...], reference: Mapping[str, float]) -> Array:
    columns = [np.log(getattr(tests, name) / reference[name]) for name in trends]
    return np.column_stack([np.ones(len(tests)), *columns])


def _problem(
    tests: Specimens, model: Formula, trends: tuple[str, ...], reference: Mapping[str, float]
) -> Problem:
    ratio, names = np.log(tests.quantity(model.load) / model.of(tests)), ("bias", *trends)
    start, design = np.zeros(len(names)), _design(tests, trends, reference)
    return problem(ratio, tests.campaign, None, names, start, design=design)


def _d8(
    tests: Specimens,
    model: Formula,
    reference: dict[str, float],
    variations: Mapping[str, float],
    specified_strength: float | None,
    exponents: Mapping[str, float],
) -> D8:
    """EN 1990 D.8 of a formula with its fitted `exponents`; the nominal value is of a code."""
    means = {name: reference[name] for name in variations if np.isfinite(reference[name])}

    def corrected(of: Specimens) -> Array:
        powers = _design(of, tuple(exponents), reference)[:, 1:] @ [*exponents.values()]
        return np.asarray(model.of(of) * np.exp(powers))

    whole = model.of(replace(tests, decks=None))
    reduction = float(np.exp(np.mean(np.log(model.of(tests) / whole))))  # by decks

    def resistance(
        x: Mapping[str, float], formula: Callable[[Specimens], Array] = corrected
    ) -> float:
        sizes = {name: np.array([{**reference, **x}[name]]) for name in _SIZES}
        stud = replace(tests, decks=None, free_width=np.array([np.nan]), **sizes)
        return reduction * float(formula(stud)[0])

    steel_known = np.isfinite(reference["ultimate_strength"])
    itself = model.characteristic or not steel_known or model.load == "tension"
    code = model if itself else strength_formula("en1994")
    nominal = None
    if steel_known or np.isinf(code.steel_factor):
        specified = float(characteristic_strength(reference["concrete_strength"]))
        if specified > 0.0:
            steel = {}
            if specified_strength is not None:
                steel["ultimate_strength"] = min(specified_strength, LARGEST_SPECIFIED)
            nominal = resistance({"concrete_strength": specified, **steel}, code.of)
    return evaluate_d8(
        tests.quantity(model.load),
        corrected(tests),
        variations={name: variations[name] for name in means},
        sensitivities=sensitivities_of(resistance, means),
        resistance=resistance({}),
        nominal=nominal,
    )


def _rows(kept: pd.DataFrame, tests: Specimens, model: Formula) -> pd.DataFrame:
    """Test, prediction and ratio of every row, with all variables (SI)."""
    load, prediction = tests.quantity(model.load), model.of(tests)
    return kept[["campaign", "specimen", "flag"]].assign(
        test=load,
        prediction=prediction,
        ratio=load / prediction,
        **{name: getattr(tests, name) for name in TRENDS},
        over_steel=load / (tests.area * tests.ultimate_strength),
    )
