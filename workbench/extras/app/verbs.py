"""`workbench app`: the page in a browser."""

import os
import signal
import sys
import webbrowser
from contextlib import closing
from pathlib import Path
from socket import create_server
from threading import Thread
from typing import Annotated, Any

import typer

from workbench.base.errors import InputError
from workbench.cli.output import Answer, option, verb
from workbench.extras.app import check_panel

PORT = 4243  # one for all times, so that links to the page hold
Start = Annotated[str | None, typer.Argument(metavar="SCENARIO.toml", help="Scenario file.")]


@verb
def app(
    scenario: Start = None,
    port: int | None = option(f"Port of the page.  [default: {PORT}, or any that is free]", None),
    no_browser: bool = option("Open no browser.", False, flag="--no-browser"),
    limit: float = option("Seconds that a model may take.", 300.0),
) -> Answer:
    """Open a page that answers as a structure is entered.

    Served by this machine for this machine, until Ctrl-C. Exit status 0, 2 for bad input.
    """
    check_panel("workbench app")
    from workbench.base.datafiles import open_input
    from workbench.base.fields import Number
    from workbench.extras.app.desk import Desk
    from workbench.scenarios.files import LARGEST_FILE

    Number(1.0, 86_400.0, "s").check("--limit", limit)
    Number(0, 65535, integer=True).check("--port", PORT if port is None else port)
    content = b""
    if scenario is not None:
        with open_input(Path(scenario), "scenario file", LARGEST_FILE) as stream:
            content = stream.read()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # as Ctrl-C: the worker ends, too
    with closing(Desk(limit)) as desk:  # its worker begins while the page is imported
        return _served(content, scenario, desk, port, no_browser)


def _served(
    content: bytes, scenario: str | None, desk: Any, port: int | None, no_browser: bool
) -> Answer:
    """Serve the page of a scenario file until it ends."""
    import panel

    from workbench.extras.app.form import read_tables
    from workbench.extras.app.server import ADDRESS, serve

    tables = read_tables(content, scenario) if scenario else None
    try:
        listener = create_server((ADDRESS, PORT if port is None else port))
    except OSError as error:
        if port is not None:
            text = f"cannot be listened at: {os.strerror(error.errno or 0)}"
            raise InputError("--port", port, text, "take another one") from error
        listener = create_server((ADDRESS, 0))

    address = f"http://{ADDRESS}:{listener.getsockname()[1]}/"
    if not no_browser:  # begins while the page is imported; some hold their call until they end
        Thread(target=webbrowser.open, args=(address,), daemon=True).start()
    from workbench.extras.app.page import ExplorerPage

    def begun() -> None:
        print(f"workbench: the page is at {address} until Ctrl-C", file=sys.stderr, flush=True)

    def page() -> Any:
        link = panel.state.session_args.get("s", [b""])[0].decode("latin-1")
        return ExplorerPage(tables, desk, link).view()

    serve(page, listener, begun)
    return Answer({})
