"""Ductility charts and pressure-impulse curves of one elastic-perfectly plastic mass.

UFC 3-340-02 and Biggs 1964 print them; here they are computed. In units of the mass, its elastic
stiffness and the resistance R_m, with w = 2 pi / T:

    ductility mu = largest displacement over the elastic limit, of t_d / T and R_m / F.

Whatever the shape of the pulse, an impulse I that is short takes mu to ((I w / R_m)^2 + 1) / 2 (all
energy is there before it moves), a force that comes at once and stays to 1 / (2 (1 - F / R_m)) (its
work is that of the resistance); below the elastic limit to I w / R_m and 2 F / R_m.
"""

from collections.abc import Sequence
from math import exp, inf, log, pi, sqrt
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from workbench.base.arrays import Array
from workbench.base.errors import SolverError
from workbench.mechanics.impact.integrator import follow
from workbench.mechanics.impact.pace import Pace
from workbench.models.resistance.kernels import PIECE, sum_up
from workbench.models.single_dof import march
from workbench.models.single_dof.model import no_striker, under_pulse
from workbench.scenarios import Pulse

_PERIOD = 1e-3  # s; any would do
_STIFFNESS = (2.0 * pi / _PERIOD) ** 2  # of a mass of 1 kg, whose resistance is 1 N
_STEPS = 100.0  # of the period
_FAR = 1e9  # m, never reached


class Loading(NamedTuple):
    """A pulse that takes the mass to a ductility: `length` t_d / T, `force` F / R_m, `impulse`.

    The impulse of it all is I w / R_m.
    """

    length: float
    force: float
    impulse: float


def ductility(shape: str, length: float, strength: float) -> float:
    """Ductility under a pulse of this shape; `length` t_d / T, `strength` R_m / F.

    Infinite for a force that stays and is not below the strength.
    """
    if shape == "ramp" and strength <= 1.0:
        return inf
    pulse = Pulse(shape, 1.0 / strength, length * _PERIOD)
    rest = 10.0 * _PERIOD if shape == "ramp" and strength < 2.0 else _PERIOD
    duration = pulse.end + pulse.whole + rest  # the momentum lasts I / 1 N
    count = int(np.ceil(duration / _PERIOD * _STEPS))
    time = np.linspace(0.0, duration, count + 1)
    pieces = np.zeros(2, PIECE)
    limit = 1.0 / _STIFFNESS
    pieces["start"][1], pieces["c"][0, 1], pieces["c"][1, 0] = limit, _STIFFNESS, 1.0
    sum_up(pieces)
    tables = pieces, np.array([[0.0, 1.0, 1.0]]), pulse.means(time), 0.0
    pace, drive = Pace.equal(duration, time[1], count), no_striker(limit, _FAR, 1.0)
    moved = follow(under_pulse, tables, pace, drive, march.RECORD).records
    top = float(moved["displacement"][:-1].max())
    if moved["displacement"][-1] > top * (1.0 + 2e-3):  # not only back where it has been
        raise SolverError("the peak", inf, "a record as long as the momentum lasts")
    return top * _STIFFNESS


def ductility_chart(shape: str, lengths: Sequence[float], strengths: Sequence[float]) -> Array:
    """Ductility, [lengths, strengths], of pulses of one shape."""
    return np.array([[ductility(shape, t, r) for r in strengths] for t in lengths])


def pressure_impulse(shape: str, wanted: float, lengths: Sequence[float]) -> list[Loading]:
    """Pulses of one shape and these lengths that take the mass to a `wanted` ductility."""
    loadings = []
    for length in lengths:
        whole = Pulse(shape, 1.0, length * _PERIOD).whole
        least = log(0.3 * step_force(wanted))  # no pulse needs less than half of a step

        def excess(force: float, length: float = length) -> float:
            return log(ductility(shape, length, exp(-force)) / wanted)

        most = least + 1.0
        while excess(most) < 0.0:
            most += 1.0
        force = exp(brentq(excess, least, most, xtol=1e-4))
        loadings.append(Loading(length, force, force * whole * 2.0 * pi / _PERIOD))
    return loadings


def impulse_asymptote(wanted: float) -> float:
    """Impulse I w / R_m of the shortest pulse that takes the mass to a ductility."""
    return sqrt(2.0 * wanted - 1.0) if wanted > 1.0 else wanted


def step_force(wanted: float) -> float:
    """Force F / R_m of the step that takes the mass to a ductility."""
    return 1.0 - 0.5 / wanted if wanted > 1.0 else 0.5 * wanted


def step_ductility(force: float) -> float:
    """Ductility under a step of F / R_m, infinite from 1 on."""
    if force >= 1.0:
        return inf
    return 0.5 / (1.0 - force) if force > 0.5 else 2.0 * force
