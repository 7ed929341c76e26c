"""`workbench models` and `workbench advise`: what exists, and which to take for a scenario."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import typer

from workbench.base.errors import InputError
from workbench.cli.output import Answer, ScenarioFile, Settings, at_work, verb
from workbench.report.page.bibliography import cited
from workbench.report.page.markdown import (
    Block,
    Table,
    bullets,
    definitions,
    paragraph,
    section,
    warnings,
)

if TYPE_CHECKING:
    from workbench.models.base import Offer
    from workbench.responses import Finding
    from workbench.study.error_model.error_model import ModelChoice


@verb
def models(name: str = typer.Argument("", help="Show one model only, in full.")) -> Answer:
    """List the models and what they assume.

    With a NAME: its assumptions, domain, options and sources.
    """
    from workbench.models.base import model_kind, offers

    if name:
        model_kind(name)  # an unknown name is refused with the nearest one
    entries = [_entry(offer) for offer in offers() if name in ("", offer.name)]
    shown = _described(entries[0]) if name else _listed(entries)
    return Answer({"models": entries}, shown)


@verb
def advise(scenario: ScenarioFile, settings: Settings = None) -> Answer:
    """Say which model to take for a scenario, and why.

    The anchor of the error model answers; of the others stands what their domains say.
    """
    from workbench.scenarios import load_scenario

    given = load_scenario(scenario, settings or [])
    from workbench.base.catalogue import DATA
    from workbench.models.base import offers
    from workbench.responses import PEAK
    from workbench.study.error_model.error_model import advise, anchor_peak, choose

    kinds = [offer.kind for offer in offers() if offer.kind is not None]
    fitting = [kind for kind in kinds if given.KIND in kind.answers and kind.name not in DATA]
    with at_work("the advice at work"):
        findings = {kind.name: advise(kind(), given) for kind in fitting}
        choice = choose(given)
    if choice.model not in findings:
        raise InputError("kind", given.KIND, "no model in the order of trust answers it")
    best = None  # estimate of the peak
    if choice.error.expected is not None and choice.error.expected > -1.0:  # not a collapse
        best = anchor_peak(given) / (1.0 + choice.error.expected)
    content = {
        "scenario": given.name,
        "model": choice.model,
        "reason": choice.reason,
        "error": dataclasses.asdict(choice.error),
        PEAK: best,
        "findings": {n: [f.as_dict() for f in each] for n, each in findings.items()},
    }
    return Answer(content, _advice(given.name, choice, best, findings))


def _advice(
    scenario: str, choice: ModelChoice, best: float | None, findings: dict[str, list[Finding]]
) -> Iterator[Block]:
    from workbench.report.page.formatting import in_unit
    from workbench.responses import PEAK

    yield paragraph(f"{scenario}: take {choice.model}, {choice.reason}.")
    if best is not None:
        text = f"Peak displacement of {choice.error.anchor}, corrected by the error to expect"
        yield paragraph(f"{text}: {in_unit(best, PEAK)}.")
    yield from warnings(finding for finding in findings[choice.model] if finding.refusal)
    columns = {
        "model": lambda pair: pair[0],
        "refuses": lambda pair: _subjects(pair[1], lambda f: f.refusal),
        "outside its domain": lambda pair: _subjects(pair[1], lambda f: f.outside),
        "further warnings": lambda pair: _subjects(pair[1], lambda f: not (f.outside or f.refusal)),
    }
    yield Table.of("models", "What every model says of itself here.", columns, findings.items())


def _subjects(findings: list[Finding], chosen: Callable[[Finding], bool]) -> str:
    return ", ".join(dict.fromkeys(f.subject for f in findings if chosen(f))) or "no"


def _entry(offer: Offer) -> dict[str, Any]:
    from workbench.base.fields import meaning

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
    documented = [kind, *(base for base in families if names & vars(base).keys())]  # of options
    text = "\n\n".join(inspect.cleandoc(base.__doc__ or "") for base in documented)
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
        "meanings": {field.name: meaning(field) for field in dataclasses.fields(kind)},
        "distribution": offer.distribution,
    }


def _listed(entries: list[dict[str, Any]]) -> Iterator[Block]:
    columns = {
        "model": "name",
        "version": lambda entry: entry.get("version"),
        "answers": lambda entry: ", ".join(entry.get("answers", ())),
        "what it is": "title",
    }
    yield Table.of("models", "", columns, entries)
    yield paragraph("`workbench models NAME` shows assumptions, options and sources of one model.")


def _described(entry: dict[str, Any]) -> Iterator[Block]:
    yield paragraph(f"{entry['name']}, version {entry['version']} ({entry['distribution']})")
    yield section("description", "", paragraph(entry["description"]))
    yield section("answers", "Answers:", bullets(tuple(entry["answers"])))
    yield section("domain", "Assumptions and domain:", bullets(tuple(entry["assumptions"])))
    meanings = {name: f"{text}; " if text else "" for name, text in entry["meanings"].items()}
    options = tuple((n, f"{meanings[n]}default {value}") for n, value in entry["options"].items())
    yield section("options", "Options (--option name=value):", definitions(options))
    if entry["sources"]:
        yield section("sources", "Sources:", bullets(tuple(map(cited, entry["sources"]))))
