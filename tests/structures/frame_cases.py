"""Small frames that the tests of drivers share."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from reissner_cases import square

from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.fibers import BeamSection
from workbench.mechanics.structures.fibers.section import LinearHardening, ReissnerBeams

HEIGHT, SPAN = 4.0, 6.0


def portal(
    parts: int = 4, section: BeamSection | None = None, lumped: bool = False
) -> tuple[PlanarAssembly, dict[str, int]]:
    """A portal with clamped feet, `parts` elements a half member; nodes by name.

    The names: foot-left, side-left (mid-height), knee-left, crown, knee-right, foot-right.
    """
    corners = {
        "foot-left": (0.0, 0.0),
        "side-left": (0.0, 0.5 * HEIGHT),
        "knee-left": (0.0, HEIGHT),
        "crown": (0.5 * SPAN, HEIGHT),
        "knee-right": (SPAN, HEIGHT),
        "foot-right": (SPAN, 0.0),
    }
    points = [np.array(corners["foot-left"])]
    names = {"foot-left": 0}
    for start, end in pairwise(corners):
        a, b = np.array(corners[start]), np.array(corners[end])
        count = parts if end != "foot-right" else 2 * parts
        points.extend(a + (b - a) * i / count for i in range(1, count + 1))
        names[end] = len(points) - 1
    nodes = np.stack([np.arange(len(points) - 1), np.arange(1, len(points))], axis=1)
    kinds = np.zeros(len(nodes), dtype=np.int64)
    group = ReissnerBeams(nodes, kinds, [section or square()])
    frame = PlanarAssembly(np.array(points), [group], lumped=lumped)
    for foot in ("foot-left", "foot-right"):
        frame.hold([frame.dof(names[foot], c) for c in ("u", "v", "rotation")])
    return frame, names


def bar(
    hardening: float = 0.0, length: float = 2.0, area: float = 1e-3, lumped: bool = False
) -> tuple[PlanarAssembly, int]:
    """A bar of 210 GPa and 355 MPa held at its left end that can only stretch; its dof.

    Its own mass is 1 g/m: masses are put on it.
    """
    law = LinearHardening(210e9, 355e6, hardening)
    section = BeamSection(np.array([-0.01, 0.01]), np.full(2, 0.5 * area), law, 1e-3, 1e8)
    group = ReissnerBeams([[0, 1]], np.zeros(1, dtype=np.int64), [section])
    rod = PlanarAssembly([[0.0, 0.0], [length, 0.0]], [group], lumped=lumped)
    rod.hold([0, 1, 2, 4, 5])
    return rod, rod.dof(1, "u")
