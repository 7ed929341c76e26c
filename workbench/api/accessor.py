"""Accessor ``response.workbench``: a response in words, with its findings as objects.

The answer in one sentence, as an object for ``--json``, as a row of a table, as blocks of a
page, which the command line prints too.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from functools import cached_property
from itertools import islice
from math import nan
from typing import TYPE_CHECKING, Any

import pandas as pd
import xarray as xr

from workbench.base.errors import Collapse, InputError
from workbench.base.fields import did_you_mean
from workbench.report.page.formatting import (
    direction,
    duration,
    in_unit,
    number,
    quantities,
    unit_of,
)
from workbench.report.page.markdown import Block, Cell, Table, definitions, paragraph, warnings
from workbench.responses import (
    ENERGIES,
    PEAK,
    SCALARS,
    VARIABLES,
    ExpectedError,
    Finding,
    Outcome,
    Response,
    attribute,
    collapse_of,
    energy_error,
    error_of,
    findings_of,
    outcome_of,
    places_of,
    scalars_of,
    survives,
    warnings_of,
)
from workbench.responses.histories import INTEGRATORS, STUD_TESTS, largest_of
from workbench.scenarios import FrameImpact, Scenario
from workbench.scenarios.files import scenario_from
from workbench.scenarios.pulse import LIGHTEST
from workbench.study.error_model.error_model import UNMEASURED

if TYPE_CHECKING:
    from workbench.api.plots import Plots


UPPER_BOUND = (  # no warning: it holds of most scenarios and says nothing about the model
    "the striker is rigid; if it is a vehicle this is an upper bound, as its front crushes "
    "(striker.stiffness or striker.crush)"
)
FORCE_UNMEASURED = (
    "the error of the largest contact force was not measured; it hangs on the mass that a model "
    "gives the impact point, and models that agree in displacement differ in it"
)
OPEN = "survives or not: the record ends before the peak"
TABLED = (PEAK, "time_of_peak", "residual_displacement", "peak_force", "impulse")
_KIND = "numerical"  # what stands after ±
_SEGMENTS = 4  # the most sheared ones, which the text names
_ROWS = 5  # of an answer that is not shown in full


def headline(response: Response) -> str:
    """The answer in one sentence: peak, interval of 90 % for the truth, fate, model and why."""
    values, error = scalars_of(response), error_of(response)
    parts = [fate_of(response)]
    if PEAK in values:
        parts.insert(0, f"{in_unit(values[PEAK], PEAK, 3)}{_interval(values[PEAK], error)}")
    elif "force" in response:
        force = largest_of(response["force"].to_numpy())
        parts.insert(0, f"largest force {in_unit(force, 'force', 3)}")
    elif values and fate_of(response) != OPEN:
        name, value = next(iter(values.items()))
        parts.insert(0, f"{VARIABLES[name].long_name} {in_unit(value, name, 3)}")
    parts.append(direction(response.attrs.get("scenario", "")))
    model, because = response.attrs["model"], response.attrs.get("because", "as asked")
    parts.append(f"by {model}, {because}")
    if any(each.subject == UNMEASURED for each in findings_of(response)):
        parts.append("outside what was measured")
    return "; ".join(filter(None, parts))


def fate_of(response: Response) -> str:
    """Fate of the structure, in words; empty where nothing is struck."""
    collapse, known = collapse_of(response), survives(response)
    if collapse is not None:
        return f"collapses: {collapse.mechanism} ({', '.join(collapse.parts)})"
    if not outcome_of(response).is_answer:
        return f"no answer, {outcome_of(response).value}"
    if known is None:
        return OPEN
    return "survives" if PEAK in response or "force" in response else ""


def _interval(peak: float, error: ExpectedError) -> str:
    """The interval of 90 %, and what is expected of an answer that lies outside of it.

    Close to collapse it says the chance of that, and has a lower end alone where that is not small.
    """
    if error.high is None:
        return ""
    factor = unit_of(PEAK).factor
    said = error.near_collapse and error.collapse is not None
    falls = f", or collapse: {100.0 * (error.collapse or 0.0):.0f} %" if said else ""
    if error.low is None or error.low <= -1.0:
        least = in_unit(peak / (1.0 + error.high), PEAK, 3)
        return f"{'' if error.reason else falls}, at least {least}; {error.reason}".rstrip("; ")
    ends = sorted(peak / (1.0 + share) * factor for share in (error.high, error.low))
    least, most = (number(end, 3) for end in ends)
    middle = ""
    if error.expected is not None and not error.low <= 0.0 <= error.high:
        middle = f"; expected {number(peak / (1.0 + error.expected) * factor, 3)}"
    return f"{falls}{middle}, 90 %: {least} to {most}"


class Rows(pd.DataFrame):
    """A table of answers that prints all of its columns, in blocks where they are too many."""

    def __repr__(self) -> str:
        numbers: Any = {"na_rep": "", "float_format": "{:.4g}".format}
        return str(self.to_string(index=False, line_width=100, **numbers))

    @property
    def _constructor(self) -> type[Rows]:
        return Rows


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
    table = Rows(rows)
    held = table.loc[table["model"] == reference, PEAK]
    error = table[PEAK] / held.iloc[0] - 1.0 if len(held) else float("nan")
    table.insert(3, "error", error)
    return table


def as_object(response: Response, scenario: Scenario) -> dict[str, Any]:
    """A response as one JSON object; what the model cannot know is null."""

    def last(name: str) -> float | None:
        return float(response[name].to_numpy().flat[-1]) if name in response else None

    shear = None
    if "shear_utilisation" in response:
        series = response["shear_utilisation"].to_series()
        shear = {str(segment): float(value) for segment, value in series.items()}
    special = (*STUD_TESTS, *INTEGRATORS, "input_energy")
    structural = [name for name in SCALARS if name not in special]
    result: dict[str, Any] = {
        "model": response.attrs["model"],
        "headline": headline(response),
        "outcome": response.attrs["outcome"],
        "message": response.attrs["message"],
        "collapse": attribute(response, "collapse") or None,
        **{name: last(name) for name in structural},
        "places": places_of(response),
        **_parts(response, scenario),
        "rate_factor": response.attrs.get("rate_factor"),
        "notes": _notes(scenario, last("peak_force") is not None) + _longer(response, scenario),
        "error": attribute(response, "error") or None,
        "numerical_uncertainty": attribute(response, "numerical_uncertainty") or None,
        "refinement": attribute(response, "refinement") or None,
        "energies": {
            **{name: last(name) for name in ENERGIES},
            "input_energy": last("input_energy"),
            "relative_balance_error": energy_error(response),
        },
        "shear_utilisation": shear,
        "warnings": [f.as_dict() for f in findings_of(response) if not f.refusal],
        "refusals": [f.as_dict() for f in findings_of(response) if f.refusal],
        "wall_time": float(response.attrs["wall_time"]),
        "provenance": {
            **attribute(response, "provenance"),
            "model_version": int(response.attrs["model_version"]),
            "options": attribute(response, "options"),
            "scenario": response.attrs["scenario"],
            "scenario_hash": response.attrs["scenario_hash"],
        },
    }
    if scenario.KIND == "stud-tests":
        result |= {name: last(name) for name in STUD_TESTS}
        result["answer"] = attribute(response, "answer") or None
    if scenario.KIND == "impact-problem":
        result |= {name: last(name) for name in INTEGRATORS}
    if scenario.STATIC:
        for name in ("displacement", "force"):
            result[name] = response[name].to_numpy().tolist() if name in response else None
    return result


def _notes(scenario: Scenario, has_force: bool) -> list[str]:
    """Notes on an answer to a hit: a rigid vehicle, a contact force without an interval."""
    striker = getattr(scenario, "striker", None)
    if striker is None:
        return []
    rigid = striker.mass >= LIGHTEST and not striker.crushes
    return [UPPER_BOUND] * rigid + [FORCE_UNMEASURED] * has_force


def _longer(response: Response, scenario: Scenario) -> list[str]:
    """Whether the record was made longer than the scenario has it."""
    wanted = getattr(scenario, "duration", None)
    end = 0.0 if "time" not in response else float(response["time"][-1])
    if wanted is None or end < 1.5 * wanted:
        return []
    return [f"the record of {wanted:g} s ends before the peak, and was made {end:.3g} s long"]


def _parts(response: Response, scenario: Scenario) -> dict[str, Any]:
    """Extremes of hinges and storeys over the run, and the members that are struck."""
    hinges: dict[str, dict[str, Any]] = {}
    for name in ("axial_force", "moment", "plastic_rotation"):
        for table in [response[name]] if name in response else []:
            for hinge, row in zip(table["hinge"].to_numpy(), table.to_numpy() + 0.0, strict=True):
                hinges.setdefault(str(hinge), {})[name] = [float(row.min()), float(row.max())]
    drift = dict(response["drift"].to_series()) if "drift" in response else {}
    struck: list[str] = []
    if isinstance(scenario, FrameImpact):
        members, node = scenario.frame.members, scenario.striker.node
        struck = [member.name for member in members if node in (member.start, member.end)]
    return {
        "hinges": hinges or None,
        "drift": {str(upright): float(value) for upright, value in drift.items()} or None,
        "struck": struck,
    }


def time_of(response: Response) -> Cell:
    """The wall time of an answer, unless compilation may be a part of it."""
    if "compiled" in response.attrs:
        return Cell("compiled")
    return Cell(duration(response.attrs["wall_time"]), response.attrs["wall_time"])


def table_blocks(name: str, responses: Mapping[str, Response]) -> Iterator[Block]:
    """Several answers as one table, their warnings below."""
    columns = {
        "model": "model",
        "fate": lambda row: fate_of(responses[row["model"]]),
        **quantities(*TABLED),
        "error of the peak": lambda row: str(error_of(responses[row["model"]])),
        "wall time": lambda row: time_of(responses[row["model"]]),
    }
    yield Table.of("models", name, columns, compared(responses))
    for label, response in responses.items():
        findings = sorted(findings_of(response), key=lambda finding: not finding.refusal)
        yield from warnings(findings, f" of {label}")


def blocks_of(response: Response, name: str, answer: dict[str, Any], full: bool) -> Iterator[Block]:
    """An `answer`, the object of a response, in words: with all of its numbers or the first."""
    yield paragraph(f"{name}: {answer['headline']}")
    if answer["message"]:
        yield paragraph(answer["message"])
    rows = numbers_in_words(response, answer)
    yield definitions(tuple(rows if full else islice(rows, _ROWS)))
    yield from notes_in_words(response, answer)
    yield from warnings(warnings_of(response))
    if len(rows) > _ROWS and not full:
        yield paragraph(f"{len(rows) - _ROWS} more numbers with --full.")


def numbers_in_words(response: Response, answer: dict[str, Any]) -> list[tuple[str, str]]:
    """The numbers of an answer by their names, with what a reference says and the wall time."""
    rows = [*_lines(answer), ("wall time", time_of(response).text)]
    other = answer.get("reference")
    if answer["rate_factor"] is not None:
        text = f"{answer['rate_factor']:.3g} times the static one by strain rate, at the hinges"
        rows.insert(1, ("yield stress", text))
    if other is not None:
        value, width = other[PEAK], (other["numerical_uncertainty"] or {}).get(PEAK, 0.0)
        known = "" if value is None else f", {in_unit(value, PEAK, width=width, kind=_KIND)}"
        rows.insert(1, (f"by {other['model']}, a reference", f"{other['outcome']}{known}"))
    return rows


def notes_in_words(response: Response, answer: dict[str, Any]) -> Iterator[Block]:
    """The error to expect of the peak, or why there is none, and the notes on an answer."""
    error = error_of(response)
    if error.collapse is not None or error.expected is not None:
        yield paragraph(f"Error of the peak displacement: {error}.")
    elif answer[PEAK] is not None and error.high is None:
        yield paragraph(f"No interval of the peak displacement: {error.reason}.")
    for note in answer["notes"]:
        yield paragraph(f"Note: {note}.")


def _lines(answer: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """The numbers of a response with their names, units and numerical uncertainty."""
    widths, places = answer["numerical_uncertainty"] or {}, answer["places"]
    energies, collapse = answer["energies"], answer["collapse"]
    if collapse:
        mechanism = f"{collapse['mechanism']} ({', '.join(collapse['parts'])})"
        yield "mechanism of the collapse", mechanism
        if collapse["time"] is not None:
            yield "time of the collapse", in_unit(collapse["time"], "time_of_peak")
        yield "displacement reached", in_unit(collapse["displacement"], "peak_displacement")
    for name in SCALARS:
        value = energies.get(name, answer.get(name))
        if value is not None:
            place = f" ({places[name]})" if name in places else ""
            text = in_unit(value, name, width=widths.get(name, 0.0), kind=_KIND)
            yield VARIABLES[name].long_name, f"{text}{place}"
    for name in ENERGIES:
        if energies[name] is not None:
            yield f"{VARIABLES[name].long_name}, at the end", in_unit(energies[name], name)
    if energies["relative_balance_error"] is not None:
        error = energies["relative_balance_error"]
        yield "largest energy error over the input energy", f"{error:.1e}"
    if answer.get("force"):
        yield "largest force", in_unit(max(answer["force"], key=abs), "force")
        for name, ladder in (answer["refinement"] or {}).get("quantities", {}).items():
            variable = ladder["variable"]
            if variable != name and name in widths:  # a point of known numerical uncertainty
                value = ladder["values"]["h"]
                yield name, in_unit(value, variable, width=widths[name], kind=_KIND)
        yield "points of the curve", str(len(answer["force"]))
    yield from _struck(answer)
    shear = sorted((answer["shear_utilisation"] or {}).items(), key=lambda pair: -pair[1])
    for segment, value in shear[:_SEGMENTS]:
        yield f"largest V/V_pl, segment {segment}", f"{value:.3g}"
    if len(shear) > _SEGMENTS:
        yield f"largest V/V_pl, {len(shear) - _SEGMENTS} others", f"up to {shear[_SEGMENTS][1]:.3g}"


def _struck(answer: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Axial forces in the members that are struck."""
    hinges = answer["hinges"] or {}
    for member in answer["struck"]:
        both = [hinges.get(f"{member}:{end}", {}) for end in ("start", "end")]
        forces = [force for hinge in both for force in hinge.get("axial_force", ())]
        if forces:
            ends = (in_unit(force, "axial_force", 3) for force in (min(forces), max(forces)))
            yield f"axial force in the struck {member}, tension positive", " to ".join(ends)


@xr.register_dataset_accessor("workbench")  # type: ignore[no-untyped-call]
class Answered:
    """A response with its findings as objects, its numbers and its pictures.

    Of responses of this session and of files that `simulate --out` wrote.

    Examples
    --------
    >>> import workbench as wb
    >>> hit = wb.impact(wb.Column("HEB 220", 0.8, 3.2), mass=1500, velocity=80)
    >>> answer = wb.simulate(hit, "four-dof").workbench
    >>> answer.outcome.value, answer.number("peak_displacement")
    ('collapse', nan)
    """

    def __init__(self, response: Response) -> None:
        self._response = response

    @property
    def outcome(self) -> Outcome:
        """How it ended; a collapse is an answer."""
        return outcome_of(self._response)

    @property
    def collapse(self) -> Collapse | None:
        """Mechanism, parts, displacement (m) and time (s) of a collapse; None without one."""
        return collapse_of(self._response)

    @property
    def findings(self) -> list[Finding]:
        """Warnings and refusals, each with sentence, remedy, number and limit."""
        return findings_of(self._response)

    @property
    def error(self) -> ExpectedError:
        """The error to expect of the peak displacement."""
        return error_of(self._response)

    @property
    def headline(self) -> str:
        """The answer in one sentence."""
        return headline(self._response)

    @cached_property
    def scenario(self) -> Scenario:
        """Scenario that was answered."""
        return scenario_from(tomllib.loads(self._response.attrs["scenario"]))

    @property
    def plot(self) -> Plots:
        """Pictures: `history`, `structure`, `deformed`, `interaction`, `energy`."""
        from workbench.api.plots import Plots

        return Plots(self.scenario, {self._response.attrs["model"]: self._response})

    def number(self, name: str) -> float:
        """A scalar in SI; NaN where the answer does not know it, as after a collapse.

        Raises `InputError` for a name that no response has.
        """
        if name not in SCALARS:
            advice = did_you_mean(name, SCALARS, f"known are {', '.join(SCALARS)}")
            raise InputError("quantity", name, "is not a scalar of responses", advice)
        return scalars_of(self._response).get(name, nan)

    def _repr_html_(self) -> str:
        from workbench.report.page.documents import html_of_blocks

        answer = as_object(self._response, self.scenario)
        return html_of_blocks(*blocks_of(self._response, self.scenario.name, answer, full=True))
