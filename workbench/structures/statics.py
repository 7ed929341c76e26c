"""The quasi-static drivers of single members: dead loads, and a push on one dof."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

import numpy as np
from numpy.typing import NDArray

from workbench.structures.assembly import PlanarAssembly
from workbench.structures.paths import Course, PathStep, lead, load

Array = NDArray[np.float64]


def apply_loads(
    assembly: PlanarAssembly, steps: int = 5, tolerance: float = 1e-10, most_cuts: int = 10
) -> None:
    """Bring the dead loads of the assembly on in equal steps, halved where needed, and commit.

    Raises `SolverError` when an equilibrium is not found.
    """
    if not np.any(assembly.load):
        return
    course = Course(assembly, assembly.load, 0, 1.0, np.zeros(assembly.size))
    course.factor = 0.0
    shares = np.arange(1, steps + 1) / steps
    for _ in load(course, shares, tolerance, most_cuts, inf, "dead load, share"):
        pass


def push(
    assembly: PlanarAssembly,
    dof: int,
    path: Array,
    tolerance: float = 1e-8,
    most_cuts: int = 10,
) -> Iterator[PathStep]:
    """Displacement control by a force: lead `dof` along `path` (m, relative to now).

    Arguments: `assembly`; `dof`; displacements `path` (steps,); `tolerance` of the residual over
    the largest force; `most_cuts`, how often an increment may be halved.
    Yields a `PathStep` for every point of the path; its factor is the force in N. Raises
    `SolverError`.
    """
    pattern = np.zeros(assembly.size)
    pattern[dof] = 1.0
    return lead(Course(assembly, pattern, dof, 1.0), path, tolerance, most_cuts, inf)
