"""Numbers of all models in many scenarios, and the table that keeps each with its reason.

The plan, ``baselines.toml``, names scenarios and models; the table beside it begins with the dated
reasons of changes and has a line for every number. How a model ends is a number, too: `OUTCOME`.
"""

import re
import tomllib
from collections.abc import Iterator
from math import isfinite
from operator import itemgetter
from pathlib import Path
from typing import Any

import pandas as pd

from workbench.base.catalogue import datasets, load
from workbench.base.datafiles import data_directory, open_input
from workbench.base.errors import InputError
from workbench.base.tables import records
from workbench.extras.bench.cases import bench_directory, load_bench
from workbench.models.base import Model, make_model, model_kind, model_names
from workbench.models.superelements import ACCURACY  # of a peak: what steps leave open
from workbench.report.page.formatting import in_unit, percent
from workbench.responses import VARIABLES, outcome_of
from workbench.scenarios import Scenario, load_scenario, scenario_from
from workbench.study.batches import Processes
from workbench.study.cells import ingredients_of, key_of
from workbench.study.error_model.error_table import TABLES

OUTCOME, ROUND_OFF = "outcome", 1e-6  # of zero, in its unit
QUANTITIES = (
    *("peak_displacement", "residual_displacement", "peak_force", "resistance"),
    *("relative_error", "test_over_prediction", "fitted_test_over_prediction", "coverage"),
    *("answer.grid.median", "answer.curve.shear", "answer.mechanical.ratio"),  # means of columns
)
# `model`, its label; `inputs`, a digest of scenario, options and data; `value`, in SI with six
# digits; `change`, the number of its reason
COLUMNS = ("scenario", "model", "version", "inputs", "quantity", "value", "unit", "change")
KEY = itemgetter("scenario", "model", "quantity")
Task = tuple[str, str, Model, Scenario]
Line = dict[str, str]
Lines = dict[tuple[str, ...], Line]
_REASON = re.compile(r"^# \d+ (\d{4}-\d\d-\d\d \S.*)$", re.MULTILINE)
_MODEL = re.compile(r"([\w-]+),? (?:version )?(\d+)(?![\w.])")  # and its version, in a text


def numbers_now(plan: Path, jobs: int) -> Lines:
    """All numbers of a plan, in so many processes. Raises `InputError` for what is no plan."""
    with open_input(plan, "--table") as stream:
        try:
            tasks = list(_tasks(tomllib.load(stream)))
        except InputError:
            raise
        except (ValueError, TypeError, LookupError, AttributeError) as error:
            fault, advice = f"is no plan: {type(error).__name__} {error}", "see data/baselines.toml"
            raise InputError(plan.name, None, fault, advice) from error
    with Processes(jobs) as run:
        return {KEY(line): line for lines in run(_numbers, tasks) for line in lines}


def _tasks(tables: Any) -> Iterator[Task]:
    asked, groups = tables["model"].items(), tables.get("cases", {})
    models = {label: make_model(of.get("of", label), of.get("options", {})) for label, of in asked}
    for name, case in tables["case"].items():
        if "file" in case:
            scenario = load_scenario(data_directory() / case["file"], case.get("set", ()))
        else:
            scenario = scenario_from({"name": name, **case["scenario"]})
        for label, of in asked:
            chosen = groups[of["cases"]] if "cases" in of else [name]
            if scenario.KIND in models[label].answers and name in chosen:
                yield name, label, models[label], scenario


def _numbers(task: Task) -> list[Line]:
    name, label, model, scenario = task
    made = ingredients_of(scenario, model)
    inputs = key_of({part: made[part] for part in ("scenario", "options", "data")})[:8]
    line = {"scenario": name, "model": label, "version": str(model.version), "inputs": inputs}
    response = model.simulate(scenario)
    numbers = [(OUTCOME, outcome_of(response).value, "")]
    for quantity in filter(response.__contains__, QUANTITIES):
        unit = VARIABLES[quantity].units if quantity in VARIABLES else "1"
        numbers.append((quantity, f"{float(response[quantity].mean()):.6g}", unit))
    return [line | dict(zip(COLUMNS[4:], number, strict=False)) for number in numbers]


def read_baselines(path: Path) -> tuple[list[str], Lines]:
    """Reasons and lines of a table. Raises `InputError` for a line that is damaged."""
    with open_input(path, "--table") as stream:
        text = stream.read().decode(errors="replace")
    reasons, lines = _REASON.findall(text), Lines()
    for row in records(re.sub(r"(?m)^#.*\n", "", text)):
        try:
            sound = row["quantity"] == OUTCOME or isfinite(float(row["value"]))
            if not sound or set(row) != {*COLUMNS} or KEY(row) in lines:
                raise ValueError
            reasons[int(row["change"]) - 1]
        except (ValueError, TypeError, LookupError) as error:
            fault, given = "is no number with its reason, or stands twice", map(str, row.values())
            raise InputError(path.name, ",".join(given), fault, "restore the line") from error
        lines[KEY(row)] = row
    return reasons, lines


def changes(before: Lines, now: Lines) -> Iterator[tuple[str, Line | None, bool]]:
    """Differences: how, the line as of now (None: it is gone), and whether it may.

    Numbers beyond the accuracy of steps, and versions and inputs behind those that stay.
    """
    for key in now | before:
        old, new = before.get(key), now.get(key)
        text = "`{2}` of `{1}` in `{0}`: ".format(*key) + f"{_shown(old)} -> {_shown(new)}"
        if not old or not new:
            yield text, new, True
            continue
        why = "" if old["inputs"] == new["inputs"] else "its scenario, options or data are others"
        if old["version"] != new["version"]:
            why = f"model version {old['version']} -> {new['version']}"
        moved = old["value"] != new["value"]
        if moved and key[2] != OUTCOME:
            was, by = float(old["value"]), float(new["value"]) - float(old["value"])
            moved = abs(by) > max(ACCURACY * abs(was), ROUND_OFF)
            text += f", {percent(by / abs(was))}" if was else ""
        if moved:
            unchanged = f"model version {new['version']} unchanged: raise it, and give a reason"
            yield f"{text}; {why or unchanged}", new, bool(why)
        elif why:  # the value stays: small changes must not add up unseen
            yield "`{1}` in `{0}`: ".format(*key) + why, new | {"value": old["value"]}, True


def _shown(line: Line | None) -> str:
    if not line or line["quantity"] == OUTCOME:
        return line["value"] if line else "none"
    return in_unit(float(line["value"]), line["quantity"])


def minted(reasons: list[str], before: Lines, now: Lines) -> bytes:
    """The table as a file, with what differs now for the last of the `reasons` (date and words)."""
    last = {"change": str(len(reasons))}
    lines = {KEY(line): line | last for _, line, _ in changes(before, now) if line}
    head = "".join(f"# {number} {reason}\n" for number, reason in enumerate(reasons, 1))
    table = pd.DataFrame([lines.get(key) or before[key] for key in now], columns=COLUMNS)
    return (head + table.to_csv(index=False, lineterminator="\n")).encode()


def of_other_versions() -> list[str]:
    """Tables of the workbench that were measured with other versions of models than now."""
    head, _, _ = (bench_directory() / "workbench.csv").read_text(encoding="utf-8").partition("\n")
    texts = [("bench/workbench.csv", head.partition(": ")[2])]
    texts += [(f"bench/{case.name}", case.model) for case in load_bench()]
    texts += [(entry.file, entry.source) for entry in datasets() if "version " in entry.source]
    for name, measured in TABLES.items():
        rows = load(name)
        for who in ("reference", "anchor"):
            versions = rows[f"{who}_version"].unique()
            texts += [
                (f"validation/{name}.csv", f"{getattr(measured, who)} {each}") for each in versions
            ]
    present = {model: str(model_kind(model).version) for model in model_names()}
    return [
        f"`{place}` was measured with `{model}` {version}, which is now {present[model]}"
        for place, text in texts
        for model, version in _MODEL.findall(text)
        if present.get(model, version) != version
    ]
