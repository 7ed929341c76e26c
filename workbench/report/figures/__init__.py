"""The figures of a report, one module per kind."""

from __future__ import annotations

import importlib
from collections.abc import Callable

from workbench.errors import InputError
from workbench.report.figures.drawing import Drawing, Request, nothing
from workbench.report.figures.style import house_style, settle

# kind -> module; each has a function draw(request) -> Drawing
KINDS = {
    "structure": "structure",
    "deformed": "deformed",
    "animation": "animation",
    "history": "history",
    "force-displacement": "force_displacement",
    "peaks": "peaks",
    "interaction": "interaction",
    "energy": "energy",
    "convergence": "convergence",
    "meshes": "meshes",
    "cost": "cost",
    "sweep": "sweep",
    "shear-domain": "shear_domain",
    "stud-scatter": "stud_scatter",
    "stud-residuals": "stud_residuals",
    "stud-curves": "stud_curves",
    "stud-model": "stud_model",
    "stud-unseen": "stud_unseen",
    "stud-interaction": "stud_interaction",
    "stud-guideline": "stud_guideline",
}


def draw(request: Request) -> Drawing:
    """Draw a figure in the house style. Raises `InputError` for an unknown kind."""
    kind = request.figure.kind
    if kind not in KINDS:
        raise InputError("figure.kind", kind, "must be one of " + ", ".join(KINDS))
    if not request.cases:
        return nothing("No case of the study names this figure.")
    module = importlib.import_module(f"workbench.report.figures.{KINDS[kind]}")
    function: Callable[[Request], Drawing] = module.draw
    with house_style():
        drawing = function(request)
        if drawing.canvas is not None:
            settle(drawing.canvas)
    return drawing


__all__ = ["KINDS", "Drawing", "Request", "draw"]
