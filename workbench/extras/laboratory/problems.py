"""Impact problems with known answers: exact ones, or certified by event-driven steps.

A certified answer is that of the event-driven integrator at half the finest step asked for; the
tests hold it to scipy's `solve_ivp` with events. Quantities are SI.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from math import asin, pi, sqrt

import numpy as np
from scipy.optimize import brentq

from workbench.base.arrays import Array
from workbench.base.errors import InputError
from workbench.base.fields import did_you_mean
from workbench.extras.laboratory.complementarity import Restitution
from workbench.extras.laboratory.schemes.event_driven import event_driven
from workbench.extras.laboratory.system import Penalty, System, springs
from workbench.extras.laboratory.systems import run

G = 9.81  # m/s2
_FINER = 2
HEIGHTS = 0.8, 0.85, 0.9, 0.95, 1.05, 1.1, 1.15


@dataclass(frozen=True)
class BenchProblem:
    """A system that meets obstacles, and what becomes of it.

    Arguments: `title`; `source` of the answer in words; `system` makes it new; `law`; `start`, q
    and v (n,); `duration` in s; `exact`, places (k, n) at times (k,), None where the answer is
    certified; `steps` of the coarsest of a ladder; `impacts`, how often a contact begins (None:
    without end, or not known); `conservative`, whether no energy comes or goes;
    `certified`, how far off an answer that is not exact may be, over the largest place; `others`,
    the same from other starts, as where in a step an impact falls decides the error of one ladder.
    """

    title: str
    source: str
    system: Callable[[], System]
    law: Restitution
    start: tuple[tuple[float, ...], tuple[float, ...]]
    duration: float
    exact: Callable[[Array], Array] | None = None
    steps: int = 40
    impacts: int | None = None
    conservative: bool = False
    certified: float = 1e-6
    others: "tuple[BenchProblem, ...]" = ()

    def answer(self, times: Array) -> Array:
        """Places (k, n) at equidistant times (k,) from 0 to the duration."""
        if self.exact is not None:
            return self.exact(times)
        h = float(times[1] - times[0]) / _FINER
        reference = run(event_driven(), self.system(), self.law, self.start, self.duration, h)
        return reference.q[::_FINER]


def flights(e: float, height: float, times: Array) -> Array:
    """A ball that falls from `height` (m) and bounces: tau_k+1 = e tau_k, through Zeno's point."""
    places = np.zeros(times.size)
    begin, speed = 0.0, 0.0
    flight, start = sqrt(2.0 * height / G), height
    while flight > 1e-14 and begin <= times[-1]:
        on = (times >= begin) & (times <= begin + flight)
        tau = times[on] - begin
        places[on] = start + speed * tau - 0.5 * G * tau**2
        begin += flight
        speed = e * (G * flight - speed)
        flight, start = 2.0 * speed / G, 0.0
    return places[:, None]


def ball(e: float, height: float = 0.3, heights: tuple[float, ...] = HEIGHTS) -> BenchProblem:
    """A ball that bounces on the floor; `heights` of other starts over its own."""
    return BenchProblem(
        f"ball, e = {e:g}",
        "parabolas; impacts accumulate where e < 1",
        *(partial(springs, [1.0], (), [{0: 1.0}], [0.0], [-G]), Restitution(e)),
        *(((height,), (0.0,)), 1.0),
        lambda times: flights(e, height, times),
        steps=50,
        conservative=e == 1.0,
        others=tuple(ball(e, share * height, ()) for share in heights),
    )


def table() -> BenchProblem:
    """A ball that bounces once in every period of a vibrating table."""
    e, period, speed = 0.5, 0.2, 0.45  # the last of the table, amplitude times frequency
    w, up = 2.0 * pi / period, 0.5 * G * period
    phase = np.arccos(up * (1.0 - e) / (1.0 + e) / speed)  # of impact: up = (1 + e) s' + e up
    size = speed / w

    def exact(times: Array) -> Array:
        tau = np.mod(times - phase / w, period)
        places: Array = size * np.sin(phase) + up * tau - 0.5 * G * tau**2
        return places[:, None]

    system = partial(springs, [1.0], (), [{0: 1.0}], [0.0], [-G], (size, w))
    tau = -phase / w % period
    start = (float(exact(np.zeros(1))[0, 0]),), (up - G * tau,)
    source = "closed form of the periodic motion (Holmes 1982)"
    return BenchProblem(
        "ball on a table", source, system, Restitution(e), start, 2.0, exact, 100, impacts=10
    )


def two_masses(e: float = 0.5) -> BenchProblem:
    """A lorry's mass hits a free one at rest."""
    heavy, light, speed, gap = 1500.0, 100.0, 20.0, 0.1
    after = heavy * speed / (heavy + light)
    kick = e * speed / (heavy + light)

    def exact(times: Array) -> Array:
        tau = np.maximum(times - gap / speed, 0.0)
        first = speed * np.minimum(times, gap / speed) + (after - light * kick) * tau
        return np.column_stack([first, (after + heavy * kick) * tau])

    system = partial(springs, [heavy, light], contacts=[{0: -1.0, 1: 1.0}], gaps=[gap])
    return BenchProblem(
        "two masses",
        "momentum and restitution",
        *(system, Restitution(e), ((0.0, 0.0), (speed, 0.0)), 0.02, exact),
        impacts=1,
    )


def cradle(law: str = "newton", coefficients: tuple[float, ...] = (1.0,)) -> BenchProblem:
    """A ball hits two that touch: three equal balls, both contacts at once."""
    first, second = (*coefficients, *coefficients)[:2]
    ends = np.array([1.0 - 2.0 * first, 1.0 + first, 1.0 + first]) / 3.0
    if law == "poisson" and first < second:  # the second ball may be thrown back onto the first
        ends = np.array([1.0 - 2.0 * first, 1.0 + 2.0 * first - second, 1.0 + second]) / 3.0
        ends[:2] = ends[:2] if ends[1] > ends[0] else ends[:2].mean()
    gap = 0.1

    def exact(times: Array) -> Array:
        tau = np.maximum(times - gap, 0.0)
        first: Array = np.outer(np.minimum(times, gap), [1.0, 0.0, 0.0])
        return first + np.outer(tau, ends)

    pairs: list[dict[int, float]] = [{0: -1.0, 1: 1.0}, {1: -1.0, 2: 1.0}]
    system = partial(springs, [1.0] * 3, contacts=pairs, gaps=[gap, 0.0])
    return BenchProblem(
        "cradle",
        f"simultaneous impacts by the law of {law.title()}",
        *(system, Restitution(coefficients, law), ((0.0,) * 3, (1.0, 0.0, 0.0)), 0.4, exact),
        impacts=2,
        conservative=law == "newton" and first == 1.0,
    )


def oscillator(distance: float = 0.6) -> BenchProblem:
    """An oscillator of amplitude and frequency 1 against an elastic wall; at 1 m it grazes."""
    quarter = asin(distance)
    period = 2.0 * quarter + pi

    def exact(times: Array) -> Array:
        tau = np.mod(times, period)
        return np.where(tau < quarter, -np.sin(tau), np.sin(tau - 2.0 * quarter))[:, None]

    system = partial(springs, [1.0], [({0: 1.0}, (1.0,), 0.0)], [{0: 1.0}], [distance])
    grazes = distance >= 1.0
    duration = 10.0
    return BenchProblem(
        "grazing" if grazes else "oscillator",
        "harmonic between impacts",
        *(system, Restitution(1.0), ((0.0,), (-1.0,)), duration),
        (lambda times: -np.sin(times)[:, None]) if grazes else exact,
        impacts=0 if grazes else int((duration - quarter) // period) + 1,
        conservative=True,
    )


def bar(elements: int = 20) -> BenchProblem:
    """A linear bar (length, mass, stiffness and wave speed 1) hits a rigid wall at 0.1.

    D'Alembert's bar leaves after 2 L / c as fast as it came. Lumped into elements its first mass
    stops at once and loses 1 / (2 elements) of the energy, and the rest rings.
    """
    n, gap = elements, 0.05
    masses = [0.5 / n, *[1.0 / n] * (n - 1), 0.5 / n]
    laws = [({i: -1.0, i + 1: 1.0}, (float(n),), 0.0) for i in range(n)]
    system = partial(springs, masses, laws, [{0: 1.0}], [gap])
    start = (0.0,) * (n + 1), (-0.1,) * (n + 1)
    return BenchProblem("bar", "certified", system, Restitution(0.0), start, 3.5, steps=100)


def soft_impact(yield_force: float | None = None) -> BenchProblem:
    """Figure 3.1 of the thesis: a vehicle of stiffness R1 meets a mass on a spring R2."""
    masses, r1, r2 = (1500.0, 2000.0), 3e5, 2e6
    start = (0.0, 0.0), (10.0, 0.0)
    resist = (r2,) if yield_force is None else (r2, 0.0, yield_force)
    laws = [({0: -1.0, 1: 1.0}, Penalty(r1), 0.0), ({1: 1.0}, resist, 0.0)]

    def exact(times: Array) -> Array:
        root = np.sqrt(np.array(masses))
        K = np.array([[r1, -r1], [-r1, r1 + r2]])
        squares, modes = np.linalg.eigh(K / np.outer(root, root))
        w = np.sqrt(squares)
        speeds = modes.T @ (root * np.array(start[1]))

        def touching(t: Array, rate: bool = False) -> Array:
            shape = np.cos(np.outer(t, w)) if rate else np.sin(np.outer(t, w)) / w
            return np.asarray((shape * speeds) @ modes.T / root)

        def pressed(t: float) -> float:
            return float(np.diff(touching(np.array([t]))[0])[0])

        tries = np.linspace(1e-4, 1.0, 2000)
        first = next(t for t in tries if pressed(float(t)) > 0.0)
        apart = float(brentq(pressed, first - tries[1] + tries[0], first, xtol=1e-15))
        q, v = (touching(np.array([apart]), rate)[0] for rate in (False, True))
        tau, alone = times - apart, sqrt(r2 / masses[1])
        free = q[1] * np.cos(alone * tau) + v[1] / alone * np.sin(alone * tau)
        left = np.column_stack([q[0] + v[0] * tau, free])
        return np.where((times <= apart)[:, None], touching(times), left)

    elastic = yield_force is None
    return BenchProblem(
        "soft impact" if elastic else "soft impact, plastic",
        "two modes until the vehicle leaves" if elastic else "certified",
        *(partial(springs, masses, laws), Restitution(0.0), start, 0.3, exact if elastic else None),
        steps=100,
        conservative=elastic,
    )


def duffing() -> BenchProblem:
    """A hardening oscillator, q'' + q + q^3 = 0, with a stop at -0.5."""
    system = partial(springs, [1.0], [({0: 1.0}, (1.0, 1.0), 0.0)], [{0: 1.0}], [0.5])
    start = (1.0,), (0.0,)
    return BenchProblem("Duffing", "certified", system, Restitution(0.8), start, 10.0, steps=80)


PROBLEMS: dict[str, Callable[[], BenchProblem]] = {
    "ball": lambda: ball(0.5),
    "ball-lively": lambda: ball(0.9),
    "ball-elastic": lambda: ball(1.0, 0.05),
    "table": table,
    "two-masses": two_masses,
    "cradle": cradle,
    "oscillator": oscillator,
    "grazing": lambda: oscillator(1.0),
    "bar": bar,
    "soft-impact": soft_impact,
    "soft-impact-plastic": lambda: soft_impact(3e5),
    "duffing": duffing,
}


@cache
def problem(name: str) -> BenchProblem:
    """The problem of this name. Raises `InputError`."""
    if name not in PROBLEMS:
        advice = did_you_mean(name, PROBLEMS)
        raise InputError("problem", name, "must be one of " + ", ".join(PROBLEMS), advice)
    return PROBLEMS[name]()
