"""The standard variables of a response; ``variables.csv`` holds them all.

Names, dimensions, SI units, meanings, and what each belongs to: ``coordinate``, ``structure``, what
only strikers that crush have, ``crushing``, columns in space, ``oblique``, hits beside the shear
centre by a factor, ``eccentric``, or ``stud-tests`` and ``integrators``, the pure numbers by which
models of studs and schemes of time integration are judged. Dimension
``history`` is `time` in an impact and `step` in a pushover.

**Second part.** Numbers implied by histories: peak, residual, contact force, impulse, energy
ledger.

The ledger is closed in `balance_error`; a model that sums in an order of its own gives it itself.
"""

import hashlib
from collections.abc import Mapping
from math import isnan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import WorkbenchError
from workbench.base.tables import records
from workbench.responses.outcome import Finding, finding

HISTORY = "history"


class Variable(NamedTuple):
    """Dimensions, SI unit and plain name of a response variable."""

    dims: tuple[str, ...]
    units: str
    long_name: str

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of a stored variable."""
        return {"units": self.units, "long_name": self.long_name}


_TABLE = Path(__file__).with_name("variables.csv").read_text(encoding="utf-8")
# answers of other tables are old; no other answer lacks what only some strikers have
_SOME = "crushing,", "oblique,", "eccentric,"
_OF_ALL = "".join(row for row in _TABLE.splitlines(True) if not row.startswith(_SOME))
TABLE_DIGEST = hashlib.sha256(_OF_ALL.encode()).hexdigest()[:16]


def _read(*of: str) -> dict[str, Variable]:
    return {
        row["name"]: Variable(tuple(row["dimensions"].split()), row["units"], row["meaning"])
        for row in records(_TABLE)
        if row["of"] in of
    }


COORDINATES = _read("coordinate")
VARIABLES = _read("structure", "crushing", "oblique", "eccentric", "stud-tests", "integrators")
STUD_TESTS, INTEGRATORS = tuple(_read("stud-tests")), tuple(_read("integrators"))
SCALARS = tuple(name for name, variable in VARIABLES.items() if not variable.dims)
ENERGIES = tuple(n for n, v in VARIABLES.items() if v.units == "J" and v.dims == (HISTORY,))

# Attributes that differ from run to run; all others repeat exactly.
TIMES = ("wall_time", "solve_time")  # s: the whole answer, and solving the equations alone
VOLATILE = ("provenance", *TIMES)


SETTLED = 1.5  # periods that a residual displacement takes
NO_PEAK = "no-peak"  # subject of the finding that the record ends before the peak
_ROUNDED = 1e-4  # of the energy stored before an impact
# extremes over all parts of a structure: of which variable, and with which signs it counts
EXTREMES = {
    "largest_drift": ("drift", (1, -1)),
    "largest_plastic_rotation": ("plastic_rotation", (1, -1)),
    "largest_sliding": ("sliding", (1, -1)),
    "largest_compression": ("axial_force", (-1,)),
    "largest_tension": ("axial_force", (1,)),
}
GONE = 0.01  # of the largest load of a pulse: what is left of it then leaves nothing more
FORCE_WINDOW = 1e-3  # s; contact forces of nonsmooth models are means over this window


def implied(
    values: Mapping[str, Array | None], time: Array | None
) -> tuple[dict[str, Any], list[Finding]]:
    """Numbers implied by histories among the `values` of a response, and findings on them.

    A displacement over `time` (s; None: load steps) implies its peak; with the percussion of a
    striker also the residual displacement, impulse and contact force, with the load of a pulse the
    residual displacement, both where the push is over (see `unloaded`); energies imply how far
    their balance is open. What takes time to find is left out where the values give it.
    """
    given: dict[str, Array] = {}
    for name, array in values.items():
        if array is not None:
            given[name] = array
    blow = "percussion" in given
    hit = blow or "load" in given
    derived: dict[str, Any] = {}
    findings = []
    if time is not None and "displacement" in given:
        displacement = given["displacement"]
        peak = peak_of(time, displacement)
        derived |= peak
        if hit and peak and "residual_displacement" not in values:
            derived["residual_displacement"] = residual_of(time, displacement, unloaded(given))
        elif hit and not peak:
            findings.append(finding("still-growing", time=time[-1]))
    if time is not None and blow:
        derived["impulse"] = given["percussion"].sum()
        if "peak_force" not in values:
            derived["peak_force"] = peak_contact_force(time[1:], given["percussion"][1:])
    if "elastic" in given:
        derived["balance_error"] = balance_error(given, static=time is None)
    return {**derived, **extremes(given)}, findings


def extremes(values: Mapping[str, Array]) -> dict[str, float]:
    """Largest drift, plastic rotation (rad), sliding (m), compression, tension (N) of all parts."""
    largest = {}
    for name, (of, signs) in EXTREMES.items():
        if of in values:
            ends = {1: values[of].max(initial=0.0), -1: -values[of].min(initial=0.0)}
            largest[name] = max(0.0, *(float(ends[sign]) for sign in signs))
    return largest


def balance_error(values: Mapping[str, Array], *, static: bool) -> Array | None:
    """Energy brought in less what is stored, dissipated and lost, in J (steps,).

    A striker brings the input energy; loads and the ground bring the external work alone. None
    if the `values` do not hold the energies that it takes.
    """
    blow = "percussion" in values
    needed = {"elastic", "dissipated", "external_work" if static else "kinetic"}
    if not needed <= set(values) or (blow and "input_energy" not in values):
        return None
    gained = values["elastic"] - values["elastic"][0]
    if static:
        return np.asarray(values["external_work"] - gained - values["dissipated"])
    lost = values.get("contact_loss", 0.0)
    brought = (values["input_energy"] if blow else 0.0) + values.get("external_work", 0.0)
    return np.asarray(unbalanced(brought, values["kinetic"], gained, values["dissipated"], lost))


def unbalanced(brought: Any, kinetic: Any, gained: Any, dissipated: Any, lost: Any) -> Any:
    """Energy that was brought in less what moves, is stored, dissipated or lost in contact, in J.

    Compiled code takes it, too.
    """
    return brought - (kinetic + gained + dissipated + lost)


def open_share(balance: Array, given: float, stored: float) -> float:
    """Largest error (J) of an energy `balance` over what was `given` (J).

    Or over a ten-thousandth of what dead loads have `stored` (J) before, if that is more: a touch
    of some mm/s is lost in its round-off.
    """
    return float(np.abs(balance).max()) / max(given, _ROUNDED * stored)


def largest_of(history: Array) -> float:
    """The value of largest magnitude of a history, with its sign."""
    return float(history[np.argmax(np.abs(history))])


def peak_of(time: Array, displacement: Array) -> dict[str, float]:
    """Peak and its time from a history by the parabola through its three highest points.

    The peak is the value of largest magnitude, with its sign. The time is that of the first peak
    within 0.5 % of it, either way, which rounding and the length of the record choose among the
    cycles of an undamped vibration. Empty where the last value is the largest: it still grows.
    Raises `WorkbenchError` where times do not increase around it.
    """
    from workbench.responses.kernels import signed_peak  # readers of responses need no compiler

    largest, at, grows = signed_peak(time, displacement)
    if grows:
        return {}
    if isnan(at):
        raise WorkbenchError("response time does not increase")
    return {"peak_displacement": float(largest), "time_of_peak": float(at)}


def unloaded(values: Mapping[str, Array]) -> int | None:
    """Row from which on nothing pushes; None: the record ends under load, or the load stays.

    A striker must not push in the last step, a pulse be down to `GONE` of its largest load.
    """
    if "percussion" in values:
        return None if values["percussion"][-1] > 0.0 else 0
    load = np.abs(values["load"])
    row = int(np.flatnonzero(load >= GONE * load.max())[-1]) + 1
    return row if row < len(load) else None


def residual_of(time: Array, displacement: Array, begin: int | None = 0) -> float | None:
    """Permanent displacement: mean over the whole cycles of free vibration after the peak.

    A cycle runs between two crossings, towards the peak, of the mid-level of the record after its
    first turn behind the peak, and behind the row `begin` (None: load stays). None if the record
    holds no whole cycle: run longer.
    """
    if begin is None:
        return None
    from workbench.responses.kernels import mean_of_cycles  # readers of responses need no compiler

    time, displacement = np.ascontiguousarray(time), np.ascontiguousarray(displacement)
    mean = mean_of_cycles(time, displacement, begin)
    return None if isnan(mean) else float(mean)


def residual_over(
    time: Array, displacement: Array, start: float, period: float
) -> tuple[float | None, list[Finding]]:
    """Permanent displacement (m) where vibrations of several periods (s) are on, the longest one.

    Mean over the last whole number of those that fit behind the `start` (s), when all has happened
    that leaves something; None, with a finding, if the record ends before `SETTLED` of them: the
    mean of a part of one is no permanent displacement.
    """
    after, needed = float(time[-1]) - start, start + SETTLED * period
    if after < SETTLED * period:
        return None, [
            finding(
                "no-residual", period, after=1e3 * after, period=1e3 * period, needed=1.1 * needed
            )
        ]
    whole = period * int(after / period)
    steps = 0.5 * (displacement[1:] + displacement[:-1]) * np.diff(time)
    area = np.concatenate([[0.0], np.cumsum(steps)])
    return float(area[-1] - np.interp(time[-1] - whole, time, area)) / whole, []


def peak_contact_force(time: Array, percussion: Array) -> float:
    """Largest contact force in N: percussions summed over a sliding window of 1 ms.

    Arguments: `time` at the end of each step, and the `percussion` of that step in N s.
    """
    from workbench.responses.kernels import largest_window

    return float(largest_window(time, percussion, FORCE_WINDOW) / FORCE_WINDOW)
