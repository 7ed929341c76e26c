"""Everything that is needed to run the study again: models, cases, software."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from typing import Any

from workbench.models.base import options_of
from workbench.report.chapters.verdicts import source_text
from workbench.report.content import (
    Block,
    Bullets,
    Cell,
    Column,
    Definitions,
    Listing,
    Paragraph,
    Section,
    Table,
)
from workbench.report.stored import Stored
from workbench.scenarios import to_toml
from workbench.study.definition import Study

_PRINTED = 60


def configuration(study: Study, stored: Stored) -> Section:
    """Models with options and assumptions, cases as TOML, provenance."""
    parts = (_models(study), _cases(study), _provenance(stored))
    return Section("configuration", "Configuration", parts)


def _models(study: Study) -> Section:
    sections = []
    said: dict[tuple[str, ...], str] = {}
    for label, model in study.models.items():
        role = []
        if label == study.reference:
            role.append("the reference")
        elif label in study.ladder:
            role.append("a coarser level of the reference")
        options = options_of(model)
        shown = ", ".join(f"`{name} = {_value(value)}`" for name, value in options.items())
        pairs = [
            ("model", f"`{model.name}`, version {model.version}"),
            ("options", shown or "none"),
        ]
        if role:
            pairs.append(("role", ", ".join(role)))
        if model.sources:
            pairs.append(("sources", " ".join(source_text(key) for key in model.sources)))
        first = said.setdefault(tuple(model.assumptions), label)
        if first == label:
            blocks: tuple[Block, ...] = (Definitions(tuple(pairs)), Bullets(model.assumptions))
        else:
            pairs.append(("assumptions", f"those of {first}"))
            blocks = (Definitions(tuple(pairs)),)
        sections.append(Section(f"model-{label}", label, blocks))
    return Section("models", "Models", tuple(sections))


def _value(value: object) -> str:
    if value is None:
        return "default"
    return str(value).lower() if isinstance(value, bool) else str(value)


def _cases(study: Study) -> Section:
    texts = {case.name: to_toml(case.scenario) for case in study.cases}
    first, *others = study.cases
    blocks: list[Block] = [
        Paragraph(
            "The first case in full; the table says how the others differ from it. Each listing "
            "is a scenario file that `workbench simulate` reads."
        )
        if others
        else Paragraph("The case is a scenario file that `workbench simulate` reads."),
        Listing(first.name, texts[first.name]),
    ]
    if others:
        base = _flat(tomllib.loads(texts[first.name]))
        rows = []
        for case in others:
            other = _flat(tomllib.loads(texts[case.name]))
            changes = [
                f"`{key} = {other.get(key, 'not set')}`"
                for key in dict.fromkeys([*base, *other])
                if key != "name" and base.get(key) != other.get(key)
            ]
            answered = ", ".join(case.models) if case.models else "all that apply"
            rows.append(
                (Cell(case.name), Cell(", ".join(changes) or "as the first"), Cell(answered))
            )
        columns = (
            Column("case", width=2.0),
            Column(f"differs from {first.name} in", width=4.5),
            Column("models asked", width=2.0),
        )
        blocks.append(Table("cases", "All other cases.", columns, tuple(rows), _PRINTED))
        blocks.extend(Listing(case.name, texts[case.name], printed=False) for case in others)
    return Section("cases", "Cases", tuple(blocks))


def _flat(tables: Mapping[str, Any], path: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in tables.items():
        if isinstance(value, dict):
            found.update(_flat(value, f"{path}{key}."))
        else:
            found[f"{path}{key}"] = value
    return found


def _provenance(stored: Stored) -> Section:
    records = stored.provenance
    blocks: list[Block] = []
    if not records:
        blocks.append(Paragraph("No cell has been answered yet."))
    if len(records) > 1:
        text = "The cells of this report were answered by different software or machines:"
        blocks.append(Paragraph(text))
    for record in records:
        pairs = tuple((name.replace("_", " "), f"`{value}`") for name, value in record.items())
        blocks.append(Definitions(pairs))
    return Section("provenance", "Provenance", tuple(blocks))
