"""What the figures of studs share: contents of stored answers, tests as tables and as markers."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from workbench.report.drawing.sheet import Request
from workbench.report.drawing.style import INK, MUTED, Look, Style, entry, numbered
from workbench.studs.answers.common import content_of
from workbench.study.definition import Case

KILO, MILLI = 1e-3, 1e3  # N to kN, m to mm
Content = dict[str, Any]
_KINDS = {"model": "prediction", "test": "test", "ratio": "ratio"}
_SIZE = 4.2  # of a test's marker
_EQUAL: Style = {"color": INK, "linewidth": 0.9}
_BOUND: Style = {"color": MUTED, "linewidth": 0.7, "linestyle": ":"}


def contents(request: Request, key: str = "") -> Iterator[tuple[Case, str, Content]]:
    """Every answer of the figure's cases and labels with its content.

    Arguments: `key`, an entry that the content must have (empty: any).
    """
    for case in request.cases:
        for label in request.shown(case):
            response = request.stored.response(case.name, label)
            content = {} if response is None else content_of(response)
            if content and (not key or content.get(key) is not None):
                yield case, label, content


def table_of(rows: Sequence[Content] | Content | None) -> pd.DataFrame:
    """Rows, or columns, of a content as a table: NaN where a number is absent."""
    table = pd.DataFrame(rows or ())
    empty = table.columns[table.isna().all()]
    return table.astype(dict.fromkeys(empty, float))


def judged_tests(label: str, content: Content) -> pd.DataFrame:
    """Fitted tests and, of a model that is judged where it is calibrated elsewhere, `unseen` ones.

    Columns: `label`, campaign, specimen, unseen, `prediction` and `test` (N) and their `ratio`.
    """
    names = {f"strength_{old}": new for old, new in _KINDS.items()}
    tests = table_of(content["tests"]).rename(columns=names).assign(unseen=False)
    if "basis" in content:
        tests = pd.concat([tests, table_of(content["judged"]).assign(unseen=True)])
    columns = ["label", "campaign", "specimen", "unseen", *_KINDS.values()]
    return tests.assign(label=label)[columns]


def measured(request: Request, case: Case, part: str) -> pd.DataFrame:
    """Rows of the tests themselves in a case: part ``calibration`` or ``validation``."""
    response = request.stored.response(case.name, request.study.reference)
    return table_of(None if response is None else content_of(response).get(part))


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
    for (campaign, new), own in tests.groupby(["campaign", unseen], sort=False):
        look = looks[str(campaign)]._replace(filled=True) if new else looks[str(campaign)]
        panel.plot(own[x], own[y], **look.points())


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
