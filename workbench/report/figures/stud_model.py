"""The mechanical stud as a picture, to scale, with its parameters and which were calibrated."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Polygon, Rectangle

from workbench.content.formatting import number
from workbench.report.figures.drawing import Drawing, Request, nothing
from workbench.report.figures.pieces import LIGHT, arrow, spring
from workbench.report.figures.studs import contents
from workbench.report.figures.style import INK, MUTED, PALETTE, new_figure

STEEL = "#b9c4cf"
# proportions of the picture, in diameters
_HEIGHT, _HEAD, _HEAD_HEIGHT, _COLLAR, _COLLAR_HEIGHT = 5.3, 1.65, 0.5, 1.25, 0.27
_FLANGE, _WIDE, _SLAB = 0.8, 5.4, 6.3
_WORDS = {
    "bearing_factor": "bearing strength over f_c",
    "foundation_factor": "foundation modulus over E_c",
    "slide_capacity": "shear slide at rupture over d",
    "friction": "friction under the flange",
    "head_factor": "pressure under the head over f_c",
    "cone_factor": "cone factor (N, mm)",
    "cone_peak": "opening of the cone at its peak over h_ef",
    "cone_end": "opening at its end over h_ef",
    "cone_loss": "share of bearing that a cone takes",
    "rupture_strain": "axial strain at rupture",
}


def draw(request: Request) -> Drawing:
    """The stud in its slab on the left, the parameters on the right."""
    found = next(contents(request, "basis"), None)
    if found is None:
        return nothing("No mechanical stud has answered these cases.")
    _, label, content = found
    fit = content["fit"]
    canvas = new_figure(3.3)
    picture, text = canvas.subplots(1, 2, width_ratios=[1.0, 1.1])
    _picture(picture)
    _parameters(text, fit)
    entries = [
        {"parameter": name, "value": value, "calibrated": name in fit["free"],
         "standard_error_of_logarithm": fit["standard_errors"].get(name)}
        for name, value in fit["parameters"].items()
    ]  # fmt: skip
    statements = (f"{label}: {content['basis']}.",)
    alt = "a headed stud on a flange in a slab, with bearing springs, cone and shear slide"
    return Drawing(canvas, pd.DataFrame(entries), statements, alt)


def _picture(panel: Axes) -> None:
    panel.set_aspect("equal")
    panel.axis("off")
    panel.add_patch(Rectangle((-_WIDE, 0.0), 2 * _WIDE, _SLAB, facecolor=LIGHT, edgecolor="none"))
    steel: dict[str, Any] = {"facecolor": STEEL, "edgecolor": INK, "linewidth": 0.9, "zorder": 3}
    panel.add_patch(Rectangle((-_WIDE, -_FLANGE), 2 * _WIDE, _FLANGE, **steel))
    panel.add_patch(Rectangle((-0.5, 0.0), 1.0, _HEIGHT - _HEAD_HEIGHT, **steel))
    head = (-0.5 * _HEAD, _HEIGHT - _HEAD_HEIGHT)
    panel.add_patch(Rectangle(head, _HEAD, _HEAD_HEIGHT, **steel))
    panel.add_patch(Rectangle((-0.5 * _COLLAR, 0.0), _COLLAR, _COLLAR_HEIGHT, **steel))
    under = _HEIGHT - _HEAD_HEIGHT
    reach = 3.9
    cone = [(-0.5 * _HEAD, under), (-reach, 0.0), (reach, 0.0), (0.5 * _HEAD, under)]
    panel.add_patch(
        Polygon(cone, closed=False, fill=False, edgecolor=PALETTE[1], linestyle="--", linewidth=1.1)
    )
    for y in (0.75, 1.75, 2.75, 3.75):
        for side in (-1.0, 1.0):
            spring(panel, (side * 0.5, y), (side * 1.9, y), 0.34)
    panel.plot([-0.9, 0.9], [0.02, 0.02], color=PALETTE[0], linewidth=2.4, zorder=5)
    arrow(panel, (-_WIDE, -1.35), (-_WIDE + 2.2, -1.35), PALETTE[1])
    words: list[tuple[float, float, str, dict[str, Any]]] = [
        (-_WIDE + 2.4, -1.35, "flange: slip; it does not rotate", {"ha": "left"}),
        (3.0, 3.1, "bearing that crushes\nand leaves gaps", {"ha": "left"}),
        (-2.15, 4.35, "cone", {"ha": "right", "color": PALETTE[1]}),
        (1.05, _HEIGHT - 0.25, "head pressing on the cone", {"ha": "left"}),
        (1.05, 0.32, "weld collar", {"ha": "left"}),
        (-1.05, 0.32, "shear slide", {"ha": "right", "color": PALETTE[0]}),
        (-_WIDE + 0.15, _SLAB - 0.4, "slab", {"ha": "left", "color": MUTED}),
    ]
    for x, y, text, style in words:
        panel.text(x, y, text, fontsize=7.0, va="center", zorder=7, **style)
    panel.set_xlim(-_WIDE - 0.1, _WIDE + 0.1)
    panel.set_ylim(-1.8, _SLAB + 0.1)


def _parameters(panel: Axes, fit: dict[str, Any]) -> None:
    panel.axis("off")
    panel.set_xlim(0.0, 1.0)
    panel.set_ylim(0.0, 1.0)
    step, y = 0.082, 0.97
    for calibrated, title in ((True, "calibrated on push-outs"), (False, "assumed")):
        panel.text(0.0, y, title, fontsize=8.0, fontweight="bold", va="center")
        y -= step
        for name in (name for name in _WORDS if (name in fit["free"]) is calibrated):
            value = fit["parameters"][name]
            error = fit["standard_errors"].get(name)
            spread = "" if error is None else f" ± {100.0 * error:.0f} %"
            panel.text(0.02, y, _WORDS[name], fontsize=7.2, va="center")
            shown = f"{number(value, 3)}{spread}"
            panel.text(0.98, y, shown, fontsize=7.2, va="center", ha="right")
            y -= step * 0.9
        y -= 0.02
