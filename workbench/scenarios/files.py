"""Scenarios as TOML: reading, overriding single values, canonical writing, hashing."""

from __future__ import annotations

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
from workbench.scenarios.frame_files import (
    FRAME_TABLES,
    FrameScenario,
    frame_scenario_from,
    frame_tables,
)
from workbench.scenarios.stud import StudTests, stud_tests_from
from workbench.scenarios.tables import build, fields_of, label_of, table_in
from workbench.sections import section_from

ColumnScenario = ColumnPushover | ColumnImpact
Scenario = ColumnScenario | FrameScenario | StudTests

_TABLES: dict[str, tuple[str, ...]] = {
    ColumnPushover.KIND: ("column", "steel", "pushover"),
    ColumnImpact.KIND: ("column", "steel", "striker", "time"),
    **FRAME_TABLES,
    StudTests.KIND: (StudTests.TABLE,),
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
    """Set one value in a nested table from ``key.path=value`` (value as TOML, else text).

    Entries of an array of tables are addressed by name, by node, or by number from 0:
    ``member.A0-A1.section=HEB 200``. Raises `InputError`.
    """
    path, equals, text = override.partition("=")
    keys = [key.strip() for key in path.split(".")]
    if not equals or not all(keys):
        raise InputError("--set", override, "must look like column.axial_load=2e5")
    target: Any = tables
    for key in keys[:-1]:
        listed = isinstance(target, list)
        target = _entry(target, key, override) if listed else target.setdefault(key, {})
        if not isinstance(target, (dict, list)):
            raise InputError("--set", override, f"{key} is a value, not a table")
    if isinstance(target, list):
        raise InputError("--set", override, f"{path.strip()} is an entry, not one of its keys")
    target[keys[-1]] = parse_value(text.strip())


def _entry(entries: list[Any], key: str, override: str) -> Any:
    """The entry that a key of an override names."""
    tables = [entry for entry in entries if isinstance(entry, dict)]
    found = [entry for number, entry in enumerate(tables) if label_of(entry, number) == key]
    if not found and key.isdecimal():
        found = tables[int(key) : int(key) + 1]
    if len(found) == 1:
        return found[0]
    how = "several entries are" if found else "no entry is"
    raise InputError("--set", override, f"{how} called {key}", "numbers from 0 name entries, too")


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
    if kind == StudTests.KIND:
        return stud_tests_from(tables)
    name = tables.get("name", kind)
    if kind in FRAME_TABLES:
        return frame_scenario_from(kind, name, tables)
    column = _column_from(table_in(tables, "column"), table_in(tables, "steel", optional=True))
    if kind == ColumnPushover.KIND:
        push = table_in(tables, "pushover", optional=True)
        check_keys(list(push), ("displacement",), "pushover")
        return ColumnPushover(name, column=column, **push)
    time = table_in(tables, "time", optional=True)
    check_keys(list(time), ("duration",), "time")
    striker = build(Striker, table_in(tables, "striker"), "striker")
    return ColumnImpact(name, column=column, striker=striker, **time)


def to_tables(scenario: Scenario) -> dict[str, Any]:
    """The scenario as nested tables in canonical order, defaults written out."""
    if isinstance(scenario, StudTests):
        return scenario.to_tables()
    if isinstance(scenario, FrameScenario):
        return frame_tables(scenario)
    column = fields_of(scenario.column)
    column["section"] = scenario.column.section.to_toml()
    tables: dict[str, Any] = {"kind": scenario.KIND, "name": scenario.name}
    tables["column"] = column
    tables["steel"] = fields_of(scenario.column.steel)
    if isinstance(scenario, ColumnImpact):
        tables["striker"] = fields_of(scenario.striker)
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


def _column_from(table: dict[str, Any], steel: dict[str, Any]) -> Column:
    if "steel" in table:
        raise InputError("column.steel", table["steel"], "is a table of its own", "use [steel]")
    if "section" in table:
        table["section"] = section_from(table["section"], "column.section")
    table["steel"] = build(Steel, steel, "steel")
    column: Column = build(Column, table, "column")
    return column
