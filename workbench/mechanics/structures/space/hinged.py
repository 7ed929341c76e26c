"""Superelements in space: bars between two hinges that yield under N, M_y and M_z, in one group."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array, Flags, Indices
from workbench.mechanics.structures.space import hinge_kernels
from workbench.mechanics.structures.space.beams import SpaceElements
from workbench.scenarios import Frame
from workbench.steel.hinges.biaxial_kernels import ROOM
from workbench.steel.hinges.interaction import surface_in_space
from workbench.steel.sections.slenderness import twist_stiffness


def _stiffness(axial: float, bending: Array, hinges: float, length: float, pins: Flags) -> Array:
    """Elastic stiffness of N and both moments at the start and at the end of a bar (5, 5).

    Arguments: EA in N, EI about both axes in N m2; n of `hinges` of n 2EA/L and n 6EI/L; `length`
    in m; which ends are `pins`, which carry no moment.
    """
    softness = np.zeros((5, 5))
    softness[0, 0] = length / axial * (1.0 + 1.0 / hinges)
    for i, each in enumerate(bending, 1):
        bend = length / (6.0 * each)
        softness[i, i] = softness[i + 2, i + 2] = bend * (2.0 + 1.0 / hinges)
        softness[i, i + 2] = softness[i + 2, i] = -bend
    carries = np.ix_(*2 * [np.flatnonzero(~np.repeat([False, *pins], [1, 2, 2]))])
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
    """Superelements in space, elastic bars between two hinges alike.

    Arguments: `nodes` (elements, 2); the members of the `frame`, one after the other, that each
    element is of, `of` (elements,); `lengths` in m; `heights` and `axes`, see `SpaceElements`;
    `hinge_stiffness`, see `_stiffness`; `regularisation`, share of the elastic stiffness beside
    hinges that yield.
    """

    kernels: Any = hinge_kernels
    impact: Any = staticmethod(hinge_kernels.impact)
    _old: HingedState

    def __init__(
        self,
        frame: Frame,
        nodes: ArrayLike,
        of: Indices,
        lengths: Array,
        heights: ArrayLike,
        axes: ArrayLike,
        hinge_stiffness: float,
        regularisation: float,
    ) -> None:
        count, steel, members = len(of), frame.steel, frame.members
        self._orient(count, heights, axes)
        sections = [frame.strength_section(member).about("strong") for member in members]
        both = [frame.about_both(member) for member in members]
        moments = np.array([[each.plastic_moment for each in pair] for pair in both])
        strength = np.column_stack([[s.squash_load for s, _ in both], moments, moments])[of]
        axial = steel.elastic_modulus * np.array([strong.area for strong, _ in both])
        bending = np.array([[each.second_moment for each in pair] for pair in both])
        bending *= steel.elastic_modulus
        pins = np.zeros((count, 2), dtype=bool)
        first = np.flatnonzero(np.diff(of, prepend=-1))
        ends = np.stack([first, np.append(first[1:], count) - 1], axis=1)
        joints = map(frame.joints_of, members)
        pins[ends, [0, 1]] = [[j.rotational_stiffness == 0.0 for j in pair] for pair in joints]
        each = zip(axial[of], bending[of], lengths, pins, strict=True)
        stiffness = np.stack([_stiffness(a, b, hinge_stiffness, *more) for a, b, *more in each])
        twist = np.array([twist_stiffness(section, steel) for section in sections])
        torsion = twist[of] / lengths
        surfaces = np.array([surface_in_space(section).record for section in sections])
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
        mass = np.array([[s.mass_per_length, s.rotary_inertia] for s, _ in both])[of].T
        super().__init__(nodes, state, mass[0], mass[1] / mass[0])

    def plastic_turns(self) -> Array:
        """Committed plastic rotations of both hinges about both axes (elements, 2)."""
        plastic = self._old.plastic
        return np.asarray(plastic[..., [4, 3]] - plastic[..., [2, 1]])

    def own_tables(self) -> SpaceBars:
        """Tables for the kernels, with scratch of their own."""
        (tables,) = self.tables
        own: SpaceBars = tables._replace(rooms=tables.rooms.copy())
        return own
