"""A stored study: its manifest, what has to be answered (again) and why, all as one tree."""

import json
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

import xarray as xr

from workbench.base.codec import label_of
from workbench.base.errors import InputError, WorkbenchError
from workbench.models.base import options_of
from workbench.responses import Outcome, provenance
from workbench.scenarios import scenario_hash, to_toml
from workbench.study.cells import Cell, cells_of, key_of
from workbench.study.definition import Study
from workbench.study.store import Ingredients, Store, canonical_json, write_atomically

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


class State(StrEnum):
    """Where a cell stands."""

    DONE = "done"
    FAILED = "failed"
    TO_DO = "to do"


@dataclass(frozen=True)
class CellStatus:
    """Where a cell stands, with the `outcome` of a stored one and the `reason` to answer it."""

    cell: Cell
    state: State
    outcome: str = ""
    reason: str = ""


def survey(study: Study, cells: list[Cell], store: Store) -> list[CellStatus]:
    """Where every cell stands, and why those to do would be answered (again)."""
    answered = _last_answers(read_manifest(store), store)

    def status(cell: Cell) -> CellStatus:
        if (answer := store.answer(cell.key, cell.ingredients)) is not None:
            outcome = Outcome(answer[0]["outcome"])
            return CellStatus(cell, State.DONE if outcome.is_answer else State.FAILED, outcome)
        reason = "the stored cell is corrupt: its file, its record and what is asked disagree"
        if not store.holds(cell.key):
            reason = _reason(cell, answered.get((cell.case, cell.label)), store)
        return CellStatus(cell, State.TO_DO, reason=reason)

    return [status(cell) for cell in cells]


def as_answered(cells: list[Cell], store: Store) -> list[Cell]:
    """Cells as they were last answered, where only the version of the model is another now."""
    answered = _last_answers(read_manifest(store), store)

    def earlier(cell: Cell) -> Cell:
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


def write_manifest(study: Study, cells: list[Cell], store: Store, *, runs: bool) -> None:
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


def _reason(cell: Cell, last: Ingredients | None, store: Store) -> str:
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


def _scenario_changes(cell: Cell, last: Ingredients, store: Store) -> Iterator[str]:
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
