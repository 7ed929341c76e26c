"""Headless Chromium, driven over its DevTools protocol by plain calls, as a person would use it.

    with Chromium() as browser:
        tab = browser.tab("http://127.0.0.1:8000/", width=390)
        tab.wait("deep('input[type=number]')")
        tab.fill("input[type=number]", "15")
        tab.click("button.save")
        assert tab.errors == []

Expressions of JavaScript find elements inside open shadow roots by `deep(selector)`, all of them by
`deepAll(selector)`, one that holds a text by `deepText(selector, text)`. The methods of a tab that
take a selector take the first that `deep` finds, or such an expression.
"""

from __future__ import annotations

import asyncio
import itertools
import json
import os
import shutil
import signal
import subprocess
import threading
from base64 import b64decode
from collections.abc import Coroutine, Mapping
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic, sleep
from typing import Any

import pytest
from tornado.websocket import WebSocketClientConnection, websocket_connect

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
PATIENCE = 30.0  # s that anything may take
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"),
    *("--enable-unsafe-swiftshader",),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--disable-extensions", "--disable-default-apps", "--mute-audio", "--hide-scrollbars"),
    # in the background, too, since tests look at several tabs
    *("--disable-renderer-backgrounding", "--disable-background-timer-throttling"),
    "--disable-backgrounding-occluded-windows",
)
FINDERS = """
window.deepAll = (selector, root = document) => {
  const found = [...root.querySelectorAll(selector)];
  for (const each of root.querySelectorAll("*"))
    if (each.shadowRoot) found.push(...deepAll(selector, each.shadowRoot));
  return found;
};
window.deep = (selector) => deepAll(selector)[0] ?? null;
window.deepText = (selector, text) =>
  deepAll(selector).find((each) => each.textContent.includes(text)) ?? null;
"""
KEYS = {  # code and number of keys that are no letter
    **{"Tab": ("Tab", 9), "Enter": ("Enter", 13), "Escape": ("Escape", 27), " ": ("Space", 32)},
    **{"PageUp": ("PageUp", 33), "PageDown": ("PageDown", 34), "End": ("End", 35)},
    **{"Home": ("Home", 36), "ArrowLeft": ("ArrowLeft", 37), "ArrowUp": ("ArrowUp", 38)},
    **{"ArrowRight": ("ArrowRight", 39), "ArrowDown": ("ArrowDown", 40)},
    **{"Backspace": ("Backspace", 8), "Delete": ("Delete", 46)},
}
TEXTS = {"Enter": "\r", " ": " "}
ALT, CONTROL, SHIFT = 1, 2, 8  # modifiers, to be added


def browser_program() -> str:
    """Path of the browser; skips the test where there is none."""
    wanted = os.environ.get("WORKBENCH_BROWSER", "")
    result = next(filter(None, map(shutil.which, [wanted] if wanted else BROWSERS)), None)
    if result is None:
        pytest.skip("no chromium or chrome: set WORKBENCH_BROWSER to one")
    return result


class DevToolsError(AssertionError):
    """A call that the browser refused, an exception in the page, or a condition that never held."""


class Tab:
    """A page that is open.

    `errors` are the texts of exceptions, errors and warnings of its console, violations of its
    policy and failed loads; `requests` the addresses that it asked for, those of websockets, too;
    `responses` (address, status, headers in lower case); `dialogs` the texts of alerts, which are
    accepted.
    """

    def __init__(self, browser: Chromium, target: str, session: str) -> None:
        self.browser, self.target, self.session = browser, target, session
        self.errors: list[str] = []
        self.requests: list[str] = []
        self.dialogs: list[str] = []
        self.responses: list[tuple[str, int, dict[str, str]]] = []

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Result of a method of the protocol, asked of this tab."""
        return self.browser.call(method, self.session, **parameters)

    def note(self, method: str, told: Mapping[str, Any]) -> None:
        """Keep what an event of the protocol tells."""
        if method == "Runtime.exceptionThrown":
            details = told["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description") or details["text"])
        elif method == "Runtime.consoleAPICalled" and told["type"] in (
            "error",
            "warning",
            "assert",
        ):
            said = (each.get("value", each.get("description", "")) for each in told["args"])
            self.errors.append(" ".join(map(str, said)))
        elif method == "Log.entryAdded" and told["entry"]["level"] in ("error", "warning"):
            entry = told["entry"]
            self.errors.append(f"{entry['text']} {entry.get('url', '')}".strip())
        elif method == "Network.requestWillBeSent":
            address = told["request"]["url"]
            self.requests += [] if address.startswith(("data:", "blob:")) else [address]
        elif method == "Network.webSocketCreated":
            self.requests.append(told["url"])
        elif method == "Network.responseReceived" and told["response"]["url"].startswith("http"):
            answer = told["response"]
            headers = {name.lower(): value for name, value in answer["headers"].items()}
            self.responses.append((answer["url"], answer["status"], headers))
        elif method == "Page.javascriptDialogOpening":
            self.dialogs.append(told["message"])
            self.browser.post("Page.handleJavaScriptDialog", self.session, accept=True)

    def js(self, expression: str) -> Any:
        """Value of an expression, of a promise what it comes to. Raises `DevToolsError`."""
        options = {"awaitPromise": True, "returnByValue": True, "userGesture": True}
        told = self.call("Runtime.evaluate", expression=expression, **options)
        return self._checked(told, expression).get("value")

    def wait(self, condition: str, seconds: float = PATIENCE) -> Any:
        """Value of an expression once it is true. Raises `DevToolsError` when it never was."""
        end = monotonic() + seconds
        while True:
            with suppress(DevToolsError):  # of a page that is being loaded
                if value := self.js(
                    f"(() => {{ const v = {condition}; return v instanceof Node ? true : v; }})()"
                ):
                    return value
            if monotonic() > end:
                raise DevToolsError(f"not within {seconds:g} s: {condition}; {self.errors}")
            sleep(0.02)

    def go(self, address: str) -> None:
        """Open an address and wait until it is loaded. Raises `DevToolsError`."""
        told = self.call("Page.navigate", url=address)
        if problem := told.get("errorText"):
            raise DevToolsError(f"{address}: {problem}")
        self.wait("document.readyState === 'complete'")

    def reload(self) -> None:
        """Load the page again and wait until it is."""
        self.js("window.isOld = true")
        self.call("Page.reload")
        self.wait("!window.isOld && document.readyState === 'complete'")

    def click(self, selector: str) -> None:
        """Click with the mouse on the middle of an element."""
        place = self._at(
            selector,
            "function () { this.scrollIntoView({block: 'center'}); const r ="
            " this.getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; }",
        )
        if not place[2] * place[3]:
            raise DevToolsError(f"{selector} is not to be seen")
        x, y = place[0] + place[2] / 2.0, place[1] + place[3] / 2.0
        for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
            one = {} if kind == "mouseMoved" else {"button": "left", "clickCount": 1}
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **one)

    def type(self, text: str) -> None:
        """Enter a text where the focus is."""
        self.call("Input.insertText", text=text)

    def press(self, key: str, modifiers: int = 0) -> None:
        """Press a key, by its name (`Tab`, `ArrowUp`, `a`), where the focus is."""
        code, number = KEYS.get(key, (f"Key{key.upper()}", ord(key[0].upper())))
        text = TEXTS.get(key, key if len(key) == 1 else "")
        common = {"key": key, "code": code, "windowsVirtualKeyCode": number, "modifiers": modifiers}
        kind = "keyDown" if text and not modifiers & ~SHIFT else "rawKeyDown"
        told = {"text": text} if kind == "keyDown" else {}
        self.call("Input.dispatchKeyEvent", type=kind, **common, **told)
        self.call("Input.dispatchKeyEvent", type="keyUp", **common)

    def fill(self, selector: str, text: str, key: str = "Enter") -> None:
        """Put a text into a field in place of what is there, and press a key after it."""
        self._at(
            selector,
            "function () { this.scrollIntoView({block: 'center'}); this.focus();"
            " this.select?.(); }",
        )
        self.type(text)
        if key:
            self.press(key)

    def files(self, selector: str, *paths: Path) -> None:
        """Choose files in an input of files."""
        handle = self._handle(selector)
        self.call("DOM.setFileInputFiles", files=[str(path) for path in paths], objectId=handle)

    def size(self, width: int, height: int = 900) -> None:
        """Give the page a size in px."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.call("Emulation.setDeviceMetricsOverride", **size)

    def tree(self) -> list[dict[str, Any]]:
        """What a screen reader gets: role, name, value and properties of each node, in order."""
        nodes = self.call("Accessibility.getFullAXTree")["nodes"]
        read = []
        for node in nodes:
            if not node.get("ignored"):
                row = {key: node.get(key, {}).get("value", "") for key in ("role", "name", "value")}
                row.update({p["name"]: p["value"].get("value") for p in node.get("properties", ())})
                read.append(row)
        return read

    def screenshot(self, path: Path, whole: bool = False) -> Path:
        """Write a PNG of what is seen, or of the whole page."""
        told = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(b64decode(told["data"]))
        return path

    def close(self) -> None:
        """Close the tab as a person does."""
        self.browser.call("Target.closeTarget", targetId=self.target)

    def _checked(self, told: Mapping[str, Any], what: str) -> dict[str, Any]:
        if details := told.get("exceptionDetails"):
            text = details.get("exception", {}).get("description") or details["text"]
            raise DevToolsError(f"{what}: {text}")
        result: dict[str, Any] = told["result"]
        return result

    def _handle(self, selector: str) -> str:
        found = selector if selector.startswith(("deep", "document")) else None
        expression = found or f"deep({json.dumps(selector)})"
        self.wait(expression)
        told = self.call("Runtime.evaluate", expression=expression)
        return str(self._checked(told, expression)["objectId"])

    def _at(self, selector: str, function: str) -> Any:
        """Value of a function of an element."""
        handle, options = self._handle(selector), {"returnByValue": True, "userGesture": True}
        told = self.call(
            "Runtime.callFunctionOn", objectId=handle, functionDeclaration=function, **options
        )
        return self._checked(told, selector).get("value")


class Chromium:
    """A browser with a profile of its own, without a way to any place but this machine.

    `names` are hosts that it takes for 127.0.0.1; downloads go to the directory `downloads`.
    `process` and `profile` are its own. Skips the test where no browser is installed.
    """

    def __init__(self, downloads: Path | None = None, names: tuple[str, ...] = ()) -> None:
        program = browser_program()
        self.downloads, self._tabs, self._numbers = downloads, dict[str, Tab](), itertools.count(1)
        self._replies: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._suggested: dict[str, str] = {}
        self._finished: list[str] = []
        self.profile = TemporaryDirectory(prefix="chromium", ignore_cleanup_errors=True)
        rules = [*(f"MAP {name} 127.0.0.1" for name in names), "MAP * ~NOTFOUND"]
        command = [program, *FLAGS, f"--user-data-dir={self.profile.name}"]
        command.append(f"--host-resolver-rules={', '.join(rules)}, EXCLUDE 127.0.0.1")
        command += ["--remote-debugging-port=0", "about:blank"]
        silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.process = subprocess.Popen(command, start_new_session=True, **silent)  # type: ignore
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        try:
            self._connection = self._run(self._connect())
        except BaseException:
            self._end()
            raise
        if downloads is not None:
            where = {"behavior": "allow", "downloadPath": str(downloads), "eventsEnabled": True}
            self.call("Browser.setDownloadBehavior", **where)

    def __enter__(self) -> Chromium:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def tab(self, address: str = "", width: int = 1400, height: int = 900) -> Tab:
        """A new tab of a size in px, at an address that is loaded."""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        told = self.call("Target.attachToTarget", targetId=target, flatten=True)
        tab = self._tabs[told["sessionId"]] = Tab(self, target, told["sessionId"])
        for domain in ("Page", "Runtime", "Log", "Network", "DOM", "Accessibility"):
            tab.call(f"{domain}.enable")
        tab.call("Page.addScriptToEvaluateOnNewDocument", source=FINDERS)
        tab.call("Emulation.setFocusEmulationEnabled", enabled=True)  # in several tabs at a time
        tab.size(width, height)
        if address:
            tab.go(address)
        return tab

    def downloaded(self, count: int = 1, seconds: float = PATIENCE) -> list[Path]:
        """Files that were downloaded so far, once there are as many. Raises `DevToolsError`."""
        assert self.downloads is not None
        end = monotonic() + seconds
        while len(self._finished) < count:
            if monotonic() > end:
                raise DevToolsError(f"{len(self._finished)} downloads in {seconds:g} s")
            sleep(0.02)
        return [self.downloads / self._suggested[each] for each in self._finished]

    def call(self, method: str, session: str = "", **parameters: Any) -> dict[str, Any]:
        """Result of a method of the protocol. Raises `DevToolsError`."""
        told = self._run(self._ask(method, session, parameters))
        if "error" in told:
            raise DevToolsError(f"{method}: {told['error']['message']}")
        result: dict[str, Any] = told["result"]
        return result

    def post(self, method: str, session: str = "", **parameters: Any) -> None:
        """Ask without waiting, from where events are read."""
        self._running = asyncio.ensure_future(self._ask(method, session, parameters))

    def close(self) -> None:
        """Close all tabs and the browser."""
        with suppress(DevToolsError, TimeoutError):
            self.call("Browser.close")
        with suppress(subprocess.TimeoutExpired):
            self.process.wait(5.0)
        self._end()

    def _run(self, task: Coroutine[Any, Any, Any]) -> Any:
        return asyncio.run_coroutine_threadsafe(task, self._loop).result(2.0 * PATIENCE)

    async def _connect(self) -> WebSocketClientConnection:
        noted, end = Path(self.profile.name, "DevToolsActivePort"), monotonic() + PATIENCE
        while not (noted.is_file() and noted.read_text().count("\n")):
            if self.process.poll() is not None or monotonic() > end:
                raise DevToolsError(f"the browser did not start: {self.process.poll()}")
            await asyncio.sleep(0.02)
        port, path = noted.read_text().splitlines()[:2]
        address = f"ws://127.0.0.1:{port}{path}"
        connection = await websocket_connect(address, max_message_size=500_000_000)
        self._reader = asyncio.ensure_future(self._read(connection))
        return connection

    async def _read(self, connection: WebSocketClientConnection) -> None:
        while (text := await connection.read_message()) is not None:
            told = json.loads(text)
            reply = self._replies.pop(told.get("id"), None)
            if reply is not None and not reply.done():
                reply.set_result(told)
            elif "method" in told:
                self._note(told["method"], told.get("sessionId", ""), told["params"])
        for reply in self._replies.values():
            if not reply.done():
                reply.set_result({"error": {"message": "the browser has gone"}})
        self._replies.clear()

    def _note(self, method: str, session: str, told: Mapping[str, Any]) -> None:
        if method == "Browser.downloadWillBegin":
            self._suggested[told["guid"]] = told["suggestedFilename"]
        elif method == "Browser.downloadProgress" and told["state"] == "completed":
            self._finished.append(told["guid"])
        elif session in self._tabs:
            self._tabs[session].note(method, told)

    async def _ask(self, method: str, session: str, parameters: Any) -> dict[str, Any]:
        number = next(self._numbers)
        asked = {"id": number, "method": method, "params": parameters}
        reply = self._replies[number] = self._loop.create_future()
        await self._connection.write_message(
            json.dumps({**asked, "sessionId": session} if session else asked)
        )
        return await asyncio.wait_for(reply, PATIENCE)

    def _end(self) -> None:
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)  # the group that was started here
        self.process.wait()
        self._run(self._finish())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()
        self.profile.cleanup()

    async def _finish(self) -> None:
        with suppress(AttributeError):  # never connected
            self._connection.close()
        others = asyncio.all_tasks() - {asyncio.current_task()}
        if others:
            await asyncio.wait(others, timeout=2.0)
        for task in others:
            task.cancel()
