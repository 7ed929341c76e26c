"""The figures of a report: a module per kind, found by its file name, with ``draw(request)``.

The kinds are known without the libraries that draw them.
"""

from __future__ import annotations

import importlib
import pkgutil
from typing import TYPE_CHECKING

from workbench.fields import Choice

if TYPE_CHECKING:
    from workbench.report.drawing.sheet import Drawing, Request

KINDS = tuple(sorted(found.name.replace("_", "-") for found in pkgutil.iter_modules(__path__)))


def check_kind(kind: str) -> None:
    """Refuse a kind of figure that nothing draws. Raises `InputError`."""
    Choice(KINDS).check("figure.kind", kind)


def draw(request: Request) -> Drawing:
    """Draw a figure in the house style. Raises `InputError` for an unknown kind."""
    from workbench.report.drawing.sheet import drawn, nothing

    check_kind(request.figure.kind)
    if not request.cases:
        return nothing("No case of the study names this figure.")
    module = importlib.import_module(f"{__name__}.{request.figure.kind.replace('-', '_')}")
    return drawn(module.draw, request)
