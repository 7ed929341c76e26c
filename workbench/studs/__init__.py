"""Shear studs: tests, resistance, load-slip laws, residual capacity, and fits with uncertainty.

The mechanical model is in `workbench.studs.mechanical`, which needs the compiled kernels.
"""

from workbench.studs.damaged import Grade as Grade
from workbench.studs.formulas import SHEAR_MODELS as SHEAR_MODELS
from workbench.studs.formulas import fit_factors as fit_factors
from workbench.studs.formulas import strength_formula as strength_formula
from workbench.studs.interaction import INTERACTIONS as INTERACTIONS
from workbench.studs.load_slip import LAWS as LAWS
from workbench.studs.load_slip import BilinearLaw as BilinearLaw
from workbench.studs.load_slip import OllgaardLaw as OllgaardLaw
from workbench.studs.load_slip import RationalLaw as RationalLaw
from workbench.studs.load_slip_fit import fit_load_slip as fit_load_slip
from workbench.studs.reading import examine as examine
from workbench.studs.reading import read_tests as read_tests
from workbench.studs.relations import RELATIONS as RELATIONS
from workbench.studs.relations import MechanicalCurve as MechanicalCurve
from workbench.studs.residual_fit import ResidualFit as ResidualFit
from workbench.studs.residual_fit import fit_residual as fit_residual
from workbench.studs.schema import POINTS as POINTS
from workbench.studs.schema import TESTS as TESTS
from workbench.studs.series import evaluate_groups as evaluate_groups
from workbench.studs.series import evaluate_series as evaluate_series
from workbench.studs.statistics.annex_d import evaluate_d8 as evaluate_d8
from workbench.studs.strength_fit import StrengthFit as StrengthFit
from workbench.studs.strength_fit import fit_strength as fit_strength
from workbench.studs.tables import check_tables as check_tables
from workbench.studs.tables import shipped as shipped
