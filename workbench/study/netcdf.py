"""Responses as netCDF-4 bytes: equal responses give equal bytes."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import xarray as xr

from workbench.responses import VOLATILE, Response

_COMPRESSED_FROM = 256  # values; below, the chunk index costs more than compression saves


def without_volatile(response: Response) -> Response:
    """The response without the attributes that change from run to run."""
    kept = {name: value for name, value in response.attrs.items() if name not in VOLATILE}
    stripped = response.copy(deep=False)
    stripped.attrs = kept
    return stripped


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
    response: Response = xr.load_dataset(path, engine="netcdf4", decode_times=False)
    for variable in response.variables.values():
        variable.encoding = {}
    response.encoding = {}
    return response
