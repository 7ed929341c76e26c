"""Element groups of an assembly: bars, two states, the step; joint springs.

**Second part.** Overstress of a step: backward Euler of Cowper-Symonds flow under one or two
stresses, compiled.

The unknown is x = (p / (D dt))^(1/q) with the equivalent plastic strain p of the step: in p itself
the slope of the overstress at rest has no bound. Derivation: docs/theory/strain-rate.md.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from copy import copy
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array, Flags, Indices
from workbench.base.compiled import njit


class Bars(NamedTuple):
    """Two-node elements in their structure.

    `dofs` (e, 6); `positions` (e, 36) of their tangents in the flat band; initial `chords` (e, 2)
    and `lengths` (e,) in m; `first_order`, geometry and equilibrium of the undeformed structure;
    `relative`, chords from relative displacements, not from places (the same but for rounding).
    """

    dofs: Indices
    positions: Indices
    chords: Array
    lengths: Array
    first_order: bool = False
    relative: bool = False


class StepRequest(NamedTuple):
    """Step of an assembly for its groups: forces and tangent at the displacements `end`.

    `force` (dofs,) and flat `band` to add to; committed displacements `start` (dofs,). If
    `dynamic`, forces are the energy-exact ones of a time step of `duration` (s), with `weight` of
    the end state; otherwise those of equilibrium at the end (weight 1). Without `tangent` the band
    is of no interest.
    """

    force: Array
    band: Array
    start: Array
    end: Array
    weight: float
    dynamic: bool
    duration: float
    tangent: bool


class StepEnergies(NamedTuple):
    """Energies of one step of a group or a whole structure, in J.

    `stored` at the end of the step; `plastic` and `algorithmic` dissipation of the step; `ideal`,
    the plastic work of stresses that stay at yield: `plastic / ideal` is the yield ratio, which
    falls below 1 where averaged stresses soften the material artificially.
    """

    stored: float
    plastic: float
    algorithmic: float
    ideal: float

    def __add__(self, other: object) -> StepEnergies:
        """Sum of two groups, entry by entry."""
        if not isinstance(other, StepEnergies):
            return NotImplemented
        return StepEnergies(*(a + b for a, b in zip(self, other, strict=True)))


class ElementGroup(ABC):
    """All elements of one kind; states are committed by swapping two buffers.

    Arguments: `nodes` (elements, 2), node numbers; an empty `state`, a NamedTuple of arrays;
    `mass_per_length` (kg/m) of the elements, and `radius_squared` (m2) of gyration.
    `kernels`, the compiled module with `assemble` and `account`, and the `tables` that these take
    besides bars and states, once it has its place; `crumples`, whether an element
    means nothing once a plastic hinge has shortened it to nothing, as the direction of a chord
    without length is undefined. What is read off is committed, in SI units; forces are those of a
    co-rotational element unless a kind has its own.
    """

    kernels: Any
    tables: tuple[Any, ...] = ()
    crumples: ClassVar[bool] = True

    def __init__(
        self,
        nodes: ArrayLike,
        state: Any,
        mass_per_length: ArrayLike = 0.0,
        radius_squared: ArrayLike = 0.0,
    ) -> None:
        self.nodes: Indices = np.asarray(nodes, dtype=np.int64).reshape(-1, 2)
        self._mass_per_length = np.asarray(mass_per_length)
        self._radius_squared = np.asarray(radius_squared)
        self._old = state
        self._new = type(state)(*(values.copy() for values in state))

    def place(self, bars: Bars) -> None:
        """Take its place in a structure from the assembly."""
        self.bars = bars

    def copy(self) -> Self:
        """Copy of the elements in the same place, with states of their own."""
        other = copy(self)
        for name in ("_old", "_new"):
            state = getattr(self, name)
            setattr(other, name, type(state)(*(values.copy() for values in state)))
        return other

    def assemble(self, step: StepRequest) -> None:
        """Add forces and tangent of a step from the committed state; keep the trial state."""
        self.kernels.assemble(step, self.bars, *self.tables, self._old, self._new)

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step from the committed state to the one assembled last."""
        energies = self.kernels.account(weight, self.bars, *self.tables, self._old, self._new)
        return StepEnergies(*energies)

    def commit(self) -> None:
        """Make the state assembled last the committed one."""
        self._old, self._new = self._new, self._old

    @property
    def states(self) -> tuple[Any, Any]:
        """The committed state and the one assembled last."""
        return self._old, self._new

    def show(self, state: Any) -> None:
        """Take a state that was reached elsewhere, or several (..., e, n), to be looked at."""
        self._old = state

    def masses(self) -> tuple[Array, Array]:
        """Mass (kg) and rotary inertia (kg m2) of every element, (elements,) each."""
        mass = self._mass_per_length * self.lengths
        return mass, mass * self._radius_squared

    def mass_matrices(self) -> Array | None:
        """Constant mass matrices (elements, 6, 6) in addition to `masses`, if there are any."""
        return None

    def kinetic_energy(self) -> float:
        """Committed kinetic energy that is not in the mass matrix, in J."""
        return 0.0

    @property
    def lengths(self) -> Array:
        """Initial lengths (elements,), in m."""
        return self.bars.lengths

    @property
    def local_forces(self) -> Array:
        """N and end moments M1, M2 (elements, 3); internal moments are -M1 and M2."""
        return np.asarray(self._old.local)

    @property
    def elongations(self) -> Array:
        """Changes of length along the axis or chord (elements,), in m; zero of springs."""
        return np.zeros(len(self.nodes))

    @property
    def shear_forces(self) -> Array:
        """Shear force (M1 + M2) / l of the elements (elements,), in N."""
        chord = self.lengths + (0.0 if self.bars.first_order else self.elongations)
        return np.asarray((self._old.local[..., 1] + self._old.local[..., 2]) / chord)


class HingedElements(ElementGroup):
    """Bars whose plasticity is that of two hinges at their ends.

    Arguments: those of `ElementGroup`; `bends`, flexibility 1 / EI (elements,) of the bars, 0 of
    straight ones, in 1 / (N m2); `first_order`, equilibrium of the undeformed structure.
    """

    def __init__(
        self, nodes: ArrayLike, state: Any, mass: ArrayLike, bends: ArrayLike, first_order: bool
    ) -> None:
        super().__init__(nodes, state, mass)
        self.bends, self.first_order = np.asarray(bends), first_order

    def place(self, bars: Bars) -> None:
        """Take its place in a structure from the assembly."""
        super().place(bars._replace(first_order=self.first_order, relative=True))

    @property
    def yields_in_shear(self) -> Flags:
        """Whether webs yield in shear (elements,)."""
        return np.zeros(len(self.lengths), dtype=bool)

    def envelope_share(self) -> float:
        """Largest share of its static strength that an end of bars that flow takes, else 0."""
        return 0.0

    @property
    @abstractmethod
    def plastic(self) -> Array:
        """Committed plastic deformations (elements, 4): u, theta of hinge 1, then of hinge 4.

        In m and rad, conjugate to N, M1 and M4; a pin's rotation is all of it.
        """

    @abstractmethod
    def utilisation(self) -> Array:
        """Left side of the yield condition at both hinges (elements, 2): 1 on the surface."""

    def shapes(self, displacement: Array, elements: Indices, points: Array) -> Array:
        """Displaced axis (points, 2) less the initial position of the first node, in m.

        Arguments: displacements (dofs,); `elements` (points,), and the `points` along them in
        0..1. Committed moments bend the bars between their ends.
        """
        x, dofs, bars = points, self.bars.dofs[elements], self.bars
        first = displacement[..., dofs[..., 0:2]]
        d = bars.chords[elements] + displacement[..., dofs[..., 3:5]] - first
        place = first + x[..., None] * d
        if np.any(self.bends):
            moments = self.bending_moments
            m1, m4 = moments[..., elements, 0], moments[..., elements, 1]
            soft = (bars.lengths / 6.0 * self.bends)[elements] * x * (1.0 - x)
            across = soft * ((1.0 - x) * (2.0 * m1 - m4) - x * (2.0 * m4 - m1))
            place[..., 0] -= across * d[..., 1]
            place[..., 1] += across * d[..., 0]
        return np.asarray(place)

    @property
    def bending_moments(self) -> Array:
        """Committed end moments that bend the bars (elements, 2), in N m."""
        return np.asarray(self._old.local[..., 1:])


class JointState(NamedTuple):
    """Rotations and their plastic parts in rad, moments in N m, (springs,) each."""

    rotation: Array
    plastic: Array
    moment: Array


class JointSprings(ElementGroup):
    """An element group of rotational springs.

    Elastic, perfectly plastic. Arguments: `nodes` (springs, 2), pairs of tied nodes, in the order
    in which they come along the member; of each spring its stiffness in N m/rad (0: a pin) and its
    strength for positive and negative moments in N m (inf: elastic), `springs` (springs, 3). The
    rotation of a spring is that of its second node less that of its first one, so that its moment
    is the internal moment of the member there: positive where it stretches the fibers on the right
    of somebody who looks along the member.
    """

    _old: JointState
    _new: JointState

    def __init__(self, nodes: ArrayLike, springs: ArrayLike) -> None:
        self._stiffness, self._most, least = np.array(springs, dtype=float).reshape(-1, 3).T
        self._least: Array = -least
        super().__init__(nodes, JointState(*np.zeros((3, len(least)))))

    def place(self, bars: Bars) -> None:
        """Take its place in a structure; the chords must have no length."""
        if np.any(bars.chords != 0.0):
            raise ValueError("joint springs connect nodes at one place")
        super().place(bars)

    def assemble(self, step: StepRequest) -> None:
        """Add moments and tangent of a step from the committed state; keep the trial state."""
        first, second = self.bars.dofs[:, 2], self.bars.dofs[:, 5]
        old, new, k = self._old, self._new, self._stiffness
        new.rotation[:] = step.end[second] - step.end[first]
        within = old.rotation + step.weight * (new.rotation - old.rotation)
        trial = k * (within - old.plastic)
        new.moment[:] = np.clip(trial, self._least, self._most)
        yields = new.moment != trial
        new.plastic[:] = old.plastic
        new.plastic[yields] += (trial[yields] - new.moment[yields]) / (step.weight * k[yields])
        pinned = k == 0.0
        new.plastic[pinned] = new.rotation[pinned]
        np.add.at(step.force, first, -new.moment)
        np.add.at(step.force, second, new.moment)
        tangent = np.where(yields, 0.0, step.weight * k)
        for row, column, sign in ((2, 2, 1.0), (2, 5, -1.0), (5, 2, -1.0), (5, 5, 1.0)):
            np.add.at(step.band, self.bars.positions[:, 6 * row + column], sign * tangent)

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step from the committed state to the one assembled last."""
        old, new, k = self._old, self._new, self._stiffness
        start, elastic = old.rotation - old.plastic, new.rotation - new.plastic
        change = elastic - start
        moment = k * ((1.0 - weight) * start + weight * elastic)
        plastic = float(moment @ (new.plastic - old.plastic))
        return StepEnergies(
            0.5 * float(k @ elastic**2), plastic, (weight - 0.5) * float(k @ change**2), plastic
        )

    @property
    def moments(self) -> Array:
        """Committed moments (springs,), in N m."""
        return self._old.moment

    @property
    def rotations(self) -> Array:
        """Committed rotations (springs,), in rad."""
        return self._old.rotation

    @property
    def plastic(self) -> Array:
        """Committed plastic rotations (springs,) in rad; of a pin all of its rotation."""
        return self._old.plastic

    def utilisation(self) -> Array:
        """Committed moments over the strengths (springs,): 1 at yield, 0 at a pin."""
        moment = self._old.moment
        return np.asarray(np.maximum(moment / self._most, moment / self._least))


ITERATIONS = 60
CLOSED = 1e-15  # step of Newton's method in x + 1 that is round-off


@njit(cache=True, error_model="numpy")
def rate_flow(
    excess: float, resistance: float, fy: float, D: float, q: float, duration: float
) -> tuple[float, float]:
    """Plastic strain of a step with Cowper-Symonds overstress, and d(strain)/d(excess).

    Solves resistance g + fy (g / (D dt))^(1/q) = excess for the plastic strain g, where
    `excess` is the trial stress above the static yield stress. In x = (g / (D dt))^(1/q) the left
    side is convex and rising, so that Newton's method from above is monotone.
    """
    scale = resistance * D * duration
    x = min(excess / fy, (excess / scale) ** (1.0 / q))
    for _ in range(ITERATIONS):
        power = scale * x ** (q - 1.0)
        change = (power * x + fy * x - excess) / (q * power + fy)
        x -= change
        if abs(change) <= 1e-15 * x:
            break
    strain_slope = D * duration * q * x ** (q - 1.0)  # dg/dx
    return D * duration * x**q, strain_slope / (resistance * strain_slope + fy)


@njit(cache=True, error_model="numpy")
def rate_multiplier(
    first: float,
    second: float,
    a: float,
    b: float,
    strength: float,
    H: float,
    fy: float,
    D: float,
    q: float,
    duration: float,
) -> tuple[float, float]:
    """Multiplier lam = p / s of a return from two trial stresses, and the stiffness s ds / dlam.

    With p = D dt x^q and the equivalent stress s = strength + H p + fy x at the end of the step
    solves (first / (s + a p))^2 + (second / (s + b p))^2 = 1: the inverse root of the left side
    rises with x, with one stress or a = b convexly, and Newton's method is kept inside the bracket
    that the smaller of the resistances gives. Arguments: trial stresses (Pa) outside of the yield
    surface, their `a` and `b` in Pa; `strength` at the start of the step, isotropic `H`, static
    yield stress `fy` that the overstress multiplies, in Pa; D in 1/s, q, `duration` in s. NaN if it
    does not converge.
    """
    scale = D * duration
    excess = max(math.sqrt(first * first + second * second) - strength, 0.0)
    x = min(excess / fy, (excess / ((min(a, b) + H) * scale)) ** (1.0 / q))
    low, high = 0.0, x
    for _ in range(ITERATIONS):
        power = scale * x ** (q - 1.0)
        p, slope = power * x, q * power
        s, rise = strength + H * p + fy * x, H * slope + fy
        across, along = s + a * p, s + b * p
        u, v = first / across, second / along
        square = u * u + v * v
        u *= u * (rise + a * slope) / across
        v *= v * (rise + b * slope) / along
        change = (1.0 - math.sqrt(square)) * square / (u + v)
        if abs(change) <= CLOSED * (1.0 + x):
            # p' s - p s' = power (q strength + (q - 1) fy x)
            return p / s, s**3 * rise / (power * (q * strength + (q - 1.0) * fy * x))
        if change > 0.0:
            high = x
        else:
            low = x
        x -= change
        if not low <= x <= high:
            x = 0.5 * (low + high)
    return np.nan, np.nan
