"""Tab of studs in a browser: a new user's way to an appendix, by the keyboard too, and refusals."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from time import monotonic
from typing import Any

import pytest
from chromium import Chromium, Tab

from workbench.studs.schema import template

pytest.importorskip("panel")

pytestmark = pytest.mark.thorough

PATIENCE = 120.0  # s: workers start, on machines that do other things
SERVER = """
from contextlib import closing
from socket import create_server

from workbench.extras.app.desk import Desk
from workbench.extras.app.server import serve
from workbench.extras.app.studs import StudDesk

if __name__ == "__main__":
    with closing(Desk()) as desk:
        listener = create_server(("127.0.0.1", 0))
        address = "http://{}:{}/".format(*listener.getsockname())
        serve(lambda: StudDesk(desk).view(), listener, lambda: print(address, flush=True))
"""
HOSTILE = "<img src=x onerror=alert(1)>"


@pytest.fixture(scope="module")
def browser(tmp_path_factory: Any) -> Iterator[tuple[Chromium, str]]:
    script = tmp_path_factory.mktemp("server") / "serve_studs.py"
    script.write_text(SERVER)
    with Chromium(tmp_path_factory.mktemp("downloads")) as browser:
        command = [sys.executable, str(script)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        try:
            yield browser, process.stdout.readline().strip()
        finally:
            process.terminate()
            process.communicate(timeout=30)


def dropped(tab: Tab, path: Path) -> None:
    tab.wait("deep('.filepond--browser')", PATIENCE)
    tab.files(".filepond--browser", path)


def button(text: str) -> str:
    return f"deepAll('button').find(e => e.textContent.trim() === {text!r} && e.offsetParent)"


def said(text: str) -> str:
    return f"deepAll('.said').some(e => e.textContent.includes({text!r}))"


def test_a_new_user_gets_an_appendix(browser: tuple[Chromium, str], tmp_path: Path) -> None:
    (tmp_path / "lab.csv").write_text(template("strength", filled=True))
    begun, (program, address) = monotonic(), browser
    tab = program.tab(address, width=390)
    dropped(tab, tmp_path / "lab.csv")
    tab.wait(button("Use these columns"), PATIENCE)
    tab.click(button("Use these columns"))
    tab.wait("deepText('.callout', 'Grade')", PATIENCE)
    tab.click(button("Leave out as outlier"))  # nothing is selected
    tab.wait(said("Select tests"), PATIENCE)
    top, bottom = tab.js("(r => [r.top, r.bottom])(deep('.said').getBoundingClientRect())")
    assert 0 <= top < bottom <= 900  # in sight, however far the page is scrolled
    # the list of tests and the appendix by the keyboard alone
    tab.js("deep('select[multiple]').focus()")
    tab.press("ArrowDown")
    tab.js(f"{button('Hold out (judge by them)')}.focus()")
    tab.press("Enter")
    tab.wait("deepAll('select[multiple] option').some(e => e.text.endsWith('held out'))", PATIENCE)
    tab.js(f"{button('Appendix (PDF)')}.focus()")
    tab.press("Enter")
    (pdf,) = program.downloaded(1, PATIENCE)
    assert pdf.read_bytes().startswith(b"%PDF")
    assert monotonic() - begun < PATIENCE
    # nothing is wider than the page, has no name, or comes from elsewhere
    assert tab.js("document.documentElement.scrollWidth") <= 390
    fields = [row for row in tab.tree() if row["role"] in ("button", "combobox", "listbox")]
    assert fields
    assert [row for row in fields if not row["name"].strip()] == []
    assert all(each.startswith((address, address.replace("http", "ws"))) for each in tab.requests)
    assert tab.errors == []
    tab.close()


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("lab.csv", b"\0\1\2", "is binary data"),
        ("lab.exe", b"MZ", "must end in .csv or .xlsx"),
        (f"{HOSTILE}.csv", b"campaign,campaign\n", "stands twice"),
    ],
)
def test_a_hostile_file_gets_one_sentence(
    browser: tuple[Chromium, str], tmp_path: Path, name: str, content: bytes, message: str
) -> None:
    (tmp_path / name).write_bytes(content)
    tab = browser[0].tab(browser[1])
    dropped(tab, tmp_path / name)
    tab.wait(said(message), PATIENCE)
    assert tab.js("deepAll('.said p').length") == 1
    assert tab.dialogs == []
    tab.close()


def test_a_file_that_is_too_large_does_not_end_the_session(
    browser: tuple[Chromium, str], tmp_path: Path
) -> None:
    (tmp_path / "large.csv").write_bytes(b"a,b\n" * 6_000_000)
    (tmp_path / "most.csv").write_bytes(b"campaign,specimen\n" + b"a,b\n" * 4_900_000)
    tab = browser[0].tab(browser[1])
    dropped(tab, tmp_path / "large.csv")
    tab.wait("deepText('.filepond--file-status', 'too large')", PATIENCE)
    tab.files(".filepond--browser", tmp_path / "most.csv")
    tab.wait(said("more than 50000 rows"), PATIENCE)
    tab.close()


def test_texts_of_a_table_never_become_markup(
    browser: tuple[Chromium, str], tmp_path: Path
) -> None:
    text = template("strength", filled=True).replace("our lab", HOSTILE)
    (tmp_path / "lab.csv").write_text(text.replace("slip_at_max_mm", f"x_{HOSTILE}"))
    tab = browser[0].tab(browser[1])
    dropped(tab, tmp_path / "lab.csv")
    tab.wait(button("Use these columns"), PATIENCE)
    tab.click(button("Use these columns"))
    tab.wait("deepText('.callout', 'Grade')", PATIENCE)
    assert tab.js("deepAll('img').length") == 0
    assert tab.dialogs == []
    assert tab.js(f"deepAll('option').some(e => e.text.startsWith({HOSTILE!r}))")
    tab.close()
