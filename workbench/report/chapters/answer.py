"""The first page: how far each model can be trusted, where, and at what cost."""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace
from functools import partial

from workbench.assessment.budget import PEAK, RESIDUAL
from workbench.content.formatting import duration, part, percent, title_of
from workbench.content.page import Page
from workbench.content.tree import ABSENT, Block, Cell, Column, Picture, Section, Table, marked
from workbench.report.chapters import choice, configuration, results, verdicts
from workbench.report.chapters.budgets import budgets
from workbench.report.chapters.choice import FAIR, Row
from workbench.report.stored import BEST, CellState, Stored
from workbench.responses import Finding
from workbench.study.definition import Figure, Study

GOOD = 0.05  # bound of what may be relied on
PAGE = Page(__file__, fair=FAIR, quantity=choice.judged)
_DECISIVE = ("peaks", "domain-map", "sweep")  # kinds that show models over cases
_LAST = ("structure", "convergence", "cost")  # kinds that show no answer
_WIDE = 4.0  # upper end of an interval over the lower one, from which it says nothing
_REASONS = 4  # why models are outside their domain, the most frequent
_JUDGED = (PEAK, RESIDUAL, "time_of_peak")
_OTHERS = 6  # quantities besides those of the matrix whose errors stand on the page
_ENDS = {"collapsed": "collapsed", "refused": "refused", "failed": "failed", "not_run": "not run"}
_DISAGREE = {
    "false_alarm": "false alarm",
    "false_safe": "false safe",
}  # on whether the structure survives


def answer(
    study: Study, stored: Stored, pictures: Iterable[Picture], more: Iterable[Block] = ()
) -> Section | None:
    """The question, the matrix, `pictures`, what places models outside their domain, budgets.

    `more` is the answer of studies of another kind.
    """
    shown = [replace(each, caption=f"{each.title}. {each.caption}") for each in pictures]
    content, rest = list(matrix(study, stored, shown)), list(more)
    if not content:
        after = next((i for i, b in enumerate(rest, 1) if isinstance(b, Table)), len(rest))
        rest[after:after] = shown
    return PAGE.section(
        "answer",
        title="The answer" if content or rest else "What was asked",
        question=study.question,
        hit=configuration.subject(study),
        synthetic=results.synthetic(stored),
        footnote=results.footnote(study, stored),
        content=[*content, *rest],
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


def matrix(study: Study, stored: Stored, pictures: Iterable[Picture] = ()) -> tuple[Block, ...]:
    """Models by groups of cases; nothing for a study whose cases have no peak."""
    by_label: dict[str, dict[str, Row]] = {}
    by_group: dict[str, dict[str, Row]] = {}
    for row in stored.rows["matrix"]:
        by_label.setdefault(row["label"], {})[row["group"]] = row
        by_group.setdefault(row["group"], {})[row["label"]] = row
    if not by_label:
        return ()
    costs = stored.costs
    times = "".join({f", {row['against']} = 1": None for row in stored.rows["cost"]})
    whole = [row["seconds"] for row in stored.rows["cost"] if row["label"] == row["against"]]
    times += f" ({duration(whole[0], 1)})" if whole else ""
    timed = [Column(f"time{times}", width=0.7, of=lambda item: part(costs.get(item[0])))]
    titles = {
        group: PAGE.words("column", group=group, row=next(iter(rows.values())))
        for group, rows in by_group.items()
    }
    columns = (
        Column("model", width=1.4, of=lambda item: _name(study, item[0])),
        *(Column(title, width=2.1, of=partial(_cell, group)) for group, title in titles.items()),
        *(timed if costs else ()),
    )
    rows = stored.rows["matrix"]
    anchored = choice.anchored(stored)
    return PAGE.blocks(
        "matrix",
        table=Table.of("matrix", "", columns, by_label.items()),
        choice=anchored,
        sentences=[] if anchored else [choice.trusted(study, stored, group) for group in by_group],
        budgets=_budgeted(study, stored, by_group),
        collapses=any(cell.collapse for cell in stored.cells.values()),
        others=list(_others(study, stored, set(by_label) - set(study.ranked))),
        static=any(row["quantity"] != PEAK for row in rows),
        residual=any(row[f"{RESIDUAL}_count"] for row in rows),
        timed=bool(costs),
        pictures=list(pictures),
        reasons=list(_reasons(stored, set(by_label))),
    )


def in_brief(study: Study, stored: Stored) -> tuple[Block, ...]:
    """The matrix and the verdicts, as they stand on a terminal and in the summary."""
    blocks = (*matrix(study, stored), *verdicts.in_brief(stored))
    synthetic = results.synthetic(stored)
    return marked((*synthetic, *blocks), results.MARK) if stored.synthetic else blocks


def _name(study: Study, label: str) -> str:
    if label not in study.ranked:
        return label
    place = f" {study.ranked.index(label) + 1}" if len(study.ranked) > 1 else ""
    return f"{label} (reference{place})"


def _others(study: Study, stored: Stored, labels: set[str]) -> Iterator[tuple[str, list[str]]]:
    """Largest errors beyond `FAIR` in quantities that the matrix does not show."""
    for quantity in [name for name in study.quantities if name not in _JUDGED][:_OTHERS]:
        worst: dict[str, float] = {}
        for (_, label), row in stored.errors(quantity, "relative_error", BEST).items():
            if label in labels and row["error"] is not None:
                worst[label] = max(worst.get(label, 0.0), row["error"], key=abs)
        far = [f"{n} {percent(e, rough=True)}" for n, e in worst.items() if abs(e) > FAIR]
        if far:
            yield title_of(quantity), far


def _budgeted(study: Study, stored: Stored, groups: Iterable[str]) -> tuple[Block, ...]:
    """Total uncertainty of an answer of the model to take in its case."""
    every = tuple(case.name for case in study.cases)
    taken = {group: choice.first(study, stored, group) for group in groups}
    by_case = {
        case: label
        for group, label in taken.items()
        if label
        for case in study.groups.get(group, every)
    }
    return budgets(stored, by_case)


def _cell(group: str, item: tuple[str, dict[str, Row]]) -> Cell:
    """What a model does in a group of cases."""
    row = item[1].get(group)
    if row is None:
        return ABSENT
    lines, tone = [], "muted"
    if row[f"{PEAK}_count"]:
        lines.append(_bias(row, PEAK))
        tone = "muted" if row["synthetic"] else _tone(row)
        if row[f"{RESIDUAL}_count"]:
            lines.append(f"residual {_bias(row, RESIDUAL)}")
    elif row["reference"]:
        lines.append(PAGE.words("reference", known=row["known"]))
    else:
        silent = "not compared" if row["answered"] else "no answer"
        lines.append("collapses" if row["collapsed"] else silent)
        tone = "bad" if row["failed"] or row["false_alarm"] or row["false_safe"] else "muted"
    said, *details = lines
    ended, value = ends(row) + ["synthetic"] * bool(row["synthetic"]), row[f"{PEAK}_bias"]
    details.append(PAGE.words("counts", row=row, ends=[]))
    text = ", ".join([said, *ended])
    return Cell(text, value, tone, hatched=bool(row["outside"]), more="; ".join(details))


def _bias(row: Row, quantity: str) -> str:
    bias, low, high = (row[f"{quantity}_{name}"] for name in ("bias", "low", "high"))
    wide = low is None or high > _WIDE * low
    if wide and row[f"{quantity}_count"] == 1:
        low = None
    elif wide:
        low, high = row[f"{quantity}_least"], row[f"{quantity}_most"]
    return PAGE.words("bias", bias=bias, low=low, high=high, of_cases=wide)


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


def ends(row: Row) -> list[str]:
    """How the cases without a number ended, and where the reference ended otherwise."""
    return [f"{row[name]} {text}" for name, text in (_ENDS | _DISAGREE).items() if row[name]]


def _reasons(stored: Stored, labels: set[str]) -> Iterator[str]:
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
    named = [f"{name} ({labels[name]})" if name in labels else name for name in finding.instead]
    return finding.taking(named)
