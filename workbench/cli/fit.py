"""`workbench fit`: strength, load-slip and residual capacity of studs from tables of tests."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from workbench.cli import fit_text
from workbench.cli.output import Json, print_json

if TYPE_CHECKING:
    import pandas as pd

    from workbench.studs.schema import Table

app = typer.Typer(
    help="Fit laws of studs to a table of tests.",
    rich_markup_mode=None,
    no_args_is_help=False,
)

File = Annotated[
    str | None,
    typer.Argument(metavar="[FILE.csv]", help="Your table of tests.  [default: shipped tables]"),
]
WithShipped = Annotated[
    bool, typer.Option("--with-shipped", help="Add the shipped tables to those of FILE.")
]
Calibrate = Annotated[
    list[str] | None,
    typer.Option(metavar="CAMPAIGN", help="A campaign to fit.  [default: all not validating]"),
]
Validate = Annotated[
    list[str] | None,
    typer.Option(metavar="CAMPAIGN", help="A campaign to hold the fit against, kept out of it."),
]
Confidence = Annotated[float, typer.Option(help="Confidence of intervals and bands.")]
KeepGood = Annotated[
    bool, typer.Option("--keep-good", help="Leave bad rows of FILE out instead of refusing it.")
]


@app.command("stud-strength")
def stud_strength(
    file: File = None,
    model: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="A formula.  [default: all]")
    ] = None,
    trend: Annotated[
        list[str] | None,
        typer.Option(metavar="VARIABLE", help="Fit the exponent that a formula misses in it."),
    ] = None,
    factor: Annotated[
        list[str] | None,
        typer.Option(metavar="steel|concrete", help="Fit this factor of the formula itself."),
    ] = None,
    loss: Annotated[
        str, typer.Option(metavar="NAME", help="linear, huber or bisquare.")
    ] = "linear",
    variation: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=V", help="Scatter of a variable in structures, for D.8."),
    ] = None,
    points: Annotated[
        str | None,
        typer.Option(metavar="POINTS.csv", help="Load-slip curves, for slip capacities."),
    ] = None,
    specified: Annotated[
        float, typer.Option("--specified-fu", metavar="MPA", help="Specified stud strength.")
    ] = 450.0,
    calibrate: Calibrate = None,
    validate: Validate = None,
    with_shipped: WithShipped = False,
    keep_good: KeepGood = False,
    confidence: Confidence = 0.9,
    as_json: Json = False,
) -> None:
    """Judge and fit formulas of shear strength.

    Undamaged headed studs in solid slabs with use_for_fit = 1; with EN 1990 D.8 and EN 1994-1-1
    Annex B.2. Campaigns that validate are kept out of the fit.
    """
    from workbench.errors import InputError, OutOfDomainError
    from workbench.studs import SHEAR_MODELS, TESTS, evaluate_groups, read_points, shear_model
    from workbench.studs.answers.series import series_content
    from workbench.studs.plain import plain

    _check_confidence(confidence)
    table, bad = _table(file, TESTS, "stud-push-out", with_shipped, keep_good)
    fitted, held = _split(table, calibrate, validate)
    options = {
        "trends": tuple(trend or ()), "loss": loss, "confidence": confidence,
        "variations": _variations(variation),
    }  # fmt: skip
    contents, left_out = [], {}
    for name in model or list(SHEAR_MODELS):
        shear_model(name)
        try:
            contents.append(_formula(fitted, held, name, factor, options))
        except (InputError, OutOfDomainError) as error:
            if model or getattr(error, "field", "table") != "table":
                raise
            left_out[name], why = str(error), error  # the others may need less of the table
    if not contents:
        raise why
    curves = None if points is None else read_points(points)
    series = evaluate_groups(fitted, curves, specified_strength=1e6 * specified)
    result = {
        **_head("stud-strength", file, with_shipped, calibrate, held, confidence, bad),
        "models": contents,
        "not_fitted": left_out,
        "series": plain([series_content(each) for each in series]),
    }
    print_json(result) if as_json else fit_text.strength(result)


@app.command("load-slip")
def load_slip(
    file: Annotated[
        str | None,
        typer.Argument(
            metavar="[POINTS.csv]", help="Your table of points.  [default: shipped tables]"
        ),
    ] = None,
    law: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="ollgaard, bilinear or rational.  [default: all]"),
    ] = None,
    loss: Annotated[str, typer.Option(metavar="NAME", help="linear, huber or soft_l1.")] = "linear",
    least_points: Annotated[int, typer.Option(help="Points that a curve needs to count.")] = 3,
    calibrate: Calibrate = None,
    validate: Validate = None,
    with_shipped: WithShipped = False,
    keep_good: KeepGood = False,
    confidence: Confidence = 0.9,
    as_json: Json = False,
) -> None:
    """Fit load-slip laws to push-out curves.

    Curves are the observations, not points: a curve of many points counts once.
    """
    from workbench.studs import LAWS, POINTS, fit_load_slip
    from workbench.studs.answers.load_slip import load_slip_content
    from workbench.studs.curve_judging import judge_curves
    from workbench.studs.load_slip import law_kind
    from workbench.studs.plain import plain

    _check_confidence(confidence)
    table, bad = _table(file, POINTS, "stud-load-slip", with_shipped, keep_good)
    fitted, held = _split(table, calibrate, validate)
    contents = []
    for name in law or list(LAWS):
        law_kind(name)
        fit = fit_load_slip(
            fitted, name, loss=loss, least_points=least_points, confidence=confidence
        )
        judged = judge_curves(held, fit.shape, fit, confidence) if not held.empty else None
        contents.append(plain(load_slip_content(fit, judged, confidence)))
    result = {
        **_head("load-slip", file, with_shipped, calibrate, held, confidence, bad),
        "laws": contents,
    }
    print_json(result) if as_json else fit_text.load_slip(result)


@app.command("residual")
def residual(
    file: File = None,
    quantity: Annotated[
        str, typer.Option(metavar="NAME", help="strength, stiffness or both.")
    ] = "both",
    predamage: Annotated[
        str | None, typer.Option(metavar="KIND", help="Tests after this damage only.")
    ] = None,
    measure: Annotated[
        str | None, typer.Option(metavar="NAME", help="Tests with this measure of damage only.")
    ] = None,
    mechanical: Annotated[
        bool, typer.Option(help="Let the mechanical model predict, or compete.")
    ] = True,
    diameter: Annotated[
        float, typer.Option("--diameter-mm", help="Of the stud that the mechanical model computes.")
    ] = 19.0,
    height: Annotated[float, typer.Option("--height-mm", help="Height of that stud.")] = 100.0,
    concrete: Annotated[float, typer.Option("--fcm-mpa", help="Mean strength of its slab.")] = 30.0,
    steel: Annotated[float, typer.Option("--fu-mpa", help="Tensile strength of it.")] = 450.0,
    calibrate: Calibrate = None,
    validate: Validate = None,
    with_shipped: WithShipped = False,
    keep_good: KeepGood = False,
    confidence: Confidence = 0.9,
    as_json: Json = False,
) -> None:
    """Fit what is left after pre-damage.

    The answer carries the grade of its evidence. Without tests after pre-damage the mechanical
    model predicts, and nothing validates it.
    """
    from workbench.errors import InputError
    from workbench.studs import TESTS
    from workbench.studs.answers.residual import answer_residual, judge_residual, residual_content
    from workbench.studs.plain import plain
    from workbench.studs.residual import QUANTITIES, damaged_rows

    _check_confidence(confidence)
    if quantity not in (*QUANTITIES, "both"):
        raise InputError("--quantity", quantity, "must be strength, stiffness or both")
    table, bad = _table(file, TESTS, "stud-push-out", with_shipped, keep_good)
    fitted, held = _split(table, calibrate, validate)
    contents = []
    for name in QUANTITIES if quantity == "both" else (quantity,):
        fit = answer_residual(
            fitted, name, _stud(diameter, height, concrete, steel),
            _calibrated if mechanical else None,
            predamage=predamage, measure=measure, confidence=confidence,
        )  # fmt: skip
        relevant = damaged_rows(held, name, fit.predamage, fit.measure)
        wanted = bool(validate) or not relevant.empty  # asked for by name, or there by their role
        judged = judge_residual(fit, held, confidence) if wanted else None
        contents.append(plain(residual_content(fit, judged, confidence)))
    grades = dict.fromkeys(content["fit"]["grade"] for content in contents)
    result = {
        **_head("residual", file, with_shipped, calibrate, held, confidence, bad),
        "grade": "; ".join(grades),
        "quantities": contents,
    }
    print_json(result) if as_json else fit_text.residual(result)


def _formula(
    fitted: pd.DataFrame,
    held: pd.DataFrame,
    name: str,
    factor: list[str] | None,
    options: dict[str, Any],
) -> dict[str, Any]:
    """A formula fitted and, where tests are held out, judged by them."""
    from workbench.studs import fit_factors, fit_strength
    from workbench.studs.answers.strength import judge_strength, strength_content
    from workbench.studs.plain import plain

    fit = fit_strength(fitted, name, **options)
    judged = corrected = None
    if not held.empty:
        judged = judge_strength(fit, held, options["confidence"])
        corrected = judge_strength(fit, held, options["confidence"], corrected=True)
    content = strength_content(fit, judged)
    content["corrected"] = None if corrected is None else corrected.to_dict()
    factors = fit_factors(fitted, name, factor, loss=options["loss"]) if factor else None
    content["factors"] = None if factors is None else factors.to_dict()
    return dict(plain(content))


def _table(
    file: str | None, schema: Table, name: str, with_shipped: bool, keep_good: bool
) -> tuple[pd.DataFrame, list[str]]:
    """The rows to work on, and one sentence for every bad row that was left out."""
    from workbench.studs import examine, shipped
    from workbench.studs.split import joined

    if file is None:
        return shipped(name), []
    examination = examine(file, schema)
    rows = examination.rows if keep_good else examination.accept()
    bad = [str(problem.error()) for problem in examination.problems]
    if with_shipped:
        rows = joined([shipped(name), rows], unique=bool(schema.key))
    return rows, bad


def _split(
    table: pd.DataFrame, calibrate: list[str] | None, validate: list[str] | None
) -> tuple[pd.DataFrame, pd.DataFrame]:
    from workbench.studs.split import check_campaigns, split_table

    check_campaigns((*(calibrate or ()), *(validate or ())), table)
    return split_table(table, calibrate or (), validate or ())


def _head(
    fit: str,
    file: str | None,
    with_shipped: bool,
    calibrate: list[str] | None,
    held: pd.DataFrame,
    confidence: float,
    bad: list[str],
) -> dict[str, Any]:
    """What every answer begins with."""
    from workbench.studs.split import campaigns_of

    tables = ([] if file is None else [file]) + (["shipped"] if with_shipped or not file else [])
    return {
        "fit": fit,
        "tables": tables,
        "calibrate": calibrate or [],
        "validate": campaigns_of(held),
        "confidence": confidence,
        "rows_left_out": bad,
    }


def _check_confidence(value: float) -> None:
    from workbench.fields import Number

    Number(0.5, 0.999).check("--confidence", value)


def _variations(texts: list[str] | None) -> dict[str, float] | None:
    from workbench.errors import InputError
    from workbench.fields import Number
    from workbench.studs.strength import VARIATIONS

    if not texts:
        return None
    result = dict(VARIATIONS)
    for text in texts:
        name, _, value = text.partition("=")
        if name not in VARIATIONS:
            raise InputError("--variation", text, "must name one of " + ", ".join(VARIATIONS))
        try:
            number = float(value)
        except ValueError:
            raise InputError("--variation", text, "must look like concrete_strength=0.15") from None
        result[name] = float(Number(0.0, 1.0).check(f"--variation {name}", number))
    return result


def _stud(diameter: float, height: float, concrete: float, steel: float) -> Any:
    from workbench.studs.mechanical import Stud
    from workbench.studs.quantities import concrete_modulus

    strength = 1e6 * concrete
    return Stud(
        1e-3 * diameter, 1e-3 * height, strength, float(concrete_modulus(strength)), 1e6 * steel
    )


def _calibrated() -> Any:
    """The mechanical model, calibrated on the shipped campaign that tells all it needs."""
    from workbench.scenarios import StudTests
    from workbench.studs.answers.mechanical import CALIBRATION, calibrated

    return calibrated(StudTests("calibration", calibrate=(CALIBRATION,)))
