"""Where the energy goes: the ledger of one impact, one panel per label.

Options: `case` (a name; default the first that has a ledger).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from workbench.content.formatting import axis_label, number, unit_of
from workbench.report.figures.drawing import (
    Array,
    Drawing,
    Request,
    joined,
    nothing,
    rows,
)
from workbench.report.figures.panels import first_answered, name_axes, panel_grid
from workbench.report.figures.style import INK, legend_below
from workbench.responses import Response

# bottom to top; fixed colours that no label uses as a fill
PARTS = (
    ("dissipated", "dissipated (plastic, algorithmic)", "#8c510a"),
    ("contact_loss", "lost in contact", "#e3b778"),
    ("elastic", "elastic", "#5ab4ac"),
    ("kinetic", "kinetic", "#c7dfee"),
)
_MOST_POINTS = 400
_MOST_PANELS = 6


def draw(request: Request) -> Drawing:
    """Stacked energies with the energy that has come in as a line on top."""
    case, ledgers, statements = first_answered(
        request, {"dissipated", "elastic", "input_energy"}, "an energy ledger"
    )
    if case is None:
        return nothing("No model keeps an energy ledger of these cases.", *statements)
    if len(ledgers) > _MOST_PANELS:
        statements.append(f"Shown are the first {_MOST_PANELS} of {len(ledgers)} ledgers.")
        ledgers = dict(list(ledgers.items())[:_MOST_PANELS])
    canvas, axes = panel_grid(len(ledgers))
    unit = unit_of("kinetic").factor
    blocks: list[Any] = []
    stacked: set[str] = set()
    for i, ((label, response), panel) in enumerate(zip(ledgers.items(), axes, strict=True)):
        history = "time" if "time" in response.dims else "step"
        struck = case.scenario.KIND.endswith("impact")
        at, parts, brought = _stack(response, history, struck)
        x = at * unit_of(history).factor
        stacked |= set(parts)
        colors = [color for name, _, color in PARTS if name in parts]
        panel.stackplot(x, *(part * unit for part in parts.values()), colors=colors, linewidth=0.0)
        panel.plot(x, brought * unit, color=INK, linestyle="--", linewidth=1.1)
        error = request.stored.number(case.name, label, "energy_error")
        panel.set_title(label, loc="left", pad=13.0)
        if error is not None:
            words = panel.annotate(
                f"largest error {number(error, 2)} of the input",
                *((0.0, 1.0), (0.0, 3.0)),
                xycoords="axes fraction",
                textcoords="offset points",
                fontsize=6.5,
            )
            words.set_in_layout(False)  # long words would make narrow panels
        name_axes(panel, i, len(ledgers), axis_label(history), "energy (kJ)")
        panel.margins(x=0.0)
        panel.set_ylim(bottom=min(0.0, panel.get_ylim()[0]))
        blocks.append(
            rows(
                {"case": case.name, "label": label, history: at, **parts, "brought_in": brought},
                len(at),
            )
        )
    handles: list[Any] = [
        Patch(color=color, label=title) for name, title, color in PARTS[::-1] if name in stacked
    ]
    handles.append(Line2D([], [], color=INK, linestyle="--", label="brought in so far"))
    legend_below(canvas, handles)
    statements.insert(0, f"Case: {case.name}. Energies in J in the data file.")
    alt = f"energy ledgers of {', '.join(ledgers)} for {case.name}"
    return Drawing(canvas, joined(blocks), tuple(statements), alt)


def _stack(response: Response, history: str, struck: bool) -> tuple[Array, dict[str, Array], Array]:
    at = np.asarray(response[history].values, dtype=float)
    index = np.unique(np.linspace(0, len(at) - 1, min(len(at), _MOST_POINTS)).astype(int))
    parts = {
        name: np.asarray(response[name].values, dtype=float)[index]
        for name, _, _ in PARTS
        if name in response
    }
    work = np.zeros(len(index))
    if "external_work" in response:
        work = np.asarray(response["external_work"].values, dtype=float)[index]
    # a striker brings its energy at once, all else does work; what dead loads had stored before
    # is part of every later sum
    brought = float(response["input_energy"]) + work if struck else work
    stored = float(response["elastic"].values[0]) if history == "time" else 0.0
    return at[index], parts, brought + stored
