"""`workbench simulate`: one scenario, one model, one response."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from workbench.cli.output import Answer, Names, option, verb, writable
from workbench.content.tree import Block, Callout, Definitions, Paragraph
from workbench.errors import InputError

if TYPE_CHECKING:
    from workbench.assessment.variations import Budget
    from workbench.models.base import Model
    from workbench.responses import Response
    from workbench.scenarios import Scenario

    Budgeted = dict[str, list[dict[str, Any]]]  # rows of terms and sums by quantity

_KIND = "numerical"  # what stands after ±

ScenarioFile = Annotated[str, typer.Argument(metavar="SCENARIO.toml", help="Scenario file.")]
Settings = Annotated[Names, option("Override a value of the scenario.", ..., "KEY=VALUE", "--set")]
Options = Annotated[Names, option("Set an option of the model.", ..., "KEY=VALUE", "--option")]
_SEGMENTS = 4  # the most sheared ones, which the text names


@verb
def simulate(
    scenario: ScenarioFile,
    model: str | None = option(
        "Name of the model, see `workbench models`.  [default: as `workbench advise` says]", None
    ),
    settings: Settings = None,
    options: Options = None,
    out: str | None = option("Write the whole response as netCDF.", None, "RUN.nc"),
    budget: bool = option(
        "Add what the errors of the answer may be, by source.", False, flag="--budget"
    ),
    spread: Names = option("How well an input is known, for the budget.", None, "KEY=SHARE"),
) -> Answer:
    """Answer one scenario with one model, and its error.

    Exit status 0 if the model answered (collapse is an answer), 1 if it did not (it says why), 2
    for bad input.
    """
    from workbench.assessment.variations import Budget
    from workbench.evidence.advice import advised, choose
    from workbench.registry import make_model
    from workbench.responses import Outcome, outcome_of
    from workbench.scenarios import load_scenario

    target = None if out is None else writable("--out", out, "nc", inputs=[scenario])
    if spread and not budget:
        raise InputError("--spread", spread[0], "is for --budget")
    spreads = pairs_of("--spread", spread, "velocity=0.1")
    errors = Budget("", (), spreads) if budget else None
    given = load_scenario(scenario, settings or [])
    if errors is not None:
        errors.variations(given)
    chosen = make_model(model or choose(given).model, pairs_of("--option", options))
    response = advised(chosen, given, chosen.simulate(given))
    outcome = outcome_of(response)
    if outcome is Outcome.INVALID_INPUT:
        raise InputError("scenario", given.name, response.attrs["message"])
    if target is not None:
        from workbench.study.store import to_netcdf_bytes, write_atomically

        write_atomically(target, to_netcdf_bytes(response))
    content = as_object(response, given)
    shown = list(_blocks(given.name, content, target))
    if errors is not None:
        from workbench.report.chapters.budgets import simulated

        terms = _budgeted(errors, chosen, given, response)
        content["budget"] = {q: list(map(_plain, rows)) for q, rows in terms.items()}
        shown += simulated({quantity: float(response[quantity]) for quantity in terms}, terms)
    return Answer(content, shown, int(not outcome.is_answer))


def as_object(response: Response, scenario: Scenario) -> dict[str, Any]:
    """A response as one JSON object; what the model cannot know is null."""
    from workbench.responses import ENERGIES, SCALARS, energy_error, findings_of, places_of
    from workbench.responses.variables import INTEGRATORS, STUD_TESTS

    def last(name: str) -> float | None:
        return float(response[name].values.flat[-1]) if name in response else None

    def attribute(name: str) -> dict[str, Any] | None:  # that not all models have
        text = response.attrs.get(name)
        return None if text is None else dict(json.loads(text))

    shear = None
    if "shear_utilisation" in response:
        series = response["shear_utilisation"].to_series()
        shear = {str(segment): float(value) for segment, value in series.items()}
    special = (*STUD_TESTS, *INTEGRATORS, "input_energy")
    structural = [name for name in SCALARS if name not in special]
    result: dict[str, Any] = {
        "model": response.attrs["model"],
        "outcome": response.attrs["outcome"],
        "message": response.attrs["message"],
        "collapse": attribute("collapse"),
        **{name: last(name) for name in structural},
        "places": places_of(response),
        **_parts(response, scenario),
        "rate_factor": response.attrs.get("rate_factor"),
        "error": attribute("error"),
        "numerical_uncertainty": attribute("numerical_uncertainty"),
        "refinement": attribute("refinement"),
        "energies": {
            **{name: last(name) for name in ENERGIES},
            "input_energy": last("input_energy"),
            "relative_balance_error": energy_error(response),
        },
        "shear_utilisation": shear,
        "warnings": [f.as_dict() for f in findings_of(response) if not f.refusal],
        "refusals": [f.as_dict() for f in findings_of(response) if f.refusal],
        "wall_time": float(response.attrs["wall_time"]),
        "provenance": {
            **json.loads(response.attrs["provenance"]),
            "model_version": int(response.attrs["model_version"]),
            "options": json.loads(response.attrs["options"]),
            "scenario": response.attrs["scenario"],
            "scenario_hash": response.attrs["scenario_hash"],
        },
    }
    if scenario.KIND == "stud-tests":
        result |= {name: last(name) for name in STUD_TESTS}
        result["answer"] = attribute("answer")
    if scenario.KIND == "impact-problem":
        result |= {name: last(name) for name in INTEGRATORS}
    if scenario.STATIC:
        for name in ("displacement", "force"):
            result[name] = response[name].values.tolist() if name in response else None
    return result


def _parts(response: Response, scenario: Scenario) -> dict[str, Any]:
    """What hinges and storeys have gone through, and which members are struck."""
    from workbench.scenarios import FrameImpact

    hinges: dict[str, dict[str, Any]] = {}
    for name in ("axial_force", "moment", "plastic_rotation"):
        for table in [response[name]] if name in response else []:
            for hinge, row in zip(table["hinge"].values, table.values + 0.0, strict=True):
                hinges.setdefault(str(hinge), {})[name] = [float(row.min()), float(row.max())]
    drift = dict(response["drift"].to_series()) if "drift" in response else {}
    struck: list[str] = []
    if isinstance(scenario, FrameImpact):
        members, node = scenario.frame.members, scenario.striker.node
        struck = [member.name for member in members if node in (member.start, member.end)]
    return {
        "hinges": hinges or None,
        "drift": {str(upright): float(value) for upright, value in drift.items()} or None,
        "struck": struck,
    }


def _blocks(name: str, answer: dict[str, Any], target: Path | None) -> Iterator[Block]:
    from workbench.evidence.error_model import ExpectedError

    yield Paragraph(f"{name}: {answer['model']}, {answer['outcome']}")
    if answer["message"]:
        yield Paragraph(answer["message"])
    yield Definitions(tuple(_lines(answer)))
    error = ExpectedError(**answer["error"])
    if error.collapse is not None:
        yield Paragraph(f"Error of the peak displacement: {error}.")
    yield from warnings(answer["warnings"])
    if target is not None:
        yield Paragraph(f"The response is in {target}.")


def warnings(findings: Iterable[dict[str, Any]], source: str = "") -> Iterator[Block]:
    """Findings, as JSON holds them, as callouts; `source`, whose they are."""
    from workbench.responses import Finding

    for finding in map(Finding.from_dict, findings):
        yield Callout("doubt", f"warning{source} ({finding.subject}): {finding}")


def _lines(answer: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """The numbers of a response with their names, units and numerical uncertainty."""
    from workbench.content.formatting import duration, in_unit
    from workbench.responses import ENERGIES, SCALARS, VARIABLES

    widths, places = answer["numerical_uncertainty"] or {}, answer["places"]
    energies, collapse = answer["energies"], answer["collapse"]
    if collapse:
        yield (
            "mechanism of the collapse",
            f"{collapse['mechanism']} ({', '.join(collapse['parts'])})",
        )
        if collapse["time"] is not None:
            yield "time of the collapse", in_unit(collapse["time"], "time_of_peak")
        yield "displacement reached", in_unit(collapse["displacement"], "peak_displacement")
    for name in SCALARS:
        value = energies.get(name, answer.get(name))
        if value is not None:
            place = f" ({places[name]})" if name in places else ""
            text = in_unit(value, name, width=widths.get(name, 0.0), kind=_KIND)
            yield VARIABLES[name].long_name, f"{text}{place}"
    for name in ENERGIES:
        if energies[name] is not None:
            yield f"{VARIABLES[name].long_name}, at the end", in_unit(energies[name], name)
    if answer["rate_factor"] is not None:
        text = f"{answer['rate_factor']:.3f} times the static one, at the strain rate of the hinges"
        yield "yield stress", text
    if energies["relative_balance_error"] is not None:
        error = energies["relative_balance_error"]
        yield "largest energy error over the input energy", f"{error:.1e}"
    if answer.get("force"):
        yield "largest force", in_unit(max(answer["force"]), "force")
        yield from _points(answer, widths)
        yield "points of the curve", str(len(answer["force"]))
    yield from _struck(answer)
    shear = sorted((answer["shear_utilisation"] or {}).items(), key=lambda pair: -pair[1])
    for segment, value in shear[:_SEGMENTS]:
        yield f"largest V/V_pl, segment {segment}", f"{value:.3g}"
    if len(shear) > _SEGMENTS:
        yield f"largest V/V_pl, {len(shear) - _SEGMENTS} others", f"up to {shear[_SEGMENTS][1]:.3g}"
    yield "wall time", duration(answer["wall_time"])


def _points(answer: dict[str, Any], widths: dict[str, float]) -> Iterator[tuple[str, str]]:
    """Points of a static curve whose numerical uncertainty is known."""
    from workbench.content.formatting import in_unit

    for name, ladder in (answer["refinement"] or {}).get("quantities", {}).items():
        variable = ladder["variable"]
        if variable != name and name in widths:
            value = ladder["values"]["h"]
            yield name, in_unit(value, variable, width=widths[name], kind=_KIND)


def _struck(answer: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Axial forces in the members that are struck."""
    from workbench.content.formatting import in_unit

    hinges = answer["hinges"] or {}
    for member in answer["struck"]:
        both = [hinges.get(f"{member}:{end}", {}) for end in ("start", "end")]
        forces = [force for hinge in both for force in hinge.get("axial_force", ())]
        if forces:
            ends = (in_unit(force, "axial_force", 3) for force in (min(forces), max(forces)))
            yield f"axial force in the struck {member}, tension positive", " to ".join(ends)


def _budgeted(budget: Budget, model: Model, scenario: Scenario, answer: Response) -> Budgeted:
    """The error budget of an answer; the model answers the varied scenarios.

    Raises `InputError` if the scenario is no impact on a column.
    """
    from workbench.models.base import on_one_mesh

    runs, alone = budget.variations(scenario), on_one_mesh(model)
    varied = {name: alone.simulate(each) for name, each in runs.items()}
    terms = budget.terms(scenario, answer, varied)  # type: ignore[arg-type]
    return {q: [term.as_dict(float(answer[q])) for term in each] for q, each in terms.items()}


def _plain(row: dict[str, Any]) -> dict[str, Any]:
    """A term as JSON holds it: an end that is a collapse is null, and `collapses` says so."""
    fallen = row["high"] is not None and not isfinite(row["high"])
    open_end = dict.fromkeys(("high", "most") if fallen else ())
    return {**row, **open_end, "collapses": fallen}


def pairs_of(flag: str, texts: list[str] | None, like: str = "beta=1.3") -> dict[str, Any]:
    """Values by name from texts of a flag that look `like` this. Raises `InputError`."""
    from workbench.scenarios import parse_value

    pairs = {}
    for text in texts or ():
        name, equals, value = text.partition("=")
        if not equals or not name.strip():
            raise InputError(flag, text, f"must look like {like}")
        pairs[name.strip()] = parse_value(value.strip())
    return pairs
