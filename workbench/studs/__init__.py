"""Shear studs: tests, resistance, load-slip laws, residual capacity, and fits with uncertainty.

Questions with their options are in `workbench.studs.questions`, the mechanical model, which needs
the compiled kernels, in `workbench.studs.mechanical`. The names below come in with their first use,
so that a question can be declared before anything heavy is imported; the package itself imports
from the modules.
"""

from importlib import import_module
from typing import Any

_PUBLIC = {  # module: names that it gives
    "damaged": ("Grade",),
    "formulas": ("SHEAR_MODELS", "fit_factors", "strength_formula"),
    "interaction": ("INTERACTIONS",),
    "load_slip": ("LAWS", "BilinearLaw", "OllgaardLaw", "RationalLaw", "fit_load_slip"),
    "relations": ("RELATIONS", "MechanicalCurve", "ResidualFit", "fit_residual"),
    "schema": ("POINTS", "TESTS", "examine", "read_tests"),
    "series": ("evaluate_d8", "evaluate_groups", "evaluate_series"),
    "strength_fit": ("StrengthFit", "fit_strength"),
    "tables": ("check_tables", "shipped"),
}
_MODULES = {name: module for module, names in _PUBLIC.items() for name in names}
__all__ = [*_MODULES]


def __getattr__(name: str) -> Any:
    """A public name, from its module, which is imported now."""
    if name not in _MODULES:
        raise AttributeError(f"module 'workbench.studs' has no attribute {name!r}")
    value = getattr(import_module(f"workbench.studs.{_MODULES[name]}"), name)
    globals()[name] = value
    return value
