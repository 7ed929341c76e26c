"""EN 1990 Annex D: fractile factors, characteristic and design resistance from tests.

A normal quantity with mean m and standard deviation s estimated from n values (V unknown) lies
below m - k s in a new test with the wanted probability for k = t_(n-1)(p) sqrt(1 + 1/n). This
reproduces tables D.1 and D.2.
Source: EN 1990:2002, D.8.2 to D.8.4 (recalled, not read again).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import exp, inf, log, prod, sqrt

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.errors import InputError

CHARACTERISTIC = 0.95  # share of tests above the characteristic value
TABLE_DESIGN = 0.999  # the probability that table D.2 follows
LIMIT_DESIGN = 0.99882  # Phi(3.04), 3.04 = 0.8 x 3.8: the limit that the standard quotes


def fractile_factor(count: float, share: float = CHARACTERISTIC) -> float:
    """Factor k for which a `share` of new tests lies above mean - k times standard deviation.

    The default `share` is that of k_n (table D.1). k_d,n (table D.2) follows `TABLE_DESIGN`,
    although its limit for many tests is quoted as 3.04, the normal quantile of `LIMIT_DESIGN`.
    Arguments: `count` of tests (infinity allowed); `share` in 0.5..1. Raises `InputError` for fewer
    than two tests.
    """
    from scipy.special import ndtri, stdtrit

    if not 0.5 < share < 1.0:
        raise InputError("share", share, "must lie between 0.5 and 1")
    if not count >= 2:
        raise InputError("count", count, "must be 2 or more tests", "one test has no scatter")
    quantile = ndtri(share) if count == inf else stdtrit(count - 1.0, share)
    return float(quantile) * sqrt(1.0 + 1.0 / count)


K_INFINITE = 1.64  # the limits as the standard prints them
KD_INFINITE = 3.04
LEAST_FOR_DESIGN = 4  # tests, table D.2 for an unknown coefficient of variation
LEAST_DESIGN = 1e-12  # of the mean: below it nothing is left but round-off
MANY_TESTS = 100  # from here on the scatter counts as known


@dataclass(frozen=True, slots=True)
class D8:
    """Result of EN 1990 D.8 with all intermediate values.

    `count`; correction factor `b`; `s_delta`, standard deviation of the logarithms of the errors
    and `V_delta`, their coefficient of variation; `V_rt` of the resistance function from its basic
    variables, `V_r` in all; `Q`, `Q_rt`, `Q_delta` and weights `alpha_rt`, `alpha_delta`; factors
    `k_n`, `k_dn`; theoretical resistance at mean values `r_m` (N); `r_k`, `r_d` (N);
    `gamma_m`, r_k / r_d; nominal resistance `r_nominal` (N, or None) and `gamma_m_star`,
    r_nominal / r_d (or None). Below `LEAST_FOR_DESIGN` tests the standard has no factor of the
    design value: `k_dn`, `r_d` and both factors are None.
    """

    count: int
    b: float
    s_delta: float
    V_delta: float
    V_rt: float
    V_r: float
    Q: float
    Q_rt: float
    Q_delta: float
    alpha_rt: float
    alpha_delta: float
    k_n: float
    k_dn: float | None
    r_m: float
    r_k: float
    r_d: float | None
    gamma_m: float | None
    r_nominal: float | None
    gamma_m_star: float | None


def evaluate_d8(
    experimental: ArrayLike,
    theoretical: ArrayLike,
    *,
    variations: Mapping[str, float] | None = None,
    sensitivities: Mapping[str, float] | None = None,
    resistance: float | None = None,
    nominal: float | None = None,
) -> D8:
    """Characteristic and design resistance by EN 1990 D.8.

    Arguments: `experimental` and `theoretical` resistances (n,) in N of the tests, with measured
    values of the basic variables; `variations`, coefficients of variation of the basic variables
    in structures to come; `sensitivities`, exponents of the variables in the resistance function,
    (x / g) dg/dx at mean values (default 1: a product); `resistance`, g_rt at the mean values of
    the design in N (default: mean of `theoretical`); `nominal` design-function value in N, for
    gamma_M*. Raises `InputError` for fewer than two tests,
    resistances that are not positive, or a scatter that leaves no design value.
    """
    e, t = (np.atleast_1d(np.asarray(each, float)) for each in (experimental, theoretical))
    if e.shape != t.shape or e.ndim != 1:
        raise InputError("tests", (e.shape, t.shape), "must be pairs of resistances")
    if not (np.all(np.isfinite(e) & np.isfinite(t)) and np.all(e > 0.0) and np.all(t > 0.0)):
        raise InputError("tests", "resistances", "must be positive numbers")
    b = float(np.sum(e * t) / np.sum(t * t))
    delta = np.log(e / (b * t))
    n = len(delta)
    if n < 2:
        raise InputError("tests", n, "must be two or more", "one test has no scatter")
    s_delta = float(np.std(delta, ddof=1))
    v_delta = sqrt(exp(s_delta**2) - 1.0)
    v_rt = _variation(dict(variations or {}), dict(sensitivities or {}))
    v_r = sqrt((1.0 + v_delta**2) * (1.0 + v_rt**2) - 1.0)
    q, q_rt, q_delta = (sqrt(log(v**2 + 1.0)) for v in (v_r, v_rt, v_delta))
    alpha_rt, alpha_delta = (0.0, 0.0) if q == 0.0 else (q_rt / q, q_delta / q)
    many = n >= MANY_TESTS
    k_n = K_INFINITE if many else fractile_factor(n)
    k_dn = KD_INFINITE if many else fractile_factor(n, TABLE_DESIGN)
    r_m = float(np.mean(t)) if resistance is None else resistance

    def value(k_infinite: float, k_limited: float) -> float:
        weighted = k_infinite * alpha_rt * q_rt + k_limited * alpha_delta * q_delta
        return b * r_m * exp(-weighted - 0.5 * q * q)

    r_k, r_d = value(K_INFINITE, k_n), value(KD_INFINITE, k_dn)
    if not r_d > LEAST_DESIGN * r_m:
        scattered = f"{n} tests whose logarithms scatter by {s_delta:.3g}"
        raise InputError("table", scattered, "leave no design value by EN 1990 D.8")
    scatters = (s_delta, v_delta, v_rt, v_r, q, q_rt, q_delta, alpha_rt, alpha_delta)
    if n < LEAST_FOR_DESIGN:
        return D8(n, b, *scatters, k_n, None, r_m, r_k, None, None, nominal, None)
    star = None if nominal is None else nominal / r_d
    return D8(n, b, *scatters, k_n, k_dn, r_m, r_k, r_d, r_k / r_d, nominal, star)


MOST_FEW = 3  # tests of D.8.4
FEW_DEVIATION = 0.1  # of the mean, for extremes of two or three tests


def few_tests_factor(count: int, variation: float) -> float:
    """eta_k of EN 1990 D.8.4: characteristic value over the mean of one to three further tests.

    Arguments: `count` of tests; `variation`, largest coefficient of variation V_r that a
    significant number of earlier tests with the same resistance function has shown. Raises
    `InputError` for other counts.
    """
    if not 1 <= count <= MOST_FEW:
        raise InputError("tests", count, "must be one to three for EN 1990 D.8.4")
    if count == 1:
        return 0.9 * exp(-2.31 * variation - 0.5 * variation**2)
    return exp(-2.0 * variation - 0.5 * variation**2)


def _variation(variations: dict[str, float], sensitivities: dict[str, float]) -> float:
    unknown = set(sensitivities) - set(variations)
    if unknown:
        raise InputError("sensitivities", ", ".join(sorted(unknown)), "have no variation given")
    for name, v in variations.items():
        if not 0.0 <= v < 2.0:
            raise InputError(f"variations.{name}", v, "must be a share from 0 to below 2")
    if not sensitivities:
        return sqrt(prod(1.0 + v**2 for v in variations.values()) - 1.0)  # (D.16)
    return sqrt(sum((sensitivities.get(x, 1.0) * v) ** 2 for x, v in variations.items()))  # (D.18)


def sensitivities_of(
    resistance: Callable[[Mapping[str, float]], float], means: Mapping[str, float]
) -> dict[str, float]:
    """Exponents (x / g) dg/dx of a resistance function at mean values, by central differences.

    Arguments: `resistance`, g of the basic variables by name; their `means`.
    """
    result = {}
    base = dict(means)
    centre = resistance(base)
    for name, mean in means.items():
        step = 1e-4 * mean
        high, low = resistance({**base, name: mean + step}), resistance({**base, name: mean - step})
        result[name] = (high - low) / (2.0 * step) * mean / centre
    return result
