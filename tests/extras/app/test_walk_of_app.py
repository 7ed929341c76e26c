"""A person's walk through the page in a browser: from nothing to a PDF, and all that goes wrong."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest
from chromium import Chromium, Tab

pytest.importorskip("panel")

pytestmark = pytest.mark.thorough

PEAK = re.compile(r"([0-9.]+)\smm")
QUIET = "could not set initial ranges"  # of plots without a point
PATIENCE = 120.0  # s: the first answers may be compiled


class Walked:
    """The command at work, a browser, and the directory of its downloads."""

    def __init__(self, browser: Chromium, address: str) -> None:
        self.browser, self.address = browser, address

    def open(self, path: str = "", **size: int) -> Tab:
        """A tab of the page with its first answer."""
        tab = self.browser.tab(self.address + path, **size)
        tab.wait("deep('.headline')", PATIENCE)
        tab.wait("deep('[data-key=kind]') && deep('[data-key=ask]') && deep('[data-slider=time]')")
        return tab


@pytest.fixture(scope="module")
def walked(tmp_path_factory):
    command = [str(Path(sys.executable).with_name("workbench")), "app", "--no-browser", "--port=0"]
    with Chromium(tmp_path_factory.mktemp("downloads")) as browser:
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        try:
            (address,) = re.findall(r"http://\S+", process.stderr.readline())
            yield Walked(browser, address)
        finally:
            process.terminate()
            _, told = process.communicate(timeout=30)
    assert process.returncode == 0
    assert "Traceback" not in told


def headline(tab: Tab) -> str:
    return tab.js("deep('.headline').innerText")


def answered(tab: Tab, before: str) -> str:
    """The headline that follows another one, once it stays."""
    tab.wait(f"deep('.headline').innerText !== {json.dumps(before)}", PATIENCE)
    text = ""
    while text != (text := headline(tab)):
        time.sleep(1.5)
    return text


def field(key: str, kind: str = "key") -> str:
    return f"[data-{kind}='{key}']"


def value(tab: Tab, key: str) -> str:
    return tab.js(f"deep({json.dumps(field(key))}).value")


def chosen(tab: Tab, key: str, word: str, kind: str = "key") -> None:
    """Choose a word of a list, as a person does with its keys."""
    change = "dispatchEvent(new Event('change'))"
    element = f"deep({json.dumps(field(key, kind))})"
    tab.wait(element)
    tab.js(f"(() => {{ const e = {element}; e.value = {json.dumps(word)}; e.{change}; }})()")


def troubles(tab: Tab) -> list[str]:
    return [error for error in tab.errors if QUIET not in error]


def test_from_nothing_to_a_pdf_and_the_same_number_on_the_command_line(walked, tmp_path):
    tab = walked.open()
    first = headline(tab)
    tab.fill(field("column.section"), "HEB 260")
    tab.fill(field("striker.velocity"), "30")
    second = answered(tab, first)
    tab.fill(field("striker.mass"), "2")
    third = answered(tab, second)
    peak = float(PEAK.match(third)[1])
    before = len(walked.browser.downloaded(0))
    tab.click(field("toml"))
    tab.click(field("pdf"))
    files = {path.suffix: path for path in walked.browser.downloaded(before + 2, PATIENCE)}
    assert files[".pdf"].read_bytes().startswith(b"%PDF")
    command = [str(Path(sys.executable).with_name("workbench")), "simulate", str(files[".toml"])]
    done = subprocess.run([*command, "--json"], capture_output=True, text=True, check=True)
    told = json.loads(done.stdout)
    assert 1e3 * told["peak_displacement"] == pytest.approx(peak, rel=5e-3)
    assert told["headline"] == third
    assert not troubles(tab)
    assert {re.match(r"\w+://([\d.:]+)?", url)[0] for url in tab.requests if ":" in url} <= {
        *(f"{scheme}://{walked.address.split('/')[2]}" for scheme in ("http", "ws")),
        *("blob://", "data://"),
    } | {"blob"}


def test_the_hand_is_followed_and_wrong_input_is_told(walked):
    tab = walked.open()
    first = headline(tab)
    tab.fill(field("striker.velocity"), "20,5")
    tab.wait(f"deep({json.dumps(field('striker.velocity', 'error'))}).innerText.includes('point')")
    tab.wait("deepText('p', 'An input is not right')")
    opacity = "getComputedStyle(deep('.headline').getRootNode().host).opacity"
    assert tab.js(opacity) == "0.65"
    tab.fill(field("striker.velocity"), "20")
    tab.wait("!deepText('p', 'An input is not right')")
    assert headline(tab) == first
    tab.wait(f"{opacity} === '1'")
    chosen(tab, "striker.velocity", "m/s", kind="unit")
    tab.wait(f"deep({json.dumps(field('striker.velocity'))}).value.startsWith('5.55')")
    tab.js(f"deep({json.dumps(field('striker.velocity', 'slider'))}).focus()")
    for _ in range(5):
        tab.press("ArrowRight")
    assert float(PEAK.match(answered(tab, first))[1]) > float(PEAK.match(first)[1])
    time_before = tab.js("deep('[data-slider=time]').value")
    tab.js("deep('[data-slider=time]').focus()")
    tab.press("ArrowRight")
    assert float(tab.js("deep('[data-slider=time]').value")) == float(time_before) + 1
    assert not troubles(tab)


def test_a_reference_is_asked_and_stopped(walked):
    tab = walked.open()
    tab.wait("deep('[data-key=fiber-corotational]')")
    tab.js("deep('[data-key=fiber-corotational]').click()")
    tab.wait("deep('[data-key=ask]').innerText === 'Ask fiber-corotational'")
    tab.click(field("ask"))
    tab.wait("deep('[data-key=stop]')")
    tab.js("deep('[data-key=stop]').click()")
    tab.wait("deep('[data-key=ask]').innerText === 'Ask fiber-corotational'", PATIENCE)
    tab.js("deep('[data-key=fiber-corotational]').click()")
    tab.js("deep('[data-key=energy-estimate]').click()")
    tab.wait("deep('[data-key=ask]').innerText === 'Ask energy-estimate'")
    tab.click(field("ask"))
    tab.wait("deep('table').innerText.includes('energy-estimate')", PATIENCE)


def test_a_link_and_a_reload_reopen_the_state_and_tabs_have_their_own(walked):
    one, other = walked.open(), walked.open()
    before = headline(one)
    one.fill(field("striker.velocity"), "44")
    changed = answered(one, before)
    assert headline(other) == before
    one.wait("location.search.length > 100")
    link = one.js("location.search")
    one.reload()
    one.wait("deep('.headline')", PATIENCE)
    assert (headline(one), value(one, "striker.velocity")) == (changed, "44")
    third = walked.open(link)
    assert value(third, "striker.velocity") == "44"
    broken = walked.open("?s=nothing")
    broken.wait(
        "[...document.querySelectorAll('*')].some((e) => e.shadowRoot?.innerHTML"
        ".includes('could not be opened'))"
    )
    assert value(broken, "striker.velocity") == "20"


def test_other_kinds_and_a_file_are_shown(walked, tmp_path):
    tab = walked.open()
    before = headline(tab)
    chosen(tab, "kind", "frame-impact")
    answered(tab, before)
    tab.fill(field("frame.bays"), "5; 6")
    file = tmp_path / "mine.toml"
    file.write_text('kind = "frame-static"\n', encoding="utf-8")
    tab.files(field("open"), file)
    tab.wait("deep('[data-error=open]').innerText.includes('the page shows')")
    text = 'kind = "column-impact"\nname = "<script>window.bad = 1</script>"\n[column]\n'
    text += 'section = "HEB 220"\nlength_below = 1.0\nlength_above = 2.0\n'
    file = tmp_path / "other.toml"  # the same one again is no change to a browser
    file.write_text(text + "[striker]\nmass = 1000.0\nvelocity = 5.0\n", encoding="utf-8")
    tab.files(field("open"), file)
    tab.wait("deep('[data-key=\"striker.mass\"]')?.value === '1000'", PATIENCE)
    tab.wait("deep('[data-key=name]').value.includes('<script>')")
    assert tab.js("window.bad === undefined")
    assert not troubles(tab)


def test_the_page_is_for_keyboards_screen_readers_and_small_screens(walked):
    tab = walked.open(width=390, height=800)
    assert tab.js("document.documentElement.scrollWidth") <= 390
    assert tab.js("document.documentElement.lang") == "en"
    roles = {"textbox", "button", "combobox", "slider", "checkbox", "link", "searchbox"}
    controls = [node for node in tab.tree() if node["role"] in roles]
    assert len(controls) > 40
    assert [node for node in controls if not node["name"]] == []
    names = [node["name"] for node in tab.tree() if node["role"] == "heading"]
    assert {"Your structure", "The answer", "Save and share", "Shear studs"} <= set(names)
    tab.js("document.querySelector('nav a').focus()")
    for _ in range(6):
        tab.press("Tab")
    assert tab.js(
        "(() => { let e = document.activeElement; while (e.shadowRoot?.activeElement)"
        " e = e.shadowRoot.activeElement; return e.dataset.key || e.dataset.unit || ''; })()"
    )
    time.sleep(1.0)
    assert tab.js("document.documentElement.scrollWidth") <= 390


def test_tests_on_studs_begin_with_a_button(walked, tmp_path):
    tab = walked.open()
    assert not tab.js("!!deep('.filepond--browser')")
    tab.click(field("tests"))
    tab.wait("deep('.filepond--browser')", PATIENCE)
    file = tmp_path / "hostile.csv"
    file.write_bytes(b"\x00\x01 no table")
    tab.files(".filepond--browser", file)
    tab.wait("deepText('p', 'binary data')", PATIENCE)
    assert not troubles(tab)
