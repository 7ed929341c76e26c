"""Resistance of the plastic mechanism of a column: hinge groups, and a curve with named events.

The curve is a piecewise polynomial force over displacement.
"""

from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array
from workbench.base.errors import OutOfDomainError
from workbench.mechanics.frames.members import shear_stiffness
from workbench.models.elastic_springs import beam_springs, thesis_springs
from workbench.models.resistance import kernels
from workbench.scenarios import Column

INTERACTIONS = LINEAR, SECTION = ("linear", "section")  # yield surfaces of N and M

Groups = tuple[Array, Array, Array, float, float, float, float, float, float]


class PlasticMechanism(NamedTuple):
    """Two rigid bars with hinge groups that yield in bending and axial force.

    Arguments: `groups`, names out of base, hit, head (a pinned end has no group; the two hinges
    at the impact point, which carry the same moment, are one group); per group `rotation_rates`
    s = d(rotation)/dv (1/m), `flexibilities` phi (rad/(N m)); `lengths` of the two bars (m);
    `plastic_moment` (N m), `squash_load` (N); `axial_force` before the push (N, tension
    positive); `axial_flexibility` of bars and restraint (m/N), infinite if free to shorten;
    `corner`, axial force (N) up to which the plastic moment is not reduced; beyond it falls in a
    straight line.
    """

    groups: tuple[str, ...]
    rotation_rates: Array
    flexibilities: Array
    lengths: tuple[float, float]
    plastic_moment: float
    squash_load: float
    axial_force: float
    axial_flexibility: float
    corner: float = 0.0

    def capacity(self, axial_force: Array) -> Array:
        """Moment (N m) that hinges carry beside axial forces (N)."""
        share = (self.squash_load - np.abs(axial_force)) / (self.squash_load - self.corner)
        return np.asarray(self.plastic_moment * np.minimum(1.0, share))

    @property
    def carries(self) -> float:
        """Axial load (N) that exhausts the lateral stiffness of the bars on their springs."""
        stiffness = self.rotation_rates * self.moments_per_displacement
        load: float = stiffness.sum(axis=0) / self.slope_sum
        return load

    @property
    def slope_sum(self) -> float:
        """Sum kappa of the inverse lengths, in 1/m."""
        return 1.0 / self.lengths[0] + 1.0 / self.lengths[1]

    @property
    def moments_per_displacement(self) -> Array:
        """Elastic moment K = s / phi of each group per displacement, in N (N m/m)."""
        return np.asarray(self.rotation_rates / self.flexibilities)

    @property
    def kernel(self) -> Groups:
        """Values for the kernels: s, K, phi, kappa, M_p, N_p, N_0, c_ax, N_c."""
        moments, kappa = self.moments_per_displacement, self.slope_sum
        return self.rotation_rates, moments, self.flexibilities, kappa, *self[4:]


def mechanism_of(
    column: Column,
    rotational_stiffness: float | None = None,
    interaction: str = SECTION,
    uniform: bool = False,
) -> PlasticMechanism:
    """The mechanism of a column.

    Arguments: `column`; `rotational_stiffness`, the factor c of the hinge stiffness c EI / l of
    a bar of length l (Heng 2017: 6; None: springs that make the bars the elastic column under a
    force at the impact point, or a `uniform` load); `interaction`, yield surface of straight lines
    with the area of the exact envelope (section) or from M_p to N_p (linear, Heng 2017). A head
    that is fixed has no restraint flexibility; the restraint of any other head is its spring, and
    without one the head is free to shorten.
    Raises `OutOfDomainError` if the axial load exhausts the lateral stiffness of the mechanism.
    """
    mechanism = any_mechanism(column, rotational_stiffness, interaction, uniform)
    if mechanism.carries <= column.axial_load:
        raise OutOfDomainError(
            f"the axial load {column.axial_load / 1e3:.4g} kN exhausts the lateral stiffness of "
            f"the two-bar mechanism, which carries {mechanism.carries / 1e3:.4g} kN: "
            "reduce the load"
        )
    return mechanism


def any_mechanism(
    column: Column,
    rotational_stiffness: float | None = None,
    interaction: str = SECTION,
    uniform: bool = False,
) -> PlasticMechanism:
    """Mechanism as of `mechanism_of`, also if it `carries` no such load; of a stack with arrays."""
    properties = column.properties
    if rotational_stiffness is None:
        stiffness = shear_stiffness(column.strength_section, column.steel)
        springs = beam_springs(column, stiffness, uniform=uniform)
    else:
        springs = thesis_springs(column, rotational_stiffness)
    corner = column.strength_section.interaction_corner() if interaction == SECTION else 0.0
    below, above = 1.0 / column.length_below, 1.0 / column.length_above
    all_groups = (
        ("base", below, springs.base),
        ("hit", below + above, springs.below + springs.above),
        ("head", above, springs.head),
    )
    groups, rates, flexibilities = zip(*(g for g in all_groups if np.all(g[2] < inf)), strict=True)
    return PlasticMechanism(
        groups,
        np.array(rates),
        np.array(flexibilities),
        (column.length_below, column.length_above),
        properties.plastic_moment,
        properties.squash_load,
        -column.axial_load,
        axial_flexibility(column),
        corner * properties.squash_load,
    )


def axial_flexibility(column: Column) -> float:
    """Shortening (m/N) of the column and its restraint per axial force, infinite if it is free."""
    flexibility = column.length / (column.steel.elastic_modulus * column.properties.area)
    if column.head == "fixed":
        return flexibility
    with np.errstate(divide="ignore"):
        restraint: float = np.divide(1.0, column.restraint_stiffness)
    return flexibility + restraint


Pieces: TypeAlias = Any  # array of kernels.PIECE
START, YIELDS, LOAD, LAST, NO_AXIAL_FORCE, TENSION, CATENARY, CORNER = range(8)  # events
_NAMES = (
    "mechanism load",
    "last hinge yields",
    "axial force vanishes",
    "tension grows",
    "catenary",
    "corner of the yield surface",
)
_YIELDS = {"base": "base yields", "hit": "impact point yields", "head": "head yields"}


def _first(values: Array) -> Array:
    """The last axis first: rows of each component."""
    return values.T if values.ndim < 3 else np.moveaxis(values, -1, 0)


def straight_pieces(v: Array, force: Array) -> Pieces:
    """Pieces of the straight lines between points: displacements (m) from 0 on, and forces (N)."""
    pieces = np.zeros(len(v) - 1, kernels.PIECE)
    pieces["start"], pieces["c"][:, 0] = v[:-1], force[:-1]
    pieces["c"][:, 1] = np.diff(force) / np.diff(v)
    return pieces


class Event(NamedTuple):
    """Something that happens along a curve: its name, displacement (m) and force (N)."""

    name: str
    displacement: float
    force: float


@dataclass(frozen=True, eq=False)
class ResistanceCurve:
    """Monotonic resistance of the column at its impact point.

    Arguments: `shape`, its name; `mechanism` it belongs to; `pieces`; `elastic_limit`,
    displacement of the first yielding (m). The cubic shape does not know the axial force, and
    only the analytic one the hinge moments. `end`, displacement (m) behind which nothing is known
    of a curve that was given. Negative displacements mirror the curve.
    """

    shape: str
    mechanism: PlasticMechanism
    pieces: Pieces
    elastic_limit: float
    end: float = inf

    def __post_init__(self) -> None:
        kernels.sum_up(self.pieces)

    @property
    def initial_stiffness(self) -> float:
        """Slope k_0 at no displacement, in N/m."""
        return float(self.pieces["c"][0, 1])

    @property
    def starts(self) -> Array:
        """Displacements at which the pieces begin, in m."""
        return np.asarray(self.pieces["start"])

    @property
    def knows_moments(self) -> bool:
        """Whether moments and rotations of the hinge groups belong to the curve."""
        return self.shape == "analytic"

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Events along the curve, in order."""
        events = []
        for v, event, group in self.pieces[["start", "event", "group"]][1:].tolist():
            yields = event == YIELDS
            name = _YIELDS[self.mechanism.groups[group]] if yields else _NAMES[event - LOAD]
            events.append(Event(name, v, float(self.force(v))))
        return tuple(events)

    @cached_property
    def lost_at(self) -> float:
        """Displacement at which the resistance falls to zero, in m (inf: it never does)."""
        return float(kernels.lost_at(self.pieces))

    def _local(self, displacement: ArrayLike) -> tuple[Pieces, Array, Array]:
        """Pieces at displacements, distances from their starts, and coefficients of the force."""
        v = np.abs(np.asarray(displacement, dtype=float))
        piece = self.pieces[np.searchsorted(self.pieces["start"], v, side="right") - 1]
        return piece, v - piece["start"], _first(piece["c"])

    def force(self, displacement: ArrayLike) -> Array:
        """Force (N) at displacements (m), any shape."""
        _, x, c = self._local(displacement)
        sign = np.sign(np.asarray(displacement, dtype=float))
        return np.asarray(sign * (c[0] + x * (c[1] + x * (c[2] + x * c[3]))))

    def tangent(self, displacement: ArrayLike) -> Array:
        """Slope (N/m) at displacements (m), any shape; at a breakpoint that of the piece after."""
        _, x, c = self._local(displacement)
        return np.asarray(c[1] + x * (2.0 * c[2] + 3.0 * x * c[3]))

    def work(self, displacement: ArrayLike) -> Array:
        """Work (J) of the force from the origin to displacements (m), any shape."""
        piece, x, c = self._local(displacement)
        within = x * (c[0] + x * (c[1] / 2.0 + x * (c[2] / 3.0 + x * c[3] / 4.0)))
        return np.asarray(piece["work"] + within)

    def unloading_stiffness(self, displacement: float) -> float:
        """Slope (N/m) of the unloading from a displacement (m) that has yielded.

        The initial slope, as Heng 2017 has it; where the curve has been steeper than that (a
        slender column in tension), its steepest slope, or unloading would return more energy
        than was put in.
        """
        return float(kernels.unloading_stiffness(self.pieces, abs(displacement)))

    def residual(self, displacement: float) -> float:
        """Permanent displacement (m) after unloading from `displacement` (m)."""
        return float(kernels.residual(self.pieces, self.elastic_limit, displacement))

    def displacement_at(self, energy: float) -> float:
        """Displacement (m) at which the work reaches `energy` (J).

        Raises `OutOfDomainError` if the resistance is lost before.
        """
        if energy <= 0.0:
            return 0.0
        lost = self.lost_at
        if np.isfinite(lost) and energy >= self.work(lost):
            raise OutOfDomainError(
                f"the resistance of the column is lost at {lost:.4g} m, after "
                f"{float(self.work(lost)) / 1e3:.4g} kJ of the {energy / 1e3:.4g} kJ to absorb"
            )
        return float(kernels.displacement_at(self.pieces, energy, lost))

    def axial_force(self, displacement: ArrayLike) -> Array:
        """Axial force (N, tension positive) at displacements (m) on the curve.

        Raises ValueError for a shape that does not know it.
        """
        if self.shape in ("cubic", "given"):
            raise ValueError(f"the {self.shape} resistance does not know the axial force")
        piece, x, _ = self._local(displacement)
        c = _first(piece["axial"])
        return np.asarray(c[0] + x * (c[1] + x * c[2]))

    def moments(self, displacement: ArrayLike) -> Array:
        """Moments (N m) of the groups, (groups, ...), at displacements (m) >= 0 on the curve.

        All are positive; raises ValueError for a shape that does not know them.
        """
        if not self.knows_moments:
            raise ValueError(f"the {self.shape} resistance does not know the hinge moments")
        mechanism, (piece, _, _) = self.mechanism, self._local(displacement)
        v = np.asarray(displacement, dtype=float)
        capacity = mechanism.capacity(self.axial_force(v))
        elastic = np.multiply.outer(mechanism.moments_per_displacement, v)
        plastic = _first(piece["plastic"])[: len(mechanism.groups)] > 0
        return np.where(plastic, capacity, elastic)

    def plastic_rotations(self, displacement: ArrayLike) -> Array:
        """Plastic rotations (rad) of the groups, (groups, ...), as `moments`."""
        v = np.asarray(displacement, dtype=float)
        flexibility = self.mechanism.flexibilities.reshape((-1,) + (1,) * v.ndim)
        turned = np.multiply.outer(self.mechanism.rotation_rates, v)
        return np.asarray(turned - flexibility * self.moments(v))

    def largest_shear(self, displacement: float) -> Array:
        """Largest shear force (N) of the bars below and above met up to `displacement` (m).

        V = (sum of the moments at both ends) / length; piecewise quadratic, so its extremes lie
        at the breakpoints or at extremes of the axial force. Raises ValueError as `moments`.
        """
        places, largest = self._shear_so_far
        before = largest[np.searchsorted(places, displacement, side="right") - 1]
        return np.asarray(np.maximum(before, self._shear(displacement)))

    @cached_property
    def _shear_so_far(self) -> tuple[Array, Array]:
        """Places (m) at which shear forces may turn, and the largest ones up to each."""
        curved = self.pieces[self.pieces["axial"][:, 2] > 0.0]
        extremes = curved["start"] - 0.5 * curved["axial"][:, 1] / curved["axial"][:, 2]
        # a breakpoint belongs to the piece after it; moments are continuous there
        places = np.concatenate([self.starts, extremes[extremes > 0.0]])
        places.sort()
        return places, np.maximum.accumulate(self._shear(places))

    def _shear(self, displacement: ArrayLike) -> Array:
        """Shear forces (N) of the bars below and above, (..., 2), as `moments`."""
        at = dict(zip(self.mechanism.groups, self.moments(displacement), strict=True))
        both = np.array([at["hit"] + at.get("base", 0.0), at["hit"] + at.get("head", 0.0)])
        return np.asarray(both.T / self.mechanism.lengths)
