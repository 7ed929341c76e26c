"""Quasi-static drivers of the solid: the axial load, then displacement control of the push."""

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from workbench.arrays import Array, Indices
from workbench.errors import SolverError
from workbench.references.solid.assembly import SolidAssembly
from workbench.structures.newton import Solution, newton, pieces

TOLERANCE = 1e-8  # of the largest nodal force, or of the squash load if that is smaller
ITERATIONS = 30
MOST_CUTS = 8


class Pushed(NamedTuple):
    """A committed step: reaction to the push (N), residual evaluations, halvings of the step."""

    force: float
    evaluations: int
    cuts: int


def equilibrium(assembly: SolidAssembly, start: Array, held: Indices) -> tuple[Solution, Array]:
    """Solve for equilibrium with the unknowns `held` as in `start`; also their reactions."""
    reactions = np.zeros(len(start))

    def evaluate(q: Array) -> Array:
        residual = assembly.residual(q)
        reactions[:] = residual
        residual[held] = 0.0
        return residual

    def allow(_: Array) -> float:
        # a wild start must not loosen the tolerance
        scale = max(float(np.max(np.abs(assembly.force))), abs(assembly.load), 1e-6)
        return max(TOLERANCE * min(scale, assembly.squash_load), assembly.round_off)

    solve = partial(assembly.solve, held=held)
    return newton(evaluate, allow, solve, start, iterations=ITERATIONS), reactions


def apply_load(assembly: SolidAssembly, load: float, steps: int = 5) -> None:
    """Bring the axial load (N, compression positive) on, with the column held straight.

    Raises `SolverError`.
    """
    held = np.array([assembly.supports.hit])
    for share in np.linspace(0.0, 1.0, steps + 1)[1:] if load else ():
        assembly.load = -load * float(share)
        found, _ = equilibrium(assembly, assembly.q, held)
        if not found.converged:
            raise SolverError(f"axial load, share {share:.3g}", found.residual, "load steps")
        assembly.commit(found.x)


def push(assembly: SolidAssembly, path: Array, held: Indices) -> Iterator[Pushed]:
    """Lead the hit section along `path` (m), committing and yielding every step.

    Arguments: `assembly`; lateral displacements `path` (steps,); `held`, the unknowns that do
    not move, besides v. Raises `SolverError`.
    """
    hit = assembly.supports.hit
    held = np.union1d(held, [hit])
    previous, evaluations = np.zeros(len(assembly.q)), 0

    def attempt(begin: float, span: float, done: float, share: float) -> SolverError | float:
        nonlocal previous, evaluations
        reach = begin + (done + share) * span
        start = _predict(assembly, reach - float(assembly.q[hit]), previous, held)
        start[hit] = reach
        found, reactions = equilibrium(assembly, start, held)
        evaluations += found.evaluations
        if not found.converged:
            previous = np.zeros(len(assembly.q))
            tried = f"line search and steps down to 1/{2**MOST_CUTS}"
            return SolverError(f"displacement {reach:.6g} m", found.residual, tried)
        previous, force = found.x - assembly.q, float(reactions[hit])
        assembly.commit(found.x)
        return force

    for target in path:
        begin, evaluations = float(assembly.q[hit]), 0
        taken = list(pieces(partial(attempt, begin, float(target) - begin), MOST_CUTS))
        yield Pushed(taken[-1][0], evaluations, sum(cuts for _, _, cuts in taken))


def _predict(assembly: SolidAssembly, increment: float, previous: Array, held: Indices) -> Array:
    """Start of a step: the last one repeated, or along the tangent if there is none."""
    hit = assembly.supports.hit
    if previous[hit] != 0.0:
        return np.asarray(assembly.q + previous * (increment / previous[hit]))
    assembly.residual(assembly.q)
    unit = np.zeros(len(assembly.q))
    unit[hit] = increment
    follow = assembly.solve(-assembly.tangent @ unit, held)
    return assembly.q + unit + (0.0 if follow is None else follow)
