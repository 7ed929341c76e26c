"""Whether a stored response is what its readers take it for."""

import json
from math import isfinite
from typing import Any

from workbench.errors import WorkbenchError
from workbench.responses import uncertainty as numerical
from workbench.responses.build import Response, check_response, collapse_of, findings_of

_WIDTHS = (numerical.WIDTHS, "data_uncertainty", "sampling_uncertainty")
_TABLES = (*_WIDTHS, numerical.SAMPLED, numerical.BASIS, "data", "answer")
_LADDER = ("order", "extrapolated", "uncertainty")


def check_stored(response: Response) -> None:
    """Hold a response to the contract, and its attributes to what is read of them.

    Raises `WorkbenchError`, or what reading others raises: ValueError, KeyError, TypeError,
    AttributeError.
    """
    check_response(response)
    attributes = response.attrs
    texts: list[Any] = [attributes["message"], attributes["scenario"]]
    numbers: list[Any] = []
    for finding in findings_of(response):
        texts += (finding.subject, finding.text, finding.remedy)
        numbers.append(finding.number)
    collapse = collapse_of(response)
    if collapse is not None:
        texts += collapse.parts
        numbers += (collapse.displacement, collapse.time)
    tables = {name: json.loads(attributes[name]) for name in _TABLES if name in attributes}
    for name in _WIDTHS:
        numbers += tables.get(name, {}).values()
    for low, high in tables.get(numerical.SAMPLED, {}).values():
        numbers += (low, high)
    if numerical.BASIS in tables:
        basis = tables[numerical.BASIS]
        texts += basis["statements"]
        numbers += basis["levels"]
        for direction in numerical.directions_of(response):
            texts += (direction.name, *direction.runs)
            numbers.append(direction.factor)
        for table in basis["quantities"].values():
            texts.append(table["note"])
            numbers += (*table["values"].values(), *map(table.get, _LADDER))
    good = all(isinstance(text, str) for text in texts)
    good &= all(isinstance(table, dict) for table in tables.values())
    if not (good and all(number is None or isfinite(number) for number in numbers)):
        raise WorkbenchError("an attribute of the response is not what is read of it")
