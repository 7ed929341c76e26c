"""`workbench simulate`: one scenario, one model, one response."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from workbench.cli.output import Answer, quantity, verb

if TYPE_CHECKING:
    from workbench.content.tree import Block
    from workbench.responses import Response
    from workbench.scenarios import Scenario


@verb
def simulate(
    scenario: Annotated[str, typer.Argument(metavar="SCENARIO.toml", help="Scenario file.")],
    model: Annotated[str, typer.Option(help="Name of the model, see `workbench models`.")],
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Override a value of the scenario."),
    ] = None,
    options: Annotated[
        list[str] | None,
        typer.Option("--option", metavar="KEY=VALUE", help="Set an option of the model."),
    ] = None,
    out: Annotated[
        str | None, typer.Option(metavar="RUN.nc", help="Write the whole response as netCDF.")
    ] = None,
) -> Answer:
    """Answer one scenario with one model.

    Exit status 0 if the model answered, 1 if it did not (it says why), 2 for bad input.
    """
    from workbench.errors import InputError
    from workbench.registry import make_model
    from workbench.responses import Outcome, outcome_of
    from workbench.scenarios import load_scenario

    target = None if out is None else _writable(out)
    given = load_scenario(scenario, settings or [])
    chosen = make_model(model, _options(options or []))
    response = chosen.simulate(given)
    outcome = outcome_of(response)
    if outcome is Outcome.INVALID_INPUT:
        raise InputError("scenario", given.name, response.attrs["message"])
    if target is not None:
        from workbench.study.files import write_atomically
        from workbench.study.netcdf import to_netcdf_bytes

        write_atomically(target, to_netcdf_bytes(response))
    content = as_object(response, given)
    return Answer(content, _blocks(response, given, target), int(outcome is not Outcome.OK))


def as_object(response: Response, scenario: Scenario) -> dict[str, Any]:
    """A response as one JSON object; what the model cannot know is null."""
    from workbench.responses import ENERGIES, energy_error, findings_of, outcome_of
    from workbench.responses.stud_tests import STUD_TESTS

    def last(name: str) -> float | None:
        return float(response[name].values.flat[-1]) if name in response else None

    result: dict[str, Any] = {
        "model": response.attrs["model"],
        "outcome": outcome_of(response).value,
        "message": response.attrs["message"],
        **{name: last(name) for name in _headlines()},
        "numerical_uncertainty": _attribute(response, "numerical_uncertainty"),
        "refinement": _attribute(response, "refinement"),
        "energies": {
            **{name: last(name) for name in ENERGIES},
            "input_energy": last("input_energy"),
            "relative_balance_error": energy_error(response),
        },
        "shear_utilisation": _shear_utilisation(response),
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
        result["answer"] = _attribute(response, "answer")
    if scenario.STATIC:
        for name in ("displacement", "force"):
            result[name] = response[name].values.tolist() if name in response else None
    return result


def _headlines() -> list[str]:
    """The scalars of structures; the input energy stands with the energies."""
    from workbench.responses import SCALARS
    from workbench.responses.stud_tests import STUD_TESTS

    return [name for name in SCALARS if name not in STUD_TESTS and name != "input_energy"]


def _shear_utilisation(response: Response) -> dict[str, float] | None:
    """V/Vpl by segment, None for models that do not state it."""
    if "shear_utilisation" not in response:
        return None
    values = response["shear_utilisation"].to_series()
    return {str(segment): float(value) for segment, value in values.items()}


def _attribute(response: Response, name: str) -> dict[str, Any] | None:
    """An attribute of the response that holds JSON; None for models that do not have it."""
    text = response.attrs.get(name)
    return None if text is None else dict(json.loads(text))


def _curve_points(response: Response) -> Iterator[tuple[str, str]]:
    """Points of a static curve with their numerical uncertainty."""
    widths = _attribute(response, "numerical_uncertainty") or {}
    table = (_attribute(response, "refinement") or {}).get("quantities", {})
    for name, found in table.items():
        if " at " in name and name in widths:
            unit = {"force": "N", "displacement": "m"}.get(name.split(" at ")[0], "1")
            yield name, quantity(found["values"]["h"], unit, widths[name])


def _blocks(response: Response, scenario: Scenario, target: Path | None) -> Iterator[Block]:
    from workbench.content.tree import Callout, Definitions, Paragraph
    from workbench.responses import outcome_of, warnings_of

    yield Paragraph(f"{scenario.name}: {response.attrs['model']}, {outcome_of(response)}")
    if response.attrs["message"]:
        yield Paragraph(response.attrs["message"])
    yield Definitions(tuple(_lines(response, scenario)))
    for finding in warnings_of(response):
        yield Callout("doubt", f"warning ({finding.subject}): {finding}")
    if target is not None:
        yield Paragraph(f"The response is in {target}.")


def _lines(response: Response, scenario: Scenario) -> Iterator[tuple[str, str]]:
    """The numbers of a response with their names."""
    from workbench.responses import ENERGIES, VARIABLES, energy_error
    from workbench.responses.stud_tests import STUD_TESTS

    widths = _attribute(response, "numerical_uncertainty") or {}
    for name in (*_headlines(), "input_energy", *STUD_TESTS):
        if name in response:
            known = VARIABLES[name]
            text = quantity(float(response[name]), known.units, widths.get(name, 0.0))
            yield known.long_name, text
    for name in ENERGIES:
        if name in response:
            title = VARIABLES[name].long_name.removesuffix(" so far")
            yield f"{title}, at the end", quantity(float(response[name][-1]), "J")
    error = energy_error(response)
    if error is not None:
        yield "largest energy error over the input energy", f"{error:.1e}"
    if scenario.STATIC and "force" in response:
        yield "largest force", quantity(float(response["force"].max()), "N")
        yield from _curve_points(response)
        yield "points of the curve", str(response.sizes["step"])
    for segment, value in (_shear_utilisation(response) or {}).items():
        yield f"largest V/V_pl, segment {segment}", f"{value:.3g}"
    yield "wall time", quantity(float(response.attrs["wall_time"]), "s")


def _options(texts: list[str]) -> dict[str, Any]:
    from workbench.errors import InputError
    from workbench.scenarios import parse_value

    options = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name.strip():
            raise InputError("--option", text, "must look like beta=1.3")
        options[name.strip()] = parse_value(value.strip())
    return options


def _writable(out: str) -> Path:
    import os

    from workbench.errors import InputError

    path = Path(out)
    if path.is_dir():
        raise InputError("--out", out, "is a directory", "name a file")
    if not path.parent.is_dir():
        raise InputError("--out", out, f"there is no directory {path.parent}", "make it first")
    if not os.access(path.parent, os.W_OK):
        raise InputError("--out", out, f"the directory {path.parent} cannot be written")
    return path
