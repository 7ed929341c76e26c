"""Tab of studs: a table of tests, its columns, a question, the tests in a picture, the appendix.

A table is data only: the reader of tables reads its bytes, and nothing of it is kept or run.
"""

import hashlib
import io
import tomllib
from asyncio import wrap_future
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from shutil import make_archive
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd
import panel as pn
from bokeh.models import ColumnDataSource
from bokeh.plotting import figure
from markupsafe import escape

from workbench.base.catalogue import STUD_POINTS, STUD_TESTS
from workbench.base.datafiles import LARGEST_FILE
from workbench.base.errors import InputError
from workbench.base.fields import Choice
from workbench.base.tables import FILES, Cells, Reading, cells_of
from workbench.extras.app.desk import trouble
from workbench.extras.intake.conversion import UNITS, convert, examined_from, place_of
from workbench.extras.intake.kinds import KINDS, names_column
from workbench.extras.intake.mapping import Mapping as Statements
from workbench.report import fit_report
from workbench.report.chapters.studs import of_fit
from workbench.report.drawing.studs import judged_tests
from workbench.report.page.documents import html_of_blocks
from workbench.report.page.markdown import section
from workbench.studs import laboratory
from workbench.studs.fit_protocol import Tables
from workbench.studs.questions import LoadSlipQuestion, Question, ResidualQuestion, StrengthQuestion
from workbench.studs.schema import NO_PREDAMAGE, Examination, TableSchema, template
from workbench.studs.tables import shipped

WORDS: dict[str, Any] = tomllib.loads(
    Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")
)
MOST_COLUMNS, MOST_LISTED, MOST_SAID = 80, 2_000, 8  # that a person looks through
LANE = "studs"  # a worker of its own: models that take long do not hold it up
OPEN = "as the table says"  # unit in the name of a column or in a row of units
LEFT, HELD = "left out", "held out"  # uses of tests that a person gives
_LOOKS = {"fitted": ("circle", "#00558c"), HELD: ("square", "#8a5a00"), LEFT: ("x", "#a11616")}
_ROWS = {"a test on a stud": STUD_TESTS, "a point of a load-slip curve": STUD_POINTS}
_WIDE: dict[str, Any] = {"sizing_mode": "stretch_width"}
_LOOK = [Path(__file__).with_name(name).read_text("utf-8") for name in ("parts.css", "studs.css")]
Answered = tuple[dict[str, Any], Tables, tuple[pd.DataFrame, pd.DataFrame], str]


def read_table(name: str, data: bytes, sheet: str | None = None) -> Cells:
    """Cells of a table that was dropped. Raises `InputError`."""
    if not name.lower().endswith(FILES):
        raise InputError(name, None, f"must end in {' or '.join(FILES)}", "save it as one of them")
    if len(data) > LARGEST_FILE:
        raise InputError(name, len(data), f"the file exceeds {LARGEST_FILE / 1e6:.0f} MB")
    cells = cells_of(data, name, names_column, Reading(sheet))
    if (count := len(cells.header)) > MOST_COLUMNS:
        raise InputError(name, count, f"has over {MOST_COLUMNS} columns", "leave some out")
    return cells


def examined_as(cells: Cells, kind: str, said: dict[str, Any]) -> Examination:
    """Rows of a table by a kind of schema and what was said of it. Raises `InputError`."""
    converted = convert(cells, KINDS[kind].table, Statements(**said), {})
    found = examined_from(converted, KINDS[kind].table)
    return replace(found, notes=(*converted.notes, *found.notes[len(cells.notes) :]))


def answer(question: Question, table: pd.DataFrame, *of_table: dict[str, Any]) -> Answered:
    """Head, tables and rows (fitted, held) of an answer, and its page. Raises `InputError`."""
    fitted, held = question.split(table)
    how, told = of_table
    head, tables = question.head(table, held, how, **told), laboratory.find(question, fitted, held)
    parts = [
        of_fit("answer", head, tables),
        section("all", "All numbers and warnings", of_fit("shown", head, tables), folded=True),
    ]
    return head, tables, (fitted, held), html_of_blocks(*parts)


def appendix(answered: Answered, ending: str) -> bytes:
    """Bytes of the report of an answer: a PDF, or a ZIP of it with its curves and rows."""
    with TemporaryDirectory() as folder, TemporaryDirectory() as beside:
        target = Path(folder, "studs.pdf")
        fit_report.write(*answered[:3], {"pdf": target})
        if ending == "zip":
            target = Path(make_archive(f"{beside}/studs", "zip", folder))
        return target.read_bytes()


def tests_and_band(name: str, tables: Tables, of: str) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Tests (`test`, `use`, x, y) of one of several answers; its line `y` with `low`, `high`."""
    own = {key: each[each["of"] == of] if "of" in each else each for key, each in tables.items()}
    if name == LoadSlipQuestion.name:
        tests, band = own["points"], own["grid"]
        largest = tests.groupby(["campaign", "specimen"])["load"].transform("max")
        tests = tests.assign(x=1e3 * tests["slip"], y=tests["load"] / largest)
        band = band.assign(x=1e3 * band["slip"], y=band["median"])
    elif name == ResidualQuestion.name:
        tests, band = own["tests"].assign(unseen=False, y=own["tests"]["ratio"]), own["curve"]
        if "judged" in own:
            unseen = own["judged"].assign(unseen=True, y=own["judged"]["test"])
            tests = pd.concat([tests, unseen], ignore_index=True)
        tests, band = tests.assign(x=tests["level"]), band.assign(x=band["level"], y=band["left"])
    else:
        tests, fit = judged_tests(of, own), own["fit"].iloc[0]
        tests = tests.assign(x=1e-3 * tests["prediction"], y=1e-3 * tests["test"])
        ends = "own" if pd.notna(fit["own_low"]) else "bias"  # a new test, or the median
        slopes = {"y": fit["bias"], "low": fit[f"{ends}_low"], "high": fit[f"{ends}_high"]}
        x = np.array([0.0, 1.05 * tests["x"].max()])
        band = pd.DataFrame({"x": x, **{key: float(each) * x for key, each in slopes.items()}})
    use = tests["unseen"].map({True: HELD, False: "fitted"})
    tests = tests.assign(test=names_of(tests), use=use)[["test", "use", "x", "y"]]
    return tests, band[["x", "y", "low", "high"]].astype(float)


def names_of(rows: pd.DataFrame) -> pd.Series:
    """Names (n,) of the tests of rows: campaign and specimen."""
    return rows["campaign"].str.cat(rows["specimen"], sep=" ")


class StudDesk:
    """Tests on studs of one session: the table that was dropped, how it is read, its fit.

    Argument: `desk`, whose ``ask(function, *arguments, lane=...)`` gives a `Future` of work done
    elsewhere.
    """

    def __init__(self, desk: Any) -> None:
        self.desk, self.document, self.turn = desk, None, 0
        self.file: tuple[str, bytes] = "", b""
        self.cells: Any = None  # of the file
        self.found: Any = None  # its rows, good and bad
        self.answered: Any = None
        self.rows, self.told = pd.DataFrame(), dict[str, Any]()  # in use; what heads tell of them
        self.marks: dict[str, str] = {}  # uses that a person gave tests, by name
        self.drawn: dict[str, pd.DataFrame] = {}  # tests where an answer last had them
        self.source, made = ColumnDataSource(), pn.widgets
        self.drop = made.FileDropper(
            label="Table (CSV or XLSX)", max_file_size="20MB", chunk_size=2_000_000
        )
        self.sheet = made.TextInput(label="Sheet of the workbook", visible=False)
        self.kind = made.Select(label="A row of the table is", options=_ROWS)
        self.question = made.Select(label="What the tests are to tell")
        self.of = made.Select(label="Shown in the picture")
        self.tests = made.MultiSelect(label="Tests", size=9, **_WIDE)
        self.columns, self.constants, self.options = (pn.FlexBox() for _ in "123")
        self.leave = _button("Leave these rows out and go on", self.take)
        self.picture = pn.pane.Bokeh(None, **_WIDE)
        self.page = _text("")
        self.status = _text("", styles={"position": "sticky", "top": "0", "z-index": "9"})
        reacts: dict[Any, Callable[[], None]] = {self.drop: self._dropped, self.sheet: self.read}
        reacts |= {self.kind: self.match, self.question: self.offer, self.of: self.draw}
        for widget, react in (reacts | {self.tests: self._select}).items():
            widget.param.watch(lambda _, react=react: react(), "value")
        tables = [_button(label, self.use, name) for name, label in WORDS["shipped"].items()]
        for kind, label in WORDS["templates"].items():
            content = template(kind, filled=True)
            tables.append(_saved(f"{kind}.csv", label, io.StringIO, content))
        marks = [_button(label, self.mark, use) for use, label in WORDS["marks"].items()]
        saved = [_saved(f"studs.{end}", t, self.save, end) for end, t in WORDS["saved"].items()]
        confirm = _button("Use these columns", self.examine)
        confirm.button_type = "primary"
        parts: Iterable[tuple[Any, ...]] = (
            (self.drop, self.sheet, pn.FlexBox(*tables)),
            (self.kind, self.columns, self.constants, confirm, self.leave),
            (self.question, self.options),
            (self.of, self.picture, self.tests, pn.FlexBox(*marks)),
            (self.page, pn.FlexBox(*saved)),
        )
        self.steps = {
            name: pn.Column(_text(f"<h3>{title}</h3><p>{words}</p>"), *part, **_WIDE)
            for (name, (title, words)), part in zip(WORDS["steps"].items(), parts, strict=True)
        }
        self._go("table")

    def view(self) -> pn.Column:
        """The tab of one session of the page."""
        self.document = pn.state.curdoc
        if self.document is not None:
            pn.extension("filedropper")
        return pn.Column(self.status, *self.steps.values(), **_WIDE)

    def _go(self, last: str) -> None:
        """Show the steps up to the `last` one."""
        for place, (name, step) in enumerate(self.steps.items()):
            known = name != "columns" or self.cells is not None
            step.visible = known and place <= list(self.steps).index(last)

    def say(self, *texts: str, role: str = "alert") -> None:
        """Say sentences on top of the page, which screen readers speak, or nothing any more."""
        more = [f"and {len(texts) - MOST_SAID} more"] * (len(texts) > MOST_SAID)
        said = "".join(f"<p>{escape(text)}</p>" for text in (*texts[:MOST_SAID], *more))
        self.status.object = said and f'<div class="said" role="{role}">{said}</div>'

    def ask(self, then: Callable[[Any], None], function: Callable[..., Any], *values: Any) -> None:
        """Let a function work elsewhere; `then` gets its result unless more was asked since."""
        self.turn += 1
        later = partial(self._arrived, self.turn, then)
        self.say("Working ...", role="status")
        future = self.desk.ask(function, *values, lane=LANE)
        future.add_done_callback(lambda done: self._later(partial(later, done)))

    def _later(self, act: Callable[[], None]) -> None:
        """Act with the lock of the page, which other threads and watchers lack."""
        if self.document is None:
            act()
        elif self.document.session_context is not None:  # the page is still open
            self.document.add_next_tick_callback(act)

    def _arrived(self, turn: int, then: Callable[[Any], None], future: Future[Any]) -> None:
        if turn != self.turn:
            return
        try:
            result = future.result()
        except Exception as error:  # a worker may end in any way
            self.sheet.visible |= getattr(error, "field", "") == "--sheet"
            self.say(trouble(error))
        else:
            self.say()
            then(result)

    # -- the table and its columns ----------------------------------------------------------------

    def _dropped(self) -> None:
        if self.drop.value:
            name, data = self.drop.value.popitem()
            self.file = name, data.encode() if isinstance(data, str) else data
            self.sheet.param.update(value="", visible=False)
            self.read()

    def read(self) -> None:
        """Read the file; its columns come next."""
        self._go("table")
        self.ask(self._matched, read_table, *self.file, self.sheet.value or None)

    def _matched(self, cells: Cells) -> None:
        self.cells = cells
        count = {k: sum(map(bool, self._places(k).values())) for k in _ROWS.values()}
        best = max(count, key=lambda kind: count[kind])
        if self.kind.value == best:
            self.match()
        self.kind.value = best

    def _places(self, kind: str) -> dict[str, str]:
        """Columns of a kind of schema by those of the file, "" for what is none."""
        known = dict.fromkeys(self.cells.header, "")
        for name in known:
            with suppress(InputError):  # no column: a person says what it is
                if place := place_of(name, KINDS[kind].table, Statements(), name):
                    known[name] = place.target
        return known

    def match(self) -> None:
        """Match the columns by their names, and offer a choice for each."""
        table, places = KINDS[self.kind.value].table, self._places(self.kind.value)
        self.columns[:] = [_choice(name, target, table) for name, target in places.items()]
        missing = (each for each in table.columns if each.name not in places.values())
        self.constants[:] = [
            _chosen(f"{each.name} of all rows", ["", *each.rule.words], "", each.name)
            if isinstance(each.rule, Choice)
            else pn.widgets.TextInput(label=f"{each.name} of all rows", tags=[each.name])
            for each in missing
            if each.filled or each.name in table.assumed
        ]
        self.leave.visible = False
        self._go("columns")

    def examine(self) -> None:
        """Read the rows by the columns that were confirmed."""
        kind, names = self.kind.value, self.cells.header
        rows = [(n, *row.objects) for n, row in zip(names, self.columns, strict=True)]
        meant, auto = {n: column.value for n, column, _ in rows}, self._places(kind)
        said = {
            "columns": {n: column for n, column in meant.items() if column not in ("", auto[n])},
            "units": {n: unit.value for n, _, unit in rows if unit.visible and unit.value != OPEN},
            "constants": {each.tags[0]: each.value for each in self.constants if each.value},
            "ignore": tuple(n for n, column in meant.items() if not column),
        }
        self.ask(self._examined, examined_as, self.cells, kind, said)

    def _examined(self, found: Examination) -> None:
        self.found, self.leave.visible = found, bool(found.problems) and len(found.rows) > 0
        self._go("columns")
        self.say(*(str(problem.error()) for problem in found.problems))
        if not found.problems:
            self.take()

    def take(self) -> None:
        """Take the good rows of the file."""
        (name, data), found = self.file, self.found
        self._start(
            found.rows,
            tables=[name],
            digest=hashlib.sha256(data).hexdigest()[:16],
            rows_left_out=[str(problem.error()) for problem in found.problems],
            notes=[f"{name}: {note}" for note in found.notes],
        )

    def use(self, name: str) -> None:
        """Take a table that comes with the workbench."""
        self.cells = None
        self._start(shipped(name), tables=["shipped"], digest=None, rows_left_out=[], notes=[])

    # -- the question and its answer --------------------------------------------------------------

    def _start(self, rows: pd.DataFrame, **told: Any) -> None:
        """Offer the questions that rows can answer, and what heads of answers tell of them."""
        self.rows, self.told = rows, told
        damaged = rows.get("predamage", NO_PREDAMAGE) != NO_PREDAMAGE
        answers: dict[type[Question], object] = {
            LoadSlipQuestion: "load_kN" in rows,
            ResidualQuestion: np.any(damaged),
            StrengthQuestion: "load_kN" not in rows and not np.all(damaged),
        }
        options = {WORDS["questions"][kind.name]: kind for kind, can in answers.items() if can}
        before, first = self.question.value, next(iter(options.values()))
        self.question.param.update(options=options, value=first)
        if before is first:
            self.offer()

    def offer(self) -> None:
        """Offer the options of the question, and answer it with their usual values."""
        self.drawn, self.marks = {}, {}
        self.options[:] = [
            _chosen(WORDS["options"][each.name], list(words), each.default, each.name)
            for each in fields(self.question.value)
            if each.name in WORDS["options"]
            and (words := getattr(each.metadata["rule"], "words", WORDS["confidences"]))
        ]
        for widget in self.options:
            widget.param.watch(lambda _: self.fit(self.marks), "value")
        self._go("question")
        self.fit({})

    def fit(self, marks: dict[str, str]) -> None:
        """Answer the question with tests in the uses (`marks`) that they are given, by name."""
        rows, use = self.rows.copy(), names_of(self.rows).map(marks)
        rows.loc[use == LEFT, "use_for_fit"] = 0.0
        if HELD in marks.values():
            rows["role"] = rows.get("role", "calibrate")
            rows.loc[use == HELD, "role"] = "validate"
        by_hand = (f"{name}: {use} in the picture" for name, use in marks.items())
        told = self.told | {"notes": [*self.told["notes"], *by_hand]}
        how = {"keep_good": bool(self.told["rows_left_out"])}
        question = self.question.value(**{each.tags[0]: each.value for each in self.options})
        self.ask(partial(self._found, marks), answer, question, rows, how, told)

    def _found(self, marks: dict[str, str], answered: Answered) -> None:
        self.marks, self.answered, (_, tables, _, page) = marks, answered, answered
        names = list(dict.fromkeys(tables["fit"]["of"]))
        before, best = self.of.value, tables.get("ranking", tables["fit"])["of"].iloc[0]
        self.of.param.update(options=names, value=before if before in names else best)
        if self.of.value == before:
            self.draw()
        self.page.object = page
        self._go("answer")

    async def save(self, ending: str) -> io.BytesIO:
        """The appendix as a file."""
        try:
            content = await wrap_future(self.desk.ask(appendix, self.answered, ending, lane=LANE))
        except Exception as error:  # a worker may end in any way
            self.say(trouble(error))
            raise
        return io.BytesIO(content)

    # -- the tests in the picture -----------------------------------------------------------------

    def draw(self) -> None:
        """Draw the tests with the band of the answer that is shown."""
        name = self.answered[0]["fit"]
        tests, band = tests_and_band(name, self.answered[1], self.of.value)
        before = self.drawn.get(self.of.value, tests[:0])
        gone = before["test"].map(self.marks).eq(LEFT) & ~before["test"].isin(tests["test"])
        tests = pd.concat([tests, before[gone].assign(use=LEFT)], ignore_index=True)
        self.drawn[self.of.value] = tests
        marker, color = (tests["use"].map(lambda use, k=k: _LOOKS[use][k]) for k in (0, 1))
        self.source = ColumnDataSource(tests.assign(marker=marker, color=color).to_dict("list"))
        self.source.selected.on_change("indices", self._tapped)
        self.picture.object = drawing(self.source, band, *WORDS["axes"][name])
        uses = dict(zip(tests["test"], tests["use"], strict=True))
        labels = {f"{test}, {use}": test for test, use in list(uses.items())[:MOST_LISTED]}
        self.tests.param.update(options=labels, value=[])

    def _select(self) -> None:
        chosen, source = set(self.tests.value), self.source
        indices = [k for k, test in enumerate(source.data["test"]) if test in chosen]
        self._later(lambda: source.selected.update(indices=indices))

    def _tapped(self, attr: str, old: list[int], new: list[int]) -> None:
        names = {self.source.data["test"][place] for place in new}
        if names != set(self.tests.value):
            self.tests.value = [name for name in self.tests.options.values() if name in names]

    def mark(self, use: str) -> None:
        """Give the selected tests a use ("": every test its own again), and answer again."""
        if use and not self.tests.value:
            self.say("Select tests in the picture or in the list first.")
        else:
            self.fit(self.marks | dict.fromkeys(self.tests.value, use) if use else {})


def drawing(source: ColumnDataSource, band: pd.DataFrame, across: str, up: str) -> Any:
    """Picture of tests over the line of a fit with its band, in which they are selected."""
    tools = "tap,box_select,pan,wheel_zoom,reset,hover"
    plot = figure(height=460, **_WIDE, tools=tools, active_drag="box_select")
    line, ends = band.to_dict("list"), band.dropna().to_dict("list")
    plot.varea("x", "low", "high", source=ends, alpha=0.2, legend_label="band")
    plot.line("x", "y", source=line, line_width=2, legend_label="fit")
    looks = {"marker": "marker", "color": "color", "size": 9, "legend_group": "use"}
    plot.hover.renderers = [plot.scatter("x", "y", source=source, **looks)]
    plot.hover.tooltips = [("test", "@test"), ("use", "@use")]
    plot.xaxis.axis_label, plot.yaxis.axis_label = across, up
    plot.toolbar.logo, plot.legend.orientation = None, "horizontal"
    plot.add_layout(plot.legend[0], "above")
    return plot


def _choice(name: str, target: str, table: TableSchema) -> pn.FlexBox:
    """Choices for a column of a file: what it is in the schema, and the unit of its numbers."""
    known = {"leave it out": "", **{f"{c.name}: {c.meaning}"[:80]: c.name for c in table.columns}}
    known |= {} if target in known.values() else {"a column of your own": target}
    column = _chosen(name, known, target)
    unit = _chosen(f"Unit of {name}", [OPEN], OPEN)

    def offer(*_: Any) -> None:
        column.label = name if column.value else f"{name} (not matched)"
        own = table.column(column.value).unit if column.value in table.names else ""
        units = next((each for each in UNITS.values() if own in each), {})
        unit.param.update(options=[OPEN, *units], value=OPEN, visible=bool(units))

    column.param.watch(offer, "value")
    offer()
    return pn.FlexBox(column, unit)


def _chosen(label: str, options: Any, value: Any, *tags: str) -> Any:
    return pn.widgets.Select(label=label, options=options, value=value, tags=list(tags))


def _text(html: str, **look: Any) -> Any:
    return pn.pane.HTML(html, stylesheets=_LOOK, **_WIDE, **look)


def _button(label: str, act: Callable[..., None], *values: Any) -> Any:
    return pn.widgets.Button(label=label, on_click=lambda _: act(*values))


def _saved(file: str, label: str, make: Callable[..., Any], *values: Any) -> pn.Row:
    """A button that saves a file; that of Panel does not hear the keyboard."""
    source = partial(make, *values)
    hidden = pn.widgets.FileDownload(filename=file, label=label, callback=source, visible=False)
    button = pn.widgets.Button(label=label)
    button.js_on_click({"hidden": hidden}, "hidden.clicks += 1")
    return pn.Row(button, hidden)
