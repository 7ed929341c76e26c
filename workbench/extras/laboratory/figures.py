"""Figure of reports, ``place``: the last unknown of an integrator's problem and the exact one."""

import numpy as np

from workbench.report.drawing.sheet import Drawing, Request
from workbench.report.drawing.style import INK, Style, entry

_EXACT: Style = {"color": INK, "linewidth": 2.2, "alpha": 0.25}


def place(request: Request) -> Drawing:
    """Places in time of integrators; what leaves the frame of the exact answer is cut."""
    sheet, panels = request.case_panels()
    needed = {"record.place", "record.exact"}
    for case, panel in panels:
        exact = np.zeros(1)
        for label, response in request.answers(case, sheet.absent, needed, "a record").items():
            time, values = response["time"].values, response["record.place"].values
            exact = response["record.exact"].values
            panel.plot(time, exact, **_EXACT, zorder=0)
            panel.plot(time, values, **request.looks[label].curve(linewidth=0.8))
            sheet.record(case=case.name, label=label, time=time, place=values)
        low, high = float(exact.min()), float(exact.max())
        margin = 0.6 * max(high - low, 1e-12)
        panel.set_ylim(low - 0.25 * margin, high + margin)
        panel.margins(x=0.0)
        sheet.name(panel, case.name, "time (s)", "place (m)")
    sheet.legend(entry("exact", **_EXACT))
    sheet.legend(*(entry(label, **request.looks[label].curve()) for label in request.labels))
    empty = "No integrator has answered a problem."
    return sheet.finish("places of the last unknown in time, a panel per problem", empty=empty)
