"""Where each model stays within bounds: a point per case, coloured by the class of its error.

Options: `x`, a case parameter with numbers; `over`, a case parameter by which the value of
`against` is divided for the other axis, called `y`; `quantity`, `against`, `bounds` (two relative
errors, default 0.05 and 0.10).
"""

from typing import Any

import numpy as np
import pandas as pd

from workbench.report.drawing.sheet import Drawing, Request, Sheet, first
from workbench.report.drawing.style import INK, Look, entry, logarithmic

_MOST_MODELS = 9
_WITHIN, _NEAR, _TOO_SMALL, _TOO_LARGE = "#009e73", "#e69f00", "#0072b2", "#d55e00"
_COLLAPSE = "#6a3d9a"


def draw(request: Request) -> Drawing:
    """A panel per model; both axes are logarithmic."""
    x, y = str(request.option("x", "")), str(request.option("y", "relative displacement"))
    near, far = request.option("bounds", (0.05, 0.10))
    left: list[str] = []
    labels = [label for label in request.labels if label != request.against]
    labels = first(labels, _MOST_MODELS, "models", left)
    sheet = Sheet.grid(len(labels), left, height=2.0, sharex=True)
    errors = request.errors(request.quantity)
    classes = {
        f"within {100 * near:g} %": Look(_WITHIN, size=3.4),
        f"within {100 * far:g} %": Look(_NEAR, marker="s", size=3.2),
        f"more than {100 * far:g} % too large": Look(_TOO_LARGE, marker="^", size=3.6),
        f"more than {100 * far:g} % too small": Look(_TOO_SMALL, marker="v", size=3.6),
        "collapse": Look(_COLLAPSE, marker="D", size=3.2),
    }
    names = list(classes)
    for panel, label in zip(sheet.panels, labels, strict=True):
        table = _table(request, label, errors, x)
        error = table["error"]
        found = [error.abs() <= near, error.abs() <= far, error > far, error < -far]
        table["class"] = np.select([*found, table["collapsed"]], names, default="no answer")
        for (name, warned), part in table.groupby(["class", "warned"]):
            look = classes.get(str(name), Look(INK, marker="x", size=3.4))
            face = {"markerfacecolor": "none"} if warned else {}
            panel.plot(part["x"], part["y"], **look.points(markeredgewidth=0.8, **face))
        panel.set_xscale("log")
        panel.set_yscale("log")
        answered = table[error.notna()]
        inside = int((answered["error"].abs() <= far).sum())
        silent = answered[(answered["error"].abs() > far) & ~answered["warned"]]
        if len(table):
            sheet.record(table.assign(model=label))
        title = f"{label}\n{inside} of {len(table)} within {100 * far:g} %"
        sheet.name(panel, title, x, y)
        if len(silent):
            text = f"{label}: {len(silent)} errors beyond {100 * far:g} % carry no warning."
            sheet.said.append(text)
    for panel in sheet.panels:  # once all points are in: the panels share their axes
        for axis in (panel.xaxis, panel.yaxis):
            logarithmic(axis, "{:g}".format)
    fallen = sum(request.stored.collapses(case.name, request.against) for case in request.cases)
    if fallen:
        text = f"{request.against} collapses in {fallen} cases, which have no place in this map."
        sheet.said.append(text)
    for name, look in classes.items():
        sheet.legend(entry(name, **look.points(markeredgewidth=0.8)))
    sheet.legend(entry("no answer", **Look(INK, marker="x", size=3.4).points()))
    open_point = Look(INK, size=3.4).points(markerfacecolor="none", markeredgewidth=0.8)
    sheet.legend(entry("open: with a warning", **open_point))
    empty = f"No case has an answer of {request.against} and the parameter {x}."
    return sheet.finish(f"classes of error over {x} and {y}, a panel per model", empty=empty)


def _table(
    request: Request, label: str, errors: dict[tuple[str, str], Any], x: str
) -> pd.DataFrame:
    """A row per case that both sides are asked: place on the map, error, whether it was warned."""
    over = str(request.option("over", ""))
    rows = []
    for case in request.cases:
        value = request.number(case, request.against, request.quantity)
        if value is None or x not in case.parameters:
            continue
        scale = float(case.parameters[over]) if over else 1.0
        row = {"case": case.name, "x": float(case.parameters[x]), "y": value / scale}
        row["error"] = errors.get((case.name, label), {}).get("error")
        cell = request.stored.cells.get((case.name, label))
        row["collapsed"] = request.stored.collapses(case.name, label)
        row["warned"] = cell is not None and bool(cell.outside)
        rows.append(row)
    kinds = {"x": float, "y": float, "error": float, "collapsed": bool, "warned": bool}
    return pd.DataFrame(rows, columns=["case", *kinds]).astype(kinds)
