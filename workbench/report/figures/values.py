"""Single values of all labels: against the reference, against tests, with their budgets of error.

``peaks``, options: `quantity` (a scalar, default ``peak_displacement``), `against` (a label;
default the reference), `cases`, `clusters` (name: labels): points of a cluster stand side by side,
named where the values of the first case leave room, in place of a legend.
``tests``: measured against predicted, one panel per model, with the half-widths of both sides.
Option: `quantity` (a scalar, default the first of the study). Made numbers are named so.
``budget``: bars per term and their sums, one panel per model, same axes. Options: `case` (default
the first with a budget), `quantity` (default ``peak_displacement``). Of the forms of a budget the
first is drawn: with the strain rate of the steel.

**Second part.** Rules of plastic interaction, section by section, and where models without shear
end.

``yield-surfaces``: two panels per section, the curves of N and M, and the deviation of their radii
from the exact ones over the angle atan2(N / N_p, M / M_p).
``shear-surfaces``: a panel per section with webs, without axial force. The exact curve is that of
one shear rate per section (`ShearSurface.one_shear_rate`); EN 1993-1-1, 6.2.8 reduces the strength
of the web by (2 V / V_pl - 1)^2 above V_pl / 2; the additive form is m + (V / V_pl)^2 = 1.
``shear-domain``: ratio of final forces against the shear force over V_pl. Options: `against` (the
shear-free label, default the reference), `tolerance` (default 0.05), `group` (case parameter that
tells the series of a model apart).
"""

import textwrap
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from workbench.base.arrays import Array
from workbench.report.chapters.budgets import change, scale
from workbench.report.drawing import studs
from workbench.report.drawing.frame import frame_scenario_of
from workbench.report.drawing.sheet import Drawing, Request, Sheet, first, nothing
from workbench.report.drawing.style import GRID, INK, MUTED, PALETTE, WARNING, Style, entry, framed
from workbench.report.page.formatting import axis_label, in_unit, number, title_of, unit_of
from workbench.responses import COVERAGE, PEAK, attribute
from workbench.responses.uncertainty import DATA_WIDTHS, uncertainty_of
from workbench.steel.hinges import ShearSurface, has_webs
from workbench.steel.hinges.interaction import ANGLES, RULES, radial_error, radius
from workbench.study.assessment.gates import SUMS
from workbench.study.assessor import width_of
from workbench.study.definition import Case

MOST_CASES = 8
_ROOM = 0.8  # share of a case's slot that its markers take
_BAND: Style = {"color": "#000000", "alpha": 0.13, "linewidth": 0.0, "zorder": 1}
_SYNTHETIC = "SYNTHETIC"
_RECORDED = ("case", "label", "form", "quantity", "term", "shift", "low", "high")
_RIGHT = 0.45  # of the axis, to the right of all bars, for the numbers
_AT_THE_EDGE: Style = {
    **{"xycoords": ("axes fraction", "data"), "textcoords": "offset points", "ha": "right"},
    **{"va": "center", "fontsize": "small", "color": INK},
}


def peaks(request: Request) -> Drawing:
    """Values above, relative deviations from the reference with their uncertainty below."""
    quantity, against = str(request.option("quantity", "peak_displacement")), request.against
    notes: list[str] = []
    cases = _known(request, quantity, notes)
    table = _values(request, cases, quantity)
    if table.empty:
        return nothing(f"No model answered these cases with {title_of(quantity)}.")
    sheet = Sheet.table(2, 1, 4.3, notes, sharex=True, height_ratios=[1.15, 1.0])
    (top, bottom), unit = sheet.panels, unit_of(quantity).factor
    clusters: dict[str, tuple[str, ...]] = request.option("clusters", {})
    present = set(table["label"]) & set(request.labels)
    order = dict.fromkeys((*(x for names in clusters.values() for x in names), *request.labels))
    labels = [label for label in order if label in present]
    if _bands(request, sheet, cases, quantity):
        sheet.legend(Patch(**_BAND, label=f"numerical uncertainty of {request.study.reference}"))
    for i, label in enumerate(labels):
        rows, look = table[table["label"] == label], request.looks[label].points()
        x = rows.pop("slot") + _ROOM * ((i + 0.5) / len(labels) - 0.5)
        values, deviations = unit * rows.iloc[:, 2:4], 100.0 * rows.iloc[:, 4:6]
        for panel, shown, cap in ((top, values, 0.0), (bottom, deviations, 2.0)):
            y, width = shown.to_numpy(float).T
            panel.errorbar(x, y, yerr=width, fmt="none", ecolor=MUTED, lw=0.9, capsize=cap)
            panel.plot(x, y, **look)
        if not clusters:
            sheet.legend(entry(label, **look))
    _slots(sheet, [case.name for case in cases])
    for case in cases:  # for the notes on what is absent
        request.answers(case, sheet.absent, (quantity,), title_of(quantity))
    top.set_ylabel(axis_label(quantity))
    low, high = top.get_ylim()
    top.set_ylim(1.08 * min(low, 0.0), 1.08 * max(high, 0.0))
    bottom.set_ylabel(textwrap.fill(f"deviation from {against} (%)", 26))
    bottom.margins(y=0.12)
    bottom.axhline(0.0, color=INK, linewidth=0.8, zorder=1)
    if clusters:
        _names(sheet, table, labels, clusters, unit)
    if table["relative_error"].isna().all():
        words = f"no comparison with {against}"
        bottom.text(0.5, 0.5, words, transform=bottom.transAxes, ha="center")
    sheet.record(table.drop(columns="slot"))
    alt = f"{title_of(quantity)} of {', '.join(labels)}, and deviations from {against}"
    return sheet.finish(alt)


def _names(
    sheet: Sheet,
    table: pd.DataFrame,
    labels: list[str],
    clusters: dict[str, tuple[str, ...]],
    unit: float,
) -> None:
    """Names beside the first points: of labels above, upright; of clusters below."""
    (top, bottom), every = sheet.panels, table.drop_duplicates("label").set_index("label")
    rows = every[every["slot"] == every["slot"].min()]
    place = every["slot"].reindex(labels) + _ROOM * (
        np.arange(0.5, len(labels)) / len(labels) - 0.5
    )
    for label in labels:
        at = place[label], unit * every.loc[label].iloc[1]
        upright: Style = {"rotation": 90, "va": "bottom", "ha": "center", "fontsize": 6.5}
        top.annotate(label, at, (0, 6), textcoords="offset points", **upright)
    for name, members in clusters.items():
        shown = [label for label in members if label in rows.index]
        deviations = 100.0 * rows.loc[shown, "relative_error"].fillna(0.0)
        middle = float(np.mean([place[label] for label in shown]))
        below = deviations.mean() < 0.0
        at = middle, float(deviations.min() if below else deviations.max())
        beside: Style = {"ha": "center", "va": "top" if below else "bottom", "fontsize": 7.5}
        bottom.annotate(name, at, (0, -7 if below else 7), textcoords="offset points", **beside)


def _known(request: Request, quantity: str, notes: list[str]) -> list[Case]:
    """Cases that have the quantity; answered ones that do not (statics, say) are named."""
    known, without = [], []
    for case in request.cases:
        labels = request.shown(case)
        if any(request.number(case, label, quantity) is not None for label in labels):
            known.append(case)
        elif any(request.stored.ok(case.name, label) for label in labels):
            without.append(case.name)
    if known and without:
        notes.append(f"Without {title_of(quantity)} of any model: {', '.join(without)}.")
    return first(known, MOST_CASES, "cases; the tables hold all of them", notes)


def _values(request: Request, cases: list[Case], quantity: str) -> pd.DataFrame:
    """A row per case and label with a value: the value and its deviation, each with its width."""
    compared = request.errors(quantity)
    names = ["case", "label", f"{quantity}_SI", "data_uncertainty_SI"]
    names += ["relative_error", "uncertainty"]
    rows = []
    for slot, case in enumerate(cases):
        for label in request.labels:
            value = request.number(case, label, quantity)
            if value is not None:
                answer = request.stored.response(case.name, label)
                width = None if answer is None else uncertainty_of(answer, quantity, DATA_WIDTHS)
                row = compared.get((case.name, label), {})
                deviation = row.get("error"), row.get("uncertainty")
                rows.append((case.name, label, value, width, *deviation, slot))
    table = pd.DataFrame(rows, columns=[*names, "slot"])
    return table.astype(dict.fromkeys(names[2:], float))


def _bands(request: Request, sheet: Sheet, cases: list[Case], quantity: str) -> bool:
    """Intervals that refinement leaves around the reference, above and below; whether there are."""
    drawn = False
    top, bottom = sheet.panels
    for i, case in enumerate(cases):
        where, row = [i - 0.46, i + 0.46], request.stored.ladder(case.name, quantity)
        band = request.interval(case, quantity)
        if band is not None:
            low, high = (unit_of(quantity).factor * end for end in band)
            top.fill_between(where, low, high, **_BAND)
            drawn = True
        if request.against == request.study.reference and row and row["relative"] is not None:
            share = 100.0 * row["relative"]
            bottom.fill_between(where, -share, share, **_BAND)
    return drawn


def _slots(sheet: Sheet, names: list[str]) -> None:
    """A slot per case, its name wrapped to the width."""
    room = max(10, 84 // len(names))
    words = ["\n".join(textwrap.wrap(name, room)) for name in names]
    sheet.panels[-1].set_xticks(range(len(names)), words)
    for panel in sheet.panels:
        panel.grid(visible=False, axis="x")
        panel.set_xlim(-0.5, len(names) - 0.5)
        panel.tick_params(axis="x", length=0)
        for edge in range(1, len(names)):
            panel.axvline(edge - 0.5, color=GRID, linewidth=0.6, zorder=0)


def tests(request: Request) -> Drawing:
    """Measured values up, predicted values across, with bias and coverage of the model."""
    unit = unit_of(request.quantity)
    tables = {label: _pairs(request, label) for label in request.labels if label != request.against}
    tables = {label: table for label, table in tables.items() if not table.empty}
    if not tables:
        return nothing(f"No model answered a test with {title_of(request.quantity)}.")
    everything = pd.concat(list(tables.values()))
    looks = studs.campaign_looks(everything["campaign"], filled=True)
    ends = (
        everything[["test", "prediction"]].to_numpy()
        + everything[["test_width", "prediction_width"]].to_numpy()
    )
    top = 1.06 * unit.factor * float(np.nanmax(ends))
    sheet = Sheet.grid(len(tables), height=2.45, sharex=True)
    for panel, (label, table) in zip(sheet.panels, tables.items(), strict=True):
        studs.draw_diagonal(panel, top)
        for campaign, rows in table.groupby("campaign", sort=False):
            values = (
                unit.factor * rows[name]
                for name in ("prediction", "test", "prediction_width", "test_width")
            )
            x, y, wide, high = values
            panel.errorbar(x, y, yerr=high, xerr=wide, fmt="none", ecolor=MUTED, lw=0.8)
            panel.plot(x, y, **looks[str(campaign)].points())
        sheet.name(panel, label, f"predicted ({unit.text})", f"measured ({unit.text})")
        note, text = _summary(request, label)
        panel.text(0.96, 0.05, note, transform=panel.transAxes, ha="right", fontsize=7.0)
        if request.stored.synthetic:
            framed(panel, 0.04, 0.86, _SYNTHETIC, WARNING, fontsize=7.0)
        sheet.notes.append(text)
        sheet.record(table)
    for case in request.cases:  # for the notes on what is absent
        request.answers(case, sheet.absent)
    sheet.legend(*(entry(name, **look.points()) for name, look in looks.items()))
    sheet.legend(*studs.diagonal_entries("measured = predicted"))
    made = f"{_SYNTHETIC}, " if request.stored.synthetic else ""
    return sheet.finish(f"{made}measured against predicted {title_of(request.quantity)}")


def _pairs(request: Request, label: str) -> pd.DataFrame:
    """A row per test that the model answers: both values and half-widths ."""
    rows = []
    for case in request.cases:
        values = [request.number(case, side, request.quantity) for side in (request.against, label)]
        test = request.stored.response(case.name, request.against)
        answer = request.stored.response(case.name, label)
        if test is None or answer is None or None in values:
            continue
        test_width = uncertainty_of(test, request.quantity, DATA_WIDTHS)
        prediction_width = request.number(case, label, width_of(request.quantity))
        campaign = attribute(test, "data").get("campaign", "all")
        rows.append(
            (label, case.name, campaign, *values, test_width or 0.0, prediction_width or 0.0)
        )
    columns = ["label", "case", "campaign", "test", "prediction", "test_width", "prediction_width"]
    return pd.DataFrame(rows, columns=columns)


def _summary(request: Request, label: str) -> tuple[str, str]:
    """Return the note in the panel and the sentence below the figure."""
    wanted = {"model": label, "against": request.against, "quantity": request.quantity}
    rows = request.stored.records("validation", **wanted)
    if not rows or rows[0]["bias"] is None:
        return "", f"{label}: no bias over tests."
    row = rows[0]
    ends = row["low"], row["high"]
    span = "" if None in ends else f" ({number(ends[0], 3)} to {number(ends[1], 3)})"
    held = f"{row['covered']:.0f} of {row['counted']:.0f}"
    text = f"{label}: median of test over prediction {number(row['bias'], 3)}{span}, "
    made = f" {_SYNTHETIC}: no test." if row["synthetic"] else ""
    return (
        f"median {number(row['bias'], 3)}\n{held} intervals hold",
        f"{text}{held} stated intervals hold the test.{made}",
    )


def budget(request: Request) -> Drawing:
    """Bars of every source of error, as changes of the answer."""
    quantity = str(request.option("quantity", PEAK))
    panels: dict[str, list[dict[str, Any]]] = {}
    for row in request.stored.records("budget", quantity=quantity):
        if row["label"] in request.labels and row["case"] == request.option("case", row["case"]):
            rows = panels.setdefault(row["label"], [])
            if not rows or rows[0]["form"] == row["form"]:
                rows.append(row)
    if not panels:
        return nothing("No answer whose errors are budgeted has been run.")
    height = sum(0.2 * len(rows) + 0.35 for rows in panels.values()) + 0.35
    sheet = Sheet.table(len(panels), 1, height, sharex=True)
    low, high = scale([row for rows in panels.values() for row in rows])
    for (label, rows), panel in zip(panels.items(), sheet.panels, strict=True):
        _bars(panel, rows, high)
        panel.set_xlim(100.0 * (low - 0.04), 100.0 * (high + _RIGHT * (high - low)))
        value = in_unit(rows[0]["value"], quantity)
        sheet.name(panel, f"{label}: {value} {rows[0]['form']}", "", "")
        for row in rows:
            sheet.record(**{name: row[name] for name in _RECORDED}, value_SI=row["value"])
    sheet.panels[-1].set_xlabel(
        f"change of the {title_of(quantity)} (%), {100 * COVERAGE:g} % intervals"
    )
    return sheet.finish(f"error budgets of the {title_of(quantity)} of {', '.join(panels)}")


def _bars(panel: Axes, rows: list[dict[str, Any]], most: float) -> None:
    """The bars of a model from the first term down, each with its numbers."""
    for place, row in enumerate(rows):
        summed = row["term"] in SUMS
        if row["low"] is not None:
            left, right = 100.0 * row["low"], 100.0 * min(row["high"], most)
            color = PALETTE[0] if summed else MUTED
            panel.barh(place, right - left, left=left, height=0.62, color=color, zorder=2)
            if row["shift"]:
                at = 100.0 * row["shift"]
                panel.plot([at, at], [place - 0.31, place + 0.31], color="white", zorder=3)
        numbers = panel.annotate(change(row), (1.0, place), (-3, 0), **_AT_THE_EDGE)
        numbers.set_in_layout(False)  # they lie inside, and would push the labels off the page
    panel.set_yticks(range(len(rows)), [row["term"] for row in rows])
    panel.set_ylim(len(rows) - 0.4, -0.6)
    panel.axvline(0.0, color=INK, linewidth=0.8, zorder=4)
    panel.axhline(sum(row["term"] not in SUMS for row in rows) - 0.5, color=MUTED, linewidth=0.6)
    panel.grid(visible=False, axis="y")
    panel.tick_params(axis="y", length=0)


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
        for place, rule in enumerate(RULES):
            r = radius(rule, section, angle)
            look: Style = {"color": f"C{place - 1}", "linewidth": 1.1}
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
        place, title = groups.index(name), f"{label}, {name}" if name else label
        style: Style = {"color": request.looks[label].color, "markersize": 4.0, "linewidth": 1.1}
        style["marker"] = _MARKERS[place % len(_MARKERS)]
        panel.plot(xs, ys, linestyle="--" if place else "-", label=title, **style)
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
