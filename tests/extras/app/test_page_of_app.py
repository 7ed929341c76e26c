"""Page of a scenario without a browser: what it asks, what it shows, what it saves."""

from __future__ import annotations

import os
import time
import tomllib
from base64 import b64decode
from concurrent.futures import Future

import pytest

pytest.importorskip("panel")

from workbench import simulate
from workbench.base.errors import InputError
from workbench.extras.app import chance, form, sheet, work
from workbench.extras.app.desk import LIVE, Desk, trouble
from workbench.extras.app.form import DECLARED, packed, started
from workbench.extras.app.page import ExplorerPage
from workbench.scenarios import scenario_from

PATIENCE = 120.0  # s
ROOMS = {"work": work, "sheet": sheet, "form": form, "chance": chance}


class Inline:
    """A desk that does its work at once, in this process; `skips` are functions that it leaves."""

    limit = 300.0

    def __init__(self, *skips: str) -> None:
        self.skips = skips or ("work.curves", "work.collapse", "sheet.picture_if_any")

    def ask(self, function, *arguments, lane=""):
        future: Future = Future()
        if function in self.skips:
            return future  # for ever at work
        if isinstance(function, str):
            room, _, name = function.partition(".")
            function = getattr(
                {"work": work, "sheet": sheet, "form": form, "chance": chance}[room], name
            )
        try:
            future.set_result(function(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future


@pytest.fixture
def page() -> ExplorerPage:
    return ExplorerPage(None, Inline())


def text_of(page: ExplorerPage, name: str) -> str:
    return page.shown[name].object


def is_pale(page: ExplorerPage, *names: str) -> bool:
    return {page.shown[name].styles["opacity"] for name in names} == {"0.65"}


def saved(page: ExplorerPage, key: str) -> bytes:
    page.shown["save"].sent = {}
    page._keep({"key": key, "value": True})
    assert page.shown["save"].errors == {}
    assert page.shown["save"].sent["name"] == f"my-column.{key}"
    return b64decode(page.shown["save"].sent["data"])


def test_the_answer_is_that_of_the_command_line(page):
    page.change({"key": "striker.velocity", "value": "36", "unit": "km/h"})
    tables = tomllib.loads(saved(page, "toml").decode())
    response = simulate(scenario_from(tables))
    assert response.workbench.headline in text_of(page, "answer")
    first = next(iter(page.responses.values()))
    assert float(first["peak_displacement"]) == float(response["peak_displacement"])
    assert set(page.responses) == {"flexible-superelement", "four-dof"}
    assert "four-dof" in text_of(page, "table")


def test_wrong_values_are_told_beside_their_field_and_the_last_answer_is_pale(page):
    before = dict(page.responses)
    page.change({"key": "striker.velocity", "value": "9000", "unit": "km/h"})
    assert page.shown["form"].errors == {
        "striker.velocity": "must be a number from 1e-06 to 300 m/s"
    }
    assert "the one before" in text_of(page, "answer")
    assert is_pale(page, "answer", "history", "table", "varied", "collapse")
    assert page.responses == before
    page._keep({"key": "pdf", "value": True})
    assert "striker.velocity" in page.shown["save"].errors["pdf"]
    page.change({"key": "striker.velocity", "value": "20", "unit": "km/h"})
    assert page.shown["form"].errors == {}
    assert "the one before" not in text_of(page, "answer")
    assert page.shown["answer"].styles == {"opacity": "1"}
    page.change({"key": "name", "value": "<b onclick=x>", "unit": ""})
    assert "<b onclick" not in "".join(str(text_of(page, n)) for n in ("answer", "table", "kept"))


def test_models_that_are_chosen_answer_when_they_are_asked(page, monkeypatch):
    monkeypatch.setattr("workbench.extras.app.page._QUICK", 60.0)  # s, on a busy machine too
    names = [field["key"] for field in page.shown["models"].groups[0]["fields"]]
    assert names[-1] == "ask"
    page._choose({"key": "energy-estimate", "value": True})
    assert "energy-estimate" not in page.responses
    ask = next(f for f in page.shown["models"].groups[0]["fields"] if f["key"] == "ask")
    assert ask["label"] == "Ask energy-estimate"
    page._choose({"key": "ask", "value": True})
    assert "energy-estimate" in page.responses
    page.change({"key": "striker.velocity", "value": "21", "unit": "km/h"})
    assert "energy-estimate" in page.responses  # it is quick: it follows from now on
    page._choose({"key": "four-dof", "value": False})
    assert "four-dof" not in page.responses


def test_a_collapse_and_a_refusal_are_answers(page):
    page.change({"key": "striker.velocity", "value": "80", "unit": "m/s"})
    assert "collapses" in text_of(page, "answer")
    assert page.shown["time"].groups == [{"title": "", "fields": []}]
    assert "No model that answered" in text_of(page, "instant")
    page.change({"key": "striker.velocity", "value": "5", "unit": "m/s"})
    page.change({"key": "striker.angle", "value": "30", "unit": "deg"})
    assert "seven-dof" in text_of(page, "answer")
    assert "out-of-domain" in text_of(page, "table")


def test_time_is_walked_through_within_the_record(page):
    count = len(page.deformed.shapes.at)
    for value in ("0", str(count - 1), "1e9", "-5"):
        page._move({"value": value})
        assert "ms" in text_of(page, "instant")
    assert page.shown["time"].groups[0]["fields"][0]["slider"] == [0, count - 1]


@pytest.mark.parametrize("kind", ["frame-impact", "member-pulse"])
@pytest.mark.thorough
def test_other_kinds_are_answered(page, kind):
    page.change({"key": "kind", "value": kind})
    assert page.form.error is None
    assert "flexible-superelement" in text_of(page, "answer")
    assert bool(page.shown["chance"].groups) == (kind == "frame-impact")


@pytest.mark.thorough
def test_files_are_those_of_the_reports(page):
    assert saved(page, "pdf").startswith(b"%PDF")
    assert saved(page, "csv").startswith(b"label,time_s")
    assert b"<svg" in saved(page, "svg")
    assert saved(page, "png").startswith(b"\x89PNG")
    assert saved(page, "html").count(b"</script>") == 4


class Later(Inline):
    """A desk whose work is done when the test says so."""

    def __init__(self) -> None:
        super().__init__("none")
        self.waiting: list = []

    def ask(self, function, *arguments, lane=""):
        future: Future = Future()
        self.waiting.append((function, arguments, future))
        return future

    def work(self, *names: str) -> None:
        """Do what was asked for, of these functions (of all without names)."""
        asked, self.waiting = self.waiting, []
        for function, arguments, future in asked:
            if names and function not in names:
                self.waiting.append((function, arguments, future))
            elif future.set_running_or_notify_cancel():
                try:
                    future.set_result(super().ask(function, *arguments).result())
                except Exception as error:
                    future.set_exception(error)


def test_no_answer_to_an_earlier_state_stands_beside_a_later_one():
    desk = Later()
    page = ExplorerPage(None, desk)
    assert page.responses == {}
    desk.work("work.answers", "work.models_of")
    desk.work()
    first = text_of(page, "answer")
    assert not is_pale(page, "varied")
    page.change({"key": "striker.velocity", "value": "40", "unit": "km/h"})
    assert is_pale(page, "structure", "varied", "hinges", "collapse", "first", "fragility")
    page._tick()
    assert is_pale(page, "answer", "history", "deformed", "table")
    page._keep({"key": "csv", "value": True})
    ((_, (kept,), _),) = [each for each in desk.waiting if each[0] == "sheet.histories_csv"]
    assert kept is page.responses  # of the state that was answered
    page._keep({"key": "pdf", "value": True})
    ((_, (asked, _), _),) = [each for each in desk.waiting if each[0] == "sheet.one_page"]
    assert asked.striker.velocity == pytest.approx(20 / 3.6)
    desk.work("work.answers")
    assert text_of(page, "answer") != first
    assert page.shown["answer"].styles == {"opacity": "1"}
    assert is_pale(page, "varied")
    desk.work("work.curves", "work.collapse", "sheet.picture_if_any")
    assert not is_pale(page, "varied")


def test_a_slow_answer_survives_a_tick_of_a_box_and_not_a_change():
    page = ExplorerPage(None, desk := Later())
    desk.work("work.answers", "work.models_of")
    page._choose({"key": "single-dof", "value": True})
    page._choose({"key": "ask", "value": True})
    page._choose({"key": "biggs", "value": True})
    desk.work("work.answers")
    assert "single-dof" in page.responses
    page._choose({"key": "energy-estimate", "value": True})
    assert "single-dof" in page.responses
    page._choose({"key": "ask", "value": True})
    page.change({"key": "striker.velocity", "value": "40", "unit": "km/h"})
    desk.work("work.answers")
    assert "energy-estimate" not in page.responses  # it was stopped


@pytest.mark.thorough
def test_a_slow_model_of_the_advice_follows_the_quick_ones():
    tables = started("column-impact")
    tables["column"]["axis"] = "weak"
    page = ExplorerPage(tables, desk := Later())
    desk.work("work.answers", "work.models_of")  # the first answer tells what is slow
    first = next(iter(page.responses))
    assert "because" in page.responses[first].attrs
    assert first != "flexible-superelement"
    page._slow = {first}
    page.change({"key": "striker.velocity", "value": "15", "unit": "km/h"})
    desk.work("work.answers")
    assert next(iter(page.responses)) == "four-dof"
    desk.work("work.answers")
    assert next(iter(page.responses)) == first
    assert first in text_of(page, "answer")


def test_a_slow_model_that_is_stopped_before_any_answer_shows_nothing():
    state = {"scenario": started("column-impact"), "models": ["single-dof"]}
    page = ExplorerPage(None, desk := Later(), packed(state))
    page._choose({"key": "ask", "value": True})
    page.stop()
    assert (page.responses, text_of(page, "table")) == ({}, "")
    desk.work("work.answers", "work.models_of")
    assert page.responses


def test_a_live_answer_that_fails_is_said_and_the_old_one_is_pale():
    page = ExplorerPage(None, desk := Later())
    desk.work("work.answers", "work.models_of")
    page.change({"key": "striker.velocity", "value": "40", "unit": "km/h"})
    (future,) = [each for name, _, each in desk.waiting if name == "work.answers"]
    future.set_running_or_notify_cancel()
    future.set_exception(TimeoutError())
    page._tick()
    assert "within the time limit" in text_of(page, "answer")
    assert is_pale(page, "answer", "table")
    assert not page.busy


def test_a_section_that_always_collapses_has_curves_without_peaks(page):
    scenario = page.form.scenario.at_velocity(200.0)
    curves = work.curves(scenario, ["striker.velocity"], "flexible-superelement", True)
    assert not [peak for peak in curves[0].peaks if peak < float("inf")]
    assert "collapses at all" in page.small["first"].show(curves[0], {"label": "Velocity"})


def test_files_are_opened_or_refused(page):
    def opened(content: bytes, **more):
        from base64 import b64encode

        message = {"key": "open", "name": "mine.toml", "value": b64encode(content).decode(), **more}
        page._keep(message)
        return page.shown["save"].errors.get("open", "")

    before = page.form.tables
    assert "not valid TOML" in opened(b"\x00\x01")
    assert "must be at most" in opened(b"", size=10**9)
    assert "the page shows" in opened(b'kind = "stud-tests"')
    assert page.form.tables is before
    assert opened(page.form.text.replace('"20 km/h"', '"40 km/h"').encode()) == ""
    assert page.form.scenario.striker.velocity == pytest.approx(40 / 3.6)


def test_a_link_reopens_the_state_and_another_one_is_told():
    tables = started("column-impact")
    tables["striker"]["velocity"] = "33 km/h"
    state = {"scenario": tables, "models": ["four-dof", "single-dof"]}
    page = ExplorerPage(None, Inline(), packed(state))
    assert page.form.tables == tables
    assert "could not be opened" not in text_of(page, "answer")
    odd = [{"scenario": tables, "models": each} for each in (3, None, "ab", ["x"] * 51)]
    wrong = (
        *odd,
        {"scenario": {**tables, "name": "\ud800"}, "models": []},
        {"scenario": 3, "models": []},
        {"models": []},
        [],
        {"scenario": {"kind": "x"}},
    )
    for each in ("rubbish", *map(packed, wrong)):
        page = ExplorerPage(None, Inline(), each)
        assert "could not be opened" in text_of(page, "answer")
        assert page.form.tables == started("column-impact")


def test_small_curves_and_the_collapse_are_those_of_sweep_and_limit():
    page = ExplorerPage(None, Inline("sheet.picture_if_any"))
    assert "Velocity: 13.8 mm to 103 mm over 10 to 30 km/h" in text_of(page, "varied")
    assert "survives up to 148 km/h and collapses at 148 km/h" in text_of(page, "collapse")
    curve = page.small["first"]._curve.data
    assert len(curve["x"]) == work.POINTS[True]
    peak = float(page.responses["flexible-superelement"]["peak_displacement"])
    middle = len(curve["x"]) // 2
    assert curve["x"][middle] == pytest.approx(20.0)
    assert curve["y"][middle] == pytest.approx(1e3 * peak, rel=1e-6)


@pytest.mark.parametrize(
    ("changed", "field"),
    [
        *(({"low": "x km/h"}, "low"), ({"high": "5 km/h"}, "high"), ({"low": "-1 m/s"}, "low")),
        *(({"striker.mass": "2"}, "striker.mass"), ({"striker.mass": "a"}, "striker.mass")),
        ({"striker.mass": "0", "steel.yield_stress": "0"}, "run"),
    ],
)
def test_a_fragility_of_wrong_values_is_refused(changed, field):
    given = {
        f["key"]: f"{f['value']} {f.get('unit', '')}".strip()
        for f in DECLARED["chance"][0]["fields"]
        if "value" in f
    }
    spreads, limit, ends = chance.fragility_input(given)
    assert (spreads["striker.mass"], limit) == (0.1, "displacement=100 mm")
    assert ends == pytest.approx((10 / 3.6, 60 / 3.6))
    with pytest.raises(InputError) as refused:
        chance.fragility_input({**given, **changed})
    assert refused.value.field == field


def sleeps() -> None:
    time.sleep(60.0)


def crashes() -> None:
    os._exit(3)


@pytest.mark.thorough
def test_models_that_hang_or_crash_cost_their_answer_alone():
    desk = Desk(limit=1.0)
    try:
        hung, dead = desk.ask(sleeps), desk.ask(crashes)
        fine = desk.ask(os.getpid, lane=LIVE)
        assert "within the time limit" in trouble(hung.exception(PATIENCE))
        assert "it crashed" in trouble(dead.exception(PATIENCE))
        assert fine.result(PATIENCE) != os.getpid()
        assert desk.ask(os.getpid).result(PATIENCE) not in (os.getpid(), fine.result())
    finally:
        desk.close()
