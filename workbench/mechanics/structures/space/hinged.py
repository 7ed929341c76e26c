"""Superelements in space: bars between two hinges that yield under N, M_y and M_z, in one group."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array, Flags, Indices
from workbench.mechanics.structures.space import hinge_kernels
from workbench.mechanics.structures.space.beams import SpaceElements
from workbench.steel.hinges import BiaxialSurface
from workbench.steel.hinges.biaxial_kernels import ROOM

NO_PINS = np.zeros(2, dtype=bool)


@dataclass(frozen=True)
class SpaceBar:
    """A bar between two hinges alike.

    Arguments: `surface` of the hinges; `strength` (3,): plastic N, and moments about the strong and
    the weak axis, in N and N m; `axial` EA in N, `bending` EI about both axes and `torsion` G I_t
    in N m2; `hinge_stiffness` n, of hinges n 2EA/L and n 6EI/L; mass (kg/m) and `rotary` inertia
    (kg m) per length.
    """

    surface: BiaxialSurface
    strength: tuple[float, float, float]
    axial: float
    bending: tuple[float, float]
    torsion: float
    hinge_stiffness: float
    mass: float
    rotary: float

    def stiffness(self, length: float, pinned: Flags = NO_PINS) -> Array:
        """Elastic stiffness of N and both moments at the start and at the end (5, 5).

        Ends that are `pinned` carry no moment.
        """
        n, softness = self.hinge_stiffness, np.zeros((5, 5))
        softness[0, 0] = length / self.axial * (1.0 + 1.0 / n)
        for i, bending in enumerate(self.bending, 1):
            bend = length / (6.0 * bending)
            softness[i, i] = softness[i + 2, i + 2] = bend * (2.0 + 1.0 / n)
            softness[i, i + 2] = softness[i + 2, i] = -bend
        carries = np.ix_(*2 * [np.flatnonzero(~np.repeat([False, *pinned], [1, 2, 2]))])
        stiffness = np.zeros_like(softness)
        stiffness[carries] = np.linalg.inv(softness[carries])
        return stiffness


class SpaceBars(NamedTuple):
    """Bars as arrays for the kernels.

    `surfaces` (bars,) and which one elements have, `of` (e,); `strength` (e, 5); `stiffness` (e, 5,
    5) over the strengths; `torsion` G I_t / L (e,); `held`, share of the elastic stiffness beside
    the hinges; `axes` (e, 2, 3, 3) of the dofs of both nodes, as rows; `rooms` (e,) of the
    projections, which know from where the next one begins.
    """

    surfaces: Any
    of: Indices
    strength: Array
    stiffness: Array
    torsion: Array
    held: float
    axes: Array
    rooms: Any


class HingedState(NamedTuple):
    """State of all superelements in space: as `SpaceState`, with plastic deformations (e, 5)."""

    triads: Array
    chord: Array
    deformation: Array
    forces: Array
    plastic: Array


class SpaceSuperelements(SpaceElements):
    """Superelements in space.

    Arguments: `nodes` (elements, 2); which of the `bars` each has, `of` (elements,); `lengths` in
    m; `heights` and `axes`, see `SpaceElements`; `regularisation`, share of the elastic stiffness
    beside hinges that yield; which ends are `pinned` (elements, 2).
    """

    kernels: Any = hinge_kernels
    impact: Any = staticmethod(hinge_kernels.impact)
    _old: HingedState

    def __init__(
        self,
        nodes: ArrayLike,
        of: Indices,
        bars: Sequence[SpaceBar],
        lengths: Array,
        heights: ArrayLike,
        axes: ArrayLike | None = None,
        regularisation: float = 1e-6,
        pinned: Flags | None = None,
    ) -> None:
        count = len(of)
        self._orient(count, heights, axes)
        strength = np.array([[*bar.strength, *bar.strength[1:]] for bar in bars])[of]
        pins = np.zeros((count, 2), dtype=bool) if pinned is None else pinned
        each = zip(of, lengths, pins, strict=True)
        stiffness = np.stack([bars[i].stiffness(length, ends) for i, length, ends in each])
        torsion = np.array([bar.torsion for bar in bars])[of] / lengths
        surfaces = np.array([bar.surface.record for bar in bars])
        scaled = stiffness / (strength[:, :, None] * strength[:, None, :])
        rooms = np.zeros(count, ROOM)
        given = surfaces, of, strength, scaled, torsion, regularisation, self._axes, rooms
        self.tables = (SpaceBars(*given),)
        state = HingedState(
            np.zeros((count, 2, 3, 3)),
            np.zeros((count, 3)),
            np.zeros((count, 7)),
            np.zeros((count, 7)),
            np.zeros((count, 5)),
        )
        mass, rotary = np.array([[bar.mass, bar.rotary] for bar in bars])[of].T
        super().__init__(nodes, state, mass, rotary / mass)

    def plastic_turns(self) -> Array:
        """Committed plastic rotations of both hinges about both axes (elements, 2)."""
        plastic = self._old.plastic
        return np.asarray(plastic[..., [4, 3]] - plastic[..., [2, 1]])

    def own_tables(self) -> SpaceBars:
        """Tables for the kernels, with scratch of their own."""
        (tables,) = self.tables
        own: SpaceBars = tables._replace(rooms=tables.rooms.copy())
        return own
