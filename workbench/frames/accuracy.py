"""What a finished run of members tells about its own accuracy and its limits."""

from __future__ import annotations

import numpy as np

from workbench.frames.chains import named
from workbench.frames.record import Record
from workbench.responses import Finding

LARGEST_DAMPING = 0.05  # of the input energy, up to the peak; peaks are then 2 to 5 % too small
LEAST_STEPS_TO_PEAK = 30
LARGEST_SHEAR_STRAIN = 0.3  # mean of a member


def impact_accuracy(record: Record, brought: float) -> list[Finding]:
    """Findings on the time steps up to the peak and their damping; energy `brought` in (J)."""
    findings = []
    displacement, algorithmic = record.column("displacement"), record.spent("algorithmic")
    top = int(np.argmax(displacement))
    if top < min(LEAST_STEPS_TO_PEAK, len(displacement) - 1):
        text = f"the peak comes after {top} time steps only"
        findings.append(Finding("time-step", text, remedy="reduce time_step", number=top))
    damped = float(algorithmic[top] / brought)
    if damped > LARGEST_DAMPING:
        text = (
            f"time stepping has dissipated {100 * damped:.1f} % of the impact energy before the "
            "peak, as waves matter more than the motion of the frame"
        )
        findings.append(Finding("damping", text, remedy="raise refinement", number=damped))
    return findings


def softened(record: Record, least: float) -> list[Finding]:
    """Whether averaging over the steps has softened what yields: a yield ratio below `least`."""
    ratio = record.yield_ratio()
    if ratio is None or ratio >= least:
        return []
    text = (
        f"yield ratio {ratio:.4f} is below {least:g}: averaging over the step softens what yields"
    )
    return [Finding("yield-ratio", text, remedy="take a smaller time_step", number=ratio)]


def shear_reached(record: Record) -> list[Finding]:
    """Members that passed their plastic shear resistance or, where shear yields, that slide."""
    names = [member.name for member in record.structure.frame.members]
    strains = record.shear_strain
    if strains is not None:
        sliding = [names[i] for i in np.argsort(-strains) if strains[i] > LARGEST_SHEAR_STRAIN]
        if not sliding:
            return []
        text = (
            f"a mean shear strain of {strains.max():.2f} was reached in {named(sliding)}, above "
            f"{LARGEST_SHEAR_STRAIN}: the model lets members slide without stretching and misses "
            "the catenary action that then sets in"
        )
        return [Finding("shear-strain", text, number=float(strains.max()))]
    ratios = record.shear_utilisation()
    above = [names[i] for i in np.argsort(-ratios) if ratios[i] > 1.0]
    if not above:
        return []
    text = (
        f"V/Vpl = {ratios.max():.2f} was reached in {named(above)}, but shear does not yield in "
        "this model: it overestimates the resistance"
    )
    return [Finding("shear-reached", text, number=float(ratios.max()))]
