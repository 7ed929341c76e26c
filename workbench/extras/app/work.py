"""Work of the page that follows the hand, in worker processes: answers, small curves, collapse.

What is imported here delays the first answer: fragilities and files have modules of their own.
"""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Sequence
from math import inf, nan

import numpy as np

import workbench.api.sweeps
from workbench.base.catalogue import DATA
from workbench.base.codec import Input, inputs_of
from workbench.cli.simulate import timed
from workbench.extras.app.desk import NEAR, SmallCurve
from workbench.models.base import make_model, model_kind, offers
from workbench.responses import Response
from workbench.scenarios import Scenario, scenario_from, to_toml
from workbench.scenarios.varied import put
from workbench.study.error_model.error_model import ORDER, choose
from workbench.study.error_model.error_table import ANCHOR
from workbench.study.limit import CriticalValue, find_limit

QUICKEST = ("four-dof", "single-dof")  # of columns that are struck, and pressed
POINTS = {True: 21, False: 7}  # of a small curve, by whether the model is quick
_ENDS = {"m/s": (1.0, 60.0)}  # of the search of a collapse; of pulses, times the value given
_TIMES = (0.1, 20.0)
_TOLERANCE = 0.005


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
    found, known = [], inputs_by_path(scenario)
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
    each, tables = inputs_by_path(scenario)[key], tomllib.loads(to_toml(scenario))
    ends = _ENDS.get(each.unit) or tuple(times * each.value for times in _TIMES)

    def at(value: float) -> Scenario:
        return scenario_from(put(tables, each.keys, value))

    return find_limit(make_model(name), at, ends, _TOLERANCE)


def inputs_by_path(scenario: Scenario) -> dict[str, Input]:
    """Inputs of a scenario by their keys."""
    return {each.path: each for each in inputs_of(scenario)}
