"""Generalized elasto-plastic hinges with super-elliptic N-M yield surfaces."""

from workbench.hinges.hinge import GeneralizedHinge, HingeUpdate
from workbench.hinges.surface import YieldSurface

__all__ = ["GeneralizedHinge", "HingeUpdate", "YieldSurface"]
