"""Frame scenarios from nested tables, as TOML gives them, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from workbench.errors import InputError
from workbench.fields import Flag, check_keys
from workbench.materials import Steel
from workbench.scenarios.frame import Frame
from workbench.scenarios.frame_events import (
    FrameGroundMotion,
    FrameImpact,
    FrameStatic,
    FrameStriker,
)
from workbench.scenarios.frame_forms import regular_frame
from workbench.scenarios.frame_parts import Joint, Load, Member, Node
from workbench.scenarios.tables import build, entries_in, fields_of, label_of, table_in
from workbench.sections import section_from

FrameScenario = FrameStatic | FrameImpact | FrameGroundMotion

_STRUCTURE = ("frame", "steel", "node", "member", "joint", "load", "split")
FRAME_TABLES: dict[str, tuple[str, ...]] = {
    FrameStatic.KIND: (*_STRUCTURE, "pattern", "push"),
    FrameImpact.KIND: (*_STRUCTURE, "striker", "time"),
    FrameGroundMotion.KIND: (*_STRUCTURE, "ground", "time"),
}
_REGULAR = ("bays", "storeys", "column", "beam", "base", "beam_joint")
_PUSH = ("node", "direction", "path", "control")
_GROUND = ("acceleration", "time_step", "node", "direction", "damping")
_SPLIT = ("member", "at", "node")


def frame_scenario_from(kind: str, name: str, tables: Mapping[str, Any]) -> FrameScenario:
    """The scenario of this kind that the tables describe. Raises `InputError`."""
    frame = _frame_from(tables)
    if kind == FrameStatic.KIND:
        push = table_in(tables, "push")
        _check_all(push, _PUSH, "push", ("node", "direction", "path"))
        if isinstance(push["path"], (int, float)):
            push["path"] = [push["path"]]
        _check_given(tables, "pattern", "add [[pattern]] with node and x, y or moment")
        return FrameStatic(name, frame, loads=_loads(tables, "pattern"), **push)
    time = table_in(tables, "time", optional=True)
    check_keys(list(time), ("duration",), "time")
    if kind == FrameImpact.KIND:
        striker = build(FrameStriker, table_in(tables, "striker"), "striker")
        return FrameImpact(name, frame, striker, **time)
    ground = table_in(tables, "ground")
    _check_all(ground, _GROUND, "ground", ("acceleration", "time_step", "node"))
    return FrameGroundMotion(name, frame, **ground, **time)


def frame_tables(scenario: FrameScenario) -> dict[str, Any]:
    """The scenario as nested tables in canonical order: explicit nodes and members.

    Entries of arrays of tables leave out what is at its default.
    """
    frame = scenario.frame
    tables: dict[str, Any] = {"kind": scenario.KIND, "name": scenario.name}
    tables["frame"] = {"fillets": frame.fillets}
    tables["steel"] = fields_of(frame.steel)
    tables["node"] = [fields_of(node, defaults=False) for node in frame.nodes]
    tables["joint"] = [fields_of(joint, defaults=False) for joint in frame.joints]
    tables["member"] = [
        fields_of(member, defaults=False) | {"section": member.section.to_toml()}
        for member in frame.members
    ]
    tables["load"] = [fields_of(load, defaults=False) for load in frame.loads]
    if isinstance(scenario, FrameStatic):
        tables["pattern"] = [fields_of(load, defaults=False) for load in scenario.loads]
        tables["push"] = {name: _plain(getattr(scenario, name)) for name in _PUSH}
    elif isinstance(scenario, FrameImpact):
        tables["striker"] = fields_of(scenario.striker)
    else:
        tables["ground"] = {name: _plain(getattr(scenario, name)) for name in _GROUND}
    if not isinstance(scenario, FrameStatic):
        tables["time"] = {"duration": scenario.duration}
    return {name: table for name, table in tables.items() if table != []}


def _frame_from(tables: Mapping[str, Any]) -> Frame:
    form = table_in(tables, "frame", optional=True)
    check_keys(list(form), ("fillets", *_REGULAR), "frame")
    fillets = Flag().check("frame.fillets", form.pop("fillets", True))
    steel = build(Steel, table_in(tables, "steel", optional=True), "steel")
    joints = tuple(_parts(Joint, tables))
    if form:
        frame = _regular(form, tables, steel, fillets, joints)
    else:
        for name in ("node", "member"):
            _check_given(tables, name, f"add [[{name}]], or bays and storeys in [frame]")
        nodes, members = tuple(_parts(Node, tables)), tuple(_parts(Member, tables))
        frame = Frame(nodes, members, joints=joints, steel=steel, fillets=fillets)
    for number, split in enumerate(entries_in(tables, "split")):
        _check_all(split, _SPLIT, f"split.{label_of(split, number)}", _SPLIT)
        frame = frame.split(**split)
    return replace(frame, loads=_loads(tables, "load"))


def _regular(
    form: dict[str, Any],
    tables: Mapping[str, Any],
    steel: Steel,
    fillets: bool,
    joints: tuple[Joint, ...],
) -> Frame:
    for name in ("node", "member"):
        if name in tables:
            raise InputError(
                name,
                None,
                f"[[{name}]] cannot stand beside {next(iter(form))} in [frame]",
                "write either nodes and members or bays and storeys; [[split]] refines both",
            )
    _check_all(form, _REGULAR, "frame", _REGULAR[:4])
    for joint in joints:
        if joint.name != form.get("beam_joint"):
            raise InputError(
                f"joint.{joint.name}",
                None,
                "is no joint of this regular frame",
                "name it as frame.beam_joint, or list nodes and members",
            )
    for name in ("column", "beam"):
        form[name] = section_from(form[name], f"frame.{name}")
    return regular_frame(**form, steel=steel, fillets=fillets, joints=joints)


def _parts(kind: type[Any], tables: Mapping[str, Any]) -> list[Any]:
    parts = []
    for number, entry in enumerate(entries_in(tables, kind.TABLE)):
        path = f"{kind.TABLE}.{label_of(entry, number)}"
        if "section" in entry:
            entry["section"] = section_from(entry["section"], f"{path}.section")
        parts.append(build(kind, entry, path))
    return parts


def _loads(tables: Mapping[str, Any], name: str) -> tuple[Load, ...]:
    loads = []
    for number, entry in enumerate(entries_in(tables, name)):
        try:
            loads.append(build(Load, entry, f"{Load.TABLE}.{label_of(entry, number)}"))
        except InputError as error:
            field = name + error.field.removeprefix(Load.TABLE)
            raise InputError(field, error.value, error.allowed, error.advice) from None
    return tuple(loads)


def _check_given(tables: Mapping[str, Any], name: str, advice: str) -> None:
    if name not in tables:
        raise InputError(name, None, f"the tables [[{name}]] are missing", advice)


def _check_all(
    table: Mapping[str, Any], known: tuple[str, ...], path: str, needed: tuple[str, ...]
) -> None:
    check_keys(list(table), known, path)
    for key in needed:
        if key not in table:
            raise InputError(f"{path}.{key}", None, "is missing", "add the key")


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value
