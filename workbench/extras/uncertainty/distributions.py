"""Distributions of single inputs, as TOML writes them, by quantiles of a standard normal score.

``{ normal = [14.0, 2.0] }`` gives mean and standard deviation, as do lognormal, gumbel and weibull;
``{ lognormal = { mean = 388e6, cov = 0.07 } }`` the coefficient of variation; ``uniform`` its ends,
``triangular`` low, mode and high, ``discrete`` values and weights. ``low`` and ``high`` beside the
law truncate it. ``{ jcss = "S355" }`` names a row of the JCSS Probabilistic Model Code.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import exp, gamma, inf, isfinite, log, pi, sqrt
from typing import Any

import numpy as np
from scipy import stats
from scipy.optimize import brentq
from scipy.special import ndtr

from workbench.base.arrays import Array
from workbench.base.errors import InputError

_EULER = 0.5772156649015329
_SHAPES = (0.2, 200.0)  # of a Weibull distribution: cov 16 to 0.006
_LARGEST, _VARIATIONS = 1e30, (1e-6, 10.0)  # number of a law; coefficients of variation
_ENDS = (("low", -inf), ("high", inf))
_NEAREST = 1e-15  # probabilities stay this far from 0 and 1


def _lognormal(mean: float, sd: float) -> Any:
    variance = log(1.0 + (sd / mean) ** 2)
    return stats.lognorm(sqrt(variance), scale=mean * exp(-variance / 2.0))


def _gumbel(mean: float, sd: float) -> Any:
    scale = sd * sqrt(6.0) / pi
    return stats.gumbel_r(mean - _EULER * scale, scale)


def _weibull(mean: float, sd: float) -> Any:
    def excess(shape: float) -> float:
        return gamma(1.0 + 2.0 / shape) / gamma(1.0 + 1.0 / shape) ** 2 - 1.0 - (sd / mean) ** 2

    shape = brentq(excess, *_SHAPES)
    return stats.weibull_min(shape, scale=mean / gamma(1.0 + 1.0 / shape))


MOMENT_LAWS: dict[str, Callable[[float, float], Any]] = {
    **{"normal": stats.norm, "lognormal": _lognormal, "gumbel": _gumbel, "weibull": _weibull}
}
LAWS = (*MOMENT_LAWS, "uniform", "triangular", "discrete", "jcss")
POSITIVE = ("lognormal", "weibull")

# JCSS Probabilistic Model Code: 3.2 steel (f_nom exp(2 V) - 20 MPa, V = 0.07; modulus), 2.18 impact
_V, _KMH = 0.07, 1.0 / 3.6
_GRADES = {"S235": 235e6, "S275": 275e6, "S355": 355e6}
JCSS: dict[str, dict[str, tuple[str, float, float]]] = {
    "yield_stress": {
        grade: ("lognormal", nominal * exp(2.0 * _V) - 20e6, _V * (nominal * exp(2.0 * _V) - 20e6))
        for grade, nominal in _GRADES.items()
    },
    "elastic_modulus": {"steel": ("lognormal", 210e9, 0.03 * 210e9)},
    "velocity": {
        "motorway": ("lognormal", 80 * _KMH, 10 * _KMH),
        "urban": ("lognormal", 40 * _KMH, 7 * _KMH),
        "courtyard": ("lognormal", 15 * _KMH, 6 * _KMH),
        "parking": ("lognormal", 10 * _KMH, 5 * _KMH),
    },
    "mass": {"truck": ("normal", 20e3, 12e3), "car": ("normal", 1500.0, 400.0)},
    "stiffness": {"vehicle": ("lognormal", 300e3, 60e3)},
}
JCSS_LOW = {"mass": {"truck": 3500.0, "car": 500.0}}  # truncated: the normal law has negative mass


@dataclass(frozen=True)
class Distribution:
    """One uncertain input: `law`, scipy's frozen `frozen` one, truncated to `low` and `high`.

    `discrete`: values and cumulative weights in place of `frozen`.
    """

    law: str
    frozen: Any
    low: float = -inf
    high: float = inf
    discrete: tuple[tuple[Any, ...], tuple[float, ...]] | None = None

    def values(self, scores: Array) -> Array:
        """Values (any shape) at standard normal scores of the same shape."""
        share = ndtr(scores)
        if self.discrete is not None:
            options, cumulative = self.discrete
            chosen = np.searchsorted(np.array(cumulative[:-1]), share, side="right")
            return np.asarray(np.array(options, dtype=object)[chosen])
        least, most = self.frozen.cdf(self.low), self.frozen.cdf(self.high)
        inside = np.clip(least + share * (most - least), _NEAREST, 1.0 - _NEAREST)
        return np.asarray(np.clip(self.frozen.ppf(inside), self.low, self.high))

    @property
    def middle(self) -> Any:
        """The median, for the scenario that stands for all."""
        return self.values(np.zeros(1)).tolist()[0]


def is_distribution(value: Any) -> bool:
    """Whether a TOML value is a distribution: a table with the name of a law."""
    return isinstance(value, Mapping) and any(law in value for law in LAWS)


def distribution_of(path: str, table: Mapping[str, Any]) -> Distribution:
    """Read a distribution at a key `path`. Raises `InputError` naming key and value."""
    laws = [law for law in LAWS if law in table]
    unknown = sorted(set(table) - {*laws, "low", "high"})
    if len(laws) != 1 or unknown:
        text = "is no known distribution: must name one law, with low and high at most beside it"
        advice = f"such as {{ normal = [14.0, 2.0] }}; laws are {', '.join(LAWS)}"
        raise InputError(path, dict(table), text, advice)
    law, given = laws[0], table[laws[0]]
    low, high = (_number(f"{path}.{end}", table.get(end, far)) for end, far in _ENDS)
    if law == "jcss":
        law, given, least = _jcss(path, given)
        low = max(low, least)
    if law == "discrete":
        return _discrete(path, given)
    frozen = _frozen(path, law, given)
    if not low < high or not frozen.cdf(low) < frozen.cdf(high):
        text = "leave nothing of the distribution between low and high"
        raise InputError(path, dict(table), text, "take wider ends")
    return Distribution(law, frozen, low, high)


def _number(path: str, value: Any) -> float:
    known = isinstance(value, int | float) and not isinstance(value, bool) and value == value
    if not known or _LARGEST < abs(value) < inf:
        raise InputError(path, value, f"must be a number in SI units, within {_LARGEST:g} of 0")
    return float(value)


def _frozen(path: str, law: str, given: Any) -> Any:
    key = f"{path}.{law}"
    if law in MOMENT_LAWS:
        mean, sd = _moments(key, given)
        if sd <= 0.0 or not isfinite(sd) or not isfinite(mean):
            raise InputError(key, given, "needs a finite mean and a standard deviation above 0")
        if law in POSITIVE and mean <= 0.0:
            raise InputError(key, given, "needs a mean above 0")
        least, most = (0.006, 15.0) if law == "weibull" else _VARIATIONS
        is_share = law in POSITIVE or (isinstance(given, Mapping) and "cov" in given)
        if (is_share and sd > most * abs(mean)) or sd < max(least * abs(mean), 1.0 / _LARGEST):
            text = f"needs a coefficient of variation from {least:g} to {most:g}"
            raise InputError(key, given, text, "write a number where nothing varies")
        return MOMENT_LAWS[law](mean, sd)
    count, names = (2, "low and high") if law == "uniform" else (3, "low, mode and high")
    if not isinstance(given, list) or len(given) != count:
        raise InputError(key, given, f"must be a list of {names}")
    ends = [_number(key, each) for each in given]
    if sorted(ends) != ends or ends[0] == ends[-1] or not all(map(isfinite, ends)):
        raise InputError(key, given, f"must rise: {names}")
    width = ends[-1] - ends[0]
    if law == "uniform":
        return stats.uniform(ends[0], width)
    return stats.triang((ends[1] - ends[0]) / width, ends[0], width)


def _moments(key: str, given: Any) -> tuple[float, float]:
    if isinstance(given, list) and len(given) == 2:
        return _number(key, given[0]), _number(key, given[1])
    if isinstance(given, Mapping) and "mean" in given and len(given) == 2:
        mean = _number(f"{key}.mean", given["mean"])
        if "sd" in given:
            return mean, _number(f"{key}.sd", given["sd"])
        if "cov" in given:
            return mean, _number(f"{key}.cov", given["cov"]) * abs(mean)
    text = "must be [mean, standard deviation], { mean, sd } or { mean, cov }"
    raise InputError(key, given, text)


def _discrete(path: str, given: Any) -> Distribution:
    key = f"{path}.discrete"
    if not isinstance(given, Mapping) or set(given) != {"values", "weights"}:
        raise InputError(key, given, "must be { values = [...], weights = [...] }")
    options, weights = given["values"], given["weights"]
    if not isinstance(options, list) or not isinstance(weights, list):
        raise InputError(key, given, "needs two lists")
    shares = [_number(f"{key}.weights", each) for each in weights]
    if len(options) != len(shares) or not shares or min(shares) < 0.0 or not sum(shares) > 0.0:
        raise InputError(key, given, "needs a weight of at least 0 for each value, one above 0")
    cumulative = np.cumsum(shares) / sum(shares)
    return Distribution("discrete", None, discrete=(tuple(options), tuple(cumulative.tolist())))


def _jcss(path: str, name: Any) -> tuple[str, list[float], float]:
    leaf = path.rpartition(".")[2]
    rows = JCSS.get(leaf, {})
    if not rows:
        text = f"is known for {', '.join(JCSS)} only"
        raise InputError(f"{path}.jcss", name, text, "write the distribution itself")
    if not isinstance(name, str) or name not in rows:
        raise InputError(f"{path}.jcss", name, f"must be one of {', '.join(rows)}")
    law, mean, sd = rows[name]
    return law, [mean, sd], JCSS_LOW.get(leaf, {}).get(name, -inf)
