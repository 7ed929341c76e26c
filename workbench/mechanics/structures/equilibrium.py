# ruff: noqa: D102 - the methods of the protocol are described where they are written
"""Equilibrium: Newton's method with a line search, steps that are halved, load control.

The drivers of static paths and of explicit steps go through states of a `Structure`.
"""

from collections.abc import Callable, Iterator
from functools import partial
from math import isfinite, isnan, nan
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from workbench.base.arrays import Array, Indices
from workbench.base.errors import InputError, SolverError
from workbench.mechanics.structures.elements import StepEnergies
from workbench.mechanics.structures.kernels import STALLED, largest

Taken = TypeVar("Taken")

ITERATIONS = 40
LARGEST_CUT, SMALLEST_CUT = 0.9, 0.1  # bounds of a regula-falsi factor
SEARCHES = 8


class ExplicitStructure(Protocol):
    """Structure as the explicit driver needs it, with a committed and a trial state."""

    size: int
    displacement: Array
    velocity: Array
    load: Array
    stored: float

    @property
    def held(self) -> Indices: ...
    def assemble(self, end: Array, weight: float | None) -> Array: ...  # prepares the tangent
    def resist(self, end: Array) -> Array: ...
    def tangent_times(self, x: Array) -> Array: ...
    def account(self, end: Array, weight: float) -> StepEnergies: ...
    def commit(self, end: Array) -> None: ...
    def mass_times(self, x: Array) -> Array: ...
    def begin_step(self, duration: float) -> None: ...
    def kinetic_energy(self) -> float: ...


class Structure(ExplicitStructure, Protocol):
    """Structure as all drivers need it, see `PlanarAssembly`."""

    def solve(self, right: Array, held: Indices | None = None) -> Array | None: ...
    def tangent_row(self, dof: int) -> tuple[Array, Indices]: ...
    def allowed_residual(self, tolerance: float, start: Array, residual: Array) -> float: ...


class Solution(NamedTuple):
    """Where Newton's method ended.

    `x` (dofs,); `converged`; `residual`, the largest entry over the largest allowed; number of
    residual `evaluations`. If converged, the last evaluation was at `x`.
    """

    x: Array
    converged: bool
    residual: float
    evaluations: int


def newton(
    evaluate: Callable[[Array], Array],
    allow: Callable[[Array], float],
    solve: Callable[[Array], Array | None],
    start: Array,
    iterations: int = 25,
) -> Solution:
    """Find x with evaluate(x) = 0.

    Arguments: `evaluate`, gives the residual (dofs,) and prepares the tangent; `allow`, gives the
    largest residual entry allowed, from the residual at the start (a bound taken from trial states
    would grow with them and let a wild state pass); `solve`, gives tangent^-1 times a vector for
    the tangent prepared last (None if it is singular); `start`; most `iterations`.

    Line search: with G(s) = d . R(x + s d), a step is taken when |G| has halved or the largest
    residual has; otherwise a zero of G is bracketed by regula falsi. For associative plasticity G
    is the slope of the incremental potential, so that this search is safe. The result may be not
    converged; that is for the caller to handle.
    """
    x = start
    residual = evaluate(x)
    allowed = allow(residual)
    evaluations = 1
    size = largest(residual)
    for _ in range(iterations):
        if size <= allowed:
            return Solution(x, True, size / allowed, evaluations)
        step = solve(-residual)
        if step is None or not isfinite(size):
            break
        slope = float(step @ residual)
        low, slope_low = 0.0, slope
        high, slope_high = nan, nan
        s = 1.0
        for _ in range(SEARCHES):
            trial = x + s * step
            residual = evaluate(trial)
            evaluations += 1
            new_size = largest(residual)
            new_slope = float(step @ residual)
            if abs(new_slope) <= 0.5 * abs(slope) or new_size <= 0.5 * size:
                break
            if isfinite(new_slope) and new_slope * slope > 0.0 and isnan(high):
                break  # no sign change in reach: take the step, the tangent will follow
            if not isfinite(new_slope) or new_slope * slope <= 0.0:
                high, slope_high = s, new_slope
            else:
                low, slope_low = s, new_slope
            if isfinite(slope_high):
                share = slope_low / (slope_low - slope_high)
                share = min(max(share, SMALLEST_CUT), LARGEST_CUT)
            else:
                share = 0.5
            s = low + share * (high - low)
        x, size = trial, new_size
    # fibers that switch between elastic and plastic within round-off can keep a residual alive
    return Solution(x, size <= STALLED * allowed, size / allowed, evaluations)


def pieces(
    attempt: Callable[[float, float], Taken | SolverError], most_cuts: int
) -> Iterator[tuple[Taken, float, int]]:
    """Go from 0 to 1 in pieces that are halved where they fail and doubled back afterwards.

    Arguments: `attempt`, from where and how far; commits and gives what it has reached, or the
    reason why it cannot. Yields what was reached, where that is, and how often a piece was halved
    since the last one; raises the reason when `most_cuts` in a row did not help. Pieces are
    multiples of powers of 1/2, so that 1 is met exactly.
    """
    done, level, cuts = 0.0, 0, 0
    while done < 1.0:
        share = 0.5**level
        taken = attempt(done, share)
        if isinstance(taken, SolverError):
            level, cuts = level + 1, cuts + 1
            if level > most_cuts:
                raise taken
            continue
        done += share
        yield taken, done, cuts
        cuts = 0
        while level > 0 and (done * 2.0 ** (level - 1)).is_integer():
            level -= 1


def equilibrium(
    assembly: Structure, load: Array, start: Array, held: Indices, tolerance: float
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


def free_pattern(assembly: Structure, pattern: Array) -> Array:
    """The load pattern without what goes straight into supports; an error if nothing is left."""
    free = np.array(pattern, dtype=float)
    free[assembly.held] = 0.0
    if not np.any(free):
        raise InputError(
            "pattern", None, "loads no free dof", "put a load where the structure can move"
        )
    return free
