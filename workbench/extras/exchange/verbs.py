"""Verb `export`: a scenario, or its answer, as a file of another program."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from pkgutil import resolve_name
from typing import Any, NamedTuple

from workbench.base.errors import InputError
from workbench.base.fields import Choice
from workbench.cli.output import (
    Answer,
    Options,
    ScenarioFile,
    Settings,
    at_work,
    option,
    pairs_of,
    verb,
    writable,
)
from workbench.report.page.markdown import Block, paragraph, warnings


class ExportFormat(NamedTuple):
    """A format: the `ending` of its file, its `writer`, a `sentence` on it, `options` it sets.

    The writer is named "module:function", and imported where it is asked for. It takes a scenario,
    the target and options by name, and gives a sentence on how to go on, and findings.
    """

    ending: str
    writer: str
    sentence: str
    options: Mapping[str, str] = {}


_DECK, _SHAPES = (
    "workbench.extras.exchange.deck:write_deck",
    "workbench.extras.exchange.vtk:write_answer",
)
_SCRIPT = "workbench.extras.exchange.opensees.script:write_script"
FORMATS = {
    "calculix": ExportFormat(
        "inp", _DECK, "input deck of a struck column", {"program": "calculix"}
    ),
    "abaqus": ExportFormat("inp", _DECK, "the same for Abaqus/Standard", {"program": "abaqus"}),
    "opensees": ExportFormat("py", _SCRIPT, "script of OpenSeesPy"),
    "vtu": ExportFormat("pvd", _SHAPES, "deformed shapes of its answer"),
}
_LIST = "; ".join(f"{name}: {each.sentence}" for name, each in FORMATS.items())


@verb
def export(
    scenario: ScenarioFile,
    to: str = option(f"{_LIST}.", metavar="|".join(FORMATS)),
    out: str | None = option(
        "The file.  [default: named after the scenario and the format]", None, "FILE"
    ),
    mesh: str | None = option(
        "Elements of a deck: plane-stress, bricks or shells.  [default: plane-stress]", None, "MESH"
    ),
    settings: Settings = None,
    options: Options = None,
) -> Answer:
    """Write a scenario for another program, or its answer.

    A deck is self-contained and says in comments what it holds; what it cannot carry is refused.
    Options of decks: refinement, struck (section or face), step, contact; of vtu those of the model
    that answers.
    """
    from workbench.scenarios import load_scenario

    chosen = FORMATS[Choice(tuple(FORMATS)).check("--to", to)]
    name = out or f"{Path(scenario).stem}-{to}.{chosen.ending}"
    target = writable("--out", name, chosen.ending, inputs=[scenario])
    said = dict(chosen.options) | ({} if mesh is None else {"mesh": mesh})
    if mesh is not None and chosen.writer != _DECK:
        raise InputError("--mesh", mesh, f"is for decks, not for {to}", "leave it out")
    values = pairs_of("--option", options, "refinement=1")
    if twice := [key for key in values if key in said]:
        remedy = "leave it out: --to and --mesh say it"
        raise InputError(f"--option {twice[0]}", values[twice[0]], "is said already", remedy)
    values |= said
    given = load_scenario(scenario, settings or [])
    with at_work(f"the export to {to} at work"):
        then, findings = resolve_name(chosen.writer)(given, target, **values)
    content = {"scenario": given.name, "to": to, "file": str(target), "then": then}
    told = {"warnings": [str(each) for each in findings]}
    return Answer(content | told, _blocks(given.name, then, findings), files={"file": target})


def _blocks(name: str, then: str, findings: list[Any]) -> Iterator[Block]:
    yield paragraph(f"{name}: {then}")
    yield from warnings(findings)
