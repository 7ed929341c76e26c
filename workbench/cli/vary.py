"""`workbench sweep` and `workbench limit`: a scenario with values varied, or one of them sought."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.base.errors import InputError
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
    warnings,
    writable,
    write_answers,
)
from workbench.report.page.markdown import Block, Cell, Table, paragraph

if TYPE_CHECKING:
    import pandas as pd

    from workbench.base.tables import Reading
    from workbench.scenarios import Scenario
    from workbench.study.limit import Limit, Trial

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

    with at_work("the sweep at work"):
        how = Reading(sheet, sep, decimal)
        rows_of_cases, notes = (None, ()) if cases is None else _cases(cases, how)
        varied = None if cases else values
        answers = swept(given, varied, model or (), count, cases=rows_of_cases)
    table = answers.to_dataframe().reset_index()
    if target is not None:
        write_answers(target, table, answers)
    if picture is not None:
        from workbench.report.drawing.charts import sweep_chart
        from workbench.report.gallery import save

        save(sweep_chart(answers, picture.name), picture)
    rows = table.astype(object).where(table.notna(), None).to_dict("records")
    outcomes = table["outcome"].value_counts()
    keys = [str(key) for key in (values if rows_of_cases is None else rows_of_cases)]
    content: dict[str, Any] = {"scenario": given.name, "over": keys, "answers": rows}
    content["notes"] = list(notes)
    answered = int(outcomes.get("ok", 0)) + int(outcomes.get("collapse", 0)) == len(rows)
    shown = [*map(paragraph, notes), *_answers(given.name, keys, table, rows)]
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


def _answers(name: str, keys: list[str], table: pd.DataFrame, rows: list[Any]) -> Iterator[Block]:
    from workbench.report.page.formatting import quantities

    outcomes = ", ".join(f"{n} {each}" for each, n in table["outcome"].value_counts().items())
    yield paragraph(f"{name}: {len(rows)} answers, {outcomes}.")
    answered = (q for q in ("peak_displacement", "residual_displacement") if q in table)
    named = {name: name for name in ("model", *keys)}
    columns = {**named, **quantities(*answered), "outcome": "outcome"}
    yield Table.of("sweep", "", columns, rows[:_SHOWN])
    if len(rows) > _SHOWN:
        yield paragraph(f"{len(rows) - _SHOWN} more rows stand in --out and --json.")


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
    from workbench.models.registry import make_model
    from workbench.study.error_model.advice import choose
    from workbench.study.limit import find_limit

    unit = unit_at(checked[0], over)
    ends = tuple(_in_si(over, value, unit) for value in values)
    if ends[0] == ends[1]:
        raise InputError("--to", ends[1], "must be another value than --from")
    with at_work("the search of the limit at work") as say:
        names = model or [choose(load_scenario(scenario, settings or [])).model]
        models = [make_model(each, pairs_of("--option", options)) for each in names]

        def follow(trial: Trial) -> None:
            say(f"{_text(trial.value, unit)}: {_ENDINGS[trial.survives].text}")

        bounds = (ends[0], ends[1])
        limits = [find_limit(each, scenario_at, bounds, tolerance, follow) for each in models]
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


def _meaning(limit: Limit, ends: tuple[float, ...], unit: str) -> str:
    """Meaning of the bracket, in one sentence."""
    low, high = limit.survives_at, limit.collapses_at
    if high is None:
        text = f"no collapse up to {_text(ends[1], unit)}" if limit.settled else "no collapse found"
    elif low is None:
        text = f"collapses already at {_text(high, unit)}" if limit.settled else "no survival found"
    else:
        text = "turns from survival to collapse between the two"
    if limit.undecided:
        unknown = ", ".join(f"{trial.value:.6g}" for trial in limit.undecided)
        text += f"; not known at {unknown}{unit and f' {unit}'}: {limit.undecided[0].message}"
    return text


def _limits(
    name: str, over: str, unit: str, limits: list[Limit], meanings: list[str]
) -> Iterator[Block]:
    yield paragraph(f"{name}: limit of {over}{unit and f' in {unit}'}")
    columns = {
        "model": lambda row: row[0].model,
        "survives at": lambda row: _value(row[0].survives_at, unit),
        "collapses at": lambda row: _value(row[0].collapses_at, unit),
        "tried": lambda row: len(row[0].trials),
        "what that means": lambda row: row[1],
    }
    yield Table.of("limits", "", columns, zip(limits, meanings, strict=True))
    for each in limits:
        yield from warnings(each.warnings, f" of {each.model} there")
    tried = {
        "model": lambda row: row[0],
        over: lambda row: _value(row[1].value, unit),
        "outcome": lambda row: _ENDINGS[row[1].survives],
        "how": lambda row: _how(row[1]),
    }
    rows = [(each.model, t) for each in limits for t in sorted(each.trials, key=lambda t: t.value)]
    yield Table.of("tried", "Every value tried.", tried, rows)


def _text(value: float, unit: str) -> str:
    """A value with its SI unit; a velocity in km/h too."""
    beside = f" ({3.6 * value:.4g} km/h)" if unit == "m/s" else ""
    return f"{value:.6g}{unit and f' {unit}'}{beside}"


def _value(value: float | None, unit: str) -> Cell | None:
    return None if value is None else Cell(_text(value, unit), value)


def _how(trial: Trial) -> str:
    collapse: dict[str, Any] | None = trial.collapse
    if collapse is None:
        return "" if trial.survives else f"{trial.outcome}: {trial.message}"
    at = "" if collapse["time"] is None else f" after {collapse['time']:.3g} s"
    where = ", ".join(collapse["parts"])
    return f"{collapse['mechanism']} ({where}) at {collapse['displacement']:.3g} m{at}"
