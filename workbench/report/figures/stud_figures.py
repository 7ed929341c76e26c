"""Laws of studs with the tests behind them: load and slip, what is left, tension with shear.

Of a study, or of the tables of fits by their names. Options: `cases`. Of load-slip curves the first
case with answers counts; of what is left after damage each case is a row, and every panel carries
the grade of its evidence.

**Second part.** Tests on studs against what formulas and the mechanical stud predict.

Of a study, or of the tables of fits by their names. Options: `cases`; the first case that a label
answers counts, tests that its fit had not seen are filled.

**Third part.** The mechanical stud as a picture, to scale, with its parameters and which were
calibrated.
"""

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Polygon, Rectangle
from matplotlib.ticker import MaxNLocator

from workbench.report.drawing import studs
from workbench.report.drawing.frame import LIGHT, arrow, spring
from workbench.report.drawing.sheet import Array, Drawing, Request, Sheet, grid_shape, nothing
from workbench.report.drawing.studs import answered
from workbench.report.drawing.style import (
    INK,
    MUTED,
    PALETTE,
    WARNING,
    Look,
    Style,
    entry,
    framed,
    new_figure,
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


_NAMED_BELOW = 0.85  # of the prediction: such a test is named


def scatter(source: studs.Source) -> Drawing:
    """Measured strength up, predicted strength across; below the line a prediction is unsafe."""
    first: dict[str, Tables] = {}
    for column in ("bias", "basis"):
        for _, label, tables in studs.answered(source, "fit", column):
            first.setdefault(label, tables)
    if not first:
        return nothing("No formula of shear strength has answered these cases.")
    labels = source.labels if isinstance(source, Request) else source
    answers = {label: first[label] for label in labels if label in first}
    tests = pd.concat([studs.judged_tests(*each) for each in answers.items()])
    tests = tests.drop(columns="ratio")
    looks = studs.campaign_looks(tests["campaign"])
    top = 1.06 * studs.KILO * float(np.max(tests[["test", "prediction"]].to_numpy(float)))
    sheet = Sheet.grid(len(answers), height=2.45, sharex=True)
    for panel, (label, tables) in zip(sheet.panels, answers.items(), strict=True):
        rows = tests[tests["label"] == label]
        _scatter_panel(panel, rows, looks, top)
        sheet.name(panel, label, "prediction (kN per stud)", "test (kN per stud)")
        note, text = _scatter_summary(label, tables)
        panel.text(0.96, 0.13, note, transform=panel.transAxes, ha="right", fontsize=7.0)
        sheet.notes.append(text)
        sheet.record(rows.rename(columns={"prediction": "prediction_N", "test": "test_N"}))
    new = set(tests.loc[tests["unseen"], "campaign"])
    unseen = {name: look._replace(filled=True) for name, look in looks.items() if name in new}
    sheet.legend(*studs.test_entries(looks, "fitted"), *studs.test_entries(unseen, "unseen"))
    sheet.legend(*studs.diagonal_entries("test = prediction"))
    names = ", ".join(answers)
    return sheet.finish(f"measured against predicted strength of push-outs for {names}")


def _scatter_panel(panel: Axes, tests: pd.DataFrame, looks: dict[str, Look], top: float) -> None:
    panel.fill_between([0.0, top], [0.0, top], 0.0, color=PALETTE[1], alpha=0.06, linewidth=0.0)
    studs.draw_diagonal(panel, top)
    shown = tests.assign(**studs.KILO * tests[["test", "prediction"]])
    studs.draw_tests(panel, shown, "prediction", "test", looks)
    worst = shown.iloc[int((shown["test"] / shown["prediction"]).argmin())]
    if worst["test"] < _NAMED_BELOW * worst["prediction"]:
        at = worst["prediction"], worst["test"]
        below: Style = {"textcoords": "offset points", "ha": "center", "va": "top", "fontsize": 6.5}
        panel.annotate(worst["specimen"], at, (0, -5), **below, annotation_clip=True)
    panel.text(0.96 * top, 0.04 * top, "unsafe", color=WARNING, fontsize=7.0, ha="right")


def _scatter_summary(label: str, tables: Tables) -> tuple[str, str]:
    """Text in the panel, and the sentence below the figure."""
    fit = tables["fit"].iloc[0]
    if "bias" not in fit:
        scatter = number(fit["scatter_of_strength"], 2)
        text = f"{label}: calibrated on {fit['tests']} tests, scatter there {scatter}"
        if "judgement" in tables:
            least = tables["judgement"]["least_test_over_prediction"].iloc[0]
            text += f"; unseen tests from {number(least, 3)} of the prediction on"
        return f"scatter {scatter}", f"{text}."
    ends = (number(fit[f"bias_{end}"], 3) for end in ("low", "high"))
    span = " to ".join(ends) if pd.notna(fit[["bias_low", "bias_high"]]).all() else "interval open"
    median = number(fit["bias"], 3)
    return f"median {median}\n({span})", (
        f"{label}: median of test over prediction {median} ({span}), scatter "
        f"{number(fit['sigma'], 2)} within campaigns."
    )


# -- what a formula misses ------------------------------------------------------------------------

# variable of the rows: axis label, factor from SI
VARIABLES = {
    "diameter": ("diameter d (mm)", 1e3),
    "slenderness": ("height over diameter h/d", 1.0),
    "concrete_strength": ("concrete strength f_c (MPa)", 1e-6),
    "concrete_modulus": ("concrete modulus E_c (GPa)", 1e-9),
    "ultimate_strength": ("stud strength f_u (MPa)", 1e-6),
    "over_steel": ("test over A_s f_u", 1.0),
}
_FEW_VALUES = 4  # values of a variable below which a trend cannot be told
_TICKS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.4, 1.6, 2.0)


def residuals(source: studs.Source) -> Drawing:
    """One panel per variable, the ratio on a logarithmic scale, for the first of the formulas."""
    answer = next(studs.answered(source, "tests", "over_steel"), None)
    if answer is None:
        return nothing("No formula of shear strength has answered these cases.")
    case, label, tables = answer
    label, tests = f"{label}, case {case}" if case else label, tables["tests"]
    looks = studs.campaign_looks(tests["campaign"])
    sheet = Sheet.grid(len(VARIABLES), [f"{label}: {len(tests)} tests."], height=2.0)
    poor = []
    for panel, (name, (title, factor)) in zip(sheet.panels, VARIABLES.items(), strict=True):
        shown = tests.assign(value=factor * tests[name])
        studs.draw_tests(panel, shown, "value", "ratio", looks)
        _ratio_axes(panel, tests["ratio"].to_numpy(float))
        sheet.name(panel, "", title, "test over prediction")
        panel.set_xlabel(title)
        if shown["value"].nunique() < _FEW_VALUES:
            poor.append(title.partition(" (")[0])
        ratio = {"value_SI": tests[name], "test_over_prediction": tests["ratio"]}
        sheet.record(variable=name, **ratio, **tests[["campaign", "specimen"]])
    sheet.legend(*(entry(name, **look.points()) for name, look in looks.items()))
    if poor:
        sheet.notes.append(
            f"Too few different values to tell a trend: {', '.join(poor)}."
            + " What differs there is the campaign." * (len(looks) > 1)
        )
    sheet.notes.append(
        f"The strongest test bore {studs.KILO * tests['test'].max():.0f} kN per stud."
    )
    return sheet.finish(f"test over prediction of {label} against {', '.join(VARIABLES)}")


def _ratio_axes(panel: Axes, ratio: Array) -> None:
    panel.set_yscale("log")
    low, high = min(0.95 * np.nanmin(ratio), 0.9), max(1.05 * np.nanmax(ratio), 1.1)
    panel.set_ylim(low, high)
    panel.set_yticks([tick for tick in _TICKS if low <= tick <= high])
    panel.yaxis.set_major_formatter("{x:g}")
    panel.minorticks_off()
    panel.xaxis.set_major_locator(MaxNLocator(5))
    panel.axhline(1.0, color=INK, linewidth=0.9, zorder=1)
    panel.margins(x=0.12)
    panel.tick_params(colors=MUTED)


# -- where the mechanical stud fails --------------------------------------------------------------

_MOST = 3  # studs with a curve
_SPREAD = 0.22  # half of the width over which the tests of a campaign stand side by side
_PREDICTED: Style = {"color": INK, "linewidth": 1.5}
_COLLAR: Style = {"color": MUTED, "linewidth": 0.9, "linestyle": "--"}


def unseen(request: Request) -> Drawing:
    """Left the ratios of all tests, right one panel per unseen stud."""
    answers = studs.answered(request, "fit", "basis")
    judged = next(((label, tables) for _, label, tables in answers if "judged" in tables), None)
    if judged is None:
        return nothing("No mechanical prediction has been judged by unseen tests.")
    label, tables = judged
    curves = [curve for _, curve in tables["curves"].groupby(["campaign", "specimen"], sort=False)]
    curves, judgement = curves[:_MOST], tables["judgement"].iloc[0]
    canvas = new_figure(2.9)
    widths = [1.05, *[1.0] * len(curves)]
    sheet = Sheet(canvas, canvas.subplots(1, len(widths), width_ratios=widths, squeeze=False)[0])
    tests = studs.judged_tests(label, tables)[["campaign", "specimen", "ratio", "unseen"]]
    tests = tests.rename(columns={"ratio": "test_over_prediction"})
    looks = studs.campaign_looks(tests["campaign"])
    _ratios(sheet.panel, tests, list(looks), looks)
    sheet.record(tests)
    for panel, curve in zip(sheet.panels[1:], curves, strict=True):
        _push_out(sheet, panel, curve, _measured(request, curve), looks)
    sheet.notes += [
        f"{label}: {tables['fit']['basis'].iloc[0]}.",
        f"Of {judgement['tests']} unseen tests the worst, {judgement['worst']}, bore "
        f"{number(judgement['least_test_over_prediction'], 2)} of the prediction: cracking "
        "and splitting of the slab enter through the limit of EN 1994-1-1 (mean form) alone.",
    ]
    for i, (name, look) in enumerate(looks.items()):
        known = f"{name}, unseen" if i else f"{name}, calibration"
        sheet.legend(entry(known, **(look._replace(filled=True) if i else look).points()))
    sheet.legend(entry("predicted", **_PREDICTED))
    sheet.legend(entry("of it through the weld collar", **_COLLAR))
    alt = "test over prediction of the mechanical stud, and its load-slip curves for unseen studs"
    return sheet.finish(alt)


def _ratios(panel: Axes, tests: pd.DataFrame, names: list[str], looks: Mapping[str, Look]) -> None:
    size = tests.groupby("campaign")["campaign"].transform("size")
    place = tests.groupby("campaign").cumcount() / (size - 1).clip(lower=1)
    slots = tests["campaign"].map({name: i for i, name in enumerate(names)})
    tests = tests.assign(at=slots + _SPREAD * (2.0 * place - 1.0) * (size > 1))
    studs.draw_tests(panel, tests, "at", "test_over_prediction", looks)
    for row in tests[tests["unseen"]].itertuples():
        beside: Style = {"xytext": (6, -3), "textcoords": "offset points", "fontsize": 7.0}
        panel.annotate(str(row.specimen), (row.at, row.test_over_prediction), **beside)
    panel.axhline(1.0, color=INK, linewidth=0.9, zorder=1)
    panel.axhspan(0.0, 0.85, color=PALETTE[1], alpha=0.06, linewidth=0.0)
    panel.set_xticks(range(len(names)), names)
    panel.set_xlim(-0.5, len(names) - 0.5)
    values = tests["test_over_prediction"]
    panel.set_ylim(min(0.6, 0.92 * values.min()), 1.08 * values.max())
    panel.set_ylabel("test over prediction, strength")
    panel.grid(visible=False, axis="x")


def _measured(request: Request, curve: pd.DataFrame) -> pd.DataFrame:
    """The measured points of a stud, from the first case that has them."""
    campaign, specimen = curve[["campaign", "specimen"]].iloc[0]
    reference = request.study.reference
    for case in request.cases:
        tables = request.stored.answer_tables(case.name, reference)
        for part in ("calibration", "validation"):
            points = tables.get(part, pd.DataFrame())
            if "slip" in points:
                same = (points["campaign"] == campaign) & (points["specimen"] == specimen)
                if same.any():
                    return pd.DataFrame(points[same])
    return pd.DataFrame()


def _push_out(
    sheet: Sheet, panel: Axes, curve: pd.DataFrame, points: pd.DataFrame, looks: Mapping[str, Look]
) -> None:
    slip, load, collar = (curve[name].to_numpy(float) for name in ("slip", "load", "collar"))
    head = dict(curve[["campaign", "specimen"]].iloc[0])
    panel.plot(studs.MILLI * slip, studs.KILO * load, **_PREDICTED)
    panel.plot(studs.MILLI * slip, studs.KILO * collar, **_COLLAR)
    sheet.record(**head, curve="predicted", slip_m=slip, load_N=load)
    if len(points):
        look = looks[head["campaign"]]._replace(filled=True).points(markersize=3.2)
        panel.plot(studs.MILLI * points["slip"], studs.KILO * points["load"], **look)
        sheet.record(**head, curve="measured", slip_m=points["slip"], load_N=points["load"])
    sheet.name(panel, " ".join(head.values()), "", "load (kN per stud)")
    panel.set_xlabel("slip (mm)")
    panel.set_xlim(left=0.0)
    panel.set_ylim(bottom=0.0)


# -- how every test moves the answer of a fit ----------------------------------------------------

_TEST_ROW, _EDGES = 0.17, 0.8  # inches: of a test, and of titles and axes
_TALLEST = 7.2  # inches: with its caption the figure fits on a page
_REACH = 0.5  # percent that an axis reaches to either side
_DOTS: Style = {"linestyle": "none", "marker": "o", "markersize": 4.0}
_CHANGES = {False: ("as the others expect it", PALETTE[0]), True: ("an outlier", WARNING)}


def influence(tables: Mapping[str, pd.DataFrame]) -> Drawing:
    """How every test moves the answer of a fit: rows of `influence_of` by the titles of panels."""
    if not tables:
        return nothing("Too few tests: none can be left out.")
    changes = pd.concat([rows.assign(panel=title) for title, rows in tables.items()])
    names = changes["specimen"]
    if len(set(changes["campaign"])) > 1:
        names = changes["campaign"].str.cat(names, sep=" ")
    changes = changes.assign(
        change=changes["without"].astype(float) / changes["value"] - 1.0, name=names
    )
    size = changes["change"].abs().groupby(changes["name"], sort=False).max()
    rows, columns = grid_shape(len(tables), 2 if len(tables) < 5 else 3)
    most = int((_TALLEST / rows - _EDGES) / _TEST_ROW)
    shown = list(size.nlargest(most).index) if len(size) > most else list(size.index)
    height = rows * (_TEST_ROW * len(shown) + _EDGES)
    sheet = Sheet.table(rows, columns, height, count=len(tables), sharey=True)
    if len(shown) < len(size):
        sheet.notes.append(f"Shown are the {len(shown)} of {len(size)} tests that move it most.")
    for panel, title in zip(sheet.panels, tables, strict=True):
        panel_rows = changes[changes["panel"] == title]
        _influence_panel(panel, panel_rows[panel_rows["name"].isin(shown)], shown)
        sheet.name(panel, title, "change without the test (%)", "")
        worst = panel_rows.loc[
            panel_rows["change"].abs().fillna(0.0).to_numpy() == panel_rows["change"].abs().max()
        ]
        if len(worst):
            test, change = worst.iloc[0]["name"], percent(float(worst.iloc[0]["change"]))
            sheet.notes.append(f"{title}: {test} moves it most, by {change} when it is left out.")
    for far in sorted(set(changes["outlier"].astype(bool))):
        words, color = _CHANGES[far]
        sheet.legend(entry(words, color=color, **_DOTS))
    sheet.record(changes.drop(columns=["name", "change"]))
    return sheet.finish("change of the answer when a test is left out")


def _influence_panel(panel: Axes, rows: pd.DataFrame, shown: Sequence[str]) -> None:
    places = rows["name"].map({name: place for place, name in enumerate(shown)}).to_numpy(float)
    change = 100.0 * rows["change"].to_numpy(float)
    panel.hlines(places, 0.0, change, color=MUTED, linewidth=0.7)
    for far, (_, color) in _CHANGES.items():
        which = rows["outlier"].to_numpy(bool) == far
        panel.plot(change[which], places[which], color=color, **_DOTS)
    panel.axvline(0.0, color=INK, linewidth=0.8)
    panel.set_yticks(range(len(shown)), shown, fontsize=6.5)
    panel.set_ylim(len(shown) - 0.4, -0.6)
    reach = 1.15 * max(float(np.nanmax(np.abs(change), initial=0.0)), _REACH)
    panel.set_xlim(-reach, reach)


# proportions of the picture, in diameters
_HEIGHT, _HEAD, _HEAD_HEIGHT, _WELD_WIDTH, _COLLAR_HEIGHT = 5.3, 1.65, 0.5, 1.25, 0.27
_FLANGE, _WIDE, _SLAB, _CONE_REACH = 0.8, 5.4, 6.3, 3.9
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


def mechanical_model(request: Request) -> Drawing:
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
        (_WELD_WIDTH, 0.0, _COLLAR_HEIGHT),
    ):
        panel.add_patch(Rectangle((-0.5 * wide, low), wide, high, **_STEEL))
    cone = [
        (-0.5 * _HEAD, _UNDER),
        (-_CONE_REACH, 0.0),
        (_CONE_REACH, 0.0),
        (0.5 * _HEAD, _UNDER),
    ]
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
