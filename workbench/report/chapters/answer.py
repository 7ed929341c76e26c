"""The first page: how far each model can be trusted, where, and at what cost."""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace
from functools import partial

from workbench.assessment.budget import PEAK, RESIDUAL
from workbench.content.formatting import count, duration, part, percent, several, title_of
from workbench.content.tree import (
    ABSENT,
    Block,
    Bullets,
    Cell,
    Column,
    Paragraph,
    Picture,
    Section,
    Table,
    marked,
)
from workbench.report.chapters import measured, ranking, verdicts
from workbench.report.chapters.budgets import budgets
from workbench.report.chapters.subject import in_labels, subject
from workbench.report.chapters.taken import first, judged, trusted
from workbench.report.chapters.wording import FAIR, Row, ends, sentence, up
from workbench.report.stored import BEST, CellState, Stored
from workbench.responses import Finding
from workbench.study.definition import Figure, Study

GOOD = 0.05  # bound of what may be relied on
_DECISIVE = ("peaks", "domain-map", "sweep")  # kinds that show models over cases
_LAST = ("structure", "convergence", "cost")  # kinds that show no answer
_WIDE = 4.0  # upper end of an interval over the lower one, from which it says nothing
_REASONS = 4  # why models are outside their domain, the most frequent
_CAPTION = (
    "How far each model is off: bias of the peak displacement over the cases of a group with its "
    "95 % interval (of one case: its error with its numerical uncertainty; of two, and where the "
    "interval would be wider than a factor of four, the ends of the cases){residual}{statics}, "
    "against the best reference that is inside its own domain. Colours judge the peak. Good: the "
    "whole interval lies within 5 %; doubtful: within 10 %, or the reference is outside its domain "
    "or of unknown uncertainty; bad: beyond, by a reference inside its domain. Hatched: the model "
    "itself warns that it is outside its domain.{time}"
)
_TIMED = " Time: the median of the cases, rounded to 1, 2, 5."
_UNTIMED = " Times are not given: every call may hold compilation."
_JUDGED = (PEAK, RESIDUAL, "time_of_peak")
_OTHERS = 6  # quantities besides those of the matrix that are told


def answer(
    study: Study, stored: Stored, pictures: Iterable[Picture], more: Iterable[Block] = ()
) -> Section:
    """The question, the matrix, `pictures`, what places models outside their domain, budgets.

    `more` is the answer of studies of another kind.
    """
    shown = [replace(each, caption=f"{each.title}. {each.caption}") for each in pictures]
    found = list(matrix(study, stored))
    found[1:1] = _budgeted(study, stored)  # beside what the references say
    found += more
    tables = (i for i, block in enumerate(found, 1) if isinstance(block, Table))
    after = next(tables, len(found))
    title = "The answer" if found or shown else "What was asked"
    said = [Paragraph(study.question), *subject(study), *measured.made(stored)]
    said += measured.footnote(study, stored)
    return Section("answer", title, (*said, *found[:after], *shown, *found[after:]))


def decisive(study: Study, drawn: Collection[str] | None = None) -> str:
    """Key of the figure of the first page, out of those that could be `drawn` (None: all).

    The one that the study names, else the first that shows models over cases, else any; or empty.
    """
    figures = [each for each in study.figures if drawn is None or each.key in drawn]

    def place(figure: Figure) -> tuple[bool, ...]:
        last = figure.kind in _LAST
        return figure.key != study.decisive, last, figure.kind not in _DECISIVE

    return min(figures, key=place).key if figures else ""


def matrix(study: Study, stored: Stored) -> Iterator[Block]:
    """Models by groups of cases; nothing for a study whose cases have no peak."""
    by_label: dict[str, dict[str, Row]] = {}
    for row in stored.rows["matrix"]:
        by_label.setdefault(row["label"], {})[row["group"]] = row
    if not by_label:
        return
    groups = dict.fromkeys(row["group"] for row in stored.rows["matrix"])
    costs = stored.costs
    times = "".join({f", {row['against']} = 1": None for row in stored.rows["cost"]})
    whole = [row["seconds"] for row in stored.rows["cost"] if row["label"] == row["against"]]
    times += f" ({duration(whole[0], 1)})" if whole else ""
    timed = [Column(f"time{times}", width=0.7, of=lambda item: part(costs.get(item[0])))]
    remains = any(row[f"{RESIDUAL}_count"] for row in stored.rows["matrix"])
    residual = ", and of the residual displacement" if remains else ""
    statics = ", where cases are static of what their column names" if _static(stored) else ""
    timing = _TIMED if costs else _UNTIMED
    caption = _CAPTION.format(residual=residual, statics=statics, time=timing)
    columns = (
        Column("model", width=1.4, of=lambda item: _name(study, item[0])),
        *(Column(_title(stored, group), width=2.1, of=partial(_cell, group)) for group in groups),
        *(timed if costs else ()),
        Column("in words", width=3.0, of=lambda item: sentence(item[1])),
    )
    yield from ranking.tree(stored) or [Bullets(tuple(trusted(study, stored, g) for g in groups))]
    yield from _besides(study, stored)
    yield Table.of("matrix", caption, columns, by_label.items())
    reasons = tuple(_why(stored, set(by_label)))
    if reasons:
        yield Paragraph("Why models are outside their domain:")
        yield Bullets(reasons)


def in_brief(study: Study, stored: Stored) -> tuple[Block, ...]:
    """The matrix and the verdicts, as they stand on a terminal and in the summary."""
    rows = stored.rows["verdicts"]
    blocks = (*matrix(study, stored), *_budgeted(study, stored), verdicts.headline(rows))
    if rows:
        blocks += (verdicts.summary_table(rows), *verdicts.reasons(rows, bounds=False))
    return marked((*measured.made(stored), *blocks), measured.MARK) if stored.synthetic else blocks


def _name(study: Study, label: str) -> str:
    if label not in study.ranked:
        return label
    place = f" {study.ranked.index(label) + 1}" if len(study.ranked) > 1 else ""
    return f"{label}\nreference{place}"


def _static(stored: Stored) -> bool:
    """Whether groups of static cases are judged by something else than a peak."""
    return any(row["quantity"] != PEAK for row in stored.rows["matrix"])


def _besides(study: Study, stored: Stored) -> Iterator[Block]:
    """Whether anything collapses, and how far models are off in what the matrix does not show."""
    shown = {row["label"] for row in stored.rows["matrix"]} - set(study.ranked)
    if not any(cell.collapse for cell in stored.cells.values()):
        yield Paragraph("No structure collapses, by any model or reference that answered.")
    said = []
    for quantity in [name for name in study.quantities if name not in _JUDGED][:_OTHERS]:
        worst: dict[str, float] = {}
        for (_, label), row in stored.errors(quantity, "relative_error", BEST).items():
            if label in shown and row["error"] is not None:
                worst[label] = max(worst.get(label, 0.0), row["error"], key=abs)
        off = {label: error for label, error in worst.items() if abs(error) > FAIR}
        if off:
            told = [f"{label} {percent(error, rough=True)}" for label, error in off.items()]
            said.append(f"{title_of(quantity)}: {'; '.join(told)}")
    if said:
        text = f"Do not take from these models what is more than {up(FAIR)} off, at worst, from"
        judged = "one quantity of a group" if _static(stored) else "displacements alone"
        yield Paragraph(f"{text} the same references (the matrix judges {judged}):")
        yield Bullets(tuple(said))


def _budgeted(study: Study, stored: Stored) -> Iterator[Block]:
    """What all errors may make of an answer of the model to take in its case."""
    groups = dict.fromkeys(row["group"] for row in stored.rows["matrix"])
    every = tuple(case.name for case in study.cases)
    told = [(study.groups.get(group, every), first(study, stored, group)) for group in groups]
    return budgets(stored, {case: label for cases, label in told if label for case in cases})


def _title(stored: Stored, group: str) -> str:
    rows = [row for row in stored.rows["matrix"] if row["group"] == group]
    against = rows[0]["against"]
    if rows[0]["quantity"] != PEAK:
        group += f": {judged(rows[0])}"
    return f"{group}; against {against}" if against else f"{group}; no reference answered"


def _cell(group: str, item: tuple[str, dict[str, Row]]) -> Cell:
    """What a model does in a group of cases."""
    row = item[1].get(group)
    if row is None:
        return ABSENT
    compared, own = row[f"{PEAK}_count"], row["reference"]
    lines, tone = [], "muted"
    if compared:
        lines.append(_bias(row, PEAK))
        tone = "muted" if row["synthetic"] else _tone(row)
        if row[f"{RESIDUAL}_count"]:
            lines.append(f"residual {_bias(row, RESIDUAL)}")
    elif own:
        known = row["known"]
        within = "" if known is None else f", numerically within {up(known)}"
        lines.append(f"the reference{within}")
    else:
        told = "not compared" if row["answered"] else "no answer"
        lines.append("collapses" if row["collapsed"] else told)
        tone = "bad" if row["failed"] or row["falls"] or row["stands"] else "muted"
    lines.append(", ".join(_counts(row)))
    text = "\n".join(line for line in lines if line)
    return Cell(text, row[f"{PEAK}_bias"], tone, hatched=bool(row["outside"]))


def _bias(row: Row, quantity: str) -> str:
    bias, low, high = (row[f"{quantity}_{name}"] for name in ("bias", "low", "high"))
    text, of = percent(bias - 1.0, rough=True), ""
    if low is None or high > _WIDE * low:
        if row[f"{quantity}_count"] == 1:
            return f"{text} (interval unknown)"
        low, high, of = row[f"{quantity}_least"], row[f"{quantity}_most"], "cases "
    ends = (percent(end - 1.0, rough=True).removesuffix("\u2009%") for end in (low, high))
    return f"{text} ({of}{' to '.join(ends)})"


def _tone(row: Row) -> str:
    """Good needs a known uncertainty and a reference inside its domain, bad one that is anywhere.

    Nothing is worse than to survive or to collapse where the reference does not.
    """
    ends = row[f"{PEAK}_low"], row[f"{PEAK}_high"]
    known = [abs(end - 1.0) for end in ends if end is not None]
    far = max(known, default=abs(row[f"{PEAK}_worst"]))
    sure = row[f"{PEAK}_within"] is not None and not row["against_outside"]
    judged = row["against_outside"] < row[f"{PEAK}_count"]
    if far <= GOOD and sure and not row["falls"] and not row["stands"]:
        return "good"
    return "bad" if (far > FAIR and judged) or row["falls"] or row["stands"] else "doubt"


def _counts(row: Row) -> Iterator[str]:
    """How many cases were asked, how those without an answer ended, what is outside a domain."""
    yield count(row["asked"], "case")
    yield from ends(row)
    if row["outside"]:
        yield f"{_of(row['outside'], row['answered'])}outside its domain"
    if row["synthetic"]:
        yield "synthetic, shows the form only"
    if row["against_outside"]:
        some = _of(row["against_outside"], row[f"{PEAK}_count"])
        yield f"{some}with the reference outside its own"


def _of(some: float, all_of: float) -> str:
    if all_of == 1:
        return ""
    return "all " if some == all_of else f"{some:.0f} "


def _why(stored: Stored, labels: set[str]) -> Iterator[str]:
    """The most frequent warnings about domains: which models, and the worst example."""
    kinds: dict[tuple[str, str], list[tuple[CellState, Finding]]] = {}
    for cell in stored.cells.values():
        if cell.label in labels:
            for finding in cell.outside:
                # without a number the sentence is the same everywhere, but may be another model's
                fixed = finding.text if finding.number is None else ""
                kinds.setdefault((finding.subject, fixed), []).append((cell, finding))
    for told in sorted(kinds.values(), key=len, reverse=True)[:_REASONS]:
        top = max((finding for _, finding in told), key=lambda f: abs(f.number or 0.0))
        names = several(list(dict.fromkeys(cell.label for cell, _ in told)), 8)
        cases = len({cell.case for cell, _ in told})
        yield f"{names} (in {count(cases, 'case')}): {in_labels(stored.study, str(top))}."
