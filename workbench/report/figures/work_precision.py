"""Error against work of integrators: one panel per problem, one line per scheme.

Work is evaluations of the forces or, with option `time`, the time that they took in the finest run.
"""

import numpy as np

from workbench.content.formatting import number
from workbench.report.drawing.sheet import Drawing, Request, Sheet
from workbench.report.drawing.style import entry, logarithmic

_FLOOR, _CEILING = 1e-12, 1e2


def draw(request: Request) -> Drawing:
    """Ladders of steps on logarithmic axes."""
    said: list[str] = []
    cases = request.chosen(said)
    timed = bool(request.option("time", False))
    what = "solving, ms" if timed else "evaluations of the forces"
    sheet = Sheet.grid(len(cases), said, sharey=False)
    for case, panel in zip(cases, sheet.panels, strict=True):
        needed = {"ladder.error", "ladder.evaluations"}
        for label, response in request.answers(case, sheet.absent, needed, "ladder").items():
            error, work = response["ladder.error"].values, response["ladder.evaluations"].values
            known = np.isfinite(error)
            if timed:
                spent = request.number(case, label, "solve_time")
                if spent is None:
                    continue
                work = 1e3 * spent / work[-1] * work
            sheet.record(case=case.name, label=label, **{what: work[known]}, error=error[known])
            look = request.looks[label]
            shown = np.clip(error[known], _FLOOR, _CEILING)
            panel.plot(work[known], shown, **look.curve(linewidth=0.9))
        panel.set_xscale("log")
        panel.set_yscale("log")
        logarithmic(panel.xaxis, lambda value: number(value, 1))
        logarithmic(panel.yaxis, lambda value: f"{value:.0e}".replace("e-0", "e-"))
        sheet.name(panel, case.name, what, "relative error")
    sheet.legend(*(entry(label, **request.looks[label].curve()) for label in request.labels))
    text = f"Errors below {_FLOOR:g} are drawn there: they are round-off; so are those above"
    sheet.said.append(f"{text} {_CEILING:g}, of steps that are not stable.")
    empty = "No integrator has answered a problem."
    return sheet.finish(f"error against {what}, a panel per problem", empty=empty)
