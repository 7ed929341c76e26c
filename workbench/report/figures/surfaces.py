"""Rules of plastic interaction, section by section, and where models without shear end.

``yield-surfaces``: two panels per section, the curves of N and M, and the deviation of their radii
from the exact ones over the angle atan2(N / N_p, M / M_p).
``shear-surfaces``: a panel per section with webs, without axial force. The exact curve is that of
one shear rate per section (`ShearSurface.one_shear_rate`); EN 1993-1-1, 6.2.8 reduces the strength
of the web by (2 V / V_pl - 1)^2 above V_pl / 2; the additive form is m + (V / V_pl)^2 = 1.
``shear-domain``: ratio of final forces against the shear force over V_pl. Options: `against` (the
shear-free label, default the reference), `tolerance` (default 0.05), `group` (case parameter that
tells the series of a model apart).
"""

import numpy as np

from workbench.base.arrays import Array
from workbench.report.drawing.layout import frame_scenario_of
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import INK, MUTED, Style
from workbench.steel.hinges import ShearSurface, has_webs
from workbench.steel.hinges.interaction import ANGLES, RULES, radial_error, radius

_POINTS = 201
_MARKERS = ("o", "s", "^", "D", "v")


def axial(request: Request) -> Drawing:
    """Two panels per section of the frames and columns of the cases, in their order."""
    known = (frame_scenario_of(case.scenario) for case in request.cases)
    frames = [scenario.frame for scenario in known if scenario]
    sections = list(dict.fromkeys(f.strength_section(m) for f in frames for m in f.members))
    sheet = Sheet.grid(2 * len(sections), height=2.6, sharey=False)
    angle = np.linspace(0.0, 0.5 * np.pi, ANGLES)
    panels = iter(sheet.panels)
    for section in sections:
        curves, errors = next(panels), next(panels)
        exact = radius("exact", section, angle)
        notes = []
        for number, rule in enumerate(RULES):
            r = radius(rule, section, angle)
            look: Style = {"color": f"C{number - 1}", "linewidth": 1.1}
            look = {"color": INK, "linewidth": 1.8} if rule == "exact" else look
            n, m, off = r * np.sin(angle), r * np.cos(angle), 100.0 * (r / exact - 1.0)
            sheet.legend(*curves.plot(m, n, label=rule, **look))
            errors.plot(np.degrees(angle), off, **look)
            sheet.record(section=section.name, rule=rule, axial=n, moment=m, error_percent=off)
            low, high, rms = (100.0 * e for e in radial_error(rule, section))
            if rule != "exact":
                notes.append(f"{rule} {low:.1f} to {high:+.1f} (rms {rms:.1f})")
        sheet.name(curves, section.name, "M/Mpl", "N/Npl")
        sheet.name(errors, "radius off the exact one, %", "angle from pure bending, degrees", "")
        sheet.notes.append(f"{section.name}, radial error in percent: {', '.join(notes)}.")
    return sheet.finish("plastic interaction of axial force and moment by seven rules")


def shear(request: Request) -> Drawing:
    """A panel per section of the columns that the cases hit, in their order."""
    columns = [column for c in request.cases if (column := getattr(c.scenario, "column", None))]
    steels = {column.strength_section: column.steel for column in columns}
    surfaces = {s: ShearSurface(s, steel, "clear") for s, steel in steels.items() if has_webs(s)}
    notes = [f"{s.name}: no plane webs." for s in steels if not has_webs(s)]
    sheet = Sheet.grid(max(len(surfaces), 1), notes, height=2.6)
    share = np.linspace(0.0, 1.0, _POINTS)
    for panel, (section, surface) in zip(sheet.panels, surfaces.items(), strict=False):
        plastic = surface.plastic_moment
        domain = surface.moment_capacity(0.0, share * surface.shear_resistance) / plastic
        exact = surface.one_shear_rate(share) / plastic
        flanges = float(surface.record["flange_moment"]) / plastic
        eurocode = 1.0 - (1.0 - flanges) * np.maximum(2.0 * share - 1.0, 0.0) ** 2
        curves: dict[str, tuple[Array, Style]] = {
            "one shear rate, exact": (exact, {"color": INK, "linewidth": 1.6}),
            "panels": (domain, {"color": "C1", "linewidth": 1.4}),
            "EN 1993-1-1, 6.2.8": (eurocode, {"color": "C0", "linestyle": "--"}),
            "additive": (1.0 - share**2, {"color": MUTED, "linestyle": ":"}),
        }
        for name, (moment, look) in curves.items():
            sheet.legend(*panel.plot(share, moment, label=name, **look))
            sheet.record(section=section.name, rule=name, shear=share, moment=moment)
        panel.set_ylim(0.0, 1.05)
        sheet.name(panel, section.name, "V/Vpl", "M/Mpl")
        lack = float(np.max(exact - domain))
        sheet.notes.append(f"{section.name}: panels lack at most {lack:.3f} M_pl.")
    return sheet.finish("plastic moment over shear force by four rules, per section")


def shear_domain(request: Request) -> Drawing:
    """One series per model and group; the utilisation is that of the shear-free model."""
    against, group = request.against, str(request.option("group", ""))
    tolerance = float(request.option("tolerance", 0.05))
    points: dict[tuple[str, str], list[tuple[float, float, str]]] = {}
    notes: list[str] = []
    for case in request.cases:
        free = request.stored.response(case.name, against)
        if free is None or not {"shear_utilisation", "force"} <= set(free.data_vars):
            notes.append(f"{case.name}: no force and shear force from {against}.")
            continue
        x = float(free["shear_utilisation"].max())
        for label in request.shown(case):
            if label == against:
                continue
            response = request.stored.response(case.name, label)
            if response is None or "force" not in response:
                notes.append(f"{case.name}: no force from {label}.")
                continue
            ratio = float(response["force"][-1]) / float(free["force"][-1])
            series = points.setdefault((label, str(case.parameters.get(group, ""))), [])
            series.append((x, ratio, case.name))
    if not points:
        return nothing(*notes)
    sheet, groups = Sheet.table(1, 1, 3.4), list(dict.fromkeys(name for _, name in points))
    panel, sheet.notes = sheet.panel, notes
    for (label, name), series in points.items():
        xs, ys, cases = map(np.array, zip(*sorted(series), strict=True))
        number, title = groups.index(name), f"{label}, {name}" if name else label
        style: Style = {"color": request.looks[label].color, "markersize": 4.0, "linewidth": 1.1}
        style["marker"] = _MARKERS[number % len(_MARKERS)]
        panel.plot(xs, ys, linestyle="--" if number else "-", label=title, **style)
        head = {"case": cases, "label": label, "group": name}
        sheet.record(**head, shear_over_plastic_shear=xs, force_ratio=ys)
        sheet.notes.append(f"{title}: {_bound(xs, ys, tolerance)}.")
    panel.axhspan(1.0 - tolerance, 1.0 + tolerance, color=MUTED, alpha=0.18, linewidth=0.0)
    panel.axhline(1.0, color=INK, linewidth=0.6)
    panel.set_xlim(left=0.0)
    sheet.name(panel, "", f"V/Vpl in {against}", f"force over that of {against}")
    sheet.legend(*panel.get_legend_handles_labels()[0])
    return sheet.finish(f"ratio of the final force to that of {against} over its shear force")


def crossing(x: Array, ratio: Array, tolerance: float) -> float | None:
    """First x (rising) at which |ratio - 1| passes the tolerance for good, interpolated.

    Infinite if it stays within, None if it is outside from the first point on.
    """
    error = np.abs(ratio - 1.0)
    inside = np.flatnonzero(error <= tolerance)
    if len(inside) == 0:
        return None
    last = int(inside[-1])
    if last == len(x) - 1:
        return float("inf")
    return float(np.interp(tolerance, error[last : last + 2], x[last : last + 2]))


def _bound(x: Array, ratio: Array, tolerance: float) -> str:
    bound = crossing(x, ratio, tolerance)
    percent = f"{100.0 * tolerance:g} %"
    if bound is None:
        return f"further off than {percent} at every V/Vpl from {x[0]:.2f} on"
    if np.isinf(bound):
        return f"within {percent} up to V/Vpl = {x[-1]:.2f}, the largest that was run"
    return f"beyond V/Vpl = {bound:.2f} further off than {percent}"
