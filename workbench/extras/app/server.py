"""Server of the page: for browsers of this machine, and for pages that it has made itself.

Pages of other places may reach it through a browser by a name that leads here (DNS rebinding), by
requests of their own, in a frame: all are refused. `server.toml` holds limits and headers.
"""

import logging
import re
import signal
import sys
import tomllib
from collections.abc import Callable
from html import escape
from pathlib import Path
from secrets import token_bytes, token_urlsafe
from socket import socket
from typing import Any

import panel
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from panel.io.application import Application, build_applications
from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop
from tornado.web import OutputTransform, RequestHandler

from workbench.base.errors import message_of, one_line

ADDRESS = "127.0.0.1"
LIMITS = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
_CHECK = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")


class PageServer(BokehTornado):  # type: ignore[misc]
    """Pages of what `make_page` gives, one for each tab, and no way to them for others."""

    def __init__(self, make_page: Callable[[], Any], port: int) -> None:
        def page() -> Any:
            try:
                return make_page()
            except Exception as error:
                return panel.pane.Str(f"The page cannot be made: {_tell(error)}")

        self.names = [f"{ADDRESS}:{port}", f"localhost:{port}"]
        signed = {"sign_sessions": True, "secret_key": token_bytes(32)}  # else anyone makes some
        options = {"extra_websocket_origins": self.names, "log_function": lambda handler: None}
        (made,) = build_applications(page, title="Steel impact workbench").values()
        super().__init__({"/": _AtOnce(*made.handlers)}, **signed, **options, **LIMITS["sessions"])
        self.add_transform(_Guarded)

    def find_handler(self, request: Any, **options: Any) -> Any:
        """Find the handler of a request, or of its refusal."""
        refusal = LIMITS["refusals"].get(self._refusal(request.headers, request.path))
        if refusal is None:
            return super().find_handler(request, **options)
        return self.get_handler_delegate(request, _Refused, refusal)

    def _refusal(self, headers: Any, path: str) -> str:
        if [host.lower() in self.names for host in headers.get_list("Host")] != [True]:
            return "name"
        visit = path == "/" and headers.get("Sec-Fetch-Dest") == "document"  # by a link
        own = visit or headers.get("Sec-Fetch-Site", "none") in ("none", "same-origin")
        origins = [each.removeprefix("http://") for each in headers.get_list("Origin")]
        if not own or set(origins) - set(self.names):
            return "foreign"
        if not re.fullmatch(LIMITS["served"], path):
            return "nothing"
        (context,) = self.applications.values()
        is_full = path == "/" and len(list(context.sessions)) >= LIMITS["most_sessions"]
        return "full" if is_full else ""


class _AtOnce(Application):  # type: ignore[misc]
    """Pages whose parts are counted once, not again with each of them: half as long to make."""

    def initialize_document(self, document: Any) -> None:
        """Fill the document of a session."""
        with document.models.freeze():
            super().initialize_document(document)


class _Refused(RequestHandler):
    """Answer of one plain sentence."""

    def initialize(self, status: int, reason: str) -> None:
        self.set_status(status)
        self.reason = reason

    def prepare(self) -> None:
        self.finish(self.reason)


class _Guarded(OutputTransform):
    """Headers of all answers; scripts that stand in a page are those of the server."""

    def transform_first_chunk(self, status: int, headers: Any, chunk: bytes, _: bool) -> Any:
        nonce = token_urlsafe(16)
        if b"</head>" in chunk:
            chunk = chunk.replace(b"</head>", f"<script>{_CHECK}</script></head>".encode(), 1)
            chunk = chunk.replace(b"<script", f'<script nonce="{nonce}"'.encode())
            headers["Content-Length"] = str(len(chunk))
        for name, value in LIMITS["headers"].items():
            headers[name] = value.strip().replace("NONCE", nonce)
        return status, headers, chunk


class _OneLine(logging.Handler):
    """Errors on the error stream, a line each."""

    def emit(self, record: logging.LogRecord) -> None:
        error = record.exc_info and record.exc_info[1]
        text = message_of(error) if error else record.getMessage()
        print(f"workbench: {one_line(text, 500)}", file=sys.stderr, flush=True)


def _tell(error: BaseException) -> str:
    """Show an error that nothing else has caught, on the page and on the terminal; its HTML."""
    logging.getLogger("panel").error("error", exc_info=error)
    text = escape(message_of(error))
    if panel.state.notifications:
        panel.state.notifications.error(text, duration=0)
    return text


def serve(make_page: Callable[[], Any], listener: socket, begun: Callable[[], Any]) -> None:
    """Serve pages until Ctrl-C or SIGTERM.

    Arguments: `make_page` gives what Panel shows, for each tab of a browser; `listener`, a socket
    at ADDRESS; `begun` is called once it answers.
    """
    told = {"exception_handler": _tell, "disconnect_notification": LIMITS["lost"]}
    panel.extension(notifications=True, **told)
    for name in ("asyncio", "bokeh", "panel", "tornado"):
        logging.getLogger(name).handlers = [_OneLine(logging.ERROR)]
    port, loop = listener.getsockname()[1], IOLoop.current()
    pages = PageServer(make_page, port)
    front = HTTPServer(pages, **LIMITS["http"])
    listener.setblocking(False)
    front.add_socket(listener)
    server = BaseServer(loop, pages, front)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: loop.add_callback_from_signal(loop.stop))
    server.start()
    loop.add_callback(begun)
    loop.start()
    server.stop()
