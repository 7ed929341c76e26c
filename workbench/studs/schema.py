"""One schema for tests on studs: push-out, pull-out, combined, and after pre-damage.

A table is a CSV file with the unit of every number in the name of its column. `TESTS` holds one
row per specimen, `POINTS` the points of measured curves; `columns.csv` beside this file declares
their columns. An empty cell means that the quantity was not reported; it never means zero.

**Second part.** Tables of tests by their schemas; every bad row is named by file, line, column and
reason.

`workbench.base.tables` gives the cells; here are the header, cells by the schema, rows by its
rules, and what must not repeat between rows.
"""

import tomllib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from math import isnan, pi
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from workbench.base.errors import InputError
from workbench.base.fields import Choice, Number, Text, did_you_mean
from workbench.base.tables import (
    COMMENT,
    FOUND_OUT,
    PLAIN,
    Cells,
    Reading,
    cells_of,
    read_cells,
    records,
)

EXTRA = "x_"  # columns of the user's own begin with this and are kept as they are
NO_PREDAMAGE = "none"
HEADED = "headed stud"
# a usual stud, for what neither a table nor the question tells
USUAL = {"diameter_mm": 19.0, "height_mm": 100.0, "fcm_MPa": 30.0, "fu_MPa": 450.0}
Row = dict[str, object]
RowFinding = tuple[str, object, str, str]  # column, value, reason, advice


@dataclass(frozen=True, slots=True)
class TableColumn:
    """A column: its name with the unit, what it means, and the rule of its cells.

    `filled`: it must exist and no cell may be empty; `default` fills empty words and flags.
    """

    name: str
    meaning: str
    rule: Number | Choice | Text
    filled: bool = False
    default: str = ""

    @property
    def unit(self) -> str:
        """The unit of its numbers, empty for words and for numbers without dimension."""
        return self.rule.unit if isinstance(self.rule, Number) else ""

    @property
    def base(self) -> str:
        """Its name without the unit."""
        return self.name.removesuffix(f"_{self.unit.replace('/', '_per_')}")

    @property
    def blank(self) -> object:
        """Value of an empty cell."""
        if isinstance(self.rule, Number):
            return float(self.default or "nan")
        return self.default


@dataclass(frozen=True, slots=True)
class TableSchema:
    """A kind of table: its columns, and the columns that together must not repeat (or none).

    `rules` gives the contradictions within a row whose single cells are in order; `complete` fills
    cells that others tell, and says so; `assumed`, what stands for a column that no row tells.
    """

    name: str
    columns: tuple[TableColumn, ...]
    key: tuple[str, ...] = ()
    rules: Callable[[Row], Iterator[RowFinding]] = lambda row: iter(())
    complete: Callable[[Row], Iterable[str]] = lambda row: ()
    assumed: Mapping[str, float] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(column.name for column in self.columns)

    def column(self, name: str) -> TableColumn:
        """The column of this name."""
        return self.columns[self.names.index(name)]

    def words(self, name: str) -> tuple[str, ...]:
        """The words that a column of words allows."""
        rule = self.column(name).rule
        return rule.words if isinstance(rule, Choice) else ()


def declared(table: str, path: Path) -> tuple[TableColumn, ...]:
    """The columns of a table that a file such as ``columns.csv`` declares."""
    return tuple(
        TableColumn(row["name"], row["meaning"], _rule(row), row["needed"] == "yes", row["default"])
        for row in records(path.read_text(encoding="utf-8"))
        if row["table"] == table
    )


def _rule(row: dict[str, str]) -> Number | Choice | Text:
    match row["kind"]:
        case "text":
            return Text(1000)
        case "word":
            return Choice(tuple(row["words"].split("|")))
        case "flag":
            return Number(0, 1, integer=True)
    low, high = float(row["low"]), float(row["high"])
    above = row["kind"] == "above"
    return Number(low, high, row["unit"], low_included=not above, advice=row["advice"])


TOTAL_TOLERANCE = 0.02  # load per stud times studs against the total: both are rounded
LEAST_STRESS, LARGEST_STRESS = 10.0, 2500.0  # MPa, load over shank area of any plausible test
LARGEST_OVER_SHANK = 2.0  # load over the tensile strength of the shank; collar and friction help
LARGEST_GAIN = 2.0  # damaged over undamaged
LEAST_SLIP = 0.02  # mm, at the largest load
LEAST_SLENDERNESS, LARGEST_SLENDERNESS = 1.5, 25.0  # height over diameter
PREDICTED = "predicted"  # an undamaged strength that no test gave
FATIGUE, LIFE, SN_LIFE = "fatigue", "life fraction", "S-N life fraction"
# of studs about their mean strength; a mean life may be several times the characteristic one
LARGEST_LEVEL = {"section loss": 1.0, "load ratio": 1.3, SN_LIFE: 10.0}
LEAST_OF_BORNE = 0.9  # of a load just borne, that a stud bears again: both are measured
PUSHED = (FATIGUE, "push-out")  # damage by shear, as the test that follows it
LIKE_LEVEL = 0.02  # by which a given share of life may miss that of the cycles
_CYCLES = (
    *("predamage_peak_kN", "predamage_range_kN", "predamage_cycles", "predamage_life_cycles"),
    "diameter_mm",
)
_MEASURED = {"push-out": ("shear_kN",), "pull-out": ("tension_kN",)}
_LOADS = ("shear_kN", "tension_kN")  # both in a combined test
QUANTITIES = {  # of which damage leaves a share: column, and that of the undamaged reference
    "strength": ("shear_kN", "undamaged_shear_kN"),
    "stiffness": ("stiffness_10_40_kN_per_mm", "undamaged_stiffness_kN_per_mm"),
}


def _shear_of_total(row: Row) -> Iterator[str]:
    """The shear of a stud from the load of a push-out specimen, where the row has that alone."""
    total, studs = known(row, "total_load_kN"), known(row, "n_studs")
    if total and studs and row["test"] == "push-out" and known(row, "shear_kN") is None:
        row["shear_kN"] = total / studs
        yield "shear_kN is computed as total_load_kN / n_studs"


def _contradictions(row: Row) -> Iterator[RowFinding]:
    yield from _results(row)
    yield from _sizes(row)
    yield from _predamage(row)


def known(row: Row, column: str) -> float | None:
    """The number in a cell, None where it was not reported."""
    value = row.get(column)
    return None if not isinstance(value, float) or isnan(value) else value


def _results(row: Row) -> Iterator[RowFinding]:
    for column in _MEASURED.get(str(row["test"]), _LOADS):
        if known(row, column) is None:
            advice = "or total_load_kN with n_studs" * (column == "shear_kN")
            yield column, "", f"must be given for a {row['test']} test", advice
    shear, studs, total = (known(row, c) for c in ("shear_kN", "n_studs", "total_load_kN"))
    if shear and studs and total and abs(shear * studs / total - 1.0) > TOTAL_TOLERANCE:
        advice = f"{studs:g} studs of {shear:g} kN make {shear * studs:.4g} kN"
        yield "total_load_kN", total, "does not fit shear_kN and n_studs", advice
    diameter = known(row, "diameter_mm")
    for column in _LOADS:
        load = known(row, column)
        if load and diameter:
            stress = 1e3 * load / (0.25 * pi * diameter**2)
            if not LEAST_STRESS <= stress <= LARGEST_STRESS:
                reason = f"means {stress:.3g} MPa over a shank of {diameter:g} mm"
                yield column, load, reason, "loads are in kN per stud, diameters in mm"
    yield from _plausible(row)


def _plausible(row: Row) -> Iterator[RowFinding]:
    """Results that no test can have: another unit, another column, the whole specimen."""
    diameter, ultimate, shear = (known(row, c) for c in ("diameter_mm", "fu_MPa", "shear_kN"))
    if shear and diameter and ultimate:
        share = 1e3 * shear / (0.25 * pi * diameter**2 * ultimate)
        if share > LARGEST_OVER_SHANK:
            reason = f"is {share:.2g} times the tensile strength of the shank"
            advice = "loads are per stud: is this the load of the specimen?"
            yield "shear_kN", shear, reason, advice
    for column, reference in QUANTITIES.values():
        value, whole = known(row, column), known(row, reference)
        if value and whole and value / whole > LARGEST_GAIN:
            reason = f"is {value / whole:.3g} times {reference}"
            yield column, value, reason, "are columns swapped, or the units different?"
    slip = known(row, "slip_at_max_mm")
    if slip is not None and slip < LEAST_SLIP:
        yield "slip_at_max_mm", slip, "is no slip at a largest load", "is it in metres?"


def _sizes(row: Row) -> Iterator[RowFinding]:
    diameter, height = known(row, "diameter_mm"), known(row, "height_mm")
    if diameter and height:
        slenderness = height / diameter
        if not LEAST_SLENDERNESS <= slenderness <= LARGEST_SLENDERNESS:
            yield "height_mm", height, f"is {slenderness:.3g} times the diameter", "both are in mm"
    strength, ultimate = known(row, "fy_MPa"), known(row, "fu_MPa")
    if strength and ultimate and strength > ultimate:
        yield "fy_MPa", strength, f"exceeds the tensile strength {ultimate:g} MPa", ""
    concrete = known(row, "fcm_MPa")
    if concrete and concrete == ultimate:
        yield "fcm_MPa", concrete, "equals fu_MPa", "is one column copied?"
    head = known(row, "head_diameter_mm")
    if head and diameter and head <= diameter:
        yield "head_diameter_mm", head, f"must exceed the shank, {diameter:g} mm", ""


def _predamage(row: Row) -> Iterator[RowFinding]:
    kind, level = row.get("predamage", NO_PREDAMAGE), known(row, "predamage_level")
    if kind == NO_PREDAMAGE:
        if level:
            yield "predamage_level", level, "needs a predamage other than none", ""
        return
    peak, span, cycles, life, diameter = (known(row, name) for name in _CYCLES)
    if peak and span and span > 2.0 * peak:
        reason = f"is more than from {-peak:g} to {peak:g} kN"
        yield "predamage_range_kN", span, reason, "it is the largest load of a cycle less the least"
    borne, shear = max(peak or 0.0, 0.5 * (span or 0.0)), known(row, "shear_kN")
    if shear and kind in PUSHED and shear < LEAST_OF_BORNE * borne:
        advice = f"its cycles have reached {borne:g} kN: is one of them of the whole specimen?"
        yield "shear_kN", shear, "is less than the load that the stud has borne", advice
    if level is None:
        if kind == FATIGUE and cycles is not None and (life or (span and diameter)):
            return  # the share of the life is computed
        advice = "0 for none, 1 for what an undamaged stud bears"
        if kind == FATIGUE:
            advice += "; or predamage_cycles with predamage_life_cycles or predamage_range_kN"
        yield "predamage_level", "", f"must be given with predamage {kind}", advice
        return
    measure = str(row.get("predamage_measure") or "")
    if not measure:
        yield "predamage_measure", "", "must say what the level of damage measures", ""
    if level > LARGEST_LEVEL.get(measure, level):
        yield "predamage_level", level, f"is no {measure}", f"at most {LARGEST_LEVEL[measure]:g}"
    if measure == LIFE and cycles and life and abs(cycles / life - level) > LIKE_LEVEL:
        reason = f"is not predamage_cycles over predamage_life_cycles, {cycles / life:.3g}"
        yield "predamage_level", level, reason, "leave it empty to have it computed"


_COLUMNS = Path(__file__).with_name("columns.csv")
TESTS = TableSchema(
    "tests",
    declared("tests", _COLUMNS),
    ("campaign", "specimen"),
    _contradictions,
    _shear_of_total,
    USUAL,
)
POINTS = TableSchema("points", declared("points", _COLUMNS))


# -- commented templates of tables: what to fill in, what it means, and an example that runs -------
# CSV whose comments stand above the header; what is in each, ``templates.toml`` declares.


class Template(NamedTuple):
    """Template of a table: its `title`, columns and example `rows`; `verb` that takes it.

    `more`, columns that help and may be added; `notes`, what columns alone do not tell; `units`, a
    second line for names without units (empty: the names hold them).
    """

    title: str
    schema: TableSchema
    columns: tuple[str, ...]
    more: tuple[str, ...]
    verb: str
    rows: tuple[str, ...]
    notes: tuple[str, ...] = ()
    units: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The whole template: comments, the header, and the line of units if there is one."""
        lines = (f"{COMMENT} {line}".rstrip() for line in self._comments())
        header = ",".join(self._header(name) for name in self.columns)
        return "\n".join([*lines, header, *([",".join(self.units)] if self.units else [])]) + "\n"

    def _header(self, name: str) -> str:
        """How the header names a column: without its unit where a line of units holds it."""
        return self.schema.column(name).base if self.units else name

    def _comments(self) -> Iterator[str]:
        yield f"{self.title}. Then"
        yield "    workbench data check FILE.csv"
        yield f"    workbench {self.verb}"
        yield "Lines above the header that begin with # are not read; an empty cell: not reported."
        for title, names in (("Columns:", self.columns), ("Columns that help:", self.more)):
            yield from ("", title)
            wide = max(len(self._header(name)) for name in names)
            for name in names:
                column = self.schema.column(name)
                rule = column.rule.allowed().removeprefix("must be ")
                words = "" if isinstance(column.rule, Text) else f"; {rule}"
                yield f"    {self._header(name):{wide}}  {column.meaning}{words}"
        yield from ("", *self.notes, "", "Example:")
        yield from (f"    {row}" for row in self.rows)


def templates_in(path: Path, *schemas: TableSchema) -> dict[str, Template]:
    """The templates that a file such as ``templates.toml`` declares, by their kinds."""
    named = {schema.name: schema for schema in schemas}

    def names(text: str) -> tuple[str, ...]:
        return tuple(name.strip() for name in text.split(",")) if text else ()

    return {
        kind: Template(
            title=given["title"],
            schema=named[given["table"]],
            columns=names(given["columns"]),
            more=names(given["more"]),
            verb=given["verb"],
            rows=tuple(given["rows"].splitlines()),
            notes=tuple(given.get("notes", "").splitlines()),
            units=names(given.get("units", "")),
        )
        for kind, given in tomllib.loads(path.read_text(encoding="utf-8")).items()
    }


TEMPLATES = templates_in(Path(__file__).with_name("templates.toml"), TESTS, POINTS)


def template(kind: str, filled: bool = False) -> str:
    """The text of a template, `filled` with its example. Raises `InputError` for unknown kinds."""
    Choice(tuple(TEMPLATES)).check("--kind", kind)
    chosen = TEMPLATES[kind]
    return chosen.text + "".join(f"{row}\n" for row in chosen.rows if filled)


_SHOWN = 5  # problems that one message lists by line


@dataclass(frozen=True, slots=True)
class CellProblem:
    """Problem with one cell or row: `line` of the file (1 is the header), `column` or ''."""

    file: str
    line: int
    column: str
    value: object
    reason: str
    advice: str = ""

    def error(self, others: tuple[int, ...] = ()) -> InputError:
        """The problem as an error; `others`, lines of further problems to mention."""
        place = f"{self.file}, line {self.line}" + (f", column {self.column}" * bool(self.column))
        mention = ""
        if others:
            lines = ", ".join(str(line) for line in others[:_SHOWN])
            more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
            mention = f"also look at line{'s' if len(others) > 1 else ''} {lines}{more}"
        advice = "; ".join(text for text in (self.advice, mention) if text)
        return InputError(place, self.value, self.reason, advice)


@dataclass(frozen=True)
class Examination:
    """A table as found: the good `rows`, and the `problems` of all others.

    `notes`, how it was read and what was computed, one sentence each.
    """

    rows: pd.DataFrame
    problems: tuple[CellProblem, ...]
    notes: tuple[str, ...] = ()

    def accept(self) -> pd.DataFrame:
        """The rows if all are good. Raises `InputError` that names the first bad one."""
        if self.problems:
            first = self.problems[0]
            lines = {problem.line for problem in self.problems[1:]} - {first.line}
            raise first.error(tuple(sorted(lines)))
        return self.rows


def read_tests(path: str | Path, *, keep_good: bool = False) -> pd.DataFrame:
    """Table of tests on studs (schema `TESTS`), one row per specimen.

    Arguments: `path` of a table; `keep_good`, leave bad rows out instead of refusing the file
    (`examine` says which). Missing numbers are NaN, missing texts empty. Raises `InputError`.
    """
    examination = examine(path, TESTS)
    return examination.rows if keep_good else examination.accept()


def read_text(text: str, table: TableSchema, name: str = "table") -> Examination:
    """Examine a table given as text as the workbench writes it (see `examine`)."""
    return examined(cells_of(text.encode(), name, table.names.__contains__, PLAIN), table)


def from_frame(frame: pd.DataFrame, table: TableSchema, name: str = "table") -> pd.DataFrame:
    """A data frame made elsewhere, checked and completed by a schema (see `read_tests`)."""
    return read_text(frame.to_csv(index=False), table, name).accept()


def examine(path: str | Path, table: TableSchema, how: Reading = FOUND_OUT) -> Examination:
    """Read a table row by row, separating good rows from problems.

    Raises `InputError` when no row can be read at all, as of large files, which are not read.
    """
    return examined(read_cells(Path(path), table.names.__contains__, how), table)


def examined(cells: Cells, table: TableSchema) -> Examination:
    """The good rows and the problems of a table by its cells. Raises `InputError`."""
    rows, problems, notes = list[Row](), list[CellProblem](), Counter[str]()
    columns, seen = _columns(cells, table), _Seen(table)
    for line, texts in cells.rows[1:]:
        row, findings = _row(texts, columns, cells)
        notes.update(() if findings else table.complete(row))
        findings = findings or list(table.rules(row)) or list(seen.repeated(row, line))
        problems.extend(CellProblem(cells.name, line, *finding) for finding in findings)
        if not findings:
            rows.append(row)
    if not rows and not problems:
        raise InputError(cells.name, "only a header", "must hold one row or more")
    frame, words = _frame(rows, columns, table), "is in no row: models that need it assume this"
    silent = [f"{c} ({value:g})" for c, value in table.assumed.items() if frame[c].isna().all()]
    computed = [f"{note} in {count} rows" for note, count in notes.items()]
    computed += [f"{', '.join(silent)} {words}"] * bool(rows and silent)
    return Examination(frame, tuple(problems), (*cells.notes, *computed))


@dataclass
class _Seen:
    """Names in the rows before: keys, and the spelling of every campaign."""

    table: TableSchema
    lines: dict[tuple[str, ...], int] = field(default_factory=dict)
    spelling: dict[str, tuple[str, int]] = field(default_factory=dict)

    def repeated(self, row: Row, line: int) -> Iterator[RowFinding]:
        """A specimen that stands twice, or else a campaign in another spelling."""
        key = tuple(str(row[part]) for part in self.table.key)
        first = self.lines.setdefault(tuple(part.casefold() for part in key), line)
        if key and first != line:
            advice = "every specimen of a campaign has its own name"
            yield self.table.key[-1], ", ".join(key), f"stands in line {first} too", advice
            return
        campaign = str(row.get("campaign", ""))
        spelled, first = self.spelling.setdefault(campaign.casefold(), (campaign, line))
        if campaign != spelled:
            advice = "one campaign has one spelling: scatter between campaigns counts"
            yield "campaign", campaign, f"is spelled {spelled} in line {first}", advice


def _columns(cells: Cells, table: TableSchema) -> list[TableColumn | str]:
    """The column of the schema, or the name of the user's own, at every place of the header."""
    names, place = cells.header, f"{cells.name}, line {cells.rows[0][0]}"
    for column in names:
        if not column.startswith(EXTRA) and column not in table.names:
            advice = f"{did_you_mean(column, table.names)} columns of your own begin with {EXTRA}"
            raise InputError(place, column, "unknown column", advice.lstrip())
    missing = ", ".join(c.name for c in table.columns if c.filled and c.name not in names)
    if missing:
        raise InputError(place, missing, "required column missing", "units belong to the name")
    return [name if name.startswith(EXTRA) else table.column(name) for name in names]


def width_findings(cells: list[str], width: int) -> list[RowFinding]:
    """Findings on a row that has not as many cells as the header."""
    if len(cells) == width:
        return []
    reason = f"has {len(cells)} cells where the header has {width}"
    advice = "put a text with separators in quotation marks, and write decimal points: 19.05"
    return [("", ",".join(cells), reason, advice)]


def _row(
    texts: list[str], columns: list[TableColumn | str], cells: Cells
) -> tuple[Row, list[RowFinding]]:
    row, findings = Row(), width_findings(texts, len(columns))
    if findings:
        return row, findings
    for text, column in zip(texts, columns, strict=True):
        if isinstance(column, str):
            row[column] = text
            continue
        try:
            row[column.name] = _cell(text, column, cells)
        except InputError as error:
            findings.append((column.name, error.value, error.allowed, error.advice))
    return row, findings


def _cell(text: str, column: TableColumn, cells: Cells) -> object:
    if not text:
        if column.filled:
            raise InputError(column.name, text, "must not be empty")
        return column.blank
    if not isinstance(column.rule, Number):
        return column.rule.check(column.name, text)
    number = cells.number(text)
    if number is None:
        raise InputError(column.name, text, column.rule.allowed(), cells.advice)
    return float(column.rule.check(column.name, number))


def _frame(
    rows: list[Row], columns: Iterable[TableColumn | str], table: TableSchema
) -> pd.DataFrame:
    """All columns of the schema in its order, then the user's own."""
    data = {
        column.name: pd.Series(
            [row.get(column.name, column.blank) for row in rows],
            dtype=float if isinstance(column.rule, Number) else object,
        )
        for column in table.columns
    }
    extra = (column for column in columns if isinstance(column, str))
    return pd.DataFrame(
        {**data, **{name: pd.Series([row[name] for row in rows], dtype=object) for name in extra}}
    )
