"""The result store of a study: one netCDF file and one record for every cell.

``<directory>/cells/<key>.nc`` holds what is the same in every run, ``<key>.json`` what is not:
wall time, provenance, time stamps, and the digest of the file. The file is written first: a
cell counts as finished when its record is there and the digest agrees. A reader of any file sees
the old content or the new one, never a half; equal content gives equal bytes, in JSON, CSV and
netCDF-4 alike.
"""

import hashlib
import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr

from workbench.errors import InputError, WorkbenchError
from workbench.responses import Response

TEMPORARY = ".partial"
_COMPRESSED_FROM = 256  # values; below, the chunk index costs more than compression saves

Row = Mapping[str, Any]


def write_atomically(path: Path, content: bytes) -> None:
    """Write, flush to the disk, then rename into place.

    A process killed in between leaves a file ending in `TEMPORARY`, which nobody reads.
    """
    temporary = path.with_name(f"{path.name}.{os.getpid()}{TEMPORARY}")
    try:
        with temporary.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


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


def csv_bytes(rows: Sequence[Row], columns: Sequence[str]) -> bytes:
    """Rows as CSV with a header; None is an empty field, floats keep all digits, lists are JSON."""

    def field(value: Any) -> Any:
        plain = not isinstance(value, (bool, list, tuple))
        return value if plain else json.dumps(value, ensure_ascii=False)

    table = pd.DataFrame(rows, columns=list(columns), dtype=object).map(field)
    return table.to_csv(index=False, lineterminator="\n").encode()


def to_netcdf_bytes(response: Response) -> bytes:
    """A response as the bytes of a netCDF-4 file, without time stamps or fill values."""
    encoding: dict[Any, dict[str, Any]] = {}
    for name, variable in response.variables.items():
        encoding[name] = {"_FillValue": None}
        if variable.dtype.kind == "f" and variable.size >= _COMPRESSED_FROM:
            encoding[name].update(zlib=True, complevel=4, shuffle=True)
    with tempfile.TemporaryDirectory(prefix="workbench-") as directory:
        path = Path(directory) / "response.nc"
        response.to_netcdf(path, engine="netcdf4", format="NETCDF4", encoding=encoding)
        return path.read_bytes()


def read_netcdf(path: Path) -> Response:
    """Read a stored response into memory (times stay in seconds)."""
    return xr.load_dataset(path, engine="netcdf4", decode_times=False).drop_encoding()


Record = dict[str, Any]


class Presence(StrEnum):
    """Whether the store holds a cell."""

    ABSENT = "absent"
    FINISHED = "finished"
    CORRUPT = "corrupt"


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
        """Make the directories and remove what an interrupted run has left behind.

        Raises `InputError` if the directory cannot be written.
        """
        try:
            self.cells.mkdir(parents=True, exist_ok=True)
            self.tables.mkdir(exist_ok=True)
            for directory in (self.directory, self.cells, self.tables):
                for leftover in directory.glob(f"*{TEMPORARY}"):
                    leftover.unlink(missing_ok=True)
        except OSError as error:
            raise InputError(
                "store", str(self.directory), f"cannot be written: {error.strerror}"
            ) from error

    def presence(self, key: str) -> Presence:
        """Whether the cell is finished, absent, or does not agree with its record."""
        file, record = self.cells / f"{key}.nc", self.cells / f"{key}.json"
        if not record.is_file():
            return Presence.ABSENT  # a file without a record was cut off before it counted
        try:
            digest = json.loads(record.read_text(encoding="utf-8"))["sha256"]
            content = file.read_bytes()
        except (OSError, ValueError, KeyError, TypeError):
            return Presence.CORRUPT
        same = hashlib.sha256(content).hexdigest() == digest
        return Presence.FINISHED if same else Presence.CORRUPT

    def put(self, key: str, content: bytes, record: Record) -> None:
        """Store the netCDF bytes of a cell, then its record."""
        digest = hashlib.sha256(content).hexdigest()
        write_atomically(self.cells / f"{key}.nc", content)
        write_atomically(
            self.cells / f"{key}.json", canonical_json({**record, "key": key, "sha256": digest})
        )

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
        """The response of a finished cell.

        Raises `WorkbenchError` if it cannot be read.
        """
        path = self.cells / f"{key}.nc"
        try:
            return read_netcdf(path)
        except (OSError, ValueError) as error:
            raise WorkbenchError(f"stored cell {path.name} cannot be read: {error}") from error
