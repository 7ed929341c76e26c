"""Frequencies of beams in closed form, from the tangent and the mass matrix."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh
from verification_cases import FORMULATIONS, along, free, hold, matrix, orders, slender_chain

CASES = {
    "cantilever": (("u", "v", "rotation"), (), (1.875104068711961, 4.694091132974175)),
    "pinned": (("u", "v"), ("u", "v"), (np.pi, 2 * np.pi)),
    "propped": (("u", "v", "rotation"), ("u", "v"), (3.926602312047919, 7.068582745628732)),
    "clamped": (("u", "v", "rotation"),) * 2 + ((4.730040744862704, 7.853204624095838),),
}


def roots(kind: str, case: str, elements: int) -> np.ndarray:
    base, head, _ = CASES[case]
    # thinner, rounding drowns the lowest mode; thicker, its rotary inertia is seen
    beam = slender_chain(kind, along(1.0, elements), radius=3e-4)
    hold(beam, 0, *base)
    if head:
        hold(beam, elements, *head)
    part = np.ix_(free(beam), free(beam))
    beam.assemble(np.zeros(beam.size), None)
    stiffness = matrix(beam.tangent_times, beam.size)[part]
    mass = matrix(beam.mass_times, beam.size)[part]
    # the other way round rounding errors of the axial stiffness would drown the lowest modes
    return eigh(mass, stiffness, eigvals_only=True)[-1:-3:-1] ** -0.25


@pytest.mark.parametrize("kind", FORMULATIONS)
@pytest.mark.parametrize("case", CASES)
def test_first_two_frequencies_at_second_order(kind, case) -> None:
    exact = np.array(CASES[case][2])
    errors = np.array([(roots(kind, case, n) / exact) ** 2 - 1.0 for n in (8, 16, 32, 64)])
    for mode in range(2):
        assert orders(errors[:, mode]) == pytest.approx(2.0, abs=0.15)  # measured 0.137
    assert np.max(np.abs(errors[-1])) <= 4e-3  # measured 0.002
