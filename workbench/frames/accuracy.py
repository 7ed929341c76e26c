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
    softened: list[Finding],
    *,
    body: str,
) -> list[Finding]:
    """Findings on the yield ratio, the time steps up to the peak and their damping.

    Arguments: histories (steps,) of the `displacement` (m) and the `algorithmic` dissipation (J);
    energy `brought` in (J); what the yield ratio says (`softened`); what moves as a whole
    (`body`), in words.
    """
    findings = list(softened)
    top = int(np.argmax(displacement))
    if top < min(LEAST_STEPS_TO_PEAK, len(displacement) - 1):
        text = f"the peak comes after {top} time steps only"
        findings.append(Finding("time-step", text, remedy="reduce time_step", number=top))
    damped = float(algorithmic[top] / brought)
    if damped > LARGEST_DAMPING:
        text = (
            f"time stepping has dissipated {100 * damped:.1f} % of the impact energy before the "
            f"peak, as waves matter more than the motion of {body}"
        )
        findings.append(Finding("damping", text, remedy="raise refinement", number=damped))
    return findings
