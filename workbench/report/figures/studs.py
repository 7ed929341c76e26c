"""What the figures of studs share: contents of stored answers, one colour per campaign."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from workbench.report.figures.drawing import Array, Request
from workbench.report.figures.style import PALETTE
from workbench.studs.answers.common import content_of
from workbench.study.definition import Case

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "h")
KILO, MILLI = 1e-3, 1e3  # N to kN, m to mm


def contents(request: Request, key: str = "") -> Iterator[tuple[Case, str, dict[str, Any]]]:
    """Every answer of the figure's cases and labels with its content.

    Arguments: `key`, an entry that the content must have (empty: any).
    """
    for case in request.cases:
        for label in request.shown(case):
            response = request.stored.response(case.name, label)
            content = {} if response is None else content_of(response)
            if content and (not key or content.get(key) is not None):
                yield case, label, content


def reference_rows(request: Request, case: Case, part: str) -> list[dict[str, Any]]:
    """Rows of the tests themselves in a case: part ``calibration`` or ``validation``."""
    response = request.stored.response(case.name, request.study.reference)
    content = {} if response is None else content_of(response)
    return list(content.get(part) or [])


def column(rows: Iterable[dict[str, Any]], name: str) -> Array:
    """A column of rows as numbers, NaN where there is none."""
    return np.array([np.nan if row[name] is None else row[name] for row in rows], float)


def campaign_looks(names: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Colour and marker of every campaign, in the order in which they appear."""
    return {
        name: {"color": PALETTE[i % len(PALETTE)], "marker": MARKERS[i % len(MARKERS)]}
        for i, name in enumerate(dict.fromkeys(names))
    }


def points(color: str, marker: str, *, filled: bool = False, size: float = 4.2) -> dict[str, Any]:
    """Keyword arguments for tests: open markers if they were fitted, filled if they were not."""
    return {
        "color": color, "marker": marker, "markersize": size, "linestyle": "none",
        "markerfacecolor": color if filled else "white", "markeredgecolor": color,
        "markeredgewidth": 1.0, "zorder": 3,
    }  # fmt: skip


def handle(label: str, **style: Any) -> Line2D:
    """A legend entry."""
    return Line2D([], [], label=label, **style)
