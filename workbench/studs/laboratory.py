"""Fits of a laboratory's tables with all that is known of them, as stacked tables.

Every function takes the question that was asked (`workbench.studs.questions`), the rows to fit and
those `held` out to judge the fit. `workbench fit` prints the tables, its report draws them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import pandas as pd

from workbench.base.errors import InputError
from workbench.base.fields import Number
from workbench.responses import Finding, finding
from workbench.studs.damaged import damaged_rows, predicted_references
from workbench.studs.fit_protocol import Fit, Tables, answer_of, ranked, stacked
from workbench.studs.formulas import SHEAR_MODELS, Formula, fit_factors, strength_formula
from workbench.studs.interaction import fit_interaction
from workbench.studs.load_slip import LAWS, fit_load_slip
from workbench.studs.questions import (
    FewTestsQuestion,
    InteractionQuestion,
    LoadSlipQuestion,
    Question,
    ResidualQuestion,
    StrengthQuestion,
)
from workbench.studs.relations import MEASURES, MechanicalCurve, ResidualFit, fit_residual
from workbench.studs.schema import POINTS, QUANTITIES, TESTS, USUAL, examine
from workbench.studs.series import evaluate_few, evaluate_groups
from workbench.studs.strength_fit import VARIATIONS, fit_strength
from workbench.studs.tables import own_rows, points_of, shipped, split_table

Rows = pd.DataFrame
USUAL_SPECIFIED = 450.0  # MPa, of stud material: SD1 of ISO 13918


def known_of(fit: Fit, held: Rows, confidence: float, how: str = "as fitted") -> Tables:
    """Everything that is known of a fit, and how it meets what was held out."""
    tables = answer_of(fit, held, confidence, how).tables
    findings = pd.DataFrame([each.as_dict() for each in ranked(fit.findings)])
    figures = pd.DataFrame({"kind": fit.figures})
    return {**tables, "findings": findings, "influence": fit.influence(), "figures": figures}


def _reasons(refusals: Mapping[str, InputError]) -> Rows:
    return pd.DataFrame([{"of": name, "why": str(why)} for name, why in refusals.items()])


def strength(asked: StrengthQuestion, fitted: Rows, held: Rows) -> Tables:
    """Formulas, as they are and as fitted; Annex B under shear; which scatters least.

    Raises `InputError`.
    """
    specified = USUAL_SPECIFIED if asked.specified is None else asked.specified
    points = None if asked.points is None else examine(asked.points, POINTS).accept()
    variations = _variations(asked.variation or ())
    formulas = [strength_formula(name) for name in asked.model or SHEAR_MODELS]
    if len({formula.load for formula in formulas}) > 1:
        names = ", ".join(formula.name for formula in formulas)
        raise InputError("--model", names, "must all be of shear, or all of tension")
    answers, refusals = [], {}
    for formula in formulas:
        try:
            answers.append((formula.label, _formula(asked, fitted, held, formula, variations)))
        except InputError as error:
            if asked.model or error.field != "table":
                raise
            refusals[formula.name] = error  # the others may need less of the table
    if not answers:
        raise next(iter(refusals.values()))
    tables = {**stacked(answers), "not_fitted": _reasons(refusals)}
    tables["ranking"] = rank_scatters(tables["tests"], asked.confidence)
    if formulas[0].load == "shear":
        series = evaluate_groups(fitted, points, specified_strength=1e6 * specified)
        tables["series"] = pd.DataFrame([each.summary() for each in series])
    return tables


def _variations(texts: Sequence[str]) -> dict[str, float]:
    """Coefficients of variation, of texts like ``diameter=0.02`` where they are given."""
    variations = dict(VARIATIONS)
    for text in texts:
        name, _, value = text.partition("=")
        if name not in VARIATIONS:
            raise InputError("--variation", text, "must name one of " + ", ".join(VARIATIONS))
        try:
            number = float(value)
        except ValueError as error:
            reason = "must look like concrete_strength=0.15"
            raise InputError("--variation", text, reason) from error
        variations[name] = float(Number(0.0, 1.0).check(f"--variation {name}", number))
    return variations


def _formula(
    asked: StrengthQuestion,
    fitted: Rows,
    held: Rows,
    formula: Formula,
    variations: Mapping[str, float],
) -> Tables:
    """A formula fitted and judged, as it is and corrected, and its own factors if wanted."""
    how: dict[str, Any] = {name: getattr(asked, name) for name in ("loss", "confidence", "slab")}
    fit = fit_strength(
        fitted,
        formula,
        trends=asked.trend or (),
        variations=variations,
        specified_strength=None if asked.specified is None else 1e6 * asked.specified,
        known_between=asked.known_between,
        **how,
    )
    scaled = None
    if asked.factor:
        scaled = fit_factors(fitted, formula, asked.factor, **how)
        stuck = (finding("stud-factor-at-bound", name=name) for name in scaled.at_bound)
        fit = replace(fit, findings=(*fit.findings, *stuck))
    tables = known_of(fit, held, asked.confidence, "as it is")
    if not held.empty:
        corrected = fit.judge(held, asked.confidence, corrected=True).summary
        row = pd.DataFrame([{"prediction": "as fitted", **corrected}])
        tables["judgement"] = pd.concat([tables["judgement"], row], ignore_index=True)
    if scaled is not None:
        tables["factors"] = scaled.table
    return tables


def load_slip(asked: LoadSlipQuestion, fitted: Rows, held: Rows) -> Tables:
    """Load-slip laws, and the points that they are drawn over."""
    how: dict[str, Any] = {n: getattr(asked, n) for n in ("loss", "least_points", "confidence")}
    fits = (fit_load_slip(fitted, name, **how) for name in asked.law or LAWS)
    tables = stacked((fit.law, known_of(fit, held, asked.confidence)) for fit in fits)
    return {**tables, "points": points_of(fitted, held)}


CALIBRATION = "provines2019"  # the shipped campaign with strength, stiffness and slip


@lru_cache(maxsize=1)
def shipped_model() -> Any:
    """The mechanical model, calibrated on the shipped campaign that tells all that it needs."""
    from workbench.studs.mechanical import calibrate

    return calibrate(split_table(shipped("stud-push-out"), (CALIBRATION,))[0])


def residual(asked: ResidualQuestion, fitted: Rows, held: Rows) -> Tables:
    """Residual strength, stiffness or both; without tests one answer for every stud.

    Campaigns that are to validate judge it, whether they tell or not. Raises `InputError`.
    """
    stud = {column: getattr(asked, column.lower()) for column in USUAL}
    for column, value in stud.items():
        if value is not None:
            TESTS.column(column).rule.check(f"--{column.lower().replace('_', '-')}", value)
    how = {n: getattr(asked, n) for n in ("predamage", "measure", "loss", "confidence")}
    how["known_between"] = asked.known_between
    if asked.predicted_reference:
        fitted = predicted_references(fitted)
    fits: list[tuple[ResidualFit, Rows]] = []
    refusals = {}
    for name in tuple(QUANTITIES) if asked.quantity == "both" else (asked.quantity,):
        try:
            model = shipped_model if asked.mechanical else None
            answers = answer_residual(fitted, name, stud, model, **how)
        except InputError as error:
            if error.field != "table":
                raise
            refusals[name] = error  # tests may tell of the other quantity alone
            continue
        relevant = damaged_rows(held, name, answers[0].predamage, answers[0].measure)
        wanted = asked.validate or not relevant.empty  # asked for by name, or there by their role
        fits += [(fit, held if wanted else relevant) for fit in answers]
    if not fits:
        raise next(iter(refusals.values()))
    single = len({fit.stud for fit, _ in fits}) == 1
    tables = stacked(
        (
            fit.quantity if single else f"{fit.quantity}, {fit.stud}",
            known_of(fit, judging, asked.confidence),
        )
        for fit, judging in fits
    )
    return {**tables, "not_fitted": _reasons(refusals)}


def interaction(asked: InteractionQuestion, fitted: Rows, held: Rows) -> Tables:
    """The exponent of tension with shear, and the laws of the codes."""
    fit = fit_interaction(fitted, loss=asked.loss, confidence=asked.confidence)
    return stacked([(fit.law, known_of(fit, held, asked.confidence))])


def few_tests(asked: FewTestsQuestion, fitted: Rows, held: Rows) -> Tables:
    """Every group of nominally equal tests, by the scatter that earlier ones have shown."""
    return {"groups": pd.DataFrame(evaluate_few(fitted, asked.known_variation or 0.0))}


_ANSWERS: dict[type[Question], Callable[..., Tables]] = {
    StrengthQuestion: strength,
    LoadSlipQuestion: load_slip,
    ResidualQuestion: residual,
    InteractionQuestion: interaction,
    FewTestsQuestion: few_tests,
}


def find(asked: Question, fitted: Rows, held: Rows) -> Tables:
    """The tables of the answer, of the rows to fit and of those `held` out to judge the fit."""
    return _ANSWERS[type(asked)](asked, fitted, held)


def fit_question(asked: Question, table: Rows) -> Tables:
    """The tables of the answer by name: `fit`, `parameters`, `findings`, `judgement` and its own.

    `table` of the schema `TESTS`, or `POINTS`. Raises `InputError`, `SolverError`.
    """
    return find(asked, *asked.split(table))


LIKE = 1.01  # ratio of scatters that is no difference: an interval must lie above it
_EQUAL = 1e-12  # of squares of logarithms


def rank_scatters(tests: pd.DataFrame, confidence: float) -> pd.DataFrame:
    """Formulas by their scatter within campaigns, the least first, among equals the first.

    Arguments: `tests`, rows with `of` (the formula), campaign, specimen and ratio, test over
    prediction; those count that every formula has a value for. Columns of the result: `of`, `ratio`
    of the scatter to the least one with its interval `low`, `high` (NaN with too few tests), and
    `apart`, whether that lies above `LIKE`. Source: Pitman 1939, standard deviations of correlated
    normal variables.
    """
    from scipy.special import stdtrit

    names = list(dict.fromkeys(tests["of"]))
    ratios = tests.pivot_table("ratio", ["campaign", "specimen"], "of")[names]
    logs = ratios.dropna().apply(np.log)
    campaigns = logs.groupby(level="campaign")
    left, nu = logs - campaigns.transform("mean"), len(logs) - campaigns.ngroups - 1
    products = left.T.to_numpy() @ left.to_numpy()
    squares = np.diag(products)
    best = int(np.flatnonzero(squares <= squares.min() + _EQUAL)[0])
    rows: list[dict[str, Any]] = [{"of": names.pop(best), "ratio": 1.0, "apart": False}]
    for k in (k for k in range(len(squares)) if k != best):
        row = {"of": str(left.columns[k]), "apart": False}
        if nu > 0 and squares[best] > _EQUAL:
            ratio = float(np.sqrt(squares[k] / squares[best]))
            unshared = max(1.0 - products[k, best] ** 2 / (squares[k] * squares[best]), 0.0)
            wide = 1.0 + 2.0 * unshared * float(stdtrit(nu, 0.5 + 0.5 * confidence)) ** 2 / nu
            factor = float(np.sqrt(wide + np.sqrt(wide**2 - 1.0)))
            ends = {"low": ratio / factor, "high": ratio * factor}
            row |= {"ratio": ratio, **ends, "apart": ratio / factor > LIKE}
        rows.append(row)
    return pd.DataFrame(rows, columns=["of", "ratio", "low", "high", "apart"])


MOST_STUDS = 4  # of a table, that the mechanical model computes one by one


def answer_residual(
    table: pd.DataFrame,
    quantity: str,
    given: Mapping[str, float | None],
    model: Callable[[], Any] | None,
    *,
    predamage: str | None = None,
    measure: str | None = None,
    **how: Any,
) -> list[ResidualFit]:
    """Fit what is left to the tests after pre-damage, or predict it if the table has none.

    One answer from tests; without them one prediction for each stud of one's own tables, that of
    most tests first. Arguments: `table` (schema `TESTS`); `quantity` ``strength`` or ``stiffness``;
    `given`, the stud if the question tells it (see `studs_of`); the mechanical `model`, called
    where it is needed: without tests, or as a candidate for tests that a pull-out damaged, if it
    can be calibrated (None: never); the rest as in `fit_residual`. Raises `InputError`,
    `SolverError`.
    """
    rows = damaged_rows(table, quantity, predamage, measure)
    kind = predamage if rows.empty else str(rows["predamage"].iloc[0])
    level = measure if rows.empty else str(rows["predamage_measure"].iloc[0])
    findings: list[Finding] = []
    curves: list[MechanicalCurve | None] = [None]
    if model is not None and kind in (None, "pull-out") and level in (None, *MEASURES):
        from workbench.studs.mechanical import residual_curve, studs_of

        try:
            studs, refused = studs_of(rows if len(rows) else own_rows(table), given)
            chosen, others = studs[: 1 if len(rows) else MOST_STUDS], studs[MOST_STUDS:]
            fit = model()
            findings += [finding("stud-refused-stud", why=text) for text in refused]
            if studs[0].assumed:
                findings.append(finding("stud-assumed-of-studs", assumed=studs[0].assumed))
            if others and rows.empty:
                titles = "; ".join(each.stud.title for each in others)
                findings.append(finding("stud-further-studs", count=len(others), titles=titles))
            which: dict[str, Any] = {"measure": level or MEASURES[0], "basis": fit.basis}
            curves = [residual_curve(e.stud, fit.around, quantity, **which) for e in chosen]
        except InputError as error:
            if rows.empty:
                raise
            findings.append(finding("stud-no-candidate", error=error))
    how |= {"predamage": predamage, "measure": measure}
    fits = (fit_residual(table, quantity, mechanical=curve, **how) for curve in curves)
    return [replace(each, findings=(*findings, *each.findings)) for each in fits]
