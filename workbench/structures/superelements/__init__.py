"""Co-rotational superelements: a rigid or flexible elastic bar between two generalized hinges."""

from workbench.structures.superelements.element import HingeEnd, Superelement, sway_stiffness
from workbench.structures.superelements.group import Superelements, SuperelementState

__all__ = ["HingeEnd", "Superelement", "SuperelementState", "Superelements", "sway_stiffness"]
