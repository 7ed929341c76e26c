"""Measure `fiber_truth.csv`: critical velocities of 2048 samples by fibers, one run at each.

    python tests/extras/uncertainty/fiber_truth.py

The column of study `fragility` that is hit at mid-height, limit 0.1 m, by `four-dof` and by
`fiber-reissner` on a coarse mesh (refinement -1). Columns: normal scores of the uncertain inputs,
ln of the critical velocity (m/s) of the four-DOF column, ln of the ratio of that of the fibers to
it. Rows that are there are kept: the script goes on where it was stopped.
"""

import csv
import sys
from pathlib import Path

import numpy as np

from workbench.extras.uncertainty.critical_velocity import DisplacementLimit, slopes_at
from workbench.extras.uncertainty.inputs import uncertain_from_text
from workbench.extras.uncertainty.sample_runs import Sampled, Setup, ratio_at
from workbench.models.four_dof import FourDof
from workbench.models.references.fiber_beams import FiberReissner

SAMPLES, SEED = 2048, 7
TABLE = Path(__file__).with_name("fiber_truth.csv")
COLUMN = """
kind = "column-impact"
[column]
section = "HEB 220"
length_below = 2.0
length_above = 2.0
head = "guided"
base = "clamped"
axial_load = { lognormal = { mean = 500e3, cov = 0.15 } }
restraint_stiffness = { lognormal = { mean = 1e7, cov = 0.3 } }
[steel]
elastic_modulus = { jcss = "steel" }
yield_stress = { jcss = "S355" }
[striker]
mass = { lognormal = { mean = 1500.0, cov = 0.1 } }
velocity = 10.0
[time]
duration = 0.2
"""


def main() -> None:
    """Write the rows that are missing."""
    uncertain = uncertain_from_text(COLUMN)
    models = FourDof(), FiberReissner(refinement=-1)
    setup = Setup(uncertain, *models, DisplacementLimit(0.1), (4.0, 20.0), SAMPLES)
    scores = uncertain.normal_scores(SAMPLES, (SEED, 0))
    reduced = Sampled.of(setup, scores, map)
    roots = reduced.roots(setup, np.full(SAMPLES, np.log(9.0)))
    at = np.array([root.log_velocity for root in roots])
    slopes = slopes_at(reduced.peaks_at, np.arange(SAMPLES), at, setup.limit)
    names = [*uncertain.names, "ln four-dof", "ln ratio"]
    if not TABLE.exists():
        TABLE.write_text(",".join(names) + "\n", encoding="utf-8")
    with TABLE.open(encoding="utf-8") as stream:
        present = sum(1 for _ in stream) - 1
    with TABLE.open("a", encoding="utf-8", newline="") as stream:
        for k in range(present, SAMPLES):
            ratio = ratio_at(setup, (scores[k : k + 1], float(at[k]), float(slopes[k])))
            numbers = [*scores[k], at[k], ratio.value]
            csv.writer(stream, lineterminator="\n").writerow(f"{each:.6g}" for each in numbers)
            stream.flush()


if __name__ == "__main__":
    sys.exit(main())
