"""Form of a scenario: its tables as a person writes them, and the fields that show them.

The state of the page is a scenario file: saving it, the link and the answers read these tables,
texts with units among them, by the same reader as the command line.
"""

from __future__ import annotations

import base64
import json
import re
import tomllib
import zlib
from collections.abc import Callable, Iterator
from copy import deepcopy
from functools import cache, cached_property
from mimetypes import guess_type
from pathlib import Path
from typing import Any

import param
import tomli_w
from panel.custom import JSComponent

from workbench.base.codec import Place, leaves
from workbench.base.errors import InputError
from workbench.base.fields import Choice, Flag, Instance, Number
from workbench.base.units import in_si
from workbench.cli.new import TEMPLATES
from workbench.scenarios import Scenario, scenario_from
from workbench.scenarios.files import KINDS, LARGEST_FILE
from workbench.steel.sections import names

DECLARED: dict[str, Any] = tomllib.loads(
    Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")
)
_LONGEST = 60  # characters of a number with its unit
LONGEST_LINK = 6_000  # characters that browsers and servers take without question
_NUMBER = re.compile(r"([-+0-9.,eE]*)\s*(.*)")
_MOST_PANELS = 400  # bays times storeys, that a page can follow
Tables = dict[str, Any]


def started(kind: str) -> Tables:
    """Tables of the template of a kind, as `workbench new` prints it."""
    file = TEMPLATES / f"{DECLARED['kinds'][kind]['start']}.toml.txt"
    return tomllib.loads(file.read_text(encoding="utf-8"))


def read_tables(content: bytes, name: str = "scenario file") -> Tables:
    """Tables of a scenario file. Raises `InputError` for what is none."""
    if len(content) > LARGEST_FILE:
        raise InputError(name, f"{len(content)} bytes", f"must be at most {LARGEST_FILE} bytes")
    try:
        tables = tomllib.loads(content.decode())
    except (ValueError, RecursionError) as error:
        raise InputError(name, None, f"is not valid TOML: {error}", "correct that line") from error
    if tables.get("kind") not in DECLARED["kinds"]:
        kinds = ", ".join(DECLARED["kinds"])
        text = f"the page shows {kinds}"
        raise InputError("kind", tables.get("kind"), text, "take `workbench simulate` for others")
    scenario_from(tables)
    return tables


def packed(state: Any) -> str:
    """State of the page as text of a link."""
    return base64.urlsafe_b64encode(zlib.compress(json.dumps(state).encode(), 9)).decode()


def unpacked(text: str) -> Any:
    """State of a link. Raises `InputError` for a text that is none."""
    try:
        reader = zlib.decompressobj()
        content = reader.decompress(base64.urlsafe_b64decode(text.encode()), LARGEST_FILE)
        return json.loads(content)
    except (ValueError, zlib.error, RecursionError) as error:
        advice = "copy the link whole, or begin with an empty page"
        raise InputError("link", None, "does not hold a state of this page", advice) from error


class ScenarioForm:
    """Fields of a scenario and its `tables`, which a person changes value by value.

    `error` is why the tables are no scenario now (None: they are one).
    """

    def __init__(self, tables: Tables) -> None:
        self.tables = deepcopy(tables)  # which other tabs may share
        self._units: dict[str, str] = {}  # by key, that the person chose
        self._left: dict[str, Tables] = {}  # tables of other kinds, as the person left them
        self._read()

    def _read(self) -> None:
        """Read the tables: the scenario, or the error that they have."""
        self.__dict__.pop("scenario", None)
        self.error: InputError | None = None
        try:
            _ = self.scenario
        except InputError as error:
            self.error = error

    @cached_property
    def scenario(self) -> Scenario:
        """Scenario of the tables. Raises `InputError`."""
        sides = [self._value(f"frame.{name}") for name in ("bays", "storeys")]
        if all(isinstance(each, list) for each in sides):
            bays, storeys = map(len, sides)
            if bays * storeys > _MOST_PANELS:
                text = f"must be at most {_MOST_PANELS} panels on this page"
                advice = "take `workbench simulate` for larger frames"
                raise InputError("frame.bays", f"{bays} x {storeys}", text, advice)
        return scenario_from(self.tables)

    @property
    def text(self) -> str:
        """Scenario file: what the person wrote, units among it."""
        return tomli_w.dumps(self.tables)

    def change(self, key: str, value: Any, unit: str = "") -> None:
        """Set a value as it is typed, with its `unit`; an empty one takes the default."""
        if key == "kind":
            self._left[self.tables["kind"]] = self.tables
            self.tables = self._left.get(value) or started(value)
            return self._read()
        if key == "steel.grade" and value:  # it gives the yield stress, and a rate law
            self.tables.get("steel", {}).pop("yield_stress", None)
        place, (holder, last) = _place(self.tables["kind"], key).rule, self._holder(key)
        rule, text = getattr(place, "item", place), str(value).strip()
        unit = unit if getattr(rule, "unit", "") in DECLARED["units"] else ""
        if not text:
            holder.pop(last, None)
        elif rule is not place:
            holder[last] = [_typed(each.strip(), unit) for each in re.split(r";\s*|,\s+", text)]
        elif isinstance(rule, Flag) and text in ("true", "false"):
            holder[last] = text == "true"
        else:
            holder[last] = _typed(text, unit) if isinstance(rule, Number) else text
        self._read()

    def measure(self, key: str, unit: str) -> None:
        """Write the number of a field in another unit."""
        (holder, last), rule = self._holder(key), _place(self.tables["kind"], key).rule
        si, given = getattr(rule, "item", rule).unit, self._value(key)
        self._units[key] = unit
        if given is None:
            return
        written = [in_other_unit(each, si, unit) for each in _listed(given)]
        holder[last] = written if isinstance(given, list) else written[0]
        self._read()

    def _holder(self, key: str) -> tuple[Any, Any]:
        """Table or list that holds a key, made where it is missing, and its last part."""
        holder: Any = self.tables
        *path, last = key.split(".")
        for part in path:
            holder = holder[int(part)] if part.isdigit() else holder.setdefault(part, {})
        return holder, last

    def _value(self, key: str) -> Any:
        """Value of a key as the tables have it, None where they do not."""
        found: Any = self.tables
        for part in key.split("."):
            if isinstance(found, list):
                found = found[int(part)] if int(part) < len(found) else {}
            else:
                found = found.get(part, {}) if isinstance(found, dict) else {}
        return None if found == {} else found

    @property
    def groups(self) -> list[dict[str, Any]]:
        """Fields by group, as the browser shows them."""
        kind = self.tables["kind"]
        chosen = {n: each["title"] for n, each in DECLARED["kinds"].items()}
        head = {"key": "kind", "label": "Kind of question", "kind": "choice", "value": kind}
        shown = [{"title": "", "fields": [{**head, "choices": list(chosen.items())}]}]
        for name in DECLARED["kinds"][kind]["groups"]:
            group = DECLARED["groups"][name]
            present = name != "split" or "split" in self.tables
            if present and not (name == "frame" and "bays" not in self.tables.get("frame", {})):
                fields = [self._field(each) for each in group["fields"]]
                shown.append({**group, "fields": fields})
        return shown

    @property
    def fields(self) -> dict[str, dict[str, Any]]:
        """Fields by key, of all groups."""
        return {field["key"]: field for group in self.groups for field in group["fields"]}

    @property
    def kept(self) -> list[str]:
        """Keys of the tables that no field shows."""
        shown = self.fields
        return [key for key in _keys(self.tables) if key not in shown]

    def _field(self, declared: dict[str, Any]) -> dict[str, Any]:
        """A field as the browser shows it: label, kind, value, unit, range."""
        key = declared["key"]
        place = _place(self.tables["kind"], key)
        rule = getattr(place.rule, "item", place.rule)
        value, default = self._value(key), place.field.default
        field = {"key": key, "label": declared["label"], "hint": place.field.metadata["help"]}
        if isinstance(rule, Choice | Flag):
            words = rule.words if isinstance(rule, Choice) else ("true", "false")
            chosen = value if isinstance(value, str) else str(value or default or "").lower()
            pairs = [*([] if default else [("", "not given")]), *((word, word) for word in words)]
            return {**field, "kind": "choice", "choices": pairs, "value": chosen}
        if isinstance(rule, Instance):
            shown = value if isinstance(value, str) else json.dumps(value)
            return {**field, "kind": "text", "list": names(), "value": shown}
        if not isinstance(rule, Number):
            listed = self._nodes if key == "striker.node" else ()
            return {**field, "kind": "text", "list": listed, "value": value or ""}
        choices = DECLARED["units"].get(rule.unit, [])
        choices = sorted(choices, key=lambda unit: unit != declared.get("unit", choices[0]))
        pairs = [_parted(each) for each in _listed(value)] if value is not None else []
        usual = rule.unit if pairs or not choices else self._units.get(key, choices[0])
        unit = next((u for _, u in pairs if u), usual)
        if len({each for _, each in pairs}) > 1:  # one unit for all of a list
            pairs = [_parted(in_other_unit(each, rule.unit, unit)) for each in _listed(value)]
        units = list(dict.fromkeys([*choices, unit])) if choices else []
        field |= {"kind": "number", "unit": unit, "units": units, "range": rule.allowed()}
        field["value"] = ", ".join(n for n, _ in pairs)
        if isinstance(default, int | float) and not pairs:
            field["usual"] = f"{_number_in(default, rule.unit, unit):g}"
        if "slider" in declared:
            ends = [
                in_si(each, rule.unit) if choices else float(each) for each in declared["slider"]
            ]
            field["slider"] = [_number_in(end, rule.unit, unit) for end in ends]  # type: ignore[arg-type]
        return field

    @property
    def _nodes(self) -> tuple[str, ...]:
        """Names of the nodes that can be struck."""
        frame = getattr(self.scenario, "frame", None) if self.error is None else None
        return () if frame is None else tuple(node.name for node in frame.nodes)


@cache
def _place(kind: str, key: str) -> Place:
    """Place of a key in the declarations of a kind; of a list of tables that of an entry."""
    table, _, name = key.rpartition(".")
    for place in leaves(KINDS[kind]):
        if place.table == table and place.key == name:
            return place
        if place.entries and table.startswith(f"{place.key}."):
            return next(p for p in leaves(place.entries) if p.key == name)
    raise InputError("form", key, f"is no key of {kind}")


def _listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def _typed(text: str, unit: str) -> Any:
    """A number as files have it: with its unit as a text, else a number where it is one."""
    if unit and not _parted(text)[1]:
        return f"{text} {unit}"
    try:
        return float(text)
    except ValueError:
        return text


def _parted(value: Any) -> tuple[str, str]:
    """Number and unit of a value of a file."""
    text = value.strip() if isinstance(value, str) else ""
    if 0 < len(text) <= _LONGEST and (match := _NUMBER.fullmatch(text)):
        return (match[1], match[2]) if match[1] else (value, "")
    return (f"{value:.12g}" if isinstance(value, float) else str(value)), ""


def _number_in(value: float, si: str, unit: str) -> float:
    """A number in SI in another unit."""
    factor = in_si(f"1 {unit}", si) if unit and unit != si else 1.0
    return value / (factor or 1.0)


def in_other_unit(value: Any, si: str, unit: str) -> Any:
    """A value of a file in another unit; one that is no number as it is."""
    number, given = _parted(value)
    known = in_si(f"{number} {given or si}", si)
    return value if known is None else f"{_number_in(known, si, unit):.10g} {unit}"


def _keys(tables: Any, above: str = "") -> Iterator[str]:
    """Keys of nested tables, with the numbers of entries of lists of tables."""
    entries = tables.items() if isinstance(tables, dict) else enumerate(tables)
    for key, value in entries:
        nested = isinstance(value, dict) or (
            isinstance(value, list) and value and isinstance(value[0], dict)
        )
        yield from _keys(value, f"{above}{key}.") if nested else (f"{above}{key}",)


class FormView(JSComponent):  # type: ignore[misc]
    """Form of a browser, of its own elements: labels, keyboard and screen readers know them."""

    groups = param.List(doc="Groups of fields.")
    errors = param.Dict({}, doc="Messages by key of a field.")
    sent = param.Dict({}, doc="File that the browser saves: name, kind, data as Base64.")

    _esm = "form.js"

    def __init__(self, told: Callable[[dict[str, Any]], None], **parameters: Any) -> None:
        super().__init__(**parameters)
        self._told = told

    def send(self, name: str, content: bytes) -> None:
        """Have the browser save a file."""
        kind = guess_type(name)[0] or "application/octet-stream"
        self.sent = {"name": name, "kind": kind, "data": base64.b64encode(content).decode()}

    def _handle_msg(self, msg: dict[str, Any]) -> None:
        """Pass on what a person has changed: key, value, unit."""
        self._told(msg)
