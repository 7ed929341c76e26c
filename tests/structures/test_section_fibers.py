"""Residual stresses of fibers: where they press and pull, and that they act so."""

from __future__ import annotations

import numpy as np
import pytest
from section_cases import response

from workbench.mechanics.structures.fibers import BeamSection, section_fibers
from workbench.mechanics.structures.fibers.section import LinearHardening
from workbench.steel.sections import find

E, FY = 210e9, 355e6


@pytest.mark.parametrize("pattern", ["triangular", "parabolic"])
@pytest.mark.parametrize(("name", "peak"), [("HEB 220", 0.5), ("IPE 300", 0.3)])
def test_flange_tips_and_mid_web_are_in_compression(pattern: str, name: str, peak: float) -> None:
    """ECCS 1984: each plate is in equilibrium by itself, junctions are in tension."""
    section = find(name)
    fibers = section_fibers(section, 40, pattern)
    web, flange = section.shape.plates
    tip = np.abs(fibers.y) > 0.5 * section.height - flange
    least = [float(fibers.residual[where].min()) for where in (tip, ~tip)]
    most = [float(fibers.residual[where].max()) for where in (tip, ~tip)]
    mid_web = 0.25 if pattern == "parabolic" else 1.0
    assert least == pytest.approx([-peak, -mid_web * peak], rel=0.15)
    assert min(most) > 0.3 * peak
    middle = np.argmin(np.abs(fibers.y))
    assert fibers.residual[middle] == pytest.approx(least[1])
    for where in (tip, ~tip):
        force = float(np.sum((fibers.residual * fibers.area)[where]))
        assert force == pytest.approx(0.0, abs=1e-9 * web * section.height)


def test_what_is_in_compression_yields_first_when_pressed() -> None:
    """Two fibers at rest, one pressed by 0.6 f_y, one pulled: further strain of 0.6 f_y / E."""
    section = BeamSection(
        *(np.array([-0.1, 0.1]), np.full(2, 0.01), LinearHardening(E, FY, 0.0), 1.0),
        initial_stress=0.6 * FY * np.array([-1.0, 1.0]),
    )
    old = np.zeros((section.law.states, 2))
    (at_rest, *_), _ = response(section, 0.0, 0.0, old)
    assert at_rest == pytest.approx(0.0, abs=1e-6)
    (pressed, *rest), _ = response(section, -0.6 * FY / E, 0.0, old)
    assert pressed == pytest.approx(-FY * 0.01)  # one at -f_y, the other at zero
    (stretched, *_), _ = response(section, 0.6 * FY / E, 0.0, old)
    assert stretched == pytest.approx(FY * 0.01)
    assert rest[1] == pytest.approx(-FY * 0.01 * 0.1)  # of -sum y sigma A
