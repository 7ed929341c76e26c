"""Studies: cases answered by models, the runner, the result store, the assessment of it.

The names below come in with their first use, so that a part imports without the rest; the package
itself imports from the modules.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from workbench.study.assessment.gates import Gate as Gate
    from workbench.study.assessment.variations import Budget as Budget
    from workbench.study.assessor import Assessment as Assessment
    from workbench.study.assessor import assess as assess
    from workbench.study.cells import CellProgress as CellProgress
    from workbench.study.cells import CellStatus as CellStatus
    from workbench.study.cells import cells_of as cells_of
    from workbench.study.cells import gather as gather
    from workbench.study.cells import survey as survey
    from workbench.study.definition import Case as Case
    from workbench.study.definition import Figure as Figure
    from workbench.study.definition import Study as Study
    from workbench.study.runner import RunSummary as RunSummary
    from workbench.study.runner import run_study as run_study
    from workbench.study.store import Store as Store
    from workbench.study.store import load_study as load_study

_PUBLIC = {  # module: names that it gives
    "assessor": ("Assessment", "assess"),
    "assessment.gates": ("Gate",),
    "assessment.variations": ("Budget",),
    "cells": ("CellProgress", "CellStatus", "cells_of", "gather", "survey"),
    "definition": ("Case", "Figure", "Study"),
    "runner": ("RunSummary", "run_study"),
    "store": ("Store", "load_study"),
}
_MODULES = {name: module for module, names in _PUBLIC.items() for name in names}
__all__ = [*_MODULES]


def __getattr__(name: str) -> Any:
    """A public name, from its module, which is imported now."""
    if name not in _MODULES:
        raise AttributeError(f"module 'workbench.study' has no attribute {name!r}")
    value = getattr(import_module(f"workbench.study.{_MODULES[name]}"), name)
    globals()[name] = value
    return value
