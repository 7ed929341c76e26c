"""Impact tests that are possible one by one and absurd together: units, columns, copies.

What is measured is held against the energy estimate: no judgement of the tests, which it may miss
by a factor of two, but of units, which it misses by more.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pandas as pd

from workbench.base.tables import plain_rows
from workbench.extras.intake.impact_tests.rows import STANDS, scenario_of
from workbench.models.domain import LEAST_LOAD
from workbench.models.energy_estimate import EnergyEstimate
from workbench.responses import Finding, Outcome, finding, outcome_of
from workbench.scenarios import ColumnImpact
from workbench.studs.schema import Row, known
from workbench.studs.tables import copies

USUAL = 4.0  # factor by which the estimate may miss the median of a campaign
# what the numbers may have been in: unit, and factors on velocity and mass that put it right
_READ_AS = {
    "velocity in km/h instead of m/s": (1.0 / 3.6, 1.0),
    "velocity in mph instead of m/s": (0.44704, 1.0),
    "velocity in ft/s instead of m/s": (0.3048, 1.0),
    "mass in lb instead of kg": (1.0, 0.45359237),
    "mass in t instead of kg": (1.0, 1000.0),
    "mass in g instead of kg": (1.0, 0.001),
}
_LIKELY, _NAMED = np.log(2.5), 3  # a reading brings the median this near; how many are named
_NUMBERS = ("span_m", "hit_at_m", "axial_load_N", "mass_kg", "velocity_m_per_s", "peak_m")


def suspicions(rows: pd.DataFrame) -> list[Finding]:
    """Findings on implausible rows of a table of impact tests, one per suspicion."""
    campaigns = {str(name): plain_rows(of) for name, of in rows.groupby("campaign", sort=False)}
    copied = (finding("same-test", first=a, second=b) for a, b in same_contents(rows))
    return [
        *(each for name, of in campaigns.items() for each in _loads(name, of)),
        *copied,
        *(each for name, of in campaigns.items() for each in _energies(name, of)),
    ]


def _loads(campaign: str, rows: list[Row]) -> Iterator[Finding]:
    columns = [scenario_of(row).column for row in rows]
    shares = [abs(c.axial_load) / c.properties.squash_load for c in columns if c.axial_load]
    if shares and max(shares) < LEAST_LOAD:
        yield finding("impact-axial-loads", campaign=campaign, share=max(shares))


def same_contents(rows: pd.DataFrame) -> list[tuple[str, str]]:
    """Names of rows that hold the same numbers, a measured peak among them."""
    return copies(
        (f"{row['campaign']} {row['specimen']}", tuple(known(row, n) or 0.0 for n in _NUMBERS))
        for row in plain_rows(rows)
        if known(row, "peak_m") is not None
    )


def _energies(campaign: str, rows: list[Row]) -> Iterator[Finding]:
    """Peaks against the energy estimate, and which other reading of the numbers would fit."""
    hits = [
        (scenario_of(row), peak)
        for row in rows
        if (peak := known(row, "peak_m")) is not None and row["collapse"] == STANDS
    ]
    if not hits:
        return
    ratio = _ratio(hits)
    if ratio is not None and 1.0 / USUAL <= ratio <= USUAL:
        return
    readings = {
        name: _ratio([(_as(hit, *factors), peak) for hit, peak in hits])
        for name, factors in _READ_AS.items()
    }
    fitting = {name: abs(np.log(each)) for name, each in readings.items() if each is not None}
    if ratio is not None:
        for unit, times in {"mm": 1000.0, "cm": 100.0, "inches": 1.0 / 0.0254}.items():
            fitting[f"peaks in {unit} instead of m"] = abs(np.log(ratio / times))
    likely = [name for name in sorted(fitting, key=fitting.__getitem__) if fitting[name] < _LIKELY]
    guess = " or ".join(likely[:_NAMED]) or "units or columns"
    if ratio is None:
        yield finding("impact-survivors", campaign=campaign, guess=guess)
    else:
        yield finding("impact-peaks", campaign=campaign, ratio=ratio, guess=guess)


def _ratio(hits: list[tuple[ColumnImpact, float]]) -> float | None:
    """Median of measured over estimated peak, None where more than half have no estimate.

    `hits`: scenarios with the measured peak (m) of each.
    """
    ratios = []
    for hit, peak in hits:
        answer = EnergyEstimate().simulate(hit)
        if outcome_of(answer) is Outcome.OK:
            ratios.append(peak / float(answer["peak_displacement"]))
    return float(np.median(ratios)) if 2 * len(ratios) > len(hits) else None


def _as(hit: ColumnImpact, velocity: float, mass: float) -> ColumnImpact:
    """The hit with velocity and mass times a factor, held within what a scenario may say."""
    striker = replace(
        hit.striker,
        velocity=min(hit.striker.velocity * velocity, 300.0),
        mass=min(hit.striker.mass * mass, 1e7),
    )
    return replace(hit, striker=striker)
