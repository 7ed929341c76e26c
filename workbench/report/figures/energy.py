"""Energy over time: the ledger of one impact, one panel per label.

Options: `case` (a name; default the first that has a ledger).
"""

import numpy as np
from matplotlib.patches import Patch

from workbench.content.formatting import axis_label, number, unit_of
from workbench.report.drawing.sheet import Array, Drawing, Request, Sheet, evenly, nothing
from workbench.report.drawing.style import INK, Style, entry
from workbench.responses import Response
from workbench.scenarios import ColumnImpact, FrameImpact

# bottom to top; fixed colours that no label uses as a fill
PARTS = (
    ("dissipated", "dissipated (plastic, algorithmic)", "#8c510a"),
    ("contact_loss", "lost in contact", "#e3b778"),
    ("crushing", "spent on crushing the striker", "#dfc27d"),
    ("elastic", "elastic", "#5ab4ac"),
    ("kinetic", "kinetic", "#c7dfee"),
)
_MOST_POINTS = 400
_BROUGHT: Style = {"color": INK, "linestyle": "--"}


def draw(request: Request) -> Drawing:
    """Stacked energies with the energy that has come in as a line on top."""
    notes: list[str] = []
    needed = {"dissipated", "elastic", "input_energy"}
    case, ledgers = request.first_answered(needed, "an energy ledger", notes)
    if case is None:
        return nothing("No model keeps an energy ledger of these cases.")
    notes.insert(0, f"Case: {case.name}. Energies in J in the data file.")
    sheet = Sheet.grid(len(ledgers), notes)
    unit = unit_of("kinetic").factor
    struck = isinstance(case.scenario, ColumnImpact | FrameImpact)
    stacked: set[str] = set()
    for (label, response), panel in zip(ledgers.items(), sheet.panels, strict=True):
        history = "time" if "time" in response.dims else "step"
        at, parts, brought = ledger(response, history, struck)
        x = at * unit_of(history).factor
        stacked |= set(parts)
        colors = [color for name, _, color in PARTS if name in parts]
        panel.stackplot(x, *(part * unit for part in parts.values()), colors=colors, linewidth=0.0)
        panel.plot(x, brought * unit, **_BROUGHT, linewidth=1.1)
        sheet.name(panel, "", axis_label(history), "energy (kJ)")
        panel.set_title(label, loc="left", pad=13.0)
        error = request.number(case, label, "energy_error")
        if error is not None:
            words = f"largest error {number(error, 2)} of the input"
            above: Style = {"xycoords": "axes fraction", "textcoords": "offset points"}
            text = panel.annotate(words, (0.0, 1.0), (0.0, 3.0), fontsize=6.5, **above)
            text.set_in_layout(False)  # long words would make narrow panels
        panel.margins(x=0.0)
        panel.set_ylim(bottom=min(0.0, panel.get_ylim()[0]))
        sheet.record(case=case.name, label=label, **{history: at}, **parts, brought_in=brought)
    sheet.legend(*(Patch(color=c, label=title) for n, title, c in PARTS[::-1] if n in stacked))
    sheet.legend(entry("brought in so far", **_BROUGHT))
    return sheet.finish(f"energy ledgers of {', '.join(ledgers)} for {case.name}")


def ledger(response: Response, history: str, struck: bool) -> tuple[Array, dict[str, Array], Array]:
    """Times or steps, energies by part in J, and the energy that has come in.

    Arguments: `history`, time or step; `struck`, whether a striker brings energy.
    """
    index = evenly(response.sizes[history], _MOST_POINTS)

    def taken(name: str) -> Array:
        return np.asarray(response[name].values[index], dtype=float)

    at, parts = taken(history), {name: taken(name) for name, _, _ in PARTS if name in response}
    # a striker brings its energy at once, all else does work; what dead loads had stored before
    # is part of every later sum
    work = taken("external_work") if "external_work" in response else 0.0 * at
    energy = float(response["input_energy"]) if struck else 0.0
    stored = float(response["elastic"].values[0]) if history == "time" else 0.0
    return at, parts, energy + work + stored
