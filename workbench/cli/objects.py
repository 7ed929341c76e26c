"""Answers as the objects that ``--json`` prints."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from workbench.responses import Response
    from workbench.scenarios import Scenario


def as_object(response: Response, scenario: Scenario) -> dict[str, Any]:
    """A response as one JSON object; what the model cannot know is null."""
    from workbench.desk.summary import headline
    from workbench.responses import ENERGIES, SCALARS, energy_error, findings_of, places_of
    from workbench.responses.variables import INTEGRATORS, STUD_TESTS

    def last(name: str) -> float | None:
        return float(response[name].values.flat[-1]) if name in response else None

    def attribute(name: str) -> dict[str, Any] | None:  # that not all models have
        text = response.attrs.get(name)
        return None if text is None else dict(json.loads(text))

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
        "collapse": attribute("collapse"),
        **{name: last(name) for name in structural},
        "places": places_of(response),
        **_parts(response, scenario),
        "rate_factor": response.attrs.get("rate_factor"),
        "error": attribute("error"),
        "numerical_uncertainty": attribute("numerical_uncertainty"),
        "refinement": attribute("refinement"),
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
            **json.loads(response.attrs["provenance"]),
            "model_version": int(response.attrs["model_version"]),
            "options": json.loads(response.attrs["options"]),
            "scenario": response.attrs["scenario"],
            "scenario_hash": response.attrs["scenario_hash"],
        },
    }
    if scenario.KIND == "stud-tests":
        result |= {name: last(name) for name in STUD_TESTS}
        result["answer"] = attribute("answer")
    if scenario.KIND == "impact-problem":
        result |= {name: last(name) for name in INTEGRATORS}
    if scenario.STATIC:
        for name in ("displacement", "force"):
            result[name] = response[name].values.tolist() if name in response else None
    return result


def _parts(response: Response, scenario: Scenario) -> dict[str, Any]:
    """What hinges and storeys have gone through, and which members are struck."""
    from workbench.scenarios import FrameImpact

    hinges: dict[str, dict[str, Any]] = {}
    for name in ("axial_force", "moment", "plastic_rotation"):
        for table in [response[name]] if name in response else []:
            for hinge, row in zip(table["hinge"].values, table.values + 0.0, strict=True):
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
