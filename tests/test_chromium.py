"""The driver of the browser: what a person does reaches a page, what goes wrong in it is noted."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from chromium import CONTROL, SHIFT, Chromium, DevToolsError

pytestmark = pytest.mark.thorough

PAGE = """<!DOCTYPE html><title>A page</title><label>first <input id="first"></label><div></div>
<script>
const root = document.querySelector("div").attachShadow({mode: "open"});
root.innerHTML = `<p style="height: 2000px">far</p><button aria-label="Save it">save</button>
<input type="file" multiple><textarea></textarea>`;
window.seen = [];
addEventListener("keydown", (event) => seen.push(event.key + (event.ctrlKey ? " ctrl" : "")));
root.querySelector("button").onclick = () => {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob(["kept"]));
  link.download = "kept.txt";
  link.click();
};
</script>"""


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with Chromium(tmp_path_factory.mktemp("downloads")) as started:
        yield started


@pytest.fixture
def tab(browser, tmp_path):
    (tmp_path / "page.html").write_text(PAGE, encoding="utf-8")
    opened = browser.tab((tmp_path / "page.html").as_uri(), 390, 600)
    yield opened
    opened.close()


def test_a_page_has_the_size_that_was_asked_for(tab, tmp_path):
    assert tab.js("[innerWidth, innerHeight]") == [390, 600]
    tab.size(800)
    assert tab.js("[innerWidth, innerHeight]") == [800, 900]
    header = tab.screenshot(tmp_path / "seen.png").read_bytes()[:24]
    assert struct.unpack(">II", header[16:]) == (800, 900)


def test_texts_and_keys_go_where_the_focus_is(tab):
    tab.fill("#first", "old", key="")
    tab.fill("#first", "15", key="Tab")
    tab.press("x")
    assert tab.js("deep('#first').value") == "15"
    assert tab.js("document.activeElement.shadowRoot.activeElement.tagName") == "BUTTON"
    tab.press("a", CONTROL)
    tab.press("Tab", SHIFT)
    assert tab.js("document.activeElement.id") == "first"
    assert tab.js("seen") == ["Tab", "x", "a ctrl", "Tab"]
    tab.press("End")
    tab.press("Backspace")
    assert tab.js("deep('#first').value") == "1"
    tab.click("textarea")
    tab.press("y")
    tab.press("Enter")
    assert tab.js("deep('textarea').value") == "y\n"


def test_a_click_inside_a_shadow_root_and_out_of_sight_is_a_click(browser, tab):
    tab.click("deepText('button', 'sav')")
    (kept,) = browser.downloaded()
    assert kept.name == "kept.txt"
    assert kept.read_text(encoding="utf-8") == "kept"


def test_files_are_chosen_inside_a_shadow_root(tab, tmp_path):
    paths = [tmp_path / "a.csv", tmp_path / "b.csv"]
    for path in paths:
        path.write_text(f"load\n{path.stem}", encoding="utf-8")
    tab.files("input[type=file]", *paths)
    read = "Promise.all([...deep('input[type=file]').files].map((file) => file.text()))"
    assert tab.js(read) == ["load\na", "load\nb"]


def test_a_screen_reader_gets_roles_and_names(tab):
    found = [(node["role"], node["name"]) for node in tab.tree()]
    assert ("button", "Save it") in found
    assert ("textbox", "first") in found


def test_errors_and_requests_are_noted(tab):
    assert tab.errors == []
    tab.js("(console.error('wrong', 3), setTimeout(() => { throw new Error('late'); }), 0)")
    tab.js("fetch('http://elsewhere.example/').catch(() => 0)")
    tab.wait("true")
    assert tab.errors[0] == "wrong 3"
    assert any("late" in text for text in tab.errors)
    assert tab.requests[-1] == "http://elsewhere.example/"
    assert any("ERR_NAME_NOT_RESOLVED" in text for text in tab.errors)


def test_a_reload_makes_a_new_page(tab):
    tab.js("window.kept = 1")
    tab.reload()
    assert tab.js("window.kept ?? null") is None
    assert tab.js("deep('textarea') !== null")


def test_what_is_not_there_fails(tab):
    with pytest.raises(DevToolsError, match=r"not within 0\.1 s"):
        tab.wait("deep('#second')", 0.1)
    with pytest.raises(DevToolsError, match="nothing is not defined"):
        tab.js("nothing")
    with pytest.raises(DevToolsError, match="ERR_FILE_NOT_FOUND"):
        tab.go(Path("/nowhere.html").as_uri())


def test_a_browser_that_is_closed_leaves_nothing():
    opened = Chromium()
    process, profile = opened.process, Path(opened.profile.name)
    opened.tab("data:text/html,<p>hello")
    opened.close()
    assert process.returncode is not None
    assert not profile.exists()
