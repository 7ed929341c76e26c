"""Generalized elasto-plastic hinges with N-M and N-M-V yield surfaces."""

from workbench.hinges.interaction import YieldSurface as YieldSurface
from workbench.hinges.panel import ShearSurface as ShearSurface
from workbench.hinges.panel import has_shear_surface as has_shear_surface
from workbench.hinges.panel import has_webs as has_webs
