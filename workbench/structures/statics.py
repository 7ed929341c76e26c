"""The quasi-static drivers of single members: dead loads, and a push on one dof."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.structures.assembly import PlanarAssembly
from workbench.structures.ledger import StepEnergies
from workbench.structures.paths import Course, lead, load

Array = NDArray[np.float64]


class StaticStep(NamedTuple):
    """A committed static step: imposed displacement (m), its force (N), energies, solver cost."""

    displacement: float
    force: float
    energies: StepEnergies
    evaluations: int
    cuts: int


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
) -> Iterator[StaticStep]:
    """Displacement control by a force: lead `dof` along `path` (m, relative to now).

    Arguments: `assembly`; `dof`; displacements `path` (steps,); `tolerance` of the residual over
    the largest force; `most_cuts`, how often an increment may be halved.
    Yields a `StaticStep` for every point of the path. Raises `SolverError`.
    """
    pattern = np.zeros(assembly.size)
    pattern[dof] = 1.0
    for step in lead(Course(assembly, pattern, dof, 1.0), path, tolerance, most_cuts, inf):
        yield StaticStep(step.displacement, step.factor, step.energies, step.evaluations, step.cuts)
