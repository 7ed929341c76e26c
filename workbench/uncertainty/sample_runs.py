"""Runs of models by sample: tables of answers, and those that a fragility curve rests on."""

import json
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from functools import partial
from math import exp, isfinite, log, nan
from multiprocessing import get_context
from typing import Any, NamedTuple

import pandas as pd
from threadpoolctl import threadpool_limits

from workbench.arrays import Array
from workbench.errors import InputError, WorkbenchError
from workbench.evidence.error_model import PEAK
from workbench.models.base import Model, on_one_mesh
from workbench.models.batch import FAILURE, OUTCOME, can_stack, simulate_many
from workbench.responses import SCALARS, Outcome, outcome_of
from workbench.responses.uncertainty import WIDTHS
from workbench.scenarios import Scenario
from workbench.scenarios.varied import Varied
from workbench.uncertainty.critical_velocity import (
    BEYOND,
    COARSE,
    NO_ANSWER,
    Asked,
    Limit,
    Ratio,
    Root,
    critical_velocity,
    grows,
    ratio_to_reference,
)
from workbench.uncertainty.inputs import UncertainScenario

MESH_LEVELS = 6  # of the runs on finer meshes
CHUNK = 256  # scenarios that a process answers at a time


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
    def search(self) -> tuple[float, float]:
        """Ln velocities between which critical velocities are searched."""
        return log(self.ends[0] / BEYOND), log(self.ends[1] * BEYOND)


def roots_of(setup: Setup, scores: Array) -> list[Root]:
    """Critical velocities of some samples; each search starts from the one before."""
    start, roots = log(setup.ends[0] * setup.ends[1]) / 2.0, []
    for scenario in setup.uncertain.scenarios(scores):
        if isinstance(scenario, InputError):
            roots.append(Root(nan, NO_ANSWER, 0))
            continue
        asked = Asked(setup.reduced, scenario)
        root = critical_velocity(asked.peak_at, setup.limit, start, setup.search)
        roots.append(root)
        if isfinite(root.log_velocity):
            start = root.log_velocity
    return roots


def ratio_at(setup: Setup, task: tuple[Array, float]) -> Ratio:
    """The ratio at one sample."""
    scenario = next(setup.uncertain.scenarios(task[0]))
    reference = Asked(on_one_mesh(setup.reference), scenario)
    reduced = Asked(setup.reduced, scenario)
    return ratio_to_reference(reference, reduced, setup.limit, task[1], setup.search)


def grows_at(setup: Setup, task: tuple[Array, float]) -> bool:
    """Whether the peak of one sample by the reduced model grows with the velocity."""
    scenario = next(setup.uncertain.scenarios(task[0]))
    return grows(Asked(setup.reduced, scenario).peak_at, task[1], setup.limit)


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
    peak, width = float(response[PEAK]), json.loads(response.attrs[WIDTHS]).get(PEAK)
    if width is None:
        return None
    return -log(peak / coarse) / ratio.slope, width / peak / ratio.slope


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
        return self.pool.map

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        if self.pool is not None:
            self.pool.shutdown(cancel_futures=True)
        if isinstance(error, BrokenProcessPool):
            text = "a process was stopped from outside; is there memory for this many --jobs?"
            raise WorkbenchError(text) from error


def _one_thread() -> None:
    threadpool_limits(1)


def answers_of(model: Model, varied: Varied, like: Scenario, jobs: int = 1) -> pd.DataFrame:
    """Answers of a model by row, see `simulate_many`, in so many threads or else processes.

    `like`, one of the scenarios.
    """
    if can_stack(model, like):
        return simulate_many(model, varied, jobs)
    parts = [varied[k : k + CHUNK] for k in range(0, len(varied), CHUNK)]
    with Processes(1 if len(parts) == 1 else jobs) as run:
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
