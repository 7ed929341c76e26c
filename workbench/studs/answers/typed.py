"""What a model of studs has found, as typed variables of its response.

A number, flag or word is a variable of no dimension, a list one along ``....item``, and the columns
of a table lie along ``....row``; names are paths, ``answer.fit.sigma.value``. NaN: not known, or
not reported. Any netCDF reader gets numbers and units; `content_of` gives the nesting back.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from workbench.responses import Response
from workbench.studs.fit_protocol import fields_of, plain

ROOT, ROW, ITEM = "answer", "row", "item"
UNITS = {
    **dict.fromkeys(("load", "collar", "friction", "P_Rk", "P_Rd", "r_m", "r_k", "r_d"), "N"),
    **dict.fromkeys(("r_nominal", "strength_test", "strength_model"), "N"),
    **dict.fromkeys(("steel_term", "concrete_term", "other_concrete_term", "resistance"), "N"),
    **dict.fromkeys(("slip", "slip_at_max", "slip_capacity", "slip_test", "slip_model"), "m"),
    **dict.fromkeys(("diameter", "height", "peak_slip", "yield_slip"), "m"),
    **dict.fromkeys(("concrete_strength", "concrete_modulus", "ultimate_strength"), "Pa"),
    **dict.fromkeys(("chord_stiffness", "stiffness_test", "stiffness_model"), "N/m"),
    "rate": "1/m",
}
Named = Iterator[tuple[str, xr.Variable]]


def with_content(
    response: Response, content: Mapping[str, Any], units: Mapping[str, str]
) -> Response:
    """The response with the content of an answer; `units` of columns where they are not usual."""
    held: Response = response.assign(dict(_variables(ROOT, content, {**UNITS, **units}, "")))
    return held


def _variables(path: str, value: Any, units: Mapping[str, str], along: str) -> Named:
    """Every leaf of a nesting by its path; arrays of one mapping may share a dimension `along`."""
    if isinstance(value, pd.DataFrame):
        for name in value:
            yield _variable(f"{path}.{name}", value[name].tolist(), units, f"{path}.{ROW}")
        return
    value = fields_of(value)
    if isinstance(value, Mapping):
        lengths = {len(each) for each in value.values() if isinstance(each, np.ndarray)}
        shared = f"{path}.{ITEM}" if len(lengths) == 1 else ""
        for key, each in value.items():
            own = shared if isinstance(each, np.ndarray) else ""
            yield from _variables(f"{path}.{key}", each, units, own)
    elif isinstance(value, (list, tuple)) and value and not np.isscalar(value[0]):
        records = [plain(each) for each in value]
        if all(np.isscalar(cell) or cell is None for row in records for cell in row.values()):
            yield from _variables(path, pd.DataFrame(records), units, "")
            return
        for place, each in enumerate(value):
            yield from _variables(f"{path}.{place}", each, units, "")
    elif isinstance(value, (list, tuple, np.ndarray)):
        yield _variable(path, list(value), units, along or f"{path}.{ITEM}")
    else:
        yield _variable(path, value, units)


def _variable(path: str, value: Any, units: Mapping[str, str], *dims: str) -> Any:
    values = value if dims else [value]
    if any(isinstance(each, str) for each in values):
        array = np.array([str(each or "") for each in values])
    elif values and all(isinstance(each, (bool, np.bool_, int, np.integer)) for each in values):
        array = np.array(values)
    else:
        array = np.array([np.nan if each is None else each for each in values], float)
    unit = units.get(path.rpartition(".")[2], "1")
    attributes = {"units": unit, "long_name": path[len(ROOT) + 1 :].replace(".", " ")}
    return path, xr.Variable(dims, array if dims else array[0], attributes)


def content_of(response: Response) -> dict[str, Any]:
    """The content that a model of studs has put into a response; empty for other responses."""
    entries: dict[str, Any] = {}
    tables: dict[str, dict[str, list[Any]]] = {}
    for path, variable in response.variables.items():
        parent, _, name = str(path).rpartition(".")
        if not str(path).startswith(f"{ROOT}."):
            continue
        value = plain(variable.values)
        if variable.dims == (f"{parent}.{ROW}",):
            tables.setdefault(parent, {})[name] = value
        else:
            entries[str(path)] = value
    entries |= {path: plain(pd.DataFrame(columns)) for path, columns in tables.items()}
    tree: dict[str, Any] = {}
    for path, value in entries.items():
        (_, *parents, name), branch = path.split("."), tree
        for key in parents:
            branch = branch.setdefault(key, {})
        branch[name] = value
    content: dict[str, Any] = _lists(tree)
    return content


def _lists(value: Any) -> Any:
    """Mappings whose keys are places become lists again."""
    if not isinstance(value, dict):
        return value
    inner = {key: _lists(each) for key, each in value.items()}
    if inner and all(key.isdigit() for key in inner):
        return [inner[key] for key in sorted(inner, key=int)]
    return inner
