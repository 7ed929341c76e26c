"""The mapping file of a table: what its columns are, and where its numbers are from."""

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workbench.base.catalogue import ROLES
from workbench.base.codec import read
from workbench.base.datafiles import open_input
from workbench.base.errors import InputError
from workbench.base.fields import Choice, Declared, Flag, Instance, Many, Number, Text, checked

PROVENANCE = ("title", "source", "licence", "year", "role")
NONE_STATED = ("unknown", "none", "n/a", "?", "-", "todo", "tbd", "not stated", "...")
LARGEST_FILE = 1_000_000  # bytes
_LINE = Text(2000)
TEMPLATE = Path(__file__).with_name("mapping.toml")  # of a mapping file, commented


def _words(value: Any, path: str) -> dict[str, str]:
    """A table of a mapping file whose values are words."""
    if not isinstance(value, dict):
        raise InputError(path, value, f"must be a table [{path}]")
    for key, word in value.items():
        _LINE.check(f"{path}.{key}", word)
    return value


def _constants(value: Any, path: str) -> dict[str, str]:
    """Words and numbers, all as the cells of a table would hold them."""
    if not isinstance(value, dict):
        raise InputError(path, value, f"must be a table [{path}]")
    for key, given in value.items():
        if isinstance(given, bool) or not isinstance(given, (str, int, float)):
            raise InputError(f"{path}.{key}", given, "must be a number or a text")
    return {key: given if isinstance(given, str) else repr(given) for key, given in value.items()}


WORDS, CONSTANTS = Instance(dict, read=_words), Instance(dict, read=_constants)


@dataclass(frozen=True)
class Mapping(Declared):
    """Mapping file of a table.

    `title`, `source`, `licence`, `year`, `role`: of all rows; `uncertainty`, how well the numbers
    are known; `name` in the catalogue and `key` of the bibliography (both optional). `columns`:
    name in the table to column of the workbench; `units` by name in the table; `constants` by
    column of the workbench; `ignore`, columns of the table that are left out; `unit_row`, whether
    line 2 holds units (None: found out); `missing`, what stands for a number that was not reported.
    """

    title: str | None = checked(_LINE, optional=True)
    source: str | None = checked(_LINE, optional=True)
    licence: str | None = checked(_LINE, optional=True)
    year: int | None = checked(Number(1850, 2100, integer=True), optional=True)
    role: str | None = checked(Choice(ROLES), optional=True)
    uncertainty: str | None = checked(_LINE, optional=True)
    kind: str | None = checked(Text(), optional=True)
    name: str | None = checked(Text(60), optional=True)
    key: str | None = checked(_LINE, optional=True)
    columns: dict[str, str] | None = checked(WORDS, optional=True)
    units: dict[str, str] | None = checked(WORDS, optional=True)
    constants: dict[str, str] | None = checked(CONSTANTS, optional=True)
    ignore: tuple[str, ...] = checked(Many(_LINE, different=True), ())
    missing: tuple[str, ...] = checked(Many(Text()), ("-", "–", "n/a", "n.r."))
    unit_row: bool | None = checked(Flag(), optional=True)


def read_mapping(path: Path) -> Mapping:
    """Read a mapping file, which must say where the numbers are from. Raises `InputError`."""
    with open_input(path, "mapping file", LARGEST_FILE) as stream:
        content = stream.read()
    try:
        tables = tomllib.loads(content.decode())
    except (ValueError, RecursionError) as error:
        raise InputError("mapping file", str(path), f"cannot be read: {error}") from error
    try:
        mapping: Mapping = read(Mapping, tables)
    except InputError as error:
        place = f"{path.name}, {error.field}"
        raise InputError(place, error.value, error.allowed, error.advice) from error
    for name in PROVENANCE:
        if getattr(mapping, name) is None:
            advice = "numbers without provenance and licence are not taken"
            raise InputError(f"{path.name}, {name}", None, "is missing", advice)
    check_stated(f"{path.name}, source", mapping.source)
    check_stated(f"{path.name}, licence", mapping.licence)
    return mapping


def check_stated(field: str, text: object) -> None:
    """Refuse what stands for a source or a licence without being one. Raises `InputError`."""
    if str(text).strip().casefold() in NONE_STATED:
        advice = "ask who owns the numbers; facts may be quoted with their source"
        raise InputError(field, text, "must say it: without it nothing is taken", advice)
