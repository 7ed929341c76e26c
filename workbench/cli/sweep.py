"""`workbench sweep`: a scenario with some of its values varied, answered by models."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.cli.output import (
    ENDINGS,
    Answer,
    Names,
    at_work,
    option,
    processes,
    verb,
    writable,
    write_answers,
)
from workbench.cli.simulate import PICTURES, ScenarioFile, Settings
from workbench.content.tree import Block, Column, Paragraph, Table
from workbench.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

_SHOWN = 40  # rows on a terminal
_MOST_VALUES = 100_000


@verb
def sweep(
    scenario: ScenarioFile,
    over: Names = option("Values of a key, once for each key.", None, "KEY=LOW:HIGH:STEP|A,B,..."),
    cases: str | None = option("A case a row, in place of --over.", None, "TABLE.csv"),
    model: Names = option("Name of a model, once for each.  [default: by the scenario]", None),
    out: str | None = option("Write the table.", None, "ANSWERS.nc|csv|parquet|xlsx"),
    plot: str | None = option("Draw the peaks.", None, "OUT.png|svg|pdf"),
    jobs: int | None = option("Processes.  [default: one for each core]", None),
    settings: Settings = None,
) -> Answer:
    """Answer a scenario with some of its values varied.

    Every value with every other, or the rows of a table whose columns are keys, by every model.
    Exit status 0 if all survive or collapse, 1 if one has no answer (the table says why), 2 for
    bad input.
    """
    from workbench.desk.sweeps import sweep as swept
    from workbench.scenarios import load_scenario

    files = [scenario, cases]
    target = None if out is None else writable("--out", out, *ENDINGS, inputs=files)
    picture = None if plot is None else writable("--plot", plot, *PICTURES, inputs=files)
    if bool(over) == bool(cases):
        raise InputError("--over", None, "must be given, or --cases, and not both")
    count = processes(jobs)
    pairs = [_values(text) for text in over or ()]
    values = dict(pairs)
    if len(values) < len(pairs):
        raise InputError("--over", [key for key, _ in pairs], "must name each key once")
    given = load_scenario(scenario, settings or [])
    with at_work("the sweep at work"):
        rows_of_cases = None if cases is None else _cases(cases)
        varied = None if cases else values
        answers = swept(given, varied, model or (), count, cases=rows_of_cases)
    table = answers.to_dataframe().reset_index()
    if target is not None:
        write_answers(target, table, answers)
    if picture is not None:
        from workbench.report.drawing.charts import draw_sweep

        draw_sweep(answers, picture)
    rows = table.astype(object).where(table.notna(), None).to_dict("records")
    outcomes = table["outcome"].value_counts()
    keys = [str(key) for key in (values if rows_of_cases is None else rows_of_cases)]
    shown = list(_blocks(given.name, keys, table, rows))
    for what, file in (("table", target), ("picture", picture)):
        shown += [Paragraph(f"The {what} is in {file}.")] if file else []
    content: dict[str, Any] = {"scenario": given.name, "over": keys, "answers": rows}
    answered = int(outcomes.get("ok", 0)) + int(outcomes.get("collapse", 0)) == len(rows)
    return Answer(content, shown, int(not answered))


def _cases(file: str) -> pd.DataFrame:
    """The table of a file, a column a key. Raises `InputError` for what is none."""
    import pandas as pd

    from workbench.datafiles import open_input

    with open_input(Path(file), "--cases") as stream:
        try:
            table = pd.read_csv(stream)
        except (pd.errors.ParserError, pd.errors.EmptyDataError) as error:
            text = "must be a table with a line of keys"
            raise InputError("--cases", file, text, str(error).strip()) from error
    if table.empty:
        raise InputError("--cases", file, "must hold one row or more")
    return table


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


def _blocks(name: str, keys: list[str], table: pd.DataFrame, rows: list[Any]) -> Iterator[Block]:
    from workbench.content.formatting import in_unit

    outcomes = ", ".join(f"{n} {each}" for each, n in table["outcome"].value_counts().items())
    yield Paragraph(f"{name}: {len(rows)} answers, {outcomes}.")

    def cell(quantity: str) -> Column:
        def text(row: dict[str, Any]) -> str | None:
            return None if row[quantity] is None else in_unit(row[quantity], quantity, 3)

        return Column(quantity.replace("_", " "), True, 1.0, text)

    def value(key: str) -> Column:
        def text(row: dict[str, Any]) -> str:
            return f"{row[key]:g}" if _is_number(row[key]) else str(row[key])

        return Column(key, True, 1.0, text)

    columns = (
        Column("model", width=1.2, of=lambda row: row["model"]),
        *map(value, keys),
        *(cell(q) for q in ("peak_displacement", "residual_displacement") if q in table),
        Column("outcome", width=0.9, of=lambda row: row["outcome"]),
    )
    yield Table.of("sweep", "", columns, rows[:_SHOWN])
    if len(rows) > _SHOWN:
        yield Paragraph(f"{len(rows) - _SHOWN} more rows stand in --out and --json.")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
