"""Test over prediction against every variable of a formula.

Options: `cases` (the first case with an answer of the first label counts).
"""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from workbench.report.drawing.sheet import Array, Drawing, Request, Sheet, nothing
from workbench.report.drawing.studs import KILO, campaign_looks, contents, draw_tests, table_of
from workbench.report.drawing.style import INK, MUTED, entry

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
_TICKS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.4, 1.6, 2.0)


def draw(request: Request) -> Drawing:
    """One panel per variable, the ratio on a logarithmic scale."""
    for answered in contents(request, "tests"):
        tests = table_of(answered[2]["tests"])
        if "ratio" in tests:
            break
    else:
        return nothing("No formula of shear strength has answered these cases.")
    case, label, _ = answered
    return plot(f"{label}, case {case.name}", tests)


def plot(label: str, tests: pd.DataFrame) -> Drawing:
    """The tests of a formula, `label`, with their ratios and variables."""
    looks = campaign_looks(tests["campaign"])
    sheet = Sheet.grid(len(VARIABLES), [f"{label}: {len(tests)} tests."], height=2.0)
    poor = []
    for panel, (name, (title, factor)) in zip(sheet.panels, VARIABLES.items(), strict=True):
        shown = tests.assign(value=factor * tests[name])
        draw_tests(panel, shown, "value", "ratio", looks)
        _axes(panel, tests["ratio"].to_numpy(float))
        sheet.name(panel, "", title, "test over prediction")
        panel.set_xlabel(title)
        if shown["value"].nunique() < _FEW:
            poor.append(title.partition(" (")[0])
        ratio = {"value_SI": tests[name], "test_over_prediction": tests["ratio"]}
        sheet.record(variable=name, **ratio, **tests[["campaign", "specimen"]])
    sheet.legend(*(entry(name, **look.points()) for name, look in looks.items()))
    if poor:
        sheet.notes.append(
            f"Too few different values to tell a trend: {', '.join(poor)}."
            + " What differs there is the campaign." * (len(looks) > 1)
        )
    sheet.notes.append(f"The strongest test bore {KILO * tests['test'].max():.0f} kN per stud.")
    return sheet.finish(f"test over prediction of {label} against {', '.join(VARIABLES)}")


def _axes(panel: Axes, ratio: Array) -> None:
    panel.set_yscale("log")
    low, high = min(0.95 * np.nanmin(ratio), 0.9), max(1.05 * np.nanmax(ratio), 1.1)
    panel.set_ylim(low, high)
    panel.set_yticks([tick for tick in _TICKS if low <= tick <= high])
    panel.yaxis.set_major_formatter("{x:g}")
    panel.minorticks_off()
    panel.xaxis.set_major_locator(MaxNLocator(5))
    panel.axhline(1.0, color=INK, linewidth=0.9, zorder=1)
    panel.margins(x=0.12)
    panel.tick_params(colors=MUTED)
