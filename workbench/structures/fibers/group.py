"""What all beams with fiber sections have in common, whatever their kinematics."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array
from workbench.structures.elements import MemberElements
from workbench.structures.fibers.section import BeamSection, section_tables


class FiberElements(MemberElements):
    """Beams with fiber sections.

    Arguments: `nodes` (elements, 2), node numbers; `section_of` (elements,), which of `sections`
    each element has; `sections`.
    """

    def __init__(
        self, nodes: ArrayLike, section_of: ArrayLike, sections: Sequence[BeamSection]
    ) -> None:
        self.sections = tuple(sections)
        self._sections = section_tables(np.asarray(section_of, dtype=np.int64), self.sections)
        states = max(section.law.states for section in sections)
        count, fibers = len(self._sections.of), self._sections.y.shape[1]
        super().__init__(nodes, self._rest(count, states, fibers))

    @abstractmethod
    def _rest(self, count: int, states: int, fibers: int) -> Any:
        """State of so many elements at rest."""

    def masses(self) -> tuple[Array, Array]:
        """Mass (kg) and rotary inertia (kg m2) of every element, (elements,) each."""
        of = self._sections.of
        mass = np.array([s.mass_per_length for s in self.sections])[of] * self.lengths
        return mass, mass * np.array([s.radius_squared for s in self.sections])[of]

    @property
    def tables(self) -> tuple[Any, ...]:
        """What the kernels take besides bars and states: the sections."""
        return (self._sections,)

    @property
    @abstractmethod
    def shear_strains(self) -> Array:
        """Committed shear strain of the elements (elements,)."""

    @property
    @abstractmethod
    def plastic_strains(self) -> Array:
        """Committed plastic strains (elements, fibers), the mean along each element."""

    def plastic_rotations(self) -> Array:
        """Committed plastic curvature integrated over each element (elements,), in rad.

        That of a section is -sum(eps_p y A) / sum(y^2 A): what bends it when its stresses are
        removed.
        """
        tables = self._sections
        lever = (tables.y * tables.area / tables.second[:, None])[tables.of]
        return np.asarray(-self.lengths * np.sum(self.plastic_strains * lever, axis=1))
