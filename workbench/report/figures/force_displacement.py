"""Force against displacement of static loading, with all of its reversals.

Options: `cases`, `quantity` (``force``, the default, or ``load_factor``), `until` (m: the record
up to the first displacement beyond it).
"""

import numpy as np
from matplotlib.axes import Axes

from workbench.content.formatting import Unit, title_of, unit_of
from workbench.fields import Choice
from workbench.report.drawing.layout import displacement_unit, frame_scenario_of
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing, thinned
from workbench.report.drawing.style import MUTED, entry
from workbench.study.definition import Case

_QUANTITY = Choice(("force", "load_factor"))
_LOOPS = 0.8  # width of a line that turns back, over that of one that does not


def draw(request: Request) -> Drawing:
    """Overlaid force-displacement curves, one panel per case."""
    quantity = request.option("quantity", "force")
    quantity = _QUANTITY.check("figure.options.quantity", quantity)
    said: list[str] = []
    cases = request.chosen(said, static=True)
    if not cases:
        return nothing("Force-displacement curves need static loading; no case is static.")
    sheet = Sheet.grid(len(cases), said, height=2.6, sharey=False)
    until, what = float(request.option("until", np.inf)), f"{title_of(quantity)} and displacement"
    for case, panel in zip(cases, sheet.panels, strict=True):
        (along, turned), (up, shown) = _axes(case, quantity)
        turning = False
        answers = request.answers(case, sheet.absent, (quantity, "displacement"), what)
        for label, response in answers.items():
            x, y = response["displacement"].values, response[quantity].values
            beyond = np.flatnonzero(np.abs(x) > until)
            end = beyond[0] if len(beyond) else len(x)
            back = bool(np.any(np.diff(x[:end]) < 0.0))
            turning |= back
            x, y = thinned(x[:end], y[:end], 2400 if back else 700)
            look = request.looks[label]
            width = look.width * (_LOOPS if back else 1.0)
            panel.plot(x * along.factor, y * up.factor, **look.curve(linewidth=width))
            sheet.legend(entry(label, **look.curve()))
            sheet.record(case=case.name, label=label, displacement_SI=x, **{f"{quantity}_SI": y})
        _finish(panel, turning)
        height = f"{shown} ({up.text})" if up.text else shown
        sheet.name(panel, case.name, f"{turned} ({along.text})", height)
    if len({_axes(case, quantity)[1][0].text for case in cases}) == 1:  # forces beside forces
        sheet.level()
    return sheet.finish(
        f"{title_of(quantity)} over displacement for {', '.join(case.name for case in cases)}",
        empty="No model answered these cases with a curve.",
    )


def _axes(case: Case, quantity: str) -> tuple[tuple[Unit, str], tuple[Unit, str]]:
    """Display unit and name of displacement and quantity: patterns may hold moments only."""
    scenario = frame_scenario_of(case)
    along = unit_of("displacement") if scenario is None else displacement_unit(scenario)
    across = along, "rotation" if along.text == "rad" else "displacement"
    loads = getattr(scenario, "loads", ())
    if quantity == "force" and loads and not any(load.x or load.y for load in loads):
        return across, (unit_of("moment"), "moment")
    return across, (unit_of(quantity), title_of(quantity))


def _finish(panel: Axes, turning: bool) -> None:
    """Loops get axes through the origin and air around them, other curves start on the axis."""
    if turning:
        panel.axhline(0.0, color=MUTED, linewidth=0.6, zorder=1)
        panel.axvline(0.0, color=MUTED, linewidth=0.6, zorder=1)
        panel.margins(x=0.04, y=0.06)
        return
    panel.margins(x=0.0)
    panel.set_ylim(bottom=min(0.0, panel.get_ylim()[0]))
