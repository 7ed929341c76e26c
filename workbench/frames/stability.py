"""First-order forces of a frame under its dead loads, and the factor on them at which it buckles.

Linear elastic frame, two elements per member: the buckling load of a member with pinned ends is
0.8 % too large, with clamped ends 1.3 %.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.frames.elastic import ElasticFrame
from workbench.scenarios import Frame

Array = NDArray[np.float64]
HALVES = 2


class DeadLoadState(NamedTuple):
    """Axial forces (members,) in N, tension positive, and the critical factor on the dead loads.

    The factor is infinite without compression, and None for a mechanism.
    """

    axial: Array
    factor: float | None


def dead_load_state(frame: Frame) -> DeadLoadState:
    """First-order axial forces and buckling factor under the dead loads of a frame."""
    elastic = ElasticFrame(frame, springs=False, parts=HALVES)
    moved = None if elastic.is_mechanism else elastic.displacement(elastic.load(frame.loads))
    if moved is None:
        return DeadLoadState(np.zeros(len(frame.members)), None)
    axial, _ = elastic.end_forces(moved)
    return DeadLoadState(axial[::2], elastic.buckling_factor(axial))
