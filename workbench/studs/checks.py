"""What must fit together within one row of a table of tests."""

from __future__ import annotations

from collections.abc import Iterator
from math import isnan, pi

from workbench.studs.schema import NO_PREDAMAGE

Row = dict[str, object]
Finding = tuple[str, object, str, str]  # column, value, reason, advice

TOTAL_TOLERANCE = 0.02  # load per stud times studs against the total: both are rounded
LEAST_STRESS, LARGEST_STRESS = 10.0, 2500.0  # MPa, load over shank area of any plausible test
LEAST_SLENDERNESS, LARGEST_SLENDERNESS = 1.5, 25.0  # height over diameter
_MEASURED = {"push-out": ("shear_kN",), "pull-out": ("tension_kN",)}
_LOADS = ("shear_kN", "tension_kN")  # both in a combined test


def row_findings(row: Row, table: str) -> Iterator[Finding]:
    """Contradictions within a row: column, value, reason and advice of each.

    Arguments: `row`, cells by column name, single cells already checked; `table`, name of its
    schema.
    """
    if table == "tests":
        yield from _results(row)
        yield from _sizes(row)
        yield from _predamage(row)


def _value(row: Row, column: str) -> float | None:
    value = row.get(column)
    return None if not isinstance(value, float) or isnan(value) else value


def _results(row: Row) -> Iterator[Finding]:
    if _value(row, "strength_over_nominal") is None:
        for column in _MEASURED.get(str(row["test"]), _LOADS):
            if _value(row, column) is None:
                yield column, "", f"must be given for a {row['test']} test", ""
    elif not row.get("nominal_model"):
        yield "nominal_model", "", "must name the formula of strength_over_nominal", ""
    shear, studs, total = (_value(row, c) for c in ("shear_kN", "n_studs", "total_load_kN"))
    if shear and studs and total and abs(shear * studs / total - 1.0) > TOTAL_TOLERANCE:
        advice = f"{studs:g} studs of {shear:g} kN make {shear * studs:.4g} kN"
        yield "total_load_kN", total, "does not fit shear_kN and n_studs", advice
    diameter = _value(row, "diameter_mm")
    for column in _LOADS:
        load = _value(row, column)
        if load and diameter:
            stress = 1e3 * load / (0.25 * pi * diameter**2)
            if not LEAST_STRESS <= stress <= LARGEST_STRESS:
                reason = f"means {stress:.3g} MPa over a shank of {diameter:g} mm"
                yield column, load, reason, "loads are in kN per stud, diameters in mm"


def _sizes(row: Row) -> Iterator[Finding]:
    diameter, height = _value(row, "diameter_mm"), _value(row, "height_mm")
    if diameter and height:
        slenderness = height / diameter
        if not LEAST_SLENDERNESS <= slenderness <= LARGEST_SLENDERNESS:
            yield "height_mm", height, f"is {slenderness:.3g} times the diameter", "both are in mm"
    strength, ultimate = _value(row, "fy_MPa"), _value(row, "fu_MPa")
    if strength and ultimate and strength > ultimate:
        yield "fy_MPa", strength, f"exceeds the tensile strength {ultimate:g} MPa", ""
    head = _value(row, "head_diameter_mm")
    if head and diameter and head <= diameter:
        yield "head_diameter_mm", head, f"must exceed the shank, {diameter:g} mm", ""


def _predamage(row: Row) -> Iterator[Finding]:
    kind, level = row.get("predamage", NO_PREDAMAGE), _value(row, "predamage_level")
    if kind == NO_PREDAMAGE:
        if level:
            yield "predamage_level", level, "needs a predamage other than none", ""
        return
    if level is None:
        advice = "0 for none, 1 for what an undamaged stud bears"
        yield "predamage_level", "", f"must be given with predamage {kind}", advice
    if not row.get("predamage_measure"):
        yield "predamage_measure", "", "must say what the level of damage measures", ""
