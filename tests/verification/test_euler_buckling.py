"""Euler's four cases: the axial load that makes the tangent singular."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh
from verification_cases import FORMULATIONS, along, free, hold, matrix, orders, slender_chain

CASES = {
    "cantilever": (("u", "v", "rotation"), (), (np.pi / 2) ** 2),
    "pinned": (("u", "v"), ("v",), np.pi**2),
    "propped": (("u", "v", "rotation"), ("v",), 4.493409457909064**2),
    "clamped": (("u", "v", "rotation"), ("v", "rotation"), (2 * np.pi) ** 2),
}


def buckling_load(kind: str, case: str, elements: int) -> float:
    base, head, _ = CASES[case]
    radius, probe = 1e-4, 1.0
    beam = slender_chain(kind, along(1.0, elements), radius)
    hold(beam, 0, *base)
    if head:
        hold(beam, elements, *head)
    part = np.ix_(free(beam), free(beam))

    def tangent(load: float) -> np.ndarray:
        x = np.zeros(beam.size)
        x[beam.dofs(range(elements + 1), "u")] = -load * radius**2 * beam.coordinates[:, 0]
        beam.assemble(x, None)
        return matrix(beam.tangent_times, beam.size)[part]

    unloaded = tangent(0.0)
    change = unloaded - tangent(probe)
    return probe / float(eigh(change, unloaded, eigvals_only=True)[-1])


@pytest.mark.parametrize("kind", FORMULATIONS)
@pytest.mark.parametrize("case", CASES)
def test_buckling_loads_converge_at_second_order(kind, case) -> None:
    exact = CASES[case][2]
    errors = [buckling_load(kind, case, n) / exact - 1.0 for n in (8, 16, 32, 64)]
    assert orders(errors) == pytest.approx(2.0, abs=0.15)  # measured 0.10
    assert abs(errors[-1]) <= 3.3e-3  # measured 0.0016
