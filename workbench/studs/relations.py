"""Relations between damage and what is left: R(D), damage D from 0 on, R = 1 undamaged, R >= 0.

D = 1 is what an undamaged stud bears; a stud that was driven beyond has more. A fatigue life ends
when what is left has fallen to the peak of the load, R(1) = P_max / P_u: relations that keep to it
are anchored.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.studs.quantities import Array

SOURCES = ("oehlers1990", "hanswille2007", "oehlers-foley1985", "yao2018")  # bibliography keys


@dataclass(frozen=True)
class Relation:
    """A form of R(D): `parameters` with `lower`, `upper` bounds and `starts`; `formula` in words.

    A fit begins at the start that is nearest: with a kink it would stop at the first valley. `peak`
    of an anchored relation: P_max / P_u, one number or that of every test (None: not anchored).
    """

    name: str
    formula: str
    parameters: tuple[str, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    starts: tuple[tuple[float, ...], ...]
    value: Callable[..., Array]
    source: str
    peak: ArrayLike | None = None

    def at(self, peak: ArrayLike | None) -> Relation:
        """An anchored relation at peaks, in its formula if they are one; any other as it is."""
        if self.peak is None or peak is None:
            return self
        told = f", P_max/P_u = {float(np.mean(np.asarray(peak, float))):.3g}" * (np.ndim(peak) == 0)
        return replace(self, peak=peak, formula=self.formula + told)

    def __call__(self, level: ArrayLike, theta: ArrayLike = ()) -> Array:
        """What is left (n,) at damage levels (n,) for parameters (p,)."""
        d = np.asarray(level, float)
        if np.any(d < 0.0):
            raise InputError("level", float(np.min(d)), "damage is 0 or more")
        known = () if self.peak is None else (np.asarray(self.peak, float),)
        return np.maximum(self.value(d, np.asarray(theta, float), *known), 0.0)

    def start_for(self, level: Array, left: Array) -> tuple[float, ...]:
        """The one of `starts` that is nearest to what is left (n,) at damage levels (n,)."""
        return min(self.starts, key=lambda theta: float(np.sum((self(level, theta) - left) ** 2)))


@dataclass(frozen=True)
class MechanicalCurve:
    """What a mechanical model predicts to be left: `level` (n,), `ratio` (n,) with a band.

    `low` and `high` (n,) bound the prediction over its unknown parameters; `predamage`,
    `measure` and `quantity` as in `fit_residual`; `basis` says what it was calibrated on; `stud`,
    which one it is computed for. Levels rise from 0, where the ratio is 1.
    """

    level: Array
    ratio: Array
    low: Array
    high: Array
    predamage: str
    measure: str
    quantity: str
    basis: str
    stud: str = ""

    def __post_init__(self) -> None:
        shapes = {np.shape(v) for v in (self.level, self.ratio, self.low, self.high)}
        if len(shapes) > 1 or len(self.level) < 2 or np.any(np.diff(self.level) <= 0.0):
            raise InputError("mechanical", shapes, "must be curves over rising levels")

    def relation(self) -> Relation:
        """The prediction as a relation without parameters: linear, NaN beyond the last level."""
        none, words = ((), (), (), ((),)), "prediction of the mechanical model"
        left = partial(np.interp, xp=self.level, fp=self.ratio, right=np.nan)
        return Relation("mechanical", words, *none, lambda d, p: np.asarray(left(d)), self.basis)


LATEST = 0.9  # damage up to which nothing need be lost
_THRESHOLDS = tuple((c, t) for c in (0.1, 0.3, 0.6, 0.9) for t in (0.05, 0.2, 0.35, 0.5, 0.65, 0.8))
RELATIONS: dict[str, Relation] = {
    relation.name: relation
    for relation in (
        Relation("none", "R = 1: no loss", (), (), (), ((),),
                 lambda d, p: np.ones_like(d), "the null hypothesis"),
        Relation("linear", "R = 1 - c D", ("c",), (0.0,), (1.0,), ((0.3,),),
                 lambda d, p: 1.0 - p[0] * d, "after Oehlers 1990 (abstract only)"),
        Relation("power", "R = 1 - c D^p", ("c", "p"), (0.0, 0.1), (1.0, 10.0), ((0.4, 1.2),),
                 lambda d, p: 1.0 - p[0] * d ** p[1], "empirical"),
        Relation("exponential", "R = exp(-c D)", ("c",), (0.0,), (20.0,), ((0.4,),),
                 lambda d, p: np.exp(-p[0] * d), "empirical"),
        Relation("threshold", "R = 1 - c (D - t) / (1 - t) from D = t on, 1 before", ("c", "t"),
                 (0.0, 0.0), (1.0, LATEST), _THRESHOLDS,
                 lambda d, p: 1.0 - p[0] * np.maximum(d - p[1], 0.0) / (1.0 - p[1]), "empirical"),
    )
}  # fmt: skip


def _inverted_s(d: Array, p: Array, peak: Array) -> Array:
    inside = np.clip(d, 1e-12, 1.0 - 1e-12)
    found = np.clip(p[0] - p[1] * np.log(inside / (1.0 - inside)), peak, 1.0)
    return np.asarray(np.where(d <= 0.0, 1.0, np.where(d >= 1.0, peak, found)))


_LEVELS = tuple((a, b) for a in (0.5, 0.65, 0.8, 0.95) for b in (0.02, 0.05, 0.1, 0.2))
ANCHORED: dict[str, Relation] = {
    relation.name: relation
    for relation in (
        Relation("oehlers", "R = 1 - (1 - P_max/P_u) D", (), (), (), ((),),
                 lambda d, p, peak: 1.0 - (1.0 - peak) * d,
                 "after Oehlers 1990 (abstract only); the end of life is a definition", 1.0),
        Relation("anchored-power", "R = 1 - (1 - P_max/P_u) D^q", ("q",), (0.1,), (10.0,),
                 ((0.3,), (1.0,), (3.0,)), lambda d, p, peak: 1.0 - (1.0 - peak) * d ** p[0],
                 "empirical", 1.0),
        Relation("inverted-s", "R = a - b ln(D / (1 - D)), from 1 down to P_max/P_u", ("a", "b"),
                 (0.0, 0.0), (1.5, 0.5), _LEVELS, _inverted_s, "inverted S, as recalled of "
                 "Hanswille, Porsch and Ustundag 2007, whose printed formula was not read", 1.0),
    )
}  # fmt: skip
