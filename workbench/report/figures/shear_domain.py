"""Where shear-free models end: ratio of final forces against the shear force over V_pl.

Options: `against` (the shear-free label, default the reference), `tolerance` (default 0.05),
`group` (case parameter that tells the series of a model apart).
"""

import numpy as np

from workbench.report.drawing.sheet import Array, Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import INK, MUTED, Style

_MARKERS = ("o", "s", "^", "D", "v")


def draw(request: Request) -> Drawing:
    """One series per model and group; the utilisation is that of the shear-free model."""
    against, group = request.against, str(request.option("group", ""))
    tolerance = float(request.option("tolerance", 0.05))
    points: dict[tuple[str, str], list[tuple[float, float, str]]] = {}
    said: list[str] = []
    for case in request.cases:
        free = request.stored.response(case.name, against)
        if free is None or not {"shear_utilisation", "force"} <= set(free.data_vars):
            said.append(f"{case.name}: no force and shear force from {against}.")
            continue
        x = float(free["shear_utilisation"].max())
        for label in request.shown(case):
            if label == against:
                continue
            response = request.stored.response(case.name, label)
            if response is None or "force" not in response:
                said.append(f"{case.name}: no force from {label}.")
                continue
            ratio = float(response["force"][-1]) / float(free["force"][-1])
            series = points.setdefault((label, str(case.parameters.get(group, ""))), [])
            series.append((x, ratio, case.name))
    if not points:
        return nothing(*said)
    sheet, groups = Sheet.table(1, 1, 3.4), list(dict.fromkeys(name for _, name in points))
    panel, sheet.said = sheet.panel, said
    for (label, name), series in points.items():
        xs, ys, cases = map(np.array, zip(*sorted(series), strict=True))
        number, title = groups.index(name), f"{label}, {name}" if name else label
        style: Style = {"color": request.looks[label].color, "markersize": 4.0, "linewidth": 1.1}
        style["marker"] = _MARKERS[number % len(_MARKERS)]
        panel.plot(xs, ys, linestyle="--" if number else "-", label=title, **style)
        head = {"case": cases, "label": label, "group": name}
        sheet.record(**head, shear_over_plastic_shear=xs, force_ratio=ys)
        sheet.said.append(f"{title}: {_bound(xs, ys, tolerance)}.")
    panel.axhspan(1.0 - tolerance, 1.0 + tolerance, color=MUTED, alpha=0.18, linewidth=0.0)
    panel.axhline(1.0, color=INK, linewidth=0.6)
    panel.set_xlim(left=0.0)
    sheet.name(panel, "", f"V/Vpl in {against}", f"force over that of {against}")
    sheet.legend(*panel.get_legend_handles_labels()[0])
    return sheet.finish(f"ratio of the final force to that of {against} over its shear force")


def crossing(x: Array, ratio: Array, tolerance: float) -> float | None:
    """First x (rising) at which |ratio - 1| passes the tolerance for good, interpolated.

    Infinite if it stays within, None if it is outside from the first point on.
    """
    error = np.abs(ratio - 1.0)
    inside = np.flatnonzero(error <= tolerance)
    if len(inside) == 0:
        return None
    last = int(inside[-1])
    if last == len(x) - 1:
        return float("inf")
    return float(np.interp(tolerance, error[last : last + 2], x[last : last + 2]))


def _bound(x: Array, ratio: Array, tolerance: float) -> str:
    found = crossing(x, ratio, tolerance)
    percent = f"{100.0 * tolerance:g} %"
    if found is None:
        return f"further off than {percent} at every V/Vpl from {x[0]:.2f} on"
    if np.isinf(found):
        return f"within {percent} up to V/Vpl = {x[-1]:.2f}, the largest that was run"
    return f"beyond V/Vpl = {found:.2f} further off than {percent}"
