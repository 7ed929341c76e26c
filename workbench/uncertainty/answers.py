"""Answers of one model to many scenarios as a table: scalars, outcome, reason of a failure."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from workbench.arrays import Array
from workbench.errors import InputError
from workbench.models.base import Model, on_one_mesh
from workbench.responses import SCALARS, Outcome, outcome_of, scalars_of
from workbench.scenarios import Scenario
from workbench.study.store import read_netcdf, to_netcdf_bytes, write_atomically
from workbench.uncertainty.inputs import UncertainScenario
from workbench.uncertainty.sample_runs import Processes

CHUNK = 256  # scenarios of a task
OUTCOME, FAILURE = "outcome", "failure"


def answers_of(model: Model, scenarios: Iterable[Scenario | InputError]) -> pd.DataFrame:
    """Scalars (SI) of a model's answers, a row a scenario; NaN where there is none.

    `outcome` and `failure`, why it is not ok (else ""), as a single call says them. References
    answer on one mesh.
    """
    alone = on_one_mesh(model)
    rows: list[dict[str, Any]] = []
    for scenario in scenarios:
        if isinstance(scenario, InputError):
            rows.append({OUTCOME: Outcome.INVALID_INPUT.value, FAILURE: str(scenario)})
            continue
        response = alone.simulate(scenario)
        outcome = outcome_of(response)
        numbers = scalars_of(response) if outcome is Outcome.OK else {}
        text = "" if outcome is Outcome.OK else str(response.attrs["message"])
        rows.append({**numbers, OUTCOME: outcome.value, FAILURE: text})
    present = [name for name in SCALARS if any(name in row for row in rows)]
    return pd.DataFrame(rows, columns=[*present, OUTCOME, FAILURE])


@dataclass(frozen=True)
class _Part:
    """A model and the uncertain scenario of which it answers samples.

    Tables are kept in a folder as soon as they are made, and taken from there.
    """

    model: Any
    uncertain: UncertainScenario
    folder: Path | None

    def answer(self, task: tuple[int, Array]) -> pd.DataFrame:
        first, scores = task
        if self.folder is None:
            return answers_of(self.model, self.uncertain.scenarios(scores))
        file = self.folder / f"{first}-{len(scores)}.nc"
        if not file.is_file():
            table = answers_of(self.model, self.uncertain.scenarios(scores))
            write_atomically(file, to_netcdf_bytes(table.rename_axis("sample").to_xarray()))
        return read_netcdf(file).to_dataframe()


def sample_answers(
    model: Any,
    uncertain: UncertainScenario,
    scores: Array,
    jobs: int = 1,
    folder: Path | None = None,
) -> pd.DataFrame:
    """Answers of a model at independent normal scores (samples, inputs), with the inputs first.

    A `folder` keeps what is finished: asked again, an interrupted run goes on from there.
    """
    parts = [(k, scores[k : k + CHUNK]) for k in range(0, len(scores), CHUNK)]
    with Processes(jobs) as run:
        tables = run(_Part(model, uncertain, folder).answer, parts)
    whole: pd.DataFrame = pd.concat(tables, ignore_index=True)
    answers = whole[[*(name for name in SCALARS if name in whole), OUTCOME, FAILURE]]
    values = {".".join(map(str, path)): column for path, column in uncertain.values(scores).items()}
    inputs = pd.DataFrame(values).infer_objects()
    return pd.concat([inputs, answers], axis=1)
