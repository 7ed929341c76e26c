"""The figures of a report, one module per kind."""

from __future__ import annotations

import importlib
from collections.abc import Callable

from workbench.report.figures.drawing import Drawing, Request, nothing
from workbench.report.figures.style import house_style, settle
from workbench.report.kinds import KINDS, check_kind


def draw(request: Request) -> Drawing:
    """Draw a figure in the house style. Raises `InputError` for an unknown kind."""
    kind = request.figure.kind
    check_kind(kind)
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
