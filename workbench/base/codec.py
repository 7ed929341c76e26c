"""Declared objects to and from TOML, by the declarations of their fields.

A declared field stands in a file at ``TABLE.name``, `TABLE` that of its class, or at the path that
it declares. A part within an object has keys of its own; a list of parts is an array of tables,
whose entries hold the fields under their names.
"""

import dataclasses
import re
from collections.abc import Collection, Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

import tomli_w

from workbench.base.errors import InputError, shown
from workbench.base.fields import Declared, Instance, Many, check_keys, path_of

_ESCAPED = re.compile(r"[^ !#-\[\]-~]")  # quotes, backslashes, and what is not ASCII


class Place(NamedTuple):
    """A declared field, its rule, and where files have it: `table` ("" for the top) and `key`.

    Declared classes: that of a `part`, whose own keys a file shows in place of this one, or that
    of the `entries` of an array of tables.
    """

    field: dataclasses.Field[Any]
    rule: Any
    table: str
    key: str
    part: Any = None
    entries: Any = None

    def among(self, tables: Mapping[str, Any]) -> bool:
        """Whether a file has this key."""
        return self.key in (tables.get(self.table, {}) if self.table else tables)


class Input(NamedTuple):
    """An input as a file has it: its `path` without names, ``node.mass``, its `name` with them.

    And the `keys` that lead there, its `value`, `default` (the value itself: it has none), `rule`.
    """

    path: str
    name: str
    keys: tuple[str | int, ...]
    value: Any
    default: Any
    rule: Any

    def __str__(self) -> str:
        value = f"{self.value:g}" if isinstance(self.value, float) else shown(self.value)
        return f"{self.name} = {value} {self.unit}".rstrip()

    @property
    def unit(self) -> str:
        """Its unit, if it has one."""
        return getattr(self.rule, "unit", "")


Made = Mapping[tuple[Any, str], Any]  # values of fields by their class and name


def read(kind: type[Declared], tables: Mapping[str, Any], made: Made | None = None) -> Any:
    """Return an object of this declared class from the tables of a file. Raises `InputError`.

    Values of fields that are `made` already, see `values_beside`, are taken as they are.
    """
    known: dict[str, list[str]] = {}
    for place in leaves(kind):
        known.setdefault(place.table or place.key, []).extend([place.key] if place.table else [])
    check_keys(list(tables), list(known), "")
    for name in tables:
        if known[name] and not isinstance(tables[name], Mapping):
            raise InputError(name, tables[name], f"must be a table [{name}]")
        for key in tables[name] if known[name] else ():
            if key not in known[name] and known.get(key):
                raise InputError(f"{name}.{key}", None, f"unknown key; [{key}] is a table itself")
            home = next((table for table, keys in known.items() if key in keys), "")
            if key not in known[name] and home:
                raise InputError(f"{name}.{key}", None, f"unknown key; {key} stands in [{home}]")
            check_keys([key], known[name], name)
    return _build(kind, tables, made=made or {})


def values_beside(
    kind: Any, tables: Mapping[str, Any], varied: Collection[str]
) -> dict[tuple[Any, str], Any]:
    """Parts, and lists of them, that `read` makes of tables but those that are `varied`.

    Raises `InputError`.
    """
    made: dict[tuple[Any, str], Any] = {}
    for place in _places(kind):
        keys = tuple(leaves(place.part)) if place.part else (place,)
        alike = {leaf.table or leaf.key for leaf in keys}.isdisjoint(varied)
        if place.part and not alike:
            made |= values_beside(place.part, tables, varied)
        elif place.part and (_is_given(place, tables) or not place.field.metadata["optional"]):
            part = _build(place.part, tables)
            made[kind, place.field.name] = part.build() if place.rule.form else part
        elif alike and place.entries and place.among(tables):
            made[kind, place.field.name] = _value(place, place.key, tables[place.key])
    return made


def write_text(whole: Any, without: str) -> str:
    """Return the nested tables of a declared object as TOML, one field left out.

    The text of a part is kept with it: the same column is hit by many strikers.
    """
    texts = [text for _, text in _texts(whole, without).values()]
    plain = [text for text in texts if not text.startswith("[")]  # TOML wants them first
    tables = (text for text in texts if text.startswith("["))
    return "\n".join(filter(None, ("".join(plain), *tables)))


def _texts(whole: Any, without: str = "") -> dict[str, tuple[Any, str]]:
    """Return the value at every top key of an object, and its TOML."""
    values: dict[str, Any] = {}
    texts: dict[str, tuple[Any, str]] = {}
    kind: Any = type(whole)
    for place in _written(kind, False):
        value = getattr(whole, place.field.name)
        if place.part and value is not None:
            if "toml" not in value.kept:
                value.kept["toml"] = _texts(place.part.of(value) if place.rule.form else value)
            texts |= value.kept["toml"]
        elif place.field.name != without:
            _put(values, place, value)
            texts.setdefault(place.table or place.key, ({}, ""))
    for key, value in values.items():  # some beside those of a part
        table = {**texts[key][0], **value} if isinstance(value, dict) else value
        texts[key] = table, dumped(key, table)
    return texts


def dumped(key: str, value: Any) -> str:
    """Return a key as TOML: what `tomli_w` writes, which takes ten times as long for plain values.

    Plain is a number with a point, or a text that needs no escapes.
    """
    table = value if isinstance(value, dict) else {key: value}
    if not all(
        type(each) is float or (type(each) is str and _ESCAPED.search(each) is None)
        for each in table.values()
    ):
        return tomli_w.dumps({key: value})
    lines = [
        f"{name} = {each}\n" if isinstance(each, float) else f'{name} = "{each}"\n'
        for name, each in table.items()
    ]
    return "".join([f"[{key}]\n", *lines] if table is value else lines)


def set_inputs(whole: Declared) -> dict[str, Input]:
    """Return the inputs of an object that are not at their defaults, by path: the first of many."""
    if "set" not in whole.kept:
        whole.kept["set"] = inputs = dict[str, Input]()
        for each in inputs_of(whole):
            if each.value != each.default:
                inputs.setdefault(each.path, each)
    kept: dict[str, Input] = whole.kept["set"]
    return kept


def inputs_of(part: Any, table: str = "", entry: tuple[Any, ...] = ()) -> Iterator[Input]:
    """Return all inputs of an object; of one in an array of tables with its label and number."""
    kind: Any = type(part)
    for place in _places(kind, bool(entry)):
        value, holder = getattr(part, place.field.name), table or place.table
        if place.part:
            yield from inputs_of(value) if value is not None else ()
        elif place.entries:
            array = place.entries.TABLE if place.table else place.key
            for number, each in enumerate(value):
                yield from inputs_of(each, array, (getattr(each, each.LABEL), number))
        else:
            path = f"{holder}.{place.key}" if holder else place.key
            name = f"{holder}.{entry[0]}.{place.key}" if entry else path
            keys = (holder, *entry[1:], place.key) if holder else (place.key,)
            default = _defaults(kind).get(place.field.name, value)
            yield Input(path, name, keys, value, default, place.rule)


@cache
def _defaults(kind: Any) -> dict[str, Any]:
    """Default values of the fields of a class, as an object has them that is made of nothing."""
    known = {field.name: field.default for field in dataclasses.fields(kind)}
    if dataclasses.MISSING not in known.values():
        return {name: getattr(kind(), name) for name in known}
    return {name: value for name, value in known.items() if value is not dataclasses.MISSING}


def label_of(entry: Mapping[str, Any], number: int) -> str:
    """Return the label of an entry of an array of tables: its name, its node, or its number."""
    label = entry.get("name", entry.get("node"))
    return label if isinstance(label, str) and len(label) <= 60 else str(number)


@cache
def _places(kind: Any, entry: bool = False) -> tuple[Place, ...]:
    """The places of all fields of a class, as the rules of its fields declare them."""
    places = []
    for field in dataclasses.fields(kind):
        rule = field.metadata["rule"]
        item = rule.item if isinstance(rule, Many) else rule
        path = field.name if entry else path_of(field, kind.TABLE)
        table, _, key = path.rpartition(".")
        part = item.form or item.kind if isinstance(item, Instance) and not item.read else None
        parts = (part, None) if item is rule else (None, part)
        places.append(Place(field, rule, table, key, *parts))
    return tuple(places)


@cache
def _written(kind: Any, entry: bool) -> list[Place]:
    # What has a written form of its own, a section, may be a table: TOML wants it last.
    return sorted(_places(kind, entry), key=lambda place: bool(getattr(place.rule, "write", None)))


def leaves(kind: Any) -> Iterator[Place]:
    """Places of all keys that files may have for objects of this class."""
    for place in _places(kind):
        yield from leaves(place.part) if place.part else (place,)


def _build(kind: Any, tables: Mapping[str, Any], entry: str = "", made: Made | None = None) -> Any:
    """The object whose keys stand in `tables`, those of one entry if its path is given."""
    values = {}
    for place in _places(kind, bool(entry)):
        name = place.field.name
        if made and (kind, name) in made:
            values[name] = made[kind, name]
        elif place.part:
            if _is_given(place, tables) or not place.field.metadata["optional"]:
                part = _build(place.part, tables, made=made)
                values[name] = part.build() if place.rule.form else part
        elif place.among(tables):
            holder = tables[place.table] if place.table else tables
            path = ".".join(filter(None, (entry, place.table, place.key)))
            values[name] = _value(place, path, holder[place.key])
        elif place.field.default is dataclasses.MISSING:
            raise _missing(place, tables, entry)
    return kind(**values)


def _value(place: Place, path: str, value: Any) -> Any:
    """One value of a file as the rule of its field has it."""
    if place.entries:
        if not isinstance(value, list) or not all(isinstance(entry, Mapping) for entry in value):
            raise InputError(path, value, f"must be tables [[{path}]]")
        parts = []
        for number, entry in enumerate(value):
            label = f"{path}.{label_of(entry, number)}"
            check_keys(list(entry), [each.key for each in _places(place.entries, True)], label)
            parts.append(_build(place.entries, entry, label))
        return tuple(parts)
    if isinstance(place.rule, Instance) and place.rule.read:
        return place.rule.read(value, path)
    alone = getattr(place.rule, "single", False) and isinstance(value, (int, float, str))
    return place.rule.check(path, [value] if alone else value)


def _entry_table(part: Any) -> dict[str, Any]:
    """Return an entry of an array of tables, without its defaults."""
    entry: dict[str, Any] = {}
    kind: Any = type(part)
    for place in _written(kind, True):
        value = getattr(part, place.field.name)
        if value != place.field.default:
            _put(entry, place, value)
    return entry


def _put(tables: dict[str, Any], place: Place, value: Any) -> None:
    """Put a value in its place, if there is one."""
    if value is None or (place.entries and not value):
        return
    if place.field.metadata["omitted"] and value == place.field.default:
        return
    if place.entries:
        value = tuple(map(_entry_table, value))
    elif isinstance(place.rule, Instance) and place.rule.write:
        value = place.rule.write(value)
    holder = tables.setdefault(place.table, {}) if place.table else tables
    holder[place.key] = list(value) if isinstance(value, tuple) else value


def _is_given(place: Place, tables: Mapping[str, Any]) -> bool:
    """Whether a file has a key of a part. Raises `InputError` where it may not have one."""
    given = [leaf for leaf in leaves(place.part) if leaf.among(tables)]
    for other in place.rule.instead_of:
        if given and other in tables:
            beside = f"{given[0].key} in [{given[0].table}]"
            advice = f"write either [[{other}]] or {beside}"
            raise InputError(other, None, f"[[{other}]] cannot stand beside {beside}", advice)
    return bool(given)


def _missing(place: Place, tables: Mapping[str, Any], entry: str) -> InputError:
    key, table = place.key, place.table
    if place.entries:
        keys = ", ".join(each.key for each in _places(place.entries, True))
        text, advice = f"the tables [[{key}]] are missing", f"add [[{key}]] with {keys}"
        return InputError(key, None, text, advice)
    if table and table not in tables:
        return InputError(table, None, f"the table [{table}] is missing", f"add [{table}]")
    return InputError(f"{entry or table}.{key}", None, "is missing", "add the key")
