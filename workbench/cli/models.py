"""`workbench models`: what exists, its assumptions and its domain."""

from __future__ import annotations

from typing import Annotated

import typer

from workbench.cli.output import Json, print_json, print_table


def models(
    name: Annotated[str, typer.Argument(help="Show one model only, in full.")] = "",
    as_json: Json = False,
) -> None:
    """List the models: what they answer, what they assume, their options."""
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


def _entry(offer: object) -> dict[str, object]:
    import dataclasses

    from workbench.registry import Offer

    assert isinstance(offer, Offer)
    if offer.kind is None:
        return {"name": offer.name, "title": f"cannot be used: {offer.problem}"}
    kind = offer.kind
    try:
        declared = kind()  # some declare sources per instance
    except Exception:
        declared = kind
    return {
        "name": offer.name,
        "title": (kind.__doc__ or "").strip().splitlines()[0],
        "description": (kind.__doc__ or "").strip(),
        "version": kind.version,
        "answers": list(kind.answers),
        "assumptions": list(kind.assumptions),
        "sources": [] if isinstance(declared.sources, property) else list(declared.sources),
        "options": {
            field.name: None if field.default is dataclasses.MISSING else field.default
            for field in dataclasses.fields(kind)
        },
        "distribution": offer.distribution,
    }
