"""`workbench models`: what exists, its assumptions and its domain."""

from __future__ import annotations

import inspect
import textwrap
from typing import TYPE_CHECKING, Annotated, Any

import typer

from workbench.cli.output import Json, print_json, print_table

if TYPE_CHECKING:
    from workbench.registry import Offer


def models(
    name: Annotated[str, typer.Argument(help="Show one model only, in full.")] = "",
    as_json: Json = False,
) -> None:
    """List the models and what they assume.

    With a NAME: its assumptions, domain, options and sources.
    """
    from workbench.registry import model_kind, offers

    if name:
        model_kind(name)  # an unknown name is refused with the nearest one
    entries = [_entry(offer) for offer in offers() if name in ("", offer.name)]
    if as_json:
        print_json({"models": entries})
        return
    if not name:
        rows = [
            (e["name"], e.get("version", "-"), ", ".join(e.get("answers", ())), e["title"])
            for e in entries
        ]
        print_table(rows, ("model", "version", "answers", "what it is"))
        print("\n`workbench models NAME` shows assumptions, options and sources of one model.")
        return
    for entry in entries:
        _show(entry)


def _entry(offer: Offer) -> dict[str, Any]:
    import dataclasses

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
    text = inspect.cleandoc(kind.__doc__ or "")
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


def _show(entry: dict[str, Any]) -> None:
    print(f"{entry['name']}, version {entry.get('version', '-')} ({entry['distribution']})")
    if "problem" in entry:
        print(entry["title"])
        return
    print(f"\n{entry['description']}\n")
    print(f"Answers: {', '.join(entry['answers'])}")
    print("Assumptions and domain:")
    for text in entry["assumptions"]:
        print(textwrap.fill(text, 96, initial_indent="  - ", subsequent_indent="    "))
    print("Options (--option name=value):")
    print_table([(f"  {name}", f"default {value}") for name, value in entry["options"].items()])
    if entry["sources"]:
        print(f"Sources: {', '.join(entry['sources'])}")
