"""Arc-length driver: follows equilibrium past limit points of load and of displacement.

Cylindrical arc length (Crisfield 1981): the increment of the translations has a given length, so
that load factor and displacements both are free to turn back. Where its iterations do not end, as
in the corners of yield surfaces, the translation that moves most is led instead (local control,
Rheinboldt 1981), which has a line search.
"""

from collections.abc import Iterator
from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from workbench.arrays import Array
from workbench.errors import InputError, SolverError
from workbench.structures.assembly import PlanarAssembly
from workbench.structures.equilibrium import DisplacementControl, free_pattern
from workbench.structures.paths import LARGEST_GAP, Course, PathStep

ITERATIONS = 15
FARTHEST = 2.0  # of the radius, for a step that had to leave the cylinder
WANTED_ITERATIONS = 8.0  # the radius adapts so that a step takes about this many
WANTED_GAP = 1e-3  # and so that its trapezoidal work is about as exact as this


class _Found(NamedTuple):
    change: Array
    factor: float
    iterations: int
    converged: bool
    residual: float


class _Arc:
    """Steps of a given length along the path of a course, with a radius that adapts."""

    def __init__(
        self, course: Course, radius: float, largest: float, tolerance: float, most_cuts: int
    ) -> None:
        self.course, self.radius, self.largest = course, radius, largest
        self.tolerance, self.most_cuts = tolerance, most_cuts
        self.translations = np.tile([1.0, 1.0, 0.0], course.assembly.size // 3)
        self.translations[course.assembly.held] = 0.0
        self.last: Array = np.zeros(course.assembly.size)
        self.cuts = 0
        self._in_a_row = 0
        self._gained: float | None = None

    def length(self, change: Array) -> float:
        """Length of the translations of a change of displacements."""
        return float(np.linalg.norm(change * self.translations))

    def tangent(self) -> Array:
        """Change of displacements (dofs,) per load factor at the committed state."""
        assembly = self.course.assembly
        assembly.assemble(assembly.displacement, None)
        self.course.evaluations += 1
        tangent = assembly.solve(self.course.pattern)
        if tangent is None:
            where = f"load factor {self.course.factor:.6g}"
            raise SolverError(where, np.inf, "the tangent is singular")
        return tangent

    def find(self) -> _Found:
        """The next state of the path at the distance of the radius, not yet committed."""
        change, more = self._ahead()
        factor = self.course.factor + more
        found = self._correct(change, factor)
        self.course.evaluations += found.iterations
        if not found.converged:
            found = self._lead(change, factor)
        onward = float((found.change * self.translations) @ change) > 0.0
        return found._replace(converged=found.converged and onward)

    def _ahead(self) -> tuple[Array, float]:
        """A first guess of the change: that of the last step; the tangent if that has failed.

        The tangent of a committed state that is about to yield on is the elastic one.
        """
        if self._in_a_row == 0 and self._gained is not None:
            share = self.radius / self.length(self.last)
            return share * self.last, share * self._gained
        tangent = self.tangent()
        forward = float((self.last * self.translations) @ tangent)
        more = (1.0 if forward >= 0.0 else -1.0) * self.radius / self.length(tangent)
        return more * tangent, more

    def commit(self, found: _Found) -> bool:
        """Commit what has been found and adapt the radius; whether that was possible."""
        residual = found.residual
        if found.converged:
            end = self.course.assembly.displacement + found.change
            gained = found.factor - self.course.factor
            gap = self.course.commit(end, found.factor, LARGEST_GAP)
            if gap <= LARGEST_GAP:
                self.last, self._gained, self._in_a_row = found.change, gained, 0
                gap = max(gap, 0.1 * WANTED_GAP)
                growth = sqrt(min(WANTED_ITERATIONS / found.iterations, WANTED_GAP / gap))
                self.radius = min(min(max(growth, 0.5), 1.5) * self.radius, self.largest)
                return True
            residual = gap / LARGEST_GAP
        self.cuts += 1
        self._in_a_row += 1
        if self._in_a_row > self.most_cuts:
            where = f"load factor {self.course.factor:.6g}"
            raise SolverError(where, residual, f"radii down to {self.radius:.3g} m")
        self.radius *= 0.5
        return False

    def record(self) -> PathStep:
        """The point that has been reached."""
        cuts, self.cuts = self.cuts, 0
        return self.course.record(cuts)

    def _correct(self, change: Array, factor: float) -> _Found:
        assembly, pattern = self.course.assembly, self.course.pattern
        start, held = assembly.displacement, assembly.held
        allowed = residual = np.inf
        for iteration in range(1, ITERATIONS + 1):
            error = self.course.constant + factor * pattern
            error -= assembly.assemble(start + change, None)
            error[held] = 0.0
            if iteration == 1:
                allowed = assembly.allowed_residual(self.tolerance, start + change, error)
            residual = float(np.max(np.abs(error))) / allowed
            if residual <= 1.0:
                return _Found(change, factor, iteration, True, residual)
            pair = assembly.solve(np.stack([error, pattern], axis=1))
            if pair is None:
                break
            free, tangent = pair[:, 0], pair[:, 1]
            more = self._root(change, free, tangent)
            if more is None:
                break
            change = change + free + more * tangent
            factor += more
        return _Found(change, factor, ITERATIONS, False, residual)

    def _lead(self, change: Array, factor: float) -> _Found:
        """Keep the translation that moves most where it is, with a line search for the others."""
        assembly = self.course.assembly
        dof = int(np.argmax(np.abs(change * self.translations)))
        control = self.course.control(dof, self.tolerance)
        solution, reached = control.solve(assembly.displacement + change, factor)
        self.course.evaluations += solution.evaluations
        moved = solution.x - assembly.displacement
        found = solution.converged and self.length(moved) <= FARTHEST * self.radius
        return _Found(moved, reached, solution.evaluations, found, solution.residual)

    def _root(self, change: Array, free: Array, tangent: Array) -> float | None:
        """Factor increment that puts the new increment back on the cylinder, on the forward side.

        Solves |W (change + free + d tangent)| = radius for d, W the translations; of the two roots
        the one whose increment points more into the direction of `change`. None without a real one.
        """
        base = (change + free) * self.translations
        t = tangent * self.translations
        a = float(t @ t)
        b = float(base @ t)
        c = float(base @ base) - self.radius**2
        discriminant = b * b - a * c
        if not (discriminant >= 0.0 and a > 0.0):
            return None
        # of the two roots the forward one has the larger inner product with the last increment
        side = 1.0 if float((change * self.translations) @ t) >= 0.0 else -1.0
        return (-b + side * sqrt(discriminant)) / a


def follow_arc(
    assembly: PlanarAssembly,
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

    Arguments: `assembly` under its dead loads; `pattern` (dofs,) in N and N m; watched `dof` and
    the `sign` of its direction; `target` displacement along it from where it is now (m or rad);
    `increment`, displacement of the dof in the first step along the tangent, whose length bounds
    that of all steps; at most `most_steps`; `tolerance` of the residual over the largest force;
    `most_cuts`, how often the radius may be halved in a row.
    Yields a `PathStep` after each commit; the last one is at `target`. Raises `SolverError`.
    """
    if not (np.isfinite(target) and target != 0.0):
        raise InputError("target", target, "must be a finite displacement other than 0")
    if not increment > 0.0:
        raise InputError("increment", increment, "must be positive")
    course = Course(assembly, free_pattern(assembly, pattern), dof, sign)
    arc = _Arc(course, increment, inf, tolerance, most_cuts)
    control = course.control(dof, tolerance)
    tangent = arc.tangent()
    if tangent[dof] == 0.0 or arc.length(tangent) == 0.0:
        raise InputError("dof", dof, "does not move under the pattern", "watch another dof")
    arc.radius = arc.largest = arc.length(tangent) * abs(increment / tangent[dof])
    for _ in range(most_steps):
        while True:
            found = arc.find()
            ahead = course.origin + sign * target - course.at
            passed = found.converged and found.change[dof] * ahead >= ahead**2
            if passed and _land(course, control, found, ahead):
                yield arc.record()
                return
            if arc.commit(found._replace(converged=found.converged and not passed)):
                break
        yield arc.record()
    where = f"displacement {sign * (course.at - course.origin):.6g} {course.unit}"
    raise SolverError(where, np.inf, f"{most_steps} steps of arc length on the way to {target:g}")


def _land(course: Course, control: DisplacementControl, found: _Found, ahead: float) -> bool:
    """Commit the state `ahead` of the dof, on the way to the one found; whether that worked."""
    share = ahead / float(found.change[course.dof])
    start = course.assembly.displacement + share * found.change
    factor = course.factor + share * (found.factor - course.factor)
    solution, reached = control.solve(start, factor)
    course.evaluations += solution.evaluations
    return solution.converged and course.commit(solution.x, reached, LARGEST_GAP) <= LARGEST_GAP
