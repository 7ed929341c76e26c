"""Equilibrium at a given load, or with one dof given and the load factor unknown."""

from functools import partial

import numpy as np

from workbench.arrays import Array, Indices
from workbench.errors import InputError
from workbench.structures.assembly import PlanarAssembly
from workbench.structures.newton import Solution, newton

ITERATIONS = 40


def equilibrium(
    assembly: PlanarAssembly, load: Array, start: Array, held: Indices, tolerance: float
) -> tuple[Solution, Array]:
    """Solve for equilibrium under `load` (dofs,) with `held` dofs where they are in `start`.

    Arguments: `tolerance` of the residual over the largest force. Returns the solution, which may
    be not converged, and internal forces less load (dofs,): the reactions at held dofs.
    """
    reactions = np.zeros(assembly.size)

    def evaluate(x: Array) -> Array:
        residual = assembly.assemble(x, None) - load
        reactions[:] = residual
        residual[held] = 0.0
        return residual

    allow = partial(assembly.allowed_residual, tolerance, start)
    solve = partial(assembly.solve, held=held)
    return newton(evaluate, allow, solve, start, ITERATIONS), reactions


def free_pattern(assembly: PlanarAssembly, pattern: Array) -> Array:
    """The load pattern without what goes straight into supports; an error if nothing is left."""
    if np.shape(pattern) != (assembly.size,) or not np.all(np.isfinite(pattern)):
        raise InputError("pattern", None, f"must be a finite load for each of {assembly.size} dofs")
    free = np.array(pattern, dtype=float)
    free[assembly.held] = 0.0
    if not np.any(free):
        raise InputError(
            "pattern", None, "loads no free dof", "put a load where the structure can move"
        )
    return free


def present_factor(assembly: PlanarAssembly, constant: Array, pattern: Array) -> float:
    """Factor of `pattern` beside the `constant` load under which the committed state is.

    Leaves the committed tangent in the assembly.
    """
    force = assembly.assemble(assembly.displacement, None) - constant
    direction = pattern / np.max(np.abs(pattern))  # loads of 1e-200 N have no square
    return float(direction @ force) / float(direction @ pattern)


class DisplacementControl:
    """One dof is led; the factor of a load `pattern` beside a `constant` load follows.

    With the led dof held the tangent stays regular at limit points of the load. Each iteration
    takes two solutions with it, one for the residual and one for the pattern; the row of the led
    dof then gives the factor (Batoz and Dhatt 1979). A pattern on the led dof alone needs the first
    only: its factor is the reaction.
    """

    def __init__(
        self, assembly: PlanarAssembly, constant: Array, pattern: Array, dof: int, tolerance: float
    ) -> None:
        self.assembly, self.constant, self.pattern = assembly, constant, pattern
        self.dof, self.tolerance = dof, tolerance
        self.held: Indices = np.union1d(assembly.held, [dof])
        elsewhere = pattern.copy()
        elsewhere[dof] = 0.0
        self._alone = not np.any(elsewhere)

    def solve(self, start: Array, factor: float) -> tuple[Solution, float]:
        """Equilibrium with the led dof where it is in `start`, and its load factor."""
        if self._alone:
            found, reactions = equilibrium(
                self.assembly, self.constant, start, self.held, self.tolerance
            )
            return found, float(reactions[self.dof] / self.pattern[self.dof])
        held = self.assembly.held

        def evaluate(y: Array) -> Array:
            force = self.assembly.assemble(y[:-1], None)
            residual = force - self.constant - y[-1] * self.pattern
            residual[held] = 0.0
            return np.append(residual, 0.0)

        def solve(right: Array) -> Array | None:
            return self._bordered(right[:-1])

        allow = partial(self.assembly.allowed_residual, self.tolerance, start)
        found = newton(evaluate, allow, solve, np.append(start, factor), ITERATIONS)
        return found._replace(x=found.x[:-1]), float(found.x[-1])

    def tangent_step(self, increment: float) -> tuple[Array, float]:
        """Change of displacements (dofs,) and of the factor along the committed tangent."""
        unit = np.zeros(self.assembly.size)
        unit[self.dof] = increment
        self.assembly.assemble(self.assembly.displacement, None)
        found = self._bordered(-self.assembly.tangent_times(unit))
        if found is None:
            return unit, 0.0
        return found[:-1] + unit, float(found[-1])

    def _bordered(self, right: Array) -> Array | None:
        """Solve K x - factor p = `right` with the led dof at rest; the factor comes last."""
        row, columns = self._row()
        pair = self.assembly.solve(np.stack([right, self.pattern], axis=1), self.held)
        if pair is None:
            return None
        free, loaded = pair[:, 0], pair[:, 1]
        slope = float(row @ loaded[columns] - self.pattern[self.dof])
        more = float(right[self.dof] - row @ free[columns])
        if slope == 0.0 or not np.isfinite(more / slope):
            return None
        factor = more / slope
        return np.append(free + factor * loaded, factor)

    def _row(self) -> tuple[Array, Indices]:
        """Row of the tangent of the led dof, and its columns."""
        width, size = self.assembly.width, self.assembly.size
        columns = np.arange(max(0, self.dof - width), min(size, self.dof + width + 1))
        band = self.assembly.band.reshape(size, -1)
        return band[columns, 2 * width + self.dof - columns], columns
