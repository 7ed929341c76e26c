"""What the mechanical model predicts to be left of a stud after a pull-out, with its band.

The band runs over the parameters that no test at hand tells, all of them at once: what a cone takes
from the bearing strength, where it ends, the friction of the flange, the strain at rupture. Ratios
are those of the mechanism itself, without the limits of `Stud.largest_shear`: under a limit a loss
would not show.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from itertools import product

import numpy as np

from workbench.errors import InputError, SolverError
from workbench.fields import Choice
from workbench.studs.mechanical.driving import (
    PullCurve,
    ShearCurve,
    pull_out,
    pull_then_push,
    push_out,
)
from workbench.studs.mechanical.parameters import Stud, Surroundings
from workbench.studs.quantities import Array
from workbench.studs.relations import MechanicalCurve
from workbench.studs.schema import QUANTITIES

LEVELS = (0.0, 0.1, 0.25, 0.5, 0.75, 1.0)
MEASURES = ("displacement ratio", "load ratio")  # of damage
LOST = 0.2  # of the peak: a pull-out that has fallen to it has failed
STEPS = 120
TRIED = (40, STEPS, 2 * STEPS)  # steps at the corners of the band: 40 are within 0.01 of 120
# ends of the unknown parameters, whose corners span the band
UNKNOWN = {
    "cone_loss": (0.0, 1.0),
    "cone_end": (0.03, 0.12),
    "friction": (0.0, 0.6),
    "rupture_strain": (0.06, 0.20),
}


def uplift_at(pulled: PullCurve, level: float, measure: str) -> float:
    """Uplift (m) of a level of damage, 0 to 1, of a pull-out.

    ``displacement ratio``: share of the uplift where the load has fallen to 20 % of its peak, or
    the shank tears; ``load ratio``: share of the peak before it. Raises `InputError` for others.
    """
    if not 0.0 <= level <= 1.0:
        raise InputError("level", level, "damage lies from 0 to 1")
    Choice(MEASURES).check("measure", measure)
    peak = int(np.argmax(pulled.load))
    if measure == "load ratio":
        rising = np.maximum.accumulate(pulled.load[: peak + 1])
        return float(np.interp(level * pulled.strength, rising, pulled.uplift[: peak + 1]))
    fallen = np.flatnonzero(pulled.load[peak:] <= LOST * pulled.strength)
    if len(fallen) == 0:
        return level * float(pulled.uplift[-1])
    i = peak + int(fallen[0])
    ends = slice(i, i - 2, -1)  # falling load: rising order for the interpolation
    return level * float(np.interp(LOST * pulled.strength, pulled.load[ends], pulled.uplift[ends]))


@lru_cache(maxsize=128)  # strength and stiffness, and all frictions, come from the same runs
def _runs(
    stud: Stud, around: Surroundings, levels: tuple[float, ...], measure: str, steps: int
) -> tuple[ShearCurve, tuple[ShearCurve | None, ...]]:
    """The push-out of the undamaged stud and those after each level (None: torn)."""
    whole, pulled = push_out(stud, around, steps=steps), pull_out(stud, around, steps=steps)
    after = [
        pull_then_push(stud, around, uplift_at(pulled, float(level), measure), steps=steps)[1]
        if level > 0.0
        else whole
        for level in levels
    ]
    return whole, tuple(after)


def residual_ratios(
    stud: Stud, around: Surroundings, levels: tuple[float, ...], measure: str, steps: int = STEPS
) -> tuple[Array, Array]:
    """Strength and stiffness (10 to 40 %) over those of the undamaged stud (levels,) each.

    Strength counts up to the slip at which the undamaged stud tears. A stud torn in the pull-out
    has nothing left.
    """
    whole, after = _runs(stud, replace(around, friction=1.0), levels, measure, steps)
    whole = whole.rubbing(around.friction)
    curves = [None if each is None else each.rubbing(around.friction) for each in after]
    end, strength, chord = float(whole.slip[-1]), whole.strength, whole.chord()
    left = [
        (0.0, 0.0) if c is None else (c.strength_within(end) / strength, c.chord() / chord)
        for c in curves
    ]
    return np.array(left).T[0], np.array(left).T[1]


def _at_corner(
    stud: Stud, around: Surroundings, levels: tuple[float, ...], measure: str
) -> tuple[Array, Array]:
    """Ratios as in `residual_ratios`, with as few steps as find an equilibrium."""
    for steps in TRIED[:-1]:
        try:
            return residual_ratios(stud, around, levels, measure, steps)
        except SolverError:
            continue
    return residual_ratios(stud, around, levels, measure, TRIED[-1])


def residual_curve(
    stud: Stud,
    around: Surroundings,
    quantity: str = "strength",
    *,
    measure: str = "displacement ratio",
    levels: tuple[float, ...] = LEVELS,
    spread: Mapping[str, tuple[float, ...]] = UNKNOWN,
    basis: str = "mechanical model, not calibrated",
) -> MechanicalCurve:
    """Predict what is left after a pull-out to several levels, with a band.

    Arguments: `quantity` ``strength`` or ``stiffness``; `measure` of the level (see `uplift_at`);
    rising `levels` from 0; `spread`, ends of the unknown parameters; `basis`, what the parameters
    rest on (`MechanicalFit.basis`). Raises `InputError`, `SolverError`.
    """
    Choice(tuple(QUANTITIES)).check("quantity", quantity)
    which, at = list(QUANTITIES).index(quantity), np.array(levels, float)
    middle = residual_ratios(stud, around, levels, measure)[which]
    corners = (dict(zip(spread, ends, strict=True)) for ends in product(*spread.values()))
    every = [middle] + [
        _at_corner(stud, replace(around, **corner), levels, measure)[which] for corner in corners
    ]
    bounds, kind = (np.min(every, axis=0), np.max(every, axis=0)), ("pull-out", measure, quantity)
    return MechanicalCurve(at, middle, *bounds, *kind, basis, stud.title)


def interaction_points(
    stud: Stud, around: Surroundings, shares: tuple[float, ...] = (0.0, 0.25, 0.5, 0.75, 0.9)
) -> tuple[Array, Array]:
    """Tension over the pull-out strength, and the shear that is left over the shear strength.

    The tension is held while the stud is pushed out, up to the slip at which it tears without
    tension. Result: both ratios (n + 1,), the last point being the pull-out itself.
    """
    whole = push_out(stud, around, steps=STEPS)
    end, strength = float(whole.slip[-1]), pull_out(stud, around, steps=STEPS).strength
    held = (push_out(stud, around, tension=share * strength, steps=STEPS) for share in shares)
    shear = [each.strength_within(end) / whole.strength for each in held]
    return np.array([*shares, 1.0]), np.array([*shear, 0.0])
