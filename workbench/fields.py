"""Validated fields of frozen dataclasses: one declaration serves Python, TOML and messages."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

from workbench.errors import InputError


@dataclasses.dataclass(frozen=True, slots=True)
class Number:
    """Allowed range of a number: bounds, whether they are included, unit, and advice."""

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

    def check(self, path: str, value: object) -> float | int:
        """Return the value as int or float, or raise `InputError` naming `path`."""
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InputError(path, value, self.allowed(), "write a number without quotes or unit")
        number = float(value)
        if not math.isfinite(number):
            raise InputError(path, value, self.allowed(), "the number must be finite")
        inside = self.low <= number <= self.high and (self.low_included or number > self.low)
        if not inside:
            raise InputError(path, value, self.allowed(), self.advice)
        if self.integer:
            if number != int(number):
                raise InputError(path, value, self.allowed(), self.advice)
            return int(number)
        return number


@dataclasses.dataclass(frozen=True, slots=True)
class Choice:
    """A word out of a fixed list."""

    words: tuple[str, ...]
    advice: str = ""

    def allowed(self) -> str:
        """The allowed words."""
        return "must be one of " + ", ".join(self.words)

    def check(self, path: str, value: object) -> str:
        """Return the word, or raise `InputError` naming `path`."""
        if not isinstance(value, str) or value not in self.words:
            raise InputError(path, value, self.allowed(), self.advice)
        return value


@dataclasses.dataclass(frozen=True, slots=True)
class Flag:
    """True or false."""

    def allowed(self) -> str:
        """The allowed values."""
        return "must be true or false"

    def check(self, path: str, value: object) -> bool:
        """Return the flag, or raise `InputError` naming `path`."""
        if not isinstance(value, bool):
            raise InputError(path, value, self.allowed())
        return value


@dataclasses.dataclass(frozen=True, slots=True)
class Text:
    """A non-empty line of text."""

    longest: int = 200

    def allowed(self) -> str:
        """The allowed values."""
        return f"must be one line of 1 to {self.longest} characters"

    def check(self, path: str, value: object) -> str:
        """Return the text, or raise `InputError` naming `path`."""
        if (
            not isinstance(value, str)
            or not value.strip()
            or len(value) > self.longest
            or any(ord(c) < 32 for c in value)
        ):
            raise InputError(path, value, self.allowed())
        return value


@dataclasses.dataclass(frozen=True, slots=True)
class Instance:
    """An object of one class."""

    kind: type[Any]
    advice: str = ""

    def allowed(self) -> str:
        """The allowed class."""
        return f"must be a {self.kind.__name__}"

    def check(self, path: str, value: object) -> object:
        """Return the object, or raise `InputError` naming `path`."""
        if not isinstance(value, self.kind):
            raise InputError(path, value, self.allowed(), self.advice)
        return value


@dataclasses.dataclass(frozen=True, slots=True)
class Numbers:
    """A list of numbers, each held to `item`; kept as a tuple."""

    item: Number
    shortest: int = 1
    longest: int = 1_000_000

    def allowed(self) -> str:
        """The allowed length and the range of each number."""
        return f"must be a list of {self.shortest} to {self.longest} numbers"

    def check(self, path: str, value: object) -> tuple[float, ...]:
        """Return the numbers, or raise `InputError` naming `path` or one place in it."""
        items = value.tolist() if hasattr(value, "tolist") else value
        if not isinstance(items, (list, tuple)):
            raise InputError(path, value, self.allowed(), "write [1.0, 2.0]")
        if not self.shortest <= len(items) <= self.longest:
            raise InputError(path, items, f"{self.allowed()}, not {len(items)}")
        return tuple(self.item.check(f"{path}.{i}", item) for i, item in enumerate(items))


@dataclasses.dataclass(frozen=True, slots=True)
class Instances:
    """A list of objects of one class; kept as a tuple."""

    kind: type[Any]
    shortest: int = 0

    def allowed(self) -> str:
        """The allowed length and class."""
        least = f"{self.shortest} or more" if self.shortest else "any number of"
        return f"must be a list of {least} {self.kind.__name__} objects"

    def check(self, path: str, value: object) -> tuple[object, ...]:
        """Return the objects, or raise `InputError` naming `path` or one place in it."""
        if not isinstance(value, (list, tuple)):
            raise InputError(path, value, self.allowed())
        if len(value) < self.shortest:
            raise InputError(path, None, self.allowed(), f"{len(value)} are given")
        one = Instance(self.kind)
        return tuple(one.check(f"{path}.{i}", item) for i, item in enumerate(value))


Rule = Number | Choice | Flag | Text | Instance | Numbers | Instances


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


def check_fields(instance: object, table: str) -> None:
    """Hold every checked field of a dataclass instance to its rule, normalising int to float.

    Raises `InputError` with the path ``table.field``.
    """
    for field in dataclasses.fields(instance):  # type: ignore[arg-type]
        rule: Rule | None = field.metadata.get("rule")
        if rule is None:
            continue
        value = getattr(instance, field.name)
        if value is None and field.metadata["optional"]:
            continue
        path = field.metadata["path"] or (f"{table}.{field.name}" if table else field.name)
        object.__setattr__(instance, field.name, rule.check(path, value))


def check_keys(given: Sequence[str], known: Sequence[str], table: str) -> None:
    """Refuse keys that a table does not have, suggesting the nearest known one."""
    import difflib

    for key in given:
        if key not in known:
            near = difflib.get_close_matches(key, known, 1)
            advice = f"did you mean {near[0]}?" if near else ""
            path = f"{table}.{key}" if table else key
            raise InputError(path, None, "unknown key; known are " + ", ".join(known), advice)
