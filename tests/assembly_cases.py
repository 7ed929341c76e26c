"""What tests of all kinds of elements do with an assembly, or with a group of one element."""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.elements import Bars


def alone(group: Any, length: float) -> Any:
    """The group of one element of that length (m) along x, in a structure of its own."""
    places = np.zeros((1, 36), dtype=np.int64)
    group.place(Bars(np.arange(6)[None], places, np.array([[length, 0.0]]), np.array([length])))
    return group


def random_state(assembly: PlanarAssembly, rng, scale: np.ndarray) -> np.ndarray:
    """Commit a plastic state and return random displacements beyond it, of a node's `scale`."""
    scales = np.tile(scale, assembly.size // 3)
    base = scales * rng.normal(size=assembly.size)
    assembly.assemble(base, None)
    assembly.commit(base)
    return base + scales * rng.normal(size=assembly.size)


def full_tangent(assembly: PlanarAssembly) -> np.ndarray:
    """Tangent of the last evaluation, column by column."""
    return np.stack([assembly.tangent_times(row) for row in np.eye(assembly.size)], axis=1)
