"""Chance to exceed a limit over the velocity, from texts that a person wrote into fields."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping

import numpy as np
import pandas as pd

from workbench.base.errors import InputError
from workbench.base.fields import Number
from workbench.base.units import in_si
from workbench.extras.app.work import inputs_by_path
from workbench.extras.uncertainty.critical_velocity import VELOCITIES, limit_of
from workbench.extras.uncertainty.fragility import fragility as run_fragility
from workbench.extras.uncertainty.inputs import uncertain_from
from workbench.extras.uncertainty.sample_runs import Setup, Target
from workbench.extras.uncertainty.verbs.fragility import pair_of, struck
from workbench.models.base import make_model
from workbench.scenarios import Scenario, to_toml
from workbench.scenarios.files import parse_value
from workbench.scenarios.varied import put

_SAMPLES, _HALF_WIDTH = 2048, 0.05


def fragility_input(given: Mapping[str, str]) -> tuple[dict[str, float], str, tuple[float, float]]:
    """Coefficients of variation by key, limit and ends (m/s) of a fragility, from texts of people.

    Raises `InputError` naming the text.
    """
    ends, spreads = [], {}
    for key in ("low", "high"):
        ends.append(VELOCITIES.check(key, in_si(given[key], "m/s") or given[key]))
    if not ends[0] < ends[1]:
        raise InputError("high", given["high"], "must be above the first velocity")
    for key, text in given.items():
        if "." in key:
            spreads[key] = Number(0.0, 1.0).check(key, parse_value(text))
    if not any(spreads.values()):
        raise InputError("run", None, "some coefficient of variation must be above 0")
    limit = given["limit"] if given["limit"] == "collapse" else f"displacement={given['limit']}"
    return spreads, limit, (ends[0], ends[1])


def fragility(
    scenario: Scenario, given: Mapping[str, str], seconds: float
) -> tuple[pd.DataFrame, str]:
    """Curve of the probability to exceed a limit over the velocity, and what it rests on.

    Arguments: texts of people, `given` by the keys of the fields: ends of the velocity, a limit,
    coefficients of variation of inputs, whose numbers become lognormal around the value of the
    scenario; `seconds` that it may take. Raises `InputError`, `WorkbenchError`.
    """
    spreads, limit, ends = fragility_input(given)
    known, tables = inputs_by_path(scenario), tomllib.loads(to_toml(scenario))
    for key, cov in spreads.items():
        law = {"lognormal": {"mean": known[key].value, "cov": cov}}
        tables = put(tables, known[key].keys, law) if cov else tables
    names = pair_of(struck(scenario).at_velocity(ends[1]), None, None)
    reduced, reference = (make_model(name) for name in names)
    uncertain = uncertain_from(tables)
    rest = limit_of(limit), ends, _SAMPLES, 1, None, seconds, Target(_HALF_WIDTH)
    result = run_fragility(Setup(uncertain, reduced, reference, *rest))
    curve = result.curve
    columns = {"low": curve.low, "median": curve.median, "high": curve.high}
    said = (
        f"{reduced.name}, {_SAMPLES} samples, corrected by {len(result.ratios)} answers of "
        f"{reference.name}; half-width of the band {curve.half_width:.2f} in probability"
    )
    return pd.DataFrame({"velocity": np.exp(curve.log_velocity), **columns}), said
