"""Arc-length driver: follows equilibrium past limit points of load and of displacement.

Cylindrical arc length (Crisfield 1981): the increment of the translations has a given length, so
that load factor and displacements both are free to turn back.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.errors import SolverError
from workbench.structures.assembly import PlanarAssembly
from workbench.structures.ledger import StepEnergies

Array = NDArray[np.float64]
LEDGER_WEIGHT = 0.5  # the trapezoidal rule, in dissipation as in external work
ITERATIONS = 15
WANTED_ITERATIONS = 5.0  # the radius adapts so that a step takes about this many


class ArcStep(NamedTuple):
    """A committed step of the path.

    `factor` on the load of the assembly; `radius` in m; `energies` of the structure and
    `external_work` of the load in J; residual `evaluations`, and `cuts` of the radius.
    """

    factor: float
    radius: float
    energies: StepEnergies
    external_work: float
    evaluations: int
    cuts: int


class _Found(NamedTuple):
    change: Array
    factor: float
    iterations: int
    converged: bool
    residual: float


def _root(change: Array, free: Array, tangent: Array, radius: float, held: Array) -> float | None:
    """Factor increment that puts the new increment back on the cylinder, on the forward side.

    Solves |W (change + free + d tangent)| = radius for d, W the translations; of the two roots
    the one whose increment points more into the direction of `change`. None without a real root.
    """
    base = (change + free) * held
    t = tangent * held
    a = float(t @ t)
    b = float(base @ t)
    c = float(base @ base) - radius**2
    discriminant = b * b - a * c
    if not (discriminant >= 0.0 and a > 0.0):
        return None
    # of the two roots the forward one has the larger inner product with the last increment
    side = 1.0 if float((change * held) @ t) >= 0.0 else -1.0
    return (-b + side * sqrt(discriminant)) / a


def _correct(
    assembly: PlanarAssembly, change: Array, factor: float, radius: float, tolerance: float
) -> _Found:
    """Newton's method from the predicted `change` and `factor`, on the cylinder of `radius`."""
    start = assembly.displacement
    translations = np.tile([1.0, 1.0, 0.0], assembly.size // 3)
    translations[assembly.held] = 0.0
    allowed = residual = np.inf
    for iteration in range(1, ITERATIONS + 1):
        error = factor * assembly.load - assembly.assemble(start + change, None)
        error[assembly.held] = 0.0
        if iteration == 1:
            allowed = assembly.allowed_residual(tolerance, error, start + change)
        residual = float(np.max(np.abs(error))) / allowed
        if residual <= 1.0:
            return _Found(change, factor, iteration, True, residual)
        pair = assembly.solve(np.stack([error, assembly.load], axis=1))
        if pair is None:
            break
        free, tangent = pair[:, 0], pair[:, 1]
        more = _root(change, free, tangent, radius, translations)
        if more is None:
            break
        change = change + free + more * tangent
        factor += more
    return _Found(change, factor, ITERATIONS, False, residual)


def follow(
    assembly: PlanarAssembly,
    radius: float,
    steps: int,
    largest_radius: float = np.inf,
    tolerance: float = 1e-9,
    most_cuts: int = 12,
) -> Iterator[ArcStep]:
    """Follow the equilibrium path under a multiple of the assembly's load, from no load.

    Arguments: `assembly`, unloaded, with the load pattern in `load`; first and largest `radius`,
    length of the increment of all translations (m); number of `steps`; `tolerance` of the
    residual over the largest force; `most_cuts`, how often the radius may be halved in a row.
    Yields an `ArcStep` after each commit. Raises `SolverError`.
    """
    factor = 0.0
    last = np.zeros(assembly.size)
    cuts = evaluations = 0
    taken = in_a_row = 0
    translations = np.tile([1.0, 1.0, 0.0], assembly.size // 3)
    while taken < steps:
        assembly.assemble(assembly.displacement, None)
        tangent = assembly.solve(assembly.load)
        if tangent is None:
            raise SolverError(f"load factor {factor:.6g}", np.inf, "the tangent is singular")
        forward = float((last * translations) @ tangent)
        sign = 1.0 if forward >= 0.0 else -1.0
        more = sign * radius / float(np.linalg.norm(tangent * translations))
        found = _correct(assembly, more * tangent, factor + more, radius, tolerance)
        evaluations += found.iterations + 1
        if not found.converged:
            cuts += 1
            in_a_row += 1
            if in_a_row > most_cuts:
                raise SolverError(
                    f"load factor {factor:.6g}", found.residual, f"radii down to {radius:.3g} m"
                )
            radius *= 0.5
            continue
        x = assembly.displacement + found.change
        energies = assembly.account(x, LEDGER_WEIGHT)
        work = 0.5 * (factor + found.factor) * float(assembly.load @ found.change)
        assembly.commit(x)
        assembly.stored = energies.stored
        factor, last = found.factor, found.change
        taken += 1
        yield ArcStep(factor, radius, energies, work, evaluations, cuts)
        cuts = evaluations = in_a_row = 0
        growth = np.sqrt(WANTED_ITERATIONS / found.iterations)
        radius = min(radius * float(np.clip(growth, 0.5, 1.5)), largest_radius)
