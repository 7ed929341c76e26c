"""`workbench simulate`: one scenario, its answer by one model or several."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.base.errors import InputError
from workbench.base.offered import companion
from workbench.cli.output import (
    PICTURES,
    Answer,
    Names,
    Options,
    ScenarioFile,
    Settings,
    at_work,
    option,
    pairs_of,
    verb,
    warnings,
    writable,
)
from workbench.report.page.markdown import Block, Cell, Table, definitions, paragraph

if TYPE_CHECKING:
    from workbench.api.answers import Comparison
    from workbench.models.base import Model
    from workbench.responses import Response
    from workbench.scenarios import Scenario
    from workbench.study.assessment.variations import Budget

_KIND = "numerical"  # what stands after ±
_SEGMENTS = 4  # the most sheared ones, which the text names
_ROWS = 5  # of an answer that is not shown in full


@verb
def simulate(
    scenario: ScenarioFile,
    model: Names = option(
        "Name of a model, see `workbench models`; several stand in one table.  "
        "[default: as `workbench advise` says, beside the quickest reference]",
        None,
    ),
    settings: Settings = None,
    options: Options = None,
    full: bool = option("Show all numbers.", False, flag="--full"),
    plot: str | None = option("Draw the answer.", None, "OUT.png|svg|pdf"),
    out: str | None = option(
        "Write the whole response as netCDF, or its deformed shapes for ParaView.",
        None,
        "RUN.nc|pvd",
    ),
    budget: bool = option(
        "Add what the errors of the answer may be, by source.", False, flag="--budget"
    ),
    spread: Names = option("How well an input is known, for the budget.", None, "KEY=SHARE"),
) -> Answer:
    """Answer one scenario: peak, interval, warnings.

    Without a model the one that `workbench advise` names answers, and the quickest reference that
    is inside its domain; several models stand in one table. Exit status 0 if the model answered
    (collapse is an answer), 1 if one did not (it says why), 2 for bad input.
    """
    from workbench.scenarios import load_scenario

    if model and len(model) > 1 and (out or budget):
        raise InputError("--model", ", ".join(model), "must be one for --out and --budget")
    target = writable("--out", out, "nc", "pvd", inputs=[scenario])
    picture = writable("--plot", plot, *PICTURES, inputs=[scenario])
    if spread and not budget:
        raise InputError("--spread", spread[0], "is for --budget")
    given = load_scenario(scenario, settings or [])
    from workbench.api.answers import Comparison, asked, simulate
    from workbench.api.summary import as_object
    from workbench.responses import outcome_of
    from workbench.study.error_model.advice import no_reference, quick_reference

    spreads = pairs_of("--spread", spread, "velocity=0.1")
    errors = _budget(given, spreads) if budget else None
    values = pairs_of("--option", options)
    chosen = {name: asked(name, **values) for name in model or ()}  # all, before the work
    with at_work(f"{', '.join(model) if model else 'the model of the advice'} at work"):
        answers = {name: timed(given, each) for name, each in chosen.items()}
        answers = answers or {"": timed(given, **values)}
    first = next(iter(answers.values()))
    reference = "" if model else quick_reference(given)
    if reference and reference != first.attrs["model"]:
        with at_work(f"{reference}, a reference, at work"):
            answers[reference] = simulate(first.workbench.scenario, reference)  # of its record
    if target is not None:
        _write(target, given, first)
    named = {each.attrs["model"]: each for each in answers.values()}
    compared = Comparison(given, named, reference if reference in named else "")
    if picture is not None:
        compared.plot.save(picture)
    status = int(not all(outcome_of(each).is_answer for each in answers.values()))
    if model and len(model) > 1:
        objects = [as_object(each, given) for each in answers.values()]
        both = {"scenario": given.name, "models": objects}
        return Answer(both, _table(compared, objects), status, {"picture": picture})
    content = as_object(first, given)
    other = named[reference] if len(named) > 1 else None
    content["reference"] = None if other is None else as_object(other, given)
    if not model and not reference:
        content["notes"].append(no_reference(given))
    shown = list(_blocks(first, given.name, content, full))
    if errors is not None:
        from workbench.report.chapters.budgets import simulated
        from workbench.study.assessment.variations import RATED, STATIC

        asked_model = asked(first.attrs["model"], **values)
        terms = _budgeted(errors, asked_model, given, first)
        for name, form in (("budget", RATED), ("budget_static", STATIC)):
            content[name] = {}
            for row in (_plain(row) for row in terms if row["form"] == form):
                content[name].setdefault(row["quantity"], []).append(row)
        shown.append(simulated(terms))
    files = {"response": target, "picture": picture}
    return Answer(content, shown, int(not outcome_of(first).is_answer), files)


def _budget(scenario: Scenario, spreads: dict[str, float]) -> Budget:
    """The budget with these spreads of inputs. Raises `InputError` where it cannot be drawn up."""
    from workbench.study.assessment.variations import Budget

    errors = Budget("", (), spreads)
    errors.variations(scenario)
    return errors


def _write(target: Path, scenario: Scenario, response: Response) -> None:
    """Write a response as netCDF, or its deformed shapes."""
    if target.suffix.lower() == ".pvd":
        companion("exports", "pvd")(target, scenario, response)
    else:
        from workbench.study.store import to_netcdf_bytes, write_atomically

        write_atomically(target, to_netcdf_bytes(response))


def timed(scenario: Scenario, model: Model | None = None, **options: Any) -> Response:
    """The answer of a model; where kernels were compiled for it, with the time of a second run.

    That of a long one is not repeated, as in studies, and says `compiled`.
    """
    from numba.core.event import install_recorder

    from workbench.api.answers import asked, simulate
    from workbench.base.compiled import TIMED_AGAIN_BELOW

    with install_recorder("numba:compile") as recorder:
        response = simulate(scenario, model, **options)
    if recorder.buffer:
        if response.attrs["wall_time"] < TIMED_AGAIN_BELOW:
            again = model or asked(response.attrs["model"], **options)
            response.attrs["wall_time"] = again.simulate(scenario).attrs["wall_time"]
        else:
            response.attrs["compiled"] = 1
    return response


def time_of(response: Response) -> Cell:
    """The wall time of an answer, unless compilation may be a part of it."""
    from workbench.report.page.formatting import duration

    if "compiled" in response.attrs:
        return Cell("compiled")
    return Cell(duration(response.attrs["wall_time"]), response.attrs["wall_time"])


def _table(compared: Comparison, objects: list[dict[str, Any]]) -> Iterator[Block]:
    """Several answers, as JSON holds them, as one table, their warnings below."""
    from workbench.api.summary import TABLED, fate_of
    from workbench.report.page.formatting import quantities
    from workbench.study.error_model.error_model import ExpectedError

    columns = {
        "model": "model",
        "fate": lambda row: fate_of(compared[row["model"]]),
        **quantities(*TABLED),
        "error of the peak": lambda row: str(ExpectedError(**row["error"])),
        "wall time": lambda row: time_of(compared[row["model"]]),
    }
    yield Table.of("models", compared.scenario.name, columns, objects)
    for each in objects:
        yield from warnings((*each["refusals"], *each["warnings"]), f" of {each['model']}")


def _blocks(response: Response, name: str, answer: dict[str, Any], full: bool) -> Iterator[Block]:
    from workbench.report.page.formatting import in_unit
    from workbench.study.error_model.error_model import PEAK, ExpectedError

    yield paragraph(f"{name}: {answer['headline']}")
    if answer["message"]:
        yield paragraph(answer["message"])
    rows, other = [*_lines(answer), ("wall time", time_of(response).text)], answer["reference"]
    if answer["rate_factor"] is not None:
        text = f"{answer['rate_factor']:.3g} times the static one by strain rate, at the hinges"
        rows.insert(1, ("yield stress", text))
    if other is not None:
        value, width = other[PEAK], (other["numerical_uncertainty"] or {}).get(PEAK, 0.0)
        known = "" if value is None else f", {in_unit(value, PEAK, width=width, kind=_KIND)}"
        rows.insert(1, (f"by {other['model']}, a reference", f"{other['outcome']}{known}"))
    yield definitions(tuple(rows if full else islice(rows, _ROWS)))
    error = ExpectedError(**answer["error"])
    if error.collapse is not None:
        yield paragraph(f"Error of the peak displacement: {error}.")
    elif answer[PEAK] is not None and error.high is None:
        yield paragraph(f"No interval of the peak displacement: {error.reason}.")
    for note in answer["notes"]:
        yield paragraph(f"Note: {note}.")
    yield from warnings(answer["warnings"])
    if len(rows) > _ROWS and not full:
        yield paragraph(f"{len(rows) - _ROWS} more numbers with --full.")


def _lines(answer: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """The numbers of a response with their names, units and numerical uncertainty."""
    from workbench.report.page.formatting import in_unit
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
    if energies["relative_balance_error"] is not None:
        error = energies["relative_balance_error"]
        yield "largest energy error over the input energy", f"{error:.1e}"
    if answer.get("force"):
        yield "largest force", in_unit(max(answer["force"], key=abs), "force")
        yield from _points(answer, widths)
        yield "points of the curve", str(len(answer["force"]))
    yield from _struck(answer)
    shear = sorted((answer["shear_utilisation"] or {}).items(), key=lambda pair: -pair[1])
    for segment, value in shear[:_SEGMENTS]:
        yield f"largest V/V_pl, segment {segment}", f"{value:.3g}"
    if len(shear) > _SEGMENTS:
        yield f"largest V/V_pl, {len(shear) - _SEGMENTS} others", f"up to {shear[_SEGMENTS][1]:.3g}"


def _points(answer: dict[str, Any], widths: dict[str, float]) -> Iterator[tuple[str, str]]:
    """Points of a static curve whose numerical uncertainty is known."""
    from workbench.report.page.formatting import in_unit

    for name, ladder in (answer["refinement"] or {}).get("quantities", {}).items():
        variable = ladder["variable"]
        if variable != name and name in widths:
            value = ladder["values"]["h"]
            yield name, in_unit(value, variable, width=widths[name], kind=_KIND)


def _struck(answer: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Axial forces in the members that are struck."""
    from workbench.report.page.formatting import in_unit

    hinges = answer["hinges"] or {}
    for member in answer["struck"]:
        both = [hinges.get(f"{member}:{end}", {}) for end in ("start", "end")]
        forces = [force for hinge in both for force in hinge.get("axial_force", ())]
        if forces:
            ends = (in_unit(force, "axial_force", 3) for force in (min(forces), max(forces)))
            yield f"axial force in the struck {member}, tension positive", " to ".join(ends)


def _budgeted(
    budget: Budget, model: Model, scenario: Scenario, answer: Response
) -> list[dict[str, Any]]:
    """The rows of the error budgets of an answer; the model answers the varied scenarios.

    Raises `InputError` if the scenario is no impact on a column.
    """
    from workbench.study.assessment.variations import RATED
    from workbench.study.error_model.advice import advised

    varied = {}
    for name, each in budget.variations(scenario).items():
        varied[name] = budget.solver(name, model).simulate(each)
        if name == RATED:
            varied[name] = advised(model, each, varied[name])
    return list(budget.rows(scenario, answer, varied))  # type: ignore[arg-type]


def _plain(row: dict[str, Any]) -> dict[str, Any]:
    """A term as JSON holds it: an end that is a collapse is null, and `collapses` says so."""
    fallen = row["high"] is not None and not isfinite(row["high"])
    open_end = dict.fromkeys(("high", "most") if fallen else ())
    return {**row, **open_end, "collapses": fallen}
