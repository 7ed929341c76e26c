"""What studies measured of models: where their peaks were in error, as rules of validity.

`workbench data rules` writes the table; a row is a region of a model, bounded in features that
a scenario has before anything is run, with what was measured there and the model that did best.
A second table holds what the columns of the study spanned: outside, nothing is expected from them.
"""

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from math import inf, isnan
from typing import Any, NamedTuple

import numpy as np

from workbench.arrays import Array, Indices
from workbench.evidence.descriptors import (
    FEATURES,
    beyond,
    descriptors,
    features,
    measured_rows,
    region_of,
    variant_of,
)
from workbench.frames.column_estimate import column_like
from workbench.models.base import Model
from workbench.models.column_of_frame import MODELS, ColumnOfFrame
from workbench.models.domain import RESTITUTION
from workbench.responses import Finding, Response, finding
from workbench.scenarios import ColumnImpact, FrameImpact, MemberPulse

TABLE, RANGES, PULSES = "validity", "validity-ranges", "pulses"
BEYOND = 0.10  # error of the peak from which a model warns
TOLERATED = 0.04  # chance of a column to be beyond it that needs no warning, see the theory page
TOLERATED_OF_PULSES = 0.1  # the same of a member under a pulse
SUBJECTS = (
    "measured",
    "measured-risk",
)  # most columns of the region are off, outside the domain; some
UNMEASURED = "unmeasured", "unmeasured-risk"  # the same where no such hit was drawn
MOSTLY = SUBJECTS[0], UNMEASURED[0]


def measured_findings(
    model: Model, scenario: Any, response: Response | None = None
) -> list[Finding]:
    """Warnings of a scenario in a region where the model was measured to be off.

    Of a hit outside what the study drew it says so, and what is known of the region. A striker
    that bounces is none: rules were measured without, and models say what bouncing does to them.
    A frame is looked up as its struck column; of that only what most columns did is reported,
    unless the model answers with this column. Of a pulse the ductility of the `response` counts.
    """
    if isinstance(scenario, MemberPulse):
        return [] if response is None else pulse_findings(model, scenario.load, response)
    if isinstance(scenario, ColumnImpact):
        return _column_findings(model, scenario)
    if not isinstance(scenario, FrameImpact):
        return []
    if isinstance(model, ColumnOfFrame):
        estimate = model.estimate(scenario)
        # columns of the study neither sway nor turn at their ends
        sways = any(each.subject == "sway" for each in estimate.findings())
        return [] if sways else _column_findings(MODELS[model.model], estimate.column)
    column = column_like(scenario) if _may_warn(model) else None
    findings = [] if column is None else _column_findings(model, column)
    return [each for each in findings if each.subject in MOSTLY]


def pulse_findings(model: Model, load: str, response: Response) -> list[Finding]:
    """Warning of a model where members of the study `drawn_pulses` were often off."""
    reached = ductility(response)
    for row in measured_rows(PULSES) if reached is not None else ():
        here = row["least"] <= reached < row["most"]
        risky = chance_of(row) > TOLERATED_OF_PULSES
        if (row["model"], row["load"]) == (model.name, load) and here and risky:
            state = "yielding" if row["least"] else "elastic"
            parts = (*_sides(row), "spread")
            return [_finding("measured-under-pulses", {**row, "state": state}, SUBJECTS, parts)]
    return []


def ductility(response: Response) -> float | None:
    """The peak of a single mass over that of an elastic one under the same resistance."""
    if not {"displacement", "force"} <= set(response.data_vars):
        return None
    displacement, force = response["displacement"].values, response["force"].values
    first, top = int(np.argmax(displacement > 0.0)), int(np.argmax(displacement))
    if not force[top] > 0.0:
        return None
    return float(displacement[top] / force[top] * force[first] / displacement[first])


class _Rules(NamedTuple):
    """Rows of the table, numbers of the `risky` ones of each model and options, which warn.

    And bounds (rows, features) of their regions, infinite where they bound nothing.
    """

    rows: list[dict[str, Any]]
    risky: dict[tuple[str, str], Indices]
    low: Array
    high: Array

    def holding(self, point: Array, numbers: Indices) -> Indices:
        """Those of the rows of these numbers in whose regions a point (features,) lies."""
        outside = (point < self.low[numbers]) | (point >= self.high[numbers])
        return numbers[~outside.any(axis=1)]


@lru_cache(maxsize=1)
def _rules() -> _Rules:
    """The table, read once."""
    rows = measured_rows(TABLE)
    risky: dict[tuple[str, str], list[int]] = {}
    for number, row in enumerate(rows):
        numbers = risky.setdefault((row["model"], row["options"]), [])
        if chance_of(row) > TOLERATED:
            numbers.append(number)
    low, high = (
        np.array([[row[f"{name}_{end}"] for name in FEATURES] for row in rows])
        for end in ("low", "high")
    )
    return _Rules(rows, {key: np.array(n, dtype=np.int64) for key, n in risky.items()}, low, high)


def _may_warn(model: Model) -> bool:
    """Whether the model was measured to be off anywhere."""
    numbers = _rules().risky.get((model.name, variant_of(model)))
    return numbers is not None and bool(numbers.size)


def _column_findings(model: Model, scenario: ColumnImpact) -> list[Finding]:
    if not _may_warn(model):
        return []
    rules, described = _rules(), descriptors(scenario)
    values = features(scenario, described)
    point = np.array(list(values.values()))
    risky = rules.holding(point, rules.risky[model.name, variant_of(model)]).tolist()
    if not risky:
        return []
    outside = beyond({**described, RESTITUTION: 0.0}, RANGES)
    if outside:
        return [_unknown(rules.rows[i], values, outside.values()) for i in risky]
    everywhere = rules.holding(point, np.arange(len(rules.rows)))
    others = [rules.rows[i] for i in everywhere.tolist()]
    bounces = scenario.striker.restitution > 0.0
    return [_known(rules.rows[i], values, others, bounces) for i in risky]


def chance_of(row: dict[str, Any]) -> float:
    """Expected share of cases beyond the bound, the mean of its posterior: few cases warn."""
    return float((row["low"] + row["high"] + 1.0) / (row["count"] + 2.0))


def _better(row: dict[str, Any], others: list[dict[str, Any]]) -> tuple[str, ...]:
    """Models with less chance to be off than that of a row, by the `others` that hold the column.

    First the one that did best in the region of the row.
    """
    chances = {other["model"]: chance_of(other) for other in others if not other["options"]}
    less = [name for name, chance in chances.items() if chance < chance_of(row)]
    return tuple(sorted(less, key=lambda name: (name != row["better"], chances[name])))


def _known(
    row: dict[str, Any], values: dict[str, float], others: list[dict[str, Any]], bounces: bool
) -> Finding:
    """What was measured in a region, the values of this column beside its bounds."""
    parts = {
        "errors": not isnan(row["bias"]),
        "collapses": row["false_alarm"] + row["false_safe"] > 0,
        "restitution": bounces,
    }
    present = (*_sides(row), *(name for name, here in parts.items() if here))
    errors = {name: 100.0 * (row[name] - 1.0) for name in ("bias", "least", "most")}
    known = {**row, **errors, "region": _region(row, values)}
    return replace(_finding("measured", known, SUBJECTS, present), instead=_better(row, others))


def _unknown(row: dict[str, Any], values: dict[str, float], outside: Iterable[str]) -> Finding:
    """That nobody measured such a hit, and what the region holds of those that were drawn."""
    known = {**row, "region": _region(row, values), "outside": "; ".join(outside)}
    return _finding("unmeasured", known, UNMEASURED)


def _sides(row: dict[str, Any]) -> tuple[str]:
    """The part of a sentence that says how many peaks were too small and too large."""
    return ("sides",) if row["low"] + row["high"] else ("few",)


def _finding(
    name: str, row: dict[str, Any], subjects: tuple[str, str], parts: tuple[str, ...] = ()
) -> Finding:
    """The finding of a row, by the second of its subjects where fewer than half were off."""
    off = row["low"] + row["high"]
    share = float(off / row["count"])
    subject = subjects[share <= 0.5]
    return finding(name, share, subject, parts=parts, off=off, bound=100.0 * BEYOND, **row)


def _region(row: dict[str, Any], values: dict[str, float]) -> str:
    """The region of a row in words, by the bounds that bound anything."""
    ends = {name: (row[f"{name}_low"], row[f"{name}_high"]) for name in FEATURES}
    return region_of({name: end for name, end in ends.items() if end != (-inf, inf)}, values)
