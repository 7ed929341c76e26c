"""What measured impacts say of the models, where they are from, and that there are none."""

import json
from typing import Any

from workbench.content.page import Page
from workbench.content.tree import Block, Section
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
    return PAGE.section("validation", rows=rows, sources=_sources(study, stored) if rows else [])


def _sources(study: Study, stored: Stored) -> list[dict[str, Any]]:
    """Where the tests are from, as stored with the answers."""
    datasets: dict[str, dict[str, Any]] = {}
    for case in study.cases:
        for label in _measured(study):
            response = stored.response(case.name, label)
            if response is None:
                continue
            given = json.loads(response.attrs["data"])
            for entry in given["datasets"]:
                known = datasets.setdefault(entry["name"], {**entry, "tests": 0})
                known["tests"] += len(given["tests"])
    return list(datasets.values())
