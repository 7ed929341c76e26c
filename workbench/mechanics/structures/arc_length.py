"""Arc-length driver: follows equilibrium past limit points of load and of displacement.

Cylindrical arc length (Crisfield 1981): the increment of the translations has a given length, so
that load factor and displacements both are free to turn back. Where its iterations do not end, as
in the corners of yield surfaces, the translation that moves most is led instead (local control,
Rheinboldt 1981), which has a line search.
"""

from collections.abc import Iterator
from math import sqrt
from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import InputError, SolverError
from workbench.mechanics.structures.equilibrium import Structure, free_pattern
from workbench.mechanics.structures.paths import LARGEST_GAP, Course, PathStep

ITERATIONS = 15
FARTHEST = 2.0  # of the radius, for a step that had to leave the cylinder
WANTED_ITERATIONS = 8.0  # the radius adapts so that a step takes about this many
WANTED_GAP = 1e-3  # and so that its trapezoidal work is about as exact as this


class _Trial(NamedTuple):
    """A state of the path that is not yet committed: change of displacements, load factor."""

    change: Array
    factor: float
    iterations: int
    converged: bool
    residual: float


class _Arc:
    """Steps of a given length along the path of a course, with a radius that adapts."""

    def __init__(self, course: Course, increment: float) -> None:
        self.course = course
        self.translations = np.tile([1.0, 1.0, 0.0], course.assembly.size // 3)
        self.translations[course.assembly.held] = 0.0
        self.last: Array = np.zeros(course.assembly.size)
        self.cuts = self._in_a_row = 0
        self._gained: float | None = None
        tangent = self._tangent()
        if tangent[course.dof] == 0.0 or self._length(tangent) == 0.0:
            allowed = "does not move under the pattern"
            raise InputError("dof", course.dof, allowed, "watch another dof")
        self.radius = self.largest = self._length(tangent) * abs(increment / tangent[course.dof])

    def _length(self, change: Array) -> float:
        """Length of the translations of a change of displacements."""
        return float(np.linalg.norm(change * self.translations))

    def _tangent(self) -> Array:
        """Change of displacements (dofs,) per load factor at the committed state."""
        assembly = self.course.assembly
        assembly.assemble(assembly.displacement, None)
        self.course.evaluations += 1
        tangent = assembly.solve(self.course.pattern)
        if tangent is None:
            where = f"load factor {self.course.factor:.6g}"
            raise SolverError(where, np.inf, "the tangent is singular")
        return tangent

    def trial(self) -> _Trial:
        """The next state of the path at the distance of the radius.

        Iterations start from the change of the last step, or from the tangent if that has failed:
        the tangent of a committed state that is about to yield on is the elastic one.
        """
        if self._in_a_row == 0 and self._gained is not None:
            share = self.radius / self._length(self.last)
            change, more = share * self.last, share * self._gained
        else:
            tangent = self._tangent()
            forward = float((self.last * self.translations) @ tangent)
            more = (1.0 if forward >= 0.0 else -1.0) * self.radius / self._length(tangent)
            change = more * tangent
        factor = self.course.factor + more
        trial = self._on_cylinder(change, factor)
        self.course.evaluations += trial.iterations
        if not trial.converged:
            trial = self._led(change, factor)
        onward = float((trial.change * self.translations) @ change) > 0.0
        return trial._replace(converged=trial.converged and onward)

    def commit(self, trial: _Trial) -> bool:
        """Commit a trial and adapt the radius; whether that was possible."""
        residual = trial.residual
        if trial.converged:
            end = self.course.assembly.displacement + trial.change
            gained = trial.factor - self.course.factor
            residual = self.course.commit(end, trial.factor)
            if residual <= 1.0:
                self.last, self._gained, self._in_a_row = trial.change, gained, 0
                gap = max(residual * LARGEST_GAP, 0.1 * WANTED_GAP)
                growth = sqrt(min(WANTED_ITERATIONS / trial.iterations, WANTED_GAP / gap))
                self.radius = min(min(max(growth, 0.5), 1.5) * self.radius, self.largest)
                return True
        self.cuts += 1
        self._in_a_row += 1
        if self._in_a_row > self.course.most_cuts:
            where = f"load factor {self.course.factor:.6g}"
            raise SolverError(where, residual, f"radii down to {self.radius:.3g} m")
        self.radius *= 0.5
        return False

    def record(self) -> PathStep:
        """The point that has been reached."""
        cuts, self.cuts = self.cuts, 0
        return self.course.record(cuts)

    def _on_cylinder(self, change: Array, factor: float) -> _Trial:
        """Newton's method with the length of the change at the radius."""
        assembly, pattern = self.course.assembly, self.course.pattern
        start, held = assembly.displacement, assembly.held
        allowed = residual = np.inf
        for iteration in range(1, ITERATIONS + 1):
            error = self.course.constant + factor * pattern
            error -= assembly.assemble(start + change, None)
            error[held] = 0.0
            if iteration == 1:
                allowed = assembly.allowed_residual(self.course.tolerance, start + change, error)
            residual = float(np.max(np.abs(error))) / allowed
            if residual <= 1.0:
                return _Trial(change, factor, iteration, True, residual)
            pair = assembly.solve(np.stack([error, pattern], axis=1))
            if pair is None:
                break
            # |W (change + free + d tangent)| = radius, W the translations, for d
            free, tangent = pair[:, 0], pair[:, 1]
            base, t = (change + free) * self.translations, tangent * self.translations
            a, b, c = float(t @ t), float(base @ t), float(base @ base) - self.radius**2
            discriminant = b * b - a * c
            if not (discriminant >= 0.0 and a > 0.0):
                break
            # of the two roots the forward one has the larger inner product with the last increment
            side = 1.0 if float((change * self.translations) @ t) >= 0.0 else -1.0
            more = (-b + side * sqrt(discriminant)) / a
            change = change + free + more * tangent
            factor += more
        return _Trial(change, factor, ITERATIONS, False, residual)

    def _led(self, change: Array, factor: float) -> _Trial:
        """Keep the translation that moves most where it is, with a line search for the others."""
        assembly = self.course.assembly
        dof = int(np.argmax(np.abs(change * self.translations)))
        solution, reached = self.course.lead(dof, assembly.displacement + change, factor)
        self.course.evaluations += solution.evaluations
        moved = solution.x - assembly.displacement
        converged = solution.converged and self._length(moved) <= FARTHEST * self.radius
        return _Trial(moved, reached, solution.evaluations, converged, solution.residual)


def follow_arc(
    assembly: Structure,
    pattern: Array,
    dof: int,
    sign: float,
    target: float,
    increment: float,
    most_steps: int = 100_000,
    tolerance: float = 1e-8,
    most_cuts: int = 12,
) -> Iterator[PathStep]:
    """Arc length beside dead loads, until the displacement of `dof` reaches `target`.

    Arguments as of `follow_displacement`, except that `dof` is watched; `target` displacement along
    it from where it is now (m or rad); `increment`, displacement of the dof in the first step along
    the tangent, whose length bounds that of all steps; at most `most_steps`; `most_cuts`, how often
    the radius may be halved in a row.
    Yields a `PathStep` after each commit; the last one is at `target`. Raises `SolverError`.
    """
    course = Course(assembly, free_pattern(assembly, pattern), dof, sign, tolerance, most_cuts)
    arc = _Arc(course, increment)
    for _ in range(most_steps):
        while True:
            trial = arc.trial()
            ahead = course.origin + sign * target - course.at
            passed = trial.converged and trial.change[dof] * ahead >= ahead**2
            if passed and _land(course, trial, ahead):
                yield arc.record()
                return
            if arc.commit(trial._replace(converged=trial.converged and not passed)):
                break
        yield arc.record()
    where = f"displacement {sign * (course.at - course.origin):.6g} {course.unit}"
    raise SolverError(where, np.inf, f"{most_steps} steps of arc length on the way to {target:g}")


def _land(course: Course, trial: _Trial, ahead: float) -> bool:
    """Commit the state `ahead` of the dof, on the way to a trial; whether that worked."""
    share = ahead / float(trial.change[course.dof])
    start = course.assembly.displacement + share * trial.change
    factor = course.factor + share * (trial.factor - course.factor)
    solution, reached = course.lead(course.dof, start, factor)
    course.evaluations += solution.evaluations
    return solution.converged and course.commit(solution.x, reached) <= 1.0
