"""Generalized elasto-plastic hinges with N-M and N-M-V yield surfaces."""

from workbench.hinges.hinge import GeneralizedHinge as GeneralizedHinge
from workbench.hinges.panel import ShearSurface as ShearSurface
from workbench.hinges.panel import has_shear_surface as has_shear_surface
from workbench.hinges.panel import has_webs as has_webs
from workbench.hinges.panel import project_panel as project_panel
from workbench.hinges.surface import YieldSurface as YieldSurface
