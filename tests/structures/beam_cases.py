"""Structures of fiber beams that several tests use."""

from __future__ import annotations

import numpy as np

from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.fibers import BeamSection
from workbench.mechanics.structures.fibers.section import FiberBeams, LinearHardening, radau_rule

E_STEEL, YIELD = 210e9, 355e6
KINDS = {
    "interpolated": {},
    "balanced": {"balanced": True},
    "sheared": {"shear": 8e8},
    "balanced-sheared": {"balanced": True, "shear": 8e8},
}


def rectangle(
    height: float = 0.2,
    width: float = 0.2,
    layers: int = 20,
    yield_stress: float = YIELD,
    hardening: float = 1e-6 * E_STEEL,
    mass: float = 314.0,
    shear: float = 0.0,
) -> BeamSection:
    """Rectangle in equal layers."""
    edges = np.linspace(-0.5 * height, 0.5 * height, layers + 1)
    area = np.full(layers, width * height / layers)
    middle = 0.5 * (edges[1:] + edges[:-1])
    law = LinearHardening(E_STEEL, yield_stress, hardening)
    return BeamSection(middle, area, law, mass, shear)


def plates(flange: int, web: int) -> BeamSection:
    """HEB 220 as three plates with hardening 1e-4 E, layered as the OpenSees model was."""
    depth, wall, thickness, width = 0.22, 0.0095, 0.016, 0.22
    parts = []
    for low, high, breadth, count in (
        (-depth / 2, -depth / 2 + thickness, width, flange),
        (-depth / 2 + thickness, depth / 2 - thickness, wall, web),
        (depth / 2 - thickness, depth / 2, width, flange),
    ):
        edges = np.linspace(low, high, count + 1)
        parts.append((0.5 * (edges[1:] + edges[:-1]), np.full(count, breadth * np.diff(edges))))
    y, area = (np.concatenate(p) for p in zip(*parts, strict=True))
    return BeamSection(y, area, LinearHardening(E_STEEL, YIELD, 1e-4 * E_STEEL), 71.4)


def chain(
    lengths,
    section: BeamSection,
    *,
    angle: float = 0.0,
    balanced: bool = False,
    lumped: bool = False,
) -> tuple[PlanarAssembly, FiberBeams]:
    """Beams in a row from the origin, at an angle to the x axis."""
    lengths = np.asarray(lengths, dtype=float)
    count = len(lengths)
    nodes = np.stack([np.arange(count), np.arange(1, count + 1)], axis=1)
    middle = np.cumsum(lengths) - 0.5 * lengths
    rule = radau_rule(middle > 0.5 * lengths.sum()) if balanced else None
    beams = FiberBeams(nodes, np.zeros(count, int), [section], rule, balanced=balanced)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    where = np.stack([along * np.cos(angle), along * np.sin(angle)], axis=1)
    return PlanarAssembly(where, [beams], lumped=lumped), beams


def of_kind(kind: str, lengths, **section) -> tuple[PlanarAssembly, FiberBeams]:
    """A chain of one of the `KINDS` of element."""
    options = dict(KINDS[kind])
    shear = options.pop("shear", 0.0)
    return chain(lengths, rectangle(shear=shear, **section), **options)


def clamp(assembly: PlanarAssembly, node: int) -> None:
    """Hold a node."""
    assembly.hold([assembly.dof(node, name) for name in ("u", "v", "rotation")])
