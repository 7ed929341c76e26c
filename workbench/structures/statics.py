"""Quasi-static drivers: load control for dead loads, displacement control of one dof."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.errors import SolverError
from workbench.structures.assembly import PlanarAssembly
from workbench.structures.ledger import StepEnergies
from workbench.structures.newton import Solution, newton

Array = NDArray[np.float64]
LEDGER_WEIGHT = 0.5  # the trapezoidal rule, in dissipation as in external work


class StaticStep(NamedTuple):
    """A committed static step: imposed displacement (m), its force (N), energies, solver cost."""

    displacement: float
    force: float
    energies: StepEnergies
    evaluations: int
    cuts: int


def _equilibrium(
    assembly: PlanarAssembly, load: Array, start: Array, held: NDArray[np.int64], tolerance: float
) -> tuple[Solution, Array]:
    """Solve for equilibrium under `load` with `held` dofs as in `start`; also the reactions."""
    reactions = np.zeros(assembly.size)

    def evaluate(x: Array) -> Array:
        residual = assembly.assemble(x, None) - load
        reactions[:] = residual
        residual[held] = 0.0
        return residual

    def allow(residual: Array) -> float:
        return assembly.allowed_residual(tolerance, residual, start)

    def solve(right: Array) -> Array | None:
        return assembly.solve(right, held)

    return newton(evaluate, allow, solve, start, iterations=40), reactions


def _tangent_start(
    assembly: PlanarAssembly, dof: int, increment: float, held: NDArray[np.int64]
) -> Array:
    """Displacements after moving `dof` by `increment` along the committed tangent."""
    assembly.assemble(assembly.displacement, None)
    unit = np.zeros(assembly.size)
    unit[dof] = increment
    imposed = assembly.tangent_times(unit)
    follow = assembly.solve(-imposed, held)
    start = assembly.displacement.copy()
    if follow is not None:
        start += follow
    start[dof] += increment
    return start


def apply_loads(
    assembly: PlanarAssembly, steps: int = 5, tolerance: float = 1e-10, most_cuts: int = 10
) -> None:
    """Bring the dead loads of the assembly on in equal steps, halved where needed, and commit.

    Raises `SolverError` when an equilibrium is not found.
    """
    done, level = 0, 0  # in units of 1 / (steps 2^level)
    while done < steps * 2**level:
        share = (done + 1) / (steps * 2**level)
        found, _ = _equilibrium(
            assembly, share * assembly.load, assembly.displacement, assembly.held, tolerance
        )
        if not found.converged:
            level, done = level + 1, 2 * done
            if level > most_cuts:
                raise SolverError(
                    f"dead load, share {share:.3g}",
                    found.residual,
                    f"line search and load steps down to 1/{steps * 2**most_cuts}",
                )
            continue
        assembly.stored = assembly.account(found.x, LEDGER_WEIGHT).stored
        assembly.commit(found.x)
        done += 1
        while level > 0 and done % 2 == 0:
            level, done = level - 1, done // 2


def push(
    assembly: PlanarAssembly,
    dof: int,
    path: Array,
    tolerance: float = 1e-8,
    most_cuts: int = 10,
) -> Iterator[StaticStep]:
    """Displacement control: lead `dof` along `path` (m, relative to now), committing each step.

    Arguments: `assembly`; `dof`; displacements `path` (steps,); `tolerance` of the residual over
    the largest force; `most_cuts`, how often an increment may be halved.
    Yields a `StaticStep` for every point of the path. Raises `SolverError`.
    """
    held = np.union1d(assembly.held, [dof])
    origin = float(assembly.displacement[dof])
    previous = np.zeros(assembly.size)
    for target in path:
        energies = StepEnergies(0.0, 0.0, 0.0, 0.0)
        evaluations = cuts = level = 0
        # sub-increments are whole multiples of span / 2^level, so that the path is met exactly
        begin = float(assembly.displacement[dof])
        span = origin + float(target) - begin
        done = 0.0
        force = 0.0
        while done < 1.0:
            share = 0.5**level
            increment = begin + (done + share) * span - float(assembly.displacement[dof])
            if previous[dof] != 0.0:
                start = assembly.displacement + previous * (increment / previous[dof])
            else:
                start = _tangent_start(assembly, dof, increment, held)
            found, reactions = _equilibrium(assembly, assembly.load, start, held, tolerance)
            evaluations += found.evaluations
            if not found.converged:
                level += 1
                cuts += 1
                if level > most_cuts:
                    raise SolverError(
                        f"displacement {begin + (done + share) * span - origin:.6g} m",
                        found.residual,
                        f"line search and increments down to 1/{2**most_cuts}",
                    )
                previous = np.zeros(assembly.size)
                continue
            step = assembly.account(found.x, LEDGER_WEIGHT)
            energies = (energies + step)._replace(stored=step.stored)
            previous = found.x - assembly.displacement
            force = float(reactions[dof])
            assembly.commit(found.x)
            assembly.stored = step.stored
            done += share
            while level > 0 and (done * 2.0 ** (level - 1)).is_integer():
                level -= 1
        yield StaticStep(
            float(assembly.displacement[dof]) - origin, force, energies, evaluations, cuts
        )
