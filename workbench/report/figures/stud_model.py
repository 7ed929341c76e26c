"""The mechanical stud as a picture, to scale, with its parameters and which were calibrated."""

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Polygon, Rectangle

from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.studs import answered
from workbench.report.drawing.style import INK, MUTED, PALETTE, Style, new_figure
from workbench.report.drawing.symbols import LIGHT, arrow, spring
from workbench.report.page.formatting import number

# proportions of the picture, in diameters
_HEIGHT, _HEAD, _HEAD_HEIGHT, _COLLAR, _COLLAR_HEIGHT = 5.3, 1.65, 0.5, 1.25, 0.27
_FLANGE, _WIDE, _SLAB, _REACH = 0.8, 5.4, 6.3, 3.9
_UNDER = _HEIGHT - _HEAD_HEIGHT
_STEEL: Style = {"facecolor": "#b9c4cf", "edgecolor": INK, "linewidth": 0.9, "zorder": 3}
_PARAMETERS = {
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
# where, what, alignment, colour
_NOTES = (
    (-_WIDE + 2.4, -1.35, "flange: slip; it does not rotate", "left", INK),
    (3.0, 3.1, "bearing that crushes\nand leaves gaps", "left", INK),
    (-2.15, 4.35, "cone", "right", PALETTE[1]),
    (1.05, _HEIGHT - 0.25, "head pressing on the cone", "left", INK),
    (1.05, 0.32, "weld collar", "left", INK),
    (-1.05, 0.32, "shear slide", "right", PALETTE[0]),
    (-_WIDE + 0.15, _SLAB - 0.4, "slab", "left", MUTED),
)


def draw(request: Request) -> Drawing:
    """The stud in its slab on the left, the parameters on the right."""
    answer = next(answered(request, "fit", "basis"), None)
    if answer is None:
        return nothing("No mechanical stud has answered these cases.")
    _, label, tables = answer
    canvas, parameters = new_figure(3.3), tables["parameters"]
    sheet = Sheet(canvas, canvas.subplots(1, 2, width_ratios=[1.0, 1.1]))
    for panel in sheet.panels:
        panel.axis("off")
    _picture(sheet.panels[0])
    _parameters(sheet.panels[1], parameters)
    sheet.record(parameters.rename(columns={"standard_error": "standard_error_of_logarithm"}))
    sheet.notes.append(f"{label}: {tables['fit']['basis'].iloc[0]}.")
    alt = "a headed stud on a flange in a slab, with bearing springs, cone and shear slide"
    return sheet.finish(alt)


def _picture(panel: Axes) -> None:
    panel.set_aspect("equal")
    panel.add_patch(Rectangle((-_WIDE, 0.0), 2 * _WIDE, _SLAB, facecolor=LIGHT, edgecolor="none"))
    for wide, low, high in (
        (2 * _WIDE, -_FLANGE, _FLANGE),
        (1.0, 0.0, _UNDER),
        (_HEAD, _UNDER, _HEAD_HEIGHT),
        (_COLLAR, 0.0, _COLLAR_HEIGHT),
    ):
        panel.add_patch(Rectangle((-0.5 * wide, low), wide, high, **_STEEL))
    cone = [(-0.5 * _HEAD, _UNDER), (-_REACH, 0.0), (_REACH, 0.0), (0.5 * _HEAD, _UNDER)]
    dashed: Style = {"edgecolor": PALETTE[1], "linestyle": "--", "linewidth": 1.1}
    panel.add_patch(Polygon(cone, closed=False, fill=False, **dashed))
    for y in (0.75, 1.75, 2.75, 3.75):
        for side in (-1.0, 1.0):
            spring(panel, complex(side * 0.5, y), complex(side * 1.9, y), 0.34)
    panel.plot([-0.9, 0.9], [0.02, 0.02], color=PALETTE[0], linewidth=2.4, zorder=5)
    arrow(panel, complex(-_WIDE, -1.35), complex(-_WIDE + 2.2, -1.35), PALETTE[1])
    for x, y, text, side_of, color in _NOTES:
        panel.text(x, y, text, fontsize=7.0, va="center", ha=side_of, color=color, zorder=7)
    panel.set(xlim=(-_WIDE - 0.1, _WIDE + 0.1), ylim=(-1.8, _SLAB + 0.1))


def _parameters(panel: Axes, parameters: pd.DataFrame) -> None:
    panel.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    step, y = 0.082, 0.97
    for calibrated, title in ((True, "calibrated on push-outs"), (False, "assumed")):
        panel.text(0.0, y, title, fontsize=8.0, fontweight="bold", va="center")
        y -= step
        for _, row in parameters[parameters["calibrated"] == calibrated].iterrows():
            spread = f" ± {100.0 * row['standard_error']:.0f} %" if calibrated else ""
            value = f"{number(row['value'], 3)}{spread}"
            for x, text, side in (
                (0.02, _PARAMETERS[row["parameter"]], "left"),
                (0.98, value, "right"),
            ):
                panel.text(x, y, text, fontsize=7.2, va="center", ha=side)
            y -= step * 0.9
        y -= 0.02
