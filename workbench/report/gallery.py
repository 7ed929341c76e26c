"""Drawing all figures of a study and writing them with their numbers.

SVG and PNG repeat byte for byte; numbers are CSV.
"""

import io
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure as Canvas

from workbench.base.errors import InputError
from workbench.report.drawing.frame import frame_scenario_of
from workbench.report.drawing.sheet import Drawing, Request
from workbench.report.drawing.style import house_style, looks
from workbench.report.figures import draw
from workbench.report.page.markdown import Picture
from workbench.study.assessor import Assessment
from workbench.study.definition import Case, Figure, Study
from workbench.study.store import write_atomically
from workbench.study.tables import for_spreadsheets

# Figures that every report has; a study that names one of the kind draws its own instead.
_STANDARD = {
    "structure": (
        "The structure",
        "To scale, with supports, loads and what hits it; the cross section is enlarged.",
    ),
    "convergence": (
        "Refinement of the reference",
        "Values of the reference at each level of its ladder, the value extrapolated to element "
        "size zero, and the interval that the grid convergence index leaves around the finest.",
    ),
    "cost": (
        "Cost against error",
        "Wall time of one case on one core, after compilation, against the magnitude of the "
        "deviation from the reference. Further down is more accurate, further left is cheaper.",
    ),
}

_BUDGETED = "What the errors may make of the answers"
_BUDGET = (
    "Each bar is one source of error by itself; blue bars are sums. A white line shows where a "
    "measured bias moves the answer. Model form, which holds the numerical part, inputs and the "
    "range of D of the rate law of the steel add in quadrature about it."
)


@dataclass(frozen=True)
class Plate:
    """A drawn figure: its definition and its drawing."""

    figure: Figure
    drawing: Drawing

    def picture(self) -> Picture:
        """The figure as it stands on a page."""
        figure, drawing = self.figure, self.drawing
        svg = "" if drawing.canvas is None else to_svg(drawing.canvas, figure.key)
        files = (f"figures/{figure.key}.csv",) if svg else ()
        words = figure.key, figure.title, figure.caption
        return Picture(*words, svg, drawing.alt, drawing.width, drawing.statements, files)


def to_svg(canvas: Canvas, key: str, *, comments: bool = False) -> str:
    """SVG text of a figure: equal figures give equal text, and ids are unique to `key`.

    `comments`: keep those in which the texts stand that are drawn as paths.

    Scripts, metadata and outside references are left out, so that it can stand inside HTML.
    """
    buffer = io.StringIO()
    with house_style():
        canvas.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    unneeded = r"\s*<metadata>.*?</metadata>" + ("" if comments else r"|\s*<!--.*?-->")
    text = re.sub(unneeded, "", text, flags=re.DOTALL)
    prefix = re.sub(r"[^A-Za-z0-9]+", "-", key)
    # ids of clips are hashes of coordinates, whose last digit depends on the layout solver
    hashed = dict.fromkeys(re.findall(r'\bid="([A-Za-z]\w*[0-9a-f]{10})"', text))
    plain = {name: f"item{number}" for number, name in enumerate(hashed)}
    text = re.sub(r"\b[A-Za-z]\w*[0-9a-f]{10}\b", lambda m: plain.get(m[0], m[0]), text)
    return re.sub(r'(\bid="|xlink:href="#|url\(#)', rf"\g<1>{prefix}-", text)


def save_png(canvas: Canvas, path: Path, resolution: int = 160) -> None:
    """Write a PNG without time stamp or program name."""
    buffer = io.BytesIO()
    with house_style():
        canvas.savefig(buffer, format="png", dpi=resolution, metadata={"Software": None})
    write_atomically(path, buffer.getvalue())


def save(canvas: Canvas, path: Path) -> None:
    """Write a picture as PNG, SVG or PDF, by the ending."""
    if path.suffix.lower() == ".svg":
        write_atomically(path, to_svg(canvas, path.stem, comments=True).encode())
    elif path.suffix.lower() == ".png":
        save_png(canvas, path)
    else:
        with house_style():
            canvas.savefig(path)


def to_csv(data: pd.DataFrame) -> str:
    """The numbers of a figure as CSV text with 9 significant digits."""
    return for_spreadsheets(data).to_csv(index=False, float_format="%.9g", lineterminator="\n")


def cases_of(study: Study, figure: Figure) -> tuple[Case, ...]:
    """The cases that a figure shows.

    The option `cases` names them; else those whose `figure` is the option `group` or the key of
    the figure; else all.
    """
    named = figure.options.get("cases", ())
    if named:
        return tuple(case for case in study.cases if case.name in named)
    group = figure.options.get("group", figure.key)
    return tuple(case for case in study.cases if case.figure == group) or study.cases


def figures_of(study: Study) -> tuple[Figure, ...]:
    """The figures of a study, completed by the standard ones it does not have.

    Raises `InputError` for keys that stand twice or are no file names.
    """
    kinds = {figure.kind for figure in study.figures}
    members = any(frame_scenario_of(case.scenario) is not None for case in study.cases)
    wanted = {"structure": members, "convergence": len(study.steps) > 1, "cost": True}
    standard = {
        kind: Figure(kind, kind, *words)
        for kind, words in _STANDARD.items()
        if wanted[kind] and kind not in kinds
    }
    front = [standard.pop("structure")] if "structure" in standard else []
    whole = (*front, *_budgets(study), *study.figures, *standard.values())
    keys = [figure.key for figure in whole]
    for key in keys:
        if keys.count(key) > 1 or not key.replace("-", "").replace("_", "").isalnum():
            raise InputError("figure.key", key, "must be unique letters, digits, - and _")
    return whole


def _budgets(study: Study) -> Iterator[Figure]:
    """A figure for every case whose errors are budgeted."""
    for number, budget in enumerate(study.budgets, 1):
        title, options = f"{_BUDGETED}: {budget.case}", {"case": budget.case}
        yield Figure(f"budget-{number}", "budget", title, _BUDGET, budget.models, options)


def draw_all(study: Study, stored: Assessment) -> tuple[Plate, ...]:
    """Draw every figure of a study. Raises `InputError` for a figure that cannot be."""
    appearance = looks(study)
    plates = []
    for figure in figures_of(study):
        labels = figure.models or tuple(study.models)
        chosen = tuple(label for label in study.models if label in labels)
        request = Request(study, figure, stored, cases_of(study, figure), chosen, appearance)
        plates.append(Plate(figure, draw(request)))
    return tuple(plates)


def save_all(plates: tuple[Plate, ...], target: Path, pictures: Mapping[str, Picture]) -> None:
    """Write ``<key>.svg`` and ``<key>.csv`` of every drawn figure, and a PNG if it asks for one.

    A figure asks for a PNG by the option `png`.
    """
    for plate in plates:
        key, canvas = plate.figure.key, plate.drawing.canvas
        if canvas is None:
            continue
        write_atomically(target / f"{key}.svg", pictures[key].svg.encode())
        write_atomically(target / f"{key}.csv", to_csv(plate.drawing.data).encode())
        if plate.figure.options.get("png"):
            save_png(canvas, target / f"{key}.png")
