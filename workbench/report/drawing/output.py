"""Figures as files: SVG and PNG that repeat byte for byte, and their numbers as CSV."""

from __future__ import annotations

import io
import re
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure as Canvas

from workbench.report.drawing.style import house_style


def to_svg(canvas: Canvas, key: str) -> str:
    """SVG text of a figure: equal figures give equal text, and ids are unique to `key`.

    Scripts, metadata and outside references are left out, so that it can stand inside HTML.
    """
    buffer = io.StringIO()
    with house_style():
        canvas.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"\s*<!--.*?-->|\s*<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    prefix = re.sub(r"[^A-Za-z0-9]+", "-", key)
    # ids of clips are hashes of coordinates, whose last digit depends on the layout solver
    found = dict.fromkeys(re.findall(r'\bid="([A-Za-z]\w*[0-9a-f]{10})"', text))
    plain = {name: f"item{number}" for number, name in enumerate(found)}
    text = re.sub(r"\b[A-Za-z]\w*[0-9a-f]{10}\b", lambda m: plain.get(m[0], m[0]), text)
    return re.sub(r'(\bid="|xlink:href="#|url\(#)', rf"\g<1>{prefix}-", text)


def save_png(canvas: Canvas, path: Path, resolution: int = 160) -> None:
    """Write a PNG without time stamp or program name."""
    with house_style():
        canvas.savefig(path, format="png", dpi=resolution, metadata={"Software": None})


def to_csv(data: pd.DataFrame) -> str:
    """The numbers of a figure as CSV text with 9 significant digits."""
    return data.to_csv(index=False, float_format="%.9g", lineterminator="\n")
