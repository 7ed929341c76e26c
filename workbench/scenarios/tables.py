"""Nested tables, as TOML gives them, to and from the fields of value objects."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from workbench.errors import InputError
from workbench.fields import check_keys
from workbench.materials import Steel
from workbench.sections import Section


def fields_of(instance: Any, defaults: bool = True) -> dict[str, Any]:
    """Fields of a value object that TOML can say, without sections, steels and None.

    Those at their default are left out unless `defaults`.
    """
    return {
        field.name: value
        for field in dataclasses.fields(instance)
        if (value := getattr(instance, field.name)) is not None
        and not isinstance(value, (Section, Steel))
        and (defaults or value != field.default)
    }


def table_in(tables: Mapping[str, Any], name: str, optional: bool = False) -> dict[str, Any]:
    """A copy of the table of this name; empty if it may be missing. Raises `InputError`."""
    if name not in tables:
        if optional:
            return {}
        raise InputError(name, None, f"the table [{name}] is missing", f"add [{name}]")
    table = tables[name]
    if not isinstance(table, dict):
        raise InputError(name, table, f"must be a table [{name}]")
    return dict(table)


def entries_in(tables: Mapping[str, Any], name: str) -> list[dict[str, Any]]:
    """Copies of the entries of an array of tables; none if it is missing. Raises `InputError`."""
    entries = tables.get(name, [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise InputError(name, entries, f"must be tables [[{name}]]")
    return [dict(entry) for entry in entries]


def label_of(entry: Mapping[str, Any], number: int) -> str:
    """What an entry of an array of tables is called: by its name, its node, or its number."""
    return str(entry.get("name", entry.get("node", number)))


def build(kind: Any, table: dict[str, Any], path: str) -> Any:
    """A value object of this class from its table. Raises `InputError`."""
    fields = dataclasses.fields(kind)
    check_keys(list(table), [f.name for f in fields], path)
    for field in fields:
        if field.default is dataclasses.MISSING and field.name not in table:
            raise InputError(f"{path}.{field.name}", None, "is missing", "add the key")
    return kind(**table)
