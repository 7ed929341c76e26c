"""A model over HTTP by the protocol of UM-Bridge (version 1.0), for samplers in any language.

POST /Evaluate with ``{"name": ..., "input": [[...]]}`` gives ``{"output": [[...]]}``, or an error
object of the protocol: ``{"error": {"type": ..., "message": ...}}``.
"""

from __future__ import annotations

import json
import tomllib
from contextlib import nullcontext, suppress
from http import HTTPStatus
from ipaddress import ip_address
from logging import CRITICAL, getLogger
from math import isfinite
from socket import gethostname
from threading import Lock
from time import time
from typing import Any
from urllib.parse import urlsplit

from waitress.adjustments import Adjustments
from waitress.channel import HTTPChannel
from waitress.parser import HTTPRequestParser
from waitress.server import TcpWSGIServer

from workbench.base.errors import InputError, message_of

PATIENCE = 10.0  # s that a client may take for a request, or be silent before one
_LIMITS = {  # bytes of a request and of its head; connections; s
    "max_request_body_size": 1_000_000,
    "max_request_header_size": 4096,  # numbers in it then have no more digits than Python reads
    "connection_limit": 500,
    "channel_timeout": int(PATIENCE),
    "cleanup_interval": 1,
    "threads": 16,
}
_LOCAL, _EVERYWHERE = ("localhost", "127.0.0.1", "::1"), ("", "0.0.0.0", "::")
_FEATURES = ("Evaluate", "Gradient", "ApplyJacobian", "ApplyHessian")


class FaultError(Exception):
    """A request without an answer: type and message of the protocol, HTTP status, and `more`."""

    def __init__(self, kind: str, message: str, status: int = 400, **more: Any) -> None:
        super().__init__(message)
        self.status, self.told = status, {"type": kind, "message": message, **more}


class Service:
    """A model of which some numbers of a scenario are the input, and scalars the output."""

    def __init__(self, model: Any, scenario: Any, keys: list[str], quantities: list[str]) -> None:
        from workbench.responses import SCALARS
        from workbench.scenarios import to_toml
        from workbench.scenarios.files import number_at

        self.model, self.quantities = model, quantities
        self.tables = tomllib.loads(to_toml(scenario))
        self.paths = [number_at(self.tables, key, "--over")[0] for key in keys]
        self.names = [".".join(map(str, path)) for path in self.paths]
        for name in quantities:
            if name not in SCALARS:
                raise InputError("--quantity", name, f"must be one of {', '.join(SCALARS)}")

    def evaluate(self, values: list[float]) -> list[float]:
        """The output of an input. Raises `FaultError`."""
        import numpy as np

        from workbench.models.batch import FAILURE, OUTCOME, simulate_many
        from workbench.responses import Outcome
        from workbench.responses.build import attribute
        from workbench.scenarios.varied import Varied

        by_key = {path: np.array([v]) for path, v in zip(self.paths, values, strict=True)}
        asked = Varied(self.tables, by_key)
        row = simulate_many(self.model, asked, 1).iloc[0]
        if row[OUTCOME] == Outcome.INVALID_INPUT.value:
            raise FaultError("InvalidInput", row[FAILURE])
        if row[OUTCOME] != Outcome.OK.value:
            kind = "".join(part.capitalize() for part in row[OUTCOME].split("-"))
            falls = row[OUTCOME] == Outcome.COLLAPSE.value
            how = attribute(self.model.simulate(asked[0]), "collapse") if falls else {}
            raise FaultError(kind, row[FAILURE], 500, **({"collapse": how} if how else {}))
        output = {name: float(row.get(name, np.nan)) for name in self.quantities}
        lacking = [name for name, value in output.items() if not isfinite(value)]
        if lacking:
            raise FaultError("InvalidOutput", f"the answer has no {', '.join(lacking)}", 500)
        return list(output.values())

    def reply(self, path: str, body: bytes | None) -> dict[str, Any]:
        """The reply to a request, `body` None of a GET. Raises `FaultError`."""
        name = self.model.name
        if path == "/Info" and body is None:
            return {"protocolVersion": 1.0, "models": [name]}
        if path.strip("/") in _FEATURES[1:]:
            raise FaultError(
                "UnsupportedFeature", f"{path.strip('/')} is not supported by the model"
            )
        if path not in ("/InputSizes", "/OutputSizes", "/ModelInfo", "/Evaluate") or body is None:
            raise FaultError("NotFound", f"nothing is served at {path} for this method", 404)
        try:
            asked = json.loads(body)
        except (ValueError, RecursionError) as error:
            raise FaultError("InvalidInput", "the request is not JSON") from error
        if not isinstance(asked, dict) or asked.get("name") != name:
            raise FaultError(
                "ModelNotFound", f"the request must name the model that is here, {name}"
            )
        if path == "/ModelInfo":
            support = {feature: feature == _FEATURES[0] for feature in _FEATURES}
            told = {"inputs": self.names, "outputs": self.quantities, "scenario": self.tables}
            return {"support": support, "workbench": told}
        if asked.get("config"):
            raise FaultError(
                "InvalidInput", "config must be empty: options are those of the server"
            )
        if path != "/Evaluate":
            sizes = {"/InputSizes": self.names, "/OutputSizes": self.quantities}
            return {f"{path[1].lower()}{path[2:]}": [len(sizes[path])]}
        given = asked.get("input")
        if not isinstance(given, list) or [type(each) for each in given] != [list]:
            raise FaultError("InvalidInput", "input must be a list that holds one list of numbers")
        numbers = [v for v in given[0] if type(v) in (int, float) and abs(v) < 1e300]
        if not len(numbers) == len(self.paths) == len(given[0]):
            text = f"input must hold {len(self.paths)} finite numbers: {', '.join(self.names)}"
            raise FaultError("InvalidInput", text)
        return {"output": [self.evaluate(list(map(float, numbers)))]}


class _Request(HTTPRequestParser):  # type: ignore[misc]
    """A request that knows since when it is read."""

    def __init__(self, adj: Adjustments) -> None:
        super().__init__(adj)
        self.begun = time()


class _Channel(HTTPChannel):  # type: ignore[misc]
    """A connection to a client."""

    parser_class = _Request


class Server(TcpWSGIServer):  # type: ignore[misc]
    """Reads requests side by side and evaluates one after the other.

    Raises `OSError` or `ValueError` where it cannot listen.
    """

    channel_class = _Channel

    def __init__(self, service: Service, host: str, port: int) -> None:
        self.service, self.host, self.count, self._turn = service, host, 0, Lock()
        getLogger("waitress").setLevel(CRITICAL)  # what a client does wrong is told to the client
        adjustments = Adjustments(host=host, port=port, **_LIMITS)
        try:
            super().__init__(self.answer, adj=adjustments)
        except OSError:
            self.close()
            raise

    def run(self) -> None:
        """Serve until Ctrl-C."""
        with suppress(KeyboardInterrupt):
            self.asyncore.loop(timeout=1.0, map=self._map, use_poll=True)

    def close(self) -> None:
        """Close all; what is still at work is left."""
        self.task_dispatcher.shutdown(timeout=0.5)
        super().close()

    def maintenance(self, now: float) -> None:
        """Close what is silent, or has been sending one request for too long."""
        super().maintenance(now)
        for channel in self.active_channels.values():
            if channel.request is not None and now - channel.request.begun > PATIENCE:
                channel.will_close = True

    def answer(self, environ: dict[str, Any], start_response: Any) -> list[bytes]:
        """Answer a request (WSGI)."""
        path, status = environ["PATH_INFO"], 200
        body = environ["wsgi.input"].read() if environ["REQUEST_METHOD"] == "POST" else None
        try:
            self._check_names(environ)
            with self._turn if path == "/Evaluate" else nullcontext():
                self.count += path == "/Evaluate"
                content = self.service.reply(path, body)
        except FaultError as fault:
            content = {"error": fault.told}
            status = fault.status
        except Exception as error:  # whatever goes wrong here is for the client to know
            content = {"error": {"type": "InternalServerError", "message": message_of(error)}}
            status = 500
        encoded = json.dumps(content).encode()
        headers = [("Content-Type", "application/json"), ("Content-Length", str(len(encoded)))]
        start_response(f"{status} {HTTPStatus(status).phrase}", headers)
        return [encoded]

    def _check_names(self, environ: dict[str, Any]) -> None:
        """Refuse pages of other places: they may have names that lead here (DNS rebinding)."""
        for header, of in (("HTTP_HOST", "//"), ("HTTP_ORIGIN", "")):
            text = environ.get(header)
            if text is None:
                continue
            try:
                name = urlsplit(of + text).hostname or ""
            except ValueError:
                name = ""
            if name not in (*_LOCAL, self.host, gethostname()) and not self._is_address(name):
                text = f"{header[5:].capitalize()} {text[:100]} is not this server"
                raise FaultError("Forbidden", text, 403)

    def _is_address(self, name: str) -> bool:
        """Whether a name is a number, where all addresses of this machine are listened at."""
        with suppress(ValueError):
            return self.host in _EVERYWHERE and bool(ip_address(name))
        return False
