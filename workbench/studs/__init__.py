"""Shear studs: tests, resistance, load-slip laws, residual capacity, and fits with uncertainty.

The mechanical model is in `workbench.studs.mechanical`, which needs the compiled kernels.
"""

from workbench.studs.factors import fit_factors
from workbench.studs.load_slip import LAWS, BilinearLaw, OllgaardLaw, RationalLaw
from workbench.studs.load_slip_fit import fit_load_slip
from workbench.studs.quantities import summarise
from workbench.studs.reading import examine, read_points, read_tests
from workbench.studs.relations import RELATIONS, MechanicalCurve
from workbench.studs.residual import Grade, ResidualFit, fit_residual
from workbench.studs.schema import POINTS, TESTS
from workbench.studs.series import evaluate_groups, evaluate_series, evaluate_table
from workbench.studs.shear import SHEAR_MODELS, Deck, design_resistance, shear_model
from workbench.studs.statistics.annex_d import evaluate_d8
from workbench.studs.stiffness import UnloadingLaw, unloadings
from workbench.studs.strength import StrengthFit, fit_strength
from workbench.studs.tables import check_tables, shipped
from workbench.studs.tension import INTERACTIONS

__all__ = [
    "INTERACTIONS",
    "LAWS",
    "POINTS",
    "RELATIONS",
    "SHEAR_MODELS",
    "TESTS",
    "BilinearLaw",
    "Deck",
    "Grade",
    "MechanicalCurve",
    "OllgaardLaw",
    "RationalLaw",
    "ResidualFit",
    "StrengthFit",
    "UnloadingLaw",
    "check_tables",
    "design_resistance",
    "evaluate_d8",
    "evaluate_groups",
    "evaluate_series",
    "evaluate_table",
    "examine",
    "fit_factors",
    "fit_load_slip",
    "fit_residual",
    "fit_strength",
    "read_points",
    "read_tests",
    "shear_model",
    "shipped",
    "summarise",
    "unloadings",
]
