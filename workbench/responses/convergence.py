"""Convergence of a sequence: observed order, extrapolate, grid convergence index.

Four levels or more are fitted by phi_0 + a h^p with least squares (Eca and Hoekstra 2014): scatter,
which a formula through three points would take for an order, becomes a standard deviation and
widens the uncertainty.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, log

import numpy as np
import scipy

from workbench.base.arrays import Array
from workbench.base.errors import InputError

RELIABLE = (0.5, 1.1)  # order over the expected one; the paper: 0.5 to 2.1 for order two
SEARCHED = (0.05, 8.0)  # orders among which a power law is sought
POINTS = 60  # of the search, before the best of them is refined
SAFE, CAUTIOUS = 1.25, 3.0  # safety factors
ACCEPTED = (0.7, 1.1)  # observed over expected order that still counts as asymptotic
CLIPPED = (0.8, 1.0)  # observed over expected order used for extrapolation
LEAST = 0.5  # share of the expected order that a cautious estimate still relies on


@dataclass(frozen=True, slots=True)
class ConvergenceFit:
    """A fitted law: its `limit` at size zero, its value at the `finest` size, its order.

    `deviation`, the standard deviation of the values from it; `order` None where the exponents
    were given.
    """

    limit: float
    finest: float
    deviation: float
    order: float | None


def best_law(
    values: Sequence[float], ratio: float, expected_order: float
) -> tuple[ConvergenceFit, float | None]:
    """The law that counts for the `values` of four levels or more, coarse to fine.

    Arguments: each level is `ratio` times finer than the one before; `expected_order` q of the
    method. All laws are fitted with equal weights and with weights that grow as 1/h, and the one
    that scatters least counts: a power law if its order lies within 0.5 to 1.1 of q; above that
    a h^q; below, or if there is none, the best of a h^q, a h^2q and a h^q + b h^2q. Result: its
    fit, and the order of the best power law (None: there is none).
    """
    phi = np.asarray(values, dtype=float)
    sizes = ratio ** np.arange(len(phi) - 1.0, -1.0, -1.0)
    weights = (np.full(len(phi), 1.0 / len(phi)), 1.0 / sizes / np.sum(1.0 / sizes))
    laws = [_power_law(phi, sizes, weight) for weight in weights]
    free = min((law for law in laws if law), key=lambda law: law.deviation, default=None)
    order = free.order if free is not None else None
    share = order / expected_order if order is not None else 0.0
    if free is not None and RELIABLE[0] <= share <= RELIABLE[1]:
        return free, order
    given = ((1.0,),) if share > RELIABLE[1] else ((1.0,), (2.0,), (1.0, 2.0))
    fits = [
        _fitted(phi, sizes, weight, expected_order * np.array(exponents))
        for weight in weights
        for exponents in given
    ]
    return min(fits, key=lambda fit: fit.deviation), order


def _power_law(phi: Array, sizes: Array, weights: Array) -> ConvergenceFit | None:
    """The best phi_0 + a h^p; None if no order within the searched range is best."""

    def deviation(exponent: float) -> float:
        return _fitted(phi, sizes, weights, np.array([exponent]), free=True).deviation

    tried = np.geomspace(*SEARCHED, POINTS)
    best = int(np.argmin([deviation(float(p)) for p in tried]))
    if best in (0, POINTS - 1):
        return None
    bounds, fine = (tried[best - 1], tried[best + 1]), {"xatol": 1e-10}
    best_fit = scipy.optimize.minimize_scalar(
        deviation, bounds=bounds, method="bounded", options=fine
    )
    return _fitted(phi, sizes, weights, np.array([float(best_fit.x)]), free=True)


def _fitted(
    phi: Array, sizes: Array, weights: Array, exponents: Array, free: bool = False
) -> ConvergenceFit:
    """phi_0 + sum a_k h^p_k by linear least squares; `free`: the exponent counts as fitted too."""
    root = np.sqrt(weights)
    terms = np.column_stack([np.ones_like(sizes), sizes[:, None] ** exponents])
    solution = np.linalg.lstsq(terms * root[:, None], phi * root, rcond=None)[0]
    fitted = terms @ solution
    unknowns = len(exponents) + 1 + int(free)
    variance = len(phi) * np.sum(weights * (phi - fitted) ** 2) / (len(phi) - unknowns)
    return ConvergenceFit(
        float(solution[0]),
        float(fitted[-1]),
        float(np.sqrt(variance)),
        float(exponents[0]) if free else None,
    )


@dataclass(frozen=True, slots=True)
class Ladder:
    """Ladder of refinements, and its statement on the value at the finest level.

    `finest`, the value there; `extrapolated`, the value at zero size; `uncertainty`, half-width of
    the interval around `finest` in its unit (absolute grid convergence index); `note`, one
    sentence for the reader; `order`, observed from three levels or fitted to more (None: it
    does not exist); `factor`, the safety factor used; `converging`, whether three levels differ
    less and less without changing sign, or more of them scatter less around a power law than they
    differ; `accepted`, whether the order is near the expected one.
    """

    finest: float
    extrapolated: float
    uncertainty: float
    note: str
    order: float | None = None
    factor: float = CAUTIOUS
    converging: bool = False
    accepted: bool = False

    @property
    def relative(self) -> float | None:
        """The uncertainty over the magnitude of the value; None if that is zero."""
        return self.uncertainty / abs(self.finest) if self.finest != 0.0 else None


def ladder(values: Sequence[float], ratio: float = 2.0, expected_order: float = 1.0) -> Ladder:
    """Observed order, extrapolation and grid convergence index (Celik et al. 2008).

    Arguments: `values` from coarse to fine, each level `ratio` times finer than the one before;
    `expected_order` of the method. Four levels or more are fitted by least squares (Eca and
    Hoekstra 2014, see `best_law`): factor 1.25 for a reliable power law, else 3. With three,
    within 0.7 to 1.1 of the expected order the safety factor is 1.25 and the order, clipped to
    0.8 to 1, extrapolates; outside, or with two levels, the factor is 3 (Roache 1994), with an
    order of half the expected one to that (Oberkampf and Roy 2010, section 8.6): differences that
    shrink faster than the method allows are not asymptotic yet. Three levels that oscillate or
    diverge get three times their spread.
    Raises `InputError` for fewer than two finite values or a ratio not above 1.
    """
    levels = [float(value) for value in values]
    if len(levels) < 2 or not all(isfinite(value) for value in levels):
        raise InputError("ladder", tuple(levels), "must hold two finite values or more")
    if not (ratio > 1.0 and expected_order > 0.0):
        raise InputError("ladder", (ratio, expected_order), "ratio above 1, order above 0")
    fine, spread = levels[-1], max(levels) - min(levels)
    if len(levels) == 2:
        correction = (fine - levels[0]) / (ratio**expected_order - 1.0)
        note = "two levels only: the expected order is assumed, safety factor 3"
        width = CAUTIOUS * abs(correction)
        return Ladder(fine, fine + correction, width, note, converging=True)
    if spread <= 1e-14 * max(abs(value) for value in levels):
        note = "the levels agree to rounding"
        return Ladder(fine, fine, 0.0, note, None, SAFE, converging=True, accepted=True)
    if len(levels) > 3:
        return _of_law(levels, ratio, expected_order)
    first, second = levels[0] - levels[1], levels[1] - fine
    if first * second < 0.0 or abs(second) >= abs(first):
        what = "oscillate" if first * second < 0.0 else "do not converge"
        return Ladder(fine, fine, CAUTIOUS * spread, f"the levels {what}: three times their spread")
    order = log(abs(first / second)) / log(ratio) if second != 0.0 else inf
    share = order / expected_order
    accepted = ACCEPTED[0] <= share <= ACCEPTED[1]
    used = min(max(share, CLIPPED[0] if accepted else LEAST), CLIPPED[1]) * expected_order
    correction = -second / (ratio**used - 1.0)
    if accepted:
        note = f"observed order {order:.2f}, expected {expected_order:g}"
        width = SAFE * abs(correction)
        return Ladder(fine, fine + correction, width, note, order, SAFE, True, True)
    if isfinite(order):
        note = (
            f"observed order {order:.2f} is outside {ACCEPTED[0]:g} to {ACCEPTED[1]:g} of the "
            f"expected {expected_order:g}: safety factor 3"
        )
    else:
        note = "the two finest levels agree exactly, the coarser one does not: safety factor 3"
    # two levels may agree by chance: at least what the coarser pair and the expected order say
    gain = ratio**expected_order
    width = max(CAUTIOUS * abs(correction), abs(first) / gain / (gain - 1.0))
    shown = order if isfinite(order) else None
    return Ladder(fine, fine + correction, width, note, shown, converging=True)


def _of_law(levels: list[float], ratio: float, expected_order: float) -> Ladder:
    """The interval from a fit: scatter and what it misses at the finest level are added."""
    fit, order = best_law(levels, ratio, expected_order)
    scatter = fit.deviation * (len(levels) - 1) / (max(levels) - min(levels))
    reliable = fit.order is not None and scatter < 1.0
    factor = SAFE if reliable else CAUTIOUS
    error, rest = abs(fit.finest - fit.limit), fit.deviation + abs(levels[-1] - fit.finest)
    width = factor * error + rest if scatter < 1.0 else CAUTIOUS * scatter * (error + rest)
    if order is None:
        law = "they follow no power law, safety factor 3"
    elif reliable:
        law = f"order {order:.2f}, expected {expected_order:g}"
    elif scatter < 1.0:
        law = (
            f"order {order:.2f} is outside {RELIABLE[0]:g} to {RELIABLE[1]:g} of "
            f"the expected {expected_order:g}, safety factor 3"
        )
    else:
        law = "they scatter more than they differ, safety factor 3 and more"
    return Ladder(
        *(levels[-1], fit.limit, width, f"fit to {len(levels)} levels: {law}", order, factor),
        converging=order is not None and scatter < 1.0,
        accepted=reliable,
    )
