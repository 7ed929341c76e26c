"""Fit of a load-slip law to one measured curve."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError, SolverError
from workbench.studs.load_slip import BilinearLaw, Law, LoadSlipLaw, law_kind
from workbench.studs.quantities import Array

# parameters of each law: name, lower and upper bound, start; all fitted as logarithms
_BOUNDS: dict[str, tuple[tuple[str, float, float, float], ...]] = {
    "ollgaard": (("rate", 10.0, 1e5, 1000.0), ("exponent", 0.05, 10.0, 0.6)),
    "bilinear": (("yield_slip", 1e-5, 0.02, 5e-4),),
    "rational": (
        ("peak_slip", 1e-4, 0.05, 6e-3),
        ("stiffness_ratio", 1.01, 500.0, 6.0),
        ("softening", 1e-4, 1.0, 0.5),
    ),
}
LOSSES = ("linear", "huber", "soft_l1")
LOSS_SCALE = 0.03  # of the largest load: deviations beyond it count less in a robust loss


@dataclass(frozen=True)
class CurveFit:
    """A law fitted to one curve.

    `law`; `parameters` by name (SI); `points` fitted; `rms` and `bias` (mean of law less test)
    of the load over the largest load; `at_bound`, names of parameters on a bound;
    `near_interpolation`, fewer than three points more than parameters, so that `rms` says little.
    """

    law: LoadSlipLaw
    parameters: dict[str, float]
    points: int
    rms: float
    bias: float
    at_bound: tuple[str, ...]
    near_interpolation: bool


def parameter_names(law: str) -> tuple[str, ...]:
    """Names of the parameters of a law that are fitted. Raises `InputError`."""
    law_kind(law)
    return tuple(name for name, *_ in _BOUNDS[law])


def make_law(law: str, parameters: dict[str, float], slip_capacity: float | None = None) -> Law:
    """The law of this name with fitted parameters (SI); a bilinear law yields before its end."""
    if law != "bilinear" or slip_capacity is None:
        return law_kind(law)(**parameters)
    return BilinearLaw(min(parameters["yield_slip"], slip_capacity), slip_capacity)


def misfit(law: LoadSlipLaw, slip: ArrayLike, ratio: ArrayLike) -> tuple[float, float]:
    """Root mean square and mean of law less test, both as load over the largest load.

    Arguments: slips (n,) in m, readings below zero count as zero; load `ratio` (n,).
    """
    error = law.ratio(np.maximum(np.asarray(slip, float), 0.0)) - np.asarray(ratio, float)
    return float(np.sqrt(np.mean(error**2))), float(np.mean(error))


def fit_curve(
    slip: ArrayLike,
    load: ArrayLike,
    law: str = "ollgaard",
    *,
    loss: str = "linear",
    held: Mapping[str, float] | None = None,
) -> CurveFit:
    """Fit a law to the shape of one curve, load over its largest load, by bounded least squares.

    Arguments: slips (n,) in m and loads (n,) in N; `law`, a name in `LAWS`; `loss` ``linear``,
    ``huber`` or ``soft_l1``; `held`, parameters with given values (SI). Raises `InputError` for
    fewer points than parameters, `SolverError`.
    """
    from scipy.optimize import least_squares

    if loss not in LOSSES:
        raise InputError("loss", loss, "must be one of " + ", ".join(LOSSES))
    fixed = dict(held or {})
    for name in fixed:
        if name not in parameter_names(law):
            raise InputError("held", name, "must be one of " + ", ".join(parameter_names(law)))
    bounds = [bound for bound in _BOUNDS[law_kind(law).name] if bound[0] not in fixed]
    names = [name for name, *_ in bounds]
    s, q = np.maximum(np.asarray(slip, float), 0.0), np.asarray(load, float)
    least = max(len(bounds), 2)
    if s.shape != q.shape or s.ndim != 1 or len(s) < least:
        raise InputError("curve", s.shape, f"must have {least} points or more for the {law} law")
    top = float(np.max(q))
    if not top > 0.0:
        raise InputError("curve", top, "must hold a positive load")
    y = q / top
    capacity = float(np.max(s)) if law == "bilinear" else None
    low, high, start = (np.log([bound[k] for bound in bounds]) for k in (1, 2, 3))

    def at(theta: Array) -> Law:
        # exponentials of the bounds may leave them by round-off
        values = np.clip(np.exp(theta), np.exp(low), np.exp(high))
        return make_law(law, {**dict(zip(names, values.tolist(), strict=True)), **fixed}, capacity)

    starts = [start]
    if "peak_slip" in names:
        peak = max(float(s[int(np.argmax(y))]), 1e-4)
        starts.append(np.clip(np.concatenate([[np.log(peak)], start[1:]]), low, high))
    tolerances = {"xtol": 1e-12, "ftol": 1e-12, "gtol": 1e-12}
    tried = [
        least_squares(
            lambda theta: at(theta).ratio(s) - y, begin, bounds=(low, high), loss=loss,
            f_scale=LOSS_SCALE, **tolerances,
        )
        for begin in starts
    ]  # fmt: skip
    solved = [each for each in tried if each.success]
    if not solved:
        raise SolverError("least squares of a load-slip curve", float("nan"), "several starts")
    found = min(solved, key=lambda each: float(each.cost)).x
    best = at(found)
    parameters = {name: float(getattr(best, name)) for name in (*names, *fixed)}
    rms, bias = misfit(best, s, y)
    stuck = np.isclose(found, low, atol=1e-4) | np.isclose(found, high, atol=1e-4)
    at_bound = tuple(name for name, on in zip(names, stuck, strict=True) if on)
    return CurveFit(best, parameters, len(s), rms, bias, at_bound, len(s) < len(names) + 3)
