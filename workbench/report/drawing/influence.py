"""How every test moves the answer of a fit."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from workbench.report.drawing.sheet import Drawing, Sheet, grid_shape, nothing
from workbench.report.drawing.style import INK, MUTED, PALETTE, WARNING, Style, entry
from workbench.report.page.formatting import percent

_ROW, _EDGES = 0.17, 0.8  # inches: of a test, and of titles and axes
_HIGHEST = 7.2  # inches: with its caption the figure fits on a page
_LEAST = 0.5  # percent that an axis reaches to either side
_DOTS: Style = {"linestyle": "none", "marker": "o", "markersize": 4.0}
_KINDS = {False: ("as the others expect it", PALETTE[0]), True: ("an outlier", WARNING)}


def plot(tables: Mapping[str, pd.DataFrame]) -> Drawing:
    """Rows of `influence_of` by the titles of their panels, the tests below each other."""
    if not tables:
        return nothing("Too few tests: none can be left out.")
    changes = pd.concat([rows.assign(panel=title) for title, rows in tables.items()])
    names = changes["specimen"]
    if len(set(changes["campaign"])) > 1:
        names = changes["campaign"].str.cat(names, sep=" ")
    changes = changes.assign(
        change=changes["without"].astype(float) / changes["value"] - 1.0, name=names
    )
    size = changes["change"].abs().groupby(changes["name"], sort=False).max()
    rows, columns = grid_shape(len(tables), 2 if len(tables) < 5 else 3)
    most = int((_HIGHEST / rows - _EDGES) / _ROW)
    shown = list(size.nlargest(most).index) if len(size) > most else list(size.index)
    height = rows * (_ROW * len(shown) + _EDGES)
    sheet = Sheet.table(rows, columns, height, count=len(tables), sharey=True)
    if len(shown) < len(size):
        sheet.notes.append(f"Shown are the {len(shown)} of {len(size)} tests that move it most.")
    for panel, title in zip(sheet.panels, tables, strict=True):
        panel_rows = changes[changes["panel"] == title]
        _panel(panel, panel_rows[panel_rows["name"].isin(shown)], shown)
        sheet.name(panel, title, "change without the test (%)", "")
        worst = panel_rows.loc[
            panel_rows["change"].abs().fillna(0.0).to_numpy() == panel_rows["change"].abs().max()
        ]
        if len(worst):
            test, change = worst.iloc[0]["name"], percent(float(worst.iloc[0]["change"]))
            sheet.notes.append(f"{title}: {test} moves it most, by {change} when it is left out.")
    for far in sorted(set(changes["outlier"].astype(bool))):
        words, color = _KINDS[far]
        sheet.legend(entry(words, color=color, **_DOTS))
    sheet.record(changes.drop(columns=["name", "change"]))
    return sheet.finish("change of the answer when a test is left out")


def _panel(panel: Axes, rows: pd.DataFrame, shown: Sequence[str]) -> None:
    places = rows["name"].map({name: place for place, name in enumerate(shown)}).to_numpy(float)
    change = 100.0 * rows["change"].to_numpy(float)
    panel.hlines(places, 0.0, change, color=MUTED, linewidth=0.7)
    for far, (_, color) in _KINDS.items():
        which = rows["outlier"].to_numpy(bool) == far
        panel.plot(change[which], places[which], color=color, **_DOTS)
    panel.axvline(0.0, color=INK, linewidth=0.8)
    panel.set_yticks(range(len(shown)), shown, fontsize=6.5)
    panel.set_ylim(len(shown) - 0.4, -0.6)
    reach = 1.15 * max(float(np.nanmax(np.abs(change), initial=0.0)), _LEAST)
    panel.set_xlim(-reach, reach)
