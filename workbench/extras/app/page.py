"""Page of a scenario: what a person changes, what is asked of the desk, what is shown.

Its state is the scenario file and the names of the models that are asked; the link holds both.
"""

from __future__ import annotations

import re
from base64 import b64decode
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial
from html import escape
from pathlib import Path
from threading import RLock
from time import perf_counter
from typing import Any

import panel as pn
import tomli_w
from markupsafe import Markup

from workbench.api.accessor import (
    as_object,
    headline,
    notes_in_words,
    numbers_in_words,
    table_blocks,
)
from workbench.base.errors import InputError
from workbench.extras.app.desk import FILES, FOLLOWING, LIVE, Desk, SmallCurve, trouble
from workbench.extras.app.form import (
    DECLARED,
    LONGEST_LINK,
    FormView,
    ScenarioForm,
    in_other_unit,
    packed,
    read_tables,
    started,
    unpacked,
)
from workbench.extras.app.pictures import Deformed, Dependence, History, fragility_plot
from workbench.report.drawing.shapes import shapes_of
from workbench.report.page.documents import html_of_blocks
from workbench.report.page.markdown import definitions, warnings
from workbench.responses import Response, outcome_of, warnings_of
from workbench.scenarios import Scenario
from workbench.scenarios.files import LARGEST_FILE
from workbench.study.limit import CriticalValue

_HERE = Path(__file__).parent
_PAGE = _HERE / "page.html.jinja"
_STYLE = (_HERE / "parts.css").read_text(encoding="utf-8")
_QUICK, _SLOW = 0.1, 0.3  # s; models that follow the hand, and that do not even if advised
_ADVICE = "the model of the advice"
_MOST_MODELS = 50  # of a link
_IN_SIGHT = 5  # models of the list that are not folded
_PATIENCE, _COMPILING = 1.0, 3.0  # s after which the page says what is at work, and why so long
_ANSWERS = ("answer", "history", "deformed", "instant", "table")  # parts that answers show
_FOLLOWS = {  # an answer: parts of the page, and what they are
    **{"structure": "the picture of the structure", "varied": "the small curves"},
    **{"hinges": "the picture of the hinges", "collapse": "the search of the collapse"},
}
_TITLE = "Steel under impact"


class ExplorerPage:
    """One person's page, in a tab of a browser or in a notebook.

    Arguments: `tables` of a scenario file, with the units of its author (None: a new column);
    `desk`, where the models work; `link`, the text of a link that holds a state.
    """

    def __init__(self, tables: dict[str, Any] | None, desk: Desk, link: str = "") -> None:
        self._desk, self._document, self._location = desk, pn.state.curdoc, pn.state.location
        self.form = ScenarioForm(tables or started(next(iter(DECLARED["kinds"]))))
        self.responses: dict[str, Response] = {}
        self._answered_to: Any = None  # the scenario that the responses are to
        self._chosen: list[str] = []  # models; empty: those that answer at once
        self._quick, self._slow = set[str](), set[str]()
        self._offered: list[tuple[str, str]] = []  # models and what they are
        self._lock = RLock()
        self._told = 0  # the turn that the page shows the answers of
        self._kind, self._turn, self.busy, self._trouble = "", 0, False, ""
        self._waits: dict[str, tuple[float, Future[Any]]] = {}
        self._held: list[Callable[[], None]] | None = []  # what the browser cannot show yet
        self._parts()
        self._reopen(link)
        self._show_form()
        self._ask()
        if self._document is not None:
            pn.state.onload(self._once_loaded)
            pn.state.add_periodic_callback(self._tick, 500)
            pn.state.on_session_destroyed(lambda _: self.stop())

    def _parts(self) -> None:
        """Make the parts of the page, empty."""
        look: dict[str, Any] = {"stylesheets": [_STYLE], "sizing_mode": "stretch_width"}
        self.history, self.deformed = History(), Deformed()
        self.small = {name: Dependence() for name in ("first", "second", "third")}
        plots: dict[str, Any] = {"history": self.history, "deformed": self.deformed, **self.small}
        told = {"form": self.change, "models": self._choose, "time": self._move}
        told |= {"chance": self._probable, "save": self._keep, "tests": self._evaluate}
        texts = ("answer", "state", "kept", "structure", "instant", "table", "varied", "collapse")
        self.shown: dict[str, Any] = {
            **{name: FormView(partial(self.alone, each), **look) for name, each in told.items()},
            **{name: pn.pane.HTML("", **look) for name in (*texts, "hinges", "probable")},
            **{
                n: pn.pane.Bokeh(each.plot, sizing_mode="stretch_width")
                for n, each in plots.items()
            },
            "fragility": pn.Column(sizing_mode="stretch_width"),
            "studs": pn.Column(sizing_mode="stretch_width"),
        }
        fields = DECLARED["chance"][0]["fields"]  # of all pages: each has copies of its own
        self._chances = {field["key"]: {**field} for field in fields if "value" in field}
        self.shown["save"].groups = DECLARED["save"]
        self.shown["tests"].groups = DECLARED["tests"]

    def view(self) -> Any:
        """The page, for a browser."""
        pn.extension("filedropper")  # of tests on studs, which may come later
        page = pn.Template(_PAGE.read_text(encoding="utf-8"), location=True)
        page.add_variable("style", Markup((_HERE / "page.css").read_text(encoding="utf-8")))
        page.title = _TITLE
        for name, part in self.shown.items():
            page.add_panel(name, part)
        return page

    def parts(self) -> Any:
        """The parts beside and below each other, for a notebook."""
        titles = re.findall(r"<h2>(.*?)</h2>|roots\.(\w+)", _PAGE.read_text(encoding="utf-8"))
        form: list[Any] = []
        shown: list[Any] = []
        found = False
        for title, name in titles:
            found |= title == "The answer"
            if name in self.shown and name not in ("studs", "tests"):
                (shown if found else form).append(self.shown[name])
            elif title and title != "Shear studs":
                (shown if found else form).append(f"### {title}")
        return pn.Row(pn.Column(*form, width=360), pn.Column(*shown))

    def alone(self, act: Callable[..., None], *arguments: Any) -> None:
        """Do something to the page while nothing else does: notebooks have several threads."""
        with self._lock:
            act(*arguments)

    # -- what a person does -----------------------------------------------------------------------

    def change(self, message: Mapping[str, Any]) -> None:
        """Take a change of a field: its value, or the unit of its number."""
        key = message["key"]
        if "measure" in message:
            self.form.measure(key, str(message["measure"]))
        else:
            self.form.change(key, message["value"], str(message.get("unit", "")))
        if "measure" in message or key in ("kind", "steel.grade"):
            self._show_form()
        self._ask()

    def load(self, tables: dict[str, Any]) -> None:
        """Show another scenario, from the tables of its file."""
        self.form, self._chosen = ScenarioForm(tables), []
        self._show_form()
        self._ask()

    def _reopen(self, link: str) -> None:
        """Take the state of a link; of one that is none it is said, and nothing changes."""
        if not link:
            return
        try:
            state = unpacked(link)
            text, models = tomli_w.dumps(state["scenario"]), state["models"]
            if not isinstance(models, list) or len(models) > _MOST_MODELS:
                raise InputError("link", None, f"must name at most {_MOST_MODELS} models")
            self.form = ScenarioForm(read_tables(text.encode(), "link"))
            self._chosen = [str(name) for name in models]
        except (LookupError, TypeError, AttributeError, ValueError, RecursionError) as error:
            why = error if isinstance(error, InputError) else "it holds no scenario"
            self._trouble = f"The link could not be opened: {why}"

    def _choose(self, message: Mapping[str, Any]) -> None:
        """Take a model in or out, ask the slow ones, or stop them."""
        name = message["key"]
        if name == "ask":
            for each in self._unasked:
                future = self._desk.ask("work.answers", self.form.scenario, [each])
                self._wait(each, future, partial(self._answered, each, self._turn))
        elif name == "stop":
            self.stop()
        elif name in dict(self._offered):
            kept = [each for each in self._wanted if each != name]
            self.ask([*kept, name] if message["value"] else kept)
        self._show_models()

    def ask(self, names: list[str]) -> None:
        """Have these models answer: the quick ones now, the others when they are asked for."""
        self._chosen = names
        if self.form.error is not None or self._told != self._turn:
            return self._ask()
        for each in [n for n in self._unasked if n in self._quick]:
            future = self._desk.ask("work.answers", self._answered_to, [each], lane=LIVE)
            self._wait(each, future, partial(self._answered, each, self._turn))
        kept = {name: self.responses[name] for name in names if name in self.responses}
        self.responses = kept or self.responses
        return self._show_answers()

    def _move(self, message: Mapping[str, Any]) -> None:
        """Show another instant of the record."""
        shapes, snapshot = self.deformed.shapes, int(float(message["value"]))
        if shapes is not None:
            snapshot = min(max(snapshot, 0), len(shapes.at) - 1)
            self.history.at(float(shapes.at[snapshot]))
        self.shown["instant"].object = escape(self.deformed.at(snapshot))

    def _probable(self, message: Mapping[str, Any]) -> None:
        """Take a value of the fragility, or compute it."""
        key, field = message["key"], self._chances.get(message["key"])
        if field is not None and "measure" in message:
            text = in_other_unit(f"{field['value']} {field['unit']}", "m/s", message["measure"])
            field["value"], _, field["unit"] = str(text).partition(" ")
            self._show_chance()
        elif field is not None:
            field["value"] = str(message["value"])
            self._pale("fragility", "probable")
        elif key == "run" and self.form.error is None:
            self._compute_fragility()

    def _keep(self, message: Mapping[str, Any]) -> None:
        """Save what a button names, or open a file."""
        key, view = message["key"], self.shown["save"]
        view.errors = {}
        try:
            if key == "open":
                name, size = str(message["name"]), message.get("size", 0)
                if size:
                    text = f"must be at most {LARGEST_FILE} bytes"
                    raise InputError(name, f"{size} bytes", text, "is this the right file?")
                content = b64decode(message["value"])
                future = self._desk.ask("form.read_tables", content, name, lane=FILES)
                return self._wait(name, future, self._opened)
            _ = self.form.scenario
        except InputError as error:
            view.errors = {key: str(error)}
            return None
        scenario, over = self._answered_to, DECLARED["varied"][self._kind][0]
        name = re.sub(r"[^\w-]+", "-", scenario.name).strip("-") or "scenario"
        makers: dict[str, tuple[Any, ...]] = {
            "csv": ("sheet.histories_csv", self.responses),
            "pdf": ("sheet.one_page", scenario, self.responses),
            "html": ("sheet.swept_page", scenario, over, list(self.responses)),
            **{
                n: ("sheet.picture", scenario, self.responses, "history", n) for n in ("svg", "png")
            },
        }

        def send(content: Any) -> None:
            view.errors = {key: self._trouble} if content is None else {}
            if content is not None:
                made = content.encode() if isinstance(content, str) else content
                view.send(f"{name}.{key}", made)

        if key == "toml":
            return send(self.form.text)
        return self._wait(f"the file {name}.{key}", self._desk.ask(*makers[key], lane=FILES), send)

    def _evaluate(self, message: Mapping[str, Any]) -> None:
        """Begin with tests on studs: few need them, and the page is there sooner without."""
        from workbench.extras.app.studs import StudDesk

        self.shown["tests"].groups = []
        self.shown["studs"][:] = [StudDesk(self._desk).view()]

    def _opened(self, tables: dict[str, Any] | None) -> None:
        """Show a file that was read, or say why it was not."""
        self.shown["save"].errors = {"open": self._trouble} if tables is None else {}
        if tables is not None:
            self.load(tables)

    # -- what is asked ----------------------------------------------------------------------------

    @property
    def _wanted(self) -> list[str]:
        """Models that are to answer."""
        return self._chosen or list(self.responses)

    @property
    def _unasked(self) -> list[str]:
        """Models that are to answer, and have not answered this state."""
        return [name for name in self._chosen if name not in {*self.responses, *self._waits}]

    @property
    def _first(self) -> str:
        """The first model that has an answer; empty without one."""
        return next((n for n, r in self.responses.items() if outcome_of(r).is_answer), "")

    def _ask(self) -> None:
        """Have the quick models answer; while they are at work the newest state waits."""
        self._turn += 1
        self.stop()
        self._show_errors()
        self._pale(*_FOLLOWS, *self.small, "fragility", "probable")
        if self.form.error is not None:
            return self._show_answer()
        if self._kind != self.form.tables["kind"]:
            self._kind, self._quick, self._offered = self.form.tables["kind"], set(), []
            offers = self._desk.ask("work.models_of", self._kind, lane=LIVE)
            self._wait("the list of models", offers, self._take_offers)
        if self.busy:
            return None
        self.busy = True
        names = [name for name in self._chosen if name in self._quick]
        asked = self.form.scenario, names, frozenset(self._slow)
        future = self._desk.ask("work.answers", *asked, lane=LIVE)
        then = partial(self._followed, self._turn, self.form.scenario)
        return self._wait("the quick models", future, then)

    def _wait(self, what: str, future: Future[Any], then: Callable[[Any], None]) -> None:
        """Call `then` with the result of a worker, on the page: None where there is none."""
        self._waits[what] = perf_counter(), future

        def take() -> None:
            result = None
            if self._waits.get(what, (0.0, None))[1] is future:
                del self._waits[what]
            try:
                result = None if future.cancelled() else future.result()
            except BaseException as error:  # a worker may raise all there is: it is said
                self._trouble = f"{what}: {trouble(error)}"
            then(result)

        def done(_: Any) -> None:
            if self._document is None:
                self.alone(take)
            elif self._document.session_context is not None:  # the tab is still open
                self._document.add_next_tick_callback(partial(self._once_loaded, take))

        future.add_done_callback(done)

    def _once_loaded(self, act: Callable[[], None] | None = None) -> None:
        """Do something once the browser has all of the page; without `act` it has it now.

        Panel loses changes of a part that its browser is still loading.
        """
        if act is not None and self._held is not None:
            self._held.append(act)
        elif act is not None:
            act()
        else:
            held, self._held = self._held or [], None
            for each in held:
                each()

    def stop(self) -> None:
        """End the slow models, and what follows an answer where it has not begun."""
        for what, (_, future) in list(self._waits.items()):
            slow = what == _ADVICE or what in self._chosen
            if slow or (what in _FOLLOWS and not future.running()):
                future.cancel()

    def _take_offers(self, offered: list[tuple[str, str]] | None) -> None:
        self._offered = offered or []
        self._show_models()

    def _followed(
        self, turn: int, scenario: Scenario, responses: dict[str, Response] | None
    ) -> None:
        """Take the answers of the quick models; ask again where the state has gone on."""
        self.busy = False
        if responses is None:
            self._show_answer()
        else:
            self._trouble = "" if self._quick else self._trouble  # a link is told of once
            self._quick |= responses.keys()
            self._slow |= {n for n, r in responses.items() if r.attrs["wall_time"] > _SLOW}
            wanted, self._answered_to = self._chosen or list(responses), scenario
            kept = {name: each for name, each in responses.items() if name in wanted}
            self.responses, self._told = kept or responses, turn
            self._pale(*_ANSWERS, pale=False)
            self._show_answers()
        if turn != self._turn:
            self._ask()
        elif self.responses:
            self._follow_up()
            if not self._chosen and not any("because" in r.attrs for r in self.responses.values()):
                future = self._desk.ask("work.answers", scenario)
                self._wait(_ADVICE, future, partial(self._advised, turn))

    def _advised(self, turn: int, responses: dict[str, Response] | None) -> None:
        """Take the answer of a model of the advice that is too slow to follow the hand."""
        if responses is not None and turn == self._turn:
            self.responses = responses
        self._show_answers()

    def _answered(self, name: str, turn: int, responses: dict[str, Response] | None) -> None:
        """Take the answer of a model that was asked for."""
        if responses is not None and turn == self._turn:
            self.responses = self.responses | responses
            self._quick |= {name} if responses[name].attrs["wall_time"] < _QUICK else set()
        self._show_answers()

    def _follow_up(self) -> None:
        """Have pictures, small curves and the collapse of this state made, now that it rests."""
        scenario, turn, model = self.form.scenario, self._turn, self._first
        keys = DECLARED["varied"][self._kind]
        quick = bool(model) and self.responses[model].attrs["wall_time"] < _QUICK
        hinged = {name: r for name, r in self.responses.items() if "moment" in r and "time" in r}
        steps: dict[str, tuple[Any, ...]] = {
            "structure": ("sheet.picture_if_any", scenario, self.responses, "structure")
        }
        if model:
            steps["varied"] = "work.curves", scenario, keys, model, quick
            steps["collapse"] = "work.collapse", scenario, keys[0], model
        if hinged:
            steps["hinges"] = "sheet.picture_if_any", scenario, hinged, "interaction"
        in_words: dict[str, Any] = {"varied": self._show_curves, "collapse": self._show_collapse}

        def take(name: str, result: Any) -> None:
            if turn == self._turn and result is not None:
                self.shown[name].object = in_words.get(name, str)(result)
                self._pale(name, *(self.small if name == "varied" else ()), pale=False)

        for name in _FOLLOWS:
            if name in steps:
                future = self._desk.ask(*steps[name], lane=FOLLOWING)
                self._wait(name, future, partial(take, name))
            else:
                self.shown[name].object = ""

    def _compute_fragility(self) -> None:
        """Have the fragility computed, from values that are right."""
        given = {
            key: f"{f['value']} {f.get('unit', '')}".strip() for key, f in self._chances.items()
        }
        view, turn = self.shown["chance"], self._turn
        view.errors = {"run": "At work, half a minute and more; what is shown stays until then."}

        def take(result: Any) -> None:
            view.errors = {}
            if result is None or turn != self._turn:
                why = self._trouble if result is None else "the scenario has changed: compute again"
                view.errors = {"run": why}
                return
            plot = pn.pane.Bokeh(fragility_plot(result[0]), sizing_mode="stretch_width")
            self.shown["fragility"][:] = [plot]
            self._pale("fragility", "probable", pale=False)
            self.shown["probable"].object = f"<p>{escape(result[1])}.</p>"

        seconds = 0.8 * self._desk.limit
        future = self._desk.ask("chance.fragility", self.form.scenario, given, seconds)
        self._wait("the curve of probability", future, take)

    # -- what is shown ----------------------------------------------------------------------------

    def _pale(self, *names: str, pale: bool = True) -> None:
        """Show parts that are of an earlier state pale, or as they are."""
        for name in names:
            self.shown[name].styles = {
                "opacity": "0.65" if pale else "1"
            }  # {} would change nothing

    def _show_form(self) -> None:
        self.shown["form"].groups = self.form.groups
        kept = ", ".join(map(escape, self.form.kept))
        self.shown["kept"].object = (
            f"<p>Not editable here, kept from the file: {kept}.</p>" if kept else ""
        )
        struck = "velocity" in DECLARED["varied"][self.form.tables["kind"]][0]
        self._show_chance(struck)
        self.shown["fragility"][:] = []
        self.shown["probable"].object = "" if struck else "<p>For structures that are struck.</p>"

    def _show_chance(self, struck: bool = True) -> None:
        fields = [self._chances.get(f["key"], f) for f in DECLARED["chance"][0]["fields"]]
        self.shown["chance"].groups = [{"title": "", "fields": fields}] if struck else []

    def _show_errors(self) -> None:
        """The message of a field beside it; a number of another unit is not told in SI."""
        error = self.form.error
        if error is None:
            self.shown["form"].errors = {}
            return
        fields = self.form.fields
        field = fields.get(error.field) or fields.get(error.field.rpartition(".")[0], {})
        brief = field.get("units") and not isinstance(error.value, str)
        self.shown["form"].errors = {
            field.get("key", "kind"): error.allowed if brief else str(error)
        }

    def _show_answer(self) -> None:
        """The answer in one sentence with its warnings; of an earlier state it is pale."""
        first = next(iter(self.responses.values()), None)
        text = f"<p>{escape(self._trouble)}</p>" if self._trouble else ""
        if first is not None:
            answer = as_object(first, self._answered_to)
            said = html_of_blocks(*notes_in_words(first, answer), *warnings(warnings_of(first)))
            numbers = html_of_blocks(definitions(tuple(numbers_in_words(first, answer))))
            text += f'<p class="headline">{escape(headline(first))}</p>{said}'
            text += f"<details><summary>All numbers</summary>{numbers}</details>"
        if self.form.error is not None:
            said = "An input is not right, see beside it; the answer is to the one before."
            text = f'<p class="wrong">{said}</p>{text}'
            self._pale(*_ANSWERS)
        self.shown["answer"].object = f'<div role="status">{text}</div>'

    def _show_answers(self) -> None:
        """All that the answers show."""
        self._show_answer()
        self.history.show(self.responses, [name for name, _ in self._offered])
        blocks = table_blocks("", self.responses) if self.responses else ()
        self.shown["table"].object = html_of_blocks(*blocks)
        shapes = (shapes_of(self._answered_to, r) for r in self.responses.values())
        known = next(filter(None, shapes), None)
        self.deformed.show(known)
        last, peak = (0, 0) if known is None else (len(known.at) - 1, known.peak)
        field = {"key": "time", "label": "Instant of the record", "kind": "range", "step": 1}
        field |= {"value": str(peak), "slider": [0, last], "turn": self._turn}
        self.shown["time"].groups = [{"title": "", "fields": [field] if last else []}]
        self._move({"value": peak})
        self._show_models()

    def _show_models(self) -> None:
        """The models that can be asked: first of the advice and those chosen, then all others."""
        fields = [
            {"key": name, "label": name, "kind": "check", "value": name in self._wanted, "hint": of}
            for name, of in self._offered
        ]
        first = [f for i, f in enumerate(fields) if i < _IN_SIGHT or f["value"]]
        others = [field for field in fields if field not in first]
        asked = ", ".join(self._unasked)
        at_work = self._waits.keys() & set(self._chosen)
        rest = "Slow models are at work" if at_work else "All chosen models have answered"
        label = f"Ask {asked}" if asked else rest
        first.append({"key": "ask", "kind": "button", "label": label, "disabled": not asked})
        if at_work:
            stop = f"Stop {', '.join(sorted(at_work))}"
            first.append({"key": "stop", "kind": "button", "label": stop})
        more = {"title": "", "folded": f"{len(others)} more models", "fields": others, "many": True}
        groups = [{"title": "Models that are asked", "fields": first, "many": True}, more]
        self.shown["models"].groups = groups if others else groups[:1]

    def _show_curves(self, curves: list[SmallCurve]) -> str:
        """Draw the small curves; return them in words."""
        fields = self.form.fields
        sentences = [
            small.show(curve, fields.get(curve.key, {"label": curve.key}))
            for small, curve in zip(self.small.values(), curves, strict=False)
        ]
        return f"<p>By {escape(self._first)}. {escape(' '.join(sentences))}</p>"

    def _show_collapse(self, limit: CriticalValue) -> str:
        """Return the bracket of the collapse in words, with its warnings."""
        over = DECLARED["varied"][self._kind][0]
        factor, unit = (3.6, "km/h") if "velocity" in over else (1e-3, "kN/m or kN")
        ends = (("survives up to", limit.survives_at), ("collapses at", limit.collapses_at))
        known = [f"{words} {factor * v:.3g} {unit}" for words, v in ends if v is not None]
        text = " and ".join(known) or "gave no answer in the range that was tried"
        said = html_of_blocks(*warnings(limit.warnings))
        return f"<p>By {escape(limit.model)}, it {text}.</p>{said}"

    def _tick(self) -> None:
        """Say what has been at work for a while, and keep the address of the page."""
        self._pale(*_ANSWERS, pale=self._told != self._turn)
        if self.form.error is None:
            self._share()  # again, as a page that is being loaded forgets its address
        now = perf_counter()
        lasting = {what: now - begun for what, (begun, _) in self._waits.items()}
        said = {_FOLLOWS.get(what, what): s for what, s in lasting.items() if s > _PATIENCE}
        text = "; ".join(f"{what} at work for {seconds:.0f} s" for what, seconds in said.items())
        if max(lasting.values(), default=0.0) > _COMPILING:
            text += ". The first run of a model compiles it for this machine: up to a minute"
        shown = f"<p>{escape(text)}.</p>" if text else ""
        if self.shown["state"].object != shown:
            self.shown["state"].object = shown

    def _share(self) -> None:
        """Put the state into the address of the page."""
        if self._location is not None:
            link = packed({"scenario": self.form.tables, "models": self._chosen})
            long = len(link) > LONGEST_LINK
            self._location.search = "" if long else f"?s={link}"
            said = "The state is too long for an address: save the scenario file."
            self.shown["kept"].object = f"<p>{said}</p>" if long else self.shown["kept"].object
