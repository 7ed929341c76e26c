"""Conformance kit: what every model has to keep, ours and third-party ones alike.

In a test suite: ``check_model(MyModel(), [scenario, ...])``.
"""

import dataclasses
import json
import pickle
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from workbench.base.codec import Input
from workbench.base.errors import InputError, WorkbenchError
from workbench.models.base import Model, options_of, with_options
from workbench.responses import Finding, Outcome, Response, check_response, findings_of, outcome_of
from workbench.responses.histories import ENERGIES, TIMES
from workbench.scenarios import Scenario, scenario_hash
from workbench.scenarios.varied import NO_VALUES, with_other_inputs

ENERGY_TOLERANCE = 1e-6  # of the input energy

OFF_PLANE = ("column.*_weak", "column.unbraced_length", "striker.friction")
_SIGNATURE = ("model", "model_version", "options", "scenario", "scenario_hash", "provenance")


def check_model(
    model: Model, scenarios: Sequence[Scenario], energy_tolerance: float = ENERGY_TOLERANCE
) -> None:
    """Hold a model to the contract, over scenarios of the kinds that it answers.

    Arguments: `model`; `scenarios`, at least one of which the model must answer with outcome ok;
    `energy_tolerance`, largest error of the energy ledger over the input energy. Of models from
    elsewhere, every input of the first scenario of a kind must change the answer or be `unused`.
    Raises AssertionError listing everything that is not kept.
    """
    problems = problems_of(model, scenarios, energy_tolerance)
    if problems:
        name = getattr(model, "name", type(model).__name__)
        raise AssertionError(f"model {name} breaks the contract:\n- " + "\n- ".join(problems))


def problems_of(
    model: Model, scenarios: Sequence[Scenario], energy_tolerance: float = ENERGY_TOLERANCE
) -> list[str]:
    """Problems of a model with the contract, one sentence each (empty: it conforms)."""
    problems = list(_declaration(model))
    if problems:
        return problems
    problems.extend(_options(model))
    outcomes = []
    for scenario in scenarios:
        if scenario.KIND not in model.answers:
            problems.append(f"{scenario.name}: the kit was given a kind that it does not answer")
            continue
        try:
            response = model.simulate(scenario)
            again = model.simulate(scenario)
        except Exception as error:
            problems.append(f"{scenario.name}: simulate raised {type(error).__name__}: {error}")
            continue
        outcomes.append(outcome_of(response))
        faults = [*_domain(model, scenario, response), *_response(model, scenario, response)]
        if not _numbers(response).identical(_numbers(again)):
            faults.append("two runs of the same scenario differ")
        faults.extend(_ledger(response, energy_tolerance))
        problems.extend(f"{scenario.name}: {text}" for text in faults)
    if Outcome.OK not in outcomes:
        problems.append("answers none of the given scenarios with outcome ok")
    problems.extend(_foreign(model, scenarios[0]) if scenarios else ())
    if not problems and not type(model).__module__.startswith("workbench."):  # walked by its tests
        first = {scenario.KIND: scenario for scenario in reversed(scenarios)}
        silent = [path for each in first.values() for path in ignored_inputs(model, each)]
        problems.extend(
            f"{path} changes nothing: use it, or name it in `unused`" for path in silent
        )
    return problems


def ignored_inputs(
    model: Any, scenario: Any, values: Mapping[str, Sequence[Any]] = NO_VALUES
) -> list[str]:
    """Paths of inputs of a scenario that a model neither uses nor says that it does not.

    With any other value, of `values` by path or one that its rule allows, numbers and outcome are
    the same and no finding names it. Known are what the model calls `unused`, the length of the
    record, masses and strain rates where nothing moves, and of plane models what matters off the
    plane of bending alone.
    """
    answer, used = model.simulate(scenario), dict[str, bool]()
    beside = () if getattr(model, "spatial", False) else OFF_PLANE
    declared = ("time.duration", *beside, *getattr(model, "unused", ()))
    for each, other in with_other_inputs(scenario, values):
        known = any(fnmatchcase(each.path, pattern) for pattern in declared)
        known |= scenario.STATIC and (each.unit.startswith("kg") or each.path == "steel.rate")
        known |= used.get(each.path, False)
        used[each.path] = known or _differs(answer, model.simulate(other), each)
    return [path for path, is_used in used.items() if not is_used]


def _differs(answer: Response, other: Response, changed: Input) -> bool:
    """Whether an answer with another input differs, or a finding of both names that."""
    if outcome_of(answer) is not outcome_of(other) or not answer.equals(other):
        return True
    key = changed.path.rpartition(".")[2]
    texts = " ".join(each.text for each in (*findings_of(answer), *findings_of(other)))
    if f"{key} = " in texts or ("_" in key and key.replace("_", " ") in texts):
        return True
    new = {f.subject for f in findings_of(other)} - {f.subject for f in findings_of(answer)}
    return any(set(key.split("_")) & set(subject.split("-")) for subject in new)


def _declaration(model: Model) -> Iterator[str]:
    kind = type(model)
    if not dataclasses.is_dataclass(kind) or not kind.__dataclass_params__.frozen:
        yield "must be an instance of a frozen dataclass"
        return
    missing = [name for name in ("domain", "simulate") if not callable(getattr(model, name, None))]
    if missing:
        yield "has no " + " and no ".join(missing)
    name = getattr(model, "name", None)
    if not isinstance(name, str) or not name or name != name.lower() or " " in name:
        yield "name must be a word in lower case, with hyphens"
    if not isinstance(getattr(model, "version", None), int) or model.version < 1:
        yield "version must be a whole number from 1"
    for attribute in ("answers", "assumptions", "sources"):
        value = getattr(model, attribute, None)
        if not isinstance(value, tuple) or not all(isinstance(v, str) and v for v in value):
            yield f"{attribute} must be a tuple of texts"
        elif not value and attribute != "sources":
            yield f"{attribute} must not be empty"
    fields = {field.name for field in dataclasses.fields(kind)}
    for attribute in {"name", "version", "answers", "assumptions", "sources"} & fields:
        yield f"{attribute} must be a class variable, not an option"
    if not kind.__doc__ or kind.__doc__.startswith(f"{kind.__name__}("):
        yield "must have a docstring"


def _options(model: Model) -> Iterator[str]:
    options = options_of(model)
    try:
        again = with_options(type(model), json.loads(json.dumps(options)))
    except (TypeError, ValueError, WorkbenchError) as error:
        yield f"options do not survive a round trip through JSON: {error}"
    else:
        if again != model:
            yield f"options change in a round trip through JSON: {options} -> {options_of(again)}"
    with suppress(InputError):
        with_options(type(model), {**options, "no_such_option": 1})
        yield "accepts an option that it does not have"
    if pickle.loads(pickle.dumps(model)) != model:
        yield "changes when it is pickled"


def _domain(model: Model, scenario: Scenario, response: Response) -> Iterator[str]:
    findings = model.domain(scenario)
    if not all(isinstance(finding, Finding) for finding in findings):
        yield "domain must return findings"
        return
    refusals = [finding for finding in findings if finding.refusal]
    if refusals and outcome_of(response) is not Outcome.OUT_OF_DOMAIN:
        yield "domain refuses the scenario but simulate answers it"
    stated = {(finding.subject, finding.text) for finding in findings_of(response)}
    for finding in findings:
        if (finding.subject, finding.text) not in stated:
            what = "refusal" if finding.refusal else "warning"
            yield f"the {what} {finding.text!r} of domain is missing in the response"


def _response(model: Model, scenario: Scenario, response: Response) -> Iterator[str]:
    try:
        check_response(response)
    except WorkbenchError as error:
        yield str(error)
    missing = [name for name in (*_SIGNATURE, "wall_time") if name not in response.attrs]
    if missing:
        yield "the response does not carry " + ", ".join(missing)
        return
    if response.attrs["model"] != model.name or response.attrs["model_version"] != model.version:
        yield "the response names another model or version"
    if response.attrs["scenario_hash"] != scenario_hash(scenario):
        yield "the response names another scenario, or the model has changed it"
    if outcome_of(response) is not Outcome.OK:
        if len(response.attrs["message"].split()) < 4:
            yield f"outcome {outcome_of(response)} comes without a sentence"
        if len(response.data_vars):
            yield f"outcome {outcome_of(response)} comes with variables"
        if outcome_of(response) is Outcome.COLLAPSE and "collapse" not in response.attrs:
            yield "outcome collapse comes without its mechanism"
    elif not response.data_vars:
        yield "outcome ok comes without a single variable"
    elsewhere = not type(model).__module__.startswith("workbench.")
    in_time = {"displacement", "time"} <= set(response.variables)
    if elsewhere and in_time and "peak_displacement" not in response:
        yield "displacement is largest at the end of its record, which so shows no peak: run longer"
    if {"displacement", "peak_displacement"} <= set(response.data_vars):
        moved, peak = response["displacement"].values, response["peak_displacement"].item()
        largest = moved[np.argmax(np.abs(moved))]
        off = max(abs(abs(peak) - abs(largest)), np.abs(moved - peak).min())
        if off > 0.02 * abs(largest):
            yield f"peak_displacement {peak:.6g} m is not that of its history, {largest:.6g} m"


def _ledger(response: Response, tolerance: float) -> Iterator[str]:
    """Whether the energies add up and whether what is lost stays lost."""
    if "balance_error" not in response:
        return
    if "input_energy" not in response:
        yield "carries balance_error without input_energy"
        return
    allowed = tolerance * response["input_energy"].item()
    error = float(np.abs(response["balance_error"]).max())
    if error > allowed:
        yield f"energy ledger is open by {error:.3g} J, {allowed:.3g} J are allowed"
    for name in ("dissipated", "contact_loss"):
        if name in response and float(np.min(np.diff(response[name].values))) < -allowed:
            yield f"{name} decreases"
    other = "contact_loss" if "crushing" in response else "crushing"  # a striker costs one of them
    parts = [name for name in ENERGIES if name not in ("external_work", other)]
    if {*parts, "external_work"} <= set(response.data_vars):
        total = sum(response[name] for name in parts) - response["external_work"]
        drift = float(total.max() - total.min())
        if drift > 1e-9 * response["input_energy"].item():
            yield f"balance_error is not what the energies leave: the sum drifts by {drift:.3g} J"


def _foreign(model: Model, scenario: Scenario) -> Iterator[str]:
    """A scenario of an unknown kind must end in out-of-domain, not in an exception."""
    kind = type("Foreign", (type(scenario),), {"KIND": "no-such-kind"})
    stranger: Any = object.__new__(kind)
    stranger.__dict__.update(scenario.__dict__)
    try:
        response = model.simulate(stranger)
    except Exception as error:
        yield f"a foreign kind of scenario raises {type(error).__name__}: {error}"
        return
    if outcome_of(response) is not Outcome.OUT_OF_DOMAIN:
        yield f"a foreign kind of scenario ends in {outcome_of(response)}, not out-of-domain"


def _numbers(response: Response) -> Response:
    return response.drop_attrs(deep=False).assign_attrs(
        {name: value for name, value in response.attrs.items() if name not in TIMES}
    )
