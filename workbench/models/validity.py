"""Where the study `which_model` found a model off: its rules of validity, as data.

`workbench data rules` writes the table; a row is a region of a model, told by bounds of what
a scenario says before anything is run, with what was measured there and the model that did best.
A second table holds what the columns of the study spanned: outside, nothing is expected from them.
"""

import csv
from collections.abc import Iterable
from functools import lru_cache
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np

from workbench.arrays import Array, Flags, Indices
from workbench.datafiles import data_directory
from workbench.models.descriptors import (
    FEATURES,
    beyond,
    descriptors,
    features,
    region_of,
    variant_of,
)
from workbench.models.domain import RESTITUTION
from workbench.responses import Finding
from workbench.scenarios import ColumnImpact

TABLE, RANGES = "validity", "validity-ranges"
BEYOND = 0.10  # error of the peak that is told
TOLERATED = 0.04  # chance of a column to be beyond it that needs no warning, see the theory page
SUBJECT = "measured"  # most columns of the region are off: outside the domain
RISK = "measured-risk"  # some are
UNMEASURED = f"un{SUBJECT}", f"un{RISK}"  # the same where the hit is none of those that were drawn
MOSTLY = SUBJECT, UNMEASURED[0]


def may_warn(model: Any) -> bool:
    """Whether the model was measured to be off anywhere."""
    numbers = _rules().risky.get((model.name, variant_of(model)))
    return numbers is not None and bool(numbers.size)


def measured_findings(model: Any, scenario: Any) -> list[Finding]:
    """Warning of a column in a region where the model was measured to be off.

    Of a hit outside what the study drew it says so, and what is known of the region. A striker
    that bounces is none: rules were measured without, and models say what bouncing does to them.
    """
    if not isinstance(scenario, ColumnImpact) or not may_warn(model):
        return []
    rules = _rules()
    mine = rules.risky[model.name, variant_of(model)]
    told = descriptors(scenario)
    own = features(scenario, told)
    at = np.array(list(own.values()))
    risky = mine[_holds(rules, at, mine)].tolist()
    if not risky:
        return []
    outside = beyond({**told, RESTITUTION: 0.0}, RANGES)
    if outside:
        return [_unknown(rules.rows[i], own, outside.values()) for i in risky]
    there = tuple(np.flatnonzero(_holds(rules, at, slice(None))).tolist())
    bounces = scenario.striker.restitution > 0.0
    return [_told(rules.rows[i], own, _better(i, there), bounces) for i in risky]


class _Rules(NamedTuple):
    """Rows of the table, numbers of the `risky` ones of each model and options, which warn.

    And bounds (rows, features) of their regions: NaN, which no number is below or above, where they
    bound nothing.
    """

    rows: list[dict[str, Any]]
    risky: dict[tuple[str, str], Indices]
    low: Array
    high: Array


def _holds(rules: _Rules, at: Array, numbers: Any) -> Flags:
    """In which of the rows of these numbers the features `at` (features,) lie."""
    return np.asarray(~((at < rules.low[numbers]) | (at >= rules.high[numbers])).any(axis=1))


@lru_cache(maxsize=1)
def _rules() -> _Rules:
    """The table."""
    path = data_directory() / "validation" / f"{TABLE}.csv"
    with path.open(newline="", encoding="utf-8") as stream:
        rows = [_typed(row) for row in csv.DictReader(stream)]
    risky: dict[tuple[str, str], list[int]] = {}
    for number, row in enumerate(rows):
        own = risky.setdefault((row["model"], row["options"]), [])
        own += [number] if row["chance"] > TOLERATED else []
    ends = [[row["bounds"].get(name, (nan, nan)) for name in FEATURES] for row in rows]
    low, high = np.moveaxis(np.array(ends).reshape(-1, len(FEATURES), 2), 2, 0)
    told = {of: np.array(numbers, dtype=np.int64) for of, numbers in risky.items()}
    return _Rules(rows, told, low, high)


def _typed(row: dict[str, str]) -> dict[str, Any]:
    """Numbers of a row as such; under `bounds` those of the region that bound anything."""
    words = ("model", "options", "better", "study")
    typed = {name: v if name in words else float(v) if v else None for name, v in row.items()}
    ends = {name: (typed[f"{name}_low"], typed[f"{name}_high"]) for name in FEATURES}
    bounds = {name: end for name, end in ends.items() if end != (-inf, inf)}
    return {**typed, "bounds": bounds, "chance": _chance(typed)}


def _chance(row: dict[str, Any]) -> float:
    """Expected share of columns beyond the bound, the mean of its posterior: few columns warn."""
    return float((row["low"] + row["high"] + 1.0) / (row["count"] + 2.0))


@lru_cache(maxsize=1024)
def _better(number: int, there: tuple[int, ...]) -> tuple[str, ...]:
    """Models with less chance to be off than that of a row, by the rows that hold `there`.

    First the one that did best in the region of the row.
    """
    row, rows = _rules().rows[number], [_rules().rows[i] for i in there]
    chances = {other["model"]: other["chance"] for other in rows if not other["options"]}
    less = [name for name, chance in chances.items() if chance < row["chance"]]
    return tuple(sorted(less, key=lambda name: (name != row["better"], chances[name])))


def _told(
    row: dict[str, Any], own: dict[str, float], better: tuple[str, ...], bounces: bool
) -> Finding:
    """What was measured in a region, the numbers of this column beside its bounds."""
    where = region_of(row["bounds"], own) + ("; all without restitution" if bounces else "")
    (off, share), apart = _off(row), row["falls"] + row["stands"]
    text = (
        f"in {off:.0f} of {row['count']:.0f} columns like this ({where}) the peak was more than "
        f"{100.0 * BEYOND:g} % off"
    )
    if off:
        text += f", {row['low']:.0f} too small and {row['high']:.0f} too large"
    else:
        text += ", but that few prove little"
    if row["bias"] is not None:
        ends = (100.0 * (row[name] - 1.0) for name in ("bias", "least", "most"))
        text += "; expect {:+.0f} % ({:+.0f} to {:+.0f} %)".format(*ends)
    if apart:
        text += (
            f"; {row['falls']:.0f} collapsed where the reference survives, {row['stands']:.0f} "
            "survived where it collapses"
        )
    return Finding(RISK if share <= 0.5 else SUBJECT, text, number=share, instead=better)


def _unknown(row: dict[str, Any], own: dict[str, float], outside: Iterable[str]) -> Finding:
    """That nobody measured such a hit, and what the region holds of those that were drawn."""
    off, share = _off(row)
    text = (
        f"what to expect here is not known ({'; '.join(outside)}); of the columns that were, in "
        f"the same region ({region_of(row['bounds'], own)}), {off:.0f} of {row['count']:.0f} had a "
        f"peak more than {100.0 * BEYOND:g} % off"
    )
    subject = UNMEASURED[share <= 0.5]
    return Finding(subject, text, number=share, instead=())


def _off(row: dict[str, Any]) -> tuple[float, float]:
    """Columns of a region that were off, and their share."""
    off = row["low"] + row["high"]
    return off, float(off / row["count"])
