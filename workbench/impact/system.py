"""What an integrator asks of a system, and the laboratory's own systems of masses and springs.

Unknowns q obey M q'' + f(q) = W P with gaps g = W'q + c(t) >= 0. Integrators call the functions
below: for Python objects that keep the protocol `System` they call its methods, for `Springs` in
compiled code the kernels themselves. So every integrator is written once, and runs both ways.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numba.extending import overload

from workbench.arrays import Array
from workbench.compiled import njit
from workbench.errors import InputError
from workbench.fields import Many, Number
from workbench.impact.laws import Penalty

ELASTIC, ONE_SIDED, PLASTIC = 0, 1, 2
PLACE, SPEED = Number(-1e9, 1e9, "m"), Number(-1e9, 1e9, "m/s")
_MASSES = Many(Number(0.0, 1e15, "kg", low_included=False), 1)
_STIFF, _CUBIC = Number(0.0, 1e18, "N/m"), Number(-1e18, 1e18, "N/m^3")
_YIELDING, _FORCE = Number(0.0, 1e18, "N/m", low_included=False), Number(0.0, 1e15, "N")
_LOAD, _FACTOR = Number(-1e15, 1e15, "N"), Number(-1e6, 1e6)
_SWING = Number(-1e9, 1e9, advice="an amplitude in m, a circular frequency in rad/s")


class System(Protocol):
    """Mass matrix (n, n), contact normals (n, m), forces with tangent, contact frame, commit."""

    @property
    def mass(self) -> Array:
        """Mass matrix (n, n), in kg."""

    @property
    def normals(self) -> Array:
        """Directions W (n, m) of the contacts."""

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


class SpringLaws(NamedTuple):
    """Springs: each acts along its row of `along` (s, n) on e = along q + `offset`.

    Elastic k e + b e^3; one-sided -k (-e)^b for e < 0; plastic of stiffness k and yield force b,
    with the committed elongation in `flow`.
    """

    along: Array
    kind: Any
    k: Array
    b: Array
    offset: Array
    flow: Array


class Springs(NamedTuple):
    """Masses on springs; `springs` makes it from what a problem says.

    `laws` of the springs; `load` (n,) in N; contact surfaces c + a sin(w t), `gap` (m,) and
    `swing`; `spent` (J), `place`. Kernels take the parts that they read: a call with all of them
    costs as much as a small solution.
    """

    mass: Array
    normals: Array
    laws: SpringLaws
    load: Array
    gap: Array
    swing: Array
    spent: Array
    place: Array

    def forces(self, q: Array) -> tuple[Array, Array]:
        """As in `System`; so are the others."""
        result: tuple[Array, Array] = spring_forces(self.laws, self.load, q)
        return result

    def mean_forces(self, q0: Array, q1: Array) -> tuple[Array, Array]:
        """Discrete gradient."""
        result: tuple[Array, Array] = spring_mean_forces(self.laws, self.load, q0, q1)
        return result

    def surface(self, t: float) -> tuple[Array, Array, Array]:
        """Place, velocity, acceleration."""
        result: tuple[Array, Array, Array] = spring_surface(self.gap, self.swing, t)
        return result

    def commit(self, q: Array) -> None:
        """Plastic flow."""
        spring_commit(self.laws, self.spent, self.place, q)

    def energy(self) -> tuple[float, float]:
        """Stored and dissipated."""
        return float(spring_energy(self.laws, self.load, self.place)), float(self.spent[0])


def springs(
    masses: Sequence[float],
    laws: Sequence[tuple[dict[int, float], Penalty | tuple[float, ...], float]] = (),
    contacts: Sequence[dict[int, float]] = (),
    gaps: Sequence[float] = (),
    load: Sequence[float] | None = None,
    swing: tuple[float, float] = (0.0, 0.0),
) -> Springs:
    """A system of masses (kg) on springs.

    Arguments: `masses`; `laws`, springs as (unknown to factor, law, offset in m), the law (k,) or
    (k, cubic) elastic, (k, 0, yield force), or a `Penalty` without damping; `contacts`, gaps
    as unknown to factor, and `gaps` at q = 0 in m; constant `load` in N; `swing` of all surfaces,
    amplitude (m) and circular frequency (rad/s). Raises `InputError`.
    """
    mass = np.array(_MASSES.check("problem.masses", masses))
    n, s = mass.size, len(laws)
    for i, law in enumerate(laws):
        if not isinstance(law, tuple | list) or len(law) != 3:
            raise InputError(f"problem.laws.{i}", law, "must be (unknown to factor, law, offset)")
    kinds = [_spring(f"problem.laws.{i}.law", law) for i, (_, law, _) in enumerate(laws)]
    kind, k, b = zip(*kinds, strict=True) if kinds else ((), (), ())
    offsets = [offset for _, _, offset in laws]
    return Springs(
        np.diag(mass),
        np.ascontiguousarray(_rows("contacts", contacts, n).T),
        SpringLaws(
            _rows("laws", [along for along, _, _ in laws], n),
            *(np.array(kind, dtype=np.int64), np.array(k, dtype=float), np.array(b, dtype=float)),
            *(numbers("laws.offset", offsets, PLACE, s, "one per spring"), np.zeros(s)),
        ),
        np.zeros(n) if load is None else numbers("load", load, _LOAD, n, "one per mass"),
        numbers("gaps", gaps, PLACE, len(contacts), "one per contact"),
        numbers("swing", swing, _SWING, 2, "amplitude and circular frequency"),
        *(np.zeros(1), np.zeros(n)),
    )


def numbers(name: str, given: Any, item: Number, count: int, which: str) -> Array:
    """So many numbers of a problem as an array; `which` says what they are. Raises `InputError`."""
    held = Many(item).check(f"problem.{name}", given)
    if len(held) != count:
        raise InputError(f"problem.{name}", held, f"must be {count}, {which}")
    return np.array(held, dtype=float)


def _spring(path: str, law: Penalty | tuple[float, ...]) -> tuple[int, float, float]:
    """Kind of a spring and its two numbers. Raises `InputError`."""
    if isinstance(law, Penalty):
        if law.damping:
            advice = "take a contact with the restitution of Penalty.rebound for it"
            raise InputError(f"{path}.damping", law.damping, "must be 0 in springs", advice)
        return ONE_SIDED, law.stiffness, law.exponent
    if not isinstance(law, tuple | list) or not 1 <= len(law) <= 3:
        raise InputError(path, law, "must be (k,), (k, cubic), (k, 0, yield force) or a Penalty")
    stiffness, *more = law
    if len(more) < 2:
        cubic = _CUBIC.check(f"{path}.cubic", more[0] if more else 0.0)
        return ELASTIC, _STIFF.check(f"{path}.stiffness", stiffness), cubic
    if more[0] != 0.0:
        raise InputError(f"{path}.cubic", more[0], "must be 0 in a spring that yields")
    force = _FORCE.check(f"{path}.yield_force", more[1])
    return PLASTIC, _YIELDING.check(f"{path}.stiffness", stiffness), force


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


@njit(cache=True, error_model="numpy")
def one_spring(kind, k, b, flow, e):
    """Force, stiffness and energy of a spring at elongation e."""
    if kind == ELASTIC:
        return k * e + b * e**3, k + 3.0 * b * e**2, 0.5 * k * e**2 + 0.25 * b * e**4
    if kind == ONE_SIDED:
        d = max(-e, 0.0)
        force = -k * d**b
        slope = b * k * d ** (b - 1.0) if d > 0.0 else 0.0
        return force, slope, -force * d / (b + 1.0)
    force = k * (e - flow)
    if abs(force) <= b:
        return force, k, 0.5 * force**2 / k
    return (b if force > 0.0 else -b), 0.0, 0.5 * b**2 / k


@njit(cache=True, error_model="numpy")
def one_mean(kind, k, b, flow, e0, e1):
    """Force whose work from e0 to e1 is the change of energy (stored and spent), and d/de1."""
    f0, _, u0 = one_spring(kind, k, b, flow, e0)
    f1, slope, u1 = one_spring(kind, k, b, flow, e1)
    if kind == ELASTIC:
        mean = 0.5 * k * (e0 + e1) + 0.25 * b * (e0 + e1) * (e0**2 + e1**2)
        return mean, 0.5 * k + 0.25 * b * (e0**2 + 2.0 * e0 * e1 + 3.0 * e1**2)
    step = e1 - e0
    if kind == PLASTIC or abs(step) <= 1e-7 * (abs(e0) + abs(e1)):
        return 0.5 * (f0 + f1), 0.5 * slope
    mean = (u1 - u0) / step
    return mean, (f1 - mean) / step


@njit(cache=True, error_model="numpy")
def spring_forces(laws, load, q):
    """Forces and tangent of springs and loads."""
    f, K = -load, np.zeros((q.size, q.size))
    for i in range(laws.k.size):
        row = laws.along[i]
        e = row @ q + laws.offset[i]
        force, slope, _ = one_spring(laws.kind[i], laws.k[i], laws.b[i], laws.flow[i], e)
        f += force * row
        K += slope * np.outer(row, row)
    return f, K


@njit(cache=True, error_model="numpy")
def spring_mean_forces(laws, load, q0, q1):
    """Energy-consistent forces of a step and their tangent."""
    f, K = -load, np.zeros((q0.size, q0.size))
    for i in range(laws.k.size):
        row, c = laws.along[i], laws.offset[i]
        law = laws.kind[i], laws.k[i], laws.b[i], laws.flow[i]
        force, slope = one_mean(*law, row @ q0 + c, row @ q1 + c)
        f += force * row
        K += slope * np.outer(row, row)
    return f, K


@njit(cache=True, error_model="numpy")
def spring_surface(gap, swing, t):
    """Gaps at q = 0, with their velocity and acceleration."""
    still = np.zeros(gap.size)
    size, w = swing
    if size == 0.0:
        return gap, still, still
    move = size * np.sin(w * t)
    return gap - move, still - size * w * np.cos(w * t), still + w * w * move


@njit(cache=True, error_model="numpy")
def spring_commit(laws, spent, place, q):
    """Flow of the plastic springs, and the place."""
    for i in range(laws.k.size):
        if laws.kind[i] == PLASTIC:
            k, row = laws.k[i], laws.along[i]
            before = k * (row @ place + laws.offset[i] - laws.flow[i])
            e = row @ q + laws.offset[i]
            after, _, _ = one_spring(PLASTIC, k, laws.b[i], laws.flow[i], e)
            flow = e - after / k
            spent[0] += 0.5 * (before + after) * (flow - laws.flow[i])
            laws.flow[i] = flow
    place[:] = q


@njit(cache=True, error_model="numpy")
def spring_energy(laws, load, place):
    """Stored energy with that of the loads."""
    stored = -(load @ place)
    for i in range(laws.k.size):
        e = laws.along[i] @ place + laws.offset[i]
        stored += one_spring(laws.kind[i], laws.k[i], laws.b[i], laws.flow[i], e)[2]
    return stored


def forces(system: System, q: Array) -> tuple[Array, Array]:
    """Forces and tangent at `q`."""
    return system.forces(q)


def mean_forces(system: System, q0: Array, q1: Array) -> tuple[Array, Array]:
    """Energy-consistent forces of a step, and their tangent in `q1`."""
    return system.mean_forces(q0, q1)


def surface(system: System, t: float) -> tuple[Array, Array, Array]:
    """Place, velocity and acceleration of the contact surfaces."""
    return system.surface(t)


def commit(system: System, q: Array) -> None:
    """Accept the state at `q`."""
    system.commit(q)


def energy(system: System) -> tuple[float, float]:
    """Stored and dissipated energy of the committed state."""
    return system.energy()


@overload(forces)
def _forces(system, q):
    return lambda system, q: spring_forces(system.laws, system.load, q)


@overload(mean_forces)
def _mean_forces(system, q0, q1):
    return lambda system, q0, q1: spring_mean_forces(system.laws, system.load, q0, q1)


@overload(surface)
def _surface(system, t):
    return lambda system, t: spring_surface(system.gap, system.swing, t)


@overload(commit)
def _commit(system, q):
    return lambda system, q: spring_commit(system.laws, system.spent, system.place, q)


@overload(energy)
def _energy(system):
    return lambda system: (
        spring_energy(system.laws, system.load, system.place),
        system.spent[0],
    )
