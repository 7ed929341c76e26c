"""Where the study `which_model` found a model off: its rules of validity, as data.

`workbench data rules` writes the table; a row is a region of a model, told by bounds of what
a scenario says before anything is run, with what was measured there and the model that did best.
"""

import csv
from collections.abc import Collection
from functools import lru_cache
from math import inf
from typing import Any

from workbench.datafiles import data_directory
from workbench.models.descriptors import FEATURES, asked_for, features, region_of, variant_of
from workbench.responses import Finding
from workbench.scenarios import ColumnImpact

TABLE = "validity"
BEYOND = 0.10  # error of the peak that is told
TOLERATED = 0.04  # chance of a column to be beyond it that needs no warning, see the theory page
SUBJECT = "measured"  # most columns of the region are off: outside the domain
RISK = "measured-risk"  # some are
REFERENCE = "fiber-shear"  # ends the chain of remedies


def measured_findings(
    model: Any, scenario: Any, others: Collection[str] | None = None
) -> list[Finding]:
    """Warning of a column in a region where the model was measured to be off.

    `others`, names of the models that the remedy may name (None: all that were measured).
    """
    if not isinstance(scenario, ColumnImpact):
        return []
    rules = _rules().get((model.name, variant_of(model)))
    if rules is None:
        return []
    own = features(scenario)
    held = [row for row in rules if _holds(row, own) and _chance(row) > TOLERATED]
    return [_told(row, own, _remedy(row, own, others)) for row in held]


@lru_cache(maxsize=1)
def _rules() -> dict[tuple[str, str], list[dict[str, Any]]]:
    """Rows of the table by model and options."""
    path = data_directory() / "validation" / f"{TABLE}.csv"
    found: dict[tuple[str, str], list[dict[str, Any]]] = {}
    with path.open(newline="", encoding="utf-8") as stream:
        for row in csv.DictReader(stream):
            found.setdefault((row["model"], row["options"]), []).append(_typed(row))
    return found


def _typed(row: dict[str, str]) -> dict[str, Any]:
    """Numbers of a row as such; under `bounds` those of the region that bound anything."""
    words = ("model", "options", "better", "study")
    typed = {name: v if name in words else float(v) if v else None for name, v in row.items()}
    ends = {name: (typed[f"{name}_low"], typed[f"{name}_high"]) for name in FEATURES}
    bounds = {name: end for name, end in ends.items() if end != (-inf, inf)}
    return {**typed, "bounds": bounds}


def _holds(row: dict[str, Any], own: dict[str, float]) -> bool:
    return all(low <= own[name] < high for name, (low, high) in row["bounds"].items())


def _chance(row: dict[str, Any]) -> float:
    """Expected share of columns beyond the bound, the mean of its posterior: few columns warn."""
    return float((row["low"] + row["high"] + 1.0) / (row["count"] + 2.0))


def _remedy(row: dict[str, Any], own: dict[str, float], others: Collection[str] | None) -> str:
    """The model to take instead of that of a row: one with less chance to be off here by its rule.

    So no chain of remedies comes back. First the one that did best in the region of the row, then
    the one with the least chance, then the reference.
    """
    chances = {
        f"{name} {options}".rstrip(): _chance(other)
        for (name, options), rows in _rules().items()
        for other in rows
        if (others is None or name in others) and _holds(other, own)
    }
    least, best = _chance(row), row["better"]
    if chances.get(best, least) < least:
        found = f"take {asked_for(best)}, off in {row['better_off']:.0f} of "
        found += f"{row['better_count']:.0f} there"
    else:
        best = min(chances, key=lambda name: chances[name], default="")
        if chances.get(best, least) >= least:
            return f"take {REFERENCE}"
        found = f"take {asked_for(best)}, less often off here"
    return found if chances[best] <= TOLERATED else f"{found}, or {REFERENCE}"


def _told(row: dict[str, Any], own: dict[str, float], remedy: str) -> Finding:
    """What was measured in a region, the numbers of this column beside its bounds."""
    where = region_of(row["bounds"], own)
    beyond, apart = row["low"] + row["high"], row["falls"] + row["stands"]
    text = (
        f"in {beyond:.0f} of {row['count']:.0f} columns like this ({where}) the peak was more than "
        f"{100.0 * BEYOND:g} % off"
    )
    if beyond:
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
    share = float(beyond / row["count"])
    return Finding(SUBJECT if share > 0.5 else RISK, text, remedy=remedy, number=share)
