"""Forces over time, and ground motion, whose structure is followed relative to its supports.

In coordinates relative to the ground, M x'' + damping M x' + f(x) = p - M r a(t): r is the rigid
displacement of all dofs for a unit displacement of the ground, M includes point masses, and dead
loads p stay. Time steps are those of the energy-exact midpoint scheme, with the mean acceleration
of the step, so that the ledger closes with the input energy -r . M (x1 - x0) a (Uang and Bertero
1990, relative energy).
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array
from workbench.errors import InputError
from workbench.structures.assembly import PlanarAssembly
from workbench.structures.time_steps import TimeStep, march, settle, solve_step

AXES = {"x": "u", "y": "v"}


class Accelerogram:
    """Acceleration of the ground: straight lines between samples, zero after the last one.

    Arguments: `samples` in m/s2 at the times 0, `interval`, 2 `interval`, ... (s). Raises
    `InputError`.
    """

    def __init__(self, samples: ArrayLike, interval: float) -> None:
        self.samples: Array = np.atleast_1d(np.asarray(samples, dtype=float))
        self.interval = interval
        if not (self.samples.ndim == 1 and np.all(np.isfinite(self.samples))):
            raise InputError("acceleration", None, "must be one or more finite numbers")
        if not interval > 0.0:
            raise InputError("sample_step", interval, "must be positive")
        means = 0.5 * (self.samples[1:] + self.samples[:-1])
        self._velocity = np.concatenate([[0.0], np.cumsum(means)]) * interval

    def velocity(self, time: float) -> float:
        """Velocity of the ground at a time, in m/s: the integral of the acceleration."""
        last = len(self.samples) - 1
        place = min(max(time / self.interval, 0.0), float(last))
        sample = min(int(place), max(last - 1, 0))
        share = place - sample
        gained = self.samples[sample] * share
        if share > 0.0:
            gained += 0.5 * (self.samples[sample + 1] - self.samples[sample]) * share**2
        return float(self._velocity[sample] + gained * self.interval)

    def mean(self, begin: float, length: float) -> float:
        """Mean acceleration of a step, in m/s2."""
        return (self.velocity(begin + length) - self.velocity(begin)) / length


def rigid_displacement(assembly: PlanarAssembly, axis: str) -> Array:
    """Displacements (dofs,) of all nodes when the ground moves by 1 along `axis`, x or y."""
    direction = np.zeros(assembly.size)
    direction[assembly.dofs(range(len(assembly.coordinates)), AXES[axis])] = 1.0
    return direction


def ground_motion(
    assembly: PlanarAssembly,
    direction: Array,
    acceleration: ArrayLike,
    sample_step: float,
    spans: Sequence[tuple[float, float]],
    weight: float,
    damping: float = 0.0,
    tolerance: float = 1e-8,
    most_cuts: int = 12,
) -> Iterator[TimeStep]:
    """Follow a structure on moving ground; displacements and velocities are relative to it.

    Arguments: `assembly` at rest under its dead loads; `direction` (dofs,), see
    `rigid_displacement`; `acceleration` samples of the ground (m/s2) every `sample_step` (s), zero
    after the last; `spans`, end times and nominal steps of successive parts of the record (s);
    `weight` of the end stresses, 1/2 to 1 (1/2 conserves energy exactly); mass-proportional
    `damping` in 1/s; `tolerance` of the residual over the largest force; `most_cuts`, how often a
    step may be halved when Newton's method fails.
    Gives a `TimeStep` after each commit. Raises `SolverError` and `InputError`.
    """
    ground = Accelerogram(acceleration, sample_step)
    if np.shape(direction) != (assembly.size,):
        raise InputError("direction", None, f"must be a number for each of {assembly.size} dofs")
    driven = assembly.mass_times(np.asarray(direction, dtype=float))
    return follow_force(
        assembly, -driven, ground.mean, spans, weight, damping, tolerance, most_cuts
    )


def follow_force(
    assembly: PlanarAssembly,
    pattern: Array,
    mean: Callable[[float, float], float],
    spans: Sequence[tuple[float, float]],
    weight: float,
    damping: float = 0.0,
    tolerance: float = 1e-8,
    most_cuts: int = 12,
) -> Iterator[TimeStep]:
    """Follow a structure under a `pattern` (dofs,) of forces times a factor over time.

    `mean` gives the mean factor of a step from its start and its length (s); the rest as
    `ground_motion`. Yields a `TimeStep` after each commit. Raises `SolverError` and `InputError`.
    """
    if not (np.isfinite(damping) and damping >= 0.0):
        raise InputError("damping", damping, "must not be negative")

    def advance(begin: float, dt: float) -> tuple[TimeStep | None, int, float]:
        factor = mean(begin, dt)
        load = assembly.load + factor * pattern
        trial = solve_step(assembly, dt, weight, load, tolerance, damping=damping)
        found = trial.solution
        if not found.converged:
            return None, found.evaluations, found.residual
        change = found.x - assembly.displacement
        damped = damping * float(change @ assembly.mass_times(change)) / dt
        given = factor * float(pattern @ change)
        step = settle(assembly, dt, found.x, trial.velocity, weight)
        step = step._replace(acceleration=factor, input_energy=given, damped=damped)
        return step, found.evaluations, found.residual

    return march(spans, advance, most_cuts, "line search")
