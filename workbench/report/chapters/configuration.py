"""Everything that is needed to run the study again: models, cases, software."""

import re
import textwrap
import tomllib
from typing import Any

from workbench.content import tree
from workbench.content.bibliography import cited
from workbench.content.tree import Block, Column, Definitions, Paragraph, Section
from workbench.models.base import options_of
from workbench.report.stored import Stored
from workbench.scenarios import to_toml
from workbench.study.definition import Case, Study
from workbench.study.manifest import differences

_PRINTED = 60
_MOST_CHANGES = 12
_MOST_ITEMS = 6
_WIDE = 96  # characters of a line in a listing
_NUMBERS = re.compile(r"^(\S+ = )\[\n((?:\s+[-+.\deE]+,\n)+)\]", re.MULTILINE)


def configuration(study: Study, stored: Stored) -> Section:
    """Models with options and assumptions, cases as TOML, provenance."""
    records = stored.provenance
    blocks: list[Block] = [] if records else [Paragraph("No cell has been answered yet.")]
    if len(records) > 1:
        text = "The cells of this report were answered by different software or machines:"
        blocks.append(Paragraph(text))
    for record in records:
        pairs = tuple((name.replace("_", " "), f"`{value}`") for name, value in record.items())
        blocks.append(Definitions(pairs))
    software = Section("provenance", "Provenance", tuple(blocks))
    return Section("configuration", "Configuration", (_models(study), _cases(study), software))


def _models(study: Study) -> Section:
    sections = []
    said: dict[tuple[str, ...], str] = {}
    for label, model in study.models.items():
        options = [f"`{name} = {_value(value)}`" for name, value in options_of(model).items()]
        pairs = [
            ("model", f"`{model.name}`, version {model.version}"),
            ("options", ", ".join(options) or "none"),
        ]
        if label == study.reference:
            pairs.append(("role", "the reference"))
        elif label in study.ladder:
            pairs.append(("role", "a coarser level of the reference"))
        if model.sources:
            pairs.append(("sources", " ".join(map(cited, model.sources))))
        first = said.setdefault(tuple(model.assumptions), label)
        if first != label:
            pairs.append(("assumptions", f"those of {first}"))
        blocks: tuple[Block, ...] = (Definitions(tuple(pairs)),)
        if first == label:
            blocks += (tree.Bullets(model.assumptions),)
        sections.append(Section(f"model-{label}", label, blocks))
    return Section("models", "Models", tuple(sections))


def _value(value: object) -> str:
    if value is None:
        return "default"
    return str(value).lower() if isinstance(value, bool) else str(value)


def _cases(study: Study) -> Section:
    """The first case of each kind in full, for all others what differs from it."""
    texts = {case.name: _compact(to_toml(case.scenario)) for case in study.cases}
    first: dict[str, Case] = {}
    for case in study.cases:
        first.setdefault(case.scenario.KIND, case)
    others = [case for case in study.cases if case is not first[case.scenario.KIND]]
    full = "The case is" if len(first) == 1 else "The first case of each kind is"
    text = f"{full} a scenario file that `workbench simulate` reads."
    if others:
        text = f"{full} given in full; the table says how the others differ from it."
    blocks: list[Block] = [Paragraph(text)]
    blocks.extend(tree.Listing(case.name, texts[case.name]) for case in first.values())
    if others:
        columns = (
            Column("case", width=1.8, of="name"),
            Column("differs from", width=1.3, of=lambda case: first[case.scenario.KIND].name),
            Column(
                *("in", False, 4.0),
                lambda case: _changes(texts[first[case.scenario.KIND].name], texts[case.name]),
            ),
            Column("models asked", False, 2.0, lambda c: ", ".join(c.models) or "all that apply"),
        )
        blocks.append(tree.Table.of("cases", "All other cases.", columns, others, _PRINTED))
        blocks.extend(tree.Listing(case.name, texts[case.name], printed=False) for case in others)
    return Section("cases", "Cases", tuple(blocks))


def _changes(first: str, other: str) -> str:
    """Entries in which one scenario file differs from another."""
    found = [
        f"`{path} = {_short(new)}`"
        for path, _, new in differences(tomllib.loads(first), tomllib.loads(other))
        if path != "name"
    ]
    if len(found) > _MOST_CHANGES:
        return f"{len(found)} entries: its listing is in the HTML report"
    return ", ".join(found) or "nothing but its name"


def _compact(toml: str) -> str:
    """The same TOML with lists of numbers along the line instead of below each other."""

    def along(found: re.Match[str]) -> str:
        numbers = " ".join(found.group(2).split())
        lines = textwrap.wrap(f"[{numbers.removesuffix(',')}]", _WIDE, subsequent_indent="    ")
        return found.group(1) + "\n".join(lines)

    return _NUMBERS.sub(along, toml)


def _short(value: Any) -> str:
    """A value as text, long lists by their ends."""
    if value is None:
        return "not set"
    if isinstance(value, list) and len(value) > _MOST_ITEMS:
        return f"[{value[0]}, ..., {value[-1]}] ({len(value)} values)"
    return str(value)
