"""Superelements: two hinges, the bar between them and its mass; all of a structure in one group."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array, Flags
from workbench.mechanics.structures.elements import Bars, HingedElements
from workbench.mechanics.structures.superelements import kernels
from workbench.steel.hinges import ShearSurface, YieldSurface
from workbench.steel.hinges.kernels import LAW, MOST, gauge
from workbench.steel.hinges.panel_kernels import WEB

REGULARISATION = 1e-6  # share of elastic stiffness; below 1e-5 a frame's peak changes by < 0.1 %


@dataclass(frozen=True)
class HingeEnd:
    """Generalized hinge at one end of a superelement.

    Arguments: `surface`, bounds of the axial force and of the internal moment, positive where it
    stretches the fibers on the right of somebody who looks from start to end; `axial_stiffness`
    in N/m (inf: the hinge itself is rigid); `rotational_stiffness` in N m/rad (inf: rigid, 0: a
    pin, which carries no moment).
    """

    surface: YieldSurface
    axial_stiffness: float = inf
    rotational_stiffness: float = inf

    @property
    def pinned(self) -> bool:
        """Whether the hinge carries no moment."""
        return self.rotational_stiffness == 0.0


@dataclass(frozen=True)
class Superelement:
    """A bar with a generalized hinge at each end (Heng 2017, papers III and IV).

    Arguments: hinges `start` and `end`; `axial_stiffness` EA (N) and `bending_stiffness` EI
    (N m2) of the bar if it is flexible, not used if it is rigid; `flexible`; `mass_per_length` in
    kg/m; `rotary_inertia` per length, rho I, in kg m, which acts on the rotation of the chord;
    `rotation_inertia`: that of the deformed chord (nonlinear), of the initial chord (linear),
    none; `web` (None: rigid in shear), whose surface is that of both hinges where it yields in
    shear, else it is elastic; `law` by which the bar flows point by point, a record of LAW, in
    place of its hinges' surfaces. One hinge of a rigid bar has a finite axial stiffness, both a
    finite rotational one.
    """

    start: HingeEnd
    end: HingeEnd
    axial_stiffness: float = inf
    bending_stiffness: float = inf
    flexible: bool = False
    mass_per_length: float = 0.0
    rotary_inertia: float = 0.0
    rotation_inertia: str = "none"
    web: ShearSurface | None = None
    web_yields: bool = True
    law: Any = field(default=None, compare=False)

    def flexibility(self, length: float) -> Array:
        """Elastic flexibility f_N, f_11, f_14, f_44 (4,) of hinges and bar, `length` in m.

        Entries of a pinned end are those of the bar alone.
        """
        ends = self.start, self.end
        axial = sum(1.0 / end.axial_stiffness for end in ends)
        hinges = [0.0 if end.pinned else 1.0 / end.rotational_stiffness for end in ends]
        bend = 0.0
        if self.flexible:
            axial += length / self.axial_stiffness
            bend = length / (6.0 * self.bending_stiffness)
        return np.array([axial, hinges[0] + 2.0 * bend, -bend, hinges[1] + 2.0 * bend])

    def shear_flexibility(self, length: float) -> float:
        """Rotation of both ends by the elastic web per end moment (1/N m), `length` in m."""
        return 0.0 if self.web is None else 1.0 / (length * float(self.web.record["stiffness"]))

    def bounds(self) -> Array:
        """Bounds (2, 4) of N in tension and compression and of M_1, M_4 positive and negative.

        The moment on the bar at its start is the internal one with its sign turned.
        """
        first, last = self.start.surface, self.end.surface
        return np.array(
            [
                [*first.axial_bounds, *first.moment_bounds[::-1]],
                [*last.axial_bounds, *last.moment_bounds],
            ]
        )


def sway_stiffness(
    length: float, bending_stiffness: float, joints: tuple[float, float] = (inf, inf)
) -> tuple[float, float]:
    """Hinge stiffnesses (N m/rad) with which a rigid bar is exact when both its ends keep upright.

    Arguments: `length` (m) and EI (N m2) of the member; rotational stiffness of its `joints` in
    N m/rad (inf: rigid, 0: pinned). Rigid joints give 6 EI / L at both ends, hence 12 EI / L^3
    against sway; with a pin the other end gets 3 EI / L. A rigid bar between two springs cannot
    be exact in other modes as well: uniform bending would need 2 EI / L.
    """
    bend = length / (6.0 * bending_stiffness)
    # moments of the flexible member for a unit chord rotation, free of division by a pin's zero
    softness = [0.0 if joint == inf else 1.0 for joint in joints]
    stiff = [1.0 if joint == inf else joint for joint in joints]
    diagonal = [2.0 * bend * k + s for k, s in zip(stiff, softness, strict=True)]
    determinant = diagonal[0] * diagonal[1] - bend * bend * stiff[0] * stiff[1]
    first = stiff[0] * (diagonal[1] + bend * stiff[1]) / determinant
    last = stiff[1] * (diagonal[0] + bend * stiff[0]) / determinant
    return first, last


class SuperelementState(NamedTuple):
    """State of all elements.

    `plastic` (e, 5): u, theta of hinge 1, then of hinge 4, and the plastic shear displacement of
    the web, in m, whose angle is in both theta, then lambda at the points of bars that flow;
    `carried` (e, 3): N, M_1, M_4 of hinges and bar;
    `local` (e, 3), the same with the regularising stiffness; `deformation` (e, 3): elongation and
    end rotations against the chord; `rate` (e,): angular velocity of the chord.
    """

    plastic: Array
    carried: Array
    local: Array
    deformation: Array
    rate: Array


class HingeTables(NamedTuple):
    """Hinges and bars of all elements, one row each.

    `bending` (e, 4): flexibility as in `project_pair`; `flexibility` (e, 4) with that of all webs,
    and its inverse `stiffness` (e, 4), zero for pins; `webs` (e,), records of WEB, all zero where
    rigid in shear, and the `lengths` (e,) of these panels; `bounds` (e, 2, 4), `exponents`
    (e, 2, 2) and whether `pinned` (e, 2) of both hinges; inertia `rotary` (e,) of the turning chord
    in kg m2; share `eta` of elastic stiffness beside them; `scratch` of the kernels; `laws` (e,) of
    bars that flow point by point, or None: kernels are compiled for either.
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
    laws: Any = None


def scratch(elements: int, flows: int = 5) -> tuple[Array, ...]:
    """Scratch arrays for the kernels: of all elements tangents and chords, else of one."""
    shapes = (elements, 3, 3), (7, 4), (3,), (3,), (flows,), (elements, 5)
    return tuple(np.empty(shape) for shape in shapes)


class Superelements(HingedElements):
    """Two-node superelements.

    Arguments: `nodes` (elements, 2), node numbers; `kinds` (elements,), what each element consists
    of; `regularisation`, the share of the elastic stiffness that acts beside the
    perfectly plastic hinges and keeps the tangent of a mechanism regular; `first_order`,
    equilibrium of the undeformed structure (shapes are then drawn with the chords as they move).
    """

    kernels: Any = kernels
    impact: Any = staticmethod(kernels.impact)
    _old: SuperelementState

    def __init__(
        self,
        nodes: ArrayLike,
        kinds: Sequence[Superelement],
        *,
        regularisation: float = REGULARISATION,
        first_order: bool = False,
    ) -> None:
        self._flows = any(kind.law is not None for kind in kinds)
        self._columns = 5 + MOST if self._flows else 5
        widths = ((self._columns,), (3,), (3,), (3,), ())
        state = SuperelementState(*(np.zeros((len(kinds), *width)) for width in widths))
        mass = np.array([kind.mass_per_length for kind in kinds])
        bends = [1.0 / kind.bending_stiffness if kind.flexible else 0.0 for kind in kinds]
        super().__init__(nodes, state, mass, bends, first_order)
        self._kinds, self.regularisation = kinds, regularisation

    def place(self, bars: Bars) -> None:
        """Take its place in a structure from the assembly."""
        super().place(bars)
        pairs = list(zip(self._kinds, self.lengths, strict=True))
        bending = np.stack([kind.flexibility(length) for kind, length in pairs])
        in_shear = np.array([kind.shear_flexibility(length) for kind, length in pairs])
        flexibility = bending + np.multiply.outer(in_shear, [0.0, 1.0, 1.0, 1.0])
        webs = np.zeros(len(pairs), WEB)
        for e, kind in enumerate(self._kinds):
            if kind.web is not None and kind.web_yields:
                webs[e] = kind.web.record
            else:
                bending[e] = flexibility[e]
        pinned = np.array([[kind.start.pinned, kind.end.pinned] for kind in self._kinds])
        ends = [(kind.start.surface, kind.end.surface) for kind in self._kinds]
        laws = np.array([kind.law for kind in self._kinds], LAW) if self._flows else None
        self._tables = HingeTables(
            bending,
            flexibility,
            _inverse(flexibility, pinned),
            webs,
            self.lengths,
            np.stack([kind.bounds() for kind in self._kinds]),
            np.array([[(end.alpha, end.beta) for end in pair] for pair in ends]),
            pinned,
            self._rotary_inertias("nonlinear"),
            self.regularisation,
            scratch(len(pairs), self._columns),
            laws,
        )
        self.tables = (self._tables,)

    def _rotary_inertias(self, kind: str) -> Array:
        """Inertia of the turning chord (elements,) in kg m2 where it is of a kind, else zero."""
        inertia = [k.rotary_inertia if k.rotation_inertia == kind else 0.0 for k in self._kinds]
        return np.array(inertia) * self.lengths

    def own_tables(self) -> HingeTables:
        """Tables for the kernels, with scratch of their own."""
        return self._tables._replace(scratch=scratch(len(self.lengths), self._columns))

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
    def plastic(self) -> Array:
        """Committed plastic deformations (elements, 4), without `plastic_shear`."""
        turned = self._old.plastic[..., :4].copy()
        turned[..., [1, 3]] -= (self.plastic_shear / self.lengths)[..., None]
        return turned

    @property
    def plastic_shear(self) -> Array:
        """Plastic shear displacement of the webs (elements,), in m."""
        return self._old.plastic[..., 4]

    @property
    def elongations(self) -> Array:
        """Committed change of chord length of the elements (elements,), in m."""
        return self._old.deformation[..., 0]

    @property
    def shear_forces(self) -> Array:
        """Committed shear force of the elements (elements,), in N; in panels that of the web."""
        webs, carried = self.yields_in_shear, self._old.carried
        of_webs = (carried[..., 1] + carried[..., 2]) / self.lengths
        return of_webs if webs.all() else np.where(webs, of_webs, super().shear_forces)

    @property
    def yields_in_shear(self) -> Flags:
        """Whether webs yield in shear (elements,)."""
        return np.asarray(self._tables.webs["stiffness"] > 0.0)

    def envelope_share(self) -> float:
        """Largest share of its static strength that an end of bars that flow takes, else 0."""
        if self._tables.laws is None:
            return 0.0
        ends = zip(self._tables.laws, self._old.carried, strict=True)
        forces = ((law, carried / law["strength"]) for law, carried in ends)
        share = max(float(gauge(law, f[0], m)[0]) for law, f in forces for m in f[1:])
        return float(max([share, *self.utilisation()[self.yields_in_shear].flat]))

    def utilisation(self) -> Array:
        """Left side of the yield condition at both hinges (elements, 2): 1 on the surface."""
        carried, exponents = self._old.carried, self._tables.exponents
        moments = self._shares(carried[..., 1:], 2) ** exponents[..., 0]
        used = moments + self._shares(carried[..., :1], 0) ** exponents[..., 1]
        if self.yields_in_shear.any():
            rows = np.ascontiguousarray(carried).reshape(-1, len(self.lengths), 3)
            kernels.use_webs(self._tables, rows, used.reshape(-1, len(self.lengths), 2))
        return used

    def _shares(self, forces: Array, bound: int) -> Array:
        """Of the bounds at both hinges, the positive one in this column and the next, that act."""
        of_sign = self._tables.bounds[..., bound : bound + 2]
        return np.abs(forces) / np.where(forces >= 0.0, of_sign[..., 0], of_sign[..., 1])

    @property
    def bending_moments(self) -> Array:
        """Committed end moments that bend the bars (elements, 2), in N m: those of the hinges."""
        return np.asarray(self._old.carried[..., 1:])


def _inverse(flexibility: Array, pinned: Flags) -> Array:
    """Elastic stiffness k_N, k_11, k_14, k_44 (elements, 4), zero where an end is pinned."""
    f_n, f11, f14, f44 = flexibility.T
    coupled = np.where(np.any(pinned, axis=1), 0.0, f14)
    f11 = np.where(pinned[:, 0], np.inf, f11)
    f44 = np.where(pinned[:, 1], np.inf, f44)
    # divided through by f_11 f_44, which may be infinite
    share = 1.0 / (1.0 - coupled**2 / (f11 * f44))
    return np.stack([1.0 / f_n, share / f11, -share * coupled / (f11 * f44), share / f44], axis=1)
