"""Fiber sections: steel laws, strips with shear shares and residual stresses; kernels' tables.

The residual stresses of rolled I sections are those of ECCS 1984 (publication 33): flange tips and
mid-web in compression, the junctions in tension, each plate in equilibrium by itself. Flanges
are then cut across their width too.

**Second part.** Beams with fiber sections, all elements of a structure in one group.

Two local laws: the co-rotational Bernoulli beam, and the geometrically exact beam (Reissner, Simo).
"""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array, Indices
from workbench.base.errors import InputError
from workbench.base.fields import Declared, Number, checked
from workbench.mechanics.structures.elements import ElementGroup
from workbench.mechanics.structures.fibers import kernels as fiber_kernels
from workbench.mechanics.structures.fibers import reissner_kernels
from workbench.steel.materials import CowperSymonds, Steel
from workbench.steel.sections import Section
from workbench.steel.sections.section import (
    CircularTube,
    ISection,
    Rectangle,
    TurnedISection,
)

_MODULUS = Number(0.0, 1e30, "Pa", low_included=False)
_HARDENING = Number(0.0, 1e30, "Pa")
_ABOVE_ZERO = Number(0.0, 1e30, low_included=False)
_SHARE = Number(0.0, 0.9999)


def parameters(*values: float) -> Array:
    """Numbers of a law for the kernels, (8,)."""
    return np.array([*values, *[0.0] * (8 - len(values))])


def _rate_numbers(rate: CowperSymonds | None) -> tuple[float, float]:
    """D and q; without a rate they are not read."""
    return (1.0, 1.0) if rate is None else (rate.reference_rate, rate.exponent)


@dataclass(frozen=True)
class LinearHardening(Declared, table="law"):
    """Elastic, then plastic with linear hardening; without hardening moduli perfectly plastic.

    Arguments in Pa: `elastic_modulus`, `yield_stress`, `kinematic_modulus` (the yield range
    moves), `isotropic_modulus` (it grows); `rate`, sensitivity to the plastic strain rate, or
    None. State of a fiber: plastic strain and its accumulated amount.
    """

    elastic_modulus: float = checked(_MODULUS)
    yield_stress: float = checked(_MODULUS)
    kinematic_modulus: float = checked(_HARDENING, 0.0)
    isotropic_modulus: float = checked(_HARDENING, 0.0)
    rate: CowperSymonds | None = None

    states: ClassVar[int] = 2

    @classmethod
    def of(cls, steel: Steel, kinematic: float = 0.0, isotropic: float = 0.0) -> Self:
        """The law of a steel; of one that does not harden so, with these shares of its modulus."""
        modulus = steel.elastic_modulus
        hardening = steel.hardening_modulus or kinematic * modulus
        return cls(modulus, steel.yield_stress, hardening, isotropic * modulus, steel.rate)

    @property
    def code(self) -> int:
        """Number of the kernel."""
        return fiber_kernels.LINEAR if self.rate is None else fiber_kernels.LINEAR_RATE

    def parameters(self) -> Array:
        """Numbers for the kernels, (8,)."""
        moduli = self.elastic_modulus, self.kinematic_modulus
        strengths = self.yield_stress, self.isotropic_modulus
        return parameters(*moduli, *strengths, *_rate_numbers(self.rate))


@dataclass(frozen=True)
class MenegottoPinto(Declared, table="law"):
    """Smooth transition between the elastic and a hardening line, with the Bauschinger effect.

    Arguments: `elastic_modulus` and `yield_stress` in Pa; `hardening_ratio`, slope of the
    hardening line over the elastic modulus; `roundness` R0 of the first loading (large: sharp
    corner) and the factors `softening` and `softening_strain` (cR1, cR2) that lower it after
    reversals. Source: Menegotto and Pinto 1973; parameters after Filippou et al. 1983. A small
    partial unloading is treated as a full reversal, as usual with this law, so that stresses
    afterwards may overshoot the first branch slightly. State of a fiber: ten numbers, the first
    is the plastic strain.
    """

    elastic_modulus: float = checked(_MODULUS)
    yield_stress: float = checked(_MODULUS)
    hardening_ratio: float = checked(_SHARE, 0.01)
    roundness: float = checked(_ABOVE_ZERO, 20.0)
    softening: float = checked(_SHARE, 0.925)
    softening_strain: float = checked(_ABOVE_ZERO, 0.15)

    code: ClassVar[int] = fiber_kernels.MENEGOTTO_PINTO
    states: ClassVar[int] = 10
    rate: ClassVar[None] = None

    def parameters(self) -> Array:
        """Numbers for the kernels, (8,)."""
        moduli = self.elastic_modulus, 0.0, self.yield_stress, self.hardening_ratio
        return parameters(*moduli, self.roundness, self.softening, self.softening_strain)


@dataclass(frozen=True)
class ShearYielding(Declared, table="law"):
    """Elastic-plastic fiber that yields at sigma^2 + 3 tau^2 = fy^2, with associated flow.

    Arguments in Pa: `elastic_modulus`, `shear_modulus`, `yield_stress`, and the very small
    `kinematic_modulus` that only regularises (the centre of the yield ellipse moves by H eps_p
    and H gamma_p / 3), or a hardening that is meant; `rate`, sensitivity to the equivalent plastic
    strain rate, or None. State of a fiber: plastic strain and plastic shear strain. A fiber without
    shear strain follows the uniaxial law.
    """

    elastic_modulus: float = checked(_MODULUS)
    shear_modulus: float = checked(_MODULUS)
    yield_stress: float = checked(_MODULUS)
    kinematic_modulus: float = checked(_HARDENING, 0.0)
    rate: CowperSymonds | None = None

    states: ClassVar[int] = 2

    @property
    def code(self) -> int:
        """Number of the kernel."""
        return fiber_kernels.SHEARED if self.rate is None else fiber_kernels.SHEARED_RATE

    def parameters(self) -> Array:
        """Numbers for the kernels, (8,)."""
        moduli = self.elastic_modulus, self.kinematic_modulus, self.yield_stress, self.shear_modulus
        return parameters(*moduli, *_rate_numbers(self.rate))


Law = LinearHardening | MenegottoPinto | ShearYielding


PATTERNS = ("none", "triangular", "parabolic")
STOCKY = 1.2  # height over width up to which the stresses are the larger ones
PEAK = {True: 0.5, False: 0.3}  # of the yield stress, for stocky and slender profiles
ACROSS = 10  # strips of half a flange with residual stresses
SHARES = 49  # points of the curve of spreading yield, denser towards the full section


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
    law: Law
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


def lobatto(points: int) -> tuple[Array, Array]:
    """Places in 0..1 and weights of Gauss-Lobatto quadrature, both ends among the places."""
    inner = np.polynomial.Legendre.basis(points - 1)
    x = np.concatenate([[-1.0], np.sort(inner.deriv().roots().real), [1.0]])
    return 0.5 * (1.0 + x), 1.0 / (points * (points - 1) * inner(x) ** 2)


class SectionFibers(NamedTuple):
    """Heights `y` (f,) in m, areas (f,) in m2, shear shares (f,), residual stress over fy (f,).

    The shear share of a fiber is its shear strain over that of the section: 1 in a plate along
    the shear force, 0 in one across it, the cosine of the angle between in a round tube.
    """

    y: Array
    area: Array
    share: Array
    residual: Array


def section_fibers(section: Section, layers: int, pattern: str = "none") -> SectionFibers:
    """Cut a section into the strips of `Section.fibers`, flanges also across if need be.

    Arguments: `section`; even number of `layers` over the depth; `pattern` of residual stresses,
    whose peak over the yield stress is 0.5 for profiles up to 1.2 times as high as wide, 0.3 for
    others. Raises `InputError` for residual stresses in anything but an I section.
    """
    if pattern == "none":
        y, area = section.fibers(layers)
        share = _shares(section, layers)
        return SectionFibers(y, area, share, np.zeros_like(y))
    shape = section.shape
    if not isinstance(shape, ISection | TurnedISection):
        raise InputError(
            "option.residual_stress", pattern, "is known for I sections only", "use none"
        )
    turned = isinstance(shape, TurnedISection)
    high, wide = (shape.width, shape.height) if turned else (shape.height, shape.width)
    peak = PEAK[high <= STOCKY * wide]
    upright, across, *fillets = (group.strips() for group in shape.layers(layers // 2))
    edges = np.linspace(0.0, 1.0, len(upright[0]) + 1)
    cuts = np.linspace(0.0, 1.0, ACROSS + 1)
    count = len(across[0])
    # Flanges stand upright in the plane of bending about the weak axis, webs about the strong one.
    parts = [
        (*upright, np.ones_like(upright[0]), _residual(pattern, edges, flange=turned)),
        (
            np.repeat(across[0], ACROSS),
            np.repeat(across[1] / ACROSS, ACROSS),
            np.zeros(count * ACROSS),
            np.tile(_residual(pattern, cuts, flange=not turned), count),
        ),
        *((y, area, 0.0 * y, 0.0 * y) for y, area in fillets),
    ]
    y, area, share, residual = (np.concatenate(values) for values in zip(*parts, strict=True))
    return SectionFibers(
        np.concatenate([-y[::-1], y]),
        *(np.concatenate([values[::-1], values]) for values in (area, share, peak * residual)),
    )


def _residual(pattern: str, edges: Array, *, flange: bool) -> Array:
    """Residual stress over its peak in strips of half a flange, or of half a web, from its middle.

    Argument: `edges` of the strips over the half width.
    """
    if pattern == "triangular":
        return (1.0 - 2.0 * _middle(edges)) * (1.0 if flange else -1.0)
    return (1.0 - 3.0 * _square(edges)) * (0.5 if flange else -0.25)


def _middle(edges: Array) -> Array:
    """Mean of x over strips between `edges`."""
    return np.asarray(0.5 * (edges[1:] + edges[:-1]))


def _square(edges: Array) -> Array:
    """Mean of x squared over strips between `edges`."""
    a, b = edges[:-1], edges[1:]
    return np.asarray((a * a + a * b + b * b) / 3.0)


def _shares(section: Section, layers: int) -> Array:
    """Shear shares of the fibers of `Section.fibers`, in their order."""
    shape = section.shape
    groups = [group.strips()[0] for group in shape.layers(layers // 2)]
    if isinstance(shape, Rectangle):
        shares = [np.ones_like(y) for y in groups]
    elif isinstance(shape, CircularTube):
        middle = 0.5 * (shape.diameter - shape.wall)
        shares = [np.sqrt(np.maximum(1.0 - (y / middle) ** 2, 0.0)) for y in groups]
    else:  # plates along the shear force come first, fillets carry none
        shares = [np.full_like(y, float(i == 0)) for i, y in enumerate(groups)]
    share = np.concatenate(shares)[np.argsort(np.concatenate(groups), kind="stable")]
    return np.concatenate([share[::-1], share])


def spread_of_yield(section: BeamSection) -> tuple[float, Array, Array]:
    """How a cantilever yields on from its end, by its fibers and without axial force.

    Result: moment at first yield over the plastic one; plastic rotations of the end, over its
    length times the curvature at first yield, and the share of the way from first yield to the
    plastic moment that the end moment has gone there (points,). By virtual work, the moment being
    linear: plastic curvature times moment, integrated over the moment, over the end moment squared.
    """
    y, area = section.y / np.max(section.y), section.area
    bent = np.concatenate([np.linspace(1.0, 3.0, 41), np.geomspace(3.2, 200.0, 40)])
    moment = np.sum(np.clip(bent[:, None] * y, -1.0, 1.0) * y * area, axis=1)
    moment /= np.sum(np.abs(y) * area)
    plastic = bent - moment / moment[0]
    along = plastic * moment
    gained = 0.5 * (along[1:] + along[:-1]) * np.diff(moment)
    rotation = np.concatenate([[0.0], np.cumsum(gained)]) / moment**2
    share = 1.0 - np.linspace(1.0, 0.0, SHARES) ** 2
    known = (moment - moment[0]) / (moment[-1] - moment[0])
    return float(moment[0]), np.interp(share, known, rotation), share


def yielding_in_bending(section: BeamSection, inner: float | None = None) -> tuple[float, float]:
    """Yield and bounding surface of a section by its fibers in bending without axial force.

    Argument: size `inner` of the yield surface (None: where the first fiber yields, at least a
    half). Result: that size; the curvature g / M_p (1/m) that gives the moment of the fibers half
    of the way from first yield to the plastic moment, 1 - m = d / (1 + d k M_p / g), d = 1 - inner,
    after a plastic curvature k.
    """
    stress = np.zeros_like(section.y) if section.initial_stress is None else section.initial_stress
    modulus, limit = section.law.elastic_modulus, section.law.parameters()[2]
    bent = np.geomspace(0.1, 200.0, 800) * limit / modulus / np.max(section.y)
    stresses = np.clip(modulus * np.outer(bent, section.y) + stress, -limit, limit)
    moment = stresses @ (section.y * section.area)
    full = limit * float(np.sum(np.abs(section.y) * section.area))
    bending = modulus * section.radius_squared * float(np.sum(section.area))
    elastic = np.min((limit - np.abs(stress)) / np.maximum(np.abs(section.y), 1e-12))
    first = float(elastic) * bending / modulus / full
    inner = max(first, 0.5) if inner is None else inner
    apart, left = 1.0 - inner, 0.5 * (1.0 - max(first, inner))
    if left == 0.0:
        return inner, 0.0
    plastic = float(np.interp(1.0 - left, moment / full, bent - moment / bending))
    return inner, plastic * apart * left / (apart - left)


class FiberElements(ElementGroup):
    """Beams with fiber sections.

    Arguments: `nodes` (elements, 2), node numbers; `section_of` (elements,), which of `sections`
    each element has; `sections`.
    """

    def __init__(
        self, nodes: ArrayLike, section_of: ArrayLike, sections: Sequence[BeamSection]
    ) -> None:
        of = np.asarray(section_of, dtype=np.int64)
        self.sections, self._sections = tuple(sections), section_tables(of, sections)
        self.tables = (self._sections,)
        states = max(section.law.states for section in sections)
        state = self._at_rest(len(of), (states, self._sections.y.shape[1]))
        mass = np.array([section.mass_per_length for section in sections])[of]
        radius_squared = np.array([section.radius_squared for section in sections])[of]
        super().__init__(nodes, state, mass, radius_squared)

    @abstractmethod
    def _at_rest(self, count: int, fibers: tuple[int, int]) -> Any:
        """State of so many elements at rest, `fibers` (states, fibers) at each point."""

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


class Points(NamedTuple):
    """Quadrature along the elements: `xi` in 0..1 and `weights`, (elements, points).

    Also (points,), the same in all. `spread` of the axial strain over the points of balanced
    elements, else zero.
    """

    xi: Array
    weights: Array
    spread: Array | float = 0.0


def gauss_rule(points: int = 2) -> Points:
    """Gauss-Legendre points, alike in every element."""
    abscissae, weights = np.polynomial.legendre.leggauss(points)
    return Points(0.5 * (1.0 + abscissae), 0.5 * weights)


def radau_rule(hinge_at_end: ArrayLike) -> Points:
    """Two Gauss-Radau points: one at the end where a hinge is expected, one a third from the other.

    Argument: `hinge_at_end` (elements,), True for end 2, False for end 1. Elastic stiffness is
    exact as with two Gauss points, and the plastic section is sampled where the moment is
    largest, so that the moment capacity at that end has no error of the order of the length.
    """
    at_end = np.asarray(hinge_at_end, dtype=bool)[:, None]
    abscissae = np.where(at_end, [[1.0 / 3.0, 1.0]], [[0.0, 2.0 / 3.0]])
    weights = np.where(at_end, [[0.75, 0.25]], [[0.25, 0.75]])
    return Points(abscissae, weights)


class FiberState(NamedTuple):
    """State of all co-rotational elements.

    `fibers` (e, points, states, f); `local` (e, 3): N, M1, M2; `inner` (e, 5): elongation, bending
    rotations, shear strain, axial amplitude.
    """

    fibers: Array
    local: Array
    inner: Array


class FiberBeams(FiberElements):
    """Two-node co-rotational Bernoulli beams.

    Arguments: those of `FiberElements` (sections without laws that yield in shear); `rule`,
    points along each element (default: two Gauss points); `balanced`: the axial strain differs
    between the two points such that N is the same (without it the axial displacement is linear, as
    in the classical displacement-based element).
    """

    kernels: Any = fiber_kernels
    _old: FiberState

    def __init__(
        self,
        nodes: ArrayLike,
        section_of: ArrayLike,
        sections: Sequence[BeamSection],
        rule: Points | None = None,
        balanced: bool = False,
    ) -> None:
        xi, weights, _ = gauss_rule() if rule is None else rule
        if balanced and weights.shape[-1] != 2:
            raise ValueError("the axial force can be balanced between two points only")
        # no mean: sum(w spread) = 0
        spread = weights[..., ::-1] * [1.0, -1.0] if balanced else np.zeros_like(weights)
        shape = len(np.atleast_1d(section_of)), weights.shape[-1]
        every = (np.broadcast_to(each, shape).copy() for each in (xi, weights, spread))
        self._points = Points(*every)
        super().__init__(nodes, section_of, sections)
        self.tables = self._points, self._sections

    def _at_rest(self, count: int, fibers: tuple[int, int]) -> FiberState:
        points = self._points.xi.shape[1]
        return FiberState(
            np.zeros((count, points, *fibers)), np.zeros((count, 3)), np.zeros((count, 5))
        )

    @property
    def elongations(self) -> Array:
        """Committed change of chord length of the elements (elements,), in m."""
        return self._old.inner[:, 0]

    @property
    def shear_strains(self) -> Array:
        """Committed elastic shear strain of the elements (elements,)."""
        return self._old.inner[:, 3]

    @property
    def plastic_strains(self) -> Array:
        """Committed plastic strains (elements, fibers), the mean along each element."""
        weights = self._points.weights[:, :, None]
        return np.asarray(np.sum(weights * self._old.fibers[:, :, 0], axis=1))


class BeamState(NamedTuple):
    """State of exact beams: `fibers` (e, states, f); `stress` N, V, M and `strain` (e, 3)."""

    fibers: Array
    stress: Array
    strain: Array


class ReissnerBeams(FiberElements):
    """Two-node geometrically exact beams with one point; arguments those of `FiberElements`."""

    kernels: Any = reissner_kernels
    crumples: ClassVar[bool] = False  # a short one may shorten by more than its length
    _old: BeamState

    def _at_rest(self, count: int, fibers: tuple[int, int]) -> BeamState:
        return BeamState(np.zeros((count, *fibers)), *np.zeros((2, count, 3)))

    @property
    def section_forces(self) -> Array:
        """Committed N, V, M of the elements (elements, 3)."""
        return self._old.stress

    @property
    def local_forces(self) -> Array:
        """Committed N and end moments M1, M2 (elements, 3); internal moments are -M1 and M2."""
        force, strain = self._old.stress, self._old.strain
        N, V, M = force.T
        mean = 0.5 * self.lengths * (N * strain[:, 1] - V * (1.0 + strain[:, 0]))
        return np.stack([N, mean - M, mean + M], axis=1)

    @property
    def elongations(self) -> Array:
        """Committed change of length of the axis of the elements (elements,), in m."""
        return np.asarray(self._old.strain[:, 0] * self.lengths)

    @property
    def shear_forces(self) -> Array:
        """Committed shear force of the elements (elements,), in N."""
        return self._old.stress[:, 1]

    @property
    def shear_strains(self) -> Array:
        """Committed shear strain of the elements (elements,)."""
        return self._old.strain[:, 1]

    @property
    def plastic_strains(self) -> Array:
        """Committed plastic strains (elements, fibers), the first state of every law."""
        return self._old.fibers[:, 0]
