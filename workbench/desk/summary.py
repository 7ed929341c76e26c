"""The answer in one sentence, and the numbers of several answers as one table."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import pandas as pd

from workbench.content.formatting import in_unit, number, unit_of
from workbench.evidence.error_model import PEAK, ExpectedError
from workbench.responses import Response, collapse_of, findings_of, outcome_of, scalars_of, survives

_COLUMNS = (PEAK, "time_of_peak", "residual_displacement", "peak_force", "impulse")
_FATES = {True: "stands", False: "collapses", None: "fate not known"}


def headline(response: Response) -> str:
    """The answer in one sentence: peak, interval of 90 % for the truth, fate, model and why."""
    because = response.attrs.get("because", "as asked")
    peak, error = scalars_of(response).get(PEAK), error_of(response)
    parts = [] if peak is None else [f"{in_unit(peak, PEAK, 3)}{_interval(peak, error)}"]
    fate = _FATES[survives(response)]
    collapse = collapse_of(response)
    if collapse is not None:
        fate += f" ({collapse.mechanism}: {', '.join(collapse.parts)})"
    elif peak is None and survives(response) is None:
        fate = f"no answer ({outcome_of(response).value})"
    return "; ".join((*parts, fate, f"by {response.attrs['model']}, {because}"))


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
            | {name: values.get(name, float("nan")) for name in _COLUMNS}
            | {"wall_time": float(response.attrs["wall_time"]), "findings": ", ".join(warned)}
        )
    table = pd.DataFrame(rows)
    held = table.loc[table["model"] == reference, PEAK]
    error = table[PEAK] / held.iloc[0] - 1.0 if len(held) else float("nan")
    table.insert(3, "error", error)
    return table
