"""Answers of many frames at a time: those of single calls, for any number of threads."""

from __future__ import annotations

import tomllib
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from workbench.base.datafiles import data_directory
from workbench.base.errors import OutOfDomainError, SolverError
from workbench.extras.frame_models.hinged_frames import Giberson
from workbench.models import superelements
from workbench.models.base import Model
from workbench.models.batch import FAILURE, OUTCOME, simulate_many
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.responses import outcome_of, scalars_of
from workbench.scenarios import FrameImpact, load_scenario, to_toml
from workbench.scenarios.varied import Varied
from workbench.study.batches import answers_of

THESIS = data_directory() / "published" / "heng2017_frame.toml"
ONE_BAR = RigidSuperelement(elements=1, rotational_stiffness=6.0, accuracy=0.01)
MODELS = {
    "one bar per member": ONE_BAR,
    "beams": FlexibleSuperelement(elements=2, accuracy=0.05),
    "given steps": RigidSuperelement(elements=1, time_step=5e-4),
    "bars that flow": replace(ONE_BAR, rate_level="bars"),
}


def drawn(count: int, seed: int = 1) -> Varied:
    """Frames of the thesis under dead loads: some collapse, one buckles before, one is no frame."""
    impact = load_scenario(THESIS)
    assert isinstance(impact, FrameImpact)
    tables = tomllib.loads(to_toml(replace(impact, duration=0.06)))
    tables["load"] = [{"node": node, "y": -1e3} for node in ("A2", "B2")]
    rng = np.random.default_rng(seed)
    loads = rng.uniform(-2e4, 0.0, count)
    loads[0], rates = -5e7, np.resize(np.array(["none", "S355"], object), count)
    nodes = np.full(count, "A2", object)
    nodes[1] = "nowhere"
    return Varied(
        tables,
        {
            ("striker", "velocity"): rng.uniform(10.0, 130.0, count),
            ("striker", "mass"): rng.uniform(500.0, 3000.0, count),
            ("steel", "yield_stress"): rng.uniform(235e6, 460e6, count),
            ("steel", "rate"): rates,
            ("load", 0, "y"): loads,
            ("load", 1, "node"): nodes,
        },
    )


def singles(model: Model, frames: Varied) -> pd.DataFrame:
    """What single calls say of the rows that can be built."""
    rows = []
    for row in range(len(frames)):
        if row != 1:
            response = model.simulate(frames[row])
            scalars = scalars_of(response) if outcome_of(response) == "ok" else {}
            words = {OUTCOME: outcome_of(response).value, FAILURE: response.attrs["message"]}
            rows.append({**scalars, **words})
    return pd.DataFrame(rows)


@pytest.mark.thorough
@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_frames_are_answered_as_by_single_calls(model: Model) -> None:
    frames = drawn(16)
    table, alone = simulate_many(model, frames), singles(model, frames)
    assert table[OUTCOME][1] == "invalid-input"
    assert "nowhere" in table[FAILURE][1]
    table = table.drop(1).reset_index(drop=True)
    assert set(table[OUTCOME]) == {"ok", "collapse", "out-of-domain"}
    assert table[[OUTCOME, FAILURE]].equals(alone[[OUTCOME, FAILURE]])
    assert set(table.columns) == set(alone.columns)
    for name in set(table.columns) - {OUTCOME, FAILURE}:
        np.testing.assert_allclose(table[name], alone[name], rtol=1e-9, atol=0.0, err_msg=name)


def test_numbers_of_frames_do_not_depend_on_threads_or_neighbours() -> None:
    frames = drawn(24, seed=2)
    one, many = (simulate_many(ONE_BAR, frames, threads) for threads in (1, 5))
    pd.testing.assert_frame_equal(one, many, check_exact=True)
    jobs = answers_of(ONE_BAR, frames, frames[0], jobs=2)
    pd.testing.assert_frame_equal(one, jobs, check_exact=True)
    part = simulate_many(ONE_BAR, [frames[row] for row in range(8, 16)])
    expected = one.iloc[8:16].reset_index(drop=True)
    pd.testing.assert_frame_equal(part, expected[part.columns], check_exact=True)


def test_many_strikers_hit_one_kept_frame_at_a_time() -> None:
    impact = load_scenario(THESIS)
    assert isinstance(impact, FrameImpact)
    hits = [replace(impact, duration=0.04).at_velocity(v) for v in np.linspace(20.0, 60.0, 12)]
    table = simulate_many(ONE_BAR, hits, 4)
    expected = [float(ONE_BAR.simulate(hit)["peak_displacement"]) for hit in hits]
    assert table["peak_displacement"].tolist() == expected
    assert (np.diff(table["peak_displacement"]) > 0.0).all()


def test_models_without_compiled_marches_answer_row_by_row() -> None:
    impact = load_scenario(THESIS)
    assert isinstance(impact, FrameImpact)
    hit = replace(impact, duration=0.01)
    table = simulate_many(Giberson(), [hit], 2)
    expected = scalars_of(Giberson().simulate(hit))
    assert table.drop(columns=[OUTCOME, FAILURE]).iloc[0].to_dict() == expected


@pytest.mark.parametrize("error", [SolverError("a step", 1.0, "all"), OutOfDomainError("crumpled")])
def test_what_fails_is_asked_again_for_its_words(error: Exception, monkeypatch) -> None:
    def fails(*_: object) -> None:
        raise error

    monkeypatch.setattr(superelements, "measure_impact", fails)
    monkeypatch.setattr(superelements, "run_impact", fails)
    impact = load_scenario(THESIS)
    table, alone = simulate_many(ONE_BAR, [impact]), ONE_BAR.simulate(impact)
    assert table[OUTCOME][0] == outcome_of(alone).value != "ok"
    assert table[FAILURE][0] == alone.attrs["message"]
    assert len(table.columns) == 2


def test_an_interrupt_drops_the_rows_that_wait() -> None:
    answered = []

    class Interrupted(RigidSuperelement):
        def numbers(self, scenario: FrameImpact) -> dict[str, float]:
            answered.append(scenario)
            if len(answered) == 3:
                raise KeyboardInterrupt
            return {}

    impact = load_scenario(THESIS)
    with pytest.raises(KeyboardInterrupt):
        simulate_many(Interrupted(), [impact] * 50_000, 1)
    assert len(answered) < 40_000
