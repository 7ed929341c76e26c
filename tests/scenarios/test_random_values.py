"""Any TOML value at any key, option or override: an object or one InputError, nothing else."""

from __future__ import annotations

import dataclasses
import datetime
import tomllib
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from builders import examples
from hypothesis import given
from hypothesis import strategies as st
from scenario_tables import SCENARIOS, places, put

from workbench.base.errors import InputError
from workbench.cli import main
from workbench.models.base import model_kind, model_names, with_options
from workbench.scenarios import load_scenario, scenario_from, scenario_hash, to_toml

PLACES = [(name, place) for name, tables in SCENARIOS.items() for place in places(tables)]
HUGE = [10**400, -(10**400), 2**1024, 2**63, -(2**63)]
UNPRINTABLE = [10**5000, -(16**4999)]  # more digits than Python prints
ODD = [-0.0, 0.0, float("nan"), float("inf"), -float("inf"), 5e-324, 1.8e308, -1e300]
MOMENTS = [datetime.datetime(2026, 1, 1), datetime.date(2026, 1, 1), datetime.time(12)]
WORDS = ["", " ", "\n", "\x00", "a.b", "a:b", "a\tb", "\u2028", "٣", "HEB ٣", "HEB " + "9" * 5000]
SCALARS = st.one_of(
    st.sampled_from([*HUGE, *ODD, *MOMENTS, *WORDS, True, False]),
    st.integers(),
    st.floats(),
    st.text(max_size=300),
)
VALUES = st.one_of(
    SCALARS,
    st.recursive(
        SCALARS,
        lambda inner: st.one_of(
            st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=8), inner, max_size=4)
        ),
        max_leaves=12,
    ),
)


def deep(depth: int) -> Any:
    """Arrays nested so deep that Python cannot print them."""
    value: Any = []
    for _ in range(depth):
        value = [value]
    return value


AWKWARD = [*HUGE, *UNPRINTABLE, *ODD, *MOMENTS, *WORDS, True, [], deep(5), deep(5000), {}]
AWKWARD += [[10**5000], {"a": {"b": 10**5000}}, {"name": 10**5000, "node": 10**5000}]


def attempt(make: Any, *arguments: Any) -> Any:
    """The object, or None where one readable line refuses it."""
    try:
        return make(*arguments)
    except InputError as error:
        message = str(error)
    assert message.isprintable()
    assert len(message) < 5000
    return None


def check_scenario(tables: dict[str, Any]) -> bool:
    """Whether the tables give a scenario, which then writes itself and reads back as itself."""
    scenario = attempt(scenario_from, tables)
    if scenario is None:
        return False
    again = scenario_from(tomllib.loads(to_toml(scenario)))
    assert again == scenario
    assert scenario_hash(again) == scenario_hash(scenario)
    return True


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_tables_that_are_disturbed_are_good_and_complete(name: str) -> None:
    tables = SCENARIOS[name]
    assert check_scenario(tables)
    written = tomllib.loads(to_toml(scenario_from(tables)))
    if name != "regular":
        for table in written.keys() - {"kind", "name"}:
            first = written[table][0] if isinstance(written[table], list) else written[table]
            given_first = tables[table][0] if isinstance(tables[table], list) else tables[table]
            assert first.keys() <= given_first.keys()


@examples(800)
@given(st.sampled_from(PLACES), VALUES)
def test_any_value_at_any_key_of_any_scenario(where: tuple[str, tuple[Any, ...]], value) -> None:
    name, place = where
    check_scenario(put(SCENARIOS[name], place, value))


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "place"), PLACES, ids=lambda v: ".".join(map(str, v)))
def test_every_key_meets_every_awkward_value(name: str, place: tuple[Any, ...]) -> None:
    answered = 0
    for value in AWKWARD:
        tables = put(SCENARIOS[name], place, value)
        answered += check_scenario(tables)
    assert answered < 10


@pytest.mark.thorough
@examples(300)
@given(st.sampled_from(PLACES), st.text(max_size=20), VALUES)
def test_unknown_keys_are_refused(where, key: str, value) -> None:
    name, place = where
    holder: Any = SCENARIOS[name]
    for step in place:
        holder = holder[step]
    if isinstance(holder, dict) and key not in holder:
        assert attempt(scenario_from, put(SCENARIOS[name], (*place, key), value)) is None


MODELS = {name: model_kind(name) for name in model_names()}
OPTIONS = [(name, field.name) for name in MODELS for field in dataclasses.fields(MODELS[name])]


@examples(400)
@given(st.sampled_from(OPTIONS), VALUES)
def test_any_value_of_any_option_of_any_model(option: tuple[str, str], value) -> None:
    model, name = option
    attempt(with_options, MODELS[model], {name: value})


@pytest.mark.parametrize(("model", "name"), OPTIONS)
def test_every_option_meets_every_awkward_value(model: str, name: str) -> None:
    for value in AWKWARD:
        attempt(with_options, MODELS[model], {name: value})


@examples(300)
@given(
    st.sampled_from(PLACES),
    st.one_of(
        st.text(),
        st.sampled_from(
            [f"1{'0' * 400}", f"1{'0' * 5000}", f"0x{'f' * 5000}", "[" * 5000, "1e999"]
        ),
    ),
)
def test_any_text_of_any_override(
    tmp_path_factory: pytest.TempPathFactory, where, text: str
) -> None:
    name, place = where
    path = tmp_path_factory.getbasetemp() / f"{name}.toml"
    if not path.exists():
        path.write_text(tomli_w.dumps(SCENARIOS[name]), encoding="utf-8")
    attempt(load_scenario, path, [".".join(map(str, place)) + "=" + text])


@pytest.mark.parametrize("text", ["[" * 5000, f"a = 1{'0' * 5000}", "a = 1\n" * 2, "\x00", "é" * 9])
def test_any_file(tmp_path: Path, text: str) -> None:
    path = tmp_path / "scenario.toml"
    path.write_text(text, encoding="utf-8")
    assert attempt(load_scenario, path) is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--set", f"striker.velocity=1{'0' * 400}"), "striker.velocity = 1000"),
        (("--set", f"striker.velocity=0x{'f' * 5000}"), "must be a number from 1e-06 to 300 m/s"),
        (("--set", f"column.length_below=1{'0' * 5000}"), "column.length_below = inf"),
        (("--set", "column.base=\n"), "column.base = '': must be one of"),
        (("--set", "column.section=HEB " + "9" * 5000), "must be a profile of the catalogue"),
        (("--set", f"column.area={'[' * 5000}"), "column.area = '[[["),
        (("--option", f"beta=1{'0' * 400}"), "option.beta = 1000"),
    ],
    ids=lambda v: str(v)[:40],
)
def test_the_command_line_refuses_in_one_line(
    tmp_path: Path, monkeypatch, capsys, arguments: tuple[str, ...], message: str
) -> None:
    path = tmp_path / "scenario.toml"
    path.write_text(tomli_w.dumps(SCENARIOS["impact"]), encoding="utf-8")
    verb = ["workbench", "simulate", str(path), "--model", "four-dof", *arguments]
    monkeypatch.setattr("sys.argv", verb)
    with pytest.raises(SystemExit) as left:
        main()
    printed = capsys.readouterr()
    assert (left.value.code, printed.out) == (2, "")
    assert printed.err.count("\n") == 1
    assert message in printed.err
