"""`workbench fit`: strength, load-slip and residual capacity of studs from tables of tests.

The options of a verb are the fields of a class; `_verb` makes the command of it, which reads the
tables and prints or writes what the verb finds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from workbench.cli.fit_options import (
    Common,
    FewOptions,
    InteractionOptions,
    LoadSlipOptions,
    ResidualOptions,
    StrengthOptions,
    priors_of,
    signature_of,
    variations_of,
)
from workbench.cli.output import Answer, verb, writable
from workbench.errors import InputError
from workbench.fields import Choice, Number

if TYPE_CHECKING:
    import pandas as pd

    from workbench.studs.fit_protocol import Fit

    # what a verb finds, and the fitted and unseen rows that it rests on
    Found = tuple[dict[str, Any], pd.DataFrame, pd.DataFrame]

Content = dict[str, Any]
USUAL_SPECIFIED = 450.0  # MPa, of stud material: SD1 of ISO 13918
app = typer.Typer(
    help="Fit laws of studs to a table of tests.", rich_markup_mode=None, no_args_is_help=False
)


def _verb(name: str, kind: type[Common]) -> Callable[[Callable[..., Found]], None]:
    """Make a verb of a function of its options, a `kind`, and of the rows to fit and to judge."""

    def made(find: Callable[..., Found]) -> None:
        def command(**given: Any) -> Answer:
            from workbench.report.chapters.fit_answer import shown

            options = kind(**given)
            Number(0.5, 0.999).check("--confidence", options.confidence)
            inputs = (options.file, getattr(options, "points", None))
            targets = _report_files(options.report or [], inputs)
            *rows, head = _tables(options, name)
            content, *rows = find(options, *rows)
            content = {**head, **content}
            return _reported(Answer(content, shown(content), rows=rows), targets)

        command.__signature__ = signature_of(kind)  # type: ignore[attr-defined]
        command.__doc__ = find.__doc__
        app.command(name)(verb(command))

    return made


@_verb("stud-strength", StrengthOptions)
def stud_strength(options: StrengthOptions, fitted: pd.DataFrame, held: pd.DataFrame) -> Found:
    """Judge and fit formulas of strength.

    Undamaged headed studs in solid slabs with use_for_fit = 1; with EN 1990 D.8 and, under shear,
    EN 1994-1-1 Annex B.2. Campaigns that validate are kept out of the fit.
    """
    from workbench.studs import (
        POINTS,
        SHEAR_MODELS,
        TESTS,
        evaluate_groups,
        examine,
        strength_formula,
    )
    from workbench.studs.fit_protocol import plain
    from workbench.studs.statistics.intervals import rank_scatters

    specified = USUAL_SPECIFIED if options.specified is None else options.specified
    TESTS.column("fu_MPa").rule.check("--specified-fu", specified)
    contents: list[Content] = []
    left_out: dict[str, Exception] = {}
    names = options.model or list(SHEAR_MODELS)
    if len({strength_formula(name).load for name in names}) > 1:
        raise InputError("--model", ", ".join(names), "must all be of shear, or all of tension")
    for name in names:
        try:
            contents.append(_formula(fitted, held, name, options))
        except InputError as error:
            if options.model or error.field != "table":
                raise
            left_out[name] = error  # the others may need less of the table
    if not contents:
        raise next(iter(left_out.values()))
    curves = None if options.points is None else examine(options.points, POINTS).accept()
    series = []
    if contents[0]["fit"]["load"] == "shear":
        series = evaluate_groups(fitted, curves, specified_strength=1e6 * specified)
    not_fitted = {name: str(why) for name, why in left_out.items()}
    tests = {content["fit"]["model"]: content["tests"] for content in contents}
    best, rivals = rank_scatters(tests, options.confidence)
    found = {"models": contents, "not_fitted": not_fitted, "series": plain(series)}
    return {**found, "least_scatter": best, "rivals": rivals}, fitted, held


@_verb("load-slip", LoadSlipOptions)
def load_slip(options: LoadSlipOptions, fitted: pd.DataFrame, held: pd.DataFrame) -> Found:
    """Fit load-slip laws to push-out curves.

    Curves are the observations, not points: a curve of many points counts once.
    """
    from workbench.studs import LAWS, fit_load_slip

    Number(2, 10_000, integer=True).check("--least-points", options.least_points)
    how = {name: getattr(options, name) for name in ("loss", "least_points", "confidence")}
    fits = (fit_load_slip(fitted, name, **how) for name in options.law or LAWS)
    return {"laws": [_judged(fit, held, options.confidence) for fit in fits]}, fitted, held


@_verb("residual", ResidualOptions)
def residual(options: ResidualOptions, fitted: pd.DataFrame, held: pd.DataFrame) -> Found:
    """Fit what is left after pre-damage.

    The answer carries the grade of its evidence. Without tests after pre-damage the mechanical
    model predicts, and nothing validates it.
    """
    from workbench.scenarios import StudTests
    from workbench.studs import TESTS
    from workbench.studs.answers.evidence import CALIBRATION, calibrated
    from workbench.studs.answers.fits import answer_residual
    from workbench.studs.damaged import damaged_rows, predicted_references
    from workbench.studs.mechanical.calibration import USUAL
    from workbench.studs.schema import QUANTITIES

    Choice((*QUANTITIES, "both")).check("--quantity", options.quantity)
    if options.predicted_reference:
        fitted = predicted_references(fitted)
    given = {column: getattr(options, column.lower()) for column in USUAL}
    for column, value in given.items():
        if value is not None:
            TESTS.column(column).rule.check(f"--{column.lower().replace('_', '-')}", value)
    # the shipped campaign that tells all that the mechanical model needs
    known = StudTests("calibration", calibrate=(CALIBRATION,))
    model = (lambda: calibrated(known)) if options.mechanical else None
    how = {name: getattr(options, name) for name in ("predamage", "measure", "loss", "confidence")}
    contents, left_out, how["priors"] = [], {}, priors_of(options.prior)
    for name in QUANTITIES if options.quantity == "both" else (options.quantity,):
        try:
            fits = answer_residual(fitted, name, given, model, **how)
        except InputError as error:
            if error.field != "table":
                raise
            left_out[name], why = str(error), error  # tests may tell of the other quantity alone
            continue
        relevant = damaged_rows(held, name, fits[0].predamage, fits[0].measure)
        wanted = options.validate or not relevant.empty  # asked for by name, or there by their role
        judging = held if wanted else relevant
        contents += [_judged(fit, judging, options.confidence) for fit in fits]
    if not contents:
        raise why
    grades = dict.fromkeys(content["fit"]["grade"] for content in contents)
    found = {"grade": "; ".join(grades), "quantities": contents, "not_fitted": left_out}
    return found, fitted, held


@_verb("interaction", InteractionOptions)
def interaction(options: InteractionOptions, fitted: pd.DataFrame, held: pd.DataFrame) -> Found:
    """Fit the exponent of tension with shear.

    Combined tests (test = combined) over the pull-outs and push-outs of their campaign and
    diameter; t^p + v^p = 1, with the laws of the codes on the same tests.
    """
    from workbench.studs.interaction import fit_interaction

    fit = fit_interaction(fitted, loss=options.loss, confidence=options.confidence)
    return {"laws": [_judged(fit, held, options.confidence)]}, fitted, held


@_verb("few-tests", FewOptions)
def few_tests(options: FewOptions, fitted: pd.DataFrame, held: pd.DataFrame) -> Found:
    """Characteristic value of one to three tests, EN 1990 D.8.4.

    Strength of undamaged studs, and share of strength and stiffness left after damage, for a
    scatter that earlier tests with the same resistance have shown (--known-variation).
    """
    from workbench.studs.fit_protocol import plain
    from workbench.studs.series import evaluate_few

    known = options.known_variation
    if known is None:
        advice = "--known-variation 0.11 for example"
        raise InputError("--known-variation", "", "must be given: few tests do not tell it", advice)
    Number(0.01, 0.5).check("--known-variation", known)
    groups = plain(evaluate_few(fitted, known))
    return {"known_variation": known, "groups": groups}, fitted, held.iloc[:0]


def _report_files(names: list[str], inputs: Sequence[str | None]) -> dict[str, Path]:
    """Where reports are to go, by their format: refused before anything is computed."""
    from workbench.report.fit_report import FORMATS

    found = {}
    for name in names:
        target = writable("--report", name, *FORMATS, inputs=inputs)
        found[target.suffix.lower().removeprefix(".")] = target
    return found


def _reported(found: Answer, targets: dict[str, Path]) -> Answer:
    """The answer with reports written, which it names."""
    if not targets:
        return found
    from workbench.content.tree import Paragraph
    from workbench.report.fit_report import write

    written = write(found.content, found.rows, targets)
    told = [Paragraph(f"{words}: {path}") for words, path in written.items()]
    return found._replace(blocks=(*found.blocks, *told))


def _tables(options: Common, fit: str) -> tuple[pd.DataFrame, pd.DataFrame, Content]:
    """The rows to fit, those that judge, and what every answer begins with."""
    from workbench.datafiles import digest
    from workbench.studs import POINTS, TESTS, examine, shipped
    from workbench.studs.tables import campaigns_of, check_campaigns, joined, split_table

    curves = fit == "load-slip"
    schema, name = (POINTS, "stud-load-slip") if curves else (TESTS, "stud-push-out")
    own = options.with_shipped or options.file is None
    parts, bad = [shipped(name)] if own else [], []
    if options.file is not None:
        examination = examine(options.file, schema)
        parts.append(examination.rows if options.keep_good else examination.accept())
        bad = [str(problem.error()) for problem in examination.problems]
    table = joined(parts, unique=bool(schema.key))
    calibrate, validate = options.calibrate or [], options.validate or []
    check_campaigns((*calibrate, *validate), table)
    fitted, held = split_table(table, calibrate, validate)
    head = {
        "fit": fit,
        "tables": [*([] if options.file is None else [options.file]), *["shipped"] * own],
        "calibrate": calibrate,
        "validate": campaigns_of(held),
        "confidence": options.confidence,
        "options": _given(options),
        "digest": None if options.file is None else digest(Path(options.file)),
        "rows_left_out": bad,
    }
    return fitted, held, head


def _given(options: Common) -> Content:
    """The options that are not as by default."""
    told = {each.name: (getattr(options, each.name), each.default) for each in fields(options)}
    hidden = ("file", "report", "points")
    return {k: v for k, (v, default) in told.items() if k not in hidden and v != default}


def _judged(fit: Fit, held: pd.DataFrame, confidence: float) -> Content:
    """Everything that is known of a fit, and how it meets what was held out."""
    from workbench.studs.fit_protocol import plain, ranked

    judged = None if held.empty else fit.judge(held, confidence)
    findings = [finding.as_dict() for finding in ranked(fit.findings)]
    content = fit.content(judged, confidence)
    return dict(plain({**content, "findings": findings, "influence": fit.influence()}))


def _formula(
    fitted: pd.DataFrame, held: pd.DataFrame, name: str, options: StrengthOptions
) -> Content:
    """A formula fitted and judged, as it is and corrected, and its own factors if wanted."""
    from workbench.studs import fit_factors, fit_strength
    from workbench.studs.fit_protocol import plain

    how = {name: getattr(options, name) for name in ("loss", "confidence", "slab")}
    fit = fit_strength(
        fitted,
        name,
        trends=tuple(options.trend or ()),
        variations=variations_of(options.variation),
        specified_strength=None if options.specified is None else 1e6 * options.specified,
        priors=priors_of(options.prior),
        **how,
    )
    more: Content = {"corrected": None, "factors": None}
    if not held.empty:
        more["corrected"] = fit.judge(held, options.confidence, corrected=True).to_dict()
    if options.factor:
        own = fit_factors(fitted, name, options.factor, loss=options.loss, slab=options.slab)
        more["factors"] = own.to_dict()
    return {**_judged(fit, held, options.confidence), **plain(more)}
