"""Histories over time, all labels of a case in one panel.

Options: `quantity` (a history; `impulse` stands for the percussions summed up), `hinge` (a name,
for quantities that belong to hinges), `cases`, `until` (s).
"""

import numpy as np
from matplotlib.axes import Axes

from workbench.content.formatting import axis_label, title_of, unit_of
from workbench.report.drawing.sheet import Array, Drawing, Request, Sheet, nothing, thinned
from workbench.report.drawing.style import MUTED, entry
from workbench.responses import Response
from workbench.study.definition import Case

_PEAKS = {"displacement": ("peak_displacement", "time_of_peak")}
_TIME = unit_of("time").factor


def draw(request: Request) -> Drawing:
    """Overlaid histories, one panel per case; models without a history show their peak."""
    quantity, hinge = str(request.option("quantity", "displacement")), request.option("hinge", "")
    said: list[str] = []
    cases = request.chosen(said, static=False)
    if not cases:
        return nothing("Histories in time need an impact or a ground motion; no case is one.")
    if hinge:
        said.append(f"Hinge: {hinge}.")
    sheet = Sheet.grid(len(cases), said, sharey=False)
    unit, until = unit_of(quantity).factor, float(request.option("until", np.inf))
    for case, panel in zip(cases, sheet.panels, strict=True):
        for label, response in request.answers(case, sheet.absent).items():
            curve, look = _curve(response, quantity, str(hinge)), request.looks[label]
            if curve is None:
                _peak(request, sheet, case, label, panel)
                continue
            time, values = curve
            time, values = thinned(time[time <= until], values[time <= until])
            panel.plot(time * _TIME, values * unit, **look.curve())
            sheet.legend(entry(label, **look.curve()))
            sheet.record(case=case.name, label=label, time_s=time, **{f"{quantity}_SI": values})
        sheet.name(panel, case.name, axis_label("time"), axis_label(quantity))
        panel.set_xlim(left=0.0)
        panel.margins(x=0.0)
        if not panel.lines:
            panel.text(0.5, 0.5, "no curve", transform=panel.transAxes, ha="center", color=MUTED)
    sheet.level()
    return sheet.finish(
        f"{title_of(quantity)} over time for {', '.join(case.name for case in cases)}",
        empty=f"No model answered these cases with {title_of(quantity)}.",
    )


def _peak(request: Request, sheet: Sheet, case: Case, label: str, panel: Axes) -> None:
    """The peak of a model without a history: a marker, or a line if its time is unknown."""
    quantity, hinge = str(request.option("quantity", "displacement")), request.option("hinge", "")
    names, look = _PEAKS.get(quantity, ()), request.looks[label]
    peak, when = (*(request.number(case, label, name) for name in names), None, None)[:2]
    if peak is None:
        where = f" of {hinge} in {case.name}" if hinge else ""
        sheet.absent.without(f"{title_of(quantity)} over time{where}", label)
        return
    shown = peak * unit_of(quantity).factor
    if when is None:
        style = look.curve(linestyle=":")
        panel.axhline(shown, **style)
    else:
        style = look.points()
        panel.plot([when * _TIME], [shown], **style)
    sheet.legend(entry(f"{label} (peak only)", **style))
    at = np.nan if when is None else when
    sheet.record(case=case.name, label=label, time_s=at, **{f"{quantity}_SI": peak})


def _curve(response: Response, quantity: str, hinge: str) -> tuple[Array, Array] | None:
    stored = "percussion" if quantity == "impulse" else quantity
    if "time" not in response.coords or stored not in response:
        return None
    values = response[stored]
    if values.dims == ("hinge", "time") and hinge in values["hinge"].values:
        values = values.sel(hinge=hinge)
    if values.dims != ("time",):
        return None
    curve = values.values.astype(float)
    return response["time"].values.astype(float), curve.cumsum() if stored != quantity else curve
