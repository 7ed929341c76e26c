"""What the answers cost."""

from __future__ import annotations

import numpy as np

from workbench.content.formatting import count, duration
from workbench.content.tree import Block, Cell, Column, Paragraph, Section, Table
from workbench.report.stored import Stored
from workbench.study.definition import Study


def cost(study: Study, stored: Stored, figures: list[Block]) -> Section:
    """Wall times per model and the figures that set them against errors."""
    rows = []
    kinds = dict.fromkeys(case.scenario.KIND for case in study.cases)
    for label, model in study.models.items():
        if model.name == "published":
            continue
        for kind in kinds:
            cases = [
                case.name
                for case in study.cases
                if kind == case.scenario.KIND and stored.ok(case.name, label)
            ]
            times = _times(stored, cases, label, "wall_time")
            solving = _times(stored, cases, label, "solve_time")
            if not times:
                continue
            middle, low, high = float(np.median(times)), min(times), max(times)
            rows.append(
                (
                    Cell(label),
                    Cell(kind),
                    Cell(str(len(times)), len(times)),
                    Cell(duration(low), low),
                    Cell(duration(middle), middle),
                    Cell(duration(high), high),
                    Cell(duration(float(np.median(solving))), float(np.median(solving)))
                    if solving
                    else Cell("–"),
                )
            )
    blocks: list[Block] = []
    if rows:
        columns = (
            Column("model", width=2.0),
            Column("scenario", width=1.6),
            Column("cases", True, 0.7),
            Column("fastest", True, 1.0),
            Column("median", True, 1.0),
            Column("slowest", True, 1.0),
            Column("solving alone", True, 1.2),
        )
        caption = (
            "Wall time of one answer on one core, after compilation: the whole response with its "
            "histories, and where the model measures it the median of solving the equations alone."
        )
        blocks.append(Table("cost-table", caption, columns, tuple(rows)))
    else:
        blocks.append(Paragraph("No model that computes has answered yet."))
    blocks.extend(figures)
    text = (
        "Wall times depend on the machine and on what else ran on it: "
        f"{count(len(stored.provenance), 'kind', 'kinds')} of machine and software, listed under "
        "provenance, answered the cells of this report."
    )
    blocks.append(Paragraph(text))
    return Section("cost", "Cost", tuple(blocks))


def _times(stored: Stored, cases: list[str], label: str, column: str) -> list[float]:
    found = (stored.number(case, label, column) for case in cases)
    return [seconds for seconds in found if seconds is not None]
