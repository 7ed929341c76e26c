"""Where the study `which_model` found a model off: its rules of validity, as data.

`workbench data rules` writes the table; a row is a region of a model, told by bounds of what
a scenario says before anything is run, with what was measured there and the model that did best.
A second table holds what the columns of the study spanned: outside, nothing is expected from them.
"""

from collections.abc import Iterable
from functools import lru_cache
from math import inf, isnan
from typing import Any, NamedTuple

import numpy as np

from workbench.arrays import Array, Flags, Indices
from workbench.models.descriptors import (
    FEATURES,
    beyond,
    descriptors,
    features,
    measured_rows,
    region_of,
    variant_of,
)
from workbench.models.domain import RESTITUTION
from workbench.responses import Finding
from workbench.scenarios import ColumnImpact

TABLE, RANGES = "validity", "validity-ranges"
BEYOND = 0.10  # error of the peak that is told
_OFF = f"{100.0 * BEYOND:g} % off"
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

    And bounds (rows, features) of their regions, infinite where they bound nothing.
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
    rows = measured_rows(TABLE)
    risky: dict[tuple[str, str], list[int]] = {}
    for number, row in enumerate(rows):
        own = risky.setdefault((row["model"], row["options"]), [])
        own += [number] if chance_of(row) > TOLERATED else []
    numbers = {of: np.array(which, dtype=np.int64) for of, which in risky.items()}
    low, high = (
        np.array([[row[f"{name}_{end}"] for name in FEATURES] for row in rows])
        for end in ("low", "high")
    )
    return _Rules(rows, numbers, low, high)


def chance_of(row: dict[str, Any]) -> float:
    """Expected share of cases beyond the bound, the mean of its posterior: few cases warn."""
    return float((row["low"] + row["high"] + 1.0) / (row["count"] + 2.0))


@lru_cache(maxsize=1024)
def _better(number: int, there: tuple[int, ...]) -> tuple[str, ...]:
    """Models with less chance to be off than that of a row, by the rows that hold `there`.

    First the one that did best in the region of the row.
    """
    row, rows = _rules().rows[number], [_rules().rows[i] for i in there]
    chances = {other["model"]: chance_of(other) for other in rows if not other["options"]}
    less = [name for name, chance in chances.items() if chance < chance_of(row)]
    return tuple(sorted(less, key=lambda name: (name != row["better"], chances[name])))


def _told(
    row: dict[str, Any], own: dict[str, float], better: tuple[str, ...], bounces: bool
) -> Finding:
    """What was measured in a region, the numbers of this column beside its bounds."""
    where = _region(row, own) + ("; all without restitution" if bounces else "")
    text = how_often(row, f"columns like this ({where})")
    if not isnan(row["bias"]):
        ends = (100.0 * (row[name] - 1.0) for name in ("bias", "least", "most"))
        text += "; expect {:+.0f} % ({:+.0f} to {:+.0f} %)".format(*ends)
    if row["falls"] + row["stands"]:
        text += (
            f"; {row['falls']:.0f} collapsed where the reference survives, {row['stands']:.0f} "
            "survived where it collapses"
        )
    return measured_finding(row, text, better)


def how_often(row: dict[str, Any], like: str) -> str:
    """In how many of the cases `like` this one a model was off, in words."""
    off = row["low"] + row["high"]
    text = f"in {off:.0f} of {row['count']:.0f} {like} the peak was more than {_OFF}"
    if not off:
        return text + ", but that few prove little"
    return text + f", {row['low']:.0f} too small and {row['high']:.0f} too large"


def measured_finding(row: dict[str, Any], text: str, better: tuple[str, ...] = ()) -> Finding:
    """The warning of a row of a table, of less weight where fewer than half of the cases were off.

    `better` models are asked first.
    """
    share = _share(row)
    return Finding(RISK if share <= 0.5 else SUBJECT, text, number=share, instead=better)


def _unknown(row: dict[str, Any], own: dict[str, float], outside: Iterable[str]) -> Finding:
    """That nobody measured such a hit, and what the region holds of those that were drawn."""
    share = _share(row)
    text = (
        f"what to expect here is not known ({'; '.join(outside)}); of the columns that were, in "
        f"the same region ({_region(row, own)}), {row['low'] + row['high']:.0f} of "
        f"{row['count']:.0f} had a peak more than {_OFF}"
    )
    return Finding(UNMEASURED[share <= 0.5], text, number=share, instead=())


def _region(row: dict[str, Any], own: dict[str, float]) -> str:
    """The region of a row in words, by the bounds that bound anything."""
    ends = {name: (row[f"{name}_low"], row[f"{name}_high"]) for name in FEATURES}
    return region_of({name: end for name, end in ends.items() if end != (-inf, inf)}, own)


def _share(row: dict[str, Any]) -> float:
    """Share of the cases of a row that were off."""
    return float((row["low"] + row["high"]) / row["count"])
