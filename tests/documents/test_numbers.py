"""Numbers of README and docs are those of stored results, which `docs/numbers.toml` names."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from functools import cache
from math import radians
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import workbench as wb
from workbench.scenarios import ColumnImpact

ROOT = Path(__file__).parents[2]
STORED = tomllib.loads((ROOT / "docs/numbers.toml").read_text(encoding="utf-8"))
NUMBER = r"([+−-]?[\d.]+)"
CELL = re.compile(rf"1/(?P<part>\d+)|{NUMBER}(?: \({NUMBER}…{NUMBER}\))?")


@cache
def page(name: str) -> str:
    return " ".join((ROOT / name).read_text(encoding="utf-8").split())


def cells_of(path: Path) -> pd.DataFrame:
    """The first table of a page, a row a cell: value and interval, of 1/5000 the 5000."""
    lines = next(part for part in path.read_text("utf-8").split("\n\n") if part[0] == "|")
    head, _, *rows = ([cell.strip() for cell in row.split("|")] for row in lines.splitlines())
    found = []
    for _, model, *cells, _ in rows:
        for column, cell in zip(head[2:], cells, strict=False):
            if match := CELL.search(cell):
                part, *values = (float((n or "nan").replace("−", "-")) for n in match.groups())
                found.append((model, column, np.nanmax([part, values[0]]), *values[1:]))
    return pd.DataFrame(found, columns=["model", "column", "value", "low", "high"])


@cache
def stored(name: str) -> Any:
    """Rows of a stored result with the columns that follow from others; values of named rows."""
    path, columns = ROOT / STORED[name]["file"], STORED[name].get("columns", {})
    table = cells_of(path) if path.suffix == ".md" else pd.read_csv(path, comment="#")
    if isinstance(columns, str):  # those of another result
        return stored(columns)
    for column, formula in columns.items():
        table[column] = eval(formula, {"t": table, "np": np})
    return table.set_index("name").value if "name" in table else table


def errors(table: pd.DataFrame, model: str) -> pd.Series[float]:
    """Error of a model against the truth of every column; 0 where both collapse."""
    peaks = table[model].abs()
    return (peaks / table.truth).where(peaks != table.truth, 1.0).dropna() - 1.0


def share(of: Any) -> str:
    return f"{100.0 * np.nanmean(of):.0f}"


HELPERS = {
    "np": np,
    "errors": errors,
    "share": share,
    "good": lambda table, model: share(errors(table, model).abs() <= 0.1),
    "spaced": lambda number: f"{number:,.0f}".replace(",", " "),
    "signed": lambda ratio: f"{100.0 * ratio:+.0f}" if abs(ratio) > 0.005 else "0",
}


def stale(name: str) -> list[str]:
    """What pages should say, by a stored result, and do not."""
    given, found = STORED[name], []
    each = given.get("each", [""])
    for label in each:
        names = {**HELPERS, "label": label, "key": each[label] if type(each) is dict else label}
        table = names["t"] = stored(name)
        if "rows" in given:
            names["t"] = table[eval(given["rows"], names)]
        for place, texts in given["texts"].items():
            said = [eval(f'f"""{text}"""', names) for text in texts]
            found += [f"{place}: {text}" for text in said if text not in page(place)]
    return found


@pytest.mark.parametrize("name", STORED)
def test_numbers_of_pages_are_those_of_stored_results(name: str) -> None:
    assert not stale(name), "pages are stale: they should say this"


def test_a_stale_number_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    table = stored("fresh")
    monkeypatch.setitem(globals(), "stored", lambda name: table.assign(inside=0.0))
    assert stale("fresh")[0].startswith("README.md: **0 %** of 691 columns")


def test_hits_off_the_web_go_as_far_as_pages_say(thesis_impact: ColumnImpact) -> None:
    strikers = [replace(thesis_impact.striker, angle=radians(a)) for a in (0.0, 5.0, 30.0, 90.0)]
    hits = [replace(thesis_impact, striker=striker) for striker in strikers]
    peaks = [float(wb.simulate(hit, "seven-dof")["peak_displacement"]) for hit in hits]
    few, more, most = (f"{100.0 * (peak / peaks[0] - 1.0):.0f} %" for peak in peaks[1:])
    assert f"**{few}** farther goes the striker that hits this column" in page("README.md")
    assert f"{more} at 30 degrees, {most} along its flanges" in page("README.md")
    assert f"{few} farther 5 degrees off its web, {more} at" in page("docs/theory/seven-dof.md")
