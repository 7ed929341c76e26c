"""Probability of exceedance: the velocities at it, what governs them, and what a curve costs."""

from collections.abc import Mapping
from typing import Any

from workbench.extras.uncertainty.exceedance import MEDIAN
from workbench.extras.uncertainty.scenario import UncertainImpact
from workbench.report.page.formatting import duration, number
from workbench.report.page.markdown import Cell, Markdown, Table
from workbench.report.page.page import Page
from workbench.responses import Response, attribute
from workbench.responses.uncertainty import SAMPLE_WIDTHS
from workbench.study.assessor import Assessment
from workbench.study.definition import Study

_PARTS = ("samples", "references", "meshes")
_AT = ("velocity.at_10", MEDIAN, "velocity.at_90")
_LEAST = 0.05  # share of an input that is named
PAGE = Page(__file__)


def in_short(study: Study, stored: Assessment) -> Markdown:
    """Summary of curves: what governs each case, and a row for each; empty without curves."""
    rows: list[tuple[str, str, Response, float | None]] = []
    governs: dict[str, str] = {}
    for case in study.cases:
        if not isinstance(case.scenario, UncertainImpact):
            continue
        for label in study.models:
            response = stored.response(case.name, label)
            if response is None or "curve.median" not in response:
                continue
            seconds = stored.number(case.name, label, "wall_time")
            rows.append((case.name, label, response, seconds))
            governs.setdefault(case.name, _governing(response))
    if not rows:
        return Markdown()
    columns: Mapping[str, Any] = {
        "case": lambda row: row[0],
        "model": lambda row: row[1],
        "v at 10 % m/s": lambda row: _velocity(row[2], _AT[0]),
        "at 50 %": lambda row: _velocity(row[2], _AT[1]),
        "at 90 %": lambda row: _velocity(row[2], _AT[2]),
        "half-width": lambda row: _half_width(row[2]),
        "runs": lambda row: _runs(row[2]),
        "time": lambda row: duration(row[3]),
    }
    table = Table.of("exceedance", "", columns, rows)
    return PAGE.blocks("exceedance", table=table, governs=governs)


def _velocity(response: Response, name: str) -> Cell | None:
    """A velocity with its half-width; None where the probability is not reached in the band."""
    if name not in response:
        return None
    value = float(response[name])
    width = attribute(response, SAMPLE_WIDTHS)[name]
    return Cell(f"{value:.3g} ± {number(width, 1)}", value)


def _half_width(response: Response) -> Cell:
    """The largest half-width of the band, and the part that is the largest of it."""
    width = float(response["band.all"])
    parts = {name: float(response[f"band.{name}"]) for name in _PARTS if f"band.{name}" in response}
    return Cell(f"{width:.3f}, most of {max(parts, key=parts.__getitem__)}", width)


def _runs(response: Response) -> str:
    """How many runs of the reduced model, of the reference, and on finer meshes."""
    counts = [int(response.get(f"runs.{name}", 0)) for name in _PARTS]
    return " + ".join(f"{count}" for count in counts if count)


def _governing(response: Response) -> str:
    """Inputs and their shares in the variance of the critical velocity, the largest first."""
    names = response["governs.input"].to_numpy()
    shares = response["governs.share"].to_numpy()
    pairs = sorted(zip(shares, names, strict=True), reverse=True)
    return ", ".join(
        f"{name} {100.0 * share:.0f}\u202f%" for share, name in pairs if share >= _LEAST
    )
