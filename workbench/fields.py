"""Declared fields of frozen dataclasses: one declaration serves Python, TOML and messages."""

from __future__ import annotations

import dataclasses
import difflib
import math
import unicodedata
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from workbench.errors import InputError


class Rule:
    """What a field may hold: `allowed` in words, and `check`, which returns the value or raises.

    `check(path, value)` raises `InputError` naming `path` and gives what the rule allows in one
    form: numbers as float (int where whole ones are asked), lists as tuples.
    """

    advice: str = ""

    def allowed(self) -> str:
        """What is allowed, in words."""
        raise NotImplementedError

    def check(self, path: str, value: Any) -> Any:
        """Return the value in the form of the rule, or raise `InputError` naming `path`."""
        raise NotImplementedError

    def refuse(self, path: str, value: object, advice: str = "") -> InputError:
        """The error of a value that is not allowed."""
        return InputError(path, value, self.allowed(), advice or self.advice)


@dataclasses.dataclass(frozen=True)
class Number(Rule):
    """Allowed range of a number: bounds, whether the lower one is included, unit, and advice."""

    low: float
    high: float
    unit: str = ""
    low_included: bool = True
    integer: bool = False
    advice: str = ""

    def allowed(self) -> str:
        """The allowed range in words."""
        kind = "a whole number" if self.integer else "a number"
        unit = f" {self.unit}" if self.unit else ""
        least = "from" if self.low_included else "above"
        return f"must be {kind} {least} {self.low:g} to {self.high:g}{unit}"

    def check(self, path: str, value: Any) -> float:
        """Return the value as int or float, or raise `InputError` naming `path`."""
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self.refuse(path, value, "write a number without quotes or unit")
        if isinstance(value, float) and not math.isfinite(value):
            raise self.refuse(path, value, "the number must be finite")
        # Compared as it is: whole numbers may lie beyond all floats.
        inside = self.low <= value <= self.high and (self.low_included or value > self.low)
        if not inside or (self.integer and value != int(value)):
            raise self.refuse(path, value)
        return int(value) if self.integer else float(value) + 0.0  # no negative zero


@dataclasses.dataclass(frozen=True)
class Choice(Rule):
    """A word out of a fixed list."""

    words: tuple[str, ...]
    advice: str = ""

    def allowed(self) -> str:
        """The allowed words."""
        return "must be one of " + ", ".join(self.words)

    def check(self, path: str, value: Any) -> str:
        """Return the word, or raise `InputError` naming `path`."""
        if not isinstance(value, str) or value not in self.words:
            raise self.refuse(path, value)
        return value


@dataclasses.dataclass(frozen=True)
class Flag(Rule):
    """True or false."""

    def allowed(self) -> str:
        """The allowed values."""
        return "must be true or false"

    def check(self, path: str, value: Any) -> bool:
        """Return the flag, or raise `InputError` naming `path`."""
        if not isinstance(value, bool):
            raise self.refuse(path, value)
        return value


@dataclasses.dataclass(frozen=True)
class Text(Rule):
    """A non-empty line of text; a `label` has no colon and no space at its ends."""

    longest: int = 200
    label: bool = False

    def allowed(self) -> str:
        """The allowed values."""
        line = f"must be one line of 1 to {self.longest} characters"
        return line + " without a colon, nor a space at its ends" if self.label else line

    def check(self, path: str, value: Any) -> str:
        """Return the text, or raise `InputError` naming `path`."""
        if (
            not isinstance(value, str)
            or not value.strip()
            or len(value) > self.longest
            or any(unicodedata.category(c) in ("Cc", "Cs", "Zl", "Zp") for c in value)
            or (self.label and (":" in value or value != value.strip()))
        ):
            raise self.refuse(path, value)
        return value


@dataclasses.dataclass(frozen=True)
class Instance(Rule):
    """An object of one class.

    Arguments: `kind`, the class; `advice`; `read` and `write`, how one value of a file (called
    with its path) becomes the object and back; `form`, a declared class that files show in its
    stead, with methods `of(instance)` and `build()`; `instead_of`, tables of a file that cannot
    stand beside the keys of this part. See `workbench.scenarios.codec`.
    """

    kind: type[Any]
    advice: str = ""
    read: Callable[[Any, str], Any] | None = None
    write: Callable[[Any], Any] | None = None
    form: type[Any] | None = None
    instead_of: tuple[str, ...] = ()

    def allowed(self) -> str:
        """The allowed class."""
        return f"must be a {self.kind.__name__}"

    def check(self, path: str, value: Any) -> Any:
        """Return the object, or raise `InputError` naming `path`."""
        if not isinstance(value, self.kind):
            raise self.refuse(path, value)
        return value


@dataclasses.dataclass(frozen=True)
class Many(Rule):
    """A list, each item held to `item`; kept as a tuple.

    `different` items may not repeat; `single`: a file may give one number as it is.
    """

    item: Rule
    shortest: int = 0
    longest: int | None = None
    different: bool = False
    single: bool = False

    def allowed(self) -> str:
        """The allowed length and what the items are."""
        several = f"{self.shortest} or more " if self.shortest else ""
        if self.longest is not None:
            several = f"{self.shortest} to {self.longest} "
        if isinstance(self.item, Instance):
            return f"must be a list of {several}{self.item.kind.__name__} objects"
        return f"must be a list of {several}{type(self.item).__name__.lower()}s"

    def check(self, path: str, value: Any) -> tuple[Any, ...]:
        """Return the items, or raise `InputError` naming `path` or one place in it."""
        items = value.tolist() if hasattr(value, "tolist") else value
        if not isinstance(items, (list, tuple)):
            raise self.refuse(path, value, "lists stand in brackets, [ ]")
        if not self.shortest <= len(items) <= (self.longest or len(items)):
            raise self.refuse(path, None, f"{len(items)} are given")
        checked = tuple(self.item.check(f"{path}.{i}", item) for i, item in enumerate(items))
        if self.different and len(set(checked)) < len(checked):
            twice = next(item for item in checked if checked.count(item) > 1)
            raise InputError(path, twice, "stands twice")
        return checked


def checked(
    rule: Rule, default: Any = dataclasses.MISSING, *, optional: bool = False, path: str = ""
) -> Any:
    """A dataclass field held to `rule`; `optional` also allows None (and defaults to it).

    `path` is the key's path in a scenario file where it differs from ``table.field``.
    """
    metadata = {"rule": rule, "optional": optional, "path": path}
    if optional and default is dataclasses.MISSING:
        default = None
    return dataclasses.field(default=default, metadata=metadata)


def path_of(field: dataclasses.Field[Any], table: str) -> str:
    """Path of a field in messages and in files."""
    declared: str = field.metadata.get("path", "")
    return declared or (f"{table}.{field.name}" if table else field.name)


def check_fields(instance: object, table: str, label: str = "") -> str:
    """Hold every checked field of a dataclass instance to its rule, normalising int to float.

    Raises `InputError` with the path ``table.field``; after the field `label` (a name) it is
    ``table.name.field``. Returns the path that then stands for the instance.
    """
    for field in dataclasses.fields(instance):  # type: ignore[arg-type]
        rule: Rule | None = field.metadata.get("rule")
        value = getattr(instance, field.name)
        if rule is None or (value is None and field.metadata["optional"]):
            continue
        value = rule.check(path_of(field, table), value)
        object.__setattr__(instance, field.name, value)
        if field.name == label:
            table = f"{table}.{value}"
    return table


def did_you_mean(word: object, known: Iterable[str], otherwise: str = "") -> str:
    """The question after a word that is not known, or `otherwise` when nothing is near it."""
    near = difflib.get_close_matches(word, list(known), 1) if isinstance(word, str) else []
    return f"did you mean {near[0]}?" if near else otherwise


def check_keys(given: Sequence[str], known: Sequence[str], table: str) -> None:
    """Refuse keys that a table does not have, suggesting the nearest known one."""
    for key in given:
        if key not in known:
            path = f"{table}.{key}" if table else key
            allowed = "unknown key; known are " + ", ".join(known)
            raise InputError(path, None, allowed, did_you_mean(key, known))
