"""Files of a store: written so that a reader sees the old content or the new one, never a half.

Equal content gives equal bytes, in JSON, CSV and netCDF-4 alike.
"""

import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr

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
        plain = not isinstance(value, (bool, list))
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
