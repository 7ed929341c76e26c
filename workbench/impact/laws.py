"""Contact laws: Newton's and Poisson's restitution, penalty springs.

Rigid contacts answer with impulses. With G = W' M^-1 W, gap velocities gamma- before and
gamma = gamma_free + G P after:

* Newton: 0 <= P perp gamma + e gamma- >= 0, contact by contact (Heng 2017, eq. 3.21).
* Poisson: P = P_c + P_e. Compression ends at 0 <= P_c perp gamma_c >= 0; expansion gives back
  P_e = e P_c, and more only where bodies would overlap otherwise (Glocker and Pfeiffer 1995).

For one contact, and for equal coefficients where all contacts are compressed, Newton and Poisson
agree; where they differ both are right by their own definitions. Penalty springs answer with a
force along a penetration: linear, Hertz (exponent 3/2), Hunt and Crossley (1975) with damping.
"""

from dataclasses import dataclass
from math import exp

import numpy as np
from scipy.optimize import brentq

from workbench.arrays import Array
from workbench.compiled import njit
from workbench.fields import Choice, Declared, Many, Number, checked
from workbench.impact.complementarity import complementary
from workbench.impact.contact import rebound

NEWTON, POISSON = "newton", "poisson"


@dataclass(frozen=True)
class Restitution(Declared, table="restitution"):
    """What comes back after an impact.

    Arguments: `coefficients` of the contacts, 0 (plastic) to 1 (elastic), one for each or one for
    all; `law`, newton or poisson.
    """

    coefficients: tuple[float, ...] | float = checked(Many(Number(0.0, 1.0), 1), (0.0,))
    law: str = checked(Choice((NEWTON, POISSON)), NEWTON)

    def __post_init__(self) -> None:
        if isinstance(self.coefficients, int | float):
            object.__setattr__(self, "coefficients", (self.coefficients,))
        super().__post_init__()

    def each(self, contacts: int) -> Array:
        """Coefficients of that many contacts. Raises `InputError` if they are not as many."""
        given = np.atleast_1d(self.coefficients)
        if given.size not in (1, contacts):
            raise self.refusal("coefficients", f"must be one number or {contacts}, one per contact")
        return np.full(contacts, given)


@njit(cache=True, error_model="numpy")
def percussions(G, free, start, e, poisson):
    """Impulses of simultaneous impacts, and their residual.

    Arguments: `G` (n, n) in 1/kg; `free` and `start`, gap velocities (n,) in m/s without impulses
    and before the impact; `e` (n,), coefficients; whether the law is Poisson's.

    """
    if not poisson:
        xi = np.empty(free.size)
        for i in range(free.size):
            xi[i] = free[i] + rebound(start[i], e[i]) * start[i]
        return complementary(G, xi)
    pressed, first = complementary(G, free)
    back = (1.0 + e) * pressed
    extra, second = complementary(G, free + G @ back)
    return back + extra, max(first, second)


@dataclass(frozen=True)
class Penalty(Declared, table="penalty"):
    """A spring that bodies meet, f = k d^n (1 + c d') at penetration d > 0, and never pulls.

    Arguments: `stiffness` k in N/m^n; `exponent` n, 1 linear, 3/2 Hertz; `damping` c in s/m of Hunt
    and Crossley.
    """

    stiffness: float = checked(Number(0.0, 1e18, "N/m^n", low_included=False))
    exponent: float = checked(Number(1.0, 3.0), 1.0)
    damping: float = checked(Number(0.0, 1e6, "s/m"), 0.0)

    def force(self, gap: float, velocity: float = 0.0) -> float:
        """Contact force (N) at a gap (m; negative where bodies overlap) and its velocity (m/s)."""
        pressed = self.stiffness * max(-gap, 0.0) ** self.exponent
        return float(max(pressed * (1.0 - self.damping * velocity), 0.0))

    def depth(self, mass: float, speed: float) -> float:
        """Largest penetration (m) without damping of a `mass` (kg) that arrives at `speed`."""
        n = self.exponent + 1.0
        return float((0.5 * n * mass * speed**2 / self.stiffness) ** (1.0 / n))

    def rebound(self, speed: float) -> float:
        """Restitution that the damping amounts to at an arrival `speed` (m/s).

        m u u' = -k d^n (1 + c u) integrates to c v (1 + e) = ln((1 + c v) / (1 - c e v)).
        """
        x = self.damping * speed
        if x < 1e-9:
            return 1.0
        top = min(1.0, 1.0 / x)

        def left(e: float) -> float:
            return (1.0 - e * x) - (1.0 + x) * exp(-x * (1.0 + e))

        return float(brentq(left, 0.0, top, xtol=1e-15)) if left(top) < 0.0 else top
