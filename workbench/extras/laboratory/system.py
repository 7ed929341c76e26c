"""System for an integrator: its protocol, and the laboratory's own masses and springs.

Unknowns q obey M q'' + f(q) = W P with gaps g = W'q + c(t) >= 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, Protocol

import numpy as np

from workbench.base.arrays import Array, Flags
from workbench.base.errors import InputError
from workbench.base.fields import Declared, Many, Number, checked

PLACE, SPEED = Number(-1e9, 1e9, "m"), Number(-1e9, 1e9, "m/s")
_MASSES = Many(Number(0.0, 1e15, "kg", low_included=False), 1)
_STIFF, _CUBIC = Number(0.0, 1e18, "N/m"), Number(-1e18, 1e18, "N/m^3")
_YIELDING, _FORCE = Number(0.0, 1e18, "N/m", low_included=False), Number(0.0, 1e15, "N")
_LOAD, _FACTOR = Number(-1e15, 1e15, "N"), Number(-1e6, 1e6)
_SWING = Number(-1e9, 1e9, advice="an amplitude in m, a circular frequency in rad/s")


class System(Protocol):
    """Mass matrix (n, n), contact normals (n, m), forces with tangent, contact frame, commit."""

    mass: Array  # (n, n), in kg
    normals: Array  # directions W (n, m) of the contacts

    def forces(self, q: Array) -> tuple[Array, Array]:
        """Internal less external forces (n,) at `q` from the committed state, and tangent."""

    def mean_forces(self, q0: Array, q1: Array) -> tuple[Array, Array]:
        """Forces whose work from `q0` to `q1` is the change of energy, and d/dq1 of them."""

    def surface(self, t: float) -> tuple[Array, Array, Array]:
        """Gaps (m,) at q = 0 and time t, their velocity and acceleration."""

    def commit(self, q: Array) -> None:
        """Make the state at `q` the committed one."""

    def energy(self) -> tuple[float, float]:
        """Stored energy, of loads too, and energy dissipated so far, in J."""


@dataclass(frozen=True)
class Penalty(Declared, table="penalty"):
    """A spring that bodies meet: its `stiffness` (N/m) acts in compression alone."""

    stiffness: float = checked(_YIELDING)


@dataclass(eq=False)
class SpringSystem:
    """Masses on springs; `springs` makes it from what a problem says.

    Arguments: diagonal `mass` (n, n); `normals` (n, m); springs, each along its row of `along`
    (s, n) on e = along q + `offset`, their `laws` (s, 4): stiffness k, cubic stiffness b, and
    bounds of the elastic elongation x, force k x + b x^3; which of them are `one_sided`, others
    flow beyond; `load` (n,) in N; contact surfaces c + a sin(w t), `gap` (m,) and `swing` (a, w).
    """

    mass: Array
    normals: Array
    along: Array
    offset: Array
    laws: Array
    one_sided: Flags
    load: Array
    gap: Array
    swing: tuple[float, float]

    def __post_init__(self) -> None:
        self.k, self.b, self.low, self.high = self.laws.T
        self.spent, self.place = 0.0, np.zeros(len(self.mass))
        self.flow = np.zeros(len(self.offset))

    def _elastic(self, q: Array) -> tuple[Array, Array, Flags]:
        """Elongations e (s,), what of them is elastic, and which of that is within its bounds."""
        e = self.along @ q + self.offset
        free = e - self.flow
        return e, np.clip(free, self.low, self.high), (self.low <= free) & (free < self.high)

    def _added(self, force: Array, slope: Array) -> tuple[Array, Array]:
        """Forces (n,) and their tangent (n, n) of forces and slopes (s,) of the springs."""
        tangent: Array = self.along.T @ (slope[:, None] * self.along)
        return self.along.T @ force - self.load, tangent

    def forces(self, q: Array) -> tuple[Array, Array]:
        """Forces and tangent, see `System`; its protocol also describes the other methods."""
        _, x, inside = self._elastic(q)
        return self._added(x * (self.k + self.b * x**2), inside * (self.k + 3.0 * self.b * x**2))

    def mean_forces(self, q0: Array, q1: Array) -> tuple[Array, Array]:
        """Discrete gradient; where a one-sided spring opens or closes, by its energies."""
        (e0, x0, in0), (e1, x1, in1) = self._elastic(q0), self._elastic(q1)
        mean = (x0 + x1) * (0.5 * self.k + 0.25 * self.b * (x0**2 + x1**2))
        slope = in1 * (0.5 * self.k + 0.25 * self.b * (x0**2 + 2.0 * x0 * x1 + 3.0 * x1**2))
        crossing = self.one_sided & (in0 != in1)
        if crossing.any():
            step = np.where(crossing, e1 - e0, 1.0)
            mean = np.where(crossing, mean * (x1 - x0) / step, mean)
            slope = np.where(crossing, (self.k * x1 - mean) / step, slope)
        return self._added(mean, slope)

    def surface(self, t: float) -> tuple[Array, Array, Array]:
        """Gaps at q = 0, with their velocity and acceleration."""
        still = np.zeros(self.gap.size)
        size, w = self.swing
        if size == 0.0:
            return self.gap, still, still
        move = size * np.sin(w * t)
        return self.gap - move, still - size * w * np.cos(w * t), still + w * w * move

    def commit(self, q: Array) -> None:
        """Flow of the plastic springs, and the place."""
        (_, before, _), (e, after, _) = self._elastic(self.place), self._elastic(q)
        flow = np.where(self.one_sided, 0.0, e - after)
        self.spent += 0.5 * float(self.k * (before + after) @ (flow - self.flow))
        self.flow, self.place = flow, np.array(q)

    def energy(self) -> tuple[float, float]:
        """Stored energy with that of the loads; dissipated."""
        _, x, _ = self._elastic(self.place)
        stored = float((0.5 * self.k + 0.25 * self.b * x**2) @ x**2)
        return stored - float(self.load @ self.place), self.spent


def springs(
    masses: Sequence[float],
    laws: Sequence[tuple[dict[int, float], Penalty | tuple[float, ...], float]] = (),
    contacts: Sequence[dict[int, float]] = (),
    gaps: Sequence[float] = (),
    load: Sequence[float] | None = None,
    swing: tuple[float, float] = (0.0, 0.0),
) -> SpringSystem:
    """A system of masses (kg) on springs.

    Arguments: `masses`; `laws`, springs as (unknown to factor, law, offset in m), the law (k,) or
    (k, cubic) elastic, (k, 0, yield force), or a `Penalty`; `contacts`, gaps as unknown to factor,
    and `gaps` at q = 0 in m; constant `load` in N; `swing` of all surfaces, amplitude (m) and
    circular frequency (rad/s). Raises `InputError`.
    """
    mass = np.array(_MASSES.check("problem.masses", masses))
    n, s = mass.size, len(laws)
    for i, law in enumerate(laws):
        if not isinstance(law, tuple | list) or len(law) != 3:
            raise InputError(f"problem.laws.{i}", law, "must be (unknown to factor, law, offset)")
    rows = [_spring(f"problem.laws.{i}.law", law) for i, (_, law, _) in enumerate(laws)]
    size, frequency = numbers("swing", swing, _SWING, 2, "amplitude and circular frequency")
    return SpringSystem(
        np.diag(mass),
        np.ascontiguousarray(_rows("contacts", contacts, n).T),
        _rows("laws", [along for along, _, _ in laws], n),
        numbers("laws.offset", [offset for _, _, offset in laws], PLACE, s, "one per spring"),
        np.array(rows, dtype=float).reshape(s, 4),
        np.array([isinstance(law, Penalty) for _, law, _ in laws], dtype=bool),
        np.zeros(n) if load is None else numbers("load", load, _LOAD, n, "one per mass"),
        numbers("gaps", gaps, PLACE, len(contacts), "one per contact"),
        (float(size), float(frequency)),
    )


def numbers(name: str, given: Any, item: Number, count: int, which: str) -> Array:
    """So many numbers of a problem as an array; `which` says what they are. Raises `InputError`."""
    held = Many(item).check(f"problem.{name}", given)
    if len(held) != count:
        raise InputError(f"problem.{name}", held, f"must be {count}, {which}")
    return np.array(held, dtype=float)


def _spring(path: str, law: Penalty | tuple[float, ...]) -> tuple[float, float, float, float]:
    """Stiffness, cubic stiffness and bounds of the elastic elongation. Raises `InputError`."""
    if isinstance(law, Penalty):
        return law.stiffness, 0.0, -inf, 0.0
    if not isinstance(law, tuple | list) or not 1 <= len(law) <= 3:
        raise InputError(path, law, "must be (k,), (k, cubic), (k, 0, yield force) or a Penalty")
    stiffness, *more = law
    if len(more) < 2:
        cubic = _CUBIC.check(f"{path}.cubic", more[0] if more else 0.0)
        return _STIFF.check(f"{path}.stiffness", stiffness), cubic, -inf, inf
    if more[0] != 0.0:
        raise InputError(f"{path}.cubic", more[0], "must be 0 in a spring that yields")
    stiffness = _YIELDING.check(f"{path}.stiffness", stiffness)
    reach = _FORCE.check(f"{path}.yield_force", more[1]) / stiffness
    return stiffness, 0.0, -reach, reach


def _rows(name: str, of: Sequence[dict[int, float]], n: int) -> Array:
    """Factors of `n` unknowns, a row each. Raises `InputError`."""
    out = np.zeros((len(of), n))
    unknown = Number(0, n - 1, integer=True, advice="unknowns are counted from 0")
    for i, (row, factors) in enumerate(zip(out, of, strict=True)):
        path = f"problem.{name}.{i}"
        if not isinstance(factors, dict) or not any(factors.values()):
            raise InputError(path, factors, "must give unknowns factors other than 0, as {0: 1.0}")
        for at, factor in factors.items():
            row[int(unknown.check(path, at))] = _FACTOR.check(f"{path}.{at}", factor)
    return out
