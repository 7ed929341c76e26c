"""A clamped beam that cannot slide: from bending to a plastic catenary (Haythornthwaite 1957)."""

from __future__ import annotations

import numpy as np
import pytest
from verification_cases import FORMULATIONS, PLASTIC_MOMENT, SIDE, SQUASH, hold, steel_chain

from workbench.mechanics.structures.paths import push

SPAN, ELEMENTS = 8.0, 64


def path(kind: str) -> np.ndarray:
    """Deflection, force, axial force and moment of the element at mid-span."""
    x = np.linspace(0.0, SPAN, ELEMENTS + 1)
    beam = steel_chain(kind, np.stack([x, 0.0 * x], axis=1))
    hold(beam, 0)
    hold(beam, ELEMENTS)
    middle = beam.dof(ELEMENTS // 2, "v")
    rows = []
    for step in push(beam, middle, np.linspace(0.0, 4.0 * SIDE, 161)[1:]):
        N, start, end = beam.groups[0].local_forces[ELEMENTS // 2]
        rows.append((step.displacement, step.factor, N, 0.5 * abs(end - start)))
    return np.array(rows).T


def test_axial_force_and_moment_stay_on_the_exact_envelope() -> None:
    """M / Mp + (N / Np)^2 = 1 for a rectangle, from the mechanism to the catenary.

    In Reissner's beam, whose elements have one section that both forces belong to.
    """
    deflection, _, N, M = path("reissner")
    plastic = deflection > 0.55 * SIDE  # the first hinges are complete
    n, m = N[plastic] / SQUASH, M[plastic] / PLASTIC_MOMENT
    assert np.max(np.abs(m + n**2 - 1.0)) <= 0.02
    assert np.ptp(n) > 0.4  # the path covers the envelope


@pytest.mark.parametrize("kind", FORMULATIONS)
def test_the_catenary_carries_what_the_squash_load_can(kind) -> None:
    """F = 2 Np w / (half span) along the line of thrust, once bending has been used up."""
    deflection, force, N, _ = path(kind)
    assert N[-1] == pytest.approx(SQUASH, rel=0.02)
    slope = deflection[-1] / np.hypot(deflection[-1], 0.5 * SPAN)
    assert force[-1] == pytest.approx(2.0 * SQUASH * slope, rel=0.013)  # measured 0.006
