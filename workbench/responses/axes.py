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

from workbench.base.arrays import Array
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
