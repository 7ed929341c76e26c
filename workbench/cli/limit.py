"""`workbench limit`: the value of a scenario key at which a structure collapses."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from workbench.cli.output import Answer, Names, at_work, option, verb
from workbench.cli.simulate import Options, ScenarioFile, Settings, pairs_of, warnings
from workbench.content.tree import Block, Cell, Column, Paragraph, Table
from workbench.errors import InputError

if TYPE_CHECKING:
    from workbench.scenarios import Scenario
    from workbench.study.limit import Limit, Trial

VELOCITY, VELOCITIES = "striker.velocity", (1.0, 60.0)  # m/s
_ENDINGS = {
    True: Cell("survives", tone="good"),
    False: Cell("collapses", tone="bad"),
    None: Cell("not known", tone="doubt"),
}


@verb
def limit(
    scenario: ScenarioFile,
    over: str = option("Key of the scenario with a number.", VELOCITY, "KEY"),
    model: Names = option("Name of a model, once for each.  [default: by the scenario]", None),
    first: float | None = option(
        "End of the range that survives.  [default: 1 m/s]", None, flag="--from"
    ),
    last: float | None = option("End that may collapse.  [default: 60 m/s]", None, flag="--to"),
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
    from workbench.evidence.advice import choose
    from workbench.fields import Number
    from workbench.registry import make_model
    from workbench.scenarios import load_scenario
    from workbench.study.limit import find_limit

    if "=" in over or over == "time.duration":
        text = "must be a key with a number that bears on the structure"
        raise InputError("--over", over, text, f"such as {VELOCITY}")
    Number(1e-6, 0.5).check("--tolerance", tolerance)
    given = (first, last)
    if over != VELOCITY and None in given:
        raise InputError("--from, --to", None, f"must both be given for {over}")
    ends = tuple(VELOCITIES[i] if end is None else end for i, end in enumerate(given))
    if ends[0] == ends[1]:
        raise InputError("--to", ends[1], "must be another value than --from")

    def scenario_at(value: float) -> Scenario:
        return load_scenario(scenario, [*(settings or []), f"{over}={value!r}"])

    checked = [scenario_at(end) for end in ends]  # both, before the work
    with at_work("the search of the limit at work"):
        names = model or [choose(load_scenario(scenario, settings or [])).model]
        models = [make_model(each, pairs_of("--option", options)) for each in names]
        limits = [find_limit(each, scenario_at, (ends[0], ends[1]), tolerance) for each in models]
    content = {
        "scenario": checked[0].name,
        "over": over,
        "range": list(ends),
        "tolerance": tolerance,
        "limits": [{**each.as_dict(), "said": _meaning(each, ends)} for each in limits],
    }
    shown = _blocks(checked[0].name, over, limits, [_meaning(each, ends) for each in limits])
    return Answer(content, shown, int(not all(each.settled for each in limits)))


def _meaning(limit: Limit, ends: tuple[float, ...]) -> str:
    """What the bracket means, in one sentence."""
    low, high = limit.survives_at, limit.collapses_at
    if high is None:
        text = f"no collapse up to {ends[1]:g}" if limit.settled else "no collapse found"
    elif low is None:
        text = f"collapses already at {high:g}" if limit.settled else "no survival found"
    else:
        text = "turns from survival to collapse between the two"
    if limit.undecided:
        unknown = ", ".join(f"{trial.value:.6g}" for trial in limit.undecided)
        text += f"; not known at {unknown}: {limit.undecided[0].message}"
    return text


def _blocks(name: str, over: str, limits: list[Limit], meanings: list[str]) -> Iterator[Block]:
    yield Paragraph(f"{name}: limit of {over}, in the unit of the scenario")
    columns = (
        Column("model", width=1.5, of=lambda row: row[0].model),
        Column("survives at", True, 1.0, lambda row: _value(row[0].survives_at)),
        Column("collapses at", True, 1.0, lambda row: _value(row[0].collapses_at)),
        Column("tried", True, 0.6, lambda row: len(row[0].trials)),
        Column("what that means", width=3.0, of=lambda row: row[1]),
    )
    yield Table.of("limits", "", columns, zip(limits, meanings, strict=True))
    for each in limits:
        yield from warnings(each.warnings, f" of {each.model} there")
    tried = (
        Column("model", width=1.5, of=lambda row: row[0]),
        Column(over, True, 1.0, lambda row: _value(row[1].value)),
        Column("outcome", width=1.0, of=lambda row: _ENDINGS[row[1].survives]),
        Column("how", width=3.5, of=lambda row: _how(row[1])),
    )
    rows = [(each.model, t) for each in limits for t in sorted(each.trials, key=lambda t: t.value)]
    yield Table.of("tried", "Every value tried.", tried, rows)


def _value(value: float | None) -> Cell | None:
    return None if value is None else Cell(f"{value:.6g}", value)


def _how(trial: Trial) -> str:
    collapse: dict[str, Any] | None = trial.collapse
    if collapse is None:
        return "" if trial.survives else f"{trial.outcome}: {trial.message}"
    at = "" if collapse["time"] is None else f" after {collapse['time']:.3g} s"
    where = ", ".join(collapse["parts"])
    return f"{collapse['mechanism']} ({where}) at {collapse['displacement']:.3g} m{at}"
