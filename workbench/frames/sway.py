"""How near a frame that was hit came to the sway from which its dead loads carry it on.

The rigid-plastic sway of the frame resists R - c w at a drift w, c what its dead loads take of it:
beyond w = R / c it falls. The energy that it takes up to w is R w - c w^2 / 2; so a share q of R is
missing for the same energy to reach R / c where (1 - q)^2 = 1 - (1 - c w / R)^2. Near the end
little energy is left in much drift, and models that differ by some percent in what yields differ
in whether the frame stands.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from workbench.arrays import Array
from workbench.errors import OutOfDomainError
from workbench.frames.collapse_load import collapse_mechanism
from workbench.frames.column_line import column_line
from workbench.frames.findings import dead_load_state
from workbench.frames.structure import upright_names
from workbench.responses import Finding
from workbench.scenarios import FrameImpact, Load

SUBJECT = "near-collapse"
MISSING = 0.1  # of the resistance: what limits at yield and their spread leave open


class Sway(NamedTuple):
    """`reached` by a drift (uprights,) of 1 is the share of the drift that the dead loads need."""

    reached: Array

    def share(self, drift: Array) -> float:
        """Largest part of the way to R / c that drifts (uprights,) have gone."""
        return float(self.reached @ drift)


def sway_of(scenario: FrameImpact) -> Sway | None:
    """The sway of the storey above or below the struck column; None if dead loads take none of it.

    Its mechanism is that of a force at the head of the column, or at the struck joint.
    """
    frame, own = scenario.frame, scenario.striker
    if not frame.loads or own.direction[-1] != "x":
        return None
    try:
        node = column_line(scenario).head
    except OutOfDomainError:
        node = own.node
    push = Load(node, x=-1.0 if own.direction.startswith("-") else 1.0)
    found = collapse_mechanism(frame, [push], frame.loads)
    if found is None or not np.isfinite(found.factor) or found.factor <= 0.0:
        return None
    work = found.works(frame, dead_load_state(frame).axial)
    names = [member.name for member in frame.members]
    upright = [names.index(name) for name in upright_names(frame)]
    softening, turns = work.sum(), np.abs(found.turns(frame))[upright]
    if softening <= 0.0 or not np.any(turns > 0.0):
        return None
    # drifts over those of the mechanism, weighted by what the dead loads do on them
    weights = np.maximum(work[upright], 0.0)
    shares = np.divide(weights, turns, out=np.zeros_like(turns), where=turns > 0.0)
    return Sway(shares / weights.sum() * float(softening / found.factor))


def sway_findings(sway: Sway | None, drift: Array) -> list[Finding]:
    """Warning of a frame that stands, but with little resistance less would fall."""
    gone = 0.0 if sway is None else sway.share(drift)
    missing = 0.0 if gone >= 1.0 else 1.0 - sqrt(gone * (2.0 - gone))
    if missing >= MISSING:
        return []
    text = (
        f"the frame has swayed {gone:.2f} of the drift at which its dead loads bring it down: "
        f"{100.0 * missing:.2g} % less resistance and this hit does, and models differ by as much"
    )
    remedy = "try a few percent more velocity"
    return [Finding(SUBJECT, text, remedy=remedy, number=gone)]
