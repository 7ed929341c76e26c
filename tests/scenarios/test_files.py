"""Scenario files: round trips, overrides, and one clear message for every kind of bad input."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
import tomli_w
from builders import examples
from hypothesis import given
from hypothesis import strategies as st
from scenario_tables import SCENARIOS

from workbench.base.datafiles import data_directory
from workbench.base.errors import InputError
from workbench.scenarios import (
    Column,
    ColumnImpact,
    ColumnPushover,
    Striker,
    load_scenario,
    scenario_from,
    scenario_hash,
    to_toml,
)
from workbench.steel.sections import find, square

GOOD = """
kind = "column-impact"
name = "HEB 220 hit at 0.8 m"
[column]
section = "HEB 220"
fillets = false
length_below = 0.8
length_above = 3.2
axial_load = 0.5e6
restraint_stiffness = 1.0e7
[steel]
yield_stress = 355e6
[striker]
mass = 1500.0
velocity = 15
[time]
duration = 0.1
"""


@pytest.fixture
def good(tmp_path: Path) -> Path:
    path = tmp_path / "good.toml"
    path.write_text(GOOD)
    return path


def test_a_file_and_the_same_objects_are_equal(good: Path) -> None:
    column = Column(
        find("HEB 220"), 0.8, 3.2, fillets=False, axial_load=0.5e6, restraint_stiffness=1e7
    )
    assert load_scenario(good) == ColumnImpact(
        "HEB 220 hit at 0.8 m", column, Striker(1500.0, 15.0)
    )


@st.composite
def scenarios(draw: st.DrawFn) -> ColumnImpact | ColumnPushover:
    section = draw(st.sampled_from([find("IPE 300"), find("HEM 200"), square(0.15)]))
    column = Column(
        section,
        draw(st.floats(0.5, 5.0)),
        draw(st.floats(0.5, 5.0)),
        base=draw(st.sampled_from(["clamped", "pinned"])),
        head=draw(st.sampled_from(["guided", "pinned", "fixed"])),
        axial_load=draw(st.floats(-1e5, 1e5)),
        head_mass=draw(st.floats(0.0, 1e4)),
        area=draw(st.one_of(st.none(), st.floats(1e-3, 1e-1))),
        fillets=draw(st.booleans()),
    )
    if draw(st.booleans()):
        return ColumnPushover("push", column, draw(st.floats(0.01, 0.9)))
    restitution = draw(st.floats(0.0, 1.0))
    striker = Striker(draw(st.floats(1.0, 1e4)), draw(st.floats(0.1, 50.0)), restitution)
    return ColumnImpact("hit", column, striker, draw(st.floats(1e-3, 1.0)))


@examples(60)
@given(scenarios())
def test_canonical_toml_reads_back_as_an_equal_scenario(scenario) -> None:
    again = scenario_from(tomllib.loads(to_toml(scenario)))
    assert again == scenario
    assert to_toml(again) == to_toml(scenario)
    assert scenario_hash(again) == scenario_hash(scenario)


@pytest.mark.parametrize("name", SCENARIOS)
def test_canonical_toml_says_what_the_tables_say(name: str) -> None:
    scenario = scenario_from(SCENARIOS[name])
    tables = tomllib.loads(to_toml(scenario))
    head = {key: tables.pop(key) for key in ("kind", "name")}
    for statements in (
        scenario,
        replace(scenario, name="x"),
    ):  # the other's parts are written by now
        head["name"] = statements.name
        assert to_toml(statements) == f"{tomli_w.dumps(head)}\n{tomli_w.dumps(tables)}"


def test_hash_ignores_the_name_and_sees_everything_else(good: Path) -> None:
    scenario = load_scenario(good)
    assert scenario_hash(replace(scenario, name="other")) == scenario_hash(scenario)
    assert scenario_hash(scenario.at_velocity(15.000001)) != scenario_hash(scenario)
    clamped = replace(scenario, column=replace(scenario.column, base="pinned"))
    assert scenario_hash(clamped) != scenario_hash(scenario)


def test_overrides_reach_every_table(good: Path) -> None:
    overrides = ["column.axial_load=2e5", "striker.velocity = 20", "column.section=IPE 300"]
    scenario = load_scenario(good, [*overrides, "steel.density=8000"])
    tables = tomllib.loads(to_toml(scenario))
    assert tables["column"]["axial_load"] == 2e5
    assert tables["column"]["section"] == "IPE 300"
    assert tables["striker"]["velocity"] == 20.0
    assert tables["steel"]["density"] == 8000.0


def test_overridden_properties_win_over_the_section(good: Path) -> None:
    column = load_scenario(good, ["column.area=91e-4", "column.plastic_moment=284720"]).column
    assert column.properties.area == 91e-4
    assert column.properties.plastic_moment == 284720.0
    # stiffness and mass stay those of the rolled profile, the strength is that of the plates
    bare = load_scenario(good).column
    assert bare.properties.second_moment == pytest.approx(8091e-8, rel=1e-3)
    assert bare.properties.squash_load == pytest.approx(3133230.0, rel=1e-9)
    assert bare.properties.impact_mass == pytest.approx(7850 * bare.section.area * 4 / 3)


BAD = [
    ("column.colour=3", "column.colour", "unknown key"),
    ("column.lenght_below=0.8", "column.lenght_below", "did you mean length_below"),
    ("striker.mass=-5", "striker.mass", "from 0.001"),
    ("striker.mass='heavy'", "striker.mass", "must be a number"),
    ("column.axial_load=4e6", "column.axial_load", "squash load 3.13323e+06"),
    ("striker.restitution=1.5", "striker.restitution", "0 to 1"),
    ("column.length_below=800", "column.length_below", "metres, not millimetres"),
    ("column.section='HEB 225'", "column.section", "HEB 220"),
    ("column.length_above=nan", "column.length_above", "finite"),
    ("striker.velocity=inf", "striker.velocity", "finite"),
    ("time.duration=0", "time.duration", "from 1e-09"),
    ("column.base='glued'", "column.base", "clamped, pinned"),
    ("column.fillets=1", "column.fillets", "true or false"),
    ("steel.yield_stress=355", "steel.yield_stress", "355 MPa is 355e6"),
    ("column.second_moment=8091", "column.second_moment", "8091 cm4 is 8091e-8"),
    ("kind='column-crash'", "kind", "column-pushover, column-impact"),
    ("column.steel=1", "column.steel", "[steel]"),
    ("time=3", "time", "must be a table"),
]


@pytest.mark.parametrize(("override", "field", "words"), BAD, ids=lambda v: str(v)[:30])
def test_bad_values_name_field_and_remedy(good: Path, override, field, words) -> None:
    with pytest.raises(InputError) as caught:
        load_scenario(good, [override])
    assert caught.value.field == field
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("override", ["column.axial_load", "=3", "column.section.x=3", "a..b=1"])
def test_bad_overrides_are_refused(good: Path, override: str) -> None:
    with pytest.raises(InputError) as caught:
        load_scenario(good, [override])
    assert caught.value.field == "--set"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("kind = ", "not valid TOML"),
        ("name = 'x'", "kind"),
        ('kind = "column-impact"\n', "[column] is missing"),
        (GOOD.replace("[striker]\nmass = 1500.0\nvelocity = 15\n", ""), "[striker] is missing"),
        (GOOD.replace("mass = 1500.0\n", ""), "striker.mass"),
        (GOOD.replace("length_below = 0.8\n", ""), "column.length_below"),
        ('kind = "column-impact"\n[beam]\n', "beam"),
    ],
)
def test_broken_files_are_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=words.replace("[", r"\[").replace("]", r"\]")):
        load_scenario(path)


def test_unreadable_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        load_scenario(tmp_path / "missing.toml")
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not a UTF-8 text file"):
        load_scenario(binary)


def test_a_stump_is_not_a_column() -> None:
    with pytest.raises(InputError, match="not a beam"):
        Column(find("HEB 600"), 0.5, 0.5)


def test_a_push_past_twice_the_segment_is_refused() -> None:
    with pytest.raises(InputError, match="twice the shorter segment"):
        ColumnPushover("push", Column(find("HEB 220"), 0.8, 3.2), 1.7)


def test_published_columns_keep_the_hash_that_keys_their_stored_answers() -> None:
    folder = data_directory() / "published"
    hashes = {
        name: scenario_hash(load_scenario(folder / f"heng2017_{name}_column.toml"))
        for name in ("impact", "clamped")
    }
    assert hashes == {"impact": "92bd2ecb9e9762e2", "clamped": "8e3b63c40ab43604"}


def test_equal_parts_are_found_in_other_processes(good: Path) -> None:
    scenario = load_scenario(good)
    assert {scenario, load_scenario(good)} == {scenario}  # both have told their hash by now
    code = (
        "import pickle, sys; from workbench.scenarios import load_scenario; "
        "assert pickle.load(sys.stdin.buffer) in {load_scenario(sys.argv[1])}"
    )
    seed = {**os.environ, "PYTHONHASHSEED": "1"}  # words hash otherwise there
    call = [sys.executable, "-c", code, str(good)]
    subprocess.run(call, input=pickle.dumps(scenario), env=seed, check=True)
