"""Curves as few whole numbers: thinned, rounded to a step, each as its difference from the last.

A page decodes them by sums; see `unpacked`, and the same in the page's script.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array


class Detail(NamedTuple):
    """How much a page keeps: most points of a history, snapshots, points of bands and energies."""

    points: int
    snapshots: int
    coarse: int


# from fine to rough; the first that fits counts
DETAILS = (
    Detail(500, 61, 80),
    Detail(300, 61, 50),
    Detail(200, 31, 40),
    Detail(120, 21, 25),
    Detail(60, 11, 15),
    Detail(24, 5, 8),
)
FINE, ROUGH = 10_000, 2_000  # steps of the largest magnitude of a curve; of a shape


def packed(values: ArrayLike, fine: int = FINE) -> dict[str, Any]:
    """Values (..., n) as whole multiples of a step, along the first axis each less the last one.

    The step is the largest magnitude over `fine`, rounded to three digits.
    """
    table = np.asarray(values, dtype=float)
    largest = float(np.abs(table).max(initial=0.0))
    step = float(f"{largest / fine:.3g}") or 1.0  # nothing to tell apart, or too small for that
    whole = np.round(table / step).astype(np.int64)
    first = np.zeros_like(whole[:1])
    return {"step": step, "n": np.diff(whole, axis=0, prepend=first).ravel().tolist()}


def unpacked(kept: dict[str, Any], width: int = 1) -> Array:
    """The values (n, width) that `packed` kept, as a page sees them."""
    rows = np.array(kept["n"], dtype=float).reshape(-1, width)
    return np.asarray(np.cumsum(rows, axis=0) * kept["step"])
