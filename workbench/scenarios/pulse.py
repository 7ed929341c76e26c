"""Forces over time: pulses of impact rules and of blast, tabulated histories.

**Second part.** Histories of loads from what makes them: a missile that crushes, the ground near a
fault.

**Third part.** Vehicles of EN 1991-1-7 as strikers, and the static forces that stand for them.

The standard was not at hand: the numbers are recalled and *not verified in print*, but for the
forces of cars (50 and 25 kN) and for what the JCSS Probabilistic Model Code, 2.18, has as well: the
angle, the motion below and the stiffness. A national annex may have others.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import radians, sin, sqrt
from typing import Any, ClassVar, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from workbench.base.arrays import Array
from workbench.base.errors import InputError
from workbench.base.fields import Choice, Declared, Flag, Instance, Many, Number, Text, checked
from workbench.base.tables import read_points
from workbench.scenarios.column import DURATION, SENSE, WEIGHS, Column, Striker, Weighed

TABLE, POINT, UNIFORM = "table", "point", "uniform"
PULSES = ("rectangular", "triangular", "exponential", "friedlander", "ramp", TABLE)
LENGTH = Number(1e-9, 1e3, "s", advice="lengths of pulses are in seconds")
PEAK = Number(1e-6, 1e12, "N or N/m")
_TIMES = Many(Number(0.0, 1e3, "s"), 2, 100_000)
_FACTORS = Many(Number(-1e6, 1e6), 2, 100_000)


def line_integral(times: ArrayLike, values: ArrayLike) -> Callable[[ArrayLike], Array]:
    """Integral from 0 on, at any times (s), of straight lines between `values` at rising `times`.

    The first of the `times` is 0; nothing is added after the last.
    """
    knots, heights = np.asarray(times, dtype=float), np.asarray(values, dtype=float)
    slopes = np.diff(heights) / np.diff(knots)
    sums = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(knots) * (heights[1:] + heights[:-1]))])

    def integral(time: ArrayLike) -> Array:
        at = np.minimum(time, knots[-1])
        i = np.minimum(np.searchsorted(knots, at, side="right") - 1, len(slopes) - 1)
        into = at - knots[i]
        return np.asarray(sums[i] + into * (heights[i] + 0.5 * slopes[i] * into))

    return integral


@dataclass(frozen=True)
class Pulse(Declared, table="pulse"):
    """A force over time, p(t) = `peak` f(t) from t = 0 on.

    With x = t / T, T the `length`: rectangular f = 1, triangular f = 1 - x, friedlander
    f = (1 - x) exp(-`decay` x), all zero after T; exponential f = exp(-x) for ever; ramp f = x,
    and 1 after T; table: straight lines, zero after the last time.

    Examples
    --------
    >>> wb.Pulse("triangular", peak=2e5, length=0.02).whole  # N s
    2000.0
    """

    shape: str = checked(Choice(PULSES))
    peak: float = checked(PEAK, help="N/m on members")
    length: float | None = checked(LENGTH, optional=True)
    decay: float = checked(Number(0.01, 100.0), 1.0, help="of the friedlander pulse")
    times: tuple[float, ...] | None = checked(_TIMES, optional=True, help="of a table, from 0")
    factors: tuple[float, ...] | None = checked(_FACTORS, optional=True, help="f at these times")

    def check(self) -> None:
        """Refuse shapes that lack what they are made of, or have what is of another."""
        if self.shape != TABLE:
            if self.length is None:
                raise self.refusal("length", "is missing", f"shape = {self.shape} needs it, in s")
            for name in ("times", "factors"):
                if getattr(self, name) is not None:
                    raise self.refusal(name, f"is for shape = {TABLE} alone")
            return
        if self.times is None or self.factors is None:
            name = "times" if self.times is None else "factors"
            raise self.refusal(name, "is missing", f"shape = {TABLE} needs times and factors")
        if len(self.times) != len(self.factors):
            text = f"must be as many as the times, {len(self.times)}"
            raise self.refusal("factors", text, f"{len(self.factors)} are given")
        if self.times[0] != 0.0 or not np.all(np.diff(self.times) > 0.0):
            raise self.refusal("times", "must rise from 0", "times are those since the start, in s")
        if self.peak * max(map(abs, self.factors)) < PEAK.low:
            raise self.refusal("factors", f"must make {PEAK.low:g} {PEAK.unit} somewhere")

    @property
    def end(self) -> float:
        """Time (s) after which nothing changes much: the length, of the exponential five."""
        if self.times is not None:
            return self.times[-1]
        assert self.length is not None
        return 5.0 * self.length if self.shape == "exponential" else self.length

    @property
    def whole(self) -> float:
        """Impulse (N s, or N s/m) of all of it; of a ramp until it stays."""
        if self.shape == "exponential":
            return self.peak * (self.length or 0.0)
        return float(self.impulse(self.end))

    @property
    def lasts(self) -> float:
        """Length (s) of a rectangular pulse of this largest force and impulse, suction as push."""
        if self.times is None:
            return self.whole / self.peak
        sizes = np.abs(self.factors or ())
        return float(np.trapezoid(sizes, self.times) / sizes.max())

    def force(self, time: ArrayLike) -> Array:
        """Force (N, or N/m) at times >= 0 (s), any shape."""
        t = np.asarray(time, dtype=float)
        if self.times is not None:
            return np.asarray(self.peak * np.interp(t, self.times, self.factors or (), right=0.0))
        x = t / self.length
        factor = {
            "rectangular": np.where(x < 1.0, 1.0, 0.0),
            "triangular": np.maximum(1.0 - x, 0.0),
            "exponential": np.exp(-x),
            "friedlander": np.maximum(1.0 - x, 0.0) * np.exp(-self.decay * x),
            "ramp": np.minimum(x, 1.0),
        }
        return np.asarray(self.peak * factor[self.shape])

    def impulse(self, time: ArrayLike) -> Array:
        """Integral (N s, or N s/m) of the force from 0 to times >= 0 (s), any shape: exact."""
        t = np.asarray(time, dtype=float)
        if self.times is not None:
            return np.asarray(self.peak * line_integral(self.times, self.factors or ())(t))
        assert self.length is not None
        x, b = t / self.length, self.decay
        s = np.minimum(x, 1.0)
        fallen = np.exp(-b * s)
        gained = {
            "rectangular": s,
            "triangular": s - 0.5 * s**2,
            "exponential": -np.expm1(-x),
            "friedlander": (1.0 - fallen) / b - (1.0 - fallen * (1.0 + b * s)) / b**2,
            "ramp": x - s + 0.5 * s**2,
        }
        return np.asarray(self.peak * self.length * gained[self.shape])

    def means(self, times: Array) -> Array:
        """Mean forces (n - 1,) between rising `times` (n,) in s."""
        return np.asarray(np.diff(self.impulse(times)) / np.diff(times))


@dataclass(frozen=True)
class MemberPulse(Weighed, Declared, table="time"):
    """A pulse on a member, a `column` at rest under its axial load, and its weight if it lies.

    Under a uniform load the impact point is where the displacement is recorded and where lumped
    models have their hinge.

    Examples
    --------
    >>> blast = wb.Pulse("friedlander", peak=4e4, length=0.02, decay=1.5)
    >>> wb.MemberPulse("blast", wb.Column("HEB 220", 2.0, 2.0), blast, load="uniform").whole  # m
    4.0
    """

    name: str = checked(Text(), path="name")
    column: Column = checked(Instance(Column))
    pulse: Pulse = checked(Instance(Pulse))
    load: str = checked(
        Choice((POINT, UNIFORM)),
        POINT,
        path="pulse.load",
        help="point: a force (N) on the impact point; uniform: a line load (N/m) on all the length",
    )
    duration: float = checked(DURATION, 0.1)
    direction: str | None = checked(
        SENSE, optional=True, path="pulse.direction", help="of the force, horizontal by default"
    )
    gravity: bool | None = checked(Flag(), optional=True, path="gravity", help=WEIGHS)

    KIND: ClassVar[str] = "member-pulse"
    READING: ClassVar[int] = 2  # raised when what all models read off their histories changes
    STATIC: ClassVar[bool] = False

    @property
    def whole(self) -> float:
        """Force of the whole load over the pulse: 1, or the length (m) of a loaded member."""
        return self.column.length if self.load == UNIFORM else 1.0


MISSILE = {
    "station_m": Number(0.0, 1e3, "m"),
    "mass_kg_per_m": Number(0.0, 1e6, "kg/m"),
    "crushing_force_N": Number(0.0, 1e12, "N"),
}
VELOCITY = Number(1e-3, 1e3, "m/s")
_PARTS, _FINE, _HALVINGS = 400, 4000, 40  # of a missile; of what is left of it
_AT, _WEIGHT = np.polynomial.legendre.leggauss(5)


def missile_of(data: bytes, name: str) -> Array:
    """Points (n, 3) of a table of a missile, see `missile_pulse`. Raises `InputError`."""
    return read_points(data, name, "missile", MISSILE, 2)[0]


def missile_pulse(points: Array, velocity: float) -> Pulse:
    """Force of a missile that crushes at a rigid wall (Riera 1968), as a table.

    Arguments: `points` (n, 3), places (m) from the nose, from 0, mass (kg/m) and force (N) under
    which the missile crushes there, straight between; `velocity` (m/s). With x the crushed length
    and M what is left, F = P_c(x) + mu(x) v^2 and M v' = -P_c, so that v^2 = v_0^2 - 2 int P_c / M
    dx, and F = -(M v)': times between the places are those with which straight lines have exactly
    the momentum. Crushing ends with the velocity or the missile. Raises `InputError`.
    """
    x, mu, crushing = np.asarray(points, dtype=float).T
    velocity = VELOCITY.check("velocity", velocity)
    if x[0] != 0.0 or not np.any(mu > 0.0):
        raise InputError("missile", None, "must begin at 0 m and have a mass")
    whole = np.append(0.0, np.cumsum(0.5 * np.diff(x) * (mu[1:] + mu[:-1])))
    end, none = x[np.argmax(whole >= whole[-1])], 1e-15 * whole[-1]  # no mass is behind it

    def left(at: Array) -> Array:
        i = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
        gone = whole[i] + 0.5 * (at - x[i]) * (mu[i] + np.interp(at, x, mu))
        return np.asarray(np.maximum(whole[-1] - gone, 0.0))

    def slowed(a: Any, b: Any) -> Any:
        """Fall of v^2 from a to b, in which nothing has a corner."""
        at = 0.5 * (a + b)[..., None] + 0.5 * (b - a)[..., None] * _AT
        return (b - a) * np.sum(_WEIGHT * np.interp(at, x, crushing) / (left(at) + none), axis=-1)

    tail = end * (1.0 - 0.5 ** (np.arange(4 * _HALVINGS) / 4.0))  # where M goes to zero
    fine = np.unique(np.concatenate([x[x <= end], np.linspace(0.0, end, _FINE), tail]))
    squares = velocity**2 - np.append(0.0, np.cumsum(slowed(fine[:-1], fine[1:])))
    if (squares <= 0.0).any():
        n = int(np.argmax(squares <= 0.0)) - 1
        low, square = fine[n : n + 1], squares[n]
        stop = scipy.optimize.brentq(
            lambda b: square - slowed(low, np.array([b]))[0], low[0], fine[n + 1]
        )
        end, squares = float(stop), np.maximum(squares, 0.0)
    at = np.unique(np.concatenate([x[x < end], np.linspace(0.0, end, _PARTS)]))
    before = np.searchsorted(fine, at, side="right") - 1
    speed = np.sqrt(np.maximum(squares[before] - slowed(fine[before], at), 0.0))
    if end < fine[-1]:
        speed[-1] = 0.0
    force = np.interp(at, x, crushing) + np.interp(at, x, mu) * speed**2
    lost, pushed = -np.diff(left(at) * speed), force[1:] + force[:-1]
    coasting = np.diff(at) / np.maximum(0.5 * (speed[1:] + speed[:-1]), 1e-300)
    time = np.where(pushed > 0.0, 2.0 * lost / np.where(pushed > 0.0, pushed, 1.0), coasting)
    times, top = np.append(0.0, np.cumsum(time)), float(force.max())
    return Pulse(TABLE, top, times=tuple(times), factors=tuple(force / top))


def near_fault_motion(
    amplitude: float, frequency: float, cycles: float, phase: float, parts: int = 200
) -> tuple[float, Array]:
    """Time step (s) and accelerations (m/s2) of the ground near a fault.

    Derivative of the pulse v = (A / 2) (1 + cos(2 pi f s / gamma)) cos(2 pi f s + nu), |s| <=
    gamma / (2 f) (Mavroeidis and Papageorgiou 2003). Arguments: `amplitude` A in m/s, `frequency`
    f in Hz, `cycles` gamma, above 1, `phase` nu in degrees, `parts` of a period. Raises
    `InputError`.
    """
    for name, value, rule in (
        ("amplitude", amplitude, Number(0.0, 100.0, "m/s", low_included=False)),
        ("frequency", frequency, Number(0.01, 100.0, "Hz")),
        ("cycles", cycles, Number(1.0, 100.0, low_included=False)),
        ("phase", phase, Number(-360.0, 360.0, "degrees")),
    ):
        rule.check(name, value)
    steps = int(np.ceil(parts * cycles))
    s = np.linspace(-0.5, 0.5, steps + 1) * cycles / frequency
    envelope, wave = 2.0 * np.pi * frequency * s / cycles, 2.0 * np.pi * frequency * s
    wave = wave + np.radians(phase)
    turning = np.sin(envelope) * np.cos(wave) / cycles + (1.0 + np.cos(envelope)) * np.sin(wave)
    return cycles / frequency / steps, -np.pi * frequency * amplitude * turning


class Traffic(NamedTuple):
    """Vehicles of one place: static forces (N) along and across the traffic, Table 4.1.

    And the design values of Table C.2 (0: it has none): mass (kg), velocity (m/s).
    """

    title: str
    along: float
    across: float
    mass: float = 0.0
    velocity: float = 0.0


TRAFFIC = {
    "motorway": Traffic("motorways and main roads", 1e6, 5e5, 3e4, 90.0 / 3.6),
    "rural": Traffic("country roads in rural areas", 7.5e5, 3.75e5),
    "urban": Traffic("roads in urban areas", 5e5, 2.5e5, 3e4, 50.0 / 3.6),
    "yard-lorries": Traffic("courtyards with lorries", 1.5e5, 7.5e4, 3e4, 15.0 / 3.6),
    "yard-cars": Traffic("courtyards with cars alone", 5e4, 2.5e4, 1.5e3, 20.0 / 3.6),
    "garage": Traffic("parking garages with cars alone", 5e4, 2.5e4, 1.5e3, 10.0 / 3.6),
}
FORCES = {
    name + suffix: force
    for name, each in TRAFFIC.items()
    for suffix, force in (("", each.along), ("-across", each.across))
}
LIGHTEST = min(each.mass for each in TRAFFIC.values() if each.mass)  # kg, of design vehicles
VEHICLE_STIFFNESS = 3.0e5  # N/m, Annex C; JCSS: of cars and lorries alike, standard deviation 6e4
DECELERATION = 3.0  # m/s^2, Table C.2; the mean of Table C.1 and of the JCSS is 4
ANGLE = 10.0  # degrees to the road, the mean of Table C.1 and of the JCSS


def velocity_after(
    velocity: float, distance: float, deceleration: float = DECELERATION, angle: float = ANGLE
) -> float:
    """Velocity (m/s) at a column at a `distance` (m) from where the vehicle leaves its lane.

    It leaves with a `velocity` (m/s) at an `angle` (degrees) to the road and is braked on its way
    s = d / sin(angle) by a `deceleration` (m/s^2): v_r = (v_0^2 - 2 a s)^1/2. Raises `InputError`
    for a distance that it does not reach, d_b = v_0^2 sin(angle) / (2 a).
    """
    velocity = Number(1e-3, 200.0, "m/s").check("velocity", velocity)
    distance = Number(0.0, 1e4, "m").check("distance", distance)
    deceleration = Number(1e-3, 20.0, "m/s^2").check("deceleration", deceleration)
    angle = Number(0.1, 90.0, "degrees").check("angle", angle)
    reached = velocity**2 * sin(radians(angle)) / (2.0 * deceleration)
    if distance >= reached:
        text = f"must be below {reached:.4g} m, where the vehicle has come to rest"
        raise InputError("distance", distance, text, "no impact is to be designed for")
    return velocity * sqrt(1.0 - distance / reached)


def design_striker(
    traffic: str,
    distance: float = 0.0,
    deceleration: float = DECELERATION,
    angle: float = ANGLE,
    stiffness: float | None = None,
) -> Striker:
    """Return the vehicle of Table C.2 as a striker, as fast as `velocity_after` a distance (m).

    It crushes with a `stiffness` (N/m), such as `VEHICLE_STIFFNESS`, or is rigid. Raises
    `InputError`, also for a kind of `traffic` without design values.
    """
    known = tuple(name for name, each in TRAFFIC.items() if each.mass)
    vehicle = TRAFFIC[Choice(known).check("traffic", traffic)]
    velocity = velocity_after(vehicle.velocity, distance, deceleration, angle)
    return Striker(vehicle.mass, velocity, stiffness=stiffness)
