"""Scenario files: reading, overriding single values, canonical writing, hashing."""

import hashlib
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from workbench.base.codec import Made, dumped, label_of, read, write_text
from workbench.base.datafiles import open_input
from workbench.base.errors import InputError
from workbench.base.fields import Choice
from workbench.base.offered import companion, offered
from workbench.scenarios.column import ColumnImpact, ColumnPushover
from workbench.scenarios.frame_events import FrameGroundMotion, FrameImpact, FramePulse, FrameStatic
from workbench.scenarios.frame_events import FrameScenario as FrameScenario
from workbench.scenarios.pulse import MemberPulse
from workbench.scenarios.stud_tests import StudTests

ColumnScenario = ColumnPushover | ColumnImpact | MemberPulse
Scenario = ColumnScenario | FrameScenario | StudTests

KINDS: dict[str, type[Any]] = {
    kind.KIND: kind
    for kind in (
        *(ColumnPushover, ColumnImpact, MemberPulse),
        *(FrameStatic, FrameImpact, FrameGroundMotion, FramePulse, StudTests),
    )
}
LARGEST_FILE = 5_000_000  # bytes; a record of the ground of 100 000 steps has some 1 MB
_UNREADABLE = (ValueError, RecursionError)  # too many digits for Python, brackets too deep


def load_scenario(path: Path | str, overrides: Iterable[str] = ()) -> Scenario:
    """Read a scenario file, with ``key.path=value`` overrides applied before it is checked.

    Raises `InputError` naming the key, its value and what is allowed.
    """
    with open_input(Path(path), "scenario file", LARGEST_FILE) as stream:
        content = stream.read()
    try:
        text = content.decode()
    except ValueError as error:
        reason = "cannot be read: not a UTF-8 text file"
        raise InputError("scenario file", str(path), reason) from error
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        allowed = f"is not valid TOML: {error}"
        raise InputError("scenario file", str(path), allowed, "correct that line") from error
    except _UNREADABLE as error:
        allowed = "holds a number of thousands of digits or brackets nested too deep"
        raise InputError("scenario file", str(path), allowed) from error
    for override in overrides:
        apply_override(tables, override)
    return scenario_from(tables)


def apply_override(tables: dict[str, Any], override: str) -> None:
    """Set one value in a nested table from ``key.path=value`` (value as TOML, else text).

    Entries of an array of tables are addressed by name, by node, or by number from 0:
    ``member.A0-A1.section=HEB 200``. Raises `InputError`.
    """
    path, equals, text = override.partition("=")
    keys = place_of(tables, path if equals else "", override)
    target: Any = tables
    for key in keys[:-1]:
        target = target[key]
    target[keys[-1]] = parse_value(text.strip())


def place_of(tables: dict[str, Any], path: str, override: str) -> tuple[str | int, ...]:
    """Keys, and numbers of entries, that lead to what a path names; tables on the way are made.

    Raises `InputError` with the whole `override`.
    """
    keys = [key.strip() for key in path.split(".")]
    if not all(keys):
        raise InputError("--set", override, "must look like column.axial_load=2e5")
    target: Any = tables
    places: list[str | int] = []
    for key in keys[:-1]:
        listed = isinstance(target, list)
        places.append(_entry(target, key, override) if listed else key)
        target = target[places[-1]] if listed else target.setdefault(key, {})
        if not isinstance(target, (dict, list)):
            raise InputError("--set", override, f"{key} is a value, not a table")
    if isinstance(target, list):
        raise InputError("--set", override, f"{path.strip()} is an entry, not one of its keys")
    return (*places, keys[-1])


def number_at(tables: dict[str, Any], key: str, field: str) -> tuple[tuple[str | int, ...], float]:
    """Keys that lead to a number in the tables of a scenario, and the number.

    Raises `InputError` naming the `field` in which a `key` stands that leads to none.
    """
    path: Any = place_of(tables, key, key)
    value: Any = tables
    for part in path:
        value = value[part] if isinstance(value, list) else value.get(part)
    if isinstance(value, bool) or not isinstance(value, int | float):
        text = "is no number of this scenario"
        raise InputError(field, key, text, "name keys as --set does, with their value")
    return path, value


def _entry(entries: list[Any], key: str, override: str) -> int:
    """Return the number of the entry that a key of an override names."""
    tables = {n: entry for n, entry in enumerate(entries) if isinstance(entry, dict)}
    named = [number for number, entry in tables.items() if label_of(entry, number) == key]
    named = named or [number for number in tables if str(number) == key]
    if len(named) == 1:
        return named[0]
    how = "several entries are" if named else "no entry is"
    raise InputError("--set", override, f"{how} called {key}", "numbers from 0 name entries, too")


def parse_value(text: str) -> Any:
    """Return a TOML value, or the text itself if it is not one: quotes may be left out."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except _UNREADABLE:
        pass
    try:
        return float(text)  # .5 and 1. are not TOML, but are meant as numbers
    except ValueError:
        return text


def scenario_from(tables: Mapping[str, Any], made: Made | None = None) -> Scenario:
    """Build a scenario from nested tables as TOML gives them. Raises `InputError`.

    Parts that are `made`, see `codec.values_beside`, are not made again.
    """
    kind = tables.get("kind")
    own = KINDS.get(kind) if isinstance(kind, str) else None
    known = own or _kind_of_a_companion(kind)
    inputs = {key: table for key, table in tables.items() if key != "kind"}
    scenario: Scenario = read(known, {"name": kind, **inputs}, made)
    return scenario


def _kind_of_a_companion(kind: Any) -> type[Any]:
    """Class of scenarios of a kind that another package offers. Raises `InputError`."""
    kinds = (*KINDS, *(point.name for point in offered("scenarios")))
    if kind is None:
        raise InputError("kind", None, "is missing", "write one of " + ", ".join(kinds))
    scenario_class: type[Any] = companion("scenarios", Choice(kinds).check("kind", kind))
    return scenario_class


def to_toml(scenario: Scenario) -> str:
    """Return the canonical TOML text of a scenario; reading it back gives an equal scenario.

    Defaults are written out, except in entries of arrays of tables.
    """
    return canonical(scenario)[0]


def scenario_hash(scenario: Scenario) -> str:
    """Return the SHA-256 of the scenario without its name, as 16 hexadecimal digits."""
    return canonical(scenario)[1]


def canonical(scenario: Scenario) -> tuple[str, str]:
    """Return the canonical TOML text of a scenario and the hash of it without the name."""
    if "canonical" not in scenario.kept:
        head = dumped("kind", scenario.KIND) + dumped("name", scenario.name)
        body = write_text(scenario, without="name")
        digest = hashlib.sha256(f"{scenario.KIND}\n{body}".encode()).hexdigest()[:16]
        scenario.kept["canonical"] = f"{head}\n{body}", digest
    text, digest = scenario.kept["canonical"]
    return text, digest
