"""The result store of a study: one netCDF file and one record for every cell.

``<directory>/cells/<key>.nc`` holds what is the same in every run, ``<key>.json`` what is not:
wall time, provenance, time stamps, and the digest of the file. The file is written first: a
cell counts as finished when its record is there, the digest agrees, and both say that they answer
what is asked. A reader of any file sees the old content or the new one, never a half; equal
content gives equal bytes, in JSON, CSV and netCDF-3 alike. Nothing is written through a link
inside a store, which may come from elsewhere.

**Second part.** Finding and loading study files: Python files that define ``study = Study(...)``.
"""

import hashlib
import importlib.util
import io
import json
import os
import struct
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from traceback import extract_tb
from typing import Any

import numpy as np
import xarray as xr
from scipy.io import netcdf_file, netcdf_variable

from workbench.base.datafiles import data_directory
from workbench.base.errors import InputError, WorkbenchError, message_of
from workbench.base.fields import did_you_mean
from workbench.base.offered import offered
from workbench.responses import Response, outcome_of, response_of
from workbench.responses.uncertainty import check_stored
from workbench.study.definition import Study

TEMPORARY = ".partial"
NOT_RUN = "not run"  # stands for the outcome of a cell that is not stored

# Attributes of a stored response by the ingredients of its key that they repeat.
_SIGNED = {"scenario": "scenario_hash", "model": "model", "model_version": "model_version"}

# What a record must hold, whoever has written it.
_RECORDED: dict[str, Any] = {
    "outcome": str,
    "wall_time": (int, float),
    "limit": (int, float, type(None)),
    "provenance": dict,
}

# What reading a cell of any content may raise: not there, no JSON, no netCDF, other shapes.
UNREADABLE = (
    *(OSError, ValueError, LookupError, TypeError, AttributeError, ArithmeticError),
    *(RecursionError, MemoryError, struct.error, WorkbenchError),
)

# Attributes of variables that are not stored as they are.
_CODED = {"_FillValue", "missing_value", "scale_factor", "add_offset", "dtype", "coordinates"}

Record = dict[str, Any]
Ingredients = Mapping[str, Any]  # everything that an answer depends on


def write_atomically(path: Path, content: bytes) -> None:
    """Write, flush to the disk, then rename into place; a link there is replaced, not followed.

    A process killed in between leaves a file ending in `TEMPORARY`, which nobody reads. A file that
    holds the content already is left alone, so that finished stores can be read only. Raises
    `InputError` if the file cannot be written; what was there is then still there.
    """
    if not path.is_symlink() and path.is_file() and path.read_bytes() == content:
        return
    temporary = path.with_name(f"{path.name}.{os.getpid()}{TEMPORARY}")
    try:
        temporary.unlink(missing_ok=True)
        with temporary.open("xb") as stream:  # x: neither an existing file nor a link is opened
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(path)
    except OSError as error:
        raise _not_written("file", path, error) from error
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def own_directory(parent: Path, name: str) -> Path:
    """The directory of this name in `parent`, made where it is missing.

    Raises `InputError` if it cannot be made or is a link: what a store from elsewhere links to is
    not ours to write.
    """
    path = parent / name
    if path.is_symlink():
        text = "is a link, through which nothing is written"
        raise InputError("directory", str(path), text, "remove it")
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _not_written("directory", path, error) from error
    return path


@contextmanager
def locked(path: Path, patience: float = 0.0) -> Iterator[None]:
    """Hold the lock that a file stands for; the system frees it when this process ends in any way.

    Arguments: `patience`, s to wait for who holds it. Raises `InputError` if it stays held, or if
    the file cannot be written or is a link.
    """
    try:
        lock = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
    except OSError as error:
        raise _not_written("directory", path.parent, error) from error
    try:
        _lock(lock, path.parent, time.monotonic() + patience)
        yield
    finally:
        os.close(lock)


def _lock(lock: int, directory: Path, until: float) -> None:
    try:
        import fcntl
    except ImportError:  # not a POSIX system: nothing to lock with
        return
    while True:
        try:
            return fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if time.monotonic() > until:
                text, advice = "is in use by another run", "wait until it is over"
                raise InputError("directory", str(directory), text, advice) from error
            time.sleep(0.02)


def _not_written(field: str, path: Path, error: OSError) -> InputError:
    advice = "make room there or name another place"
    return InputError(field, str(path), f"cannot be written: {error.strerror}", advice)


def canonical_json(content: Any) -> bytes:
    """JSON with sorted keys, two-space indents and a final newline; refuses NaN."""
    text = json.dumps(
        content, sort_keys=True, indent=2, ensure_ascii=False, allow_nan=False, default=_plain
    )
    return (text + "\n").encode()


def _plain(value: Any) -> Any:
    if hasattr(value, "item"):
        return value.item()  # a NumPy scalar, as sweeps often carry
    raise TypeError(f"{type(value).__name__} cannot be stored as JSON")


def to_netcdf_bytes(response: Response) -> bytes:
    """A response as the bytes of a netCDF-3 file (64-bit offsets), without fill values.

    An HDF5 file (netCDF-4) of a response is larger, and takes ten times as long to read.
    """
    encoding = {name: {"_FillValue": None} for name in response.variables}
    return bytes(response.to_netcdf(engine="scipy", format="NETCDF3_64BIT", encoding=encoding))


def read_netcdf(path: Path) -> Response:
    """Read a stored response (times stay in seconds). Raises one of `UNREADABLE`."""
    return _response_in(path.read_bytes())


def _response_in(content: bytes) -> Response:
    """The response in the bytes of a netCDF-3 file."""
    with netcdf_file(io.BytesIO(content), mmap=False) as stored:
        held = stored.variables.items()
        arrays = {name: _array(one) for name, one in held if not _CODED & set(one._attributes)}
        if len(arrays) == len(held):  # nothing to decode: by the short way, as it was built
            return response_of(arrays, _words(stored._attributes))
    source = xr.open_dataset(io.BytesIO(content), engine="scipy", decode_times=False)
    return source.load().drop_encoding()


def _array(stored: netcdf_variable) -> tuple[tuple[str, ...], Any, dict[str, Any]]:
    """Dimensions, values and attributes of a variable; texts stand as characters in the file."""
    values, attributes = stored.data, _words(stored._attributes)
    if stored.typecode() != "c":
        return stored.dimensions, values.astype(values.dtype.newbyteorder("=")), attributes
    words = values.view(f"S{values.shape[-1]}").reshape(values.shape[:-1])
    return stored.dimensions[:-1], np.char.decode(words, attributes.pop("_Encoding")), attributes


def _words(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes of a file, its texts decoded."""
    return {
        name: value.decode() if isinstance(value, bytes) else value.item()
        for name, value in attributes.items()
    }


@dataclass(frozen=True)
class Store:
    """The stored cells, tables and manifest of one study under `directory`."""

    directory: Path

    @property
    def cells(self) -> Path:
        """Directory of the cells."""
        return self.directory / "cells"

    @property
    def tables(self) -> Path:
        """Directory of the tables that the assessment writes."""
        return self.directory / "tables"

    @property
    def manifest(self) -> Path:
        """The manifest file."""
        return self.directory / "manifest.json"

    def prepare(self) -> None:
        """Make the directories. Raises `InputError` if they cannot be written or are links."""
        for directory in (self.cells, self.tables):
            own_directory(self.directory, directory.name)

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Prepare and hold the lock of the store; what an interrupted run has left is removed.

        The system frees the lock when this process ends in any way. Raises `InputError` if
        another run holds it, whose files are not touched. A store that can only be read has no
        lock: no one writes there.
        """
        self.prepare()
        if not all(os.access(d, os.W_OK) for d in (self.directory, self.cells, self.tables)):
            yield
            return
        with locked(self.directory / ".lock"):
            for directory in (self.directory, self.cells, self.tables):
                for leftover in directory.glob(f"*{TEMPORARY}"):
                    leftover.unlink(missing_ok=True)
            yield

    def holds(self, key: str) -> bool:
        """Whether a cell has come to be stored under this key, whatever has become of it since.

        A file without a record was cut off before it counted.
        """
        return (self.cells / f"{key}.json").is_file()

    def answer(self, key: str, ingredients: Ingredients) -> tuple[Record, Response] | None:
        """Record and response of a cell, read once; None where it is not finished.

        Names of files prove nothing: record and response say themselves what they answer. Others
        may have written them: they are held to what is `asked` and to all that readers rely on. A
        cell that the store `holds` without an answer is corrupt.
        """
        try:
            record, file = self.record(key), self.cells / f"{key}.nc"
            content = file.read_bytes() if file.is_file() else b""  # a pipe would never end
            same = hashlib.sha256(content).hexdigest() == record["sha256"]
            sound = all(isinstance(record[name], kinds) for name, kinds in _RECORDED.items())
            if not (same and sound and record["key"] == key):
                return None
            response = _response_in(content)
            check_stored(response)
            return (
                (record, response) if _answers(response, ingredients, record["outcome"]) else None
            )
        except UNREADABLE:
            return None

    def put(self, key: str, content: bytes, record: Record) -> None:
        """Store the netCDF bytes of a cell, then its record."""
        digest = hashlib.sha256(content).hexdigest()
        signed = canonical_json({**record, "key": key, "sha256": digest})
        write_atomically(self.cells / f"{key}.nc", content)
        write_atomically(self.cells / f"{key}.json", signed)

    def remove(self, key: str) -> None:
        """Forget a cell; its record goes first."""
        (self.cells / f"{key}.json").unlink(missing_ok=True)
        (self.cells / f"{key}.nc").unlink(missing_ok=True)

    def keys(self) -> set[str]:
        """Keys of all cells that have a file or a record, finished or not."""
        return {path.stem for path in self.cells.glob("*.*") if path.suffix in (".nc", ".json")}

    def record(self, key: str) -> Record:
        """The record of a finished cell."""
        record: Record = json.loads((self.cells / f"{key}.json").read_text(encoding="utf-8"))
        return record

    def response(self, key: str) -> Response:
        """The response of a finished cell. Raises `WorkbenchError` if it cannot be read."""
        path = self.cells / f"{key}.nc"
        try:
            return read_netcdf(path)
        except UNREADABLE as error:
            raise WorkbenchError(f"stored cell {path.name} cannot be read: {error}") from error


def _answers(response: Response, ingredients: Ingredients, outcome: str) -> bool:
    """Whether a response says that it answers what is asked, and ended as its record says."""
    attributes = response.attrs
    same = all(attributes[mine] == ingredients[name] for name, mine in _SIGNED.items())
    options = json.loads(attributes["options"])
    return same and options == ingredients["options"] and outcome_of(response) == outcome


@dataclass(frozen=True)
class LoadedStudy:
    """A study and the `file` that defines it, which worker processes load as well."""

    study: Study
    file: Path


def study_files() -> dict[str, Path]:
    """Study files by name: those in ``studies/`` here, then those that come with the workbench."""
    files: dict[str, Path] = {}
    for directory in (Path("studies"), data_directory("studies")):
        for path in sorted(directory.glob("*.py")):
            if not path.stem.startswith("_"):
                files.setdefault(path.stem, path)
    return files


def load_study(name: str | Path) -> LoadedStudy:
    """Load a study by the path of its file or by its name in ``studies/``.

    Parameters
    ----------
    name : str or Path
        File, such as `workbench new study` prints one, or name of a study.

    Returns
    -------
    LoadedStudy
        The `study` and its `file`, which worker processes load as well.

    Raises
    ------
    InputError
        If there is no such study (naming the nearest one), if the file cannot be run, or if it
        does not define ``study = Study(...)``.

    Examples
    --------
    >>> len(wb.load_study("studies/mine.py").study.cases) > 1
    True
    """
    path = Path(name)
    if path.suffix != ".py":
        known = study_files()
        stem = str(name).replace("-", "_")
        if stem not in known:
            near = did_you_mean(stem, known)
            text = f"is not known; {near}".removesuffix("; ")
            advice = f"give the path of a study file, or one of {len(known)} names in ./studies"
            raise InputError("study", str(name), text, advice)
        path = known[stem]
    if not path.is_file():
        raise InputError("study", str(name), "there is no such file")
    study = study_in(path)
    for point in offered("sides"):  # further sides, as of answers of other programs
        study = point.load()(study)
    return LoadedStudy(study, path.resolve())


def study_in(path: Path) -> Study:
    """The study that a file defines, imported with its directory on the import path.

    The module name comes from the path, so that a worker process that loads the same file finds
    the classes that the file defines. Raises `InputError`.
    """
    path = path.resolve()
    name = f"workbench_study_{path.stem}_{hashlib.sha256(str(path).encode()).hexdigest()[:8]}"
    if name not in sys.modules:
        if str(path.parent) not in sys.path:
            sys.path.insert(0, str(path.parent))
        specification = importlib.util.spec_from_file_location(name, path)
        if specification is None or specification.loader is None:
            raise InputError("study", str(path), "is not a Python file")
        module = importlib.util.module_from_spec(specification)
        sys.modules[name] = module
        try:
            specification.loader.exec_module(module)
        except (Exception, SystemExit) as error:
            del sys.modules[name]
            if isinstance(error, InputError):
                raise
            trace = extract_tb(error.__traceback__)
            lines = [frame.lineno for frame in trace if frame.filename == str(path)]
            where = f"line {lines[-1]}: " if lines else ""
            text = f"cannot be loaded: {where}{message_of(error)}"
            raise InputError("study", path.name, text) from error
    study = getattr(sys.modules[name], "study", None)
    if not isinstance(study, Study):
        raise InputError("study", path.name, "must define study = Study(...)")
    return study
