"""Sections and structures that the tests of geometrically exact beams share."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.fibers import BeamSection
from workbench.mechanics.structures.fibers.section import (
    LinearHardening,
    MenegottoPinto,
    ReissnerBeams,
    ShearYielding,
)
from workbench.steel.materials import MILD_STEEL

E, FY, SIDE, LAYERS = 210e9, 355e6, 0.2, 20
G = E / 2.6
DEPTH = ((np.arange(LAYERS) + 0.5) / LAYERS - 0.5) * SIDE
AREA = np.full(LAYERS, SIDE**2 / LAYERS)
SHEAR = {"shear_stiffness": G * SIDE**2 * 5.0 / 6.0}
LAWS = {
    "perfect": (LinearHardening(E, FY, 1e-6 * E), SHEAR),
    "hardening": (LinearHardening(E, FY, 1e-2 * E, 2e-2 * E), SHEAR),
    "rate": (LinearHardening(E, FY, 1e-2 * E, rate=MILD_STEEL), SHEAR),
    "menegotto-pinto": (MenegottoPinto(E, FY, 0.01), SHEAR),
    "shear": (ShearYielding(E, G, FY, 1e-6 * E), {"shear_share": np.ones(LAYERS)}),
    "shear-rate": (
        ShearYielding(E, G, FY, 1e-2 * E, MILD_STEEL),
        {"shear_share": np.ones(LAYERS)},
    ),
}


def square(name: str = "perfect", **more: object) -> BeamSection:
    """A solid square of 0.2 m with one of the laws."""
    law, shear = LAWS[name]
    return BeamSection(DEPTH, AREA, law, 314.0, **{**shear, **more})


def elastic(radius: float, bending: float = 1.0, shear: float = 1.0) -> BeamSection:
    """Two elastic fibers: I / A = radius^2, EI = bending, GA = shear times EA."""
    area = np.full(2, 0.5 * bending / radius**2)
    law = LinearHardening(1.0, 1e30)
    return BeamSection(radius * np.array([-1.0, 1.0]), area, law, 1.0, shear * bending / radius**2)


def chain(points: object, section: BeamSection, lumped: bool = False) -> PlanarAssembly:
    """Beams from point to point."""
    at = np.asarray(points, dtype=float)
    nodes = np.stack([np.arange(len(at) - 1), np.arange(1, len(at))], axis=1)
    group = ReissnerBeams(nodes, np.zeros(len(nodes), dtype=np.int64), [section])
    return PlanarAssembly(at, [group], lumped=lumped)


def straight(length: float, elements: int, section: BeamSection, **more: bool) -> PlanarAssembly:
    """A straight chain along x."""
    x = np.linspace(0.0, length, elements + 1)
    return chain(np.stack([x, 0.0 * x], axis=1), section, **more)


def thesis_frame(size: float, lumped: bool = False) -> tuple[PlanarAssembly, int]:
    """Frame of Heng 2017, section 5.3, of squares, and the dof that is hit.

    Four bays of 3 m, two storeys of 4 m, clamped bases; the middle column is hit 0.8 m above its
    base. `size` of all elements in m.
    """
    numbers: dict[tuple[float, float], int] = {}
    elements: list[tuple[int, int]] = []

    def member(x0: float, y0: float, x1: float, y1: float) -> None:
        count = round(float(np.hypot(x1 - x0, y1 - y0)) / size)
        points = [
            (round(x0 + (x1 - x0) * i / count, 6), round(y0 + (y1 - y0) * i / count, 6))
            for i in range(count + 1)
        ]
        line = [numbers.setdefault(point, len(numbers)) for point in points]
        elements.extend(pairwise(line))

    for x in 3.0 * np.arange(5):
        for low, high in ((0.0, 0.8), (0.8, 4.0), (4.0, 8.0)):
            member(x, low, x, high)
    for y in (4.0, 8.0):
        for x in 3.0 * np.arange(4):
            member(x, y, x + 3.0, y)
    group = ReissnerBeams(elements, np.zeros(len(elements), dtype=np.int64), [square()])
    frame = PlanarAssembly(list(numbers), [group], lumped=lumped)
    bases = [numbers[(3.0 * i, 0.0)] for i in range(5)]
    frame.hold([frame.dof(node, c) for node in bases for c in ("u", "v", "rotation")])
    return frame, frame.dof(numbers[(6.0, 0.8)], "u")
