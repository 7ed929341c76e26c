"""The contract of a model, and the one path by which every model answers a scenario.

**Second part.** Models by name: what the installed distributions offer under ``workbench.models``.
"""

import dataclasses
import json
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.metadata import EntryPoint
from itertools import filterfalse
from math import degrees
from operator import attrgetter
from typing import Any, ClassVar, Protocol, TypeVar, runtime_checkable

import numpy as np

from workbench.base.errors import CollapseError, InputError, OutOfDomainError, SolverError
from workbench.base.fields import Declared, check_keys, did_you_mean
from workbench.base.offered import offered
from workbench.mechanics.frames.elastic import linear_algebra
from workbench.models.domain import (
    ECCENTRIC,
    EDGE,
    eccentric_finding,
    factor_values,
    implausible,
    oblique_findings,
    unused_inputs,
)
from workbench.models.strain_rate import with_strain_rate
from workbench.responses import (
    VARIABLES,
    Finding,
    Outcome,
    Response,
    check_response,
    collapsed_response,
    failed_response,
    finding,
    findings_of,
    outcome_of,
    refused_response,
    set_findings,
    survives,
)
from workbench.responses.build import provenance
from workbench.scenarios import Scenario, Striker, canonical
from workbench.scenarios.column import DURATION

M = TypeVar("M")
LONGER = 4  # doublings of a record that ends before its peak


@runtime_checkable
class Model(Protocol):
    """Answers a scenario with a response; a frozen dataclass whose fields are its options.

    `name` and `version` (raised when its numbers change) identify it; `answers` lists scenario
    kinds; `assumptions` are sentences. A model that knows strain rate or hardening by itself has a
    `material` that names them; others run with `with_strain_rate`. Optional: `crushing`, whether it
    answers strikers that crush; `spatial`, whether those that hit off the plane of bending;
    `eccentric`, whether those that hit beside the shear centre;
    `unused`, see `unused_inputs`; for many, see `models.batch`.
    """

    name: ClassVar[str]
    version: ClassVar[int]
    answers: ClassVar[tuple[str, ...]]
    assumptions: ClassVar[tuple[str, ...]]

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the model or of its data."""
        ...

    def domain(self, scenario: Any) -> list[Finding]:
        """Where a scenario of a kind that it answers lies outside the model's assumptions."""
        ...

    def simulate(self, scenario: Scenario) -> Response:
        """Answer the scenario; a failure is a response with its outcome."""
        ...


def respond(model: Model, scenario: Any, solve: Callable[[Any], Response]) -> Response:
    """Run `solve` inside the contract: domain check, typed outcomes, provenance, wall time.

    A model's `simulate` calls this with its own solution method. Refusals, collapse, failed
    convergence and states outside the domain come back as responses with that outcome, not as
    exceptions.
    """
    with linear_algebra().limit(limits=1):
        started = time.perf_counter()
        solved, factor = scenario, 1.0
        if scenario.KIND in model.answers:
            solved, factor, left_out = with_strain_rate(model, scenario)
            findings = findings_before(model, scenario, left_out)
        else:
            kinds = ", ".join(model.answers)
            findings = [finding("kind", name=model.name, answers=kinds, kind=scenario.KIND)]
        warnings = list(filterfalse(attrgetter("refusal"), findings))
        striker = getattr(scenario, "striker", None)
        if len(warnings) < len(findings):
            response = refused_response([each for each in findings if each.refusal])
        else:
            try:
                response = solve(solved)
                if striker is not None and striker.crushes:
                    response = crushed(response, striker)
                if ECCENTRIC in map(attrgetter("subject"), warnings):
                    for name, value in factor_values(scenario, EDGE).items():
                        response[name] = ((), value, VARIABLES[name].attributes)
                check_response(response)
            except CollapseError as error:
                response = collapsed_response(error)
            except SolverError as error:
                response = failed_response(Outcome.NOT_CONVERGED, str(error))
            except OutOfDomainError as error:
                known = isinstance(error.args[0], Finding)
                refusal = error.args[0] if known else Finding("domain", str(error), refusal=True)
                response = refused_response([refusal])
        if warnings:
            set_findings(response, [*warnings, *findings_of(response)])
        if factor != 1.0:
            response.attrs["rate_factor"] = factor
        seconds = time.perf_counter() - started
        response.attrs.update(
            **signature(model, scenario), provenance=_provenance(), wall_time=seconds
        )
        return response


def findings_before(model: Model, scenario: Any, left_out: Sequence[Finding]) -> list[Finding]:
    """Findings about a model in a scenario before it answers: its domain, odd input, its striker.

    With what it has `left_out` of the steel, see `with_strain_rate`.
    """
    in_space = hasattr(scenario, "frame") and is_oblique(scenario)
    if in_space and not getattr(model, "spatial", False):
        return [finding("space-frame", name=model.name)]
    findings = [*model.domain(scenario), *implausible(scenario), *unused_inputs(model, scenario)]
    findings += left_out
    striker = getattr(scenario, "striker", None)
    if striker is None:
        return findings
    findings += striker_findings(model, scenario)
    plain = getattr(model, "eccentric", False) or not getattr(model, "spatial", False)
    return findings if plain else findings + oblique_findings(scenario)


def striker_findings(model: Any, scenario: Any) -> list[Finding]:
    """Findings on the striker of a scenario, or of a stack of them.

    Refusals of one that crushes, or hits off the plane or the axis, unknown to the model; notes,
    with which it answers, where that changes nothing, or by a factor that was measured.
    """
    findings, striker = [], scenario.striker
    if striker.crushes and not getattr(model, "crushing", False):
        findings.append(finding("rigid-striker-alone", name=model.name))
    farthest = float(np.max(striker.angle))  # of a stack
    if farthest > 0.0 and not getattr(model, "spatial", False):
        name = "off-plane" if is_oblique(scenario) else "round"
        findings.append(finding(name, degrees(farthest), name=model.name))
    beside = float(np.max(np.abs(striker.eccentricity)))
    if beside > 0.0 and not getattr(model, "eccentric", False):
        findings.append(eccentric_finding(model.name, scenario, beside))
    return findings


def is_oblique(scenario: Any) -> bool:
    """Whether something, or one of a stack, acts off the plane of what is not alike all round."""
    column, frame = getattr(scenario, "column", None), getattr(scenario, "frame", None)
    if frame is not None and frame.spatial:
        return True
    angle = getattr(getattr(scenario, "striker", scenario), "angle", 0.0)
    return bool(np.any(angle)) and not (column is not None and column.is_round)


def crushed(response: Response, striker: Striker) -> Response:
    """The response to a striker that crushes: what the contact took is what that has cost.

    It says so where the striker was crushed past the last point of its law.
    """
    if "contact_loss" not in response:
        return response
    response = response.rename(contact_loss="crushing")
    response["crushing"].attrs = VARIABLES["crushing"].attributes
    if striker.crush is not None:
        strokes, forces = np.transpose(striker.crush)
        beyond = float(response["crushing"].max() - np.trapezoid(forces, strokes))
        last = float(strokes[-1])
        if beyond > 1e-6 * float(response["input_energy"]) and forces[-1] > 0.0:
            reached = last + beyond / float(forces[-1])
            past = finding("past-crush-law", reached, last=last)
            set_findings(response, [*findings_of(response), past])
    return response


class Answering(Declared, ABC, table="option"):
    """A model whose fields are its options, and which solves a scenario by itself with `_solve`."""

    def simulate(self, scenario: Scenario) -> Response:
        """Answer a scenario of a kind that it answers; a failure is a response with its outcome."""
        return respond(self, scenario, self._solve)  # type: ignore[arg-type]

    @abstractmethod
    def _solve(self, scenario: Any) -> Response:
        """The response to a scenario inside the domain."""


@cache
def _provenance() -> str:
    return json.dumps(provenance(), sort_keys=True)


def signature(model: Model, scenario: Scenario) -> dict[str, Any]:
    """The attributes by which a response names model and scenario."""
    toml, digest = canonical(scenario)
    return {
        "model": model.name,
        "model_version": model.version,
        "options": _options(model),  # type: ignore[arg-type]
        "scenario": toml,
        "scenario_hash": digest,
    }


@lru_cache(maxsize=256)
def _options(model: Any) -> str:
    return json.dumps(options_of(model), sort_keys=True)


def options_of(model: Model) -> dict[str, Any]:
    """The options of a model and their values."""
    return {f.name: getattr(model, f.name) for f in dataclasses.fields(model)}  # type: ignore[arg-type]


def on_one_mesh(model: M) -> M:
    """The model without the coarser meshes of a reference: the same numbers, without an error."""
    if not hasattr(model, "levels"):
        return model
    return dataclasses.replace(model, levels=1)  # type: ignore[type-var]


def ask(model: Model, scenario: Any) -> tuple[Any, Response]:
    """The answer of a model; a record that ends before its peak is made longer, where it may be.

    With the scenario, which then has this record. A reference looks for it on one mesh.
    """
    response, alone = model.simulate(scenario), on_one_mesh(model)
    first = scenario
    for _ in range(LONGER):
        longer = 2.0 * getattr(scenario, "duration", DURATION.high)
        undecided = outcome_of(response) is Outcome.OK and survives(response) is None
        if not undecided or longer > DURATION.high:
            break
        scenario = dataclasses.replace(scenario, duration=longer)
        response = alone.simulate(scenario)
    if scenario is not first and alone != model:
        response = model.simulate(scenario)
    return scenario, response


def with_options(kind: type[Any], options: Mapping[str, Any]) -> Any:
    """A model of this kind with options checked by name and value. Raises `InputError`."""
    known = [f.name for f in dataclasses.fields(kind)]
    check_keys(list(options), known, "option")
    try:
        return kind(**options)
    except TypeError as error:
        raise InputError("option", dict(options), str(error)) from error


GROUP = "models"  # of the entry points that offer models
_NEW = " (a new entry point counts once its package is installed again)"
_DECLARED = ("name", "version", "answers", "assumptions", "sources", "domain", "simulate")


@dataclass(frozen=True, slots=True)
class Offer:
    """One registered model: its `name`, its class `kind`, or the `problem` that hides it.

    Exactly one of `kind` and `problem` is set; `distribution` says who provides it.
    """

    name: str
    distribution: str
    kind: type[Any] | None
    problem: str = ""


def model_names() -> list[str]:
    """Names of all registered models, sorted; nothing is imported.

    Returns
    -------
    list of str
        Names of the workbench and of other installed packages.

    Examples
    --------
    >>> "four-dof" in wb.model_names()
    True
    """
    return sorted({point.name for point in offered(GROUP)})


def offers() -> list[Offer]:
    """Every registered model, imported; one that cannot be used carries its problem."""
    return [_offer(name) for name in model_names()]


def model_kind(name: str) -> type[Any]:
    """The class of the model `name`.

    Raises `InputError` for an unknown name (with the nearest known one) and for a model that is
    registered but cannot be imported or does not keep the contract.
    """
    known = model_names()
    if name not in known:
        near = did_you_mean(name, known)
        text = f"is not known{_NEW}; {near}".removesuffix("; ")
        raise InputError("model", name, text, "`workbench models` lists all")
    offer = _offer(name)
    if offer.kind is None:
        text = f"cannot be used: {offer.problem}"
        raise InputError("model", name, text, "see `workbench doctor`")
    return offer.kind


def make_model(name: str, options: Mapping[str, Any] | None = None) -> Model:
    """A model with its options set.

    Parameters
    ----------
    name : str
        One of `model_names`.
    options : mapping, optional
        Values by name of option, in SI units; `workbench models NAME` lists them.

    Returns
    -------
    Model
        Frozen; ``model.simulate(scenario)`` answers.

    Raises
    ------
    InputError
        For an unknown name or option and a value that is not allowed.

    Examples
    --------
    >>> wb.make_model("four-dof", {"beta": 1.3}).beta
    1.3
    """
    model: Model = with_options(model_kind(name), options or {})
    return model


def _offer(name: str) -> Offer:
    points = [point for point in offered(GROUP) if point.name == name]
    provider = ", ".join(sorted({p.dist.name if p.dist else "unknown" for p in points}))
    return Offer(name, provider, *_load(name, points))


def _load(name: str, points: list[EntryPoint]) -> tuple[type[Any] | None, str]:
    if len(points) > 1:
        targets = " and ".join(sorted(point.value for point in points))
        return None, f"several distributions provide it: {targets}"
    try:
        kind = points[0].load()
    except (Exception, SystemExit) as error:  # a third-party import may fail in any way
        return None, f"{type(error).__name__} on import: {error}"
    missing = [item for item in _DECLARED if not hasattr(kind, item)]
    if not isinstance(kind, type) or not dataclasses.is_dataclass(kind):
        return None, f"{points[0].value} is not a dataclass"
    if missing:
        return None, f"{points[0].value} declares no {', '.join(missing)}"
    if kind.name != name:  # type: ignore[attr-defined]
        return None, f"{points[0].value} calls itself {kind.name!r}"  # type: ignore[attr-defined]
    return kind, ""
