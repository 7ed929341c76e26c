"""Test over prediction against every variable of a formula.

Options: `cases` (the first case with an answer of the first label counts).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, MaxNLocator

from workbench.report.figures.drawing import Drawing, Request, joined, nothing, rows
from workbench.report.figures.panels import panel_grid
from workbench.report.figures.studs import KILO, campaign_looks, column, contents, handle, points
from workbench.report.figures.style import INK, MUTED, legend_below

# variable of the rows: axis label, factor from SI
VARIABLES = {
    "diameter": ("diameter d (mm)", 1e3),
    "slenderness": ("height over diameter h/d", 1.0),
    "concrete_strength": ("concrete strength f_c (MPa)", 1e-6),
    "concrete_modulus": ("concrete modulus E_c (GPa)", 1e-9),
    "ultimate_strength": ("stud strength f_u (MPa)", 1e-6),
    "over_steel": ("test over A_s f_u", 1.0),
}
_FEW = 4  # values of a variable below which a trend cannot be told


def draw(request: Request) -> Drawing:
    """One panel per variable, the ratio on a logarithmic scale."""
    formulas = (
        each
        for each in contents(request, "tests")
        if each[2]["tests"] and "ratio" in each[2]["tests"][0]
    )
    found = next(formulas, None)
    if found is None:
        return nothing("No formula of shear strength has answered these cases.")
    case, label, content = found
    tests = content["tests"]
    looks = campaign_looks(test["campaign"] for test in tests)
    canvas, axes = panel_grid(len(VARIABLES), height=2.0)
    blocks: list[Any] = []
    poor = []
    for i, (panel, (name, (title, factor))) in enumerate(zip(axes, VARIABLES.items(), strict=True)):
        x, ratio = factor * column(tests, name), column(tests, "ratio")
        for campaign, look in looks.items():
            own = np.array([test["campaign"] == campaign for test in tests])
            panel.plot(x[own], ratio[own], **points(**look))
        _axes(panel, ratio)
        panel.set_xlabel(title)
        if i % 3 == 0:
            panel.set_ylabel("test over prediction")
        if len(np.unique(x[np.isfinite(x)])) < _FEW:
            poor.append(title.partition(" (")[0])
        block = {"variable": name, "value_SI": x / factor, "test_over_prediction": ratio}
        block |= {"campaign": [t["campaign"] for t in tests]}
        block |= {"specimen": [t["specimen"] for t in tests]}
        blocks.append(rows(block, len(tests)))
    handles = [handle(name, **points(**look)) for name, look in looks.items()]
    legend_below(canvas, handles)
    statements = [f"{label}, case {case.name}: {len(tests)} tests."]
    if poor:
        statements.append(
            f"Too few different values to tell a trend: {', '.join(poor)}. What differs there is "
            "the campaign."
        )
    largest = float(np.nanmax(column(tests, "test"))) * KILO
    statements.append(f"The strongest test bore {largest:.0f} kN per stud.")
    alt = f"test over prediction of {label} against {', '.join(VARIABLES)}"
    return Drawing(canvas, joined(blocks), tuple(statements), alt)


def _axes(panel: Axes, ratio: Any) -> None:
    panel.set_yscale("log")
    low, high = min(0.95 * np.nanmin(ratio), 0.9), max(1.05 * np.nanmax(ratio), 1.1)
    panel.set_ylim(low, high)
    ticks = [t for t in (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.4, 1.6, 2.0) if low <= t <= high]
    panel.set_yticks(ticks)
    panel.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    panel.minorticks_off()
    panel.xaxis.set_major_locator(MaxNLocator(5))
    panel.axhline(1.0, color=INK, linewidth=0.9, zorder=1)
    panel.margins(x=0.12)
    panel.tick_params(colors=MUTED)
