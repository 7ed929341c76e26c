"""Runs of models by sample: tables of answers, and those that a fragility curve rests on."""

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from math import exp, isfinite, log
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import t as student

from workbench.base.arrays import Array, Indices
from workbench.base.errors import InputError
from workbench.base.fields import Number
from workbench.extras.uncertainty.critical_velocity import (
    BEYOND,
    CLOSE,
    COARSE,
    STRIDE,
    Asked,
    DisplacementLimit,
    Ratio,
    Root,
    critical_velocity,
    in_step,
    ratio_to_reference,
    search,
)
from workbench.extras.uncertainty.inputs import UncertainScenario
from workbench.models.base import LONGER, on_one_mesh
from workbench.models.batch import OUTCOME
from workbench.models.references.refine import REFINEMENT
from workbench.responses import COVERAGE, PEAK, Outcome, outcome_of
from workbench.responses.uncertainty import uncertainty_of
from workbench.scenarios.column import DURATION
from workbench.scenarios.varied import Path_, Varied
from workbench.study.batches import Run, answers_by, answers_of

MESH_LEVELS = 6  # of the runs on finer meshes
VELOCITY: Path_ = ("striker", "velocity")
RECORD: Path_ = ("time", "duration")
ECCENTRICITY = ("striker", "eccentricity")


class Target(NamedTuple):
    """Half-width that is good enough: in probability, or relative in velocity."""

    probability: float = 0.02
    velocity: float = 0.01


@dataclass(frozen=True)
class Setup:
    """Setup of the question: uncertain scenario, models, limit, ends of the velocities (m/s).

    `samples` in all; `seed`; `references` (None: looks at the band decide, up to `seconds`);
    `meshes`, whether some of them are run on finer meshes too.
    """

    uncertain: UncertainScenario
    reduced: Any
    reference: Any
    limit: DisplacementLimit
    ends: tuple[float, float]
    samples: int = 8192
    seed: int = 1
    references: int | None = None
    seconds: float = 600.0
    target: Target = Target()
    jobs: int = 1
    meshes: bool = True

    def __post_init__(self) -> None:
        """Refuse hits beside the shear centre that no model of these knows."""
        judge = self.reduced if self.reference is None else self.reference
        beside = getattr(getattr(self.uncertain.base, "striker", None), "eccentricity", 0.0)
        asked = beside or ECCENTRICITY in self.uncertain.inputs
        if asked and not getattr(judge, "eccentric", False):
            text = f"is left out by {judge.name}, which would answer the hit through the middle"
            advice = "take shell for the reference (half a minute a run), or leave it out"
            raise InputError(".".join(ECCENTRICITY), beside, text, advice)

    @property
    def has_meshes(self) -> bool:
        """Whether some of the references are run on finer meshes."""
        return self.meshes and hasattr(self.reference, "refinement")

    @property
    def search(self) -> tuple[float, float]:
        """Ln velocities between which critical velocities are searched."""
        return log(self.ends[0] / BEYOND), log(self.ends[1] * BEYOND)


def ratio_at(setup: Setup, task: tuple[Array, float, float]) -> Ratio:
    """The ratio at one sample: its scores, ln critical velocity and slope by the reduced model."""
    scores, log_velocity, slope = task
    scenario = next(setup.uncertain.scenarios(scores))
    reference = Asked(on_one_mesh(setup.reference), scenario)
    return ratio_to_reference(reference, slope, setup.limit, log_velocity, setup.search)


def on_finer_mesh(
    setup: Setup, finer: int, task: tuple[Array, float, Ratio]
) -> tuple[float, float] | None:
    """Shift of one critical velocity by a finer mesh, and the half-width that is left, in ln."""
    scores, log_velocity, ratio = task
    scenario = next(setup.uncertain.scenarios(scores))
    x = log_velocity + ratio.value
    model = setup.reference
    refinement = model.refinement + finer
    rules = {field.name: field.metadata.get("rule", REFINEMENT) for field in fields(model)}
    levels = min(MESH_LEVELS, int(refinement - rules["refinement"].low) + 1)
    fine = replace(model, refinement=refinement, levels=levels)
    if not isfinite(setup.limit.displacement) or not isfinite(ratio.slope):
        asked = Asked(on_one_mesh(fine), scenario)
        root = critical_velocity(asked.peak_at, setup.limit, x, setup.search, COARSE)
        moved = root.log_velocity - x
        return (moved, abs(moved) + COARSE) if isfinite(moved) else None
    struck: Any = scenario
    struck = struck.at_velocity(exp(x))
    response = fine.simulate(struck)
    coarse = Asked(on_one_mesh(model), scenario).peak_at(x)
    if outcome_of(response) is not Outcome.OK or not isfinite(coarse):
        return None
    peak, width = abs(float(response[PEAK])), uncertainty_of(response, PEAK)
    if width is None:
        return None
    return -log(peak / coarse) / ratio.slope, width / peak / ratio.slope


class Finer(NamedTuple):
    """References on a mesh that is `refined` so many times more, a few `among` the first so many.

    `runs`: shift and remaining half-width in ln velocity of each, NaN where it has no answer.
    """

    refined: int = 0
    among: int = 0
    runs: tuple[tuple[float, float], ...] = ()

    @property
    def error(self) -> tuple[float | None, float]:
        """Half-width (None: unknown) and shift in ln velocity from the mesh of the references."""
        parts = [part for part in self.runs if isfinite(part[0])]
        if len(parts) < 2:
            return None, 0.0
        shifts, widths = np.array(parts).T
        spread = student.ppf(0.5 + COVERAGE / 2.0, len(parts) - 1) * shifts.std(ddof=1)
        return float(widths.max() + spread / np.sqrt(len(parts))), float(shifts.mean())


def numbers_at(path: Path_, rule: Number, values: Iterable[Any]) -> Array:
    """Values (rows,) of a key as numbers in SI; texts of a discrete law say their unit."""
    name = ".".join(map(str, path))
    return np.array([rule.check(name, v) if isinstance(v, str) else float(v) for v in values])


@dataclass(frozen=True)
class Sampled:
    """Samples of the inputs, asked together by one model at velocities of their own.

    `varied`, their scenarios; `like`, one of them; `run` and `jobs` of the processes.
    """

    model: Any
    varied: Varied
    like: Any
    run: Run = map
    jobs: int = 1

    @classmethod
    def of(cls, setup: Setup, scores: Array, run: Run) -> "Sampled":
        """Samples of normal scores (samples, inputs), answered by the reduced model."""
        uncertain = setup.uncertain
        return cls(setup.reduced, uncertain.varied(scores), uncertain.base, run, setup.jobs)

    def peaks_at(self, rows: Indices, log_velocity: Array) -> Array:
        """Peaks (rows,) in m of some rows at ln velocities, as `PeaksAt`."""
        return self.peaks({**self._values(rows), VELOCITY: np.exp(log_velocity)})

    def peaks(self, values: dict[Path_, Array] | None = None, longer: int = 0) -> Array:
        """Magnitudes of peaks (rows,) in m: infinite for collapse, NaN without an answer.

        `values` of the inputs by row in place of all samples; a record that ends before its peak is
        made `longer`, as `study.limit.ask` does.
        """
        values = self._values(slice(None)) if values is None else values
        count = len(next(iter(values.values())))
        duration = numbers_at(RECORD, DURATION, values.get(RECORD, [self.like.duration] * count))
        asked = Varied(self.varied.tables, {**values, RECORD: duration})
        table = answers_by(self.run, self.jobs, self.model, asked, self.like)
        peaks = np.full(count, np.nan)
        if PEAK in table:
            peaks = table[PEAK].abs().to_numpy(copy=True)
        peaks[table[OUTCOME] == Outcome.COLLAPSE.value] = np.inf
        undecided = (table[OUTCOME] == Outcome.OK.value).to_numpy() & np.isnan(peaks)
        undecided &= 2.0 * duration <= DURATION.high
        if longer < LONGER and undecided.any():
            again = {path: column[undecided] for path, column in asked.by_key.items()}
            again[RECORD] = 2.0 * duration[undecided]
            peaks[undecided] = self.peaks(again, longer + 1)
        return peaks

    def _values(self, rows: Any) -> dict[Path_, Array]:
        return {path: np.asarray(each)[rows] for path, each in self.varied.by_key.items()}

    def roots(
        self, setup: Setup, starts: Array, stride: float = STRIDE, close: float = CLOSE
    ) -> list[Root]:
        """Critical velocities of all samples; searches start from ln velocities (samples,)."""
        ends = setup.search
        searches = [search(setup.limit, float(x), ends, close, stride) for x in starts]
        return in_step(searches, self.peaks_at)


def sample_answers(
    model: Any, uncertain: UncertainScenario, scores: Array, jobs: int = 1
) -> pd.DataFrame:
    """Answers of a model at independent normal scores (samples, inputs), with the inputs first."""
    varied = uncertain.varied(scores)
    answers = answers_of(model, varied, uncertain.base, jobs)
    values = {".".join(map(str, path)): column for path, column in varied.by_key.items()}
    return pd.concat([pd.DataFrame(values).infer_objects(), answers], axis=1)
