"""Draws the figures of theory pages, or those named: `python docs/theory/figures/theory.py`."""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure as Canvas
from statsmodels.stats.proportion import proportion_confint

import workbench as wb
from workbench.report.drawing.style import GRID, PALETTE, house_style, logarithmic, new_figure
from workbench.report.gallery import to_svg
from workbench.steel.materials import GRADES, MILD_STEEL
from workbench.study.error_model.error_table import COLUMNS, MARGIN, TRUTH

COLUMN = wb.Column(
    "HEB 220", 0.8, 3.2, fillets=False, axial_load="500 kN", restraint_stiffness="10 kN/mm"
)
HIT = wb.impact(COLUMN, mass=1500, velocity=15)


def drawn(answers: wb.Comparison, kind: str) -> Canvas:
    """A figure of reports from answers."""
    canvas = answers.plot.drawing(kind).canvas
    assert canvas is not None
    return canvas


def four_dof() -> Canvas:
    """Forces of the hinges on their surface."""
    return drawn(wb.compare(HIT, ["four-dof"], "four-dof"), "interaction")


def single_dof() -> Canvas:
    """Resistance of the pushed column under the assumptions of the thesis."""
    thesis = {"rotational_stiffness": 6.0}
    curves = {
        name: wb.make_model("single-dof", {**thesis, "resistance": name})
        for name in ("analytic", "cubic", "linear")
    }
    curves = {"four-dof": wb.make_model("four-dof", thesis), **curves}
    push = wb.ColumnPushover("push", COLUMN, 0.5)
    return drawn(wb.compare(push, curves, "four-dof"), "force-displacement")


def generalized_hinge() -> Canvas:
    """The exact envelope of the section and what stands for it."""
    return drawn(wb.compare(HIT, ["four-dof"], "four-dof"), "yield-surfaces")


def soft_impact() -> Canvas:
    """Striker and impact point, for a rigid striker and two that crush."""
    canvas = new_figure(2.5)
    speed, way = canvas.subplots(1, 2)
    fronts = {"rigid": None, "10 MN/m": 10e6, "2 MN/m": 2e6}
    for number, (name, stiffness) in enumerate(fronts.items()):
        hit = HIT.changed(striker=HIT.striker.changed(stiffness=stiffness))
        run = wb.simulate(hit, "single-dof")
        time = 1e3 * run["time"].to_numpy()
        speed.plot(time, run["striker_velocity"], color=PALETTE[number], label=name)
        way.plot(time, 1e3 * run["displacement"], color=PALETTE[number])
    for panel, words in ((speed, "velocity of the striker, m/s"), (way, "displacement, mm")):
        panel.set_xlabel("time, ms")
        panel.set_ylabel(words)
        panel.grid(color=GRID, linewidth=0.5)
    speed.legend(frameon=False, title="front of the striker")
    return canvas


def shear_panel() -> Canvas:
    """What shear leaves of the plastic moment."""
    return drawn(wb.compare(HIT, ["four-dof-shear"], "four-dof-shear"), "shear-surfaces")


def strain_rate() -> Canvas:
    """The law of the grades and of mild steel."""
    canvas = new_figure(2.7, 4.8)
    panel = canvas.subplots()
    rate = np.logspace(-3, 3, 49)
    laws = {"mild steel": MILD_STEEL} | {name: law for name, (_, law) in GRADES.items()}
    for number, (name, law) in enumerate(laws.items()):
        panel.plot(rate, [law.factor(r) for r in rate], color=PALETTE[number], label=name)
        if law.slow is not None and law.fast is not None:
            ends = [1.0 + (rate / end) ** (1.0 / law.exponent) for end in (law.fast, law.slow)]
            panel.fill_between(rate, *ends, color=PALETTE[number], alpha=0.12, linewidth=0)
    panel.set_xscale("log")
    logarithmic(panel.xaxis, "{:g}".format)
    panel.set_xlabel("strain rate, 1/s")
    panel.set_ylabel("yield stress over the static one")
    panel.grid(color=GRID, linewidth=0.5)
    panel.legend(frameon=False)
    return canvas


def superelements() -> Canvas:
    """Shapes of a struck portal."""
    frame = wb.regular_frame((6.0,), (4.0,), "HEB 220", "IPE 300", base="clamped")
    hit = wb.impact(frame.split("A0-A1", 0.8, "hit"), 1500, 8, node="hit", direction="+x")
    models = ["flexible-superelement", "rigid-superelement"]
    return drawn(wb.compare(hit, models, models[0]), "deformed")


def error_model() -> Canvas:
    """Peaks over the velocity, with the interval of the truth; collapses close to one."""
    canvas = new_figure(2.7, 7.0)
    panel, near = canvas.subplots(1, 2)
    speeds = np.arange(4.0, 20.1, 2.0)
    for number, name in enumerate(("flexible-superelement", "four-dof")):
        runs = [wb.simulate(HIT.at_velocity(float(v)), name).workbench for v in speeds]
        peaks = np.array([run.number("peak_displacement") for run in runs])
        panel.plot(speeds, 1e3 * peaks, color=PALETTE[number], label=name)
        if number == 0:
            ends = np.array([[run.error.low, run.error.high] for run in runs], float)
            band = 1e3 * peaks[:, None] / (1.0 + ends)
            panel.fill_between(speeds, *band.T, color=PALETTE[2], alpha=0.2, label="truth, 90 %")
    panel.set_xlabel("velocity, m/s")
    panel.set_ylabel("peak displacement, mm")
    rows = COLUMNS.rows[COLUMNS.rows[TRUTH].notna() & (COLUMNS.rows[MARGIN] > 0.0)]
    edges = np.array([0.8, 0.85, 0.9, 0.95, 1.0, 1.05, 1.1, 1.25])
    fallen = np.isinf(rows[TRUTH]).groupby(np.digitize(rows[MARGIN], edges))
    share, count = fallen.mean().to_numpy(), fallen.size().to_numpy()
    middles = 0.5 * (edges[1:] + edges[:-1])[fallen.mean().index - 1]
    ends = proportion_confint(share * count, count, 0.1, "beta")
    sides = np.abs(np.array(ends) - share)
    near.errorbar(middles, share, sides, fmt="o", color=PALETTE[0], label="drawn columns, 90 %")
    margins = np.linspace(0.8, 1.25, 181)
    stated = [COLUMNS.collapses(margin >= 1.0, {MARGIN: margin}) for margin in margins]
    near.plot(margins, stated, color=PALETTE[1], label="stated")
    near.set_xlabel("velocity over that of a collapse of the anchor")
    near.set_ylabel("share that collapses")
    for each in (panel, near):
        each.grid(color=GRID, linewidth=0.5)
        each.legend(frameon=False)
    return canvas


FIGURES: dict[str, Callable[[], Canvas]] = {
    "four-dof": four_dof,
    "single-dof": single_dof,
    "strain-rate": strain_rate,
    "superelements": superelements,
    "shear-panel": shear_panel,
    "error-model": error_model,
    "generalized-hinge": generalized_hinge,
    "soft-impact": soft_impact,
}

if __name__ == "__main__":
    for page in sys.argv[1:] or FIGURES:
        with house_style():
            text = to_svg(FIGURES[page](), page)
        Path(__file__).with_name(f"{page}.svg").write_text(text, encoding="utf-8")
