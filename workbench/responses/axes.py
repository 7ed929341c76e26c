"""Coordinates of responses: their indexes and variables, by the short way.

Going through `xarray.Dataset(coords=...)` takes several times as long as solving the SDOF column.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from xarray.core.indexing import PandasIndexingAdapter
from xarray.indexes import PandasIndex

from workbench.arrays import Array
from workbench.responses.variables import COORDINATES

_ATTRIBUTES = {name: one.attributes for name, one in COORDINATES.items()}


def axis_of(name: str, values: Sequence[Any] | Array) -> tuple[PandasIndex, xr.Variable]:
    """A coordinate of a response: its index and its variable."""
    if isinstance(values, np.ndarray) and values.dtype == np.float64:  # the rest is for asking
        known = pd.Index._simple_new(values, name=name)  # type: ignore[attr-defined]
        index = PandasIndex(known, name, values.dtype, fastpath=True)
    else:
        known = pd.Index(values, name=name)
        index = PandasIndex(known, name)
    held = PandasIndexingAdapter(known, index.coord_dtype)
    axis = xr.IndexVariable((name,), held, _ATTRIBUTES[name], fastpath=True)  # type: ignore[no-untyped-call]
    return index, axis


def names_axis(name: str, values: tuple[str, ...]) -> tuple[PandasIndex, xr.Variable]:
    """`axis_of` the names of parts, whose index many responses share."""
    index, axis = _kept(name, values)
    return index, axis.copy(deep=False)


def counted_axis(name: str, size: int) -> tuple[PandasIndex, xr.Variable]:
    """`axis_of` points along members, evenly spaced, or of numbers from 0; many share it."""
    index, axis = _counted(name, size)
    return index, axis.copy(deep=False)


@lru_cache(maxsize=256)
def _counted(name: str, size: int) -> tuple[PandasIndex, xr.Variable]:
    values: Any = np.linspace(0.0, 1.0, size) if name == "point" else np.arange(size)
    return axis_of(name, values)


@lru_cache(maxsize=256)
def _kept(name: str, values: tuple[str, ...]) -> tuple[PandasIndex, xr.Variable]:
    return axis_of(name, values)
