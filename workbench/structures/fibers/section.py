"""Layered cross sections with their laws, and what all beams with such sections have in common."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array, Indices
from workbench.structures.elements import MemberElements
from workbench.structures.uniaxial import ShearYielding, UniaxialLaw


@dataclass(frozen=True)
class BeamSection:
    """Fibers of a section, in SI units.

    Arguments: fiber ordinates `y` (f,) and areas `area` (f,); `law` of all fibers;
    `mass_per_length` in kg/m (rotary inertia is that times I / A of the fibers);
    `shear_stiffness` GA in N of the elastic shear strain, 0 if the fibers carry the shear force;
    `shear_share` (f,), the shear strain of a fiber over that of the section (1 in a web, 0 in a
    flange; only with a law that yields in shear); `initial_stress` (f,) in Pa, self-equilibrated.
    """

    y: Array
    area: Array
    law: UniaxialLaw | ShearYielding
    mass_per_length: float
    shear_stiffness: float = 0.0
    shear_share: Array | None = None
    initial_stress: Array | None = None

    @property
    def radius_squared(self) -> float:
        """Square of the radius of gyration, I / A, in m2."""
        return float(np.sum(self.y**2 * self.area) / np.sum(self.area))


class SectionTables(NamedTuple):
    """Sections as arrays for the kernels: which one an element has, laws, and fibers (s, f).

    `second` moment of area (s,) in m4; the rest as in `BeamSection`, `initial` as a strain.
    """

    of: Indices
    code: Indices
    parameters: Array
    y: Array
    area: Array
    share: Array
    initial: Array
    shear: Array
    second: Array


def section_tables(of: Indices, sections: Sequence[BeamSection]) -> SectionTables:
    """Arrays of all sections; sections with fewer fibers get empty ones.

    Arguments: `of` (elements,), which of the `sections` each element has.
    """
    fibers = max(len(section.y) for section in sections)

    def filled(rows: Sequence[Array | None]) -> Array:
        table = np.zeros((len(sections), fibers))
        for i, row in enumerate(rows):
            if row is not None:
                table[i, : len(row)] = row
        return table

    strains = [
        None if s.initial_stress is None else s.initial_stress / s.law.elastic_modulus
        for s in sections
    ]
    y, area = filled([s.y for s in sections]), filled([s.area for s in sections])
    return SectionTables(
        of,
        np.array([section.law.code for section in sections], dtype=np.int64),
        np.stack([section.law.parameters() for section in sections]),
        y,
        area,
        filled([section.shear_share for section in sections]),
        filled(strains),
        np.array([section.shear_stiffness for section in sections]),
        np.sum(y**2 * area, axis=1),
    )


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


def lobatto(points: int) -> tuple[Array, Array]:
    """Places in 0..1 and weights of Gauss-Lobatto quadrature, both ends among the places."""
    inner = np.polynomial.Legendre.basis(points - 1)
    x = np.concatenate([[-1.0], np.sort(inner.deriv().roots().real), [1.0]])
    return 0.5 * (1.0 + x), 1.0 / (points * (points - 1) * inner(x) ** 2)
