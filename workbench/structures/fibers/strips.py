"""Fibers of a section with what beams need beyond area: shear shares and residual stresses.

The residual stresses of rolled I sections are those of ECCS 1984 (publication 33): flange tips and
mid-web in compression, the junctions in tension, each plate in equilibrium by itself. Flanges
are then cut across their width too.
"""

from typing import NamedTuple

import numpy as np

from workbench.arrays import Array
from workbench.errors import InputError
from workbench.sections import Section
from workbench.sections.shapes import CircularTube, ISection, Rectangle

PATTERNS = ("none", "triangular", "parabolic")
STOCKY = 1.2  # height over width up to which the stresses are the larger ones
PEAK = {True: 0.5, False: 0.3}  # of the yield stress, for stocky and slender profiles
ACROSS = 10  # strips of half a flange with residual stresses


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
