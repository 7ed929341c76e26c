"""Static paths: a dof or a load factor is led through successive targets, each step committed.

A pattern of nodal loads and moments is multiplied by the load factor; the dead loads of the
assembly stay as they are. The work of both is accounted for by the trapezoidal rule.

**Second part.** Arc-length driver: follows equilibrium past limit points of load and of
displacement.

Cylindrical arc length (Crisfield 1981): the increment of the translations has a given length, so
that load factor and displacements both are free to turn back. Where its iterations do not end, as
in the corners of yield surfaces, the translation that moves most is led instead (local control,
Rheinboldt 1981), which has a line search.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from math import ceil, inf, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array
from workbench.base.errors import InputError, SolverError
from workbench.mechanics.structures.assembly import COMPONENTS
from workbench.mechanics.structures.elements import StepEnergies
from workbench.mechanics.structures.equilibrium import (
    ITERATIONS,
    Solution,
    Structure,
    equilibrium,
    free_pattern,
    newton,
    pieces,
)

LEDGER_WEIGHT = 0.5  # the trapezoidal rule, in dissipation as in external work
MOST_CUTS = 16  # crossing a corner of a yield surface can take as much
LARGEST_GAP = 5e-3  # of the energy turned over in a step; a structure that jumps leaves more


class PathStep(NamedTuple):
    """A committed point of a static path.

    `displacement` of the led or watched dof along its sign since the start of the path (m or rad);
    load `factor`; `energies` of the structure and `external_work` of pattern and dead loads since
    the last point (J); residual `evaluations`; `cuts`, how often the increment was halved.
    """

    displacement: float
    factor: float
    energies: StepEnergies
    external_work: float
    evaluations: int
    cuts: int


def follow_displacement(
    assembly: Structure,
    pattern: Array,
    dof: int,
    sign: float,
    targets: Sequence[float],
    increment: float,
    tolerance: float = 1e-8,
    most_cuts: int = MOST_CUTS,
) -> Iterator[PathStep]:
    """Displacement control: lead `dof` through `targets`; the load factor follows.

    Arguments: `assembly` under its dead loads; `pattern` (dofs,) in N and N m; `dof` and the `sign`
    of its direction; displacements `targets` along it from where it is now (m or rad), more than
    one for reversals; largest `increment` between points; `tolerance` of the residual over the
    largest force; `most_cuts`, how often an increment may be halved.
    Yields a `PathStep` for each point; every target is one. Raises `SolverError`, also where the
    structure would jump (snap-back), and `InputError`.
    """
    if dof in assembly.held:
        raise InputError("dof", dof, "is held by a support", "lead a dof that can move")
    points = sign * np.array(_points(0.0, targets, increment))
    course = Course(assembly, free_pattern(assembly, pattern), dof, sign, tolerance, most_cuts)
    yield from _lead(course, points)


def follow_load(
    assembly: Structure,
    pattern: Array,
    factors: Sequence[float],
    dof: int,
    sign: float,
    increment: float,
    tolerance: float = 1e-8,
    most_cuts: int = 10,
) -> Iterator[PathStep]:
    """Load control: lead the factor of `pattern` through successive `factors`.

    Arguments as for `follow_displacement`, except that `dof` is only watched, and that `increment`
    is that of the factor. Raises `SolverError` where a limit point ends the path.
    """
    course = Course(assembly, free_pattern(assembly, pattern), dof, sign, tolerance, most_cuts)
    yield from _load(course, _points(course.factor, factors, increment), "load factor")


def apply_loads(
    assembly: Structure,
    steps: int = 5,
    tolerance: float = 1e-10,
    most_cuts: int = 10,
    name: str = "dead load",
) -> None:
    """Bring the dead loads of the assembly on in equal steps, halved where needed, and commit.

    Raises `SolverError`, which speaks of the load by `name`, when an equilibrium is not found.
    """
    if not np.any(assembly.load):
        return
    constant = np.zeros(assembly.size)
    course = Course(assembly, assembly.load, 0, 1.0, tolerance, most_cuts, inf, constant)
    course.factor = 0.0
    for _ in _load(course, [share / steps for share in range(1, steps + 1)], f"{name}, share"):
        pass


def push(
    assembly: Structure, dof: int, path: Array, tolerance: float = 1e-8, most_cuts: int = 10
) -> Iterator[PathStep]:
    """Displacement control by a force: lead `dof` along `path` (m, relative to now).

    Yields a `PathStep` for every point of the path; its factor is the force in N. Arguments and
    errors otherwise as for `follow_displacement`, without its limit to jumps.
    """
    pattern = np.zeros(assembly.size)
    pattern[dof] = 1.0
    return _lead(Course(assembly, pattern, dof, 1.0, tolerance, most_cuts, inf), path)


def _points(begin: float, targets: ArrayLike, increment: float) -> list[float]:
    """Equal steps of at most `increment` from `begin` to each of the targets in turn."""
    stops = np.atleast_1d(np.asarray(targets, dtype=float))
    points: list[float] = []
    for stop in stops:
        count = ceil(abs(stop - begin) / increment - 1e-9)
        points.extend(np.linspace(begin, stop, count + 1)[1:])
        begin = float(stop)
    return points


class Course:
    """A structure on its static path: where it is, what the step under way has cost and done.

    Arguments: `pattern` without loads on supports; `dof` that is led or watched, along `sign`;
    `tolerance` of the residual; `most_cuts`, how often an increment may be halved; `largest_gap` of
    a step, see `commit`; `constant` loads beside the pattern, the dead loads unless given.
    """

    def __init__(
        self,
        assembly: Structure,
        pattern: Array,
        dof: int,
        sign: float,
        tolerance: float,
        most_cuts: int,
        largest_gap: float = LARGEST_GAP,
        constant: Array | None = None,
    ) -> None:
        self.assembly, self.pattern, self.dof, self.sign = assembly, pattern, dof, sign
        self.tolerance, self.most_cuts, self.largest_gap = tolerance, most_cuts, largest_gap
        self.constant = assembly.load if constant is None else constant
        self.origin = float(assembly.displacement[dof])
        force = assembly.assemble(assembly.displacement, None) - self.constant
        direction = pattern / np.max(np.abs(pattern))  # loads of 1e-200 N have no square
        self.factor = float(direction @ force) / float(direction @ pattern)
        self.unit = "rad" if dof % len(COMPONENTS) == COMPONENTS["rotation"] else "m"
        self.evaluations = 0
        self._energies = StepEnergies(0.0, 0.0, 0.0, 0.0)
        self._work = 0.0

    @property
    def at(self) -> float:
        """Displacement of the dof, in m or rad."""
        return float(self.assembly.displacement[self.dof])

    def lead(self, dof: int, start: Array, factor: float) -> tuple[Solution, float]:
        """Equilibrium with a `dof` where it is in `start`, and the load factor that it takes.

        With the led dof held the tangent stays regular at limit points of the load. Each iteration
        takes two solutions with it, one for the residual and one for the pattern; the row of the
        led dof then gives the factor (Batoz and Dhatt 1979). A pattern on the led dof alone needs
        the first only: its factor is the reaction.
        """
        assembly, held = self.assembly, self.assembly.held
        if not np.any(np.delete(self.pattern, dof)):
            with_dof = np.union1d(held, [dof])
            solution, reactions = equilibrium(
                assembly, self.constant, start, with_dof, self.tolerance
            )
            return solution, float(reactions[dof] / self.pattern[dof])

        def evaluate(y: Array) -> Array:
            residual = assembly.assemble(y[:-1], None) - self.constant - y[-1] * self.pattern
            residual[held] = 0.0
            return np.append(residual, 0.0)

        def solve(right: Array) -> Array | None:
            return self._bordered(dof, right[:-1])

        allow = partial(assembly.allowed_residual, self.tolerance, start)
        solution = newton(evaluate, allow, solve, np.append(start, factor), ITERATIONS)
        return solution._replace(x=solution.x[:-1]), float(solution.x[-1])

    def tangent_step(self, increment: float) -> tuple[Array, float]:
        """Change of displacements (dofs,) and of the factor along the committed tangent."""
        assembly, unit = self.assembly, np.zeros(self.assembly.size)
        unit[self.dof] = increment
        assembly.assemble(assembly.displacement, None)
        change = self._bordered(self.dof, -assembly.tangent_times(unit))
        if change is None:
            return unit, 0.0
        return change[:-1] + unit, float(change[-1])

    def _bordered(self, dof: int, right: Array) -> Array | None:
        """Solve K x - factor p = `right` with the `dof` at rest; the factor comes last."""
        assembly = self.assembly
        row, columns = assembly.tangent_row(dof)
        held = np.union1d(assembly.held, [dof])
        pair = assembly.solve(np.stack([right, self.pattern], axis=1), held)
        if pair is None:
            return None
        free, loaded = pair[:, 0], pair[:, 1]
        slope = float(row @ loaded[columns] - self.pattern[dof])
        more = float(right[dof] - row @ free[columns])
        if slope == 0.0 or not np.isfinite(more / slope):
            return None
        factor = more / slope
        return np.append(free + factor * loaded, factor)

    def commit(self, end: Array, factor: float) -> float:
        """Commit the trial state at `end`, unless the energies of the step leave too large a gap.

        The gap is what the trapezoidal work lacks or has too much, over the energy turned over. It
        vanishes with the step along a path, but not where the structure jumps: then the difference
        would have set it in motion. Returns the gap over the largest one.
        """
        change = end - self.assembly.displacement
        step = self.assembly.account(end, LEDGER_WEIGHT)
        work = 0.5 * (self.factor + factor) * float(self.pattern @ change)
        work += float(self.constant @ change)
        gained = step.stored - self.assembly.stored
        missing = abs(work - gained - step.plastic)
        turned = abs(work) + abs(gained) + abs(step.plastic)
        gap = missing / turned / self.largest_gap if turned > 0.0 else 0.0
        if gap <= 1.0:
            self._energies = (self._energies + step)._replace(stored=step.stored)
            self._work += work
            self.assembly.commit(end)
            self.assembly.stored = step.stored
            self.factor = factor
        return gap

    def record(self, cuts: int) -> PathStep:
        """The point that has been reached; what comes next is counted anew."""
        displacement = self.sign * (self.at - self.origin)
        point = PathStep(
            displacement, self.factor, self._energies, self._work, self.evaluations, cuts
        )
        self._energies, self._work = StepEnergies(0.0, 0.0, 0.0, 0.0), 0.0
        self.evaluations = 0
        return point


def _lead(course: Course, points: Array) -> Iterator[PathStep]:
    """Lead the dof of a course through displacements `points` from its origin, one record each."""
    assembly, dof = course.assembly, course.dof
    previous, gained = np.zeros(assembly.size), 0.0

    def guesses(increment: float) -> Iterator[tuple[Array, float]]:
        """Changes of displacements and factor to start from: the last step's, the tangent's."""
        if previous[dof] * increment > 0.0:
            ratio = increment / previous[dof]
            yield previous * ratio, gained * ratio
        yield course.tangent_step(increment)

    def attempt(begin: float, end: float, done: float, share: float) -> SolverError | None:
        nonlocal previous, gained
        goal = begin + (done + share) * (end - begin)
        start, factor, excess = assembly.displacement, course.factor, inf
        for change, more in guesses(goal - course.at):
            solution, reached = course.lead(dof, start + change, factor + more)
            course.evaluations += solution.evaluations
            excess = solution.residual
            if solution.converged:
                excess = course.commit(solution.x, reached)
                if excess <= 1.0:
                    previous, gained = solution.x - start, reached - factor
                    return None
        where = f"displacement {course.sign * (goal - course.origin):.6g} {course.unit}"
        tried = (
            f"line search and increments down to 1/{2**course.most_cuts} from two starts; where "
            "the path turns back in this dof, lead another one or use arc length"
        )
        return SolverError(where, excess, tried)

    for point in course.origin + points:
        taken = pieces(partial(attempt, course.at, point), course.most_cuts)
        yield course.record(sum(cuts for _, _, cuts in taken))


def _load(course: Course, points: Sequence[float], name: str) -> Iterator[PathStep]:
    """Lead the load factor of a course through `points`, one record each; `name` is for errors."""
    assembly = course.assembly

    def attempt(begin: float, end: float, done: float, share: float) -> SolverError | None:
        factor = begin + (done + share) * (end - begin)
        total = course.constant + factor * course.pattern
        solution, _ = equilibrium(
            assembly, total, assembly.displacement, assembly.held, course.tolerance
        )
        course.evaluations += solution.evaluations
        excess = solution.residual
        if solution.converged:
            excess = course.commit(solution.x, factor)
            if excess <= 1.0:
                return None
        return SolverError(
            f"{name} {factor:.6g}",
            excess,
            f"line search and load steps down to 1/{2**course.most_cuts}; no equilibrium is within "
            "reach past a limit point: use displacement control or arc length",
        )

    for point in points:
        taken = pieces(partial(attempt, course.factor, point), course.most_cuts)
        yield course.record(sum(cuts for _, _, cuts in taken))


ARC_ITERATIONS = 15
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
        for iteration in range(1, ARC_ITERATIONS + 1):
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
        return _Trial(change, factor, ARC_ITERATIONS, False, residual)

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
