"""Tests on studs against what formulas and the mechanical stud predict.

Of a study, or of the tables of fits by their names. Options: `cases`; the first case that a label
answers counts, tests that its fit had not seen are filled.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from workbench.report.drawing import studs
from workbench.report.drawing.sheet import Array, Drawing, Request, Sheet, grid_shape, nothing
from workbench.report.drawing.style import (
    INK,
    MUTED,
    PALETTE,
    WARNING,
    Look,
    Style,
    entry,
    new_figure,
)
from workbench.report.page.formatting import number, percent
from workbench.studs.fit_protocol import Tables
from workbench.studs.model import tables_of

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
        response = request.stored.response(case.name, reference)
        tables = {} if response is None else tables_of(response)
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

_ROW, _EDGES = 0.17, 0.8  # inches: of a test, and of titles and axes
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
    most = int((_TALLEST / rows - _EDGES) / _ROW)
    shown = list(size.nlargest(most).index) if len(size) > most else list(size.index)
    height = rows * (_ROW * len(shown) + _EDGES)
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
