"""The result store of a study: one netCDF file and one record for every cell.

``<directory>/cells/<key>.nc`` holds what is the same in every run, ``<key>.json`` what is not:
wall time, provenance, time stamps, and the digest of the file. The file is written first: a
cell counts as finished when its record is there and the digest agrees.
"""

import hashlib
import json
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from workbench.errors import InputError, WorkbenchError
from workbench.responses import Response
from workbench.study.files import TEMPORARY, canonical_json, read_netcdf, write_atomically

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
