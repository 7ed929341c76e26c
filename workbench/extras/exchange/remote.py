"""A model that another program answers over HTTP, by the protocol of UM-Bridge (version 1.0).

Numbers of the scenario go to `workbench serve`, or to any server of the protocol, scalars come
back. What comes is data: it is held to form and size, and nothing of it runs.
Source: Seelinger et al. 2024, Democratizing Uncertainty Quantification.
"""

import json
import re
import tomllib
from collections.abc import Mapping
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import partial, reduce
from http.client import HTTPConnection, HTTPSConnection
from itertools import islice
from socket import SHUT_RDWR, socket
from threading import Timer
from time import monotonic
from typing import Any, ClassVar
from urllib.parse import urlsplit

from workbench.base.errors import Collapse, InputError, Mechanism, OutOfDomainError, one_line, shown
from workbench.base.fields import Choice, Many, Number, Text, checked
from workbench.models.base import Answering
from workbench.responses import SCALARS, Finding, Outcome, Response, build_response, finding
from workbench.responses.build import failed_response, set_attributes
from workbench.scenarios import Scenario, StudTests, to_toml
from workbench.scenarios.files import KINDS, number_at
from workbench.scenarios.varied import Path_, put

LARGEST = 1_000_000  # bytes of a reply
_ADDRESS = re.compile(r"https?://([\w.-]+|\[[\da-f:.]+\])(:\d{1,5})?(/[\w.~-]+)*/?", re.A | re.I)
_INFINITE, _EARLY = 1e60, 1e-3  # a number as good as infinite; s by which clocks may differ
_OUTCOMES = {"".join(map(str.capitalize, each.split("-"))): each for each in Outcome}
_KEYS = Many(Text(), shortest=1, different=True)
_SCALARS = Many(Choice(SCALARS), shortest=1, different=True)
_ORDER = "in the order of the server"


class RemoteError(Exception):
    """A server without numbers: why, the `outcome`, and the `collapse` of the structure, if any."""

    def __init__(self, text: str, outcome: Outcome = Outcome.CRASHED, collapse: Any = None) -> None:
        super().__init__(text)
        self.outcome, self.collapse = outcome, collapse

    def response(self, *findings: Finding) -> Response:
        """The response that says so, with `findings` of its own."""
        refused = self.outcome is Outcome.OUT_OF_DOMAIN
        refusals = [Finding("domain", str(self), refusal=True)] if refused else []
        response = failed_response(self.outcome, "", [*findings, *refusals])
        response.attrs["message"] = str(self)  # with a remedy of its own
        if self.collapse is not None:
            set_attributes(response, collapse=self.collapse)
        return response


def need(held: Any, text: str, outcome: Outcome = Outcome.CRASHED) -> None:
    """Raise `RemoteError` unless a condition is `held`."""
    if not held:
        raise RemoteError(text, outcome)


@dataclass(frozen=True)
class Remote(Answering):
    """A server of UM-Bridge, to which some numbers of the scenario are sent."""

    url: str | None = checked(Text(500), optional=True, help="of the server, http://HOST:PORT")
    served: str | None = checked(
        Text(), optional=True, help="model there; needed if it has several"
    )
    inputs: tuple[str, ...] = checked(_KEYS, ("striker.velocity",), help=f"keys sent, {_ORDER}")
    outputs: tuple[str, ...] = checked(_SCALARS, ("peak_displacement",), help=f"returned, {_ORDER}")
    config: str = checked(Text(2000), "{}", help="the server's own options, a JSON object")
    timeout: float = checked(Number(1e-3, 1e6, "s"), 60.0, help="of all requests of an answer")

    name: ClassVar[str] = "remote"
    version: ClassVar[int] = 1
    material = "rate", "hardening"  # as far as the server has them
    crushing = spatial = eccentric = True  # likewise
    answers: ClassVar[tuple[str, ...]] = tuple(k for k, of in KINDS.items() if of is not StudTests)
    assumptions: ClassVar[tuple[str, ...]] = (
        "The server answers in SI units; its own assumptions and warnings do not come along.",
        "All that is not sent is as in the scenario that the server stands for: one that tells it, "
        "as `workbench serve` does, is held to it; the answer of another one is warned of.",
        "The server stays as it is: stored answers are not renewed when it changes.",
    )
    sources: ClassVar[tuple[str, ...]] = ("seelinger2024",)

    def check(self) -> None:
        """Refuse what is no address of a server, and a configuration that is no JSON object."""
        if self.url is not None and _ADDRESS.fullmatch(self.url) is None:
            text = "must be http://HOST:PORT or https://HOST:PORT, without user, query or fragment"
            raise self.refusal("url", text, "`workbench serve` prints it")
        if not isinstance(_json(self.config), dict):
            raise self.refusal("config", 'must be a JSON object, such as {"level": 2}')

    def domain(self, scenario: Scenario) -> list[Finding]:
        """Refuse where there is no server, and numbers that the scenario does not have."""
        try:
            self._sent(tomllib.loads(to_toml(scenario)))
        except InputError as error:
            return [finding("no-such-input", error=error)]
        return [finding("no-server")] if self.url is None else []

    def _sent(self, tables: dict[str, Any]) -> dict[Path_, float]:
        """The numbers that are sent, by the keys that lead to them in the tables of a scenario."""
        return dict(number_at(tables, key, "inputs") for key in self.inputs)

    def _solve(self, scenario: Scenario) -> Response:
        try:
            return self._asked(tomllib.loads(to_toml(scenario)))
        except RemoteError as error:
            return error.response()

    def _asked(self, tables: dict[str, Any]) -> Response:
        """The answer of the server to a scenario. Raises `RemoteError`, `OutOfDomainError`."""
        ask = partial(ask_server, str(self.url), monotonic() + self.timeout)
        info, sent = ask("/Info"), self._sent(tables)
        version, names = info.get("protocolVersion"), info.get("models")
        text = f"{self.url} speaks version {shown(version)} of UM-Bridge, not 1.0"
        need(version == 1.0 and isinstance(names, list), f"{text}: take another server")
        there = names[0] if self.served is None and len(names) == 1 else self.served
        text = f"option served = {self.served}: {self.url} has {shown(names)}; name one of them"
        need(isinstance(there, str) and there in names, text, Outcome.INVALID_INPUT)
        told = ask("/ModelInfo", {"name": there})
        able = isinstance(told.get("support"), dict) and told["support"].get("Evaluate") is True
        need(able, f"the model at {self.url} has no Evaluate: take another one")
        findings = [finding("untold-scenario", url=self.url, inputs=", ".join(self.inputs))]
        if "workbench" in told:
            self._hold(told["workbench"], tables, sent)
            findings = []
        asked, sizes = {"name": there, "config": json.loads(self.config)}, []
        for key, wanted in {"inputSizes": self.inputs, "outputSizes": self.outputs}.items():
            size = ask(f"/{key[0].upper()}{key[1:]}", asked).get(key)
            whole = isinstance(size, list) and all(type(n) is int and n >= 0 for n in size)
            text = f"{key} at {self.url} are {shown(size)}, not those of {', '.join(wanted)}"
            need(whole and sum(size) == len(wanted), f"{text}: name as many as the model has")
            sizes.append(size)
        values = iter(sent.values())
        asked["input"] = [list(islice(values, size)) for size in sizes[0]]
        try:
            output = ask("/Evaluate", asked).get("output")
        except RemoteError as error:
            return error.response(*findings)
        text = f"{self.url} puts out {shown(output)}"
        lists = isinstance(output, list) and all(isinstance(each, list) for each in output)
        numbers: list[Any] = [n for each in output for n in each] if lists else [None]
        known = all(type(n) in (int, float) for n in numbers)
        need(known and [*map(len, output)] == sizes[1], f"{text}, not lists of {sizes[1]} numbers")
        finite = all(abs(n) < _INFINITE for n in numbers)
        need(finite, f"{text}, which is not finite: see the server", Outcome.NOT_CONVERGED)
        response = build_response(dict(zip(self.outputs, numbers, strict=True)), warnings=findings)
        set_attributes(response, served={"url": self.url, "model": there})
        return response

    def _hold(self, told: Any, tables: dict[str, Any], sent: dict[Path_, float]) -> None:
        """Refuse a server that has `told` another scenario, or other numbers than are `sent`.

        Raises `OutOfDomainError`, `RemoteError` where that is no scenario.
        """
        from workbench.study.cells import differences

        asked = {"inputs": [".".join(map(str, p)) for p in sent], "outputs": [*self.outputs]}
        try:
            given = {name: told[name] for name in asked} | {"name": tables["name"]}
            theirs = reduce(lambda t, p: put(t, p, sent[p]), sent, told["scenario"])
            other = list(differences(theirs | given, tables | asked))
        except (ValueError, TypeError, LookupError, AttributeError, RecursionError) as error:
            raise RemoteError(f"{self.url} tells no scenario: take another server") from error
        if other:
            parts = (f"{path} {shown(old)} -> {shown(new)}" for path, old, new in other[:3])
            named = one_line("; ".join(parts), 500)
            raise OutOfDomainError(finding("other-scenario", len(other), url=self.url, named=named))


def ask_server(url: str, deadline: float, path: str, body: Any = None) -> Any:
    """The reply of a server to one request, a JSON object. Raises `RemoteError`.

    Arguments: its `url`; the `deadline` on the monotonic clock, s; the `path` of the request, and
    its `body` (None: GET). It goes to that host alone: no redirect is followed, no proxy asked.
    """
    parts, place, reason = urlsplit(url), url.rstrip("/") + path, ""
    method, sent = ("GET", None) if body is None else ("POST", json.dumps(body))
    kind = HTTPSConnection if parts.scheme == "https" else HTTPConnection
    headers = {"Content-Type": "application/json", "Connection": "close"}
    try:
        left = deadline - monotonic()
        with closing(kind(parts.hostname or "", parts.port, timeout=left)) as connection:
            connection.connect()
            # bytes that drip renew the limit of a socket, but not that of a watch
            watch = Timer(deadline - monotonic(), _cut, [connection.sock])
            watch.start()
            try:
                connection.request(method, parts.path.rstrip("/") + path, sent, headers)
                with connection.getresponse() as reply:
                    status, content = reply.status, reply.read(LARGEST + 1)
            finally:
                watch.cancel()
    except Exception as error:  # what is no HTTP fails in many ways
        reason = one_line(getattr(error, "strerror", None) or str(error) or repr(error), 200)
    late = f"{place} has not answered in time: allow more by option timeout"
    need(monotonic() < deadline - _EARLY, late, Outcome.TIMED_OUT)
    need(not reason, f"no answer from {place}: {reason}; start the server, or correct option url")
    need(len(content) <= LARGEST, f"{place} answers with more than {LARGEST / 1e6:g} MB: no model")
    need(status // 100 != 3, f"{place} leads elsewhere, where nothing is asked: correct option url")
    told = _json(content)
    if isinstance(told, dict) and isinstance(told.get("error"), dict):
        raise _told(told["error"], place)
    known = status == 200 and isinstance(told, dict)
    need(known, f"{place} answers with HTTP {status} and no JSON object: correct option url")
    return told


def _json(text: str | bytes) -> Any:
    """The value of a text in JSON; None of any other."""
    with suppress(ValueError, RecursionError):
        return json.loads(text)
    return None


def _cut(line: socket) -> None:
    """End a connection that another thread reads."""
    with suppress(OSError):
        line.shutdown(SHUT_RDWR)


def _told(error: Mapping[str, Any], place: str) -> RemoteError:
    """The error that an error object of the protocol tells."""
    texts = (error.get(name) for name in ("type", "message"))
    kind, message = (one_line(text) if isinstance(text, str) else "?" for text in texts)
    outcome, text = _OUTCOMES.get(kind, Outcome.CRASHED), f"{place} answers with {kind}: {message}"
    if outcome is Outcome.COLLAPSE:
        with suppress(LookupError, TypeError, ValueError):
            mechanism, parts, moved, time = (error["collapse"][name] for name in Collapse._fields)
            if all(abs(number) < _INFINITE for number in (moved, time or 0.0)):
                how = Collapse(Mechanism(mechanism), tuple(map(one_line, parts)), moved, time)
                return RemoteError(text, outcome, how._asdict())
    return RemoteError(text, Outcome.CRASHED if outcome.is_answer else outcome)
