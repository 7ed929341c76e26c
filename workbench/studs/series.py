"""EN 1990 Annex D: fractile factors, characteristic and design resistance from tests.

A normal quantity with mean m and standard deviation s estimated from n values (V unknown) lies
below m - k s in a new test with the wanted probability for k = t_(n-1)(p) sqrt(1 + 1/n). This
reproduces tables D.1 and D.2.
Source: EN 1990:2002, D.8.2 to D.8.4 (recalled, not read again).

**Second part.** Nominally equal tests, also of a table: EN 1994-1-1 Annex B.2, and EN 1990 D.8.4
for a few.

Three push tests or more are evaluated by B.2.4 and B.2.5 of EN 1994-1-1:2004 (recalled, not read
again). One to three tests have a characteristic value by D.8.4 from a scatter known beforehand:
the shear of undamaged studs, or the share of the undamaged strength or stiffness that one level
of damage leaves.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from math import exp, inf, log, prod, sqrt
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.base.errors import InputError
from workbench.studs.damaged import damage_of, damaged_rows
from workbench.studs.schema import NO_PREDAMAGE, QUANTITIES
from workbench.studs.tables import LIKE_CONCRETE, Array, undamaged_headed_studs

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


LARGEST_DEVIATION = 0.10  # of any test from the mean of the series
REDUCTION = 0.9
DUCTILE_SLIP = 6.0e-3  # m, EN 1994-1-1, 6.6.1.1(5)


@dataclass(frozen=True, slots=True)
class AnnexB:
    """Characteristic and design resistance, slip capacity and ductility class of a series.

    `count`; `mean` and `lowest` resistance and largest `deviation` from the mean; `P_Rk`, `P_Rd`
    in N; slip capacities `slips` in m, `slip_capacity` delta_uk in m (None without curves);
    `ductile` (None without curves); `slip_is_lower_bound`, some curve ended before its load fell
    to P_Rk; `note`, one sentence where the numbers need one.
    """

    count: int
    mean: float
    lowest: float
    deviation: float
    P_Rk: float
    P_Rd: float
    slips: tuple[float, ...]
    slip_capacity: float | None
    ductile: bool | None
    slip_is_lower_bound: bool
    note: str


def evaluate_series(
    resistances: ArrayLike,
    *,
    specified_strength: float,
    measured_strength: float,
    curves: Sequence[tuple[ArrayLike, ArrayLike]] = (),
    partial_factor: float = 1.25,
) -> AnnexB:
    """Evaluate three or more nominally equal tests by Annex B.2.5.

    Arguments: `resistances` per stud (n,) in N; `specified_strength` (minimum) and
    `measured_strength` of the stud material in Pa; `curves` (slip in m, load in N) of the tests in
    the same order, or none; `partial_factor` gamma_V. Raises `InputError` for fewer than three
    tests or one off the mean by over 10 %, an unknown strength, curves of other tests.
    """
    p = np.atleast_1d(np.asarray(resistances, float))
    if not np.isfinite(measured_strength):
        raise InputError("fu_MPa", None, "must be given: P_Rd is related to the measured strength")
    if len(p) < 3 or not np.all(p > 0.0):
        raise InputError("tests", len(p), "must be three or more positive resistances (B.2.5)")
    mean, lowest = float(np.mean(p)), float(np.min(p))
    deviation = float(np.max(np.abs(p / mean - 1.0)))
    if deviation > LARGEST_DEVIATION:
        off = f"{100 * deviation:.0f} % off the mean"
        advice = "make three more tests of the same kind and evaluate all by EN 1990 D.8"
        raise InputError("tests", off, "must lie within 10 % of the mean", advice)
    if curves and len(curves) != len(p):
        raise InputError("curves", len(curves), f"must be {len(p)}, one per test, or none")
    characteristic = REDUCTION * lowest
    reached = [slip_capacity(slip, load, characteristic) for slip, load in curves]
    slips = tuple(slip for slip, _ in reached)
    capacity = REDUCTION * min(slips) if slips else None
    bound = any(open_ended for _, open_ended in reached)
    ductile = None if capacity is None else capacity >= DUCTILE_SLIP
    note = ""
    if bound:
        note = "a curve ends before its load falls to P_Rk: its slip capacity is a lower bound"
        if ductile is False:
            ductile = None  # the stud may be ductile: the test was stopped too early to tell
    return AnnexB(
        len(p), mean, lowest, deviation, characteristic,
        min(specified_strength / measured_strength, 1.0) * characteristic / partial_factor,
        slips, capacity, ductile, bound, note,
    )  # fmt: skip


def slip_capacity(slip: ArrayLike, load: ArrayLike, level: float) -> tuple[float, bool]:
    """Largest slip (m) at a load level (N) on the falling branch, and whether the curve ends above.

    Arguments: `slip` (n,) in m and `load` (n,) in N in the order of the test. In the second case
    the slip is that of the last point, a lower bound. Raises `InputError` for a curve that never
    reaches the level.
    """
    s: Array = np.asarray(slip, float)
    q: Array = np.asarray(load, float)
    if s.shape != q.shape or len(s) < 2 or np.max(q) < level:
        raise InputError("curve", float(np.max(q, initial=0.0)), f"must reach {level:.4g} N")
    last = int(np.flatnonzero(q >= level)[-1])
    if last == len(q) - 1:
        return float(s[-1]), True
    share = (q[last] - level) / (q[last] - q[last + 1])
    return float(s[last] + share * (s[last + 1] - s[last])), False


_DECK = ("deck_depth_mm", "deck_width_mm", "deck_thickness_mm", "studs_per_rib", "deck_fixing")
EQUAL = ("campaign", "diameter_mm", "height_mm", "slab", "stud_spacing", "fu_MPa", *_DECK)
LIKE_LOAD = 0.05  # share by which the largest load of a curve may miss that of the table


class Series(NamedTuple):
    """Nominally equal tests: their name, how many, and the result or why there is none."""

    name: str
    tests: int
    result: AnnexB | None
    refusal: str

    def summary(self) -> dict[str, Any]:
        """One row of a table; the class of ductility in words."""
        row: dict[str, Any] = {"series": self.name, "tests": self.tests, "refusal": self.refusal}
        if self.result is not None:
            row |= asdict(self.result)
            del row["slips"], row["count"]
            words = {True: "ductile", False: "brittle", None: "not known"}
            row["ductile"] = words[self.result.ductile]
        return row


def evaluate_groups(
    table: pd.DataFrame,
    points: pd.DataFrame | None = None,
    *,
    specified_strength: float,
    partial_factor: float = 1.25,
) -> list[Series]:
    """Every group of nominally equal undamaged headed studs, evaluated or refused with the reason.

    Arguments: `table` (schema `TESTS`); `points` (schema `POINTS`) with load-slip curves to beyond
    the maximum, used where all tests of a group have one; the rest as in `evaluate_series`. Raises
    `InputError` for a table without undamaged headed studs.
    """
    curves = {} if points is None else _curves(points)
    result = []
    for group in equal_tests(undamaged_headed_studs(table, "any")):
        first = group.iloc[0]
        names = list(zip(group["campaign"], group["specimen"], strict=True))
        evaluated, why = None, ""
        try:
            _check_curves(group, names, curves)
            evaluated = evaluate_series(
                1e3 * group["shear_kN"].to_numpy(float),
                specified_strength=specified_strength,
                measured_strength=1e6 * float(first["fu_MPa"]),
                curves=[curves[n] for n in names] if all(n in curves for n in names) else [],
                partial_factor=partial_factor,
            )
        except InputError as error:
            why = f"{error.allowed}; {error.advice}" if error.advice else error.allowed
        result.append(Series(title_of(group), len(group), evaluated, why))
    return result


def title_of(group: pd.DataFrame) -> str:
    """Nominally equal tests in words."""
    first = group.iloc[0]
    words = [str(first["campaign"]), f"{first['diameter_mm']:g} mm"]
    words += [str(first[c]) for c in ("slab", "stud_spacing") if first[c]]
    strength = float(group["fcm_MPa"].astype(float).mean())
    return ", ".join(words + [f"f_c {strength:.3g} MPa"] * bool(np.isfinite(strength)))


def equal_tests(rows: pd.DataFrame) -> Iterator[pd.DataFrame]:
    """Nominally equal tests: the same in `EQUAL`, in concrete of about the same strength."""
    for _, group in rows.groupby(list(EQUAL), sort=False, dropna=False):
        strength = group["fcm_MPa"].astype(float).sort_values()
        starts, first = [], np.nan
        for value in strength:
            first = first if value <= (1.0 + LIKE_CONCRETE) * first else value
            starts.append(first)
        part = pd.Series(starts, index=strength.index)
        for _, equal in group.groupby(part.reindex(group.index), sort=False, dropna=False):
            yield equal


def _check_curves(group: pd.DataFrame, names: list[Any], curves: dict[Any, Any]) -> None:
    """Refuse curves whose largest load is not that of their test."""
    for name, load in zip(names, group["shear_kN"], strict=True):
        top = 1e-3 * float(np.max(curves[name][1])) if name in curves else load
        if abs(top / load - 1.0) > LIKE_LOAD:
            reason = f"the curve of {name[1]} must reach the {load:.4g} kN of the table"
            raise InputError("curves", f"{top:.4g} kN", reason)


def _curves(points: pd.DataFrame) -> dict[Any, tuple[Array, Array]]:
    """Slips in m and loads in N of every curve, by campaign and specimen."""
    read = points[points["branch"] != "low-load reading"]
    return {
        name: (1e-3 * rows["slip_mm"].to_numpy(float), 1e3 * rows["load_kN"].to_numpy(float))
        for name, rows in read.groupby(["campaign", "specimen"], sort=False)
    }


class Few(NamedTuple):
    """A group of one to three tests: `mean` (N, or a share) and `characteristic` value.

    `kind`, ``shear`` or the share that is left; `factor` eta_k; `deviation`, of the farthest from
    the mean; `refusal`, why there is no value.
    """

    name: str
    kind: str
    tests: int
    mean: float
    deviation: float
    factor: float | None
    characteristic: float | None
    refusal: str


def evaluate_few(table: pd.DataFrame, variation: float) -> list[Few]:
    """Every group of nominally equal tests of a table, evaluated or refused with the reason.

    Arguments: `table` (schema `TESTS`); `variation`, V_r known from earlier tests. Raises
    `InputError` for a table without a test that a fit may use.
    """
    groups = [_few(*each, variation) for each in _groups(table)]
    if not groups:
        undamaged_headed_studs(table)  # says why none is left
    return groups


def _groups(table: pd.DataFrame) -> Iterator[tuple[str, str, Array]]:
    """Name, kind and values of every group."""
    try:
        undamaged = undamaged_headed_studs(table, "any")
    except InputError:
        undamaged = table.iloc[:0]
    for group in equal_tests(undamaged):
        yield title_of(group), "shear", 1e3 * group["shear_kN"].to_numpy(float)
    damaged = table.assign(predamage_measure=damage_of(table)["measure"])
    damaged = damaged[damaged["predamage"] != NO_PREDAMAGE]
    kinds = damaged[["predamage", "predamage_measure"]].drop_duplicates()
    for quantity in QUANTITIES:
        for kind in kinds.itertuples(index=False):
            rows = damaged_rows(table, quantity, *kind)
            for level, equal in rows.groupby("level", sort=True):
                for group in equal_tests(equal):
                    name = f"{title_of(group)}, {' '.join(kind)} {level:.3g}"
                    yield name, f"{quantity} left", group["ratio"].to_numpy(float)


def _few(name: str, kind: str, values: Array, variation: float) -> Few:
    count, mean = len(values), float(np.mean(values))
    deviation = float(np.max(np.abs(values / mean - 1.0)))
    factor, refusal = None, ""
    if count > MOST_FEW:
        refusal = f"more than {MOST_FEW} tests tell their own scatter: D.8.2, by the other fits"
    elif deviation > FEW_DEVIATION:
        refusal = f"{100 * deviation:.0f} % off the mean: two or three tests must lie within 10 %"
    else:
        factor = few_tests_factor(count, variation)
    characteristic = None if factor is None else factor * mean
    return Few(name, kind, count, mean, deviation, factor, characteristic, refusal)
