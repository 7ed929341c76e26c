"""What the answers cost."""

from collections.abc import Iterable, Iterator
from math import nan
from statistics import median
from typing import NamedTuple

from workbench.content.formatting import count, duration, valued
from workbench.content.tree import Block, Column, Paragraph, Section, Table
from workbench.report.stored import Stored
from workbench.study.definition import Study


class _Times(NamedTuple):
    """Wall times of a label in one kind of scenario, s: whole answers, and solving alone."""

    label: str
    kind: str
    whole: list[float]
    solving: list[float]


_COLUMNS = (
    Column("model", width=2.0, of="label"),
    Column("scenario", width=1.6, of="kind"),
    Column("cases", True, 0.7, lambda times: len(times.whole)),
    Column("fastest", True, 1.0, lambda times: valued(min(times.whole), duration)),
    Column("median", True, 1.0, lambda times: valued(median(times.whole), duration)),
    Column("slowest", True, 1.0, lambda times: valued(max(times.whole), duration)),
    Column("solving alone", True, 1.2, lambda t: valued(median(t.solving or [nan]), duration)),
)


def cost(study: Study, stored: Stored, figures: Iterable[Block]) -> Section:
    """Wall times per model and the figures that set them against errors."""
    rows = list(_times(study, stored))
    caption = (
        "Wall time of one answer on one core, after compilation: the whole response with its "
        "histories, and where the model measures it the median of solving the equations alone."
    )
    text = (
        "Wall times depend on the machine and on what else ran on it: "
        f"{count(len(stored.provenance), 'kind', 'kinds')} of machine and software, listed under "
        "provenance, answered the cells of this report."
    )
    table: Block = Table.of("cost-table", caption, _COLUMNS, rows)
    if not rows:
        table = Paragraph("No model that computes has answered yet.")
    return Section("cost", "Cost", (table, *figures, Paragraph(text)))


def _times(study: Study, stored: Stored) -> Iterator[_Times]:
    times = stored.values("wall_time"), stored.values("solve_time")
    for label, model in study.models.items():
        for kind in dict.fromkeys(case.scenario.KIND for case in study.cases):
            own = [
                (case.name, label)
                for case in study.cases
                if kind == case.scenario.KIND and stored.ok(case.name, label)
            ]
            whole, solving = ([known[key] for key in own if key in known] for known in times)
            if whole and model.name != "published":
                yield _Times(label, kind, whole, solving)
