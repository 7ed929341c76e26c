"""Generalized elasto-plastic hinges with N-M and N-M-V yield surfaces."""

from workbench.hinges.hinge import GeneralizedHinge, HingeUpdate
from workbench.hinges.panel import (
    PanelUpdate,
    ShearSurface,
    has_shear_surface,
    has_webs,
    project_panel,
)
from workbench.hinges.surface import YieldSurface

__all__ = [
    "GeneralizedHinge",
    "HingeUpdate",
    "PanelUpdate",
    "ShearSurface",
    "YieldSurface",
    "has_shear_surface",
    "has_webs",
    "project_panel",
]
