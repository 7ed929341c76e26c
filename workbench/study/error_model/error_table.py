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

from workbench.base.arrays import Array, Flags
from workbench.base.catalogue import load
from workbench.base.errors import OutOfDomainError
from workbench.mechanics.frames.column_estimate import column_like
from workbench.models.base import is_oblique
from workbench.models.domain import shear_demand
from workbench.models.hit_mass import elastic_energy, front_velocity
from workbench.models.resistance.shapes import stages_of
from workbench.models.strain_rate import feels_rate, rate_factor, stronger
from workbench.responses import COVERAGE
from workbench.scenarios import ColumnImpact, FrameImpact, MemberPulse, Striker
from workbench.scenarios.pulse import UNIFORM

DEMAND, YIELDING, STRIKER = "shear_demand", "energy_over_elastic", "striker_over_lumped"
FACTOR, CRUSH, SHAPE, ANGLE = "rate_factor", "front_work", "shape", "angle"
MARGIN = "margin"  # see `error_model.margin_of`
FEATURES = {  # of the error model, and their words
    DEMAND: "V/Vpl of the mechanism",
    YIELDING: "energy of the hit over the elastic one",
    STRIKER: "striker over lumped mass",
    "turned": "energy of the hit over the work of the mechanism per length of the shorter segment",
    "axial_over_squash": "axial load over the squash load",
    "stiffening": "pull of the restraint less the axial load, over the mechanism",
    "front": "velocity over the one from which shear waves yield the webs",
    "shorter_over_length": "shorter segment over the length",
    FACTOR: "factor on the yield stress for the strain rate",
    CRUSH: "work of the front up to the mechanism over the energy of the hit",
    SHAPE: "webs (0), weak axis of an I (1) or round (2)",
}
LOADED, LASTS = "loaded_over_length", "impulse_over_force_and_period"
RISES, STAYS = "rise_over_period", 10.0  # periods that a force lasts which stays
PULSE_FEATURES = {
    LOADED: "loaded length over length",
    DEMAND: FEATURES[DEMAND],
    LASTS: "impulse over largest force and period",
    "force_over_resistance": "largest force over the resistance of the mechanism",
    "direct_shear": "half of a force at a point over Vpl",
    "axial_over_squash": FEATURES["axial_over_squash"],
    "shorter_over_length": FEATURES["shorter_over_length"],
    RISES: "time to the largest force over the period",
}
FRAME_FEATURES = FEATURES | {"members": "members of the frame"}
DIRECTION_FEATURES = FEATURES | {ANGLE: "angle off the web in rad"}
_NO_NUMBERS = ("levels",)  # options that leave the answer as it is


def features(scenario: ColumnImpact) -> dict[str, float]:
    """The numbers that the error of a column may hang on, by the names of `FEATURES`.

    The pull acts at the displacement that the mechanism alone would need, elastic up to the squash
    load, and across the column by the turn of both segments. With a rate law they are those of the
    column that is as many times stronger as its factor says.
    """
    factor = rate_factor(scenario, shear_yields=True) if feels_rate(scenario) else 1.0
    scenario = stronger(scenario, factor) if feels_rate(scenario) else scenario
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
        FACTOR: factor,
        CRUSH: _front_work(striker, resistance) / scenario.input_energy,
        SHAPE: 2.0 if column.is_round else float(column.section != column.section.about("strong")),
    }


def direction_features(scenario: ColumnImpact) -> dict[str, float]:
    """Features of the column hit in its own plane, and the angle, by `DIRECTION_FEATURES`."""
    return {**features(scenario), ANGLE: scenario.striker.angle}


def _front_work(striker: Striker, force: float) -> float:
    """Work (J) of a front until it presses with a `force` (N); 0 of a rigid striker."""
    if not striker.crushes:
        return 0.0
    if striker.crush is None:
        return 0.5 * force**2 / float(striker.stiffness or 1.0)
    strokes, forces = np.array(striker.crush).T
    until = 1 + int(np.argmax(forces >= force)) if (forces >= force).any() else len(forces)
    return float(np.trapezoid(forces[:until], strokes[:until]))


def pulse_features(scenario: MemberPulse) -> dict[str, float]:
    """Numbers of a member under a pulse, without units, by the names of `PULSE_FEATURES`.

    Period and resistance are those of its elastic and its last stage by Biggs. A ramp lasts as long
    as any that was drawn.
    """
    column, pulse, uniform = scenario.column, scenario.pulse, scenario.load == UNIFORM
    elastic, *_, mechanism = stages_of(column, uniform=uniform)
    mass = elastic.load_mass_factor * column.properties.mass_per_length * column.length
    period = 2.0 * pi * sqrt(mass / elastic.stiffness)
    factors, times = np.abs(pulse.factors or (1.0,)), pulse.times or (0.0,)
    force = pulse.peak * float(factors.max()) * scenario.whole
    ramp = pulse.shape == "ramp"
    rises = float(pulse.length or 0.0) if ramp else times[int(factors.argmax())]
    return {
        LOADED: float(uniform),
        DEMAND: max(shear_demand(scenario).values()),
        LASTS: STAYS if ramp else pulse.lasts / period,
        "force_over_resistance": force / mechanism.load,
        "direct_shear": 0.0 if uniform else 0.5 * force / column.properties.shear_resistance,
        "axial_over_squash": column.axial_load / column.properties.squash_load,
        "shorter_over_length": min(column.length_below, column.length_above) / column.length,
        RISES: rises / period,
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
BEAM = "fiber-reissner"  # a second reference, whose webs do not yield in shear
BEYOND_DRAW = 0.05  # share of the range of a feature, by which a scenario may lie outside of it
NEAREST = 20  # neighbours of a point
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
        return self._at(self._standard(point))

    def _at(self, place: Array) -> float:
        away = self._places - place
        distances = np.sqrt(np.einsum("ij,ij->i", away, away))
        distances[distances == 0.0] = np.inf
        count = min(NEAREST, len(distances) - 1)
        near = np.argpartition(distances, count - 1)[:count]  # a sort of all takes most of the time
        weights = 1.0 - (distances[near] / distances[near].max()) ** 2 + 1e-9
        line = float(self._with_one(place) @ self._line)
        return line + float(weights @ self._off[near] / weights.sum())

    @cached_property
    def rests(self) -> Array:
        """The values less what the others make expect of them (n,)."""
        rests: Array = self.values - np.array([self._at(place) for place in self._places])
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

    Arguments: `dataset` of the catalogue, a row for every scenario that the `studies` draw;
    `features` of a scenario by name, as its columns have them, with their `words`; `cells`, bounds
    of features between cells, the weightiest first: what leaves too few rows bounds nothing;
    `doubted`, those between which the finest reference judged the reference (empty: it did not);
    whether intervals are `centred` by what is near; names of `anchor` and `reference`.
    """

    kind: str
    dataset: str
    studies: tuple[str, ...]
    features: Callable[[Any], dict[str, float]]
    words: Mapping[str, str]
    cells: Mapping[str, tuple[float, ...]]
    doubted: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    centred: bool = False
    anchor: str = ANCHOR
    reference: str = REFERENCE

    @cached_property
    def rows(self) -> pd.DataFrame:
        """The table, read once; twice a row where two references differ about collapse."""
        rows = load(self.dataset)
        if BEAM not in rows:
            return rows
        beam, truth = rows[BEAM], rows[TRUTH]
        apart = beam.notna() & truth.notna() & (np.isinf(beam) != np.isinf(truth))
        second = rows[apart].assign(**{TRUTH: beam[apart], "reference_residual": nan})
        both: pd.DataFrame = pd.concat([rows, second], ignore_index=True)
        return both

    @cached_property
    def ratios(self) -> Array:
        """ln(truth / anchor) of all rows (n,), infinite where one collapses, NaN without a peak."""
        return self._against(self.anchor) * -1.0

    def log_ratios(self, values: Mapping[str, float]) -> Array:
        """Sorted ln(truth / anchor) of a scenario with such features: what is near, and rests."""
        near = self._local.at(self.scaled(values)) if self.centred else 0.0
        return self.rests(values) + near

    def rests(self, values: Mapping[str, float]) -> Array:
        """Sorted ln(truth / anchor) in the cell of a scenario, less what the others expect."""
        return np.sort(self._rests[self._alike(self._judged, values)])

    @cached_property
    def _rests(self) -> Array:
        rests = self.ratios.copy()
        if self.centred:
            rests[self._known] = self._local.rests
        return rests

    @cached_property
    def _judged(self) -> Flags:
        """Rows where the anchor stands, whatever the truth does (n,)."""
        judged: Flags = self.ratios > -inf  # so that it is not NaN
        return judged

    @cached_property
    def _known(self) -> Flags:
        """Rows where truth and anchor stand (n,)."""
        known: Flags = np.isfinite(self.ratios)
        return known

    @cached_property
    def _local(self) -> LocalMean:
        return LocalMean(self._points[self._known], self.ratios[self._known])

    def residuals(self, values: Mapping[str, float]) -> Array:
        """Sorted differences of residuals, truth less anchor, over the peak of the anchor."""
        if "anchor_residual" not in self.rows:
            return np.empty(0)
        change = self.rows["reference_residual"] - self.rows["anchor_residual"]
        parts = (change / self.rows[self.anchor]).to_numpy(float)
        known = np.sort(parts[self._alike(self._known, values) & ~np.isnan(parts)])
        return known if len(known) >= LEAST else known[:0]

    def doubts(self, values: Mapping[str, float]) -> Array:
        """Sorted ln(finest / reference) of such columns, empty where they are few."""
        if not self.doubted:
            return np.empty(0)
        ratios = self._against(FINEST)
        inside = self._alike(np.isfinite(ratios), values, self.doubted, FEWEST)
        return np.sort(ratios[inside])

    def _alike(
        self,
        known: Flags,
        values: Mapping[str, float],
        cells: Mapping[str, tuple[float, ...]] | None = None,
        least: int = 0,
    ) -> Flags:
        """Rows (n,) among those `known` that lie in the cell of a scenario.

        Bounds that leave fewer than `LEAST` are dropped, the last ones first, and close to a
        collapse all but that; with `least` none is, and no rows are left where they are fewer.
        """
        for name, bounds in (self.cells if cells is None else cells).items():
            if values.get(MARGIN) and name != MARGIN:
                break
            here = np.searchsorted(bounds, values.get(name, 0.0), "right")
            inside = known & (np.searchsorted(bounds, self.rows[name], "right") == here)
            if not least and inside.sum() < LEAST:
                break
            known = inside
        return known if known.sum() >= least else known & False

    def knows(self, margin: float) -> bool:
        """Whether enough anchors that stand were drawn as close to a collapse."""
        near = {MARGIN: self.cells[MARGIN]}
        return bool(self._alike(self._judged, {MARGIN: margin}, near, LEAST).any())

    def cell(self, values: Mapping[str, float]) -> str:
        """The cell of a scenario in words."""
        texts = []
        for name, bounds in self.cells.items():
            value = values.get(name, 0.0)
            if name == MARGIN and not value:
                continue
            if values.get(MARGIN) and name != MARGIN:
                break
            place = int(np.searchsorted(bounds, value, "right"))
            if name in UNUSUAL:
                texts += [UNUSUAL[name][place - 1]] if place else []
                continue
            low, high = (0.0, *bounds)[place], (*bounds, inf)[place]
            between = f"{low:g} to {high:g}" if low and high < inf else ""
            between = between or (f"above {low:g}" if low else f"below {high:g}")
            texts.append(f"{self.words.get(name, NEARNESS)} {between}")
        return ", ".join(texts)

    def collapses(self, anchored: bool, values: Mapping[str, float]) -> float:
        """Chance that a structure collapses whose anchor does, or does not (rule of succession).

        Of structures with a like `MARGIN`, if it has one; of all that are far from a collapse else.
        """
        truth, anchor = self.rows[TRUTH].to_numpy(), self.rows[self.anchor].to_numpy()
        known = (np.isinf(anchor) == anchored) & ~np.isnan(anchor) & ~np.isnan(truth)
        near = {MARGIN: self.cells[MARGIN]}
        alike = truth[self._alike(known, values, near)]
        return float((np.isinf(alike).sum() + 1.0) / (len(alike) + 2.0))

    def unknown(self, values: Mapping[str, float]) -> str:
        """Why nothing is known of a scenario with such features; empty where something is."""
        point, known = self.scaled(values), self._points[self._known]
        low, high = known.min(axis=0), known.max(axis=0)
        away = np.maximum(low - point, point - high) > BEYOND_DRAW * (high - low)
        texts = []
        for name in np.array(list(self.words))[away]:
            drawn = self.rows[name][self._known]
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
            ratios: Array = np.log(np.abs(self.rows[name].div(self.rows[TRUTH]).to_numpy(float)))
        return ratios

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


def ends_of(count: int) -> tuple[int, int]:
    """Places of the ends of an interval among sorted values; the extremes where those are few."""
    low = max(floor((count + 1) * 0.5 * (1.0 - COVERAGE)) - 1, 0)
    return low, count - 1 - low


UNUSUAL = {  # features that most scenarios lack, and what their cells are called
    FACTOR: ("with a strain rate",),
    CRUSH: ("hit by a front that crushes",),
    SHAPE: ("bent about the weak axis", "round"),
}
NEARNESS = "velocity over that of a collapse of the anchor"
FAR = 0.8  # largest velocity over that of a collapse that is not close to it
_NEAR = {MARGIN: (FAR, 0.9, 1.0)}
COLUMNS = ErrorTable(
    kind=ColumnImpact.KIND,
    dataset="columns",
    studies=("which_model", "drawn_columns"),
    features=features,
    words=FEATURES,
    cells={
        **_NEAR,
        **{CRUSH: (1e-6,), SHAPE: (0.5, 1.5), FACTOR: (1.02,)},
        **{STRIKER: (0.6, 5.0), DEMAND: (0.5, 1.0)},
    },
    doubted={STRIKER: (0.6,), DEMAND: (0.5, 1.0)},
    centred=True,
)
DIRECTIONS = ErrorTable(
    kind=ColumnImpact.KIND,
    dataset="directions",
    studies=("drawn_directions",),
    features=direction_features,
    words=DIRECTION_FEATURES,
    cells={**_NEAR, STRIKER: (0.6, 5.0)},
    anchor="superelement-space",
    reference="fiber-space",
)
PULSES = ErrorTable(
    kind=MemberPulse.KIND,
    dataset="pulses",
    studies=("drawn_pulses",),
    features=pulse_features,
    words=PULSE_FEATURES,
    cells={**_NEAR, LOADED: (0.5,)},
)
FRAMES = ErrorTable(
    kind=FrameImpact.KIND,
    dataset="frames",
    studies=("drawn_frames",),
    features=frame_features,
    words=FRAME_FEATURES,
    cells={**_NEAR, STRIKER: (0.6, 5.0)},
)
OF_KINDS = {table.kind: table for table in (COLUMNS, PULSES, FRAMES)}
TABLES = {table.dataset: table for table in (*OF_KINDS.values(), DIRECTIONS)}


def table_of(scenario: Any) -> ErrorTable | None:
    """The table of a scenario's kind, and of its direction; None where errors were not measured."""
    if isinstance(scenario, ColumnImpact) and is_oblique(scenario):
        return DIRECTIONS
    return OF_KINDS.get(scenario.KIND)
