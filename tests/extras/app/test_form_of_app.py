"""Form of the page: its tables are a scenario file, and say what cannot be."""

from __future__ import annotations

import json
import tomllib
import zlib
from base64 import urlsafe_b64encode

import pytest

pytest.importorskip("panel")

from hypothesis import given
from hypothesis import strategies as st

from workbench.base.errors import InputError
from workbench.extras.app.form import DECLARED, ScenarioForm, packed, read_tables, started, unpacked
from workbench.scenarios import scenario_from
from workbench.scenarios.files import LARGEST_FILE

KINDS = tuple(DECLARED["kinds"])


def fields_of(form: ScenarioForm) -> dict[str, dict]:
    return {field["key"]: field for group in form.groups for field in group["fields"]}


@pytest.mark.parametrize("kind", KINDS)
def test_every_field_is_a_key_that_files_have_and_shows_what_stands_there(kind):
    form = ScenarioForm(started(kind))
    assert form.error is None
    for key, field in fields_of(form).items():
        assert field["label"]
        if field["kind"] == "number" and key != "time.duration":
            form.change(key, "no number", field["unit"])
            assert form.error is not None
            assert form.error.field.startswith(key.split(".")[0])
            form.change(key, field["value"], field["unit"])
            assert form.error is None, key
            assert fields_of(form)[key]["value"] == field["value"]


def test_a_changed_form_is_the_file_that_the_command_line_reads(tmp_path):
    form = ScenarioForm(started("column-impact"))
    form.change("striker.velocity", "54", "km/h")
    form.change("column.section", "HEB 300")
    form.change("column.head", "pinned")
    form.change("steel.yield_stress", "")
    form.change("steel.grade", "S275")
    form.change("steel.thickness", "20", "mm")
    read = scenario_from(tomllib.loads(form.text))
    assert read == form.scenario
    assert read.striker.velocity == 15.0
    assert (read.column.section.name, read.column.head) == ("HEB 300", "pinned")
    assert read.column.steel.yield_stress == 265e6  # EN 10025-2, above 16 mm
    assert 'velocity = "54 km/h"' in form.text


@pytest.mark.parametrize(
    ("key", "value", "unit", "said"),
    [
        ("striker.velocity", "5400", "km/h", "from 1e-06 to 300 m/s"),
        ("striker.velocity", "20,5", "km/h", "decimals have a point"),
        ("striker.velocity", "nan", "km/h", "must be"),
        ("striker.mass", "", "t", "is missing"),
        ("striker.mass", "<img src=x>", "t", "must be a number"),
        ("column.section", "HEB 221", "", "HEB 220"),
        ("column.axial_load", "1e9", "kN", "must be"),
        ("column.length_below", "1e400", "m", "must be"),
    ],
)
def test_wrong_values_are_told_with_their_field_and_kept_as_typed(key, value, unit, said):
    form = ScenarioForm(started("column-impact"))
    form.change(key, value, unit)
    assert form.error is not None
    assert form.error.field == key
    assert said in str(form.error)
    with pytest.raises(InputError):
        _ = form.scenario
    form.change(key, str(started("column-impact")["striker"]["mass"]).split()[0], unit)
    if key == "striker.mass":
        assert form.error is None


def test_another_unit_leaves_the_quantity():
    form = ScenarioForm(started("column-impact"))
    before = form.scenario
    for key, unit in (
        ("striker.velocity", "m/s"),
        ("striker.mass", "kg"),
        ("column.axial_load", "N"),
    ):
        form.measure(key, unit)
        assert fields_of(form)[key]["unit"] == unit
    assert form.scenario.striker.mass == before.striker.mass
    assert form.scenario.striker.velocity == pytest.approx(before.striker.velocity, rel=1e-9)
    form.measure("column.head_mass", "kg")  # not given: nothing to write
    assert "head_mass" not in form.tables["column"]
    form.change("striker.velocity", "fast", "m/s")
    form.measure("striker.velocity", "km/h")
    assert form.tables["striker"]["velocity"] == "fast m/s"


def test_frames_take_bays_and_name_their_nodes():
    form = ScenarioForm(started("frame-impact"))
    form.change("frame.bays", "6, 7.5", "m")
    form.change("frame.storeys", "4; 3.5", "m")
    assert len(form.scenario.frame.nodes) == 10  # nine, and the impact point
    assert "C2" in fields_of(form)["striker.node"]["list"]
    assert "load.0.node" in form.kept
    assert "split.0.at" in fields_of(form)
    form.change("striker.node", "Z9")
    assert form.error is not None


def test_another_kind_begins_with_its_template_and_the_first_is_kept():
    form = ScenarioForm(started("column-impact"))
    form.change("name", "mine")
    form.change("kind", "member-pulse")
    assert form.scenario.KIND == "member-pulse"
    form.change("kind", "column-impact")
    assert form.scenario.name == "mine"


def test_a_grade_takes_the_place_of_a_yield_stress():
    form = ScenarioForm(started("column-impact"))
    assert form.scenario.column.steel.yield_stress == 355e6
    form.change("steel.grade", "S275")
    assert form.scenario.column.steel.yield_stress == 275e6


def test_lists_have_one_unit_and_no_decimal_commas():
    form = ScenarioForm(started("frame-impact"))
    form.tables["frame"]["bays"] = ["6 m", "500 cm", 7.0]
    assert fields_of(form)["frame.bays"]["value"] == "6, 5, 7"
    form.change("frame.bays", "5,5", "m")
    assert "decimals have a point" in str(form.error)
    form.change("frame.bays", ", ".join(["5"] * 30), "m")
    form.change("frame.storeys", ", ".join(["4"] * 30), "m")
    assert "at most 400 panels" in str(form.error)


def test_long_texts_are_no_numbers():
    form = ScenarioForm(started("column-impact"))
    form.change("striker.mass", "1 a" + " " * 30_000 + "b", "t")
    assert form.error is not None
    assert fields_of(form)["striker.mass"]["value"].startswith("1 a")


def test_a_unit_of_an_empty_field_is_kept():
    form = ScenarioForm(started("column-impact"))
    form.measure("column.head_mass", "kg")
    assert fields_of(form)["column.head_mass"]["unit"] == "kg"


@given(st.sampled_from(KINDS), st.lists(st.text(max_size=8), max_size=3))
def test_links_hold_the_state(kind, models):
    state = {"scenario": started(kind), "models": models}
    assert unpacked(packed(state)) == state


@pytest.mark.parametrize(
    "text",
    [
        *("", "%%%", "AAAA", "é", urlsafe_b64encode(b"{}").decode()),
        urlsafe_b64encode(zlib.compress(b"[" * 100_000)).decode(),
        urlsafe_b64encode(zlib.compress(b" " * (LARGEST_FILE + 10))).decode(),
        packed({})[:-6],
    ],
)
def test_links_that_are_none_are_refused(text):
    with pytest.raises(InputError, match="link"):
        unpacked(text)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"\xff\xfe", "not valid TOML"),
        (b"kind = ", "not valid TOML"),
        (b"a = " + b"[" * 5000, "not valid TOML"),
        (b'kind = "frame-static"', "the page shows"),
        (b'kind = "column-impact"\nname = "x"', "column"),
        (b"#" * (LARGEST_FILE + 1), "at most"),
    ],
)
def test_files_that_are_no_scenario_of_the_page_are_refused(content, said):
    with pytest.raises(InputError, match=said):
        read_tables(content)


def test_states_are_plain_json():
    assert json.loads(json.dumps(started("frame-impact"))) == started("frame-impact")
