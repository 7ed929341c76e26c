"""Lee's frame: snap-through and snap-back (Schweizerhof and Wriggers 1986)."""

from __future__ import annotations

import numpy as np
import pytest
from verification_cases import FORMULATIONS, hold, slender_chain

from workbench.structures.arc_length import follow


@pytest.mark.parametrize("kind", FORMULATIONS)
def test_lee_frame(kind) -> None:
    """Limit loads 18.55 and -9.43 EI / L^2, both ends hinged, load at a fifth of the beam."""
    part = 20
    ticks = np.linspace(0.0, 1.0, part + 1)
    upright = np.stack([0.0 * ticks, ticks], axis=1)
    beam = np.stack([ticks[1:], 1.0 + 0.0 * ticks[1:]], axis=1)
    frame = slender_chain(kind, np.concatenate([upright, beam]))
    hold(frame, 0, "u", "v")
    hold(frame, 2 * part, "u", "v")
    frame.load[frame.dof(part + part // 5, "v")] = -1.0
    factors = np.array([s.factor for s in follow(frame, 0.05, 400, 0.15)])
    top = int(np.flatnonzero(np.diff(factors) < 0.0)[0])
    assert factors[top] == pytest.approx(18.55, rel=5e-3)
    assert factors[top:].min() == pytest.approx(-9.43, rel=2e-2)
