"""Make ``synthetic.csv``: impact tests that nobody has made, to show the form of a comparison.

Peaks and permanent displacements are answers of `fiber-shear`, times a lognormal factor drawn with
a fixed seed, as a laboratory would scatter. They validate nothing: a model is compared with another
one. Run: ``python data/impacts/make_synthetic.py``.
"""

import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from workbench.extras.intake.impact_tests import scenario_of
from workbench.models.references.fiber_beams import FiberShear

SEED = 20261122
SCATTER = {"peak": 0.03, "residual": 0.05}  # standard deviations of the logarithms
COVERED = 2.0  # standard deviations in a half-width that holds 95 %
# section, span, hit at, base, head, axial load (N), mass, velocity
BEAMS, COLUMNS = "SYNTHETIC beams", "SYNTHETIC columns"
HITS = {
    (BEAMS, "B1"): ("IPE 200", 3.0, 1.5, "pinned", "pinned", 0.0, 500.0, 4.0),
    (BEAMS, "B2"): ("IPE 200", 3.0, 1.5, "pinned", "pinned", 0.0, 500.0, 6.0),
    (BEAMS, "B3"): ("IPE 200", 3.0, 1.0, "pinned", "pinned", 0.0, 500.0, 6.0),
    (BEAMS, "B4"): ("HEB 160", 3.0, 1.5, "pinned", "pinned", 0.0, 800.0, 5.0),
    (BEAMS, "B5"): ("HEB 160", 3.0, 1.5, "pinned", "pinned", 0.0, 800.0, 7.0),
    (BEAMS, "B6"): ("HEB 160", 3.0, 0.6, "pinned", "pinned", 0.0, 800.0, 7.0),
    (COLUMNS, "C1"): ("HEB 160", 3.0, 1.5, "clamped", "guided", 1.5e5, 1000.0, 5.0),
    (COLUMNS, "C2"): ("HEB 160", 3.0, 1.5, "clamped", "guided", 1.5e5, 1000.0, 8.0),
    (COLUMNS, "C3"): ("HEB 160", 3.0, 0.75, "clamped", "guided", 1.5e5, 1000.0, 8.0),
    (COLUMNS, "C4"): ("HEB 220", 4.0, 1.0, "clamped", "guided", 3.0e5, 1500.0, 7.0),
    (COLUMNS, "C5"): ("HEB 220", 4.0, 1.0, "clamped", "pinned", 3.0e5, 1500.0, 7.0),
    (COLUMNS, "C6"): ("HEB 220", 4.0, 0.8, "clamped", "guided", 3.0e5, 1500.0, 10.0),
}
_COLUMNS = (
    *("section", "span_m", "hit_at_m", "base", "head", "axial_load_N", "mass_kg"),
    "velocity_m_per_s",
)
_FIXED = {
    **{"fillets": 0.0, "yield_stress_Pa": 355e6, "duration_s": 0.2},
    "source": "made by data/impacts/make_synthetic.py from answers of fiber-shear",
    **{"licence": "MIT (this repository)", "year": 2026, "role": "synthetic"},
}


def rows() -> Iterator[dict[str, object]]:
    """The rows, one after the other, as the noise is drawn."""
    drawn = np.random.default_rng(SEED)
    for (campaign, specimen), hit in HITS.items():
        given = dict(zip(_COLUMNS, hit, strict=True))
        row: dict[str, object] = {"campaign": campaign, "specimen": specimen, **given, **_FIXED}
        answer = FiberShear(levels=1).simulate(scenario_of(row))
        for name, scatter in SCATTER.items():
            value = float(answer[f"{name}_displacement"]) * np.exp(scatter * drawn.normal())
            row |= {f"{name}_m": f"{value:.4f}"}
            row |= {f"{name}_uncertainty_m": f"{COVERED * scatter * value:.4f}"}
        yield row


if __name__ == "__main__":
    made = list(rows())
    with Path(__file__).with_name("synthetic.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(made[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(made)
