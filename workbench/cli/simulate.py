"""`workbench simulate`: one scenario, one model, one response."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from workbench.cli.output import Json, print_json, print_table, quantity

if TYPE_CHECKING:
    from workbench.responses import Response
    from workbench.scenarios import Scenario

_HEADLINES = (
    *("peak_displacement", "time_of_peak", "residual_displacement", "peak_force", "impulse"),
)
_STATIC = ("column-pushover", "frame-static")  # kinds whose answer is a curve over load steps


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
    as_json: Json = False,
) -> int:
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
    if as_json:
        print_json(as_object(response, given))
    else:
        _print(response, given)
        if target is not None:
            print(f"\nThe response is in {target}.")
    return 0 if outcome is Outcome.OK else 1


def as_object(response: Response, scenario: Scenario) -> dict[str, Any]:
    """A response as one JSON object; what the model cannot know is null."""
    from workbench.responses import ENERGIES, outcome_of, warnings_of
    from workbench.responses.stud_tests import STUD_TESTS

    def scalar(name: str) -> float | None:
        return float(response[name]) if name in response else None

    def last(name: str) -> float | None:
        return float(response[name].values[-1]) if name in response else None

    def curve(name: str) -> list[float] | None:
        return [float(v) for v in response[name].values] if name in response else None

    error, given = _energy_error(response)
    shear = None
    if "shear_utilisation" in response:
        values = response["shear_utilisation"]
        names = [str(name) for name in values["segment"].values]
        shear = dict(zip(names, map(float, values.values), strict=True))
    result: dict[str, Any] = {
        "model": response.attrs["model"],
        "outcome": outcome_of(response).value,
        "message": response.attrs["message"],
        **{name: scalar(name) for name in _HEADLINES},
        "numerical_uncertainty": _attribute(response, "numerical_uncertainty"),
        "refinement": _attribute(response, "refinement"),
        "energies": {
            **{name: last(name) for name in ENERGIES},
            "input_energy": given,
            "relative_balance_error": error,
        },
        "shear_utilisation": shear,
        "warnings": [f"{finding.subject}: {finding.text}" for finding in warnings_of(response)],
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
        result |= {name: scalar(name) for name in STUD_TESTS}
        result["answer"] = _attribute(response, "answer")
    if scenario.KIND in _STATIC:
        result["displacement"] = curve("displacement")
        result["force"] = curve("force")
    return result


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


def _energy_error(response: Response) -> tuple[float | None, float | None]:
    """Largest error of the energy ledger over the input energy, and that energy in J."""
    if "input_energy" not in response:
        return None, None
    given = float(response["input_energy"])
    if "balance_error" not in response or given == 0.0:
        return None, given
    return float(abs(response["balance_error"]).max()) / given, given


def _print(response: Response, scenario: Scenario) -> None:
    from workbench.responses import ENERGIES, VARIABLES, outcome_of, warnings_of
    from workbench.responses.stud_tests import STUD_TESTS

    widths = _attribute(response, "numerical_uncertainty") or {}
    print(f"{scenario.name}: {response.attrs['model']}, {outcome_of(response)}")
    if response.attrs["message"]:
        print(response.attrs["message"])
    rows = [
        (
            VARIABLES[name].long_name,
            quantity(float(response[name]), VARIABLES[name].units, widths.get(name, 0.0)),
        )
        for name in (*_HEADLINES, "input_energy", *STUD_TESTS)
        if name in response
    ]
    rows += [
        (
            f"{VARIABLES[name].long_name.removesuffix(' so far')}, at the end",
            quantity(float(response[name][-1]), "J"),
        )
        for name in ENERGIES
        if name in response
    ]
    error, _ = _energy_error(response)
    if error is not None:
        rows.append(("largest energy error over the input energy", f"{error:.1e}"))
    if scenario.KIND in _STATIC and "force" in response:
        largest = float(response["force"].max())
        rows.append(("largest force", quantity(largest, "N")))
        rows.extend(_curve_points(response))
        rows.append(("points of the curve", str(response.sizes["step"])))
    if "shear_utilisation" in response:
        for segment in response["shear_utilisation"]["segment"].values:
            value = float(response["shear_utilisation"].sel(segment=segment))
            rows.append((f"largest V/V_pl, segment {segment}", f"{value:.3g}"))
    rows.append(("wall time", quantity(float(response.attrs["wall_time"]), "s")))
    print_table([(f"  {name}", value) for name, value in rows])
    for finding in warnings_of(response):
        print(f"warning ({finding.subject}): {finding.text}")


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
