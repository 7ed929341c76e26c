"""The answer in one sentence, and the numbers of several answers as one table."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import pandas as pd

from workbench.content.formatting import in_unit, number, unit_of
from workbench.evidence.error_model import PEAK, ExpectedError
from workbench.responses import (
    VARIABLES,
    Response,
    collapse_of,
    findings_of,
    outcome_of,
    scalars_of,
    survives,
)

TABLED = (PEAK, "time_of_peak", "residual_displacement", "peak_force", "impulse")


def headline(response: Response) -> str:
    """The answer in one sentence: peak, interval of 90 % for the truth, fate, model and why."""
    values, error = scalars_of(response), error_of(response)
    parts = [fate_of(response)]
    if PEAK in values:
        parts.insert(0, f"{in_unit(values[PEAK], PEAK, 3)}{_interval(values[PEAK], error)}")
    elif "force" in response:
        parts.insert(0, f"largest force {in_unit(float(response['force'].max()), 'force', 3)}")
    elif values:
        name, value = next(iter(values.items()))
        parts.insert(0, f"{VARIABLES[name].long_name} {in_unit(value, name, 3)}")
    model, because = response.attrs["model"], response.attrs.get("because", "as asked")
    return "; ".join((*filter(None, parts), f"by {model}, {because}"))


def fate_of(response: Response) -> str:
    """What becomes of the structure, in words; empty where nothing is struck."""
    collapse, known = collapse_of(response), survives(response)
    if collapse is not None:
        return f"collapses: {collapse.mechanism} ({', '.join(collapse.parts)})"
    if not outcome_of(response).is_answer:
        return f"no answer, {outcome_of(response).value}"
    if known is None:
        return "stands or not: the record ends before the peak"
    return "stands" if PEAK in response or "force" in response else ""


def _interval(peak: float, error: ExpectedError) -> str:
    if error.low is None or error.high is None:
        return ""
    factor = unit_of(PEAK).factor
    least, most = (number(peak / (1.0 + share) * factor, 3) for share in (error.high, error.low))
    return f", 90 %: {least} to {most}"


def error_of(response: Response) -> ExpectedError:
    """The error to expect of an answer; one without advice on it has none."""
    stored = response.attrs.get("error")
    if stored is None:
        return ExpectedError("", reason="ask `workbench.simulate`, which adds the error to expect")
    return ExpectedError(**json.loads(stored))


def compared(responses: Mapping[str, Response], reference: str = "") -> pd.DataFrame:
    """A row per answer, SI; `error` is the peak over that of the `reference` less one."""
    rows: list[dict[str, Any]] = []
    for label, response in responses.items():
        values = scalars_of(response)
        warned = [each.subject for each in findings_of(response)]
        rows.append(
            {"model": label, "outcome": outcome_of(response).value}
            | {name: values.get(name, float("nan")) for name in TABLED}
            | {"wall_time": float(response.attrs["wall_time"]), "findings": ", ".join(warned)}
        )
    table = pd.DataFrame(rows)
    held = table.loc[table["model"] == reference, PEAK]
    error = table[PEAK] / held.iloc[0] - 1.0 if len(held) else float("nan")
    table.insert(3, "error", error)
    return table
