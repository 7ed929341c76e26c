"""Meshes of member segments, graded towards both ends where plastic hinges form."""

from math import ceil, log

import numpy as np

from workbench.arrays import Array


def graded_lengths(
    length: float, smallest: float, largest: float, growth: float = 1.5, least: int = 4
) -> Array:
    """Element lengths of a segment: `smallest` at both ends, growing inwards up to `largest`.

    Arguments: `length` of the segment, `smallest` and `largest` element length in m; `growth`,
    ratio of neighbouring elements; `least` number of elements. Result: lengths (elements,) that
    sum to `length`, symmetric, slightly below the sizes asked for where they do not fit exactly.
    """
    # one element per unit of the integral of dx / h(x), h(x) = start + slope x up to the cap;
    # start is chosen so that the first element has the length `smallest`
    slope = log(growth)
    start = smallest * slope / (growth - 1.0)
    half = 0.5 * length
    graded = min(max((largest - start) / slope, 0.0), half)
    cap = max(largest, start)
    graded_count = log(1.0 + slope * graded / start) / slope
    half_count = graded_count + (half - graded) / cap
    count = max(ceil(2.0 * half_count - 1e-9), least)
    at = np.linspace(0.0, 2.0 * half_count, count + 1)
    inner = np.minimum(at, 2.0 * half_count - at)
    position = np.where(
        inner <= graded_count,
        start * np.expm1(slope * np.minimum(inner, graded_count)) / slope,
        graded + (inner - graded_count) * cap,
    )
    nodes = np.where(at <= half_count, position, length - position)
    return np.asarray(np.diff(nodes))


def halved(lengths: Array, times: int) -> Array:
    """Element lengths after halving every element `times` times."""
    return np.asarray(np.repeat(lengths, 2**times) / 2**times)
