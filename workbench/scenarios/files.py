"""Scenarios as TOML: reading, overriding single values, canonical writing, hashing."""

from __future__ import annotations

import dataclasses
import hashlib
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import tomli_w

from workbench.errors import InputError
from workbench.fields import Choice, check_keys
from workbench.materials import Steel
from workbench.scenarios.column import Column, ColumnImpact, ColumnPushover, Striker
from workbench.sections import Section, section_from

Scenario = ColumnPushover | ColumnImpact

_TABLES: dict[str, tuple[str, ...]] = {
    ColumnPushover.KIND: ("column", "steel", "pushover"),
    ColumnImpact.KIND: ("column", "steel", "striker", "time"),
}


def load_scenario(path: Path | str, overrides: Iterable[str] = ()) -> Scenario:
    """Read a scenario file, with ``key.path=value`` overrides applied before it is checked.

    Raises `InputError` naming the key, its value and what is allowed.
    """
    file = Path(path)
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not a UTF-8 text file"
        raise InputError("scenario file", str(path), f"cannot be read: {reason}") from error
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(
            "scenario file", str(path), f"is not valid TOML: {error}", "correct that line"
        ) from error
    for override in overrides:
        apply_override(tables, override)
    return scenario_from(tables)


def apply_override(tables: dict[str, Any], override: str) -> None:
    """Set one value in a nested table from ``key.path=value`` (value as TOML, else text)."""
    path, equals, text = override.partition("=")
    keys = [key.strip() for key in path.split(".")]
    if not equals or not all(keys):
        raise InputError("--set", override, "must look like column.axial_load=2e5")
    target = tables
    for key in keys[:-1]:
        target = target.setdefault(key, {})
        if not isinstance(target, dict):
            raise InputError("--set", override, f"{key} is a value, not a table")
    target[keys[-1]] = parse_value(text.strip())


def parse_value(text: str) -> Any:
    """A TOML value, or the text itself if it is not one (so that quotes may be left out)."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        pass
    try:
        return float(text)  # .5 and 1. are not TOML, but are meant as numbers
    except ValueError:
        return text


def scenario_from(tables: Mapping[str, Any]) -> Scenario:
    """Build a scenario from nested tables as TOML gives them. Raises `InputError`."""
    if "kind" not in tables:
        raise InputError("kind", None, "is missing", "write one of " + ", ".join(_TABLES))
    kind = Choice(tuple(_TABLES)).check("kind", tables["kind"])
    check_keys(list(tables), ("kind", "name", *_TABLES[kind]), "")
    name = tables.get("name", kind)
    column = _column_from(_table(tables, "column"), _table(tables, "steel", optional=True))
    if kind == ColumnPushover.KIND:
        push = _table(tables, "pushover", optional=True)
        check_keys(list(push), ("displacement",), "pushover")
        return ColumnPushover(name, column=column, **push)
    time = _table(tables, "time", optional=True)
    check_keys(list(time), ("duration",), "time")
    striker = _build(Striker, _table(tables, "striker"), "striker")
    return ColumnImpact(name, column=column, striker=striker, **time)


def to_tables(scenario: Scenario) -> dict[str, Any]:
    """The scenario as nested tables in canonical order, defaults written out."""
    column = _fields_of(scenario.column)
    column["section"] = scenario.column.section.to_toml()
    tables: dict[str, Any] = {"kind": scenario.KIND, "name": scenario.name}
    tables["column"] = column
    tables["steel"] = _fields_of(scenario.column.steel)
    if isinstance(scenario, ColumnImpact):
        tables["striker"] = _fields_of(scenario.striker)
        tables["time"] = {"duration": scenario.duration}
    else:
        tables["pushover"] = {"displacement": scenario.displacement}
    return tables


def to_toml(scenario: Scenario) -> str:
    """The canonical TOML text of a scenario; reading it back gives an equal scenario."""
    return canonical(scenario)[0]


def scenario_hash(scenario: Scenario) -> str:
    """SHA-256 of what happens (the name left out), as 16 hexadecimal digits."""
    return canonical(scenario)[1]


def canonical(scenario: Scenario) -> tuple[str, str]:
    """The canonical TOML text of a scenario and the hash of what happens in it."""
    tables = to_tables(scenario)
    head = {"kind": tables.pop("kind"), "name": tables.pop("name")}
    body = tomli_w.dumps(tables)
    digest = hashlib.sha256(f"{head['kind']}\n{body}".encode()).hexdigest()[:16]
    return f"{tomli_w.dumps(head)}\n{body}", digest


def _fields_of(instance: Any) -> dict[str, Any]:
    pairs = ((f.name, getattr(instance, f.name)) for f in dataclasses.fields(instance))
    return {
        name: value
        for name, value in pairs
        if value is not None and not isinstance(value, (Section, Steel))
    }


def _table(tables: Mapping[str, Any], name: str, optional: bool = False) -> dict[str, Any]:
    if name not in tables:
        if optional:
            return {}
        raise InputError(name, None, f"the table [{name}] is missing", f"add [{name}]")
    table = tables[name]
    if not isinstance(table, dict):
        raise InputError(name, table, f"must be a table [{name}]")
    return dict(table)


def _build(kind: Any, table: dict[str, Any], path: str) -> Any:
    fields = dataclasses.fields(kind)
    check_keys(list(table), [f.name for f in fields], path)
    for field in fields:
        if field.default is dataclasses.MISSING and field.name not in table:
            raise InputError(f"{path}.{field.name}", None, "is missing", "add the key")
    return kind(**table)


def _column_from(table: dict[str, Any], steel: dict[str, Any]) -> Column:
    if "steel" in table:
        raise InputError("column.steel", table["steel"], "is a table of its own", "use [steel]")
    if "section" in table:
        table["section"] = section_from(table["section"], "column.section")
    table["steel"] = _build(Steel, steel, "steel")
    column: Column = _build(Column, table, "column")
    return column
