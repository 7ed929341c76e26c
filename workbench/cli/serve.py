"""`workbench serve`: a model over HTTP, by the protocol of UM-Bridge (version 1.0).

Samplers of other packages, in any language, then ask it as their own: POST /Evaluate with
``{"name": ..., "input": [[...]]}`` gives ``{"output": [[...]]}``. What has no such answer is an
error object of the protocol: ``{"error": {"type": ..., "message": ...}}``.
"""

from __future__ import annotations

import json
import sys
import tomllib
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, HTTPServer
from math import isfinite
from typing import Any

from workbench.cli.output import Answer, Options, ScenarioFile, Settings, option, pairs_of, verb
from workbench.content.tree import Paragraph
from workbench.errors import InputError, message_of

LARGEST = 1_000_000  # bytes of a request
PATIENCE = 10.0  # s that a client may be silent in a request
_FEATURES = ("Evaluate", "Gradient", "ApplyJacobian", "ApplyHessian")


class FaultError(Exception):
    """A request without an answer: type and message of the protocol, HTTP status."""

    def __init__(self, kind: str, message: str, status: int = 400) -> None:
        super().__init__(message)
        self.kind, self.status = kind, status


class Service:
    """A model of which some numbers of a scenario are the input, and scalars the output."""

    def __init__(self, model: Any, scenario: Any, keys: list[str], quantities: list[str]) -> None:
        from workbench.responses import SCALARS
        from workbench.scenarios import to_toml
        from workbench.scenarios.files import place_of

        self.model, self.quantities = model, quantities
        self.tables = tomllib.loads(to_toml(scenario))
        self.paths: list[Any] = []
        for key in keys:
            path: Any = place_of(self.tables, key, key)
            value: Any = self.tables
            for part in path:
                value = value[part] if isinstance(value, list) else value.get(part)
            if isinstance(value, bool) or not isinstance(value, int | float):
                text = "is no number of this scenario"
                raise InputError("--over", key, text, "name keys as --set does, with their value")
            self.paths.append(path)
        for name in quantities:
            if name not in SCALARS:
                raise InputError("--quantity", name, f"must be one of {', '.join(SCALARS)}")

    def evaluate(self, values: list[float]) -> list[float]:
        """The output of an input. Raises `FaultError`."""
        import numpy as np

        from workbench.models.batch import FAILURE, OUTCOME, simulate_many
        from workbench.responses import Outcome
        from workbench.scenarios.varied import Varied

        by_key = {path: np.array([v]) for path, v in zip(self.paths, values, strict=True)}
        row = simulate_many(self.model, Varied(self.tables, by_key), 1).iloc[0]
        if row[OUTCOME] == Outcome.INVALID_INPUT.value:
            raise FaultError("InvalidInput", row[FAILURE])
        if row[OUTCOME] != Outcome.OK.value:
            kind = "".join(part.capitalize() for part in row[OUTCOME].split("-"))
            raise FaultError(kind, row[FAILURE], 500)
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
            return {"support": {feature: feature == _FEATURES[0] for feature in _FEATURES}}
        if asked.get("config"):
            raise FaultError(
                "InvalidInput", "config must be empty: options are those of the server"
            )
        if path != "/Evaluate":
            sizes = {"/InputSizes": self.paths, "/OutputSizes": self.quantities}
            return {f"{path[1].lower()}{path[2:]}": [len(sizes[path])]}
        given = asked.get("input")
        if not isinstance(given, list) or [type(each) for each in given] != [list]:
            raise FaultError("InvalidInput", "input must be a list that holds one list of numbers")
        numbers = [v for v in given[0] if type(v) in (int, float) and abs(v) < 1e300]
        if not len(numbers) == len(self.paths) == len(given[0]):
            keys = ", ".join(".".join(map(str, path)) for path in self.paths)
            text = f"input must hold {len(self.paths)} finite numbers: {keys}"
            raise FaultError("InvalidInput", text)
        return {"output": [self.evaluate(list(map(float, numbers)))]}


class Server(HTTPServer):
    """Answers one request after the other. Raises `OSError` where it cannot listen."""

    count = 0  # of evaluations

    def __init__(self, service: Service, host: str, port: int) -> None:
        super().__init__((host, port), Handler)
        self.service = service

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say in one line that a client has gone."""
        print(f"workbench: a request was lost: {sys.exc_info()[1]}", file=sys.stderr)


class Handler(BaseHTTPRequestHandler):
    """One request."""

    server: Server
    timeout = PATIENCE

    def do_GET(self) -> None:
        """Answer /Info."""
        self._send(None)

    def do_POST(self) -> None:
        """Answer all else."""
        length = self.headers.get("Content-Length", "")
        size = int(length) if length.isdecimal() else LARGEST + 1
        self._send(self.rfile.read(size) if size <= LARGEST else b"")

    def _send(self, body: bytes | None) -> None:
        try:
            content, status = self.server.service.reply(self.path, body), 200
        except FaultError as fault:
            content = {"error": {"type": fault.kind, "message": str(fault)}}
            status = fault.status
        except Exception as error:  # whatever goes wrong here is for the client to know
            content = {"error": {"type": "InternalServerError", "message": message_of(error)}}
            status = 500
        self.server.count += self.path == "/Evaluate"
        encoded = json.dumps(content).encode()
        self.send_response(status)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(encoded)))
        self.end_headers()
        self.wfile.write(encoded)

    def log_message(self, format: str, *arguments: Any) -> None:
        """Say nothing."""


@verb
def serve(
    scenario: ScenarioFile,
    over: list[str] = option("Key of a number that is input, once for each.", ..., "KEY"),
    model: str | None = option("Name of a model.  [default: by the scenario]", None, "NAME"),
    quantity: list[str] = option("Scalar that is output.", ["peak_displacement"], "NAME"),
    host: str = option("Address to listen at.", "127.0.0.1"),
    port: int = option("Port to listen at; 0: any that is free.", 4242),
    settings: Settings = None,
    options: Options = None,
) -> Answer:
    """Let other programs ask a model over HTTP.

    By the protocol of UM-Bridge, until Ctrl-C: input are the numbers of the scenario under --over,
    output the scalars under --quantity, all in SI. Exit status 0, 2 for bad input.
    """
    from workbench.cli.fragility import pair_of
    from workbench.fields import Number
    from workbench.models.base import on_one_mesh
    from workbench.registry import make_model
    from workbench.scenarios import load_scenario

    Number(0, 65535, integer=True).check("--port", port)
    base = load_scenario(scenario, settings or [])
    name = model or pair_of(base, None, "")[0]
    chosen = on_one_mesh(make_model(name, pairs_of("--option", options)))
    service = Service(chosen, base, over, quantity)
    try:
        server = Server(service, host, port)
    except OSError as error:
        text = f"cannot be listened at: {error.strerror or message_of(error)}"
        raise InputError("--port", f"{host}:{port}", text, "take another one") from error
    address = f"http://{host}:{server.server_port}"
    print(f"workbench: {name} is served at {address} until Ctrl-C", file=sys.stderr, flush=True)
    with server, suppress(KeyboardInterrupt):
        server.serve_forever()
    text = f"{server.count} evaluations of {name}."
    return Answer({"model": name, "evaluations": server.count}, [Paragraph(text)])
