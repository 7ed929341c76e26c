"""Numbers that describe hits and pulses before a run, and the variants of models.

**Second part.** Tables of the error of the anchor: drawn scenarios of one kind, their features and
cells.

What is expected at a point from measured ones near it is a line through all plus the mean rest
near. *Source:* Hoerl and Kennard 1970 for the ridge; Vovk, Gammerman and Shafer 2005 for rests
whose own value is left out (docs/theory/error-model.md).
"""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from math import floor, inf, nan, pi, sqrt
from typing import Any

import numpy as np
import pandas as pd

from workbench.base.arrays import Array
from workbench.base.catalogue import load
from workbench.base.errors import OutOfDomainError
from workbench.mechanics.frames.column_estimate import column_like
from workbench.models.domain import shear_demand
from workbench.models.hit_mass import elastic_energy, front_velocity
from workbench.models.resistance.shapes import stages_of
from workbench.models.strain_rate import rate_factor, stronger
from workbench.responses import COVERAGE
from workbench.scenarios import ColumnImpact, FrameImpact, MemberPulse
from workbench.scenarios.pulse import UNIFORM

DEMAND, YIELDING, STRIKER = "shear_demand", "energy_over_elastic", "striker_over_lumped"
FEATURES = {  # of the error model, and their words
    DEMAND: "V/Vpl of the mechanism",
    YIELDING: "energy of the hit over the elastic one",
    STRIKER: "striker over lumped mass",
    "turned": "energy of the hit over the work of the mechanism per length of the shorter segment",
    "axial_over_squash": "axial load over the squash load",
    "stiffening": "pull of the restraint less the axial load, over the mechanism",
    "front": "velocity over the one from which shear waves yield the webs",
    "shorter_over_length": "shorter segment over the length",
}
LOADED, LASTS = "loaded_over_length", "impulse_over_force_and_period"
DRAWN_SHAPES = ("rectangular", "triangular", "exponential", "friedlander")
PULSE_FEATURES = {
    LOADED: "loaded length over length",
    DEMAND: FEATURES[DEMAND],
    LASTS: "impulse over largest force and period",
    "force_over_resistance": "largest force over the resistance of the mechanism",
    "direct_shear": "half of a force at a point over Vpl",
    "axial_over_squash": FEATURES["axial_over_squash"],
    "shorter_over_length": FEATURES["shorter_over_length"],
}
FRAME_FEATURES = FEATURES | {"members": "members of the frame"}
FACTOR = "rate_factor"
RATE_FEATURES = {
    DEMAND: FEATURES[DEMAND],
    STRIKER: FEATURES[STRIKER],
    FACTOR: "factor on the yield stress for the strain rate",
}
_NO_NUMBERS = ("levels",)  # options that leave the answer as it is


def features(scenario: ColumnImpact) -> dict[str, float]:
    """The numbers that the error of a column may hang on, by the names of `FEATURES`.

    The pull acts at the displacement that the mechanism alone would need, elastic up to the squash
    load, and across the column by the turn of both segments.
    """
    column, striker, demand = scenario.column, scenario.striker, shear_demand(scenario)
    properties, below, above = column.properties, column.length_below, column.length_above
    lumped = properties.impact_mass / striker.mass
    resistance = sum(min(each, 1.0) for each in demand.values()) * properties.shear_resistance
    values = {
        DEMAND: max(demand.values()),
        YIELDING: scenario.input_energy / (1.0 + lumped) / elastic_energy(column),
        STRIKER: 1.0 / lumped,
    }
    way = scenario.input_energy / (1.0 + 1.0 / values[STRIKER]) / resistance
    turn = way / below + way / above
    stiffness = column.steel.elastic_modulus * properties.area / column.length
    if column.head != "fixed":
        ratio = column.restraint_stiffness / stiffness
        stiffness *= ratio / (1.0 + ratio)
    pull = min(0.5 * stiffness * way * turn, properties.squash_load)
    return {
        **values,
        "turned": way / min(below, above),
        "axial_over_squash": column.axial_load / properties.squash_load,
        "stiffening": (pull - column.axial_load) * turn / resistance,
        "front": striker.velocity / front_velocity(scenario),
        "shorter_over_length": min(below, above) / column.length,
    }


def rate_features(scenario: ColumnImpact) -> dict[str, float]:
    """Features of the column with one factor on the yield stress, and the factor, of a rate law."""
    factor = rate_factor(scenario, shear_yields=True)
    return {**features(stronger(scenario, factor)), FACTOR: factor}


def pulse_features(scenario: MemberPulse) -> dict[str, float]:
    """Numbers of a member under a pulse, without units, by the names of `PULSE_FEATURES`.

    Period and resistance are those of its elastic and its last stage by Biggs. Raises
    `OutOfDomainError` for shapes that were not drawn.
    """
    column, pulse, uniform = scenario.column, scenario.pulse, scenario.load == UNIFORM
    if pulse.shape not in DRAWN_SHAPES:
        raise OutOfDomainError(f"pulses of the shape {pulse.shape} were not drawn")
    elastic, *_, mechanism = stages_of(column, uniform=uniform)
    mass = elastic.load_mass_factor * column.properties.mass_per_length * column.length
    period = 2.0 * pi * sqrt(mass / elastic.stiffness)
    force = pulse.peak * scenario.whole
    return {
        LOADED: float(uniform),
        DEMAND: max(shear_demand(scenario).values()),
        LASTS: pulse.whole / pulse.peak / period,
        "force_over_resistance": force / mechanism.load,
        "direct_shear": 0.0 if uniform else 0.5 * force / column.properties.shear_resistance,
        "axial_over_squash": column.axial_load / column.properties.squash_load,
        "shorter_over_length": min(column.length_below, column.length_above) / column.length,
    }


def frame_features(scenario: FrameImpact) -> dict[str, float]:
    """Features of the struck column as its frame holds it, and the `members`, by `FRAME_FEATURES`.

    Raises `OutOfDomainError` for what was not drawn: hits on no column, joints that turn, springs.
    """
    column, frame = column_like(scenario), scenario.frame
    if frame.joints or any(n.spring_x or n.spring_y or n.spring_rotation for n in frame.nodes):
        raise OutOfDomainError("frames with springs or joints that turn were not drawn")
    if column is None:
        raise OutOfDomainError("hits on columns between their ends were drawn")
    return {**features(column), "members": float(len(frame.members))}


@lru_cache(maxsize=256)
def _options(model: Any) -> tuple[str, ...]:
    """The options of a model that differ from the default and change its numbers: ``a=1``."""
    values = ((f.name, f.default, getattr(model, f.name)) for f in dataclasses.fields(model))
    return tuple(
        f"{name}={value}"
        for name, default, value in values
        if value != default and name not in _NO_NUMBERS
    )


def variant_of(model: Any) -> str:
    """The options of a model that differ from the default and change its numbers: ``a=1 b=x``."""
    return " ".join(_options(model))


def command_of(model: Any) -> str:
    """A model with these options as the command line names it."""
    return " --option ".join((model.name, *_options(model)))


ANCHOR, REFERENCE, FINEST = "flexible-superelement", "fiber-shear", "solid-plane-stress"
FACTOR_BEAM = "fiber-shear-factor"  # the reference with one factor for the strain rate
MARGIN, NEAREST = 0.05, 20  # of the range of a feature that nobody drew; neighbours of a point
RIDGE = 10.0  # on standard features
CUT = 0.02  # share of the values at each end that the line does not follow
LEAST = 19  # values whose extremes hold nine of ten
FEWEST = 8  # drawn scenarios from which the error of the reference is known
TRUTH = "reference_peak"  # column of the table, in m; infinite: a collapse, empty: none


class LocalMean:
    """Expected values from measured `values` (n,) at `points` (n, k), on any scales."""

    def __init__(self, points: Array, values: Array) -> None:
        self.values = values
        self._mean, self._scale = points.mean(axis=0), np.maximum(points.std(axis=0), 1e-9)
        self._places = self._standard(points)
        sides, shrink = self._with_one(self._places), RIDGE * np.eye(points.shape[1] + 1)
        shrink[0, 0] = 0.0
        cut = np.clip(values, *np.quantile(values, [CUT, 1.0 - CUT]))
        self._line = np.linalg.solve(sides.T @ sides + shrink, sides.T @ cut)
        self._off = cut - sides @ self._line

    def at(self, point: Array) -> float:
        """Expected value at a point (k,); measured ones at this very point are left out."""
        place = self._standard(point)
        distances = np.linalg.norm(self._places - place, axis=1)
        distances[distances == 0.0] = np.inf
        near = np.argsort(distances)[: min(NEAREST, len(distances) - 1)]
        weights = 1.0 - (distances[near] / distances[near[-1]]) ** 2 + 1e-9
        line = float(self._with_one(place) @ self._line)
        return line + float(weights @ self._off[near] / weights.sum())

    @cached_property
    def rests(self) -> Array:
        """The values less what the others make expect of them (n,)."""
        points = self._places * self._scale + self._mean
        rests: Array = self.values - np.array([self.at(point) for point in points])
        return rests

    def _standard(self, points: Array) -> Array:
        standard: Array = np.round((points - self._mean) / self._scale, 9)
        return standard

    @staticmethod
    def _with_one(places: Array) -> Array:
        sides: Array = np.concatenate([np.ones((*places.shape[:-1], 1)), places], axis=-1)
        return sides


@dataclass(frozen=True)
class ErrorTable:
    """Where the anchor was measured, for one `kind` of scenarios.

    Arguments: `dataset` of the catalogue, a row for every scenario that the `study` draws;
    `features` of a scenario by name, as its columns have them, with their `words`; `cells`, bounds
    of features between cells; `doubted`, those between which the finest reference judged the
    reference (empty: it did not); share by which the peak of an anchor `grows`, at 1.05 of the
    load, that is close to collapse; whether intervals are `centred` by what is near; names of
    `anchor` and `reference`; the table of what a rate law adds (`rated`; None: not measured);
    `factor`, a feature at which, if it is 1, nothing is off: errors grow in proportion to what it
    has beyond 1, and below all that were drawn are at most those of the least (empty: none does).
    """

    kind: str
    dataset: str
    study: str
    features: Callable[[Any], dict[str, float]]
    words: Mapping[str, str]
    cells: Mapping[str, tuple[float, ...]]
    doubted: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    grows: float = 0.13
    centred: bool = False
    anchor: str = ANCHOR
    reference: str = REFERENCE
    rated: "ErrorTable | None" = None
    factor: str = ""

    @cached_property
    def rows(self) -> pd.DataFrame:
        """The table, read once."""
        return load(self.dataset)

    @cached_property
    def ratios(self) -> Array:
        """ln(truth / anchor) of all rows (n,), NaN where one has no peak."""
        return self._against(self.anchor) * -1.0

    def log_ratios(self, values: Mapping[str, float]) -> Array:
        """Sorted ln(truth / anchor) of a scenario with such features: what is near, and rests."""
        near = self._local.at(self.scaled(values)) if self.centred else 0.0
        return self.rests(values) + near

    def rests(self, values: Mapping[str, float]) -> Array:
        """Sorted ln(truth / anchor) in the cell of a scenario, less what the others expect."""
        rests: Array = _alike(self._rests, self.rows, values, self.cells) * self._scale(values)
        return rests

    def _scale(self, values: Any) -> Any:
        """Scale of errors, by features or of all rows; no less than was drawn."""
        if not self.factor:
            return 1.0
        least = self.rows[self.factor][~np.isnan(self.ratios)].min()
        return np.maximum(values[self.factor], least) - 1.0

    @cached_property
    def _rests(self) -> Array:
        rests: Array = self.ratios / self._scale(self.rows)
        if self.centred:
            rests[np.isfinite(rests)] = self._local.rests
        return rests

    @cached_property
    def _local(self) -> LocalMean:
        known = np.isfinite(self.ratios)
        return LocalMean(self._points[known], self.ratios[known])

    def residuals(self, values: Mapping[str, float]) -> Array:
        """Sorted differences of residuals, truth less anchor, over the peak of the anchor."""
        if "anchor_residual" not in self.rows:
            return np.empty(0)
        change = self.rows["reference_residual"] - self.rows["anchor_residual"]
        parts = (change / self.rows[self.anchor] / self._scale(self.rows)).to_numpy(float)
        known = _alike(parts + 0.0 * self.ratios, self.rows, values, self.cells)
        return known * self._scale(values) if len(known) >= LEAST else known[:0]

    def doubts(self, values: Mapping[str, float]) -> Array:
        """Sorted ln(finest / reference) of such columns, empty where they are few."""
        if not self.doubted:
            return np.empty(0)
        known = _alike(self._against(FINEST), self.rows, values, self.doubted)
        return known if len(known) >= FEWEST else known[:0]

    def cell(self, values: Mapping[str, float]) -> str:
        """The cell of a scenario in words."""
        texts = []
        for name, bounds in self.cells.items():
            place = int(np.searchsorted(bounds, values[name], "right"))
            low, high = (0.0, *bounds)[place], (*bounds, inf)[place]
            between = f"{low:g} to {high:g}" if low and high < inf else ""
            between = between or (f"above {low:g}" if low else f"below {high:g}")
            texts.append(f"{self.words[name]} {between}")
        return ", ".join(texts)

    def collapses(self, anchored: bool) -> float:
        """Chance that a structure collapses whose anchor does, or does not (rule of succession)."""
        truth, anchor = self.rows[TRUTH].to_numpy(), self.rows[self.anchor].to_numpy()
        alike = truth[(np.isinf(anchor) == anchored) & ~np.isnan(anchor) & ~np.isnan(truth)]
        return float((np.isinf(alike).sum() + 1.0) / (len(alike) + 2.0))

    def unknown(self, values: Mapping[str, float]) -> str:
        """Why nothing is known of a scenario with such features; empty where something is."""
        point, known = self.scaled(values), self._points[~np.isnan(self.ratios)]
        low, high = known.min(axis=0), known.max(axis=0)
        if self.factor:
            low[list(self.words).index(self.factor)] = 0.0  # of 1, where nothing is off
        away = np.maximum(low - point, point - high) > MARGIN * (high - low)
        texts = []
        for name in np.array(list(self.words))[away]:
            drawn = self.rows[name][~np.isnan(self.ratios)]
            span = f"drawn were {drawn.min():.3g} to {drawn.max():.3g}"
            texts.append(f"{self.words[name]} {values[name]:.3g}, {span}")
        if texts:
            return f"not measured here: {'; '.join(texts)}"
        spread = np.maximum(self._points.std(axis=0), 1e-9)
        distances = np.linalg.norm((self._points - point) / spread, axis=1)
        nearest = np.argsort(distances)[:NEAREST]
        lost = float(self.rows[TRUTH].isna().iloc[nearest].mean())
        return "the reference itself does not know such a case" if lost > 0.5 else ""

    def _against(self, name: str) -> Array:
        """ln(peak of a model / truth), of magnitudes, of all rows, NaN where one has none."""
        with np.errstate(invalid="ignore", divide="ignore"):
            ratios = np.log(np.abs(self.rows[name].div(self.rows[TRUTH]).to_numpy(float)))
        return np.where(np.isfinite(ratios), ratios, nan)

    @cached_property
    def _points(self) -> Array:
        return self.scaled(self.rows)

    def scaled(self, values: Any) -> Array:
        """Features on their scales, logarithmic where all are positive."""
        columns = []
        for name in self.words:
            scale = np.log if self.rows[name].min() > 0.0 else np.arcsinh
            columns.append(scale(values[name]))
        return np.stack(columns, axis=-1)


def _alike(
    ratios: Array, rows: Any, values: Mapping[str, float], cells: Mapping[str, tuple[float, ...]]
) -> Array:
    """Sorted ratios (n,), where known, of the rows that lie in the cell of a scenario."""
    inside = ~np.isnan(ratios)
    for name, bounds in cells.items():
        here = np.searchsorted(bounds, values[name], "right")
        inside &= np.searchsorted(bounds, rows[name], "right") == here
    return np.sort(ratios[inside])


def ends_of(count: int) -> tuple[int, int]:
    """Places of the ends of an interval among sorted values; the extremes where those are few."""
    low = max(floor((count + 1) * 0.5 * (1.0 - COVERAGE)) - 1, 0)
    return low, count - 1 - low


RATES = ErrorTable(
    kind=ColumnImpact.KIND,
    dataset="rates",
    study="drawn_rates",
    features=rate_features,
    words=RATE_FEATURES,
    cells={STRIKER: (0.6,), DEMAND: (1.0,)},
    anchor=FACTOR_BEAM,
    factor=FACTOR,
)
COLUMNS = ErrorTable(
    kind=ColumnImpact.KIND,
    dataset="columns",
    study="which_model",
    features=features,
    words=FEATURES,
    cells={STRIKER: (0.6, 5.0), DEMAND: (0.5, 1.0)},
    doubted={STRIKER: (0.6,), DEMAND: (0.5, 1.0)},
    centred=True,
    rated=RATES,
)
PULSES = ErrorTable(
    kind=MemberPulse.KIND,
    dataset="pulses",
    study="drawn_pulses",
    features=pulse_features,
    words=PULSE_FEATURES,
    cells={LOADED: (0.5,)},
    grows=0.25,
)
FRAMES = ErrorTable(
    kind=FrameImpact.KIND,
    dataset="frames",
    study="drawn_frames",
    features=frame_features,
    words=FRAME_FEATURES,
    cells={STRIKER: (0.6, 5.0)},
)
OF_KINDS = {table.kind: table for table in (COLUMNS, PULSES, FRAMES)}
TABLES = {table.dataset: table for table in (*OF_KINDS.values(), RATES)}


def table_of(scenario: Any) -> ErrorTable | None:
    """The table of a scenario's kind; None where errors were not measured."""
    return OF_KINDS.get(scenario.KIND)
