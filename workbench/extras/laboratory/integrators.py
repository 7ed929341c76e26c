"""Which integrator for which problem: a matrix of the work that one percent of error takes."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from workbench.extras.laboratory.scenario import ImpactProblem
from workbench.report.page.formatting import number
from workbench.report.page.markdown import ABSENT, Cell, Markdown, PageColumn, Table
from workbench.report.page.page import Page
from workbench.responses import Response
from workbench.study.assessor import Assessment
from workbench.study.definition import Study

GOOD = 0.01  # error of the places over the largest place
_EXACT, _POOR, _BLOWN = 1e-10, 0.1, 10.0
_CALM, _CHATTER = 0.1, 0.3  # of a lasting contact; a single blow has 1
_IN_SIGHT = 6  # schemes in the table on a screen
_LESS = "≤\u202f"
PAGE = Page(__file__)


class _Entry(NamedTuple):
    """Entry of a scheme on a problem; `work` in evaluations, None if 1 % is not reached.

    `at_once`: it is reached by the coarsest step already.
    """

    work: int | None
    at_once: bool
    error: float
    order: float | None
    missed: int
    spurious: int
    chatter: float


Entries = dict[str, dict[str, _Entry | None]]  # by scheme and problem


def in_short(study: Study, stored: Assessment) -> Markdown:
    """Summary of integrators: the matrix, and what it says; empty without integrators."""
    entries: Entries = {}
    cases = [case for case in study.cases if isinstance(case.scenario, ImpactProblem)]
    for case in cases:
        for label in study.models:
            cell = stored.cells.get((case.name, label))
            response = stored.response(case.name, label)
            if response is not None and "ladder.error" in response:
                entries.setdefault(label, {})[case.name] = _entry(response)
            elif cell is not None and cell.outcome == "not-converged":
                entries.setdefault(label, {})[case.name] = None
    if not any(entry for row in entries.values() for entry in row.values()):
        return Markdown()
    problems = [case.name for case in cases if any(case.name in row for row in entries.values())]
    columns = (
        PageColumn("scheme", width=2.0, of=lambda item: str(item[0])),
        *(PageColumn(name, width=1.0, of=partial(_cell, name)) for name in problems),
    )
    reached = Counter(n for n, row in entries.items() for e in row.values() if e and e.work)
    rows = sorted(entries.items(), key=lambda item: -reached[item[0]])
    most = max(reached.values(), default=0)
    least = Counter(able[0][1] for name in problems if (able := _able(name, entries)))
    return PAGE.blocks(
        "integrators",
        table=replace(Table.of("integrators", "", columns, rows), in_sight=_IN_SIGHT),
        reached=[label for label, _ in rows if most and reached[label] == most],
        most=most,
        least=[f"{label} ({number})" for label, number in least.most_common()],
        problems=problems,
        best=[(name, _best(name, entries)) for name in problems],
        wrong=list(_wrong(entries)),
        chatter=list(_chatter(entries)),
    )


def _entry(response: Response) -> _Entry:
    error, work = (response[f"ladder.{name}"].values for name in ("error", "evaluations"))
    bad = np.flatnonzero(~(error <= GOOD))
    first = int(bad[-1]) + 1 if bad.size else 0

    def scalar(name: str) -> float | None:
        return float(response[name]) if name in response else None

    return _Entry(
        int(work[first]) if first < error.size else None,
        first == 0,
        float(error[-1]),
        scalar("observed_order"),
        int(scalar("missed_impacts") or 0),
        int(scalar("spurious_impacts") or 0),
        scalar("chatter") or 0.0,
    )


def _cell(problem: str, item: tuple[str, dict[str, _Entry | None]]) -> Cell:
    if problem not in item[1]:
        return ABSENT
    entry = item[1][problem]
    if entry is None:
        return Cell("no answer", None, "bad")
    lines = [_words(entry)]
    if entry.error < _POOR:
        if entry.order is not None:
            lines.append(f"p {entry.order:.1f}")
        error = f"{entry.error:.0e}".replace("e-0", "e-")
        lines.append("exact" if entry.order is None and entry.error < _EXACT else error)
    else:
        lines.append(_times(entry.error) if entry.error < _BLOWN else "blows up")
    if entry.missed or entry.spurious:
        lines.append(f"−{entry.missed} +{entry.spurious}")
    tone = "good" if entry.work is not None else "doubt" if entry.error <= _POOR else "bad"
    hatched = bool(entry.missed or entry.spurious)
    return Cell("\n".join(lines), entry.work, tone, hatched, brief=lines[0])


def _words(entry: _Entry) -> str:
    if entry.work is None:
        return "never"
    return f"{_LESS if entry.at_once else ''}{number(entry.work, 2)}"


def _times(error: float) -> str:
    """An error over the largest place, in percent of it or in times."""
    return f"{100.0 * error:.0f}\u202f%" if error < 0.995 else f"{error:.2g} times"


def _able(problem: str, entries: Entries) -> list[tuple[int, str, _Entry]]:
    """Schemes that reach 1 %, those of least work first."""
    able = [(e.work, n, e) for n, row in entries.items() if (e := row.get(problem)) and e.work]
    return sorted(able)


def _best(problem: str, entries: Entries) -> list[str]:
    """The three schemes that need least work."""
    return [f"{name} {_words(entry)}" for _, name, entry in _able(problem, entries)[:3]]


def _wrong(entries: Entries) -> Iterator[tuple[list[str], tuple[str, ...], str]]:
    """Schemes that never converge, by the problems that they get wrong, with the largest error."""
    schemes: dict[tuple[str, ...], list[str]] = {}
    for label, row in entries.items():
        wrong = [n for n, e in row.items() if e is None or (e.work is None and e.error > _POOR)]
        schemes.setdefault(tuple(wrong), []).append(label)
    for problems, labels in schemes.items():
        errors = [e.error for n in labels for p in problems if (e := entries[n][p]) is not None]
        if problems:
            yield labels, problems, _times(max(errors)) if errors else ""


def _chatter(entries: Entries) -> Iterator[tuple[str, float, list[str]]]:
    """Schemes that let the force of a lasting contact chatter where another does not."""
    for name in dict.fromkeys(name for row in entries.values() for name in row):
        chatter = {n: e.chatter for n, row in entries.items() if (e := row.get(name))}
        least = min(chatter.values(), default=0.0)
        loud = {n: c for n, c in chatter.items() if 0.0 < least < _CALM < _CHATTER < c}
        if loud:
            yield name, least, [f"{n} {number(c, 2)}" for n, c in loud.items()]
