"""`workbench app`: who may ask its server, how it begins and ends, with a page that stands in."""

from __future__ import annotations

import asyncio
import os
import re
import signal
import socket
import subprocess
import sys
import threading
from contextlib import contextmanager, suppress
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from chromium import Chromium, DevToolsError

pytest.importorskip("panel")

from tornado.websocket import WebSocketClosedError, websocket_connect

from workbench.cli import run
from workbench.scenarios import to_toml

STAND_IN = str(Path(__file__).with_name("stand_in.py"))
thorough = pytest.mark.thorough


class Served:
    """A process that serves, its port, and what it wrote on the error stream so far."""

    def __init__(self, *arguments: str, limits: tuple[str, ...] = (), **environment: str) -> None:
        verb = ["app", *([] if environment else ["--no-browser"]), *arguments]
        self.process = subprocess.Popen(
            [sys.executable, STAND_IN, *limits, *verb],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | environment,
            preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_IGN),  # a shell's job
        )
        self.child = int(self.process.stderr.readline().split("child ")[1])
        line = self.process.stderr.readline()
        known = r"workbench: the page is at (http://127\.0\.0\.1:(\d+)/) until Ctrl-C\n"
        self.address, port = re.fullmatch(known, line).groups()
        self.port = int(port)

    def __enter__(self) -> Served:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.communicate()

    def end(self, number: int = signal.SIGTERM) -> str:
        """What it wrote since; it ends with 0 and leaves no process."""
        self.process.send_signal(number)
        out, error = self.process.communicate(timeout=30)
        assert (self.process.returncode, out) == (0, "")
        with pytest.raises(ProcessLookupError):
            os.kill(self.child, 0)
        return error

    def ask(self, path: str = "/", method: str = "GET", **headers: str) -> tuple[int, dict, str]:
        """Status, headers in lower case, and body of an answer to raw headers."""
        given = {"Host": f"127.0.0.1:{self.port}", "Connection": "close"}
        given |= {name.replace("_", "-"): value for name, value in headers.items()}
        lines = [f"{name}: {value}" for name, value in given.items() if value]
        return self.raw("\r\n".join([f"{method} {path} HTTP/1.1", *lines, "", ""]))

    def raw(self, text: str) -> tuple[int, dict, str]:
        """The same of a text that is sent as it is."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=20) as connection:
            connection.sendall(text.encode())
            with connection.makefile("rb") as stream:
                lines = list(iter(lambda: stream.readline().decode().strip(), ""))
                if not lines:
                    return 0, {}, ""  # the connection is ended without a word
                first, *lines = lines
                pairs = (line.split(": ", 1) for line in lines)
                headers = {name.lower(): value for name, value in pairs}
                body = stream.read(int(headers.get("content-length", 0))).decode("utf-8", "replace")
        return int(first.split()[1]), headers, body

    def token(self) -> str:
        """Token of a new session."""
        return re.search(r'"token":"([^"]+)"', self.ask()[2]).group(1)

    def upgrade(self, token: str, **headers: str) -> int:
        """Status of the answer to the handshake of a websocket."""
        upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec_WebSocket_Version": "13"}
        upgrade |= {"Sec_WebSocket_Key": "c2l4dGVlbiBieXRlcyE="}
        upgrade |= {"Sec_WebSocket_Protocol": f"bokeh, {token}", "Origin": self.address[:-1]}
        return self.ask("/ws", **(upgrade | headers))[0]


@pytest.fixture(scope="module")
def served():
    with Served("--port", "0", limits=("most_sessions=1000",)) as process:
        yield process


@contextmanager
def other_server(page: str):
    """A page of another place, and its address."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(page.encode())

        def log_message(self, *_: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()
        thread.join()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--port", "70000"), "--port = 70000: must be a whole number from 0 to 65535"),
        (("--port", "-1"), "--port = -1: must be"),
        (("--limit", "0"), "--limit = 0.0: must be a number from 1 to 86400 s"),
        (("--limit", "nan"), "s; the number must be finite"),
        (("none.toml",), "cannot be read: No such file"),
        (("bad.toml",), "striker.velocity = -3"),
        (("text.toml",), "is not valid TOML"),
    ],
)
def test_bad_input_is_one_line(arguments, message, thesis_impact, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = re.sub("velocity = .*", "velocity = -3", to_toml(thesis_impact))
    Path("bad.toml").write_text(text, encoding="utf-8")
    Path("text.toml").write_text("kind = [", encoding="utf-8")
    assert run(["app", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_without_panel_it_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setattr("workbench.extras.app.find_spec", lambda name: None)
    assert run(["app"]) == 2
    text = "workbench app: needs panel, which is not installed; "
    text += "pip install 'steel-impact-workbench[app]'"
    assert capsys.readouterr().err == f"workbench: {text}\n"


def test_a_port_that_is_taken_is_one_line(capsys):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert run(["app", "--port", str(port)]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"workbench: --port = {port}: cannot be listened at: Address already")
    assert error.count("\n") == 1


@thorough
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_when_it_is_told_to(number, thesis_impact, tmp_path):
    file = tmp_path / "scenario.toml"
    file.write_text(to_toml(thesis_impact), encoding="utf-8")
    with Served(str(file), "--port", "0", "--limit", "20") as process:
        asyncio.run(first_message(process, process.token()))  # a session does not hold it up
        assert process.end(number) == ""


@thorough
def test_the_usual_port_gives_way_to_one_that_is_free():
    with Served() as first, Served() as second:
        assert first.port != second.port != 4243
        assert second.ask()[0] == 200
        assert (first.end(), second.end()) == ("", "")


@thorough
def test_it_opens_the_browser_and_goes_on_where_there_is_none(tmp_path):
    program, opened = tmp_path / "browser", tmp_path / "opened"
    program.write_text(f'#!/bin/sh\nprintf %s "$1" > {opened}.new && mv {opened}.new {opened}\n')
    program.chmod(0o755)
    with Served("--port", "0", BROWSER=str(program)) as process:
        for _ in range(100):
            if opened.exists():
                break
            threading.Event().wait(0.1)
        assert opened.read_text() == process.address
        assert process.end() == ""
    with Served("--port", "0", PATH=str(tmp_path), BROWSER="") as process:
        assert process.ask()[0] == 200
        assert process.end() == ""


@thorough
def test_every_answer_has_headers_that_guard_it(served):
    for path, status in (
        ("/", 200),
        ("/static/js/bokeh.min.js", 200),
        ("/static/none.js", 404),
        ("/favicon.ico", 200),
        ("/none", 404),
    ):
        got, headers, _ = served.ask(path)
        assert got == status, path
        assert headers["x-frame-options"] == "DENY"
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "no-referrer"
        assert headers["cross-origin-resource-policy"] == "same-origin"
        assert headers["cross-origin-opener-policy"] == "same-origin"
        policy = headers["content-security-policy"]
        assert "script-src 'self' blob: 'unsafe-eval' 'nonce-" in policy
        assert "NONCE" not in policy
        assert "access-control-allow-origin" not in headers
    nonces = {served.ask()[1]["content-security-policy"] for _ in range(3)}
    assert len(nonces) == 3


REFUSED = (403, 400)  # the second by tornado: no HTTP
FOREIGN = {
    "a name that leads here": {"Host": "evil.example"},
    "that with our port": {"Host": "evil.example:{port}"},
    "the right name at another port": {"Host": "127.0.0.1:1"},
    "a name that begins as ours": {"Host": "127.0.0.1.evil.example:{port}"},
    "a user of that name": {"Host": "127.0.0.1:{port}@evil.example"},
    "another address of this machine": {"Host": "0.0.0.0:{port}"},
    "no name": {"Host": ""},
    "a page of another place": {"Origin": "http://evil.example"},
    "a page of another port": {"Origin": "http://127.0.0.1:1"},
    "a page without a place": {"Origin": "null"},
    "a page in another scheme": {"Origin": "https://127.0.0.1:{port}"},
    "an image elsewhere": {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Dest": "image"},
    "a frame elsewhere": {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Dest": "iframe"},
    "a script of another port": {"Sec_Fetch_Site": "same-site", "Sec_Fetch_Dest": "script"},
}


@thorough
@pytest.mark.parametrize("who", FOREIGN)
def test_pages_of_other_places_are_refused_by_every_handler(served, who):
    headers = {name: value.format(port=served.port) for name, value in FOREIGN[who].items()}
    for path in ("/", "/static/js/bokeh.min.js", "/favicon.ico", "/ws", "/autoload.js", "/none"):
        status, _, text = served.ask(path, **headers)
        assert status in REFUSED, path
        assert status == 400 or re.fullmatch(r"[A-Z][^<>]+\.", text)
    assert served.upgrade(served.token(), **headers) in REFUSED


@thorough
def test_two_hosts_and_two_origins_are_refused(served):
    name = f"127.0.0.1:{served.port}"
    for extra in ("Host: evil.example", "Origin: http://evil.example"):
        lines = f"GET / HTTP/1.1\r\nHost: {name}\r\nOrigin: http://{name}\r\n{extra}\r\n"
        status, _, _ = served.raw(f"{lines}Connection: close\r\n\r\n")
        assert status in REFUSED


@thorough
def test_own_pages_and_links_to_the_page_are_answered(served):
    for name in (
        f"127.0.0.1:{served.port}",
        f"localhost:{served.port}",
        f"LOCALHOST:{served.port}",
    ):
        assert served.ask(Host=name)[0] == 200
        assert served.ask("/static/js/bokeh.min.js", Origin=f"http://{name.lower()}")[0] == 200
    link = {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Dest": "document"}
    assert served.ask("/?state=of+a+link", **link)[0] == 200
    assert served.ask("/static/js/bokeh.min.js", **link)[0] == 403
    assert served.upgrade(served.token()) == 101


@thorough
def test_nothing_but_the_page_and_its_files_is_served(served):
    outside = ("/components/antigravity/a/_css/b", "/autoload.js", "/metadata")
    for path in (*outside, "/rest/session_info", "/admin", "//", "/ws/"):
        assert served.ask(path)[0] == 404, path
    for path in (
        "/static/../ws/..",
        "/static/../../server.toml",
        "/static/%2e%2e/%2e%2e/tornado.py",
        "/static//etc",
    ):
        assert served.ask(path)[0] in (403, 404), path
    for method in ("POST", "PUT", "DELETE", "OPTIONS"):
        assert served.ask(method=method)[0] == 405
    assert served.ask(method="POST", Content_Length="100000")[0] in (0, 400)
    assert served.ask(X_Large="x" * 40_000)[0] in (0, 400)
    assert served.ask(f"/?{'x' * 8000}")[0] == 200


@thorough
def test_only_this_machine_reaches_it(served):
    own = {each[4][0] for each in socket.getaddrinfo(socket.gethostname(), 0, socket.AF_INET)}
    for address in own | {"127.0.0.2"}:
        if address != "127.0.0.1":
            with pytest.raises(ConnectionRefusedError):
                socket.create_connection((address, served.port), timeout=5).close()


async def first_message(server: Served, token: str, then: str = "") -> str | None:
    """First message of a websocket, which must have ended after `then`; None where it is ended."""
    connection = await websocket_connect(
        f"ws://127.0.0.1:{server.port}/ws", subprotocols=["bokeh", token]
    )
    first = await asyncio.wait_for(connection.read_message(), 20)
    if then:
        with suppress(WebSocketClosedError):
            await connection.write_message(then)
    elif first:
        connection.close()
    while first and await asyncio.wait_for(connection.read_message(), 20) is not None:
        pass
    connection.close()
    return first


@thorough
def test_a_session_needs_a_token_that_the_server_signed(served):
    token = served.token()
    assert "ACK" in asyncio.run(first_message(served, token))
    payload, _, signature = token.rpartition(".")
    for wrong in (f"{payload}.{signature[::-1]}", payload, "nothing"):
        assert asyncio.run(first_message(served, wrong)) is None
    assert served.ask("/?bokeh-session-id=mine")[0] == 403


@thorough
def test_a_message_that_is_too_large_ends_its_connection_only(served):
    assert "ACK" in asyncio.run(first_message(served, served.token(), "x" * 8_000_000))
    assert served.ask()[0] == 200


@thorough
def test_pages_are_counted_and_forgotten():
    limits = ("most_sessions=3", "unused_session_lifetime_milliseconds=500")
    with Served(
        "--port", "0", limits=(*limits, "check_unused_sessions_milliseconds=200")
    ) as process:
        assert [process.ask()[0] for _ in range(4)] == [200, 200, 200, 503]
        status, _, text = process.ask()
        assert (status, text) == (503, "Too many pages are open: close some and wait two minutes.")
        assert process.ask("/favicon.ico")[0] == 200
        for _ in range(100):
            if process.ask()[0] == 200:
                break
            threading.Event().wait(0.1)
        else:
            pytest.fail("sessions do not end")
        assert process.end() == ""


@thorough
def test_an_error_is_on_the_page_and_one_line_on_the_terminal(thesis_impact, tmp_path):
    file = tmp_path / "scenario.toml"
    file.write_text(to_toml(thesis_impact.changed(name="breaks")), encoding="utf-8")
    with Served(str(file), "--port", "0") as process:
        with Chromium() as browser:
            tab = browser.tab(process.address)
            tab.wait("deepText('pre, div', 'The page cannot be made: ValueError: <i>no page</i>')")
            assert tab.js("deep('i')") is None
        assert process.end() == "workbench: ValueError: <i>no page</i>\n"


# What follows needs a browser.


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    names = ("evil.example",)
    with Chromium(tmp_path_factory.mktemp("downloads"), names) as opened:
        yield opened


@pytest.fixture
def tab(served, browser):
    opened = browser.tab(served.address)
    opened.wait("deepText('pre', 'counted 0')")
    yield opened
    opened.close()


@thorough
def test_all_that_a_page_needs_comes_from_this_machine(served, tab):
    own = (served.address, served.address.replace("http", "ws"))
    assert len(tab.requests) > 5
    assert [each for each in tab.requests if not each.startswith(own)] == []
    for address, _, headers in tab.responses:
        assert headers["x-content-type-options"] == "nosniff", address


@thorough
def test_scripts_that_stand_in_texts_do_not_run(tab):
    tab.wait("deepAll('b').length === 2")  # the texts are there
    assert tab.js("window.hacked ?? null") is None
    blocked = [text for text in tab.errors if "violates the following Content Security" in text]
    assert any("inline event handler" in text for text in blocked)
    others = [text for text in tab.errors if text not in blocked and "none.png" not in text]
    assert others == []


@thorough
def test_components_pictures_and_downloads_work_under_the_policy(browser, tab):
    tab.click("deepText('button', 'count')")
    tab.wait("deepText('pre', 'counted 1')")
    assert tab.js("deepAll('canvas').some((each) => each.width > 200)")
    tab.click("deepText('a', 'kept.txt')")
    (kept,) = browser.downloaded()
    assert kept.read_text(encoding="utf-8") == "kept"


@thorough
def test_tabs_have_a_state_each_and_a_reload_a_new_one(served, browser, tab):
    second = browser.tab(served.address)
    second.wait("deepText('pre', 'counted 0')")
    for count in ("1", "2"):
        tab.click("deepText('button', 'count')")
        tab.wait(f"deepText('pre', 'counted {count}')")
    assert second.js("deepText('pre', 'counted 0') !== null")
    tab.reload()
    tab.wait("deepText('pre', 'counted 0')")
    second.click("deepText('button', 'count')")
    second.wait("deepText('pre', 'counted 1')")
    second.close()


@thorough
def test_a_file_of_5_mb_is_read_and_a_larger_one_refused_in_words(tab, tmp_path):
    largest, larger = tmp_path / "largest.csv", tmp_path / "larger.csv"
    largest.write_bytes(b"x" * 5_000_000)
    larger.write_bytes(b"x" * 5_000_001)
    tab.files("input[type=file]", largest)
    tab.wait("deepText('pre', 'read 5000000 bytes')")
    tab.files("input[type=file]", larger)
    tab.wait("deepText('pre', 'read 0 bytes')")
    assert tab.dialogs == ["A file must not exceed 5 MB: is this the right one?"]
    tab.click("deepText('button', 'count')")  # the connection holds
    tab.wait("deepText('pre', 'counted 1')")


@thorough
def test_an_error_of_a_callback_is_on_the_page_as_text(tab):
    for _ in range(4):  # a click on a page that is still being wired is lost, as a person's
        tab.click("deepText('button', 'fail')")
        with suppress(DevToolsError):
            tab.wait("deepText('*', 'TypeError: list indices')", 15)
            break
    tab.wait("deepText('*', 'TypeError: list indices')", 1)
    assert tab.js("deepAll('b').length") == 2  # no third one in the message
    assert tab.js("window.hacked ?? null") is None


@thorough
def test_a_link_opens_its_state(served, browser):
    opened = browser.tab(f"{served.address}?s=linked")
    opened.wait("deepText('pre', 'linked, counted 0')")
    opened.close()


@thorough
def test_a_page_says_that_its_server_has_gone(browser):
    with Served("--port", "0") as process:
        opened = browser.tab(process.address)
        opened.wait("deepText('pre', 'counted 0')")
        assert process.end() == ""
        opened.wait("deepText('*', 'The connection is lost. Reload the page')")
        opened.close()


@thorough
def test_a_name_that_leads_here_shows_nothing(served, browser):
    opened = browser.tab(f"http://evil.example:{served.port}/")
    assert opened.js("document.body.textContent").startswith("This server answers to its own name")
    opened.close()


ATTACK = """<!DOCTYPE html><a href="ADDRESS">a link</a><script>
const told = {};
const noted = (name) => new Promise((done) => { told[name] = (text) => done([name, text]); });
const waits = ["image", "script", "socket", "fetch", "post"].map(noted);
const put = (name, element) => {
  element.onload = () => told[name]("let in");
  element.onerror = () => told[name]("refused");
  document.body.append(element);
};
addEventListener("load", () => {
  put("image", Object.assign(new Image(), {src: "ADDRESSfavicon.ico"}));
  put("script", Object.assign(document.createElement("script"), {src: "ADDRESSautoload.js"}));
  const frame = document.createElement("iframe");
  frame.src = "ADDRESS";
  document.body.append(frame);
  const socket = new WebSocket("ADDRESSws".replace("http", "ws"), ["bokeh", "TOKEN"]);
  socket.onopen = () => told.socket("let in");
  socket.onerror = () => told.socket("refused");
  fetch("ADDRESS").then(() => told.fetch("let in"), () => told.fetch("refused"));
  fetch("ADDRESS", {method: "POST", mode: "no-cors", body: "x"}).then(
    () => told.post("sent, not read"), () => told.post("refused"));
});
window.all = Promise.all(waits).then(Object.fromEntries);
</script>"""


@thorough
def test_a_page_of_another_place_gets_nothing_but_a_link(served, browser):
    page = ATTACK.replace("ADDRESS", served.address).replace("TOKEN", served.token())
    with other_server(page) as address:
        opened = browser.tab(address)
        found = opened.js("window.all")
        assert found.pop("post") in ("refused", "sent, not read")
        assert set(found.values()) == {"refused"}
        got = {
            (url, status) for url, status, _ in opened.responses if url.startswith(served.address)
        }
        assert {status for _, status in got} <= {403, 405}
        opened.click("a")
        opened.wait("deepText('pre', 'counted 0')")
        opened.close()
