"""Building, checking and reducing responses (`xarray.Dataset` with the standard variables).

**Second part.** Where a number came from: versions, lock file, source state, kind of machine (no
names).
"""

import hashlib
import json
import platform
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache, lru_cache
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike
from xarray.core.indexing import PandasIndexingAdapter
from xarray.indexes import PandasIndex

from workbench.base.arrays import Array
from workbench.base.errors import Collapse, CollapseError, Mechanism, WorkbenchError
from workbench.responses.histories import (
    COORDINATES,
    EXTREMES,
    HISTORY,
    NO_PEAK,
    SCALARS,
    VARIABLES,
    implied,
    open_share,
)
from workbench.responses.outcome import SYNTHETIC, ExpectedError, Finding, Outcome

Response = xr.Dataset
_ATTRIBUTES = {name: one.attributes for name, one in COORDINATES.items()}
_TOLD = {"units", "long_name"}  # of every variable
_KNOWN = {  # dimensions and attributes of variables over time, or of steps
    of: {
        name: (tuple(of if d == HISTORY else d for d in one.dims), one.attributes)
        for name, one in {**COORDINATES, **VARIABLES}.items()
    }
    for of in ("time", "step")
}
_NAMES, _NUMBERS = "OU", "fiu"  # kinds of types
_TEXTS = ("hinge", "segment", "member", "upright", "run")  # coordinates that are names
_RULES: dict[Any, Any] = {  # by variable: what it may stand over, its unit, the kinds of its type
    name: (
        [_KNOWN[of][name][0] for of in _KNOWN],
        attributes["units"],
        _NAMES if name in _TEXTS else _NUMBERS,
    )
    for name, (_, attributes) in _KNOWN["time"].items()
}
UNADVISED = "ask `workbench.simulate`, which adds the error to expect"
_LARGE = 1000  # numbers of an array that is looked at by itself
_LARGEST = 1e60  # in any unit: what is beyond is as good as infinite, its square still a number


def build_response(
    values: Mapping[str, ArrayLike | None],
    *,
    time: ArrayLike | None = None,
    steps: int | None = None,
    hinges: Sequence[str] = (),
    segments: Sequence[str] = (),
    members: Sequence[str] = (),
    uprights: Sequence[str] = (),
    warnings: Sequence[Finding] = (),
) -> Response:
    """Make a response from plain arrays, with dimensions, units and names from the table.

    Arguments: `values`, variable name to array in the order of its dimensions (entries that
    are None are left out: a quantity that a model cannot know is absent); `time` in s for
    histories in time, or `steps`, the number of load steps; names of `hinges`, `segments`,
    `members` and `uprights` among them; `warnings` met while solving. What the histories imply
    (see `histories.implied`) is added; where a model gives it itself, also as None, that counts.
    Points along members are evenly spaced, snapshots numbered. Raises KeyError for a variable that
    is not in the table.
    """
    instants = None if time is None else np.asarray(time, dtype=float)
    given: dict[str, Array | None] = {}
    for name, value in values.items():
        given[name] = None if value is None else np.asarray(value, dtype=float)
    derived, findings = implied(given, instants)
    known = _KNOWN["time" if time is not None else "step"]
    named = {"hinge": hinges, "segment": segments, "member": members, "upright": uprights}
    along: dict[str, Any] = {}
    for name, names in named.items():
        if len(names):
            along[name] = tuple(names)
    if instants is not None:
        along["time"] = instants
    elif steps is not None:
        along["step"] = steps
    data: dict[Any, xr.Variable] = {}
    sizes: dict[Any, int] = {}
    for name, value in {**derived, **given}.items():
        if value is None:
            continue
        (dims, attributes), array = known[name], np.asarray(value, dtype=float)
        if array.shape != tuple(map(sizes.get, dims)):
            for dim, size in zip(dims, array.shape, strict=False):
                sizes.setdefault(dim, size)
            if array.shape != tuple(map(sizes.get, dims)):
                raise ValueError(f"{name}: shape {array.shape} is not that of {dims} {sizes}")
        data[name] = variable_of(xr.Variable, dims, array, attributes)
    for name in filter(sizes.__contains__, ("point", "snapshot")):
        along[name] = sizes[name]
    indexes: dict[Any, Any] = {}
    coordinates: dict[Any, xr.Variable] = {}
    for name in filter(along.__contains__, COORDINATES):
        make = axis_of if name == "time" else shared_axis
        index, axis = make(name, along[name])
        if sizes.setdefault(name, axis.size) != axis.size:
            raise ValueError(f"{name}: {axis.size} coordinates of {sizes[name]} values")
        indexes[name], coordinates[name] = index, axis
    # What it is made of is known not to conflict: looking for that takes xarray half a millisecond.
    response = xr.Dataset._construct_direct(
        {**data, **coordinates}, set(coordinates), sizes, {}, indexes
    )
    response.attrs["outcome"] = Outcome.OK.value
    response.attrs["message"] = ""
    set_findings(response, [*findings, *warnings])
    return response


# Coordinates go the short way: `xarray.Dataset(coords=...)` takes several times as long as solving
# the SDOF column.


def variable_of(kind: Any, dims: tuple[Any, ...], data: Any, attributes: dict[str, str]) -> Any:
    """A variable of xarray of what is known to fit; to check it again takes as long as the rest."""
    one = object.__new__(kind)
    one._dims, one._data, one._attrs, one._encoding = dims, data, dict(attributes), None
    return one


def axis_of(
    name: str, values: Sequence[Any] | Array, attributes: Mapping[str, Any] | None = None
) -> tuple[PandasIndex, xr.Variable]:
    """A coordinate of a response: its index and its variable; None: the standard attributes."""
    if isinstance(values, np.ndarray) and values.dtype == np.float64:  # the rest is for asking
        known = pd.Index._simple_new(values, name=name)  # type: ignore[attr-defined]
        index = PandasIndex(known, name, values.dtype, fastpath=True)
    else:
        known = pd.Index(values, name=name)
        index = PandasIndex(known, name, getattr(values, "dtype", None))
    held = PandasIndexingAdapter(known, index.coord_dtype)
    shown = _ATTRIBUTES[name] if attributes is None else dict(attributes)
    return index, variable_of(xr.IndexVariable, (name,), held, shown)


def shared_axis(name: str, parts: tuple[str, ...] | int) -> tuple[PandasIndex, xr.Variable]:
    """`axis_of` the names of parts, or of so many: points along members or numbers from 0.

    Many responses share its index; the variable has attributes of its own.
    """
    index, axis = _shared(name, parts)
    return index, variable_of(xr.IndexVariable, (name,), axis._data, _ATTRIBUTES[name])


@lru_cache(maxsize=512)
def _shared(name: str, parts: tuple[str, ...] | int) -> tuple[PandasIndex, xr.Variable]:
    values: Any = parts
    if isinstance(parts, int):
        values = np.linspace(0.0, 1.0, parts) if name == "point" else np.arange(parts)
    return axis_of(name, values)


def response_of(
    arrays: Mapping[str, tuple[tuple[str, ...], Any, Mapping[str, Any]]],
    attributes: Mapping[str, Any],
) -> Response:
    """A response from its dimensions, arrays and attributes by name, known to fit, and its own."""
    variables: dict[Any, xr.Variable] = {}
    sizes: dict[Any, int] = {}
    indexes: dict[Any, Any] = {}
    for name, (dims, values, of_variable) in arrays.items():
        sizes.update(zip(dims, values.shape, strict=True))
        if dims == (name,):
            words = values.astype(str) if values.dtype == object else values
            indexes[name], variables[name] = axis_of(name, words, of_variable)
        else:
            variables[name] = variable_of(xr.Variable, dims, values, dict(of_variable))
    return xr.Dataset._construct_direct(variables, set(indexes), sizes, dict(attributes), indexes)


def failed_response(outcome: Outcome, message: str, findings: Sequence[Finding] = ()) -> Response:
    """A response without variables that says how the attempt ended and what to do.

    Arguments: the `outcome`; a `message` in words; the `findings` behind it, if any.
    """
    response = xr.Dataset()
    response.attrs["outcome"] = outcome.value
    response.attrs["message"] = failure_message(outcome, message)
    set_findings(response, findings)
    return response


def failure_message(outcome: Outcome, message: str) -> str:
    """How an attempt has ended, and what to do about it."""
    return f"{message}. {outcome.advice}" if message else outcome.advice


def refused_response(refusals: Sequence[Finding]) -> Response:
    """The response of a model that cannot answer, for reasons that are its refusals."""
    response = failed_response(Outcome.OUT_OF_DOMAIN, "", refusals)
    response.attrs["message"] = refusal_message(refusals)
    return response


def refusal_message(findings: Sequence[Finding]) -> str:
    """The message of a model that refuses, from its findings."""
    reasons = "; ".join(str(finding) for finding in findings if finding.refusal)
    return f"{reasons}. {Outcome.OUT_OF_DOMAIN.advice}"


def collapsed_response(error: CollapseError) -> Response:
    """The answer that the structure collapses."""
    response = failed_response(Outcome.COLLAPSE, str(error), error.findings)
    set_attributes(response, collapse=error.collapse._asdict())
    return response


def set_attributes(response: Response, **tables: Mapping[str, Any]) -> None:
    """Let a response carry tables of names and values, as JSON, so that any netCDF holds them."""
    for name, table in tables.items():
        response.attrs[name] = json.dumps(table, sort_keys=True)


def attribute(response: Response, name: str) -> dict[str, Any]:
    """Table of `set_attributes` that a response carries, to be read only; empty without one."""
    text = response.attrs.get(name)
    return {} if text is None else _parsed(text)


@lru_cache(maxsize=1024)
def _parsed(text: str) -> Any:
    """Value of a text in JSON: many responses carry the same one."""
    return json.loads(text)


def error_of(response: Response) -> ExpectedError:
    """The error to expect of an answer; one without advice on it has none."""
    stored = attribute(response, "error")
    return ExpectedError(**stored) if stored else ExpectedError("", reason=UNADVISED)


def outcome_of(response: Response) -> Outcome:
    """How the attempt ended."""
    return Outcome(response.attrs["outcome"])


def collapse_of(response: Response) -> Collapse | None:
    """How the structure collapsed; None if it did not."""
    if outcome_of(response) is not Outcome.COLLAPSE:
        return None
    collapse = attribute(response, "collapse")
    mechanism, parts = Mechanism(collapse["mechanism"]), tuple(collapse["parts"])
    return Collapse(mechanism, parts, collapse["displacement"], collapse["time"])


def survives(response: Response) -> bool | None:
    """Whether the structure survives; None without an answer.

    There is none either where the record ends before the peak: a collapse may still come.
    """
    outcome = outcome_of(response)
    if outcome is Outcome.OK:
        open_end = any(finding.subject == NO_PEAK for finding in findings_of(response))
        return None if open_end else True
    return False if outcome is Outcome.COLLAPSE else None


def findings_of(response: Response) -> list[Finding]:
    """The findings that a response carries: refusals and warnings."""
    return list(_findings(response.attrs["findings"]))


@lru_cache(maxsize=1024)
def _findings(stored: str) -> tuple[Finding, ...]:
    """Findings in JSON, parsed: many responses carry the same ones."""
    return tuple(map(Finding.from_dict, _parsed(stored)))


def is_synthetic(response: Response) -> bool:
    """Whether its numbers are made, not measured: they validate nothing."""
    return any(finding.subject == SYNTHETIC for finding in findings_of(response))


def warnings_of(response: Response) -> list[Finding]:
    """The warnings that a response carries."""
    return [finding for finding in findings_of(response) if not finding.refusal]


def set_findings(response: Response, findings: Sequence[Finding]) -> None:
    """Let a response carry these findings and no others."""
    response.attrs["findings"] = f"[{', '.join(map(_text, findings))}]"


@lru_cache(maxsize=1024)
def _text(finding: Finding) -> str:
    """A finding in JSON: many responses carry the same ones."""
    return json.dumps(finding.as_dict())


def check_response(response: Response) -> None:
    """Hold a response to the contract: known names, units, dimensions, types, finite numbers.

    Names with dots are a model's own results: words, or numbers that are NaN where not known.
    Raises `WorkbenchError` naming the variable.
    """
    numbers: dict[Any, Array] = {}
    for name, array in dict(response.variables).items():  # plain ones: no index is built
        shapes, units, kinds = _RULES.get(name, ((), "", ""))
        if not shapes and name in response.coords:
            continue
        if not shapes and "." not in str(name):
            raise WorkbenchError(f"response variable {name!r} is not a standard one")
        if not array.attrs.keys() >= _TOLD or (shapes and array.attrs["units"] != units):
            raise WorkbenchError(f"response variable {name!r} lacks units or long_name")
        if shapes and array.dims not in shapes:
            over = ", ".join(map(str, array.dims)) or "nothing"
            raise WorkbenchError(f"response variable {name!r} stands over {over}")
        if shapes and array.dtype.kind not in kinds:
            raise WorkbenchError(f"response variable {name!r} holds {array.dtype}")
        if kinds == _NUMBERS:
            numbers[name] = array.to_numpy()
    time = numbers.pop("time", None)
    large: list[Array] = []
    small: list[Array] = [np.empty(0)]
    for values in numbers.values():
        (large if values.size > _LARGE else small).append(values.ravel())
    if not all(map(_finite, (*large, np.concatenate(small)))):
        name = next(name for name, values in numbers.items() if not _finite(values))
        raise WorkbenchError(f"response variable {name!r} holds numbers that are not finite")
    if time is not None and not (time.size and _finite(time) and (time[1:] > time[:-1]).all()):
        raise WorkbenchError("response time does not increase")


def _finite(values: Array) -> bool:
    return not values.size or bool(values.min() > -_LARGEST and values.max() < _LARGEST)


def scalars_of(response: Response) -> dict[str, float]:
    """The scalar quantities that a response has."""
    return {name: float(response[name]) for name in SCALARS if name in response}


def places_of(response: Response) -> dict[str, str]:
    """The hinge or member of each extreme of a response that is not zero.

    Extremes over time alone have none.
    """
    places = {}
    for name, (of, signs) in EXTREMES.items():
        if name in response and of in response and float(response[name]) > 0.0:
            part = response[of].dims[0]
            if part in _TEXTS:
                values = response[of].to_numpy().reshape(response[of].shape[0], -1)
                largest = np.max([(sign * values).max(axis=1) for sign in signs], axis=0)
                places[name] = str(response[part].to_numpy()[int(np.argmax(largest))])
    return places


def energy_error(response: Response) -> float | None:
    """Largest error of the energy ledger, see `open_share`; None where there is none."""
    known = response.variables  # plain ones: no index is built
    if not {"balance_error", "input_energy"} <= known.keys():
        return None
    stored = float(known["elastic"].to_numpy()[0]) if "elastic" in known else 0.0
    given = float(known["input_energy"].to_numpy())
    return open_share(known["balance_error"].to_numpy(), given, stored) if given else None


DISTRIBUTION = "steel-impact-workbench"  # its name where packages are installed from
_LIBRARIES = ("numpy", "scipy", "xarray", "numba")
_ROOT = Path(__file__).resolve().parents[2]


@cache
def provenance() -> dict[str, str]:
    """Versions, hash of the lock file, git commit, processor; never a host name or a path."""
    record = {"workbench": metadata.version(DISTRIBUTION), "python": platform.python_version()}
    for library in _LIBRARIES:
        record[library] = metadata.version(library)
    record["machine"] = f"{platform.system()} {platform.machine()}, {_processor()}"
    lock = _ROOT / "requirements.lock"
    if lock.is_file():
        record["requirements_lock"] = hashlib.sha256(lock.read_bytes()).hexdigest()[:16]
    commit = _git("rev-parse", "HEAD")
    if commit and (_ROOT / ".git").exists():
        dirty = bool(_git("status", "--porcelain", "--", "workbench", "data", "studies"))
        record["commit"] = commit[:12] + ("+changes" if dirty else "")
    return record


def _processor() -> str:
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or "unknown processor"


def _git(*arguments: str) -> str:
    command = ["git", "-C", str(_ROOT), *arguments]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
