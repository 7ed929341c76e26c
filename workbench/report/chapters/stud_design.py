"""Numbers that a designer of studs asks for, from the stored fits."""

from __future__ import annotations

from collections.abc import Iterator
from textwrap import wrap
from typing import Any

from workbench.content.formatting import number, percent
from workbench.content.tree import Block, Callout, Cell, Column, Paragraph, Section, Table
from workbench.report.chapters.stud_evidence import Answered, answers
from workbench.report.stored import Stored
from workbench.studs.strength import LEAST_FOR_DESIGN
from workbench.study.definition import Study

KILO, MILLI = 1e-3, 1e3
_LEAST_IN_SERIES = 3  # tests, EN 1994-1-1, B.2.5
_LEVELS = (0.25, 0.5, 0.75, 1.0)  # of damage
_GRADE_WIDTH = 30  # characters of a line


def design(study: Study, stored: Stored) -> Section | None:
    """Tables of D.8, Annex B, campaigns left out, load-slip parameters and what is left."""
    found = list(answers(study, stored))
    if not found:
        return None
    blocks: list[Block] = []
    for part in (_d8, _left_out, _series, _load_slip, _residual):
        blocks.extend(part(found))
    return Section("design", "Design numbers", tuple(blocks)) if blocks else None


def _formulas(found: list[Answered]) -> list[tuple[str, str, dict[str, Any]]]:
    """Case, label and fit of every formula, once per label: where it has most tests."""
    best: dict[str, tuple[str, str, dict[str, Any]]] = {}
    for case, label, asked, content in found:
        fit = content.get("fit") or {}
        if asked != "strength" or "d8" not in fit:
            continue
        if label not in best or fit["tests"] > best[label][2]["tests"]:
            best[label] = case, label, fit
    return [entry for entry in best.values() if len(entry[2]["campaigns"]) > 1] or [*best.values()]


def _d8(found: list[Answered]) -> Iterator[Block]:
    formulas = _formulas(found)
    if not formulas:
        return
    _, _, first = formulas[0]
    reference = first["reference"]
    yield Paragraph(
        "EN 1990 D.8 [@en1990] for the stud in the middle of the tests: "
        f"d = {number(MILLI * reference['diameter'], 3)} mm, "
        f"h = {number(MILLI * reference['height'], 3)} mm, "
        f"f_cm = {number(reference['concrete_strength'] / 1e6, 3)} MPa, "
        f"f_u = {number((reference['ultimate_strength'] or 0.0) / 1e6, 3)} MPa. The coefficients "
        "of variation of structures to come are assumptions: diameter 1 %, concrete strength 15 %, "
        "its modulus 10 %, stud strength 5 %. gamma_M* is the nominal value of the code, without "
        "partial factor, over the design value found here; EN 1994-1-1 has 1.25."
    )
    rows = []
    for case, label, fit in formulas:
        d8 = fit["d8"]
        rows.append(
            (
                Cell(f"{label}\n({case}, {fit['tests']} tests)"),
                *(_number(d8[name], 3) for name in ("b", "V_delta", "V_rt", "V_r", "k_n", "k_dn")),
                *(_number(d8[name], 4, KILO) for name in ("r_m", "r_k")),
                *(_number(value, 4, factor) for value, factor in _design_values(d8)),
            )
        )
    columns = (
        Column("formula", width=2.2),
        *(Column(name, True, 0.75) for name in ("b", "V_δ", "V_rt", "V_r", "k_n", "k_d,n")),
        *(Column(f"{name} (kN)", True, 0.95) for name in ("g_rt(X_m)", "r_k", "r_d")),
        Column("γ_M", True, 0.75),
        Column("γ_M*", True, 0.75),
    )
    caption = (
        "EN 1990 D.8: correction b, scatter of the formula V_δ, of the basic variables V_rt and of "
        "both V_r, fractile factors, resistance at mean values, characteristic and design value."
    )
    yield Table("design-d8", caption, columns, tuple(rows))


def _design_values(d8: dict[str, Any]) -> tuple[tuple[float | None, float], ...]:
    """Design value and partial factors, where EN 1990 has a fractile factor, with their units."""
    given = d8["count"] >= LEAST_FOR_DESIGN
    values = ((d8["r_d"], KILO), (d8["gamma_m"], 1.0), (d8["gamma_m_star"], 1.0))
    return tuple((value if given else None, factor) for value, factor in values)


def _left_out(found: list[Answered]) -> Iterator[Block]:
    rows = []
    for _, label, fit in _formulas(found):
        for each in fit["left_out"]:
            covered = each["covered"]
            rows.append(
                (
                    Cell(label),
                    Cell(each["campaign"]),
                    Cell(str(each["count"]), each["count"]),
                    Cell(percent(each["bias"]), each["bias"]),
                    Cell(percent(each["rms"], signed=False), each["rms"]),
                    Cell("none: too few campaigns", tone="doubt")
                    if covered is None
                    else Cell(percent(covered, signed=False), covered),
                )
            )
    if not rows:
        return
    columns = (
        Column("formula", width=2.4),
        Column("campaign left out", width=1.6),
        Column("tests", True, 0.7),
        Column("bias of the log ratio", True, 1.3),
        Column("its root mean square", True, 1.4),
        Column("inside the 90 % band", True, 1.8),
    )
    caption = (
        "Every campaign predicted by the formula with the bias of the others: negative, the tests "
        "bore less than predicted."
    )
    yield Table("design-left-out", caption, columns, tuple(rows))


def _series(found: list[Answered]) -> Iterator[Block]:
    groups: list[dict[str, Any]] = next(
        (c["series"] for _, _, _, c in found if c.get("series")), []
    )
    if not groups:
        return
    evaluated = [group for group in groups if group["result"]]
    if not evaluated:
        largest = max(group["tests"] for group in groups)
        yield Callout(
            "doubt",
            f"EN 1994-1-1, B.2 [@en1994-1-1] cannot be applied: none of the {len(groups)} groups "
            f"of nominally equal tests has three (the largest has {largest}). A table of your own "
            "with such a series is evaluated by `workbench fit stud-strength FILE.csv`.",
        )
    rows = []
    for group in groups:
        if group["tests"] < _LEAST_IN_SERIES:
            continue
        result = group["result"] or {}
        ductile = {True: "ductile", False: "brittle", None: "not known"}[result.get("ductile")]
        refusal = Cell(group["refusal"], tone="muted")
        rows.append(
            (
                Cell(group["name"]),
                Cell(str(group["tests"]), group["tests"]),
                _number(result.get("P_Rk"), 4, KILO),
                _number(result.get("P_Rd"), 4, KILO),
                _number(result.get("slip_capacity"), 3, MILLI),
                Cell(ductile) if result else refusal,
            )
        )
    if not rows:
        return
    columns = (
        Column("series", width=3.2),
        Column("tests", True, 0.7),
        Column("P_Rk (kN)", True, 1.0),
        Column("P_Rd (kN)", True, 1.0),
        Column("δ_uk (mm)", True, 1.0),
        Column("class, or why there is none", width=3.2),
    )
    caption = "EN 1994-1-1, Annex B.2: every series of three tests or more."
    yield Table("design-series", caption, columns, tuple(rows), 12)


def _load_slip(found: list[Answered]) -> Iterator[Block]:
    rows = []
    case_of: dict[str, tuple[str, dict[str, Any]]] = {}
    for case, label, asked, content in found:
        fit = content.get("fit")
        if asked != "load-slip" or not fit:
            continue
        if label not in case_of or fit["curves"] > case_of[label][1]["curves"]:
            case_of[label] = case, fit
    for label, (case, fit) in case_of.items():
        for name, value in fit["population"].items():
            factor, unit = _UNITS.get(name, (1.0, ""))
            rows.append(
                (
                    Cell(f"{label} ({case}, {fit['curves']} curves)"),
                    Cell(name.replace("_", " ") + (f" ({unit})" if unit else "")),
                    _number(value["median"], 3, factor),
                    Cell(_span(value["profile"], factor)),
                    Cell(_span(value["bootstrap"], factor)),
                    _number(value["sigma"]["value"], 2),
                    _number(value["tau"]["value"], 2),
                )
            )
    if not rows:
        return
    columns = (
        Column("law", width=3.0),
        Column("parameter", width=1.7),
        Column("median", True, 0.9),
        Column("profile interval", True, 1.5),
        Column("bootstrap", True, 1.5),
        Column("σ", True, 0.6),
        Column("τ", True, 0.6),
    )
    caption = (
        "Load-slip laws: median of each parameter over the curves with its 90 % intervals, scatter "
        "of its logarithm within (σ, the error of each curve's fit included) and between (τ) "
        "campaigns."
    )
    yield Table("design-load-slip", caption, columns, tuple(rows))


_UNITS = {"rate": (1e-3, "1/mm"), "yield_slip": (1e3, "mm"), "peak_slip": (1e3, "mm")}


def _residual(found: list[Answered]) -> Iterator[Block]:
    rows = []
    for _, _, asked, content in found:
        if not asked.startswith("residual") or "curve" not in content:
            continue
        fit, curve = content["fit"], content["curve"]
        cells = []
        for level in _LEVELS:
            at = min(range(len(curve["level"])), key=lambda i: abs(curve["level"][i] - level))
            left = curve["left"][at]
            text = number(left, 2)
            if left is not None and curve["low"] is not None:
                text += f"\n({number(curve['low'][at], 2)} to {number(curve['high'][at], 2)})"
            cells.append(Cell(text, left))
        tone = "" if content["validated"] else "bad"
        rows.append(
            (
                Cell(f"{fit['quantity']}, {fit['predamage']}, {fit['measure']}"),
                *cells,
                Cell(fit["relation"]),
                Cell(
                    "\n".join(wrap(fit["grade"], _GRADE_WIDTH, break_on_hyphens=False)), tone=tone
                ),
            )
        )
    if not rows:
        return
    columns = (
        Column("what is left", width=2.4),
        *(Column(f"level {level:g}", True, 1.1) for level in _LEVELS),
        Column("relation", width=1.1),
        Column("grade", width=2.6),
    )
    caption = (
        "Share that is left after damage, with its range: the band of a new test, or, for the "
        "mechanical model, what its assumed parameters leave open."
    )
    yield Table("design-residual", caption, columns, tuple(rows))


def _span(interval: dict[str, Any] | None, factor: float) -> str:
    if interval is None:
        return "too few campaigns"
    low, high = (
        "open" if interval[side] is None else number(factor * interval[side], 3)
        for side in ("low", "high")
    )
    return f"{low} to {high}"


def _number(value: float | None, digits: int, factor: float = 1.0) -> Cell:
    if value is None:
        return Cell("–", tone="muted")
    return Cell(number(factor * value, digits), value)
