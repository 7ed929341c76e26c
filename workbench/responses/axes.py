"""Coordinates of responses: their indexes and variables, by the short way.

Going through `xarray.Dataset(coords=...)` takes several times as long as solving the SDOF column.
"""

from collections.abc import Mapping, Sequence
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
    own = _ATTRIBUTES[name] if attributes is None else dict(attributes)
    return index, variable_of(xr.IndexVariable, (name,), held, own)


def names_axis(name: str, values: tuple[str, ...]) -> tuple[PandasIndex, xr.Variable]:
    """`axis_of` the names of parts, whose index many responses share."""
    return _own(name, *_kept(name, values))


def counted_axis(name: str, size: int) -> tuple[PandasIndex, xr.Variable]:
    """`axis_of` points along members, evenly spaced, or of numbers from 0; many share it."""
    return _own(name, *_counted(name, size))


def _own(name: str, index: PandasIndex, axis: xr.Variable) -> tuple[PandasIndex, xr.Variable]:
    """The index, and a variable of the same data with attributes of its own."""
    return index, variable_of(xr.IndexVariable, (name,), axis._data, _ATTRIBUTES[name])


@lru_cache(maxsize=256)
def _counted(name: str, size: int) -> tuple[PandasIndex, xr.Variable]:
    values: Any = np.linspace(0.0, 1.0, size) if name == "point" else np.arange(size)
    return axis_of(name, values)


@lru_cache(maxsize=256)
def _kept(name: str, values: tuple[str, ...]) -> tuple[PandasIndex, xr.Variable]:
    return axis_of(name, values)
