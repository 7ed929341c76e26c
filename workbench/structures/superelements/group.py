"""The group object: all superelements of a structure, with two state buffers."""

from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array, Flags, Indices
from workbench.hinges.panel_kernels import WEB
from workbench.structures.elements import Bars, HingedElements
from workbench.structures.superelements import kernels
from workbench.structures.superelements.element import Superelement

REGULARISATION = 1e-6  # share of elastic stiffness; below 1e-5 a frame's peak changes by < 0.1 %


class SuperelementState(NamedTuple):
    """State of all elements.

    `plastic` (e, 5): u, theta of hinge 1, then of hinge 4, and how far the web slides, in m, whose
    angle is in both theta; `carried` (e, 3): N, M_1, M_4 of hinges and bar; `local` (e, 3), the
    same with the regularising stiffness; `deformation` (e, 3): elongation and end rotations against
    the chord; `rate` (e,): angular velocity of the chord.
    """

    plastic: Array
    carried: Array
    local: Array
    deformation: Array
    rate: Array


class HingeTables(NamedTuple):
    """Hinges and bars of all elements, one row each.

    `bending` (e, 4): flexibility as in `project_pair`; `flexibility` (e, 4) with that of the webs,
    and its inverse `stiffness` (e, 4), zero for pins; `webs` (e,), records of WEB, all zero where
    rigid in shear, and the `lengths` (e,) of these panels; `bounds` (e, 2, 4), `exponents`
    (e, 2, 2) and whether `pinned` (e, 2) of both hinges; inertia `rotary` (e,) of the turning chord
    in kg m2; share `eta` of elastic stiffness beside them; `scratch` of the kernels.
    """

    bending: Array
    flexibility: Array
    stiffness: Array
    webs: Any
    lengths: Array
    bounds: Array
    exponents: Array
    pinned: Flags
    rotary: Array
    eta: float
    scratch: tuple[Array, ...]


def scratch(elements: int) -> tuple[Array, ...]:
    """What the kernels need room for: of all elements tangents and chords, else of one."""
    shapes = (elements, 3, 3), (7, 4), (3,), (3,), (5,), (elements, 5)
    return tuple(np.empty(shape) for shape in shapes)


class Superelements(HingedElements):
    """Two-node superelements.

    Arguments: `nodes` (elements, 2), node numbers; `section_of` (elements,), which of `sections`
    each element is; `regularisation`, the share of the elastic stiffness that acts beside the
    perfectly plastic hinges and keeps the tangent of a mechanism regular; `first_order`,
    equilibrium of the undeformed structure (shapes are then drawn with the chords as they move).
    """

    kernels: ClassVar[Any] = kernels
    _old: SuperelementState

    def __init__(
        self,
        nodes: ArrayLike,
        *,
        sections: Sequence[Superelement],
        section_of: ArrayLike,
        regularisation: float = REGULARISATION,
        first_order: bool = False,
    ) -> None:
        own = [sections[i] for i in np.asarray(section_of, dtype=np.int64)]  # of each element
        widths = ((5,), (3,), (3,), (3,), ())
        state = SuperelementState(*(np.zeros((len(own), *width)) for width in widths))
        super().__init__(nodes, own, state, first_order)
        self.regularisation = regularisation

    def place(self, bars: Bars) -> None:
        """Take its place in a structure from the assembly."""
        super().place(bars)
        own = list(zip(self._own, self.lengths, strict=True))
        bending = np.stack([section.flexibility(length) for section, length in own])
        slides = np.array([section.shear_flexibility(length) for section, length in own])
        flexibility = bending + np.multiply.outer(slides, [0.0, 1.0, 1.0, 1.0])
        webs = np.zeros(len(self._own), WEB)
        for e, section in enumerate(self._own):
            if section.web is not None:
                webs[e] = section.web.record
        self._slide: Flags = webs["stiffness"] > 0.0
        flexible = [1.0 / s.bending_stiffness if s.flexible else 0.0 for s in self._own]
        self.bends: Array = np.array(flexible)  # in 1 / (N m2)
        pinned = np.array([[s.start.pinned, s.end.pinned] for s in self._own])
        exponents = np.stack([section.exponents() for section in self._own])
        self._powers: Array = np.moveaxis(exponents, -1, 0)[:, None].copy()
        self._tables = HingeTables(
            bending,
            flexibility,
            _inverse(flexibility, pinned),
            webs,
            self.lengths,
            np.stack([section.bounds() for section in self._own]),
            exponents,
            pinned,
            self._rotary_inertias("nonlinear"),
            self.regularisation,
            scratch(len(own)),
        )

    def _rotary_inertias(self, kind: str) -> Array:
        """Inertia of the turning chord (elements,) in kg m2 where it is of a kind, else zero."""
        inertia = [s.rotary_inertia if s.rotation_inertia == kind else 0.0 for s in self._own]
        return np.array(inertia) * self.lengths

    @property
    def states(self) -> tuple[SuperelementState, SuperelementState]:
        """The committed state and the one assembled last."""
        return self._old, self._new

    def show(self, state: SuperelementState) -> None:
        """Take a state that was reached elsewhere, or several (..., e, 3), to be looked at."""
        self._old = state

    def mass_matrices(self) -> Array:
        """Constant rotary inertia (elements, 6, 6) of the initial chords, where it is linear."""
        along = self.bars.chords / self.lengths[:, None]
        normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / self.lengths[:, None]
        gradient = np.zeros((len(self.nodes), 6))
        gradient[:, 0:2], gradient[:, 3:5] = -normal, normal
        inertia = self._rotary_inertias("linear")
        return np.asarray(inertia[:, None, None] * gradient[:, :, None] * gradient[:, None, :])

    def kinetic_energy(self) -> float:
        """Committed kinetic energy of the nonlinear rotary inertia, in J."""
        return 0.5 * float(self._tables.rotary @ self._old.rate**2)

    @property
    def turning_inertia(self) -> bool:
        """Whether there is rotary inertia that turns with the chords."""
        return bool(self._tables.rotary.any())

    def turn_with(self, displacement: Array, velocity: Array) -> None:
        """Give the chords the angular velocities that the nodes have (dofs,), in m and m/s."""
        first, last = self.bars.dofs[:, 0:2], self.bars.dofs[:, 3:5]
        d = self.bars.chords + displacement[last] - displacement[first]
        v = velocity[last] - velocity[first]
        self._old.rate[:] = (d[:, 0] * v[:, 1] - d[:, 1] * v[:, 0]) / np.sum(d**2, axis=1)

    @property
    def plastic(self) -> Array:
        """Committed plastic deformations (elements, 4): u, theta of hinge 1, then of hinge 4.

        In m and rad, conjugate to N, M1 and M4; a pin's rotation is all of it. The web slides
        beside them, see `sliding`.
        """
        turned = self._old.plastic[..., :4].copy()
        turned[..., [1, 3]] -= (self.sliding / self.lengths)[..., None]
        return turned

    @property
    def sliding(self) -> Array:
        """How far the web of each has slid for good (elements,), in m."""
        return self._old.plastic[..., 4]

    @property
    def elongations(self) -> Array:
        """Committed change of chord length of the elements (elements,), in m."""
        return self._old.deformation[..., 0]

    @property
    def shear_forces(self) -> Array:
        """Committed shear force of the elements (elements,), in N; in panels that of the web."""
        webs, carried = self.slide, self._old.carried
        sliding = (carried[..., 1] + carried[..., 2]) / self.lengths
        return sliding if webs.all() else np.where(webs, sliding, super().shear_forces)

    @property
    def slide(self) -> Flags:
        """Whether webs yield in shear (elements,)."""
        return self._slide

    def utilisation(self) -> Array:
        """Left side of the yield condition at both hinges (elements, 2): 1 on the surface."""
        return self.used_by(np.ascontiguousarray(self._old.carried))

    def used_by(self, carried: Array) -> Array:
        """The same (..., elements, 2) of the forces `carried` (..., elements, 3)."""
        rows = carried.reshape(-1, len(self._own), 3)
        used = np.zeros((*rows.shape[:2], 2))
        if not self.slide.all():
            shares = np.empty((2, *used.shape))
            kernels.use_bounds(self._tables.bounds, rows, shares)
            shares **= self._powers
            used = shares[0] + shares[1]
        if self.slide.any():
            kernels.use_webs(self._tables, rows, used)
        return used.reshape(*carried.shape[:-1], 2)

    def shapes(self, displacement: Array, elements: Indices, points: Array) -> Array:
        """Displaced axis (points, 2), bent by committed moments where it is flexible."""
        return self.bent(displacement, elements, points, self.bends, self._old.carried[..., 1:])


def _inverse(flexibility: Array, pinned: Flags) -> Array:
    """Elastic stiffness k_N, k_11, k_14, k_44 (elements, 4), zero where an end is pinned."""
    f_n, f11, f14, f44 = flexibility.T
    coupled = np.where(np.any(pinned, axis=1), 0.0, f14)
    f11 = np.where(pinned[:, 0], np.inf, f11)
    f44 = np.where(pinned[:, 1], np.inf, f44)
    # divided through by f_11 f_44, which may be infinite
    share = 1.0 / (1.0 - coupled**2 / (f11 * f44))
    return np.stack([1.0 / f_n, share / f11, -share * coupled / (f11 * f44), share / f44], axis=1)
