"""EN 1994-1-1 Annex B.2 on the rows of a table: series of nominally equal push tests."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.studs.quantities import Array, undamaged_headed_studs
from workbench.studs.statistics.annex_b import AnnexB, evaluate_series

EQUAL = ("campaign", "diameter_mm", "height_mm", "slab", "stud_spacing", "fcm_MPa", "fu_MPa")


class Series(NamedTuple):
    """Nominally equal tests: their name, how many, and the result or why there is none."""

    name: str
    tests: int
    result: AnnexB | None
    refusal: str

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        result = None if self.result is None else self.result.to_dict()
        return {**self._asdict(), "result": result}


def evaluate_groups(
    table: pd.DataFrame,
    points: pd.DataFrame | None = None,
    *,
    specified_strength: float,
    partial_factor: float = 1.25,
) -> list[Series]:
    """Every group of nominally equal tests of a table, evaluated or refused with the reason.

    Arguments as in `evaluate_table`; curves are used where all tests of a group have one. Raises
    `InputError` for a table without undamaged headed studs.
    """
    rows = undamaged_headed_studs(table)
    curved = set() if points is None else set(_names(points))
    result = []
    for _, group in rows.groupby(list(EQUAL), sort=False, dropna=False):
        first = group.iloc[0]
        words = [str(first["campaign"]), f"{first['diameter_mm']:g} mm"]
        words += [str(first[c]) for c in ("slab", "stud_spacing") if first[c]]
        found, why = None, ""
        try:
            found = evaluate_table(
                group,
                points if set(_names(group)) <= curved else None,
                specified_strength=specified_strength,
                partial_factor=partial_factor,
            )
        except InputError as error:
            why = f"{error.allowed}; {error.advice}" if error.advice else error.allowed
        result.append(Series(", ".join(words), len(group), found, why))
    return result


def evaluate_table(
    table: pd.DataFrame,
    points: pd.DataFrame | None = None,
    *,
    specified_strength: float,
    partial_factor: float = 1.25,
) -> AnnexB:
    """Evaluate the undamaged headed studs of a table as one series (see `evaluate_series`).

    Arguments: `table` (schema `TESTS`) with the rows of the series only; `points` (schema `POINTS`)
    with their load-slip curves to beyond the maximum, for the slip capacity; minimum
    `specified_strength` of the stud material in Pa; `partial_factor`. Raises `InputError` when the
    rows are not nominally equal, or a curve is missing.
    """
    rows = undamaged_headed_studs(table)
    for column in EQUAL:
        values = sorted(set(rows[column].astype(str)))
        if len(values) > 1:
            reason = "differs: a series of Annex B has nominally equal tests"
            raise InputError(column, ", ".join(values), reason, "choose the rows of one kind")
    measured = float(rows["fu_MPa"].iloc[0])
    if not np.isfinite(measured):
        raise InputError("fu_MPa", None, "must be given: P_Rd is related to the measured strength")
    return evaluate_series(
        1e3 * rows["shear_kN"].to_numpy(float),
        specified_strength=specified_strength,
        measured_strength=1e6 * measured,
        curves=[] if points is None else [_curve(points, *name) for name in _names(rows)],
        partial_factor=partial_factor,
    )


def _names(table: pd.DataFrame) -> list[tuple[str, str]]:
    return list(zip(table["campaign"], table["specimen"], strict=True))


def _curve(points: pd.DataFrame, campaign: str, specimen: str) -> tuple[Array, Array]:
    own = points[(points["campaign"] == campaign) & (points["specimen"] == specimen)]
    own = own[own["branch"] != "low-load reading"]
    if own.empty:
        advice = "give the curves of all tests, or none"
        raise InputError("points", f"{campaign} {specimen}", "has no curve", advice)
    return 1e-3 * own["slip_mm"].to_numpy(float), 1e3 * own["load_kN"].to_numpy(float)
