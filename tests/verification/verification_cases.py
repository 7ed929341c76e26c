"""Beams of both formulations for the verification suite, and how an order is measured."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.fibers import BeamSection
from workbench.mechanics.structures.fibers.section import FiberBeams, LinearHardening, ReissnerBeams

FORMULATIONS = ("reissner", "corotational")
E, FY, SIDE, LAYERS, MASS = 210e9, 355e6, 0.2, 20, 314.0
Y = ((np.arange(LAYERS) + 0.5) / LAYERS - 0.5) * SIDE
AREA = np.full(LAYERS, SIDE**2 / LAYERS)
SECOND = float(np.sum(Y**2 * AREA))
SHEAR = E / 2.6 * SIDE**2 * 5.0 / 6.0
PLASTIC_MOMENT, SQUASH = FY * SIDE**3 / 4.0, FY * SIDE**2
NEVER = 1e30


def group(kind: str, elements: Sequence[Sequence[int]], y, area, law: LinearHardening, mass, shear):
    """Elements of one formulation."""
    of = np.zeros(len(elements), dtype=np.int64)
    if kind == "reissner":
        return ReissnerBeams(elements, of, [BeamSection(y, area, law, mass, shear)])
    return FiberBeams(elements, of, [BeamSection(y, area, law, mass)])


def steel_chain(kind: str, points, yield_stress=FY, hardening=1e-7, lumped=False) -> PlanarAssembly:
    """Solid squares of 0.2 m from point to point, with shear strain only in Reissner's beam."""
    at = np.asarray(points, dtype=float)
    elements = list(pairwise(range(len(at))))
    law = LinearHardening(E, yield_stress, hardening * E)
    beams = group(kind, elements, Y, AREA, law, MASS, SHEAR)
    return PlanarAssembly(at, [beams], lumped=lumped)


def slender_chain(kind: str, points, radius: float = 1e-3) -> PlanarAssembly:
    """Elastic beams with EI = 1, mass 1 per length and a radius of gyration near zero."""
    at = np.asarray(points, dtype=float)
    elements = list(pairwise(range(len(at))))
    area = np.full(2, 0.5 / radius**2)
    y = radius * np.array([-1.0, 1.0])
    beams = group(kind, elements, y, area, LinearHardening(1.0, NEVER), 1.0, 1.0 / radius**2)
    return PlanarAssembly(at, [beams])


def along(length: float, elements: int, angle: float = 0.0) -> np.ndarray:
    """Points on a straight line from the origin."""
    x = np.linspace(0.0, length, elements + 1)
    return np.stack([x * np.cos(angle), x * np.sin(angle)], axis=1)


def hold(assembly: PlanarAssembly, node: int, *names: str) -> None:
    """Hold components of a node, all without names."""
    assembly.hold([assembly.dof(node, name) for name in names or ("u", "v", "rotation")])


def matrix(product, size: int) -> np.ndarray:
    """The full matrix of a product."""
    return np.stack([product(unit) for unit in np.eye(size)], axis=1)


def free(assembly: PlanarAssembly) -> np.ndarray:
    """The dofs that are not held."""
    return np.setdiff1d(np.arange(assembly.size), assembly.held)


def orders(errors: Sequence[float]) -> np.ndarray:
    """Observed orders between successive halvings."""
    values = np.abs(np.asarray(errors))
    return np.log2(values[:-1] / values[1:])
