"""Generalized elasto-plastic hinges with N-M, N-M-V and N-My-Mz yield surfaces."""

from workbench.steel.hinges.interaction import BiaxialSurface as BiaxialSurface
from workbench.steel.hinges.interaction import ShearSurface as ShearSurface
from workbench.steel.hinges.interaction import YieldSurface as YieldSurface
from workbench.steel.hinges.interaction import has_bar_law as has_bar_law
from workbench.steel.hinges.interaction import has_shear_surface as has_shear_surface
from workbench.steel.hinges.interaction import has_webs as has_webs
