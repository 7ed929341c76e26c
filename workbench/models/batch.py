"""Answers of one model to many scenarios as a table, of stacks in compiled loops.

A model with `stackable(scenario)`, `refused(stack)` and `answer_stack(stack, refused)` answers a
stack of struck columns at once, with the numbers of single calls: same formulas, same integrator.
Rows that it cannot answer that way are asked one by one, so that refusals and failures have the
words of a single call.

A model of structures with `numbers(scenario)`, the scalars of an answer alone (None: ask for the
whole one), answers rows one by one, but several at a time: its compiled steps give up the lock of
Python.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from workbench.base.arrays import Array, Indices
from workbench.base.errors import CollapseError, InputError, message_of
from workbench.mechanics.frames.elastic import linear_algebra
from workbench.models.base import Model, on_one_mesh, striker_findings
from workbench.models.domain import ECCENTRIC
from workbench.models.strain_rate import with_strain_rate
from workbench.responses import SCALARS, Outcome, failure_message, outcome_of, scalars_of
from workbench.scenarios import Scenario
from workbench.scenarios.varied import stacks, take

OUTCOME, FAILURE = "outcome", "failure"
CHUNK = 4096  # rows of a stack that a thread answers together, others that wait for threads
SURVIVES, UNKNOWN, COLLAPSES, LOST = range(4)  # codes of rows; of the last two models say how


class BatchAnswers(NamedTuple):
    """Answers to a stack: `codes` (n,), `scalars` (n,) by name, NaN where there is none.

    And how row i has collapsed, `collapse(i)`. Rows of code UNKNOWN are asked one by one.
    """

    codes: Indices
    scalars: dict[str, Array]
    collapse: Callable[[int], CollapseError]

    @classmethod
    def of(
        cls, codes: Indices, scalars: dict[str, Array], collapse: Callable[[int], CollapseError]
    ) -> "BatchAnswers":
        """Answers by numbers that count only where the structure survives."""
        known = {name: np.where(codes == SURVIVES, each, np.nan) for name, each in scalars.items()}
        return cls(codes, known, collapse)


def can_stack(model: Any, scenario: Scenario) -> bool:
    """Whether a model answers scenarios like this one in stacks."""
    stackable = getattr(model, "stackable", None)
    return stackable is not None and bool(stackable(scenario))


def simulate_many(
    model: Model, scenarios: Sequence[Scenario], threads: int | None = None
) -> pd.DataFrame:
    """Answer many scenarios with one model: a table, see `workbench.api.sweeps.simulate_many`.

    A `Varied` builds its scenarios only where a row is asked alone.
    """
    alone, count = on_one_mesh(model), len(scenarios)
    table: dict[str, Array] = {}
    outcomes, failures = np.full(count, Outcome.OK.value, object), np.full(count, "", object)

    def stacked(part: tuple[Indices, Any]) -> tuple[Indices, BatchAnswers]:
        rows, stack = part
        refused = np.broadcast_to(alone.refused(stack), len(rows))  # type: ignore[attr-defined]
        solved = with_strain_rate(alone, stack)[0]
        return rows, alone.answer_stack(solved, refused)  # type: ignore[attr-defined]

    left: list[Indices] = []
    parts, at_once = _parts(alone, scenarios, left), hasattr(alone, "numbers")
    with linear_algebra().limit(limits=1), _pool(threads or _cores()) as pool:
        for rows, answers in pool.map(stacked, parts):
            left.append(rows[answers.codes == UNKNOWN])
            for name, values in answers.scalars.items():
                table.setdefault(name, np.full(count, np.nan))[rows] = values
            for i in np.flatnonzero(answers.codes >= COLLAPSES):
                outcomes[rows[i]] = Outcome.COLLAPSE.value
                error = answers.collapse(int(i))
                failures[rows[i]] = failure_message(Outcome.COLLAPSE, str(error))
        rows = np.concatenate([*left, np.empty(0, np.int64)])
        ask = partial(_single, alone, scenarios)
        for k in range(0, len(rows), CHUNK):
            some = rows[k : k + CHUNK]
            singles = pool.map(ask, some) if at_once else map(ask, some)
            for row, (outcome, failure, scalars) in zip(some, singles, strict=True):
                outcomes[row], failures[row] = outcome.value, failure
                for name, value in scalars.items():
                    table.setdefault(name, np.full(count, np.nan))[row] = value
    present = [name for name in SCALARS if name in table and not np.isnan(table[name]).all()]
    columns: dict[str, Any] = {name: table[name] for name in present}
    return pd.DataFrame({**columns, OUTCOME: outcomes, FAILURE: failures})


def admitted(model: Any, scenario: Any) -> Any:
    """The scenario that a model solves in place of an impact; None if it refuses or says more."""
    solved, _, left_out = with_strain_rate(model, scenario)
    findings = *striker_findings(model, scenario), *model.domain(scenario), *left_out
    whole = any(each.refusal or each.subject == ECCENTRIC for each in findings)
    return None if whole else solved


@contextmanager
def _pool(threads: int) -> Iterator[ThreadPoolExecutor]:
    """So many threads; what waits for them is dropped where an error or an interrupt ends it."""
    pool = ThreadPoolExecutor(threads)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def _single(
    model: Model, scenarios: Sequence[Scenario], row: int
) -> tuple[Outcome, str, dict[str, float]]:
    """How a model answers a row that is asked alone: outcome, why it fails, scalars.

    One with `numbers` need not make the whole response where these are all there is to know.
    """
    try:
        scenario = scenarios[int(row)]
        scalars = model.numbers(scenario) if hasattr(model, "numbers") else None
        if scalars is not None and all(map(isfinite, scalars.values())):
            return Outcome.OK, "", scalars
        response = model.simulate(scenario)
    except InputError as error:
        return Outcome.INVALID_INPUT, str(error), {}
    except CollapseError as error:
        return Outcome.COLLAPSE, failure_message(Outcome.COLLAPSE, str(error)), {}
    except Exception as error:  # a defect of a model costs its row, not the table
        text = f"{model.name} raised {message_of(error)}"
        return Outcome.CRASHED, failure_message(Outcome.CRASHED, text), {}
    outcome = outcome_of(response)
    if outcome is Outcome.OK:
        return outcome, "", scalars_of(response)
    return outcome, str(response.attrs["message"]), {}


def _parts(
    model: Any, scenarios: Sequence[Scenario], left: list[Indices]
) -> Iterator[tuple[Indices, Any]]:
    """Chunks of stacks with their rows; rows that have none are put where they are `left`."""
    if not hasattr(model, "stackable"):
        left.append(np.arange(len(scenarios)))
        return
    for rows, stack in stacks(scenarios):
        refused = stack is None or any(f.refusal for f in striker_findings(model, stack))
        if refused or not model.stackable(stack):
            left.append(rows)
            continue
        for k in range(0, len(rows), CHUNK):
            yield rows[k : k + CHUNK], take(stack, slice(k, k + CHUNK))


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
