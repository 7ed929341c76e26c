"""Laws of studs with the tests behind them: load and slip, what is left, tension with shear.

Options: `cases`. Of load-slip curves the first case with answers counts; of what is left after
damage each case is a row, and every panel carries the grade of its evidence.
"""

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from workbench.content.formatting import number, percent
from workbench.report.drawing import studs
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import (
    INK,
    PALETTE,
    WARNING,
    Style,
    entry,
    framed,
    numbered,
)
from workbench.studs.fit_protocol import Tables
from workbench.studs.interaction import INTERACTIONS

_LARGEST_SLIP = 10.0  # mm
_LAW = PALETTE[0]
# no lines: some curves have nothing between half of the load and the peak
_FITTED: Style = {"color": "#8a8a8a", "linestyle": "none", "marker": ".", "markersize": 3.0}
_FEW = 5


def curves(request: Request) -> Drawing:
    """One panel per law: median, band, fitted curves in grey, unseen ones in colour."""
    answers = {label: tables for _, label, tables in studs.answered(request, "grid", "median")}
    if not answers:
        return nothing("No load-slip law has answered these cases.")
    return curves_of(answers)


def curves_of(answers: Mapping[str, Tables]) -> Drawing:
    """The tables of laws by their labels; all are drawn over the points of the first."""
    points = next(iter(answers.values()))["points"]
    fitted, unseen = (_curves(points[points["unseen"] == new]) for new in (False, True))
    # the colour of the law is not used again
    campaigns = dict.fromkeys(campaign for campaign, _ in unseen)
    looks = {name: numbered(i + 1) for i, name in enumerate(campaigns)}
    styles = {
        name: look.curve(linestyle="-", linewidth=0.8, marker=look.marker, markersize=2.4)
        for name, look in looks.items()
    }
    sheet = Sheet.grid(len(answers), height=2.35, sharex=True)
    for panel, (label, tables) in zip(sheet.panels, answers.items(), strict=True):
        for curve in fitted.values():
            panel.plot(curve["slip_mm"], curve["load"], **_FITTED, zorder=2)
        for (campaign, _), curve in unseen.items():
            panel.plot(curve["slip_mm"], curve["load"], **{**styles[campaign], "zorder": 3.5})
        grid = tables["grid"]
        law = grid.assign(slip=studs.MILLI * grid["slip"])
        studs.draw_band(panel, law, "slip", "median", _LAW)
        drawn = grid[[name for name in ("median", "low", "high") if name in grid]]
        sheet.record(label=label, slip_m=grid["slip"], **drawn)
        sheet.name(panel, label, "slip (mm)", "load over largest load")
        panel.set(xlim=(0.0, _LARGEST_SLIP), ylim=(0.0, 1.12))
        sheet.notes.append(_curves_sentence(label, tables))
    few = sum(len(curve) < _FEW for curve in fitted.values())
    if few:
        sheet.notes.append(
            f"{few} of the {len(fitted)} fitted curves have fewer than {_FEW} points, with none "
            "between half of the load and the peak: they hardly tell the shape there."
        )
    for kind, group in (("fitted", fitted), ("unseen", unseen)):
        for curve in group.values():
            values = {"slip_m": curve["slip"], "median": curve["load"]}
            sheet.record(label=kind, **curve[["campaign", "specimen"]], **values)
    sheet.legend(
        *studs.band_entries(_LAW, "median of the law", "90 % band of a further curve"),
        entry(f"{len(fitted)} fitted curves", **_FITTED),
        *(entry(f"{campaign}, unseen", **style) for campaign, style in styles.items()),
    )
    return sheet.finish(f"load over largest load against slip for {', '.join(answers)}")


def _curves(points: pd.DataFrame) -> dict[Any, pd.DataFrame]:
    """Points of every specimen that has several, rising in slip, loads over the largest."""
    if points.empty:
        return {}
    points = points.assign(slip_mm=studs.MILLI * points["slip"])
    groups = points.groupby(["campaign", "specimen"], sort=False)
    return {
        key: curve.assign(load=curve["load"] / curve["load"].max()).sort_values(
            "slip", kind="stable"
        )
        for key, curve in groups
        if len(curve) > 1 and curve["load"].max() > 0.0
    }


def _curves_sentence(label: str, tables: Tables) -> str:
    fit, text = tables["fit"].iloc[0], f"{label}: no fit"
    if "curves" in fit:
        misfit = number(fit["median_rms"], 2)
        text = f"{label}: {fit['curves']} curves fitted, median misfit {misfit}"
    if "judgement" in tables:
        judged = tables["judgement"].iloc[0]
        misfit = number(judged["median_rms"], 2)
        text += f"; on {judged['curves']} unseen curves misfit {misfit}"
        if pd.notna(judged["coverage"]):
            text += f", {percent(judged['coverage'], signed=False)} of their points in the band"
        if pd.notna(ratio := judged["stiffness_test_over_prediction"]):
            text += f", stiffness {number(ratio, 3)} times the predicted one"
    return f"{text}."


# -- what is left after damage --------------------------------------------------------------------

# validated by tests of several campaigns or not
_COLORS = {True: "#009e73", False: "#d55e00"}
# tests or a prediction behind it
_BANDS = {True: "band of a new test", False: "range over what is assumed"}
_NONE = pd.DataFrame(columns=["campaign"])
AXES = {
    "displacement ratio": "uplift over the uplift at failure",
    "load ratio": "tension over the pull-out resistance",
    "life fraction": "share of the fatigue life",
    "S-N life fraction": "share of the fatigue life by EN 1994-1-1",
    "section loss": "share of the section lost",
}


def left(request: Request) -> Drawing:
    """A panel per quantity and measure of damage; every panel carries its grade."""
    answers = list(studs.answered(request, "curve", "left"))
    if not answers:
        return nothing("No residual capacity has been answered in these cases.")
    return _left_drawn([(case.name, label, tables) for case, label, tables in answers])


def left_of(answers: Mapping[str, Tables]) -> Drawing:
    """The tables of answers: a row for every quantity, a column for every stud."""
    fits = {name: tables["fit"].iloc[0] for name, tables in answers.items()}
    studs_of = {
        n: fit["stud"] or f"{fit['predamage']}, {fit['measure']}" for n, fit in fits.items()
    }
    return _left_drawn(
        [(fits[n]["quantity"], studs_of[n], tables) for n, tables in answers.items()]
    )


def _left_drawn(answers: Sequence[tuple[str, str, Tables]]) -> Drawing:
    """A row for each case and a column for each label, of which the tables are given."""
    cases = list(dict.fromkeys(case for case, _, _ in answers))
    labels = list(dict.fromkeys(label for _, label, _ in answers))
    sheet = Sheet.table(len(cases), len(labels), 2.55 * len(cases) + 0.6, sharey="row")
    tests = [tables.get("tests", _NONE) for _, _, tables in answers]
    looks = studs.campaign_looks(pd.concat(tests)["campaign"], filled=True)
    for case, label, tables in answers:
        place = cases.index(case) * len(labels) + labels.index(label)
        panel, fit = sheet.panels[place], tables["fit"].iloc[0]
        sheet.record(case=case, label=label, **_left_panel(panel, fit, tables["curve"]))
        studs.draw_tests(panel, tables.get("tests", _NONE), "level", "ratio", looks)
        panel.set_xlabel(AXES.get(fit["measure"], f"damage ({fit['measure']})"))
        if case == cases[0]:
            panel.set_title(label, loc="left")
        if label == labels[0]:
            panel.set_ylabel(f"{fit['quantity']} left")
        sentence = _left_sentence(fit, tables["curve"])
        sheet.notes += [] if sentence in sheet.notes else [sentence]
    for panel in sheet.panels:
        if not panel.lines:
            panel.remove()
    fits = [(tables["fit"].iloc[0], tables["curve"]) for _, _, tables in answers]
    for fit, curve in sorted(fits, key=lambda each: not each[0]["validated"]):
        names = "what is left", _BANDS[bool(fit["tests"])]
        entries = studs.band_entries(_COLORS[bool(fit["validated"])], *names)
        sheet.legend(*entries[: 2 if curve["low"].notna().any() else 1])
    sheet.legend(*studs.test_entries(looks, "tests"))
    return sheet.finish(f"residual capacity of a stud against damage: {', '.join(cases)}")


def _left_panel(panel: Axes, fit: pd.Series, curve: pd.DataFrame) -> dict[str, Any]:
    """The curve with its band and its grade; returns what was drawn."""
    color, tested = _COLORS[bool(fit["validated"])], curve[~curve["extrapolated"].astype(bool)]
    beyond = curve[curve["level"] >= tested["level"].max()]
    studs.draw_band(panel, tested, "level", "left", color)
    if len(beyond) > 1:
        panel.plot(beyond["level"], beyond["left"], color=color, linestyle=":")
        panel.axvline(float(tested["level"].max()), color=INK, linewidth=0.5, linestyle="--")
    panel.axhline(1.0, color=INK, linewidth=0.6, zorder=2)
    panel.set(xlim=(0.0, float(curve["level"].max())), ylim=(0.0, 1.25))
    grade = "\n".join(textwrap.wrap(fit["grade"], 44, break_on_hyphens=False))
    framed(panel, 0.03, 0.05, grade, color, fontsize=7.0, fontweight="bold")
    return {name: curve[name] for name in ("level", "left", "low", "high")}


def _left_sentence(fit: pd.Series, curve: pd.DataFrame) -> str:
    last = curve[curve["left"].notna() & ~curve["extrapolated"].astype(bool)].iloc[-1]
    text = f"{fit['quantity'].capitalize()} by {fit['measure']}: {last['left']:.2f} left"
    text += f" at level {last['level']:g}"
    if pd.notna(last["low"]):
        text += f" (from {last['low']:.2f} to {last['high']:.2f})"
    return f"{text}, stud {fit['stud']}; {fit['grade']}."


# -- tension and shear together -------------------------------------------------------------------

Curve = tuple[str, Style, pd.DataFrame]  # label, how it is drawn, tension and shear


def interaction(request: Request) -> Drawing:
    """Tension across, shear up, both over what the stud bears alone."""
    answers = list(studs.answered(request, "curve", "tension"))
    if not answers:
        return nothing("No interaction of tension and shear has answered these cases.")
    curves, statements = [], []
    for _, label, tables in answers:
        law, stud = tables["fit"].iloc[0][["law", "stud"]]
        style = _law_style(law, 1.2)
        if law not in INTERACTIONS:
            look = request.looks[label]
            style = {"color": look.color, "linestyle": "-", "marker": look.marker}
            style |= {"linewidth": 1.2, "markersize": 4.5, "zorder": 3}
            statements.append(f"{label}: stud {stud}.")
        curves.append((label, style, tables["curve"]))
    tests = (tables["tests"] for _, _, tables in answers if "tests" in tables)
    return _interaction_drawn(curves, next(tests, pd.DataFrame()), statements)


def interaction_of(answers: Mapping[str, Tables]) -> Drawing:
    """A fitted law with its tests, and the laws of the codes."""
    (tables,) = answers.values()
    style: Style = {"color": PALETTE[0], "linewidth": 1.8, "zorder": 3}
    curves = [("fitted", style, tables["curve"])]
    for name in INTERACTIONS:
        law = tables["curve"].assign(shear=tables["curve"][name])
        curves.append((name, _law_style(name, 1.0), law))
    return _interaction_drawn(curves, tables["tests"])


def _law_style(law: str, width: float) -> Style:
    line = INTERACTIONS[law].line if law in INTERACTIONS else "-"
    return {"color": INK, "linestyle": line, "linewidth": width}


def _interaction_drawn(
    curves: list[Curve], tests: pd.DataFrame, statements: Iterable[str] = ()
) -> Drawing:
    sheet = Sheet.table(1, 1, 3.7)
    sheet.notes += statements
    panel = sheet.panel
    for label, style, curve in curves:
        panel.plot(curve["tension"], curve["shear"], **style)
        sheet.legend(entry(label, **style))
        sheet.record(label=label, tension_ratio=curve["tension"], shear_ratio=curve["shear"])
    if tests.empty:
        words = "no combined test in the tables:\nnothing here is validated"
        framed(panel, 0.06, 0.06, words, WARNING, fontsize=8.0)
        sheet.notes.append("No test combines tension and shear: the curves are not validated.")
    else:
        looks = studs.campaign_looks(tests["campaign"], filled=True)
        studs.draw_tests(panel, tests, "tension", "shear", looks)
        sheet.legend(*studs.test_entries(looks, "tests"))
        ratios = {"tension_ratio": tests["tension"], "shear_ratio": tests["shear"]}
        sheet.record(label=tests["campaign"], **ratios)
    panel.set(xlim=(0.0, 1.08), ylim=(0.0, 1.08))
    panel.set_aspect("equal")
    sheet.name(panel, "", "tension over pull-out resistance", "shear over shear resistance")
    names = ", ".join(label for label, *_ in curves)
    return sheet.finish(f"interaction of tension and shear by {names}", beside="upper", width=0.9)
