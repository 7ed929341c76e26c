"""Figures of studs, common parts: tables of stored answers, tests as tables and as markers."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from workbench.report.drawing.sheet import Request
from workbench.report.drawing.style import INK, MUTED, Look, Style, entry, numbered
from workbench.studs.fit_protocol import Tables

KILO, MILLI = 1e-3, 1e3  # N to kN, m to mm
_SIZE = 4.2  # of a test's marker
_EQUAL: Style = {"color": INK, "linewidth": 0.9}
_BOUND: Style = {"color": MUTED, "linewidth": 0.7, "linestyle": ":"}


Source = Request | Mapping[str, Tables]  # a figure of a study, or the tables of fits by name


def answered(source: Source, key: str, column: str) -> Iterator[tuple[str, str, Tables]]:
    """Every answer with a column in its table `key`: name of its case, label, tables.

    Of a study those of the figure's cases and labels; fits have no case (an empty name).
    """
    for case, label, tables in _answers(source):
        if column in tables.get(key, ()):
            yield case, label, tables


def _answers(source: Source) -> Iterator[tuple[str, str, Tables]]:
    if isinstance(source, Mapping):
        yield from (("", label, tables) for label, tables in source.items())
        return
    for case in source.cases:
        for label in source.shown(case):
            yield case.name, label, source.stored.answer_tables(case.name, label)


def judged_tests(label: str, tables: Tables) -> pd.DataFrame:
    """Fitted tests and those that the fit has not used, `unseen`.

    Columns: `label`, campaign, specimen, unseen, `prediction` and `test` (N) and their `ratio`.
    """
    names = {"strength_model": "prediction", "strength_test": "test", "strength_ratio": "ratio"}
    tests = tables["tests"].rename(columns=names).assign(unseen=False)
    if "judged" in tables:
        tests = pd.concat([tests, tables["judged"].assign(unseen=True)])
    columns = ["label", "campaign", "specimen", "unseen", *names.values()]
    return tests.assign(label=label)[columns]


def campaign_looks(names: Iterable[str], *, filled: bool = False) -> dict[str, Look]:
    """The look of every campaign, in the order in which they appear; markers open or `filled`."""
    looks = {name: numbered(i) for i, name in enumerate(dict.fromkeys(names))}
    return {name: look._replace(filled=filled, size=_SIZE) for name, look in looks.items()}


def draw_tests(panel: Axes, tests: pd.DataFrame, x: str, y: str, looks: Mapping[str, Look]) -> None:
    """Columns of a table of tests against each other, a marker for each campaign.

    Tests are open, or filled where the column `unseen` says so.
    """
    if tests.empty:
        return
    unseen = tests["unseen"] if "unseen" in tests else tests["campaign"].eq("")
    for (campaign, new), rows in tests.groupby(["campaign", unseen], sort=False):
        look = looks[str(campaign)]._replace(filled=True) if new else looks[str(campaign)]
        panel.plot(rows[x], rows[y], **look.points())


def test_entries(looks: Mapping[str, Look], what: str) -> list[Any]:
    """Legend entries of campaigns, such as ``mcgarraugh1971, unseen``."""
    return [entry(f"{name}, {what}", **look.points()) for name, look in looks.items()]


def draw_diagonal(panel: Axes, top: float) -> None:
    """Lines of equal test and prediction and of 20 % to either side, on equal axes up to `top`."""
    line = np.array([0.0, top])
    panel.plot(line, line, **_EQUAL)
    for factor in (0.8, 1.2):
        panel.plot(line, factor * line, **_BOUND)
    panel.set(xlim=(0.0, top), ylim=(0.0, top))
    panel.set_box_aspect(1.0)


def diagonal_entries(equal: str) -> list[Any]:
    """Legend entries of these lines."""
    return [entry(equal, **_EQUAL), entry("± 20 %", **_BOUND)]


def draw_band(panel: Axes, table: pd.DataFrame, x: str, y: str, color: str) -> None:
    """A curve of a table with the band between its columns `low` and `high`, if it has them."""
    panel.plot(table[x], table[y], color=color, linewidth=1.8, zorder=4)
    if "low" in table and table["low"].notna().any():
        band = panel.fill_between(table[x], table["low"], table["high"], color=color, alpha=0.18)
        band.set(linewidth=0.0, zorder=1)


def band_entries(color: str, line: str, band: str) -> list[Any]:
    """Legend entries of a curve and of its band."""
    return [
        entry(line, color=color, linewidth=1.8),
        Patch(color=color, alpha=0.18, linewidth=0.0, label=band),
    ]
