"""Rules of plastic interaction of axial force and moment, and how far they are off by direction.

Two panels per section of the members: the curves, and the deviation of their radii from the
exact ones over the angle atan2(N / N_p, M / M_p).
"""

import numpy as np

from workbench.hinges.interaction import ANGLES, RULES, radial_error, radius
from workbench.models.frame_model import as_frame
from workbench.report.drawing.sheet import Drawing, Request, Sheet
from workbench.report.drawing.style import INK, Style
from workbench.scenarios import ImpactProblem, StudTests


def draw(request: Request) -> Drawing:
    """Two panels per section of the frames and columns of the cases, in their order."""
    told = (case.scenario for case in request.cases)
    frames = [as_frame(s).frame for s in told if not isinstance(s, StudTests | ImpactProblem)]
    sections = list(dict.fromkeys(f.strength_section(m) for f in frames for m in f.members))
    sheet = Sheet.grid(2 * len(sections), height=2.6, sharey=False)
    angle = np.linspace(0.0, 0.5 * np.pi, ANGLES)
    panels = iter(sheet.panels)
    for section in sections:
        curves, errors = next(panels), next(panels)
        exact = radius("exact", section, angle)
        said = []
        for number, rule in enumerate(RULES):
            r = radius(rule, section, angle)
            own: Style = {"color": f"C{number - 1}", "linewidth": 1.1}
            look: Style = {"color": INK, "linewidth": 1.8} if rule == "exact" else own
            n, m, off = r * np.sin(angle), r * np.cos(angle), 100.0 * (r / exact - 1.0)
            sheet.legend(*curves.plot(m, n, label=rule, **look))
            errors.plot(np.degrees(angle), off, **look)
            sheet.record(section=section.name, rule=rule, axial=n, moment=m, error_percent=off)
            low, high, rms = (100.0 * e for e in radial_error(rule, section))
            if rule != "exact":
                said.append(f"{rule} {low:.1f} to {high:+.1f} (rms {rms:.1f})")
        sheet.name(curves, section.name, "M/Mpl", "N/Npl")
        sheet.name(errors, "radius off the exact one, %", "angle from pure bending, degrees", "")
        sheet.said.append(f"{section.name}, radial error in percent: {', '.join(said)}.")
    return sheet.finish("plastic interaction of axial force and moment by seven rules")
