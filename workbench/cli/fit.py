"""`workbench fit`: strength, load-slip and residual capacity of studs from tables of tests.

A verb is a class: its fields are the options, `find` gives the tables of the answer.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import typer

from workbench.base.errors import InputError
from workbench.base.fields import Choice, Number
from workbench.cli.output import DECIMAL, SEP, SHEET, Answer, Names, option, verb, writable

if TYPE_CHECKING:
    import pandas as pd

    from workbench.report.page.markdown import Block
    from workbench.studs.fit_protocol import Tables

app = typer.Typer(
    help="Fit laws of studs to a table of tests.", rich_markup_mode=None, no_args_is_help=False
)
FORMATS = ("html", "pdf")
USUAL_SPECIFIED = 450.0  # MPa, of stud material: SD1 of ISO 13918
_CAMPAIGN, _LOSS = "CAMPAIGN", "linear, huber or bisquare."
_BETWEEN = "Scatter between campaigns (of logarithms, of shares left) that is known."


def _file(metavar: str, rows: str) -> Any:
    text = f"Your table of {rows}.  [default: shipped tables]"
    return typer.Argument(None, metavar=metavar, help=text)


@dataclass
class FitVerb:
    """What every fit is asked: the tables, the campaigns, the confidence, a report."""

    file: str | None = _file("[FILE.csv]", "tests")
    calibrate: Names = option("A campaign to fit.  [default: all not validating]", None, _CAMPAIGN)
    validate: Names = option("A campaign to judge the fit by, kept out of it.", None, _CAMPAIGN)
    with_shipped: bool = option("Add the shipped tables to FILE.", False, None, "--with-shipped")
    keep_good: bool = option("Leave bad rows of FILE out.", False, None, "--keep-good")
    confidence: float = option("Confidence of intervals and bands.", 0.9)
    report: Names = option("Write a report, its curves as CSV beside it.", None, "FILE.html|pdf")
    sheet: str | None = SHEET
    sep: str | None = SEP
    decimal: str | None = DECIMAL

    name: ClassVar[str]
    on_curves: ClassVar[bool] = False

    def find(self, fitted: pd.DataFrame, held: pd.DataFrame) -> Tables:
        """The tables of the answer, of the rows to fit and of those held out to judge it."""
        raise NotImplementedError

    def _given(self, *names: str) -> dict[str, Any]:
        return {name: getattr(self, name) for name in names}

    def answer(self) -> Answer:
        """Read the tables, find the answer, write the reports that are asked for."""
        from workbench.studs.fit_protocol import plain

        Number(0.5, 0.999).check("--confidence", self.confidence)
        if (between := getattr(self, "known_between", None)) is not None:
            Number(0.001, 1.0).check("--known-between", between)
        targets, inputs = {}, (self.file, getattr(self, "points", None))
        for name in self.report or ():  # refused before anything is computed
            target = writable("--report", name, *FORMATS, inputs=inputs)
            targets[target.suffix.lower().removeprefix(".")] = target
        fitted, held, head = self._split()
        written: dict[str, Path] = {}
        try:
            tables = self.find(fitted, held)
        except InputError as error:
            if len(fitted) or not head["roles"]:
                raise
            roles = ", ".join(f"{role} in {n}" for role, n in head["roles"].items())
            advice = 'give rows to fit the role "calibrate"; --with-shipped judges by the others'
            reason = f"none may be fitted: their role is {roles}"
            raise InputError(
                "table", f"{sum(head['roles'].values())} rows", reason, advice
            ) from error
        if targets:
            from workbench.report.fit_report import write

            written = write(head, tables, (fitted, held), targets)
        return Answer({**head, "results": plain(tables)}, _blocks(head, tables, written))

    def _split(self) -> tuple[pd.DataFrame, pd.DataFrame, dict[str, Any]]:
        """The rows to fit, those that judge, and what was asked."""
        from workbench.base.datafiles import digest
        from workbench.base.tables import Reading
        from workbench.studs import POINTS, TESTS, examine, shipped
        from workbench.studs.tables import campaigns_of, check_campaigns, joined, split_table

        schema = POINTS if self.on_curves else TESTS
        with_shipped = self.with_shipped or self.file is None
        parts = [shipped("stud-load-slip" if self.on_curves else "stud-push-out")] * with_shipped
        left_out: list[str] = []
        notes: list[str] = []
        if self.file is not None:
            how = Reading(self.sheet, self.sep, self.decimal)
            examination = examine(self.file, schema, how)
            notes += (f"{Path(self.file).name}: {note}" for note in examination.notes)
            parts.append(examination.rows if self.keep_good else examination.accept())
            left_out = [str(problem.error()) for problem in examination.problems]
        table = joined(parts, unique=bool(schema.key))
        calibrate, validate = self.calibrate or [], self.validate or []
        check_campaigns((*calibrate, *validate), table)
        fitted, held = split_table(table, calibrate, validate)
        declared: dict[str, Any] = {each.name: each.default for each in fields(self)}
        options = {
            name: value
            for name, value in vars(self).items()
            if name not in ("file", "report", "points") and value != declared[name].default
        }
        return fitted, held, {
            "fit": self.name,
            "tables": [*([self.file] if self.file else []), *["shipped"] * with_shipped],
            "calibrate": calibrate,
            "validate": campaigns_of(held),
            "confidence": self.confidence,
            "options": options,
            "digest": None if self.file is None else digest(Path(self.file)),
            "rows_left_out": left_out,
            "notes": notes,
            "roles": table["role"].value_counts().to_dict() if "role" in table else {},
            "known_variation": getattr(self, "known_variation", None),
        }  # fmt: skip


def _blocks(head: dict[str, Any], tables: Tables, written: dict[str, Path]) -> Iterator[Block]:
    """The answer on a terminal, and the reports that were written."""
    from workbench.report.chapters.studs import of_fit
    from workbench.report.page.markdown import paragraph

    yield of_fit("shown", head, tables)
    yield from (paragraph(f"{words}: {path}") for words, path in written.items())


def _command(kind: type[FitVerb]) -> type[FitVerb]:
    """Make a command of a verb: its parameters are those that its class is made with."""

    def command(**given: Any) -> Answer:
        return kind(**given).answer()

    command.__signature__ = signature(kind, eval_str=True)  # type: ignore[attr-defined]
    command.__doc__ = kind.__doc__
    app.command(kind.name)(verb(command))
    return kind


@_command
@dataclass
class StudStrength(FitVerb):
    """Judge and fit formulas of strength.

    Undamaged headed studs in solid slabs with use_for_fit = 1; with EN 1990 D.8 and, under shear,
    EN 1994-1-1 Annex B.2. Campaigns that validate are kept out of the fit.
    """

    model: Names = option(
        "A formula; of pull-outs en1992-, aci318-, aisc360-tension.  [default: all of shear]",
        None,
        "NAME",
    )
    trend: Names = option("A variable whose missing exponent is fitted.", None, "NAME")
    factor: Names = option("Fit this factor of the formula: steel or concrete.", None, "NAME")
    loss: str = option(_LOSS, "linear", "NAME")
    known_between: float | None = option(_BETWEEN, None, "TAU")
    slab: str = option("solid, or deck: reduced by the rules of the codes.", "solid", "NAME")
    variation: Names = option("Scatter of a variable in structures, for D.8.", None, "NAME=V")
    points: str | None = option("Load-slip curves, for slip capacities.", None, "POINTS.csv")
    specified: float | None = option(
        "Specified stud strength.  [default: 450 in Annex B, as tested in D.8]",
        None,
        "MPA",
        "--specified-fu",
    )

    name: ClassVar[str] = "stud-strength"

    def find(self, fitted: pd.DataFrame, held: pd.DataFrame) -> Tables:
        """Every formula, as it is and as fitted; Annex B under shear; which scatters least."""
        from workbench.studs import POINTS, TESTS, examine, laboratory

        usual = USUAL_SPECIFIED if self.specified is None else self.specified
        TESTS.column("fu_MPa").rule.check("--specified-fu", usual)
        return laboratory.strength(
            fitted,
            held,
            self.model,
            points=None if self.points is None else examine(self.points, POINTS).accept(),
            specified=1e6 * usual,
            factors=self.factor,
            trends=tuple(self.trend or ()),
            variations=_variations(self.variation or []),
            specified_strength=None if self.specified is None else 1e6 * usual,
            **self._given("loss", "confidence", "slab", "known_between"),
        )


def _variations(texts: list[str]) -> dict[str, float]:
    """Coefficients of variation, of texts like ``diameter=0.02`` where they are given."""
    from workbench.studs.strength_fit import VARIATIONS

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


@_command
@dataclass
class LoadSlip(FitVerb):
    """Fit load-slip laws to push-out curves.

    Curves are the observations, not points: a curve of many points counts once.
    """

    file: str | None = _file("[POINTS.csv]", "points")
    law: Names = option("A law of `workbench.studs.LAWS`.  [default: all]", None, "NAME")
    loss: str = option("linear, huber or soft_l1.", "linear", "NAME")
    least_points: int = option("Points that a curve needs to count.", 3)

    name: ClassVar[str] = "load-slip"
    on_curves: ClassVar[bool] = True

    def find(self, fitted: pd.DataFrame, held: pd.DataFrame) -> Tables:
        """Every law, and the points that the laws are drawn over."""
        from workbench.studs import laboratory

        Number(2, 10_000, integer=True).check("--least-points", self.least_points)
        how = self._given("loss", "least_points", "confidence")
        return laboratory.load_slip(fitted, held, self.law, **how)


@_command
@dataclass
class Residual(FitVerb):
    """Fit what is left after pre-damage.

    The answer carries the grade of its evidence. Without tests after pre-damage the mechanical
    model predicts, and nothing validates it.
    """

    quantity: str = option("strength, stiffness or both.", "both", "NAME")
    predamage: str | None = option("Tests after this damage only.", None, "KIND")
    measure: str | None = option("Tests with this measure of damage only.", None, "NAME")
    loss: str = option(_LOSS, "linear", "NAME")
    known_between: float | None = option(_BETWEEN, None, "TAU")
    predicted_reference: bool = option(
        "Predict undamaged strengths that no test gave.", False, None, "--predicted-reference"
    )
    mechanical: bool = option("Let the mechanical model predict, or compete.", True)
    diameter_mm: float | None = option(
        "Stud to predict for.  [default: those of FILE, else 19]", None
    )
    height_mm: float | None = option("Height of that stud.  [default: as in FILE, else 100]", None)
    fcm_mpa: float | None = option(
        "Mean strength of its slab.  [default: as in FILE, else 30]", None
    )
    fu_mpa: float | None = option("Its tensile strength.  [default: as in FILE, else 450]", None)

    name: ClassVar[str] = "residual"

    def find(self, fitted: pd.DataFrame, held: pd.DataFrame) -> Tables:
        """What is left of strength, stiffness or both; without tests one answer for every stud."""
        from workbench.studs import TESTS, laboratory
        from workbench.studs.schema import QUANTITIES, USUAL

        Choice((*QUANTITIES, "both")).check("--quantity", self.quantity)
        given = {column: getattr(self, column.lower()) for column in USUAL}
        for column, value in given.items():
            if value is not None:
                flag = f"--{column.lower().replace('_', '-')}"
                TESTS.column(column).rule.check(flag, value)
        return laboratory.residual(
            fitted,
            held,
            tuple(QUANTITIES) if self.quantity == "both" else (self.quantity,),
            given=given,
            model=_calibrated if self.mechanical else None,
            judged=bool(self.validate),
            predicted_reference=self.predicted_reference,
            **self._given("predamage", "measure", "loss", "confidence", "known_between"),
        )


def _calibrated() -> Any:
    """The mechanical model, calibrated on the shipped campaign that tells all that it needs."""
    from workbench.scenarios import StudTests
    from workbench.studs.answers import CALIBRATION, calibrated

    return calibrated(StudTests("calibration", calibrate=(CALIBRATION,)))


@_command
@dataclass
class Interaction(FitVerb):
    """Fit the exponent of tension with shear.

    Combined tests (test = combined) over the pull-outs and push-outs of their campaign and
    diameter; t^p + v^p = 1, with the laws of the codes on the same tests.
    """

    loss: str = option(_LOSS, "linear", "NAME")

    name: ClassVar[str] = "interaction"

    def find(self, fitted: pd.DataFrame, held: pd.DataFrame) -> Tables:
        """The exponent, and the laws of the codes."""
        from workbench.studs import laboratory

        return laboratory.interaction(fitted, held, **self._given("loss", "confidence"))


@_command
@dataclass
class FewTests(FitVerb):
    """Characteristic value of one to three tests, EN 1990 D.8.4.

    Strength of undamaged studs, and share of strength and stiffness left after damage, for a
    scatter that earlier tests with the same resistance have shown (--known-variation).
    """

    known_variation: float | None = option("V_r that earlier tests have shown; needed.", None, "V")

    name: ClassVar[str] = "few-tests"

    def find(self, fitted: pd.DataFrame, held: pd.DataFrame) -> Tables:
        """Every group of nominally equal tests."""
        import pandas as pd

        from workbench.studs.series import evaluate_few

        known = self.known_variation
        if known is None:
            advice, reason = "--known-variation 0.11 for example", "must be given: few tests do not"
            raise InputError("--known-variation", "", f"{reason} tell it", advice)
        Number(0.01, 0.5).check("--known-variation", known)
        return {"groups": pd.DataFrame(evaluate_few(fitted, known))}
