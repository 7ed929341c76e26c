"""The first page: how far each model can be trusted, where, and at what cost."""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace
from functools import partial
from typing import NamedTuple

from workbench.models.base import model_names
from workbench.report.chapters import choice, configuration, results, verdicts
from workbench.report.chapters.budgets import budgets
from workbench.report.chapters.choice import FAIR, Row
from workbench.report.page.formatting import duration, part, percent, title_of
from workbench.report.page.markdown import (
    Cell,
    Markdown,
    PageColumn,
    Picture,
    Table,
    before_captions,
    literal,
)
from workbench.report.page.page import Page
from workbench.responses import PEAK, RESIDUAL, Finding
from workbench.study.assessor import BEST, Assessment, CellState
from workbench.study.definition import Figure, Study

GOOD = 0.05  # bound of what may be relied on
PAGE = Page(__file__, fair=FAIR, quantity=choice.judged)
_DECISIVE = ("peaks", "domain-map", "sweep")  # kinds that show models over cases
_LAST = ("structure", "convergence", "cost")  # kinds that show no answer
_WIDE = 4.0  # upper end of an interval over the lower one, from which it says nothing
_REASONS = 4  # why models are outside their domain, the most frequent
_IN_SIGHT = 8  # rows of the matrix
_SENTENCES = 5
NOTHING = Markdown()
_JUDGED = (PEAK, RESIDUAL, "time_of_peak")
_OTHERS = 6  # quantities besides those of the matrix whose errors stand on the page
_ENDS = {
    **{"collapsed": "collapsed", "refused": "refused", "failed": "failed", "not_run": "not run"},
    **{"false_alarm": "false alarm", "false_safe": "false safe"},  # on whether it survives
}


class MatrixCell(NamedTuple):
    """Cell of the matrix, a model in a group of cases: statement, ends without a number, details.

    `brief` is the shortest form of a statement with numbers.
    """

    group: str
    statement: str
    ends: str
    details: str
    tone: str
    hatched: bool
    bias: float | None
    brief: str = ""

    @property
    def words(self) -> str:
        """All that the cell says, in one line."""
        return "; ".join(filter(None, (self.statement, self.ends, self.details)))


class MatrixRow(NamedTuple):
    """The cells of a model by group, and its time as a part of that of `time_against`."""

    label: str
    cells: dict[str, MatrixCell]
    time: str


def answer(
    study: Study, stored: Assessment, pictures: Iterable[Picture], more: Markdown = NOTHING
) -> Markdown:
    """The decisive `pictures`, question, answers, matrix; on demand what these rest on.

    `more` is the answer of studies of another kind.
    """
    shown = list(pictures)
    content = literal([matrix(study, stored), more])
    return PAGE.blocks(
        "answer",
        title="The answer" if content else "What was asked",
        question=study.question,
        hit=configuration.subject(study),
        synthetic=results.synthetic(stored),
        footnote=results.footnote(study, stored),
        content=content,
        pictures=[replace(e, caption=f"{e.title}.", statements=(), files=()) for e in shown],
        shown=shown,
    )


def decisive(study: Study, drawn: Collection[str] | None = None) -> str:
    """Key of the figure of the first page, out of those that could be `drawn` (None: all).

    The one that the study names, else the first that shows models over cases, else any; or empty.
    """
    figures = [each for each in study.figures if drawn is None or each.key in drawn]

    def place(figure: Figure) -> tuple[bool, ...]:
        last = figure.kind in _LAST
        return figure.key != study.decisive, last, figure.kind not in _DECISIVE

    return min(figures, key=place).key if figures else ""


def matrix_rows(stored: Assessment) -> list[MatrixRow]:
    """The matrix as data, a row for each model; none for a study whose cases have no peak."""
    times = {row["label"]: _time(row) for row in stored.records("cost")}
    cells: dict[str, dict[str, MatrixCell]] = {}
    for row in stored.records("matrix"):
        cells.setdefault(row["label"], {})[row["group"]] = _cell(row)
    return [MatrixRow(label, by_group, times.get(label, "")) for label, by_group in cells.items()]


def _time(row: Row) -> str:
    """The time of a model as a part of that of the reference, whose own is given in full."""
    return duration(row["seconds"]) if row["label"] == row["against"] else part(row["ratio"])


def time_against(stored: Assessment) -> str:
    """The label whose time is that of which the matrix gives parts; empty without times."""
    return next(iter(stored.tables["cost"]["against"]), "")


def matrix(study: Study, stored: Assessment) -> Markdown:
    """Answers by group and the matrix of models; nothing for a study whose cases have no peak."""
    rows = matrix_rows(stored)
    if not rows:
        return NOTHING
    judged = stored.tables["matrix"]
    groups = {row["group"]: row for row in stored.records("matrix")}
    timed, anchored = time_against(stored), choice.anchored(stored)
    rows = _first_ones(study, rows, choice.named(study, stored, groups))
    columns = (
        PageColumn("model", width=1.4, of="label"),
        *(
            PageColumn(
                PAGE.words("column", group=group, row=row), width=2.1, of=partial(_of, group)
            )
            for group, row in groups.items()
        ),
        *([PageColumn(f"time / {timed}", width=1.1, of=lambda r: r.time or None)] if timed else []),
    )
    labels = {row.label for row in rows}
    sentences = [] if anchored else list(choice.trusted(study, stored, groups))
    return PAGE.blocks(
        "matrix",
        table=replace(Table.of("matrix", "", columns, rows), in_sight=_IN_SIGHT),
        choice=anchored,
        sentences=sentences[:_SENTENCES],
        more=sentences[_SENTENCES:],
        details=[choice.details(study, stored, group, row) for group, row in groups.items()],
        budgets=_budgeted(study, stored, groups),
        commands=list(_commands(study, labels)),
        collapses=any(cell.collapse for cell in stored.cells.values()),
        others=list(_others(study, stored, labels - set(study.ranked))),
        static=(judged["quantity"] != PEAK).any(),
        residual=judged[f"{RESIDUAL}_count"].any(),
        timed=timed,
        reasons=list(_reasons(stored, labels)),
    )


def _first_ones(study: Study, rows: list[MatrixRow], named: Collection[str]) -> list[MatrixRow]:
    """References, models that sentences name, those of the decisive figure; then all others."""
    key = decisive(study)
    drawn = {label for figure in study.figures if figure.key == key for label in figure.models}

    def place(row: MatrixRow) -> tuple[bool, ...]:
        return row.label not in study.ranked, row.label not in named, row.label not in drawn

    return sorted(rows, key=place)


def _commands(study: Study, labels: Collection[str]) -> Iterator[str]:
    """Registered models by name, each with the labels of the study that are not that name."""
    by_name: dict[str, list[str]] = {}
    for label, model in study.models.items():
        if label in labels and label != model.name:
            by_name.setdefault(model.name, []).append(label)
    for name in sorted(by_name.keys() & set(model_names())):
        yield f"{name} ({', '.join(by_name[name])})"


def in_brief(study: Study, stored: Assessment) -> Markdown:
    """The matrix and the verdicts, as they stand on a terminal and in the summary."""
    blocks = literal([results.synthetic(stored), matrix(study, stored), verdicts.in_brief(stored)])
    return before_captions(blocks, results.MARK) if stored.synthetic else blocks


def _others(study: Study, stored: Assessment, labels: set[str]) -> Iterator[tuple[str, list[str]]]:
    """Largest errors beyond `FAIR` in quantities that the matrix does not show."""
    for quantity in [name for name in study.quantities if name not in _JUDGED][:_OTHERS]:
        worst: dict[str, float] = {}
        for (_, label), row in stored.errors(quantity, "relative_error", BEST).items():
            if label in labels and row["error"] is not None:
                worst[label] = max(worst.get(label, 0.0), row["error"], key=abs)
        far = [f"{n} {percent(e, rough=True)}" for n, e in worst.items() if abs(e) > FAIR]
        if far:
            yield title_of(quantity), far


def _budgeted(study: Study, stored: Assessment, groups: Iterable[str]) -> Markdown:
    """The total uncertainty of the answer by the model that is to be taken in its group."""
    every = [case.name for case in study.cases]
    by_case: dict[str, str] = {}
    for group in groups:
        if label := choice.first(study, stored, group):
            by_case |= dict.fromkeys(study.groups.get(group, every), label)
    return budgets(stored, by_case)


def _of(group: str, row: MatrixRow) -> Cell | None:
    """The cell of a row of the table."""
    cell = row.cells.get(group)
    if cell is None:
        return None
    text = ", ".join(filter(None, (cell.statement, cell.ends)))
    brief = ", ".join(filter(None, (cell.brief, cell.ends))) if cell.brief else ""
    return Cell(text, cell.bias, cell.tone, cell.hatched, cell.details, brief)


def _cell(row: Row) -> MatrixCell:
    """Cell of a model in a group of cases, from its row in the stored table."""
    tone, details, brief = "muted", [], ""
    if row[f"{PEAK}_count"]:
        statement, brief = _bias(row, PEAK), _bias(row, PEAK, "brief")
        tone = "muted" if row["synthetic"] else _tone(row)
        if row[f"{RESIDUAL}_count"]:
            details.append(f"residual displacement {_bias(row, RESIDUAL)}")
    elif row["reference"]:
        statement = PAGE.words("reference", known=row["known"])
        brief = statement.removesuffix("\u2009%")
    else:
        silent = "not compared" if row["answered"] else "no answer"
        statement = "collapses" if row["collapsed"] else silent
        tone = "bad" if row["failed"] or row["false_alarm"] or row["false_safe"] else "muted"
    ends = [f"{row[name]} {text}" for name, text in _ENDS.items() if row[name]]
    ends += ["synthetic"] * bool(row["synthetic"])
    return MatrixCell(
        *(row["group"], statement, ", ".join(ends)),
        "; ".join([*details, PAGE.words("counts", row=row)]),
        *(tone, bool(row["outside"]), row[f"{PEAK}_bias"]),
        brief=brief,
    )


def _bias(row: Row, quantity: str, part: str = "bias") -> str:
    """The bias with its interval or, as `part` brief, the interval alone."""
    bias, low, high = (row[f"{quantity}_{name}"] for name in ("bias", "low", "high"))
    wide = low is None or high > _WIDE * low
    if wide and row[f"{quantity}_count"] == 1:
        low = None
    elif wide:
        low, high = row[f"{quantity}_least"], row[f"{quantity}_most"]
    return PAGE.words(part, bias=bias, low=low, high=high, of_cases=wide)


def _tone(row: Row) -> str:
    """Good needs a known uncertainty and a reference inside its domain, bad one that is anywhere.

    Nothing is worse than to survive or to collapse where the reference does not.
    """
    limits = row[f"{PEAK}_low"], row[f"{PEAK}_high"]
    known = [abs(limit - 1.0) for limit in limits if limit is not None]
    far = max(known, default=abs(row[f"{PEAK}_worst"]))
    sure = row[f"{PEAK}_within"] is not None and not row["against_outside"]
    judged = row["against_outside"] < row[f"{PEAK}_count"]
    if far <= GOOD and sure and not row["false_alarm"] and not row["false_safe"]:
        return "good"
    return "bad" if (far > FAIR and judged) or row["false_alarm"] or row["false_safe"] else "doubt"


def _reasons(stored: Assessment, labels: set[str]) -> Iterator[str]:
    """The most frequent warnings about domains: which models, and the worst example."""
    kinds: dict[tuple[str, str], list[tuple[CellState, Finding]]] = {}
    for cell in stored.cells.values():
        for finding in cell.outside if cell.label in labels else ():
            # without a number the sentence is the same everywhere, but may be another model's
            fixed = finding.text if finding.number is None else ""
            kinds.setdefault((finding.subject, fixed), []).append((cell, finding))
    for alike in sorted(kinds.values(), key=len, reverse=True)[:_REASONS]:
        worst = max((finding for _, finding in alike), key=lambda f: abs(f.number or 0.0))
        yield PAGE.words(
            "warning",
            models=list(dict.fromkeys(cell.label for cell, _ in alike)),
            cases=len({cell.case for cell, _ in alike}),
            finding=in_labels(stored.study, worst),
        )


def in_labels(study: Study, finding: Finding) -> Finding:
    """A finding whose remedy names models by the labels of the study too."""
    if not finding.instead:
        return finding
    labels: dict[str, str] = {}
    for label, model in study.models.items():
        labels.setdefault(model.name, label)
    named = [
        name if labels.get(name, name) == name else f"{name} ({labels[name]})"
        for name in finding.instead
    ]
    return finding.taking(named)
