from __future__ import annotations

import io
from types import SimpleNamespace

import pytest

from workbench.responses import Outcome
from workbench.study import Study, cells_of
from workbench.study.runner import Progress, ProgressBar, progress_for


def test_the_estimate_weighs_labels_by_their_own_cost() -> None:
    dear, cheap = SimpleNamespace(label="dear"), SimpleNamespace(label="cheap")
    progress = Progress()
    progress.begin("toy", [dear] * 3 + [cheap] * 5, 0, 2)
    assert progress.seconds_left() is None
    progress.advance(dear, Outcome.OK, 10.0)
    assert progress.seconds_left() is None  # five of seven cells are of a label without a time
    assert progress.left == ""
    progress.advance(cheap, Outcome.CRASHED, 1.0)
    assert progress.seconds_left() == pytest.approx((2 * 10.0 + 4 * 1.0) / 2)
    assert progress.failed == 1
    progress.begin("toy", [dear] * 9 + [cheap], 0, 2, {"dear": [10.0]})
    assert progress.seconds_left() == pytest.approx(10 * 10.0 / 2)  # few unknown ones may


def test_stored_cells_tell_what_their_labels_cost() -> None:
    dear, cheap = SimpleNamespace(label="dear"), SimpleNamespace(label="cheap")
    stream = io.StringIO()
    progress = Progress(stream)
    progress.begin("toy", [dear] * 3 + [cheap] * 5, 3, 2, {"dear": [9.0, 11.0], "cheap": [1.0]})
    assert progress.seconds_left() == pytest.approx((3 * 10.0 + 5 * 1.0) / 2)
    progress.advance(dear, Outcome.OK, 13.0)
    assert progress.seconds_left() == pytest.approx((2 * 11.0 + 5 * 1.0) / 2)
    first = stream.getvalue().splitlines()[0]
    assert first == "toy: 8 cells to answer, 3 already stored, about 0:00:18 left"


def test_lines_are_few_and_say_what_is_left(toy_study: Study) -> None:
    stream = io.StringIO()
    cells = cells_of(toy_study) * 10
    lines = Progress(stream)
    lines.begin("toy", cells, 3, 2)
    for number, cell in enumerate(cells):
        outcome = Outcome.OUT_OF_DOMAIN if number % 2 else Outcome.CRASHED
        lines.advance(cell, outcome, 2.0)
    lines.end()
    text = stream.getvalue().splitlines()
    assert text[0] == "toy: 120 cells to answer, 3 already stored"
    assert len(text) == 11
    assert text[1] == "12 of 120 cells, 6 failed, about 0:01:48 left"
    assert text[-1].startswith("120 of 120 cells answered, 60 failed, in ")


def test_a_slow_run_is_not_silent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("workbench.study.runner.SILENCE", -1.0)
    stream, cell = io.StringIO(), SimpleNamespace(label="dear")
    lines = Progress(stream)
    lines.begin("toy", [cell] * 40, 0, 1, {"dear": [60.0]})
    for _ in range(2):
        lines.advance(cell, Outcome.OK, 60.0)
    assert stream.getvalue().splitlines()[1:] == [
        "1 of 40 cells, about 0:39:00 left",
        "2 of 40 cells, about 0:38:00 left",
    ]


def test_a_bar_on_a_terminal_only() -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    assert isinstance(progress_for(Terminal(), {}), ProgressBar)
    assert type(progress_for(Terminal(), {"CI": "true"})) is Progress
    assert type(progress_for(io.StringIO(), {})) is Progress


def test_the_bar_runs(toy_study: Study, capsys: pytest.CaptureFixture[str]) -> None:
    bar = ProgressBar()
    cells = cells_of(toy_study)
    bar.begin("toy", cells, 0, 1)
    bar.note("a [note]")
    for cell in cells:
        bar.advance(cell, Outcome.OK, 0.1)
    bar.end()
    bar.end()
    shown = capsys.readouterr().err
    assert "a [note]" in shown
    assert "12/12" in shown
