"""The first page: how far each model can be trusted, where, and at what cost."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial
from math import ceil

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
from workbench.report.chapters.subject import in_labels, measured_at, subject
from workbench.report.chapters.wording import FAIR, Row, ends, sentence, up
from workbench.report.stored import BEST, CellState, Stored
from workbench.responses import Finding
from workbench.study.definition import Study

GOOD = 0.05  # bound of what may be relied on
_DECISIVE = ("peaks", "domain-map", "sweep")  # kinds that show models over cases
_REASONS = 4  # why models are outside their domain, the most frequent
_CAPTION = (
    "How far each model is off: bias of the peak displacement over the cases of a group with its "
    "95 % interval (of one case: its error with its numerical uncertainty){residual}{statics}, "
    "against the best reference that is inside its own domain. Colours judge the peak. Good: the "
    "whole interval lies within 5 %; doubtful: within 10 %, or the reference is outside its domain "
    "or of unknown uncertainty; bad: beyond, by a reference inside its domain. Hatched: the model "
    "itself warns that it is outside its domain.{time}"
)
_TIMED = " Time: the median of the cases, rounded to 1, 2, 5."
_UNTIMED = " Times are not given: every call may hold compilation."
_JUDGED = (PEAK, RESIDUAL, "time_of_peak")
_OTHERS = 6  # quantities besides those of the matrix that are told


def answer(study: Study, stored: Stored, pictures: Iterable[Picture]) -> Section:
    """The question, the matrix, `pictures`, what places models outside their domain, budgets."""
    shown = [replace(each, caption=f"{each.title}. {each.caption}") for each in pictures]
    found = list(matrix(study, stored))
    found[1:1] = _budgeted(study, stored)  # beside what the references say
    after = next((i for i, block in enumerate(found) if isinstance(block, Table)), -1) + 1
    title = "The answer" if found or shown else "What was asked"
    said = [Paragraph(study.question), *subject(study), *measured.made(stored)]
    said += measured.footnote(study, stored)
    return Section("answer", title, (*said, *found[:after], *shown, *found[after:]))


def decisive(study: Study) -> str:
    """Key of the figure of the first page; empty if none shows models over cases."""
    kinds = (figure.key for figure in study.figures if figure.kind in _DECISIVE)
    return study.decisive or next(kinds, "")


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
    yield from ranking.tree(stored) or [Bullets(tuple(_trusted(study, stored, g) for g in groups))]
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


def _judged(row: Row) -> str:
    """What the numbers of a row are of, in words."""
    return "peak" if row["quantity"] == PEAK else title_of(row["quantity"]).lower()


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
    ranked = [(study.groups.get(group, every), _ranked(study, stored, group)) for group in groups]
    taken = {case: labels[0] for cases, labels in ranked if labels for case in cases}
    return budgets(stored, taken)


def _group(stored: Stored, group: str) -> dict[str, Row]:
    return {row["label"]: row for row in stored.rows["matrix"] if row["group"] == group}


def _ranked(study: Study, stored: Stored, group: str) -> list[str]:
    """The models that stay within `FAIR` in every case of a group, the one to take first."""
    own = _group(stored, group)
    found = {
        label: row[f"{PEAK}_within"]
        for label, row in own.items()
        if label not in study.ranked
        and row[f"{PEAK}_count"]
        and row[f"{PEAK}_count"] + row["collapsed"] == row["asked"]
        and row[f"{PEAK}_within"] is not None
        and row[f"{PEAK}_within"] <= FAIR
        and not any(row[name] for name in ("outside", "against_outside", "falls", "stands"))
        and not row["synthetic"]
    }
    costs = stored.costs

    def place(label: str) -> tuple[float, ...]:
        """Whole percents; the rest is told apart by what remains, then by the time."""
        shares = found[label], own[label][f"{RESIDUAL}_within"] or 0.0
        return *(ceil(100.0 * share) for share in shares), costs.get(label, 1.0)

    return sorted(found, key=place)


def _trusted(study: Study, stored: Stored, group: str) -> str:
    """The model to take in a group of cases, and all that stay within `FAIR` in every case."""
    own, ranked, costs = _group(stored, group), _ranked(study, stored, group), stored.costs
    judged = [row for row in own.values() if row[f"{PEAK}_count"]]
    if judged and all(row["against_outside"] == row[f"{PEAK}_count"] for row in judged):
        return f"{group}: nobody knows, as no reference is inside its domain."
    if any(row["synthetic"] for row in own.values()):
        return f"{group}: synthetic, shows the form only; no model is judged."
    if not ranked:
        return f"{group}: {ranking.advice(stored, group, up(FAIR))}"
    first, *others = ranked
    within = {label: up(own[label][f"{PEAK}_within"]) for label in ranked}
    asked, remains = own[first]["asked"], own[first][f"{RESIDUAL}_within"]
    cases = "the case" if asked == 1 else f"all {asked} cases"
    left = "" if remains is None else f", residual within {up(remains)}"
    spent = f", {part(costs[first])} of the time" if first in costs else ""
    of = own[first]["against"] or "the reference"
    what = _judged(own[first])
    text = f"{group}: {first}, {what} within {within[first]} of {of}{left} in {cases}{spent}"
    if others:
        names = several([f"{label} ({within[label]})" for label in others], 8)
        text += f". {what.capitalize()} within {up(FAIR)} as well, inside their domain: {names}"
    return f"{text}.{measured_at(study, group)}"


def _title(stored: Stored, group: str) -> str:
    rows = [row for row in stored.rows["matrix"] if row["group"] == group]
    against = rows[0]["against"]
    if rows[0]["quantity"] != PEAK:
        group += f": {_judged(rows[0])}"
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
    text = percent(bias - 1.0, rough=True)
    if low is None:
        return f"{text} (interval unknown)"
    ends = (percent(end - 1.0, rough=True).removesuffix("\u2009%") for end in (low, high))
    return f"{text} ({' to '.join(ends)})"


def _tone(row: Row) -> str:
    """Good needs a known uncertainty and a reference inside its domain, bad one that is anywhere.

    Nothing is worse than to survive or to collapse where the reference does not.
    """
    ends = row[f"{PEAK}_low"], row[f"{PEAK}_high"]
    known = [abs(end - 1.0) for end in ends if end is not None]
    far = max(known, default=abs(row[f"{PEAK}_bias"] - 1.0))
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
