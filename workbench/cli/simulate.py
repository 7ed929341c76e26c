"""`workbench simulate`: one scenario, its answer by one model or several.

`workbench sweep` and `workbench limit`: a scenario with values varied, or one of them sought.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import partial
from math import isfinite, pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.base.errors import InputError
from workbench.base.offered import companion
from workbench.cli.output import (
    DECIMAL,
    ENDINGS,
    PICTURES,
    SEP,
    SHEET,
    Answer,
    Jobs,
    Names,
    Options,
    ScenarioFile,
    Settings,
    at_work,
    option,
    pairs_of,
    processes,
    verb,
    writable,
    write_answers,
)
from workbench.report.page.markdown import Block, Cell, Table, paragraph, warnings

if TYPE_CHECKING:
    import pandas as pd

    from workbench.base.tables import Reading
    from workbench.models.base import Model
    from workbench.responses import Response
    from workbench.scenarios import Scenario
    from workbench.study.assessment.variations import Budget
    from workbench.study.limit import CriticalValue, SurvivalTrial


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
    from workbench.api.accessor import as_object, blocks_of, table_blocks
    from workbench.api.answers import Comparison, asked, simulate
    from workbench.responses import outcome_of
    from workbench.study.error_model.error_model import no_reference, quick_reference

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
        return Answer(both, table_blocks(given.name, named), status, {"picture": picture})
    content = as_object(first, given)
    content["reference"] = as_object(named[reference], given) if len(named) > 1 else None
    if not model and not reference:
        content["notes"].append(no_reference(given))
    shown = list(blocks_of(first, given.name, content, full))
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


def _budgeted(
    budget: Budget, model: Model, scenario: Scenario, answer: Response
) -> list[dict[str, Any]]:
    """The rows of the error budgets of an answer; the model answers the varied scenarios.

    Raises `InputError` if the scenario is no impact on a column.
    """
    from workbench.study.assessment.variations import RATED
    from workbench.study.error_model.error_model import advised

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


VELOCITY, VELOCITIES = "striker.velocity", (1.0, 60.0)  # m/s
_ENDINGS = {
    True: Cell("survives", tone="good"),
    False: Cell("collapses", tone="bad"),
    None: Cell("not known", tone="doubt"),
}
_SHOWN = 40  # rows on a terminal
_KEY = re.compile(r"[a-z_0-9]+(\.[a-z_0-9]+)+")  # of a scenario
_MOST_VALUES = 100_000


@verb
def sweep(
    scenario: ScenarioFile,
    over: Names = option("Values of a key, once for each key.", None, "KEY=LOW:HIGH:STEP|A,B,..."),
    cases: str | None = option("A case a row, in place of --over.", None, "TABLE.csv|xlsx"),
    model: Names = option("Name of a model, once for each.  [default: by the scenario]", None),
    out: str | None = option("Write the table.", None, "ANSWERS.nc|csv|parquet|xlsx"),
    plot: str | None = option("Draw the peaks.", None, "OUT.png|svg|pdf"),
    jobs: Jobs = None,
    settings: Settings = None,
    sheet: str | None = SHEET,
    sep: str | None = SEP,
    decimal: str | None = DECIMAL,
) -> Answer:
    """Answer a scenario with some of its values varied.

    Every value with every other, or the rows of a table whose columns are keys, by every model.
    Exit status 0 if all survive or collapse, 1 if one has no answer (the table says why), 2 for
    bad input.
    """
    from workbench.base.tables import Reading
    from workbench.scenarios import load_scenario

    files = [scenario, cases]
    target = writable("--out", out, *ENDINGS, inputs=files)
    picture = writable("--plot", plot, *PICTURES, inputs=files)
    if bool(over) == bool(cases):
        raise InputError("--over", None, "must be given, or --cases, and not both")
    count = processes(jobs)
    pairs = [_values(text) for text in over or ()]
    values = dict(pairs)
    if len(values) < len(pairs):
        raise InputError("--over", [key for key, _ in pairs], "must name each key once")
    given = load_scenario(scenario, settings or [])
    from workbench.api.sweeps import sweep as swept
    from workbench.base.tables import plain_rows

    with at_work("the sweep at work"):
        how = Reading(sheet, sep, decimal)
        rows_of_cases, notes = (None, ()) if cases is None else _cases(cases, how)
        answers = swept(given, None if cases else values, model or (), count, cases=rows_of_cases)
    table = answers.to_dataframe().reset_index()
    if target is not None:
        write_answers(target, table, answers)
    if picture is not None:
        from workbench.report.drawing.sheet import sweep_chart
        from workbench.report.gallery import save

        save(sweep_chart(answers, picture.name), picture)
    rows = plain_rows(table)
    outcomes = table["outcome"].value_counts()
    keys = [str(key) for key in (values if rows_of_cases is None else rows_of_cases)]
    content = {"scenario": given.name, "over": keys, "answers": rows, "notes": list(notes)}
    answered = int(outcomes.get("ok", 0)) + int(outcomes.get("collapse", 0)) == len(rows)
    for key in keys:
        if answers[key].attrs["units"] == "rad":
            table[key] = [_text(value, "rad") for value in table[key]]
    shown = [*map(paragraph, notes), *_answers(given.name, keys, table)]
    return Answer(content, shown, int(not answered), {"table": target, "picture": picture})


def _cases(file: str, how: Reading) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """The table of a file, a column a key, and how it was read. Raises `InputError`."""
    import pandas as pd

    from workbench.base.tables import read_cells
    from workbench.scenarios.files import parse_value
    from workbench.study.tables import from_spreadsheets

    cells, rows = read_cells(Path(file), _KEY.fullmatch, how), []
    for line, texts in cells.rows[1:]:
        if len(texts) != len(cells.header) or "" in texts:
            reason = f"must have {len(cells.header)} values"
            raise InputError(f"--cases, {cells.name}, line {line}", ",".join(texts), reason)
        numbers = map(cells.number, texts)
        pairs = zip(texts, numbers, strict=True)
        rows.append([parse_value(text) if number is None else number for text, number in pairs])
    if not rows:
        raise InputError("--cases", file, "must hold one row or more")
    return from_spreadsheets(pd.DataFrame(rows, columns=cells.header)), cells.notes


def _values(text: str) -> tuple[str, list[Any]]:
    """Key and values of ``KEY=LOW:HIGH:STEP`` or ``KEY=A,B,...``."""
    from workbench.scenarios.files import parse_value

    key, equals, values = text.partition("=")
    if not equals or not key.strip() or not values.strip():
        raise InputError("--over", text, "must look like striker.velocity=5:30:0.5 or KEY=A,B")
    ends = values.split(":")
    if len(ends) == 1:
        return key.strip(), [parse_value(each.strip()) for each in values.split(",")]
    try:
        low, high, step = map(float, ends)
    except ValueError as error:
        advice = "three numbers in SI units, or values with commas"
        raise InputError("--over", text, "must be LOW:HIGH:STEP", advice) from error
    if not step > 0.0 or not low <= high or not (high - low) / step < _MOST_VALUES:
        allowed = f"must rise by a step above 0, in fewer than {_MOST_VALUES} steps"
        raise InputError("--over", text, allowed)
    number = int((high - low) / step + 1e-9)
    return key.strip(), [round(low + step * k, 12) for k in range(number + 1)]


def _answers(name: str, keys: list[str], table: pd.DataFrame) -> Iterator[Block]:
    from workbench.report.page.formatting import quantities

    outcomes = ", ".join(f"{n} {each}" for each, n in table["outcome"].value_counts().items())
    yield paragraph(f"{name}: {len(table)} answers, {outcomes}.")
    shown = "peak_displacement", "residual_displacement"
    answered = (q for q in map(str, table) if q in shown or q.startswith("edge_factor"))
    named = {name: name for name in ("model", *keys)}
    columns = {**named, **quantities(*answered), "outcome": "outcome"}
    yield Table.of("sweep", "", columns, table[:_SHOWN])
    if len(table) > _SHOWN:
        yield paragraph(f"{len(table) - _SHOWN} more rows stand in --out and --json.")


@verb
def limit(
    scenario: ScenarioFile,
    over: str = option("Key of the scenario with a number.", VELOCITY, "KEY"),
    model: Names = option("Name of a model, once for each.  [default: by the scenario]", None),
    first: str | None = option(
        "End of the range that survives, in SI or with a unit.  [default: 1 m/s]",
        None,
        "VALUE",
        "--from",
    ),
    last: str | None = option("End that may collapse.  [default: 60 m/s]", None, "VALUE", "--to"),
    tolerance: float = option("Width of the bracket over its larger value.", 0.005),
    settings: Settings = None,
    options: Options = None,
) -> Answer:
    """Find the value at which a structure collapses.

    Per model, the bracket in which survival turns into collapse, every value tried, and what the
    model warns of there. By default it asks the model that `workbench advise` names for the
    scenario of the file. Exit status 0 if every model says where, or that it is not in the range,
    1 if one leaves that open, 2 for bad input.
    """
    from workbench.base.fields import Number
    from workbench.scenarios import load_scenario
    from workbench.scenarios.files import parse_value

    if "=" in over or over == "time.duration":
        text = "must be a key with a number that bears on the structure"
        raise InputError("--over", over, text, f"such as {VELOCITY}")
    Number(1e-6, 0.5).check("--tolerance", tolerance)
    given = (first, last)
    if over != VELOCITY and None in given:
        raise InputError("--from, --to", None, f"must both be given for {over}")

    def scenario_at(value: Any) -> Scenario:
        return load_scenario(scenario, [*(settings or []), f"{over}={value!r}"])

    texts = [VELOCITIES[i] if end is None else parse_value(end) for i, end in enumerate(given)]
    values = [float(each) if type(each) is int else each for each in texts]
    checked = [scenario_at(value) for value in values]  # both, before the work
    from workbench.api.sweeps import unit_at
    from workbench.models.base import make_model
    from workbench.study.error_model.error_model import choose
    from workbench.study.limit import find_limit

    unit = unit_at(checked[0], over)
    ends = _in_si(over, values[0], unit), _in_si(over, values[1], unit)
    if ends[0] == ends[1]:
        raise InputError("--to", ends[1], "must be another value than --from")
    with at_work("the search of the limit at work") as say:
        names = model or [choose(load_scenario(scenario, settings or [])).model]
        models = [make_model(each, pairs_of("--option", options)) for each in names]

        def follow(trial: SurvivalTrial) -> None:
            say(f"{_text(trial.value, unit)}: {_ENDINGS[trial.survives].text}")

        limits = [find_limit(each, scenario_at, ends, tolerance, follow) for each in models]
    content = {
        "scenario": checked[0].name,
        "over": over,
        "unit": unit,
        "range": list(ends),
        "tolerance": tolerance,
        "limits": [{**each.as_dict(), "said": _meaning(each, ends, unit)} for each in limits],
    }
    meanings = [_meaning(each, ends, unit) for each in limits]
    shown = _limits(checked[0].name, over, unit, limits, meanings)
    return Answer(content, shown, int(not all(each.settled for each in limits)))


def _in_si(over: str, value: Any, unit: str) -> float:
    """An end of the range in the SI `unit` of its key, which has read it."""
    from workbench.base.units import in_si

    number = in_si(value, unit) if isinstance(value, str) and unit else value
    if isinstance(number, bool) or not isinstance(number, float):
        raise InputError(over, value, "must be a number", "or with a unit, such as 40 km/h")
    return number


def _meaning(limit: CriticalValue, ends: tuple[float, ...], unit: str) -> str:
    """Meaning of the bracket, in one sentence."""
    from workbench.models.domain import ECCENTRIC

    low, high = limit.survives_at, limit.collapses_at
    if high is None:
        text = f"no collapse up to {_text(ends[1], unit)}" if limit.settled else "no collapse found"
    elif low is None:
        text = f"collapses already at {_text(high, unit)}" if limit.settled else "no survival found"
    else:
        text = "turns from survival to collapse between the two"
    if any(each.subject == ECCENTRIC for each in limit.warnings):
        text += ", hit through the shear centre instead of beside it"
    if limit.undecided:
        unknown = ", ".join(f"{trial.value:.6g}" for trial in limit.undecided)
        text += f"; not known at {unknown}{unit and f' {unit}'}: {limit.undecided[0].message}"
    return text


def _limits(
    name: str, over: str, unit: str, limits: list[CriticalValue], meanings: list[str]
) -> Iterator[Block]:
    from workbench.report.page.formatting import valued

    said = partial(_text, unit=unit)
    yield paragraph(f"{name}: limit of {over}{unit and f' in {unit}'}")
    columns = {
        "model": lambda row: row[0].model,
        "survives at": lambda row: valued(row[0].survives_at, said),
        "collapses at": lambda row: valued(row[0].collapses_at, said),
        "tried": lambda row: len(row[0].trials),
        "what that means": lambda row: row[1],
    }
    yield Table.of("limits", "", columns, zip(limits, meanings, strict=True))
    for each in limits:
        yield from warnings(each.warnings, f" of {each.model} there")
    tried = {
        "model": lambda row: row[0],
        over: lambda row: valued(row[1].value, said),
        "outcome": lambda row: _ENDINGS[row[1].survives],
        "how": lambda row: _how(row[1]),
    }
    rows = [(each.model, t) for each in limits for t in sorted(each.trials, key=lambda t: t.value)]
    yield Table.of("tried", "Every value tried.", tried, rows)


def _text(value: float, unit: str) -> str:
    """A value with its SI unit; a velocity in km/h too, an angle in degrees."""
    factor, other = {"m/s": (3.6, "km/h"), "rad": (180.0 / pi, "deg")}.get(unit, (1.0, ""))
    beside = f" ({factor * value:.4g} {other})" if other else ""
    return f"{value:.6g}{unit and f' {unit}'}{beside}"


def _how(trial: SurvivalTrial) -> str:
    collapse = trial.collapse
    if collapse is None:
        return "" if trial.survives else f"{trial.outcome}: {trial.message}"
    at = "" if collapse.time is None else f" after {collapse.time:.3g} s"
    where = ", ".join(collapse.parts)
    return f"{collapse.mechanism} ({where}) at {collapse.displacement:.3g} m{at}"
