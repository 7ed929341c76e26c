"""Draws the figures of docs/theory/integrators.md: `python docs/theory/figures/integrators.py`."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from workbench.extras.laboratory.complementarity import Restitution
from workbench.extras.laboratory.schemes import scheme
from workbench.extras.laboratory.system import springs
from workbench.extras.laboratory.systems import run
from workbench.report.drawing.style import GRID, INK, MUTED, PALETTE, house_style, new_figure
from workbench.report.gallery import to_svg

BLUE, RED = PALETTE[:2]


def corner(panel: Axes, title: str, across: str, up: str, shift: float = 0.0) -> None:
    """A complementarity condition: on one axis or on the other, never both."""
    panel.axis("off")
    panel.set_xlim(-0.75, 1.35)
    panel.set_ylim(-0.4, 1.5)
    for tip in ((1.3, 0.0), (0.0, 1.25)):
        panel.annotate("", tip, (-0.7 * tip[0] / 1.3, -0.15 * tip[1]), arrowprops=ARROW)
    panel.plot([shift, shift, 1.2], [1.15, 0.0, 0.0], color=BLUE, linewidth=2.4)
    panel.text(1.3, -0.06, across, ha="right", va="top")
    panel.text(0.0, 1.3, up, ha="center", va="bottom")
    panel.set_title(title, fontsize=8.5, color=INK)


ARROW = {"arrowstyle": "-|>", "color": MUTED, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}


def chain() -> str:
    """From Signorini's condition to the problem of one step."""
    canvas = new_figure(2.0)
    place, speed, impact, step = canvas.subplots(1, 4)
    corner(place, "Signorini: place", "gap g", "force λ")
    place.text(0.1, 0.55, "touching,\npushing", color=BLUE)
    place.text(0.42, 0.1, "apart, no force", color=BLUE)
    corner(speed, "while g = 0: its velocity", "γ = dg/dt", "force λ")
    speed.text(0.1, 0.55, "stays", color=BLUE)
    speed.text(0.42, 0.1, "leaves", color=BLUE)
    corner(impact, "impact: Newton's law", "γ⁺", "impulse P", 0.45)
    impact.text(0.45, -0.06, "−e γ⁻", ha="center", va="top")
    impact.text(0.52, 0.6, "rebound", color=BLUE)
    corner(step, "a step: w = G P + b", "w", "impulse P")
    w = np.array([-0.6, 0.4])
    step.plot(w, (w + 0.6) / 0.9, color=RED, linewidth=1.4)
    step.plot([0.0], [0.6 / 0.9], "o", color=INK, markersize=5)
    step.text(-0.62, -0.08, "b < 0", color=RED, va="top")
    step.text(0.1, 0.6, "solution", color=INK)
    return to_svg(canvas, "chain")


def newmark() -> str:
    """Energy after one impact over that before: derived, and measured with the integrator."""
    canvas = new_figure(2.4, 4.4)
    panel = canvas.subplots()
    s = np.linspace(0.0, 1.0, 301)
    factor = np.where(s < 2.0 / 3.0, (3.0 - 4.0 * s) ** 2, (8.0 * s - 5.0) ** 2)
    panel.plot(s, factor, color=BLUE, label="derived")
    at = np.linspace(0.03, 0.97, 25)
    measured = []
    for share in at:  # the wall is met this share of a step after the first one
        mass = springs([1.0], contacts=[{0: 1.0}], gaps=[0.0])
        start = ([0.1 * (1.0 + share)], [-1.0])
        found = run(scheme("newmark").stepper, mass, Restitution(1.0), start, 1.0, 0.1)
        measured.append(found.v[-1, 0] ** 2)
    panel.plot(at, measured, "o", color=RED, markersize=3.5, label="integrator")
    panel.axhline(1.0, color=MUTED, linewidth=0.8, linestyle="--")
    panel.text(0.03, 0.85, "kept", color=MUTED, va="top")
    panel.set_xlabel("place of the wall in its step, s")
    panel.set_ylabel("energy after over before")
    panel.grid(color=GRID, linewidth=0.5)
    panel.legend(frameon=False)
    return to_svg(canvas, "newmark")


FIGURES = {"impact-chain.svg": chain, "impact-newmark.svg": newmark}

if __name__ == "__main__":
    for name, draw in FIGURES.items():
        with house_style():
            (Path(__file__).parent / name).write_text(draw(), encoding="utf-8")
