"""Runs of models by sample: tables of answers, and those that a fragility curve rests on."""

import json
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from math import exp, isfinite, log, nan
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
from threadpoolctl import threadpool_limits

from workbench.arrays import Array
from workbench.errors import InputError
from workbench.evidence.error_model import PEAK
from workbench.models.base import Model, on_one_mesh
from workbench.models.batch import FAILURE, OUTCOME, can_stack, simulate_many
from workbench.responses import SCALARS, Outcome, outcome_of
from workbench.responses.uncertainty import WIDTHS
from workbench.scenarios import Scenario
from workbench.scenarios.varied import Varied
from workbench.study.store import read_netcdf, to_netcdf_bytes, write_atomically
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
CHUNK, STACK, PARTS = 256, 65_536, 16  # scenarios of a part; of one answered in stacks; parts


class Target(NamedTuple):
    """Half-width that is good enough: in probability, or relative in velocity."""

    probability: float = 0.02
    velocity: float = 0.01


@dataclass(frozen=True)
class Setup:
    """What is asked: uncertain scenario, models, limit, ends of the range of velocities (m/s).

    `samples` in all; `seed`; `references` (None: looks at the band decide, up to `seconds`).
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


Run = Callable[[Callable[[Any], Any], Sequence[Any]], list[Any]]


class Processes:
    """Run a function over tasks in processes of one thread each; in this one if `jobs` is 1."""

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
        self.pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Run:
        if self.jobs == 1:
            return lambda function, tasks: [function(task) for task in tasks]
        context = get_context("spawn")
        self.pool = ProcessPoolExecutor(self.jobs, context, initializer=_one_thread)
        pool = self.pool
        return lambda function, tasks: list(pool.map(function, tasks))

    def __exit__(self, *_: object) -> None:
        if self.pool is not None:
            self.pool.shutdown(cancel_futures=True)


def _one_thread() -> None:
    threadpool_limits(1)


@dataclass(frozen=True)
class _Part:
    """A model that answers parts with so many threads.

    Tables are kept in a folder as soon as they are made, and taken from there.
    """

    model: Any
    threads: int
    folder: Path | None

    def answer(self, task: tuple[int, Varied]) -> pd.DataFrame:
        first, varied = task
        if self.folder is None:
            return simulate_many(self.model, varied, self.threads)
        file = self.folder / f"{first}-{len(varied)}.nc"
        if not file.is_file():
            table = simulate_many(self.model, varied, self.threads)
            write_atomically(file, to_netcdf_bytes(table.rename_axis("sample").to_xarray()))
        return read_netcdf(file).to_dataframe()


def answers_of(
    model: Model, varied: Varied, like: Scenario, jobs: int = 1, folder: Path | None = None
) -> pd.DataFrame:
    """Answers of a model by row, see `simulate_many`, in so many threads or else processes.

    `like`, one of the scenarios. A `folder` keeps what is finished: asked again, an interrupted run
    goes on from there.
    """
    stacked = can_stack(model, like)
    size = min(max(len(varied) // PARTS, CHUNK), STACK) if stacked else CHUNK
    parts = [(k, varied[k : k + size]) for k in range(0, len(varied), size)]
    with Processes(1 if stacked or len(parts) == 1 else jobs) as run:
        tables = run(_Part(model, jobs if stacked else 1, folder).answer, parts)
    whole: pd.DataFrame = pd.concat(tables, ignore_index=True)
    return whole[[*(name for name in SCALARS if name in whole), OUTCOME, FAILURE]]


def sample_answers(
    model: Any,
    uncertain: UncertainScenario,
    scores: Array,
    jobs: int = 1,
    folder: Path | None = None,
) -> pd.DataFrame:
    """Answers of a model at independent normal scores (samples, inputs), with the inputs first."""
    varied = uncertain.varied(scores)
    answers = answers_of(model, varied, uncertain.base, jobs, folder)
    values = {".".join(map(str, path)): column for path, column in varied.by_key.items()}
    return pd.concat([pd.DataFrame(values).infer_objects(), answers], axis=1)
