"""Co-rotational superelements: a rigid or flexible elastic bar between two generalized hinges."""

from workbench.mechanics.structures.superelements.group import HingeEnd as HingeEnd
from workbench.mechanics.structures.superelements.group import Superelement as Superelement
from workbench.mechanics.structures.superelements.group import Superelements as Superelements
from workbench.mechanics.structures.superelements.group import (
    SuperelementState as SuperelementState,
)
from workbench.mechanics.structures.superelements.group import sway_stiffness as sway_stiffness
