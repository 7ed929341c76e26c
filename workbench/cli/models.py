"""`workbench models`: what exists, its assumptions and its domain."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import typer

from workbench.cli.output import Answer, verb
from workbench.content.bibliography import cited
from workbench.content.tree import Block, Bullets, Column, Definitions, Paragraph, Section, Table

if TYPE_CHECKING:
    from workbench.registry import Offer


@verb
def models(name: str = typer.Argument("", help="Show one model only, in full.")) -> Answer:
    """List the models and what they assume.

    With a NAME: its assumptions, domain, options and sources.
    """
    from workbench.registry import model_kind, offers

    if name:
        model_kind(name)  # an unknown name is refused with the nearest one
    entries = [_entry(offer) for offer in offers() if name in ("", offer.name)]
    shown = _described(entries[0]) if name else _listed(entries)
    return Answer({"models": entries}, shown)


def _entry(offer: Offer) -> dict[str, Any]:
    kind = offer.kind
    if kind is None:
        return {
            "name": offer.name,
            "title": f"cannot be used: {offer.problem}",
            "problem": offer.problem,
            "distribution": offer.distribution,
        }
    try:
        sources = kind().sources  # published series have theirs from the data
    except Exception:
        sources = kind.sources
    names = {field.name for field in dataclasses.fields(kind)}
    families = (base for base in kind.__mro__[1:] if "name" not in vars(base))
    told = [kind, *(base for base in families if names & vars(base).keys())]  # of options
    text = "\n\n".join(inspect.cleandoc(base.__doc__ or "") for base in told)
    return {
        "name": offer.name,
        "title": text.partition("\n")[0],
        "description": text,
        "version": kind.version,
        "answers": list(kind.answers),
        "assumptions": list(kind.assumptions),
        "sources": list(sources) if isinstance(sources, tuple) else [],
        "options": {
            field.name: None if field.default is dataclasses.MISSING else field.default
            for field in dataclasses.fields(kind)
        },
        "distribution": offer.distribution,
    }


def _listed(entries: list[dict[str, Any]]) -> Iterator[Block]:
    columns = (
        Column("model", of="name"),
        Column("version", True, of=lambda entry: entry.get("version")),
        Column("answers", of=lambda entry: ", ".join(entry.get("answers", ()))),
        Column("what it is", of="title"),
    )
    yield Table.of("models", "", columns, entries)
    yield Paragraph("`workbench models NAME` shows assumptions, options and sources of one model.")


def _described(entry: dict[str, Any]) -> Iterator[Block]:
    yield Paragraph(f"{entry['name']}, version {entry['version']} ({entry['distribution']})")
    yield Section("description", "", (Paragraph(entry["description"]),))
    yield Section("answers", "Answers:", (Bullets(tuple(entry["answers"])),))
    yield Section("domain", "Assumptions and domain:", (Bullets(tuple(entry["assumptions"])),))
    options = tuple((name, f"default {value}") for name, value in entry["options"].items())
    yield Section("options", "Options (--option name=value):", (Definitions(options),))
    if entry["sources"]:
        yield Section("sources", "Sources:", (Bullets(tuple(map(cited, entry["sources"]))),))
