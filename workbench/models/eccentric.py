"""Hits beside the shear centre of an I section: how much farther they go than sections that keep.

Shells answered drawn pairs of hits along the web, one through the shear centre and one on the
flange beside it (data set `eccentric-hits`). The logarithm of what is struck over the axis of the
centred hit is a linear function of a few numbers that are known before a run; its interval is that
of the rests, each of a line without its own pair. See docs/theory/shell.md.
"""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.catalogue import load
from workbench.models.domain import mechanism_demand
from workbench.responses import Finding, finding
from workbench.scenarios import ColumnImpact
from workbench.steel.sections import ISection

DATASET, MESH = "eccentric-hits", -1  # the mesh that answered all pairs
EDGE, FACE = "eccentric_edge_m", "eccentric_face_m"  # of the struck flange; of the striker
BESIDE, PRESSED = "eccentricity_over_half_width", "axial_over_squash"
FEATURES = {
    BESIDE: "eccentricity over half the width of the flange",
    "ln_mechanism_over_flange": "ln of the resistance of the mechanism over f_y t_f squared",
    "ln_way_over_half_width": "ln of the way that the mechanism needs over half the width",
}
LEVELS = 0.05, 0.5, 0.95  # lower end, middle and upper end of the interval


class Line(NamedTuple):
    """Coefficients of a line (1 + features), sorted rests (pairs,), bounds of what was drawn."""

    coefficients: Array
    rests: Array
    least: dict[str, float]
    most: dict[str, float]


def features(scenario: ColumnImpact) -> dict[str, Any]:
    """The numbers that a factor hangs on, by the names of `FEATURES`, and P/Npl."""
    column, striker = scenario.column, scenario.striker
    properties, shape = column.properties, column.section.shape
    assert isinstance(shape, ISection)
    half, lumped = 0.5 * shape.width, properties.impact_mass / striker.mass
    resistance = sum(mechanism_demand(column).values()) * properties.shear_resistance
    local = column.steel.yield_stress * shape.flange**2
    way = scenario.input_energy / (1.0 + lumped) / resistance
    values = abs(striker.eccentricity) / half, np.log(resistance / local), np.log(way / half)
    pressed = column.axial_load / properties.squash_load
    return dict(zip(FEATURES, values, strict=True)) | {PRESSED: pressed}


@lru_cache(maxsize=2)
def line(target: str) -> Line:
    """The line of a `target`, `EDGE` or `FACE`, by least squares over the drawn pairs."""
    pairs = load(DATASET)
    pairs = pairs[(pairs["refinement"] == MESH) & (pairs["centred_outcome"] == "ok")]
    pairs = pairs[pairs["eccentric_outcome"] == "ok"]
    given = np.column_stack([np.ones(len(pairs)), pairs[list(FEATURES)]])
    ratios = np.log((pairs[target] / pairs["centred_axis_m"]).to_numpy())
    inverse = np.linalg.pinv(given)
    own = np.einsum("ij,ji->i", given, inverse)
    rests = (ratios - given @ inverse @ ratios) / (1.0 - own)
    drawn = pairs[[*FEATURES, PRESSED]]  # from the shear centre to the edge, from no load on
    least, most = {**drawn.min(), BESIDE: 0.0, PRESSED: 0.0}, {**drawn.max(), BESIDE: 1.0}
    return Line(inverse @ ratios, np.sort(rests), least, most)


def eccentric_finding(name: str, scenario: Any, beside: float) -> Finding:
    """What a model by this name, which knows no hit `beside` (m) the shear centre, says of it.

    The factor with which it answers where such hits were drawn, else its refusal.
    """
    if not is_drawn(scenario):
        return finding("eccentricity", beside, name=name)
    edge, face = (factor(scenario, target) for target in (EDGE, FACE))
    return finding("eccentric-factor", beside, name=name, edge=edge, face=face)


def is_drawn(scenario: Any) -> bool:
    """Whether such hits were drawn: along the web of an I section, on its flange, rigid."""
    if not isinstance(scenario, ColumnImpact):
        return False
    shape, striker = scenario.column.section.shape, scenario.striker
    if not isinstance(shape, ISection) or striker.crushes or np.any(striker.angle):
        return False
    values, known = features(scenario), line(EDGE)
    if np.ndim(sum(values.values())):  # a stack: its rows are asked one by one
        return False
    return all(known.least[each] <= values[each] <= known.most[each] for each in values)


def log_factors(scenario: ColumnImpact, target: str) -> Array:
    """Sorted ln of what is struck over the axis of the hit through the shear centre: (pairs,).

    The expected one with the rest of every drawn pair.
    """
    known, values = line(target), features(scenario)
    given = np.array([1.0, *(values[name] for name in FEATURES)])
    return np.asarray(known.coefficients @ given + known.rests)


def factor(scenario: ColumnImpact, target: str) -> tuple[float, float, float]:
    """Lower end, middle and upper end of 90 % of the factor of a `target`."""
    ends = np.quantile(log_factors(scenario, target), LEVELS, method="weibull")
    low, middle, high = map(float, np.exp(ends))
    return low, middle, high
