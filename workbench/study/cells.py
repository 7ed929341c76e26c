"""Cells of a study: one scenario answered by one model, and the key that identifies the answer.

**Second part.** A worker answers a cell: it never fails, and hands back bytes and a record.

**Third part.** A stored study: its manifest, what has to be answered (again) and why, all as one
tree.
"""

import fnmatch
import hashlib
import json
import pickle
import time
import tomllib
import traceback
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from enum import StrEnum
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import xarray as xr
from numba.core.event import install_timer
from threadpoolctl import threadpool_limits

from workbench.base.codec import label_of
from workbench.base.compiled import TIMED_AGAIN_BELOW
from workbench.base.errors import InputError, WorkbenchError, message_of
from workbench.models.base import Model, options_of, signature
from workbench.responses import Outcome, Response, failed_response, outcome_of
from workbench.responses.build import provenance
from workbench.responses.histories import TABLE_DIGEST, TIMES, VOLATILE
from workbench.responses.uncertainty import check_stored
from workbench.scenarios import Scenario, scenario_hash, to_toml
from workbench.study.definition import Study
from workbench.study.error_model.error_model import advised
from workbench.study.store import (
    Ingredients,
    Store,
    canonical_json,
    to_netcdf_bytes,
    write_atomically,
)

STORE_FORMAT = 3


@dataclass(frozen=True)
class StudyCell:
    """A case answered by a label.

    Arguments: `case` and `label`, names in the study; `scenario` and `model`; `ingredients`,
    everything that the answer depends on; `key`, their hash, under which the answer is stored.
    """

    case: str
    label: str
    scenario: Scenario
    model: Model
    ingredients: Ingredients
    key: str

    @property
    def name(self) -> str:
        """``case/label``, as patterns and messages use it."""
        return f"{self.case}/{self.label}"

    @property
    def version(self) -> int:
        """Version of the model that answers, or has answered."""
        return int(self.ingredients["model_version"])


def ingredients_of(scenario: Scenario, model: Model) -> dict[str, Any]:
    """Everything that an answer depends on: scenario, model, options, data, versions.

    A model whose answer rests on data files says so by an attribute `data_digest`, a kind of
    scenario whose histories all models read in another way than once, by `READING`.
    Raises `InputError` for options that JSON cannot hold.
    """
    options = options_of(model)
    try:
        options = json.loads(json.dumps(options, sort_keys=True, allow_nan=False))
    except (TypeError, ValueError) as error:
        text = f"of {model.name} cannot be stored: {error}"
        raise InputError("model options", options, text) from error
    reading = getattr(scenario, "READING", 0)
    return {
        **({"reading": reading} if reading else {}),
        "scenario": scenario_hash(scenario),
        "model": model.name,
        "model_version": model.version,
        "options": options,
        "data": str(getattr(model, "data_digest", "")),
        "package": provenance()["workbench"],
        "store_format": STORE_FORMAT,
        "variables": TABLE_DIGEST,
    }


def key_of(ingredients: Ingredients) -> str:
    """SHA-256 of the ingredients in canonical form, as 20 hexadecimal digits."""
    text = json.dumps(ingredients, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:20]


def cells_of(study: Study) -> list[StudyCell]:
    """All cells of a study, each checked so that no run begins that cannot end.

    Raises `InputError` for models that do not keep the contract, for options that cannot be stored
    or models that cannot be sent to a worker process and for a study without cells.
    """
    for label, model in study.models.items():
        field = f"study.models[{label!r}]"
        if isinstance(model, type) or not isinstance(model, Model):
            text, advice = "must be a model object", "see workbench.models.base.Model"
            raise InputError(field, model, text, advice)
        try:
            pickle.dumps(model)
        except Exception as error:
            text = f"cannot be sent to a worker process: {error}"
            advice = "define its class at the top of a module"
            raise InputError(field, type(model).__name__, text, advice) from error
    cells = []
    triples = [(case, label, study.models[label]) for case, label in study.cells()]
    for case, label, model in [*triples, *study.varied_cells()]:
        ingredients = ingredients_of(case.scenario, model)
        cells.append(
            StudyCell(case.name, label, case.scenario, model, ingredients, key_of(ingredients))
        )
    if not cells:
        raise InputError("study", study.name, "has no cell: no model answers any of its cases")
    return cells


def select(cells: list[StudyCell], pattern: str | None) -> list[StudyCell]:
    """Cells whose case, label or ``case/label`` matches a shell pattern (None: all).

    Raises `InputError` if nothing matches.
    """
    if pattern is None:
        return cells
    chosen = [
        cell
        for cell in cells
        if any(fnmatch.fnmatchcase(name, pattern) for name in (cell.case, cell.label, cell.name))
    ]
    if not chosen:
        shown = ", ".join(dict.fromkeys([c.case for c in cells] + [c.label for c in cells]))
        raise InputError("--only", pattern, f"matches no cell; cases and labels are {shown}")
    return chosen


# A single call of a few milliseconds measures cold caches: quick cells give a median of calls.
TIMED_OFTEN_BELOW, FURTHER_CALLS = 0.1, 4  # s
READ_BELOW = 5.0  # s; of longer ones, what it takes to read kernels from the disk is nothing
TIMED_WITHIN = 0.02  # of a time, what may be compilation


@dataclass(frozen=True)
class Task:
    """A cell on its way to a worker: `payload` is its pickled model and scenario.

    `limit` is the wall time allowed in s, or None; `file` the study file that defines models.
    """

    key: str
    payload: bytes
    limit: float | None = None
    file: str = ""


@dataclass(frozen=True)
class Result:
    """A cell answered: netCDF bytes and the record of how they came about."""

    key: str
    content: bytes
    record: dict[str, Any]

    @property
    def outcome(self) -> Outcome:
        """How the cell ended."""
        return Outcome(self.record["outcome"])


def task_of(cell: StudyCell, limit: float | None = None, file: Path | None = None) -> Task:
    """The task that answers a cell."""
    payload = pickle.dumps((cell.model, cell.scenario))
    return Task(cell.key, payload, limit, "" if file is None else str(file))


def perform(task: Task, warm: set[str], answered: Callable[[], None] = lambda: None) -> Result:
    """Answer a task in this process, with one numerical thread. It never fails.

    Arguments: `warm` collects the kinds of cell that this process has answered before. The time
    limit is that of the model, and judged here for executors that cannot stop a cell; `answered` is
    called at its end, before the advice, for which the anchor may have to run.
    """
    begin = time.perf_counter()
    with threadpool_limits(1):
        model, scenario = _unpacked(task)
        started = datetime.now(UTC)
        response, record = _performed(task, warm, model, scenario)
        seconds = time.perf_counter() - begin
        if is_late(task, seconds):
            return timed_out(task, seconds)
        answered()
        if "trace" not in record:
            advice = partial(advised, model, scenario, response)
            response, trace = _guarded(model, scenario, advice)
            record |= {"trace": trace} if trace else {}
        return _result(task, response, record, started)


def _performed(
    task: Task, warm: set[str], model: Model, scenario: Scenario
) -> tuple[Response, dict[str, Any]]:
    """The first of a kind may compile or read kernels: then a second call gives its time."""
    begin = time.perf_counter()
    with install_timer("numba:compile", lambda _: None) as compiling:
        response, trace = _answer(model, scenario)
    first = time.perf_counter() - begin
    kind = f"{type(model).__module__}.{type(model).__qualname__}/{scenario.KIND}"
    compiled = compiling.duration if compiling.done else 0.0
    again = kind not in warm and (first < READ_BELOW or compiled > TIMED_WITHIN * first)
    cold = again and first >= min(TIMED_AGAIN_BELOW, (task.limit or 1e9) / 3.0)
    timed = _answer(model, scenario)[0] if again and not cold else response
    warm.add(kind)
    runs = [timed]
    allowed = min(TIMED_OFTEN_BELOW, (task.limit or 1e9) / (3.0 + FURTHER_CALLS))
    if timed.attrs.get("wall_time", first) < allowed:
        runs += [_answer(model, scenario)[0] for _ in range(FURTHER_CALLS)]
    record: dict[str, Any] = {"wall_time": first, "first_call": first}
    for name in TIMES:
        measured = [run.attrs[name] for run in runs if name in run.attrs]
        if measured:
            record[name] = median(measured)
    record |= {"cold": True} if cold else {}  # its times may hold compilation
    record |= {"trace": trace} if trace else {}
    return response, record


def unanswered(task: Task, outcome: Outcome, message: str, seconds: float) -> Result:
    """The result of a task whose worker was stopped or died after so many `seconds`."""
    model, scenario = pickle.loads(task.payload)
    response = _signed(failed_response(outcome, message), model, scenario)
    record = {"wall_time": seconds, "first_call": seconds}
    return _result(task, response, record, datetime.now(UTC))


def is_late(task: Task, seconds: float) -> bool:
    """Whether a task has taken longer than it may."""
    return task.limit is not None and seconds > task.limit


def timed_out(task: Task, seconds: float) -> Result:
    """The result of a task that took longer than it may."""
    message = f"stopped after the {task.limit:g} s that a cell may take"
    return unanswered(task, Outcome.TIMED_OUT, message, seconds)


def _result(task: Task, response: Response, record: dict[str, Any], started: datetime) -> Result:
    """Bytes and record of a response: what repeats in the bytes, what does not in the record."""
    record |= {
        "outcome": outcome_of(response).value,
        "limit": task.limit,
        "provenance": provenance(),
        "started": started.isoformat(timespec="milliseconds"),
        "finished": datetime.now(UTC).isoformat(timespec="milliseconds"),
    }
    lasting = {name: value for name, value in response.attrs.items() if name not in VOLATILE}
    content = to_netcdf_bytes(response.drop_attrs(deep=False).assign_attrs(lasting))
    return Result(task.key, content, record)


def _unpacked(task: Task) -> tuple[Model, Scenario]:
    """Model and scenario of a task; the study file is loaded only if they need it."""
    try:
        pair: tuple[Model, Scenario] = pickle.loads(task.payload)
    except (ImportError, AttributeError):
        if not task.file:
            raise
        from workbench.study.store import study_in

        study_in(Path(task.file))
        pair = pickle.loads(task.payload)
    return pair


def _answer(model: Model, scenario: Scenario) -> tuple[Response, list[str]]:
    return _guarded(model, scenario, partial(model.simulate, scenario))


def _guarded(
    model: Model, scenario: Scenario, make: Callable[[], Response]
) -> tuple[Response, list[str]]:
    """The response that `make` gives, or that it failed, with the trace of a crash."""
    trace: list[str] = []
    try:
        response = make()
        check_stored(_signed(response, model, scenario))
    except InputError as error:
        response = failed_response(Outcome.INVALID_INPUT, str(error))
    except Exception as error:
        response = failed_response(Outcome.CRASHED, f"{model.name} raised {message_of(error)}")
        # file names without directories: records are compared between machines
        trace = [
            f"{Path(frame.filename).name}:{frame.lineno} in {frame.name}"
            for frame in traceback.extract_tb(error.__traceback__)
        ]
    return _signed(response, model, scenario), trace


def _signed(response: Response, model: Model, scenario: Scenario) -> Response:
    """Name model and scenario in a response that did not come through `respond`."""
    for name, value in signature(model, scenario).items():
        response.attrs.setdefault(name, value)
    return response


Manifest = dict[str, Any]

_DESCRIBED = ("title", "question", "reference", "ladder", "quantities")
_CHANGES = {
    "model": "another model",
    "model_version": "model version",
    "options": "option",
    "data": "the data have changed",
    "package": "workbench version",
    "store_format": "format of the store",
    "reading": "other quantities are read off histories",
    "variables": "the table of response variables has changed",
}


class CellProgress(StrEnum):
    """Where a cell stands."""

    DONE = "done"
    FAILED = "failed"
    TO_DO = "to do"


@dataclass(frozen=True)
class CellStatus:
    """Where a cell stands, with the `outcome` of a stored one and the `reason` to answer it."""

    cell: StudyCell
    state: CellProgress
    outcome: str = ""
    reason: str = ""


def survey(study: Study, cells: list[StudyCell], store: Store) -> list[CellStatus]:
    """Where every cell stands, and why those to do would be answered (again)."""
    answered = _last_answers(read_manifest(store), store)

    def status(cell: StudyCell) -> CellStatus:
        if (answer := store.answer(cell.key, cell.ingredients)) is not None:
            outcome = Outcome(answer[0]["outcome"])
            return CellStatus(
                cell, CellProgress.DONE if outcome.is_answer else CellProgress.FAILED, outcome
            )
        reason = "the stored cell is corrupt: its file, its record and what is asked disagree"
        if not store.holds(cell.key):
            reason = _reason(cell, answered.get((cell.case, cell.label)), store)
        return CellStatus(cell, CellProgress.TO_DO, reason=reason)

    return [status(cell) for cell in cells]


def as_answered(cells: list[StudyCell], store: Store) -> list[StudyCell]:
    """Cells as they were last answered, where only the version of the model is another now."""
    answered = _last_answers(read_manifest(store), store)

    def earlier(cell: StudyCell) -> StudyCell:
        last = answered.get((cell.case, cell.label), cell.ingredients)
        version = cell.ingredients["model_version"]
        if store.holds(cell.key) or {**last, "model_version": version} != cell.ingredients:
            return cell
        return replace(cell, ingredients=last, key=key_of(last))

    return [earlier(cell) for cell in cells]


def read_manifest(store: Store) -> Manifest:
    """The manifest of a store, empty if there is none yet.

    Raises `InputError` if it cannot be read.
    """
    if not store.manifest.is_file():
        return {}
    try:
        manifest: Manifest = json.loads(store.manifest.read_text(encoding="utf-8"))
        for entry in manifest["cells"]:
            whose = [entry["case"], entry["label"], entry["key"]]
            made_of = [entry["ingredients"], entry.get("answered") or {}]
            if not all(isinstance(name, str) for name in whose):
                raise TypeError("a cell without a name")
            if not all(isinstance(each, dict) for each in made_of):
                raise TypeError("a cell of unknown origin")
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        where, advice = str(store.manifest), "remove it and run again"
        raise InputError("manifest", where, "cannot be read", advice) from error
    return manifest


def write_manifest(study: Study, cells: list[StudyCell], store: Store, *, runs: bool) -> None:
    """Write what the study is made of, in canonical form, and who `runs` it, if anyone does.

    A cell that is not stored keeps under ``answered`` what its last stored answer was made of.
    """
    before = read_manifest(store)
    answered = _last_answers(before, store)
    entries = []
    for cell in cells:
        entry = {name: getattr(cell, name) for name in ("case", "label", "key", "ingredients")}
        last = answered.get((cell.case, cell.label))
        if not store.holds(cell.key) and last is not None:
            entry["answered"] = last
        entries.append(entry)
    manifest = {**_description(study), "cells": entries}
    manifest["provenance"] = (not runs and before.get("provenance")) or provenance()
    write_atomically(store.manifest, canonical_json(manifest))


def _description(study: Study) -> Manifest:
    return {
        "study": study.name,
        **{name: getattr(study, name) for name in _DESCRIBED},
        "cases": [
            {
                "name": case.name,
                "kind": case.scenario.KIND,
                "scenario": to_toml(case.scenario),
                "scenario_hash": scenario_hash(case.scenario),
                "parameters": dict(case.parameters),
                "figure": case.figure,
            }
            for case in study.cases
        ],
        "labels": {
            label: {
                "model": model.name,
                "version": model.version,
                "options": options_of(model),
                "assumptions": model.assumptions,
                "sources": model.sources,
            }
            for label, model in study.models.items()
        },
    }


def _last_answers(manifest: Manifest, store: Store) -> dict[tuple[str, str], Ingredients]:
    """Ingredients of the last stored answer of every (case, label)."""
    answers = {}
    for entry in manifest.get("cells", ()):
        # the manifest is written before the cells: look whether the cell came to be stored
        last = entry["ingredients"] if store.holds(entry["key"]) else entry.get("answered")
        if last is not None:
            answers[entry["case"], entry["label"]] = last
    return answers


def _reason(cell: StudyCell, last: Ingredients | None, store: Store) -> str:
    if last is None:
        return "never ran"
    now = cell.ingredients
    if dict(last) == dict(now):
        return "its stored cell has been removed"
    reasons = list(_scenario_changes(cell, last, store))
    for name, text in _CHANGES.items():
        before, after = last.get(name), now.get(name)
        if name == "options" and isinstance(before, dict):
            reasons.extend(_changes(before, now[name], f"{text} "))
        elif before != after:
            reasons.append(
                text if name in ("data", "reading", "variables") else f"{text} {before} -> {after}"
            )
    return "; ".join(reasons)


def _scenario_changes(cell: StudyCell, last: Ingredients, store: Store) -> Iterator[str]:
    if last.get("scenario") == cell.ingredients["scenario"]:
        return
    try:
        before = tomllib.loads(store.response(key_of(last)).attrs["scenario"])
    except (WorkbenchError, KeyError, ValueError):  # the old cell is gone
        yield "scenario changed"
        return
    after = tomllib.loads(to_toml(cell.scenario))
    before["name"] = after["name"]
    yield "scenario changed: " + ", ".join(_changes(before, after))


def differences(
    before: Mapping[str, Any], after: Mapping[str, Any], path: str = ""
) -> Iterator[tuple[str, Any, Any]]:
    """Path, old and new value of every entry in which two trees of tables differ.

    Tables in a list go by their names; an entry that one side lacks is None there.
    """
    for name in dict.fromkeys([*before, *after]):
        old, new = _by_name(before.get(name)), _by_name(after.get(name))
        if old == new:
            continue
        if all(value is None or isinstance(value, dict) for value in (old, new)):
            yield from differences(old or {}, new or {}, f"{path}{name}.")
        else:
            yield f"{path}{name}", old, new


def _by_name(value: Any) -> Any:
    if isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value):
        return {label_of(entry, number): entry for number, entry in enumerate(value)}
    return value


def _changes(before: Mapping[str, Any], after: Mapping[str, Any], head: str = "") -> list[str]:
    changes = []
    for path, *values in differences(before, after):
        old, new = ("default" if value is None else value for value in values)
        changes.append(f"{head}{path} {old} -> {new}")
    return changes


def gather(study: Study, root: Path) -> xr.DataTree:
    """The stored responses of a study as ``tree["case/label"]``.

    A slash within a case or label, as in "10 m/s", becomes an underscore there.
    Arguments: `study`; `root`, the directory of all stores. The attributes of the tree hold the
    `study` name, the `manifest` (JSON) and the `missing` cells (JSON list), which are absent;
    every cell has the attributes `wall_time` (s) and `provenance` (JSON) of its record.
    """
    store = Store(Path(root) / study.name)
    tree = xr.DataTree(name=study.name)
    missing = []
    for cell in cells_of(study):
        if (answer := store.answer(cell.key, cell.ingredients)) is None:
            missing.append(cell.name)
            continue
        record, response = answer
        response.attrs["wall_time"] = record["wall_time"]
        response.attrs["provenance"] = json.dumps(record["provenance"], sort_keys=True)
        path = "/".join(name.replace("/", "_") for name in (cell.case, cell.label))
        tree[path] = xr.DataTree(response)
    tree.attrs["study"] = study.name
    tree.attrs["manifest"] = json.dumps(read_manifest(store), sort_keys=True)
    tree.attrs["missing"] = json.dumps(missing)
    return tree
