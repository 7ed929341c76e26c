"""Work of the page in its worker processes: answers, small curves, collapse, fragility."""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Mapping, Sequence
from math import inf, nan

import numpy as np
import pandas as pd

import workbench.api.sweeps
from workbench.base.catalogue import DATA
from workbench.base.codec import Input, inputs_of
from workbench.base.errors import InputError
from workbench.base.fields import Number
from workbench.base.units import in_si
from workbench.cli.simulate import timed
from workbench.extras.app import sheet
from workbench.extras.app.desk import NEAR, SmallCurve
from workbench.extras.uncertainty.critical_velocity import VELOCITIES, limit_of
from workbench.extras.uncertainty.fragility import fragility as run_fragility
from workbench.extras.uncertainty.inputs import uncertain_from
from workbench.extras.uncertainty.sample_runs import Setup, Target
from workbench.extras.uncertainty.verbs.fragility import pair_of, struck
from workbench.models.base import make_model, model_kind, offers
from workbench.responses import Response
from workbench.scenarios import Scenario, scenario_from, to_toml
from workbench.scenarios.files import parse_value
from workbench.scenarios.varied import put
from workbench.study.error_model.error_model import ORDER, choose
from workbench.study.error_model.error_table import ANCHOR
from workbench.study.limit import CriticalValue, find_limit

QUICKEST = ("four-dof", "single-dof")  # of columns that are struck, and pressed
POINTS = {True: 21, False: 7}  # of a small curve, by whether the model is quick
_ENDS = {"m/s": (1.0, 60.0)}  # of the search of a collapse; of pulses, times the value given
_TIMES = (0.1, 20.0)
_TOLERANCE = 0.005
_SAMPLES, _HALF_WIDTH = 2048, 0.05  # of a fragility


def models_of(kind: str) -> list[tuple[str, str]]:
    """Names and first sentences of the models that answer a kind, those of the advice first."""
    kinds = [offer.kind for offer in offers() if offer.kind is not None]
    fitting = [each for each in kinds if kind in each.answers and each.name not in DATA]
    fitting.sort(key=lambda each: each.name not in (*QUICKEST, *ORDER))
    return [(each.name, str(each.__doc__).partition("\n")[0]) for each in fitting]


def answers(
    scenario: Scenario, names: Sequence[str] = (), slow: Collection[str] = ()
) -> dict[str, Response]:
    """Responses of models with advice and warnings, by name.

    Without names of those that answer at once: of the advice, the quickest that answers the kind,
    the anchor, less what is known to be `slow`. That of the advice says why it answers.
    """
    advised = choose(scenario).model
    quickest = [name for name in QUICKEST if scenario.KIND in model_kind(name).answers]
    usual = [n for n in (advised, *quickest[:1], ANCHOR) if n not in slow] or [advised]
    asked = dict.fromkeys(names or usual)
    return {n: timed(scenario, None if n == advised else make_model(n)) for n in asked}


def curves(scenario: Scenario, keys: Sequence[str], name: str, quick: bool) -> list[SmallCurve]:
    """Peaks of a model over some keys, from half to one and a half times the value given.

    A `quick` one gives more points.
    """
    found, known = [], _inputs(scenario)
    for key in (key for key in keys if known.get(key) and known[key].value):
        values = np.linspace(*NEAR, POINTS[quick]) * known[key].value
        swept = workbench.api.sweeps.sweep(scenario, {key: values}, [name])
        fallen = swept["outcome"].to_numpy()[0] == "collapse"
        known_peaks = swept.get("peak_displacement")  # of collapses alone there is none
        peaks = np.full(len(values), nan) if known_peaks is None else known_peaks.to_numpy()[0]
        peaks = np.where(fallen, inf, peaks)
        found.append(SmallCurve(key, known[key].unit, values, peaks))
    return found


def collapse(scenario: Scenario, key: str, name: str) -> CriticalValue:
    """Bracket of the value of a key at which the structure collapses."""
    each, tables = _inputs(scenario)[key], tomllib.loads(to_toml(scenario))
    ends = _ENDS.get(each.unit) or tuple(times * each.value for times in _TIMES)

    def at(value: float) -> Scenario:
        return scenario_from(put(tables, each.keys, value))

    return find_limit(make_model(name), at, ends, _TOLERANCE)


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
    known, tables = _inputs(scenario), tomllib.loads(to_toml(scenario))
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


def picture(scenario: Scenario, responses: dict[str, Response], kind: str) -> str:
    """A figure of the reports as SVG; empty where the answers have nothing to show."""
    try:
        return sheet.picture(scenario, responses, kind, "svg").decode()
    except InputError:
        return ""


def swept_page(scenario: Scenario, key: str, names: Sequence[str]) -> str:
    """Page to explore answers over a key, from half to one and a half times the value given."""
    values = np.linspace(*NEAR, POINTS[False]) * _inputs(scenario)[key].value
    return sheet.sweep_page(scenario, key, values.tolist(), names)


def _inputs(scenario: Scenario) -> dict[str, Input]:
    return {each.path: each for each in inputs_of(scenario)}
