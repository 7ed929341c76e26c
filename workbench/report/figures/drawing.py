"""What a figure is made from and what comes out of it."""

from __future__ import annotations

import io
import itertools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure as Canvas
from numpy.typing import NDArray

from workbench.report.figures.style import Look, house_style
from workbench.report.stored import Stored
from workbench.study.definition import Case, Figure, Study

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Request:
    """What to draw: a `figure` of a `study` from `stored` results.

    `cases` are those that name the figure (or all), `labels` those that it shows, `looks` the
    look of every label.
    """

    study: Study
    figure: Figure
    stored: Stored
    cases: tuple[Case, ...]
    labels: tuple[str, ...]
    looks: Mapping[str, Look]

    def option(self, name: str, default: Any) -> Any:
        """A drawing option of the figure."""
        return self.figure.options.get(name, default)

    def shown(self, case: Case) -> list[str]:
        """The labels that are to answer a case, in order."""
        return [label for label in self.labels if self.stored.expects(case.name, label)]


@dataclass(frozen=True)
class Drawing:
    """A drawn figure: `canvas` (None if there was nothing to draw), the numbers in it, its text.

    `data` is a long table of everything drawn; `statements` say what is absent and why; `alt`
    describes the picture in words; `width` is its share of the text width; `moving` is HTML that a
    screen shows instead of the canvas (empty: the canvas).
    """

    canvas: Canvas | None
    data: pd.DataFrame
    statements: tuple[str, ...] = ()
    alt: str = ""
    width: float = 1.0
    moving: str = ""


class Absences:
    """What a figure cannot show: no answer, or an answer without what the figure needs."""

    def __init__(self) -> None:
        self._unanswered: dict[str, list[str]] = {}
        self._silent: dict[str, list[str]] = {}

    def no_answer(self, label: str, case: str) -> None:
        """A label gave no answer to a case."""
        self._unanswered.setdefault(label, []).append(case)

    def without(self, what: str, label: str) -> None:
        """A label answers, but does not know something."""
        known = self._silent.setdefault(what, [])
        if label not in known:
            known.append(label)

    def sentences(self) -> list[str]:
        """One sentence per kind of absence."""
        found = [
            f"No answer from {label}: {', '.join(cases)}."
            for label, cases in self._unanswered.items()
        ]
        found += [f"Without {what}: {', '.join(labels)}." for what, labels in self._silent.items()]
        return found


def nothing(*statements: str) -> Drawing:
    """A drawing that only says why nothing could be drawn."""
    return Drawing(None, pd.DataFrame(), statements or ("There is nothing to draw.",))


def to_svg(canvas: Canvas, key: str) -> str:
    """SVG text of a figure: equal figures give equal text, and ids are unique to `key`.

    Scripts, metadata and outside references are left out, so that it can stand inside HTML.
    """
    buffer = io.StringIO()
    with house_style():
        canvas.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"\s*<!--.*?-->", "", text, flags=re.DOTALL)
    text = re.sub(r"\s*<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    prefix = re.sub(r"[^A-Za-z0-9]+", "-", key)
    # ids of clips are hashes of coordinates, whose last digit depends on the layout solver
    found = dict.fromkeys(re.findall(r'\bid="([A-Za-z]\w*[0-9a-f]{10})"', text))
    plain = {name: f"item{number}" for number, name in enumerate(found)}
    text = re.sub(r"\b[A-Za-z]\w*[0-9a-f]{10}\b", lambda m: plain.get(m[0], m[0]), text)
    text = re.sub(r'\bid="([^"]+)"', rf'id="{prefix}-\1"', text)
    text = re.sub(r'xlink:href="#([^"]+)"', rf'xlink:href="#{prefix}-\1"', text)
    return re.sub(r"url\(#([^)]+)\)", rf"url(#{prefix}-\1)", text)


def save_png(canvas: Canvas, path: Path, resolution: int = 160) -> None:
    """Write a PNG without time stamp or program name."""
    with house_style():
        canvas.savefig(path, format="png", dpi=resolution, metadata={"Software": None})


def to_csv(data: pd.DataFrame) -> str:
    """The numbers of a figure as CSV text with 9 significant digits."""
    return data.to_csv(index=False, float_format="%.9g", lineterminator="\n")


def thinned(x: Array, y: Array, most: int = 700) -> tuple[Array, Array]:
    """Fewer points of a curve for drawing; extremes of x and y within each bucket are kept.

    The order of the points stays, so that loops stay loops.
    """
    if len(x) <= most:
        return x, y
    edges = np.linspace(0, len(x), most // 2 + 1).astype(int)
    keep = {0, len(x) - 1}
    turns = bool(np.any(np.diff(x) < 0.0))
    for low, high in itertools.pairwise(edges):
        for values in (y, x) if turns else (y,):
            keep.add(low + int(np.argmin(values[low:high])))
            keep.add(low + int(np.argmax(values[low:high])))
    index = np.array(sorted(keep))
    return x[index], y[index]


def rows(columns: Mapping[str, Any], size: int) -> pd.DataFrame:
    """A block of a long table; single values are repeated."""
    return pd.DataFrame(
        {name: value if np.ndim(value) else [value] * size for name, value in columns.items()}
    )


def joined(blocks: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """All blocks below each other."""
    return pd.concat(blocks, ignore_index=True) if blocks else pd.DataFrame()
