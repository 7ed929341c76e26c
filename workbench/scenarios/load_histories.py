"""Histories of loads from what makes them: a missile that crushes, the ground near a fault."""

from typing import Any

import numpy as np
import scipy

from workbench.base.arrays import Array
from workbench.base.errors import InputError
from workbench.base.fields import Number
from workbench.base.tables import read_points
from workbench.scenarios.pulse import TABLE, Pulse

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
