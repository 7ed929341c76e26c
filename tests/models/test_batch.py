"""Answers of stacks: those of single calls, for any number of threads, with the same words."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.stats import qmc
from toy_models import Spring

from workbench.base.errors import InputError
from workbench.models.base import Model
from workbench.models.batch import FAILURE, OUTCOME, can_stack, simulate_many
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.single_dof import SingleDof
from workbench.models.soft_impact import SoftImpact
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.responses import outcome_of, scalars_of
from workbench.scenarios.varied import Varied, stacks, take

BASE = {
    "kind": "column-impact",
    "name": "drawn",
    "column": {"section": "HEB 220", "length_below": 1.0, "length_above": 3.0, "axial_load": 2e5},
    "striker": {"mass": 1000.0, "velocity": 10.0},
    "time": {"duration": 0.15},
}
DRAWN = {
    ("column", "length_below"): (0.8, 2.5),
    ("column", "length_above"): (1.0, 3.5),
    ("column", "axial_load"): (-2e5, 8e5),
    ("steel", "yield_stress"): (235e6, 460e6),
    ("striker", "mass"): (300.0, 2500.0),
    ("striker", "velocity"): (2.0, 22.0),
    ("striker", "restitution"): (-0.5, 1.0),
    ("column", "restraint_stiffness"): (-4e7, 4e7),
    ("time", "duration"): (0.06, 0.2),
}
WORDS = {
    ("column", "section"): ("HEB 220", "IPE 300", {"side": 0.15}, "HEA 200"),
    ("column", "base"): ("clamped", "pinned"),
    ("steel", "rate"): ("none", "S355"),
    ("column", "head"): ("guided", "pinned", "fixed"),
}


def drawn(count: int, seed: int = 1) -> Varied:
    """Columns by a Latin hypercube; without restraint, without restitution in a third or more."""
    ends = np.array(list(DRAWN.values()))
    points = qmc.LatinHypercube(len(ends), rng=np.random.default_rng(seed)).random(count)
    numbers = (ends[:, 0] + points * (ends[:, 1] - ends[:, 0])).T
    by_key: dict[tuple[str | int, ...], np.ndarray] = dict(zip(DRAWN, numbers, strict=True))
    for path in (("striker", "restitution"), ("column", "restraint_stiffness")):
        by_key[path] = np.maximum(by_key[path], 0.0)
    for path, words in WORDS.items():
        column = np.empty(count, object)
        column[:] = [words[i * len(words) // count] for i in range(count)]
        by_key[path] = np.random.default_rng(seed).permutation(column)
    return Varied(BASE, by_key)


def singles(model: Model, scenarios: Varied) -> pd.DataFrame:
    """What single calls say."""
    rows = []
    for row in range(len(scenarios)):
        try:
            response = model.simulate(scenarios[row])
        except InputError as error:
            rows.append({OUTCOME: "invalid-input", FAILURE: str(error)})
            continue
        ok = outcome_of(response) == "ok"
        values = {OUTCOME: outcome_of(response).value, FAILURE: response.attrs["message"]}
        rows.append({**(scalars_of(response) if ok else {}), **values})
    return pd.DataFrame(rows)


MODELS = {
    "energy": EnergyEstimate(),
    "single": SingleDof(),
    "linear": SingleDof("linear", interaction="linear", rotational_stiffness=6.0),
    "cubic": EnergyEstimate("cubic", hit_mass="waves"),
    "hinges": FourDof(),
    "panels": FourDofShear(),
    "soft": SoftImpact(striker_stiffness=3e6, crush_force=4e5),
    "rigid bars": RigidSuperelement(accuracy=0.03),
    "beams": FlexibleSuperelement(accuracy=0.03, shear="none"),
}


SLOW = ("soft", "rigid bars", "beams")


@pytest.mark.thorough
@pytest.mark.parametrize("name", MODELS)
def test_stacks_answer_as_single_calls_do(name: str) -> None:
    model, scenarios = MODELS[name], drawn(24 if name in SLOW else 60)
    table, alone = simulate_many(model, scenarios), singles(model, scenarios)
    assert {"ok", "collapse", "out-of-domain"} >= set(table[OUTCOME]) >= {"ok", "collapse"}
    assert table[[OUTCOME, FAILURE]].equals(alone[[OUTCOME, FAILURE]])
    assert set(table.columns) == set(alone.columns)
    for name in set(table.columns) - {OUTCOME, FAILURE}:
        np.testing.assert_allclose(table[name], alone[name], rtol=1e-9, atol=1e-12, err_msg=name)


def test_columns_of_hardening_steel_are_stacked() -> None:
    model = SingleDof()
    hard = {"elastic_modulus": 205e9, "hardening_modulus": 2.1e9, "rate": "S355"}
    moduli = {("steel", "elastic_modulus"): np.array([200e9, 210e9, 190e9])}
    scenarios = Varied(BASE | {"steel": hard}, moduli)
    assert can_stack(model, scenarios[0])
    table, alone = simulate_many(model, scenarios), singles(model, scenarios)
    assert table[[OUTCOME, FAILURE]].equals(alone[[OUTCOME, FAILURE]])
    peaks = "peak_displacement"
    np.testing.assert_allclose(table[peaks], alone[peaks], rtol=1e-9)


def test_numbers_do_not_depend_on_threads_or_neighbours() -> None:
    scenarios = drawn(9000)
    one, many = (simulate_many(SingleDof(), scenarios, threads) for threads in (1, 5))
    pd.testing.assert_frame_equal(one, many, check_exact=True)
    part = simulate_many(SingleDof(), scenarios[4000:4050])
    pd.testing.assert_frame_equal(
        part, one.iloc[4000:4050].reset_index(drop=True), check_exact=True
    )


def test_lists_of_scenarios_are_stacked_too() -> None:
    scenarios = drawn(40)
    listed = simulate_many(SingleDof(), [scenarios[row] for row in range(40)])
    pd.testing.assert_frame_equal(listed, simulate_many(SingleDof(), scenarios), check_exact=True)


def test_refused_values_have_the_words_of_a_single_call() -> None:
    wrong = {
        ("striker", "mass"): [1000.0, -1.0, 1000.0, "1 t", 1000.0, np.nan, "heavy"],
        ("column", "axial_load"): [0.0, 0.0, 1e8, 0.0, 2e6, 0.0, 0.0],
        ("column", "length_above"): [3.0, 3.0, 3.0, 3.0, 30.0, 3.0, 3.0],
    }
    table = simulate_many(SingleDof(), Varied(BASE, wrong))
    alone = singles(SingleDof(), Varied(BASE, wrong))
    assert table[OUTCOME].tolist() == [
        *("ok", "invalid-input", "invalid-input", "ok", "out-of-domain"),
        *("invalid-input", "invalid-input"),
    ]
    assert table[FAILURE].equals(alone[FAILURE])
    assert "Euler load" in table[FAILURE][4]


def test_columns_that_are_none_are_asked_one_by_one(thesis_impact) -> None:
    unknown = Varied(BASE, {("striker", "colour"): ["red", "blue"]})
    table = simulate_many(SingleDof(), unknown)
    assert set(table[OUTCOME]) == {"invalid-input"}
    equal = SingleDof(time_step=1e-5)
    assert not can_stack(equal, thesis_impact)
    alone = equal.simulate(thesis_impact)
    table = simulate_many(equal, [thesis_impact])
    assert table["peak_displacement"][0] == float(alone["peak_displacement"])


def test_a_row_of_a_stack_is_its_scenario() -> None:
    scenarios = drawn(12)
    for rows, stack in stacks(scenarios):
        assert stack is not None
        for i, row in enumerate(rows.tolist()):
            assert take(stack, i) == scenarios[row]


def test_rows_share_the_parts_in_which_nothing_varies() -> None:
    hits = Varied(BASE, {("striker", "velocity"): np.array([5.0, 10.0])})
    first, second = hits[0], hits[1]
    assert first.column is second.column
    assert (first.striker.velocity, second.striker.velocity) == (5.0, 10.0)
    loads = Varied(BASE, {("column", "axial_load"): np.array([0.0, 1e5])})
    assert [each.column.axial_load for each in loads] == [0.0, 1e5]
    assert loads[0].striker is loads[1].striker
    assert BASE["column"]["axial_load"] == 2e5


def test_a_model_that_crashes_costs_its_rows_alone() -> None:
    slow = [Varied(BASE, {("striker", "velocity"): np.array([10.0, 20.0])})[i] for i in (0, 1)]
    answers = simulate_many(Spring(trouble="raise"), slow)
    assert answers[OUTCOME].tolist() == ["ok", "crashed"]
    assert "toy-spring raised ZeroDivisionError" in answers[FAILURE][1]
