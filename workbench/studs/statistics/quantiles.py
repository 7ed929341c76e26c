"""Fractile factors of EN 1990 Annex D from their definition.

A normal quantity with mean m and standard deviation s estimated from n values (V unknown) lies
below m - k s in a new test with the wanted probability for k = t_(n-1)(p) sqrt(1 + 1/n); with a
known standard deviation t is replaced by the normal quantile. This is the prediction of one new
value, and it reproduces the tables D.1 and D.2.
"""

from __future__ import annotations

from math import inf, sqrt

from workbench.errors import InputError

CHARACTERISTIC = 0.95  # share of tests above the characteristic value
TABLE_DESIGN = 0.999  # the probability that table D.2 follows
LIMIT_DESIGN = 0.99882  # Phi(3.04), 3.04 = 0.8 x 3.8: the limit that the standard quotes


def fractile_factor(count: float, share: float = CHARACTERISTIC, *, known: bool = False) -> float:
    """Factor k for which a `share` of new tests lies above mean - k times standard deviation.

    The default `share` is that of k_n (table D.1). k_d,n (table D.2) follows `TABLE_DESIGN`,
    although its limit for many tests is quoted as 3.04, the normal quantile of `LIMIT_DESIGN`.
    Arguments: `count` of tests (infinity allowed); `share` in 0.5..1; `known`, the standard
    deviation is known beforehand. Raises `InputError` for too few tests.
    """
    from scipy.special import ndtri, stdtrit

    if not 0.5 < share < 1.0:
        raise InputError("share", share, "must lie between 0.5 and 1")
    least = 1 if known else 2
    if not count >= least:
        advice = "one test has no scatter to estimate"
        raise InputError("count", count, f"must be {least} or more tests", advice)
    spread = sqrt(1.0 + 1.0 / count)
    if known or count == inf:
        return float(ndtri(share)) * spread
    return float(stdtrit(count - 1.0, share)) * spread
