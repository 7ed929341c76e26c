"""Tests on studs as a scenario: TOML in and out, campaigns that do one thing, files by content."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from workbench.base.errors import InputError
from workbench.scenarios import StudTests, load_scenario, scenario_from, scenario_hash, to_toml

SPLIT = StudTests("split", calibrate=("provines2019",), validate=("lehigh279",))


def test_round_trip_and_hash() -> None:
    again = scenario_from(tomllib.loads(to_toml(SPLIT)))
    assert again == SPLIT
    assert scenario_hash(again) == scenario_hash(SPLIT)
    renamed = StudTests("other", calibrate=("provines2019",), validate=("lehigh279",))
    assert scenario_hash(renamed) == scenario_hash(SPLIT)
    assert scenario_hash(StudTests("all")) != scenario_hash(SPLIT)


def test_a_file_counts_with_its_content(tmp_path: Path) -> None:
    table = tmp_path / "lab.csv"
    table.write_text("one")
    given = StudTests("mine", tables=("stud-push-out", str(table)))
    assert len(given.digests) == 1
    text = to_toml(given)
    scenario = tmp_path / "scenario.toml"
    scenario.write_text(text)
    assert load_scenario(scenario) == given
    table.write_text("two")
    changed = StudTests("mine", tables=("stud-push-out", str(table)))
    assert scenario_hash(changed) != scenario_hash(given)
    with pytest.raises(InputError, match="the file has changed; remove the key"):
        load_scenario(scenario)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"asked": "colour"}, "tests.asked = 'colour': must be one of strength"),
        ({"tables": ()}, "must name a table"),
        ({"tables": "stud-push-out"}, "must be a list of texts"),
        ({"tables": ("a.csv",)}, "a.csv'.*No such file"),
        ({"calibrate": ("a", "a")}, "tests.calibrate = 'a': stands twice"),
        ({"calibrate": ("a",), "validate": ("a",)}, "a fit is not validated by its own rows"),
        ({"confidence": 90.0}, "tests.confidence"),
        ({"digests": ("0" * 16,)}, "must be 0, one per file"),
    ],
)
def test_impossible_questions_are_refused(change: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        StudTests("x", **change)


def test_unknown_keys_are_refused() -> None:
    with pytest.raises(InputError, match="did you mean validate"):
        scenario_from({"kind": "stud-tests", "tests": {"validates": []}})
    with pytest.raises(InputError, match=r"must be a table \[tests\]"):
        scenario_from({"kind": "stud-tests", "tests": 3})
