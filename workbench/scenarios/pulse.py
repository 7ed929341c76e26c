"""Forces over time: pulses of impact rules and of blast, tabulated histories."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array
from workbench.base.fields import Choice, Declared, Flag, Instance, Many, Number, Text, checked
from workbench.scenarios.column import DURATION, SENSE, WEIGHS, Column, Weighed

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
    and 1 after T; table: straight lines, zero after the last time. Raises `InputError`.
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

    Under a uniform load the hit point is where the displacement is recorded and where lumped
    models have their hinge.
    """

    name: str = checked(Text(), path="name")
    column: Column = checked(Instance(Column))
    pulse: Pulse = checked(Instance(Pulse))
    load: str = checked(
        Choice((POINT, UNIFORM)),
        POINT,
        path="pulse.load",
        help="point: a force (N) on the hit point; uniform: a line load (N/m) on all the length",
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
