"""What a finished impact run of members tells about its own accuracy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from workbench.responses import Finding

Array = NDArray[np.float64]
LARGEST_DAMPING = 0.05  # of the input energy, up to the peak; peaks are then 2 to 5 % too small
LEAST_STEPS_TO_PEAK = 30


def impact_accuracy(
    displacement: Array,
    algorithmic: Array,
    brought: float,
    end: float,
    softened: list[Finding],
    *,
    peaked: bool,
    body: str,
) -> list[Finding]:
    """Findings on the peak, the yield ratio, the time steps and their damping.

    Arguments: histories (steps,) of the `displacement` (m) and the `algorithmic` dissipation (J);
    energy `brought` in (J); `end` of the record in s; what the yield ratio says (`softened`);
    whether there is a peak (`peaked`); what moves as a whole (`body`), in words.
    """
    findings = []
    if not peaked:
        text = (
            f"the displacement still grows at the end of the record, {end:g} s: "
            "extend time.duration to find the peak"
        )
        findings.append(Finding("no-peak", text))
    findings += softened
    top = int(np.argmax(displacement))
    if peaked and top < LEAST_STEPS_TO_PEAK:
        text = f"the peak comes after {top} time steps only: reduce time_step"
        findings.append(Finding("time-step", text))
    damped = algorithmic[top] / brought
    if damped > LARGEST_DAMPING:
        text = (
            f"time stepping has dissipated {100 * damped:.1f} % of the impact energy before the "
            f"peak, as waves matter more than the motion of {body}: raise refinement"
        )
        findings.append(Finding("damping", text))
    return findings
