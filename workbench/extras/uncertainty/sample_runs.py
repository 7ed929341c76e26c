"""Runs of models by sample: tables of answers, and those that a fragility curve rests on."""

import json
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from functools import partial
from math import exp, isfinite, log
from multiprocessing import get_context
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import t as student
from threadpoolctl import threadpool_limits

from workbench.base.arrays import Array, Indices
from workbench.base.errors import WorkbenchError
from workbench.base.fields import Number
from workbench.extras.uncertainty.critical_velocity import (
    BEYOND,
    CLOSE,
    COARSE,
    STRIDE,
    Asked,
    Limit,
    Ratio,
    Root,
    critical_velocity,
    in_step,
    ratio_to_reference,
    search,
)
from workbench.extras.uncertainty.fragility_curve import LEVEL
from workbench.extras.uncertainty.inputs import UncertainScenario
from workbench.models.base import LONGER, Model, on_one_mesh
from workbench.models.batch import FAILURE, OUTCOME, can_stack, simulate_many
from workbench.responses import SCALARS, Outcome, outcome_of
from workbench.responses.uncertainty import WIDTHS
from workbench.scenarios import Scenario
from workbench.scenarios.column import DURATION
from workbench.scenarios.varied import Path_, Varied
from workbench.study.error_model.error_model import PEAK
from workbench.study.executors import deaf_to_interrupts, end_with_parent

MESH_LEVELS = 6  # of the runs on finer meshes
CHUNK, PARTS = 256, 8  # scenarios that a process answers at a time, at most; times that it is asked
VELOCITY: Path_ = ("striker", "velocity")
RECORD: Path_ = ("time", "duration")


class Target(NamedTuple):
    """Half-width that is good enough: in probability, or relative in velocity."""

    probability: float = 0.02
    velocity: float = 0.01


@dataclass(frozen=True)
class Setup:
    """What is asked: uncertain scenario, models, limit, ends of the range of velocities (m/s).

    `samples` in all; `seed`; `references` (None: looks at the band decide, up to `seconds`);
    `meshes`, whether some of them are run on finer meshes too.
    """

    uncertain: UncertainScenario
    reduced: Any
    reference: Any
    limit: Limit
    ends: tuple[float, float]
    samples: int = 8192
    seed: int = 1
    references: int | None = None
    seconds: float = 600.0
    target: Target = Target()
    jobs: int = 1
    meshes: bool = True

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
    fine = replace(model, refinement=model.refinement + finer, levels=MESH_LEVELS)
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
    peak, width = abs(float(response[PEAK])), json.loads(response.attrs[WIDTHS]).get(PEAK)
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
        spread = student.ppf(0.5 + LEVEL / 2.0, len(parts) - 1) * shifts.std(ddof=1)
        return float(widths.max() + spread / np.sqrt(len(parts))), float(shifts.mean())


Run = Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[Any]]


class Processes:
    """Run a function over tasks in processes of one thread each; in this one if `jobs` is 1.

    Results come in the order of the tasks. With `threads`, in those of this process instead. Raises
    `WorkbenchError` if a process is stopped from outside.
    """

    def __init__(self, jobs: int, threads: bool = False) -> None:
        self.jobs, self.threads = jobs, threads
        self.pool: Executor | None = None

    def __enter__(self) -> Run:
        if self.jobs == 1:
            return map
        if self.threads:
            self.pool = ThreadPoolExecutor(self.jobs)
        else:
            context = get_context("spawn")
            self.pool = ProcessPoolExecutor(self.jobs, context, initializer=_one_thread)
        return self._map

    def _map(self, function: Callable[[Any], Any], tasks: Iterable[Any]) -> Iterator[Any]:
        assert self.pool is not None
        with deaf_to_interrupts():  # processes start with their first task
            return self.pool.map(function, tasks)

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        if self.pool is not None:
            if error is not None:  # such as an interrupt: nobody waits for what is at work
                for process in dict(getattr(self.pool, "_processes", None) or {}).values():
                    process.kill()
            self.pool.shutdown(cancel_futures=True)
        if isinstance(error, BrokenProcessPool):
            text = "a process was stopped from outside; is there memory for this many --jobs?"
            raise WorkbenchError(text) from error


def _one_thread() -> None:
    end_with_parent()
    threadpool_limits(1)


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
        """Those of normal scores (samples, inputs), asked by the reduced model."""
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


def answers_of(model: Model, varied: Varied, like: Scenario, jobs: int = 1) -> pd.DataFrame:
    """Answers of a model by row, see `simulate_many`, in so many threads or else processes.

    `like`, one of the scenarios.
    """
    with Processes(1 if len(varied) <= CHUNK else jobs) as run:
        return answers_by(run, jobs, model, varied, like)


def answers_by(run: Run, jobs: int, model: Model, varied: Varied, like: Scenario) -> pd.DataFrame:
    """As `answers_of`, by the processes of a `run`; they only start where answers do not stack.

    A few rows of superelements, which march beside each other, are not worth processes.
    """
    if can_stack(model, like) or (run is map and hasattr(model, "numbers")):
        return simulate_many(model, varied, jobs)
    size = min(CHUNK, max(1, len(varied) // (PARTS * jobs)))
    parts = [varied[k : k + size] for k in range(0, len(varied), size)]
    tables = run(partial(simulate_many, model, threads=1), parts)
    whole: pd.DataFrame = pd.concat(tables, ignore_index=True)
    return whole[[*(name for name in SCALARS if name in whole), OUTCOME, FAILURE]]


def sample_answers(
    model: Any, uncertain: UncertainScenario, scores: Array, jobs: int = 1
) -> pd.DataFrame:
    """Answers of a model at independent normal scores (samples, inputs), with the inputs first."""
    varied = uncertain.varied(scores)
    answers = answers_of(model, varied, uncertain.base, jobs)
    values = {".".join(map(str, path)): column for path, column in varied.by_key.items()}
    return pd.concat([pd.DataFrame(values).infer_objects(), answers], axis=1)
