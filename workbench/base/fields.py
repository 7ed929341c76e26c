"""Declared fields of frozen dataclasses: one declaration serves Python, TOML and messages."""

import dataclasses
import difflib
import math
import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from html import escape
from operator import attrgetter
from typing import Any, ClassVar, Self

from workbench.base.errors import InputError
from workbench.base.units import in_si, in_words, unknown_in

_PLAIN = "write a number without quotes"
DISTRIBUTION = "write a number; distributions are for `workbench fragility` and `sample`"
_LIKE = {"m": '"3.2 m"', "m/s": '"90 km/h"', "N": '"500 kN"', "kg": '"1.5 t"', "Pa": '"355 MPa"'}


class Rule:
    """The values that a field may hold."""

    advice: str = ""

    def allowed(self) -> str:
        """Return the allowed values in words, as messages have them."""
        return f"must be {self._allowed()}"

    def _allowed(self) -> str:
        raise NotImplementedError

    def check(self, path: str, value: Any) -> Any:
        """Return the value in the one form of the rule, or raise `InputError` naming `path`."""
        if not self._accepts(value):
            raise self._refusal(path, value)
        return value

    def _accepts(self, value: Any) -> bool:
        raise NotImplementedError

    def _refusal(self, path: str, value: object, advice: str = "") -> InputError:
        return InputError(path, value, self.allowed(), advice or self.advice)


@dataclasses.dataclass(frozen=True)
class Number(Rule):
    """A number (kept as float; as int where whole ones are asked) between two bounds."""

    low: float
    high: float
    unit: str = ""
    low_included: bool = True
    integer: bool = False
    advice: str = ""
    even: bool = False  # of whole ones

    def _allowed(self) -> str:
        kind = "a whole number" if self.integer else "a number"
        kind = "an even number" if self.even else kind
        unit = f" {self.unit}" if self.unit else ""
        least = "from" if self.low_included else "above"
        return f"{kind} {least} {self.low:g} to {self.high:g}{unit}"

    def check(self, path: str, value: Any) -> float:
        """Return the value as int or float, or raise `InputError` naming `path`."""
        if isinstance(value, str):
            value = self._with_unit(path, value)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self._refusal(path, value, DISTRIBUTION if isinstance(value, dict) else _PLAIN)
        if isinstance(value, float) and not math.isfinite(value):
            raise self._refusal(path, value, "the number must be finite")
        # Compared as it is: whole numbers may lie beyond all floats.
        whole = not self.integer or value % (2 if self.even else 1) == 0
        if not self.holds(value) or not whole:
            raise self._refusal(path, value)
        return int(value) if self.integer else float(value) + 0.0  # 0.0, not -0.0: they are equal

    def holds(self, value: Any) -> Any:
        """Whether a number, or each of an array, lies between the bounds."""
        return (self.low <= value) & (value <= self.high) & (self.low_included | (value > self.low))

    def _with_unit(self, path: str, text: str) -> float:
        """The number of a text such as ``"90 km/h"``."""
        number = in_si(text, self.unit) if self.unit else None
        if number is None:
            like = _LIKE.get(self.unit, "")
            comma = "decimals have a point; " if re.search(r"\d,\d", text) else ""
            more = like and f", or with a unit in quotes, such as {like}"
            raise self._refusal(path, text, f"{comma}{unknown_in(text)}{_PLAIN}{more}")
        return number


@dataclasses.dataclass(frozen=True)
class Choice(Rule):
    """A word out of a fixed list."""

    words: tuple[str, ...]
    advice: str = ""

    def _allowed(self) -> str:
        return "one of " + ", ".join(self.words)

    def _accepts(self, value: Any) -> bool:
        return isinstance(value, str) and value in self.words


@dataclasses.dataclass(frozen=True)
class Flag(Rule):
    """True or false."""

    def _allowed(self) -> str:
        return "true or false"

    def _accepts(self, value: Any) -> bool:
        return isinstance(value, bool)


@dataclasses.dataclass(frozen=True)
class Text(Rule):
    """A line of text; a `label` has no colon and no space at its ends."""

    longest: int = 200
    label: bool = False
    shortest: int = 1

    def _allowed(self) -> str:
        line = f"one line of {self.shortest} to {self.longest} characters"
        return line + " without a colon, nor a space at its ends" if self.label else line

    def _accepts(self, value: Any) -> bool:
        if not isinstance(value, str) or len(value) > self.longest:
            return False
        if len(value.strip()) < self.shortest:
            return False
        # what is printable holds none of them, and is known at once
        line = value.isprintable() or not any(
            unicodedata.category(c) in ("Cc", "Cs", "Zl", "Zp") for c in value
        )
        return line and not (self.label and (":" in value or value != value.strip()))


@dataclasses.dataclass(frozen=True)
class Instance(Rule):
    """An object of one class.

    Arguments: `kind`, the class; `advice`; `read` and `write`, how one value of a file (called
    with its path) becomes the object and back; `form`, a declared class that files show in its
    stead, with methods `of(instance)` and `build()`; `instead_of`, tables of a file that cannot
    stand beside the keys of this part. See `workbench.base.codec`.
    """

    kind: type[Any]
    advice: str = ""
    read: Callable[[Any, str], Any] | None = None
    write: Callable[[Any], Any] | None = None
    form: type[Any] | None = None
    instead_of: tuple[str, ...] = ()

    def _allowed(self) -> str:
        return f"a {self.kind.__name__}"

    def check(self, path: str, value: Any) -> Any:
        """Return the object; what files give in its stead, a name or a table, becomes one."""
        named = self.read is not None and isinstance(value, (str, Mapping))
        if self.read is not None and named and not self._accepts(value):
            value = self.read(value, path)
        return super().check(path, value)

    def _accepts(self, value: Any) -> bool:
        return isinstance(value, self.kind)


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

    def _allowed(self) -> str:
        several = f"{self.shortest} or more " if self.shortest else ""
        if self.longest is not None:
            several = f"{self.shortest} to {self.longest} "
        if self.longest == self.shortest:
            several = f"{self.longest} "
        if isinstance(self.item, Instance):
            return f"a list of {several}{self.item.kind.__name__} objects"
        return f"a list of {several}{type(self.item).__name__.lower()}s"

    def check(self, path: str, value: Any) -> tuple[Any, ...]:
        """Return the items, or raise `InputError` naming `path` or one place in it."""
        items = value.tolist() if hasattr(value, "tolist") else value
        if not isinstance(items, (list, tuple)):
            raise self._refusal(path, value, "lists stand in brackets, [ ]")
        if not self.shortest <= len(items) <= (self.longest or len(items)):
            raise self._refusal(path, None, f"{len(items)} are given")
        held = tuple(self.item.check(f"{path}.{i}", item) for i, item in enumerate(items))
        if self.different and len(set(held)) < len(held):
            twice = next(item for item in held if held.count(item) > 1)
            raise InputError(path, twice, "stands twice")
        return held


def checked(
    rule: Rule,
    default: Any = dataclasses.MISSING,
    *,
    optional: bool = False,
    path: str = "",
    compare: bool = True,
    omitted: bool = False,
    help: str = "",
) -> Any:
    """Declare a dataclass field held to `rule`; `optional` also allows None, its default then.

    `path` is the key's path in a scenario file where it differs from ``table.field``; `compare`,
    whether it takes part in comparisons; `omitted`, whether files leave it out at its default, so
    that a field that is added leaves the hashes of scenarios alone; `help`, what it means, where
    its name and rule do not say it.
    """
    metadata = {"rule": rule, "optional": optional, "path": path, "help": help}
    metadata["omitted"] = omitted
    if optional and default is dataclasses.MISSING:
        default = None
    return dataclasses.field(default=default, metadata=metadata, compare=compare)


def meaning(field: dataclasses.Field[Any]) -> str:
    """Say what a declared field means and may hold; nothing of one that is not declared."""
    data = field.metadata
    return "; ".join(filter(None, (data["help"], data["rule"].allowed()))) if "rule" in data else ""


def path_of(field: dataclasses.Field[Any], table: str) -> str:
    """Path of a field in files: the declared one, or its name in a table."""
    declared: str = field.metadata.get("path", "")
    return declared or (f"{table}.{field.name}" if table else field.name)


class Declared:
    """A frozen dataclass whose fields are declared with `checked`, and held to that when made.

    Of a class, `table` is the table of files, and the word of messages, in which its fields stand;
    `label` the first field of parts that are many, by which messages call one: ``node.A1.x``.
    """

    TABLE: ClassVar[str] = ""
    LABEL: ClassVar[str] = ""
    __dataclass_fields__: ClassVar[dict[str, Any]]

    def __init_subclass__(cls, table: str = "", label: str = "") -> None:
        cls.TABLE, cls.LABEL = table or cls.TABLE, label or cls.LABEL
        cls.__hash__ = Declared.__hash__  # type: ignore[method-assign]  # that of its own is slow

    @property
    def kept(self) -> dict[str, Any]:
        """Results that depend on this object alone and are computed once, by name."""
        results: dict[str, Any] = self.__dict__.setdefault("_kept", {})
        return results

    def __hash__(self) -> int:
        """Hash of all fields, computed once: whole frames are keys of results."""
        try:
            value: int = self.__dict__["_kept"]["hash"]
        except KeyError:
            value = self.kept["hash"] = hash(_compared(type(self))(self))  # type: ignore[arg-type]
        return value

    def __getstate__(self) -> dict[str, Any]:
        """State of a copy, without results: hashes of words differ in another process."""
        return {name: value for name, value in self.__dict__.items() if name != "_kept"}

    def __post_init__(self) -> None:
        for field, rule, optional, path in _checks(type(self)):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if value is not None or not optional:
                value = rule.check(path or self._path(field), value)
                object.__setattr__(self, field.name, value)
        self.check()

    def check(self) -> None:
        """Refuse what the fields cannot be together. Raises `InputError`."""

    def changed(self, **values: Any) -> Self:
        """Return a copy with other values, checked; of a stack, or with arrays, `unchecked`."""
        if is_stack(self) or any(map(is_stack, values.values())):
            return self.unchecked(**values)
        return dataclasses.replace(self, **values)

    def unchecked(self, **values: Any) -> Self:
        """Return a copy with other values, which are allowed; arrays make it a stack of objects."""
        copy = object.__new__(type(self))
        names = (field.name for field in dataclasses.fields(self))
        copy.__dict__.update({name: getattr(self, name) for name in names} | values)
        return copy

    def refusal(self, name: str, allowed: str, advice: str = "") -> InputError:
        """Return the error of the field of this name, "" for all; the rest as in `InputError`."""
        field = self.__dataclass_fields__.get(name)
        if field is None:
            return InputError(f"{self.TABLE}.{getattr(self, self.LABEL)}", None, allowed, advice)
        return InputError(self._path(field), getattr(self, name), allowed, advice)

    @property
    def words(self) -> dict[str, str]:
        """Texts of the fields that are not at their defaults, by name, in units that people use."""
        rules = _checks(type(self))  # type: ignore[arg-type]
        kept = ((f, getattr(self, f.name), getattr(rule, "unit", "")) for f, rule, *_ in rules)
        return {f.name: in_words(x, u) for f, x, u in kept if x not in (None, f.default)}

    def _repr_html_(self) -> str:
        """The `words` of the fields as a table of a notebook."""
        rows = (f"<tr><th>{n}</th><td>{escape(text)}</td></tr>" for n, text in self.words.items())
        return f"<table><caption>{type(self).__name__}</caption>{''.join(rows)}</table>"

    def _path(self, field: dataclasses.Field[Any]) -> str:
        label = f".{getattr(self, self.LABEL)}" if self.LABEL not in ("", field.name) else ""
        return path_of(field, self.TABLE + label)


def is_stack(part: Any) -> bool:
    """Whether something is an array, or a declared object with arrays somewhere in its fields."""
    inner = dataclasses.fields(part) if isinstance(part, Declared) else ()
    return getattr(part, "ndim", 0) > 0 or any(is_stack(getattr(part, f.name)) for f in inner)


@cache
def _checks(kind: type[Declared]) -> list[tuple[dataclasses.Field[Any], Rule, bool, str]]:
    """Fields of a class and their rules, whether they may be None, and the path if all share it."""
    return [
        (field, data["rule"], data["optional"], "" if kind.LABEL else path_of(field, kind.TABLE))
        for field in dataclasses.fields(kind)
        if "rule" in (data := field.metadata)
    ]


@cache
def _compared(kind: type[Declared]) -> Callable[[Any], Any]:
    """The values of an object of a class that take part in comparisons."""
    names = [field.name for field in dataclasses.fields(kind) if field.compare]
    return attrgetter(*names) if names else lambda _: ()


def did_you_mean(word: object, known: Iterable[str], otherwise: str = "") -> str:
    """Return the question after an unknown word, or `otherwise` when nothing is near it."""
    near = difflib.get_close_matches(word, list(known), 1) if isinstance(word, str) else []
    return f"did you mean {near[0]}?" if near else otherwise


def check_keys(given: Sequence[str], known: Sequence[str], table: str) -> None:
    """Refuse keys that a table does not have, suggesting the nearest known one."""
    for key in given:
        if key not in known:
            path = f"{table}.{key}" if table else key
            near = did_you_mean(key, known)
            allowed = f"unknown key; {near} Known" if near else "unknown key; known"
            raise InputError(path, None, f"{allowed} are {', '.join(known)}")
