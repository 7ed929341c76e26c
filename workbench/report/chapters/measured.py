"""What measured impacts say of the models, where they are from, and that there are none."""

import json
from collections.abc import Mapping
from typing import Any

from workbench.content.formatting import share, span_cell, title_of, valued
from workbench.content.page import Page
from workbench.content.tree import Block, Cell, Column, Section, Table
from workbench.report.stored import Stored
from workbench.study.definition import Study
from workbench.study.validation import MEASURED

MARK = "SYNTHETIC, no tests: "  # before every caption of a report that shows made numbers
PAGE = Page(__file__)


def synthetic(stored: Stored) -> tuple[Block, ...]:
    """That numbers are made, where they are."""
    return PAGE.blocks("synthetic") if stored.synthetic else ()


def footnote(study: Study, stored: Stored) -> tuple[Block, ...]:
    """That nothing was measured, where a study of impacts has no test."""
    struck = any(hasattr(case.scenario, "striker") for case in study.cases)
    return PAGE.blocks("footnote") if struck and (stored.synthetic or not _measured(study)) else ()


def _measured(study: Study) -> list[str]:
    return [label for label, model in study.models.items() if model.name == MEASURED]


def validation(study: Study, stored: Stored) -> Section | None:
    """Bias, scatter and coverage over tests, and the sources of the tests; None without tests."""
    rows = stored.rows["validation"]
    if not rows:
        return None
    columns = (
        Column("model", width=1.8, of="model"),
        Column("quantity", width=1.5, of=lambda row: title_of(row["quantity"])),
        Column("tests", True, 0.6, lambda row: int(row["tests"])),
        Column("median", True, 0.8, lambda row: valued(row["bias"], 3)),
        Column("95 % interval", True, 1.3, span_cell),
        Column("scatter", True, 0.8, lambda row: share(row["scatter"])),
        Column("measurement", True, 0.9, lambda row: share(row["measurement"])),
        Column("inside", True, 0.9, lambda row: f"{row['covered']:.0f} of {row['counted']:.0f}"),
        Column("of all, 95 %", True, 1.1, _coverage),
        Column("farthest", width=1.3, of="worst"),
    )
    table = Table.of("validation", "", columns, rows)
    return PAGE.section("validation", models=table, sources=_sources(study, stored))


def _coverage(row: Mapping[str, Any]) -> Cell | None:
    low, high = row["coverage_low"], row["coverage_high"]
    return None if low is None else Cell(f"{100.0 * low:.0f} to {100.0 * high:.0f} %", low)


def _sources(study: Study, stored: Stored) -> Table:
    """Where the tests are from, as stored with the answers."""
    datasets: dict[str, dict[str, Any]] = {}
    counts: dict[str, int] = {}
    for case in study.cases:
        for label in _measured(study):
            response = stored.response(case.name, label)
            if response is None:
                continue
            given = json.loads(response.attrs["data"])
            for entry in given["datasets"]:
                datasets[entry["name"]] = entry
                counts[entry["name"]] = counts.get(entry["name"], 0) + len(given["tests"])
    columns = (
        Column("table", width=1.2, of="name"),
        Column("title", width=2.0, of="title"),
        Column("tests", True, 0.5, lambda entry: counts[entry["name"]]),
        Column("role", width=0.8, of="role"),
        Column("source", width=2.2, of="source"),
        Column("licence", width=1.0, of="licence"),
        Column("year", width=0.6, of="year"),
        Column("uncertainty", width=2.0, of="uncertainty"),
    )
    return Table.of("test-sources", "", columns, datasets.values())
