"""What was measured of one-mass models under pulses: where their peaks were in error.

`studies/drawn_pulses.py rules` writes the table; a row is a range of ductility of a model.
"""

from typing import Any

import numpy as np

from workbench.evidence.descriptors import measured_rows
from workbench.models.base import Model
from workbench.responses import Finding, Response, finding

PULSES = "pulses"
BEYOND, TOLERATED = 0.10, 0.1  # error of the peak that matters, chance of it that needs no warning


def pulse_findings(model: Model, load: str, response: Response) -> list[Finding]:
    """Warning of a model where members of the study `drawn_pulses` were often off."""
    reached = ductility(response)
    for row in measured_rows(PULSES) if reached is not None else ():
        here = row["least"] <= reached < row["most"]
        risky = chance_of(row) > TOLERATED
        if (row["model"], row["load"]) == (model.name, load) and here and risky:
            state = "yielding" if row["least"] else "elastic"
            off = row["low"] + row["high"]
            parts = "sides" if off else "few", "spread"
            values = {**row, "state": state, "off": off, "bound": 100.0 * BEYOND}
            return [
                finding("measured-under-pulses", float(off / row["count"]), parts=parts, **values)
            ]
    return []


def ductility(response: Response) -> float | None:
    """The peak of a single mass over that of an elastic one under the same resistance."""
    if not {"displacement", "force"} <= set(response.data_vars):
        return None
    displacement, force = response["displacement"].values, response["force"].values
    first, top = int(np.argmax(displacement > 0.0)), int(np.argmax(displacement))
    if not force[top] > 0.0:
        return None
    return float(displacement[top] / force[top] * force[first] / displacement[first])


def chance_of(row: dict[str, Any]) -> float:
    """Expected share of cases beyond the bound, the mean of its posterior: few cases warn."""
    return float((row["low"] + row["high"] + 1.0) / (row["count"] + 2.0))
