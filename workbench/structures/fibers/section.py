"""Fiber sections: strips of a section, with shear shares and residual stresses; laws as tables.

The residual stresses of rolled I sections are those of ECCS 1984 (publication 33): flange tips and
mid-web in compression, the junctions in tension, each plate in equilibrium by itself. Flanges
are then cut across their width too.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.arrays import Array, Indices
from workbench.errors import InputError
from workbench.sections import Section
from workbench.sections.shapes import CircularTube, ISection, Rectangle
from workbench.structures.fibers.laws import ShearYielding, UniaxialLaw

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


def section_fibers(
    section: Section, layers: int, pattern: str = "none", peak: float | None = None
) -> SectionFibers:
    """Cut a section into the strips of `Section.fibers`, flanges also across if need be.

    Arguments: `section`; even number of `layers` over the depth; `pattern` of residual stresses;
    their `peak` over the yield stress (None: 0.5 for profiles up to 1.2 times as high as wide,
    0.3 for others). Raises `InputError` for residual stresses in anything but an I section.
    """
    if pattern == "none":
        y, area = section.fibers(layers)
        share = _shares(section, layers)
        return SectionFibers(y, area, share, np.zeros_like(y))
    shape = section.shape
    if not isinstance(shape, ISection):
        raise InputError(
            "option.residual_stress", pattern, "is known for I sections only", "use none"
        )
    if peak is None:
        peak = PEAK[shape.height <= STOCKY * shape.width]
    web, flange, *fillets = (group.strips() for group in shape.layers(layers // 2))
    edges = np.linspace(0.0, 1.0, len(web[0]) + 1)
    cuts = np.linspace(0.0, 1.0, ACROSS + 1)
    if pattern == "triangular":
        in_web, in_flange = 2.0 * _middle(edges) - 1.0, 1.0 - 2.0 * _middle(cuts)
    else:
        in_web, in_flange = 0.25 * (3.0 * _square(edges) - 1.0), 0.5 * (1.0 - 3.0 * _square(cuts))
    count = len(flange[0])
    parts = [
        (*web, np.ones_like(web[0]), in_web),
        (
            np.repeat(flange[0], ACROSS),
            np.repeat(flange[1] / ACROSS, ACROSS),
            np.zeros(count * ACROSS),
            np.tile(in_flange, count),
        ),
        *((y, area, 0.0 * y, 0.0 * y) for y, area in fillets),
    ]
    y, area, share, residual = (np.concatenate(values) for values in zip(*parts, strict=True))
    return SectionFibers(
        np.concatenate([-y[::-1], y]),
        *(np.concatenate([values[::-1], values]) for values in (area, share, peak * residual)),
    )


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
