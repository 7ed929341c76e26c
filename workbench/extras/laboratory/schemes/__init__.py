"""Time integrators of impact, a family a file, and what each of them declares."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import inf, sqrt

from workbench.base.errors import InputError
from workbench.base.fields import did_you_mean
from workbench.extras.laboratory.schemes.event_driven import event_driven
from workbench.extras.laboratory.schemes.newmark import (
    energy_penalty,
    generalized_alpha,
    hht_alpha,
    newmark,
    newmark_rates,
)
from workbench.extras.laboratory.schemes.time_stepping import (
    central_differences,
    energy_midpoint,
    gear_gupta_leimkuhler,
    moreau_jean,
    moreau_midpoint,
)
from workbench.extras.laboratory.systems import Stepper

MOMENTUM, ENERGY, LINEAR_ENERGY = "momentum", "energy", "energy of linear systems"
LAW, ELASTIC, NONE = "law", "elastic", "none"


@dataclass(frozen=True)
class Scheme:
    """An integrator and its declarations, each of which a test measures.

    Arguments: `stepper` makes its step; `order` of smooth motion; `impact_order` through impacts
    (0: the answer does not converge); what it `conserves` without dissipation in contact;
    `penetration` (a, b), so that gaps stay above -(a h V + b h^2 A), V and A the largest approach
    and relative acceleration; `stable`, largest omega h of linear vibrations; what comes back after
    an impact: the `restitution` of the law, all (elastic), or what the grid draws (none).
    """

    title: str
    make: Callable[[], Stepper]
    order: int
    impact_order: int
    conserves: tuple[str, ...]
    penetration: tuple[float, float]
    stable: float = inf
    restitution: str = LAW

    @cached_property
    def stepper(self) -> Stepper:
        """The step of the scheme with its usual parameters."""
        return self.make()


_BOTH = (MOMENTUM, LINEAR_ENERGY)
SCHEMES: dict[str, Scheme] = {
    "moreau-jean": Scheme("Moreau-Jean, theta 1/2", moreau_jean, 2, 1, _BOTH, (0.5, 2.0)),
    "moreau-midpoint": Scheme(
        "Moreau's explicit midpoint", moreau_midpoint, 2, 1, (MOMENTUM,), (1.0, 2.0), 2.0
    ),
    "midpoint": Scheme(
        "energy-conserving midpoint", energy_midpoint, 2, 1, (MOMENTUM, ENERGY), (1.0, 2.0)
    ),
    "midpoint-fixed-point": Scheme(
        "energy-conserving midpoint, impulses by fixed point",
        lambda: energy_midpoint(turns=10_000),
        *(2, 1, (MOMENTUM, ENERGY), (1.0, 2.0)),
    ),
    "ggl": Scheme("Gear-Gupta-Leimkuhler", gear_gupta_leimkuhler, 2, 1, _BOTH, (0.0, 0.0)),
    "ggl-studer": Scheme(
        "Gear-Gupta-Leimkuhler, Studer's first",
        lambda: gear_gupta_leimkuhler(0.5, late=False),
        *(2, 1, _BOTH, (0.5, 2.0)),
    ),
    "ggl-split": Scheme(
        "Gear-Gupta-Leimkuhler, split",
        lambda: gear_gupta_leimkuhler(0.5, split=True),
        *(2, 1, _BOTH, (0.0, 0.0)),
    ),
    "event-driven": Scheme(
        "event-driven Runge-Kutta", event_driven, 4, 4, (MOMENTUM,), (0.0, 0.0), sqrt(8.0)
    ),
    "newmark": Scheme(
        "Newmark, contact at the end",
        *(newmark, 2, 0, _BOTH, (0.0, 0.0)),
        restitution=NONE,
    ),
    "newmark-rates": Scheme(
        "Newmark, contact velocity at the end",
        *(newmark_rates, 2, 1, _BOTH, (0.5, 2.0)),
        restitution=ELASTIC,
    ),
    "newmark-penalty": Scheme(
        "Newmark, penalty that keeps energy",
        *(energy_penalty, 2, 1, _BOTH, (0.5, 2.0)),
        restitution=ELASTIC,
    ),
    "hht-alpha": Scheme(
        "HHT-alpha, contact at the end",
        *(hht_alpha, 2, 0, (MOMENTUM,), (0.0, 0.0)),
        restitution=NONE,
    ),
    "generalized-alpha": Scheme(
        "generalized-alpha, contact at the end",
        *(generalized_alpha, 2, 0, (MOMENTUM,), (0.0, 0.0)),
        restitution=NONE,
    ),
    "generalized-alpha-impulses": Scheme(
        "generalized-alpha, velocities updated at impact",
        lambda: generalized_alpha(impulses=True),
        *(2, 1, (MOMENTUM,), (0.5, 2.0)),
    ),
    "central-differences": Scheme(
        "explicit central differences", central_differences, 2, 1, (MOMENTUM,), (0.0, 2.0), 2.0
    ),
}
CLASSICAL = tuple(name for name, scheme in SCHEMES.items() if not scheme.impact_order)


def scheme(name: str) -> Scheme:
    """The integrator of this name. Raises `InputError`."""
    if name not in SCHEMES:
        advice = did_you_mean(name, SCHEMES)
        raise InputError("integrator", name, "must be one of " + ", ".join(SCHEMES), advice)
    return SCHEMES[name]
