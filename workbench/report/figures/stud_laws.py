"""Laws of studs with the tests behind them: load and slip, what is left, tension with shear.

Of a study, or of the tables of fits by their names. Options: `cases`. Of load-slip curves the first
case with answers counts; of what is left after damage each case is a row, and every panel carries
the grade of its evidence.
"""

import textwrap
from typing import Any

import pandas as pd
from matplotlib.axes import Axes

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
from workbench.report.page.formatting import number, percent
from workbench.studs.fit_protocol import Tables
from workbench.studs.interaction import INTERACTIONS

_LARGEST_SLIP = 10.0  # mm
_LAW = PALETTE[0]
# no lines: some curves have nothing between half of the load and the peak
_FITTED: Style = {"color": "#8a8a8a", "linestyle": "none", "marker": ".", "markersize": 3.0}
_FEW = 5


def curves(source: studs.Source) -> Drawing:
    """One panel per law: median, band, fitted curves in grey, unseen ones in colour.

    All are drawn over the points of the first.
    """
    answers = {label: tables for _, label, tables in studs.answered(source, "grid", "median")}
    if not answers:
        return nothing("No load-slip law has answered these cases.")
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
_ABREAST, _ROW = 2, 2.45  # panels side by side that leave room for grades; inches of a row
_LETTERS = 76  # of titles and grades across the page
AXES = {
    "displacement ratio": "uplift over the uplift at failure",
    "load ratio": "tension over the pull-out resistance",
    "life fraction": "share of the fatigue life",
    "S-N life fraction": "share of the fatigue life by EN 1994-1-1",
    "section loss": "share of the section lost",
}


def left(source: studs.Source) -> Drawing:
    """A row for each case, or quantity of fits, and a column for each label, or stud of fits.

    Of more than two labels the panels follow each other, two abreast. Every one has its grade.
    """
    answers = []
    for case, label, tables in studs.answered(source, "curve", "left"):
        fit = tables["fit"].iloc[0]
        stud = fit["stud"] or f"{fit['predamage']}, {fit['measure']}"
        place = (case, label) if case else (fit["quantity"], stud)
        answers.append((*place, fit, tables))
    if not answers:
        return nothing("No residual capacity has been answered in these cases.")
    cases = list(dict.fromkeys(case for case, *_ in answers))
    labels = list(dict.fromkeys(label for _, label, *_ in answers))
    rows, columns = len(cases), len(labels)
    below = columns > _ABREAST >= rows
    if below:
        answers.sort(key=lambda answer: labels.index(answer[1]))
        rows, columns = -(-len(answers) // _ABREAST), _ABREAST
    count, shared = (len(answers), "none") if below else (rows * columns, "row")
    sheet = Sheet.table(rows, columns, _ROW * rows + 0.6, count=count, sharey=shared)
    letters = _LETTERS // columns
    tests = [tables.get("tests", _NONE) for *_, tables in answers]
    looks = studs.campaign_looks(pd.concat(tests)["campaign"], filled=True)
    for order, (case, label, fit, tables) in enumerate(answers):
        at = order if below else cases.index(case) * columns + labels.index(label)
        panel = sheet.panels[at]
        sheet.record(case=case, label=label, **_left_panel(panel, fit, tables["curve"], letters))
        studs.draw_tests(panel, tables.get("tests", _NONE), "level", "ratio", looks)
        panel.set_xlabel(AXES.get(fit["measure"], f"damage ({fit['measure']})"))
        if below or case == cases[0]:
            panel.set_title("\n".join(textwrap.wrap(label, letters)), loc="left")
        if below or label == labels[0]:
            panel.set_ylabel(f"{fit['quantity']} left")
        sentence = _left_sentence(fit, tables["curve"])
        sheet.notes += [] if sentence in sheet.notes else [sentence]
    for panel in sheet.panels:
        if not panel.lines:
            panel.remove()
    for *_, fit, tables in sorted(answers, key=lambda answer: not answer[2]["validated"]):
        names = "what is left", _BANDS[bool(fit["tests"])]
        entries = studs.band_entries(_COLORS[bool(fit["validated"])], *names)
        sheet.legend(*entries[: 2 if tables["curve"]["low"].notna().any() else 1])
    sheet.legend(*studs.test_entries(looks, "tests"))
    return sheet.finish(f"residual capacity of a stud against damage: {', '.join(cases)}")


def _left_panel(panel: Axes, fit: pd.Series, curve: pd.DataFrame, letters: int) -> dict[str, Any]:
    """The curve with its band and its grade in lines of so many letters; returns what was drawn."""
    color, tested = _COLORS[bool(fit["validated"])], curve[~curve["extrapolated"].astype(bool)]
    beyond = curve[curve["level"] >= tested["level"].max()]
    studs.draw_band(panel, tested, "level", "left", color)
    if len(beyond) > 1:
        panel.plot(beyond["level"], beyond["left"], color=color, linestyle=":")
        panel.axvline(float(tested["level"].max()), color=INK, linewidth=0.5, linestyle="--")
    panel.axhline(1.0, color=INK, linewidth=0.6, zorder=2)
    panel.set(xlim=(0.0, float(curve["level"].max())), ylim=(0.0, 1.25))
    grade = "\n".join(textwrap.wrap(fit["grade"], letters, break_on_hyphens=False))
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


def interaction(source: studs.Source) -> Drawing:
    """Tension across, shear up, both over what the stud bears alone; of a fit with the codes."""
    answers = list(studs.answered(source, "curve", "tension"))
    if not answers:
        return nothing("No interaction of tension and shear has answered these cases.")
    sheet = Sheet.table(1, 1, 3.7)
    panel, names = sheet.panel, []

    def draw(name: str, tension: pd.Series, shear: pd.Series, style: Style) -> None:
        panel.plot(tension, shear, **style)
        sheet.legend(entry(name, **style))
        sheet.record(label=name, tension_ratio=tension, shear_ratio=shear)
        names.append(name)

    def law_style(law: str, width: float) -> Style:
        return {"color": INK, "linestyle": INTERACTIONS[law].line, "linewidth": width}

    for _, label, tables in answers:
        fit, curve = tables["fit"].iloc[0], tables["curve"]
        if fit["law"] in INTERACTIONS:
            style = law_style(fit["law"], 1.2)
        elif isinstance(source, Request):
            look = source.looks[label]
            style = {"color": look.color, "linestyle": "-", "marker": look.marker}
            style |= {"linewidth": 1.2, "markersize": 4.5, "zorder": 3}
            sheet.notes.append(f"{label}: stud {fit['stud']}.")
        else:
            label, style = "fitted", {"color": PALETTE[0], "linewidth": 1.8, "zorder": 3}
        draw(label, curve["tension"], curve["shear"], style)
        for law in (law for law in INTERACTIONS if law in curve):
            draw(law, curve["tension"], curve[law], law_style(law, 1.0))
    tests = next((tables["tests"] for *_, tables in answers if "tests" in tables), pd.DataFrame())
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
    alt = f"interaction of tension and shear by {', '.join(names)}"
    return sheet.finish(alt, beside="upper", width=0.9)
