"""Program of the tests: the command line with a page that stands in for that of the workbench.

python stand_in.py [NAME=VALUE of a limit of the server ...] app [arguments of the verb]
"""

from __future__ import annotations

import io
import subprocess
import sys
from types import ModuleType
from typing import Any

import panel as pn
import param
from bokeh.plotting import figure
from panel.custom import JSComponent

from workbench.cli import main
from workbench.extras.app import server

HOSTILE = """<b>bold</b><img src="static/none.png" onerror="window.hacked = 'handler'">
<script>window.hacked = 'script'</script>"""


class Counter(JSComponent):
    """A component of its own script."""

    value = param.Integer(0)
    _esm = """export function render({ model, el }) {
      const button = document.createElement("button");
      button.textContent = "count";
      button.onclick = () => { model.value += 1; };
      el.append(button);
    }"""


class Desk:
    """A desk with a process, as the worker processes of the page."""

    def __init__(self, limit: float) -> None:
        code = "import sys; sys.stdin.read()"
        self.process = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE)
        print("limit", limit, "child", self.process.pid, file=sys.stderr, flush=True)

    def close(self) -> None:
        self.process.communicate()


class ExplorerPage:
    """Widgets of all kinds that a page needs."""

    def __init__(self, tables: Any, desk: Desk, link: str) -> None:
        self.name = link or (tables or {"name": "nothing"})["name"]

    def view(self) -> Any:
        if self.name == "breaks":
            raise ValueError("<i>no page</i>")
        counter = Counter()
        plot = figure(width=300, height=200)
        plot.line([1, 2, 3], [1, 4, 2])
        file = pn.widgets.FileInput()
        fail = pn.widgets.Button(name="fail")
        fail.on_click(lambda _: [][HOSTILE])
        kept = pn.widgets.FileDownload(callback=lambda: io.BytesIO(b"kept"), filename="kept.txt")
        said = pn.bind(lambda v: f"{self.name}, counted {v}", counter.param.value)
        read = pn.bind(lambda v: f"read {len(v or b'')} bytes", file)
        hostile = pn.pane.HTML(HOSTILE), pn.pane.Markdown(HOSTILE)
        parts = counter, pn.pane.Str(said), plot, file, pn.pane.Str(read), fail, kept, *hostile
        return pn.Column(*parts)


if __name__ == "__main__":
    for name, kind in (("desk", Desk), ("page", ExplorerPage)):
        module = ModuleType(f"workbench.extras.app.{name}")
        setattr(module, kind.__name__, kind)
        sys.modules[module.__name__] = module
    begin = sys.argv.index("app")
    for limit in sys.argv[1:begin]:
        key, _, number = limit.partition("=")
        table = server.LIMITS if key in server.LIMITS else server.LIMITS["sessions"]
        table[key] = type(table[key])(number)  # of a limit that there is
    main(sys.argv[begin:])
