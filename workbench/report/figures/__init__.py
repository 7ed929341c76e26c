"""The figures of a report: functions that draw a `Request`, by kind.

A new kind is one line here and its function, or an entry point. The kinds are known without the
libraries that draw.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import TYPE_CHECKING

from workbench.base.fields import Choice
from workbench.base.offered import companion, offered

if TYPE_CHECKING:
    from workbench.report.drawing.sheet import Drawing, Request

KINDS = {
    "budget": "values.budget",
    "chooser": "refinement.choices",
    "convergence": "refinement.convergence",
    "cost": "refinement.cost",
    "deformed": "deformed.draw",
    "domain-map": "refinement.domain_map",
    "energy": "curves.energy",
    "force-displacement": "curves.force_displacement",
    "history": "curves.history",
    "interaction": "curves.interaction_path",
    "meshes": "refinement.meshes",
    "peaks": "values.peaks",
    "shear-domain": "values.shear_domain",
    "shear-surfaces": "values.shear",
    "structure": "structure.draw",
    "stud-curves": "stud_figures.curves",
    "stud-guideline": "stud_figures.left",
    "stud-interaction": "stud_figures.interaction",
    "stud-model": "stud_figures.mechanical_model",
    "stud-residuals": "stud_figures.residuals",
    "stud-scatter": "stud_figures.scatter",
    "stud-unseen": "stud_figures.unseen",
    "sweep": "refinement.sweep",
    "tests": "values.tests",
    "work-precision": "refinement.work_precision",
    "yield-surfaces": "values.axial",
}


def check_kind(kind: str) -> None:
    """Refuse a kind of figure that nothing draws. Raises `InputError`."""
    if kind not in KINDS:
        others = tuple(point.name for point in offered("figures"))
        Choice((*KINDS, *others)).check("figure.kind", kind)


def plot_of(kind: str) -> Callable[..., Drawing]:
    """The function that draws a kind of figure. Raises `InputError` for an unknown one."""
    check_kind(kind)
    if kind not in KINDS:
        companion_plot: Callable[..., Drawing] = companion("figures", kind)
        return companion_plot
    module, name = KINDS[kind].split(".")
    plot: Callable[..., Drawing] = getattr(importlib.import_module(f"{__name__}.{module}"), name)
    return plot


def draw(request: Request) -> Drawing:
    """Draw a figure in the house style. Raises `InputError` for an unknown kind."""
    from workbench.report.drawing.sheet import drawn, nothing

    plot = plot_of(request.figure.kind)
    if not request.cases:
        return nothing("No case of the study names this figure.")
    return drawn(plot, request)
