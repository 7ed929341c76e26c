"""A server of UM-Bridge as a model: our own server gives the direct answer, no other does harm."""

from __future__ import annotations

import json
import socket
import threading
import time
from contextlib import contextmanager
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest
from test_registered_models import model_of
from toy_models import Spring
from waitress import wasyncore

from workbench.base.errors import InputError
from workbench.cli import run
from workbench.extras.exchange.remote import LARGEST, Remote
from workbench.extras.uncertainty.service import Server, Service
from workbench.models.base import make_model
from workbench.models.domain import implausible
from workbench.responses import Outcome, findings_of, outcome_of
from workbench.responses.build import attribute, collapse_of
from workbench.scenarios import (
    Column,
    ColumnImpact,
    ColumnPushover,
    Striker,
    frame_scenario,
    to_toml,
)
from workbench.testing import check_model

HIT = ColumnImpact(
    "hit", Column("HEB 220", 2.0, 2.0, axial_load=3e5), Striker(1500.0, 8.0), duration=0.2
)
BOTH = ("peak_displacement", "impulse")


@contextmanager
def served(model, scenario, keys=("striker.velocity",), quantities=BOTH):
    """Address of our own server."""
    server = Server(Service(model, scenario, list(keys), list(quantities)), "127.0.0.1", 0)
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    yield f"http://127.0.0.1:{server.effective_port}"
    server.trigger.pull_trigger(lambda: wasyncore.close_all(server._map))
    thread.join()


@pytest.fixture(scope="module")
def ours():
    with served(make_model("four-dof"), HIT) as url:
        yield Remote(url, outputs=BOTH)


@pytest.mark.claim("model:remote", "answer over the direct one", "property", 1, 1e-12)
@pytest.mark.parametrize("velocity", [3.0, 8.0, 80.0])
def test_our_own_server_gives_the_direct_answer(ours, velocity, claim) -> None:
    scenario = replace(HIT.at_velocity(velocity), name="another name")
    answer, direct = ours.simulate(scenario), make_model("four-dof").simulate(scenario)
    assert outcome_of(answer) is outcome_of(direct)
    assert collapse_of(answer) == collapse_of(direct)
    assert answer.attrs["message"].endswith(direct.attrs["message"])
    assert (outcome_of(answer) is Outcome.COLLAPSE) == (velocity == 80.0)
    assert set(answer.data_vars) == (set() if velocity == 80.0 else set(BOTH))
    for name in answer.data_vars:
        claim(answer[name] / direct[name])
    if velocity != 80.0:
        assert attribute(answer, "served") == {"url": ours.url, "model": "four-dof"}
    assert findings_of(answer) == implausible(scenario)


def test_the_contract_is_kept_with_a_server(ours) -> None:
    check_model(ours, [HIT, HIT.at_velocity(4.0)])


def test_steel_with_a_rate_is_left_to_the_server() -> None:
    steel = HIT.column.steel.changed(rate="S355", hardening_modulus=2e9)
    scenario = HIT.changed(column=HIT.column.changed(steel=steel))
    model = make_model("four-dof", {"rate_level": "bars"})
    with served(model, scenario, quantities=BOTH[:1]) as url:
        answer = Remote(url).simulate(scenario)
    assert float(answer["peak_displacement"]) == pytest.approx(
        float(model.simulate(scenario)["peak_displacement"]), rel=1e-12
    )
    assert findings_of(answer) == []


def test_inputs_of_lists_and_other_kinds_of_scenarios_are_sent() -> None:
    frame, push = frame_scenario(HIT), ColumnPushover("push", HIT.column, 0.05)
    model, name = make_model("rigid-superelement"), frame.frame.members[0].name
    key = f"member.{name}.mass_per_length"
    heavy = replace(frame.frame.members[0], mass_per_length=90.0)
    frame = replace(frame, frame=replace(frame.frame, members=(heavy, *frame.frame.members[1:])))
    with served(model, frame, [key], BOTH[:1]) as url:
        answer = Remote(url, inputs=(key,)).simulate(frame)
    direct = model.simulate(frame)
    assert float(answer["peak_displacement"]) == float(direct["peak_displacement"])
    model, keys, work = make_model("single-dof"), ("pushover.displacement",), ("input_energy",)
    with served(model, push, keys, work) as url:
        answer = Remote(url, inputs=keys, outputs=work).simulate(push)
    assert float(answer["input_energy"]) == float(model.simulate(push)["input_energy"])


@pytest.mark.parametrize(
    ("scenario", "options", "words"),
    [
        (
            HIT.changed(column=HIT.column.changed(axial_load=4e5)),
            {},
            "1 in all, column.axial_load 300000.0 -> 400000.0",
        ),
        (HIT.changed(duration=0.1), {}, "time.duration 0.2 -> 0.1"),
        (ColumnPushover("push", HIT.column, 0.05), {"inputs": ["pushover.displacement"]}, "kind"),
        (HIT, {"inputs": ["striker.mass"]}, "inputs ['striker.velocity'] -> ['striker.mass']"),
        (HIT, {"outputs": ["impulse", "peak_displacement"]}, "outputs ['peak_displacement', "),
        (HIT, {"inputs": ["striker.colour"]}, "striker.colour"),
        (HIT, {"inputs": ["column.section"]}, "is no number of this scenario"),
        (HIT, {"inputs": ["striker.velocity.x"]}, "value, not a table"),
    ],
)
def test_another_scenario_or_other_numbers_are_refused(ours, scenario, options, words) -> None:
    answer = make_model("remote", {"url": ours.url, "outputs": BOTH, **options}).simulate(scenario)
    assert outcome_of(answer) is Outcome.OUT_OF_DOMAIN
    assert words in answer.attrs["message"]
    assert [f.refusal for f in findings_of(answer)] == [True]


@pytest.mark.parametrize(
    ("scenario", "outcome", "words"),
    [
        (HIT.at_velocity(20.0), Outcome.NOT_CONVERGED, "NotConverged: no convergence at"),
        (HIT.at_velocity(4.0), Outcome.OUT_OF_DOMAIN, "OutOfDomain: refuses"),
    ],
)
def test_what_fails_at_our_server_fails_alike_here(scenario, outcome, words, monkeypatch) -> None:
    monkeypatch.setattr(Spring, "domain", refuse_slow)
    with served(Spring(trouble="solver"), HIT, quantities=BOTH[:1]) as url:
        answer = Remote(url).simulate(scenario)
    assert outcome_of(answer) is outcome
    assert words in answer.attrs["message"]
    assert [f.subject for f in findings_of(answer)] == ["domain"] * (
        outcome is Outcome.OUT_OF_DOMAIN
    )


def refuse_slow(self, scenario):
    from workbench.responses import Finding

    slow = scenario.striker.velocity < 5.0
    return [Finding("toy", "refuses what is slow", True)] if slow else []


def test_without_a_server_it_says_how_to_name_one() -> None:
    answer = model_of("remote").simulate(HIT)
    assert outcome_of(answer) is Outcome.OUT_OF_DOMAIN
    assert "--option url=http://localhost:4242" in answer.attrs["message"]


# what other servers may do: replies by path, JSON with status 200 unless a function writes them
GOOD = {
    "/Info": {"protocolVersion": 1.0, "models": ["forward"]},
    "/ModelInfo": {"support": {"Evaluate": True, "Gradient": False}},
    "/InputSizes": {"inputSizes": [1]},
    "/OutputSizes": {"outputSizes": [1]},
    "/Evaluate": {"output": [[0.125]]},
}


class Quiet(ThreadingHTTPServer):
    def handle_error(self, *_):
        """A client that has gone is no error."""


@contextmanager
def standing(**changes):
    """Address of a server with other replies than the good ones, and what it was asked."""
    replies = {**GOOD, **{f"/{name}": reply for name, reply in changes.items()}}
    asked = []

    class Handler(BaseHTTPRequestHandler):
        def answer(self):
            body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
            asked.append((self.command, self.path, json.loads(body) if body else None))
            reply = replies.get(self.path.removeprefix("/prefix"))
            if callable(reply):
                reply(self)
            else:
                whole(200, json.dumps(reply).encode())(self)

        do_GET = do_POST = answer  # noqa: N815

        def log_message(self, *_):
            pass

    server = Quiet(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, args=[0.01], daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}", asked
    server.shutdown()
    server.server_close()


def whole(status, content, **headers):
    def write(handler):
        handler.send_response(status)
        for name, value in {"Content-Length": len(content), **headers}.items():
            handler.send_header(name, value)
        handler.end_headers()
        handler.wfile.write(content)

    return write


def error(kind, message="why", status=500, **more):
    told = {"error": {"type": kind, "message": message, **more}}
    return whole(status, json.dumps(told).encode())


def dripping(start, drop):
    def write(handler):
        handler.wfile.write(start)
        while True:
            handler.wfile.write(drop)
            time.sleep(0.02)

    return write


def test_any_server_of_the_protocol_is_asked_in_its_form_and_warned_of() -> None:
    changes = {"InputSizes": {"inputSizes": [1, 2]}, "OutputSizes": {"outputSizes": [1, 0, 1]}}
    with standing(**changes, Evaluate={"output": [[0.1], [], [7]]}) as (url, asked):
        model = Remote(
            f"{url}/prefix/",
            inputs=("striker.velocity", "column.axial_load", "steel.yield_stress"),
            outputs=BOTH,
            config='{"level": 2}',
        )
        answer = model.simulate(HIT)
    assert [float(answer[name]) for name in BOTH] == [0.1, 7.0]
    named = {"name": "forward", "config": {"level": 2}}
    assert asked == [
        ("GET", "/prefix/Info", None),
        ("POST", "/prefix/ModelInfo", {"name": "forward"}),
        ("POST", "/prefix/InputSizes", named),
        ("POST", "/prefix/OutputSizes", named),
        ("POST", "/prefix/Evaluate", {**named, "input": [[8.0], [3e5, 355e6]]}),
    ]
    (warning,) = findings_of(answer)
    assert (warning.subject, warning.refusal, warning.outside) == ("server", False, True)
    assert "does not tell which scenario" in warning.text
    assert "striker.velocity, column.axial_load, steel.yield_stress" in warning.text


NAN, DEEP = whole(200, b'{"output": [[NaN]]}'), whole(200, b"[" * 100_000)
FALLS = {"mechanism": "geometry", "parts": ["below"], "displacement": 0.5, "time": 0.01}


@pytest.mark.parametrize(
    ("changes", "outcome", "words"),
    [
        ({"Info": {"protocolVersion": 0.9, "models": ["a"]}}, "crashed", "version 0.9"),
        ({"Info": {"models": ["a"]}}, "crashed", "version None"),
        ({"Info": {"protocolVersion": 1.0, "models": "a"}}, "crashed", "take another"),
        ({"Info": {"protocolVersion": 1.0, "models": []}}, "invalid-input", "has []"),
        ({"Info": {"protocolVersion": 1.0, "models": [["a"]]}}, "invalid-input", "name one"),
        ({"Info": {"protocolVersion": 1.0, "models": ["a", "b"]}}, "invalid-input", "['a', 'b']"),
        ({"Info": whole(404, b"<html>")}, "crashed", "HTTP 404"),
        ({"Info": whole(200, b"<html>")}, "crashed", "no JSON object"),
        ({"Info": whole(200, b"\xff\xfe")}, "crashed", "no JSON object"),
        ({"Info": DEEP}, "crashed", "no JSON object"),
        ({"Info": [1]}, "crashed", "no JSON object"),
        ({"Info": whole(302, b"", Location="http://127.0.0.1:1/Info")}, "crashed", "elsewhere"),
        ({"Evaluate": whole(307, b"", Location="/Info")}, "crashed", "elsewhere"),
        ({"Info": lambda handler: handler.wfile.write(b"SSH-2.0\r\n")}, "crashed", "no answer"),
        ({"Info": lambda handler: None}, "crashed", "no answer"),
        ({"Evaluate": whole(200, b'{"output": [[0.12', **{"Content-Length": 90})}, "crashed", ""),
        ({"ModelInfo": {}}, "crashed", "no Evaluate"),
        ({"ModelInfo": {"support": ["Evaluate"]}}, "crashed", "no Evaluate"),
        ({"ModelInfo": {"support": {"Evaluate": "yes"}}}, "crashed", "no Evaluate"),
        ({"InputSizes": {"inputSizes": [2]}}, "crashed", "inputSizes at http"),
        ({"InputSizes": {"inputSizes": [2, -1]}}, "crashed", "inputSizes at http"),
        ({"InputSizes": {"inputSizes": [True]}}, "crashed", "inputSizes at http"),
        ({"InputSizes": {"inputSizes": 1}}, "crashed", "inputSizes at http"),
        ({"OutputSizes": {"outputSizes": [10**12]}}, "crashed", "not those of peak_displacement"),
        ({"OutputSizes": {}}, "crashed", "outputSizes at http"),
        ({"Evaluate": {"output": [0.1]}}, "crashed", "not lists of [1] numbers"),
        ({"Evaluate": {"output": [[0.1, 0.2]]}}, "crashed", "not lists of [1] numbers"),
        ({"Evaluate": {"output": [[0.1], [0.2]]}}, "crashed", "not lists of [1] numbers"),
        ({"Evaluate": {"output": [["0.1"]]}}, "crashed", "not lists of [1] numbers"),
        ({"Evaluate": {"output": [[True]]}}, "crashed", "not lists of [1] numbers"),
        ({"Evaluate": {"output": [[None]]}}, "crashed", "not lists of [1] numbers"),
        ({"Evaluate": {}}, "crashed", "puts out None"),
        ({"Evaluate": NAN}, "not-converged", "not finite"),
        ({"Evaluate": {"output": [[1e300]]}}, "not-converged", "not finite"),
        ({"Evaluate": {"output": [[10**400]]}}, "not-converged", "not finite"),
        ({"Evaluate": whole(200, b"9" * 5000)}, "crashed", "no JSON object"),
        ({"Evaluate": error("NotConverged")}, "not-converged", "NotConverged: why"),
        ({"Evaluate": error("TimedOut")}, "timed-out", "TimedOut: why"),
        ({"Evaluate": error("InvalidInput", status=400)}, "invalid-input", "InvalidInput: why"),
        ({"Evaluate": error("OutOfDomain", status=200)}, "out-of-domain", "OutOfDomain: why"),
        ({"Evaluate": error("Ok", status=200)}, "crashed", "Ok: why"),
        ({"Evaluate": error("\x1b[2J<b>", "a\nb")}, "crashed", "\\x1b[2J<b>: a\\nb"),
        ({"Evaluate": error(["x"], {"y": 1})}, "crashed", "?: ?"),
        ({"Evaluate": error("Collapse")}, "crashed", "Collapse: why"),
        ({"Evaluate": error("Collapse", collapse=FALLS)}, "collapse", "why"),
        *(
            ({"Evaluate": error("Collapse", collapse=how)}, "crashed", "Collapse: why")
            for how in (
                5,
                {**FALLS, "mechanism": "magic"},
                {**FALLS, "mechanism": ["geometry"]},
                {**FALLS, "parts": [5]},
                {**FALLS, "displacement": "far"},
                {**FALLS, "displacement": None},
                {**FALLS, "displacement": 1e300},
                {**FALLS, "time": [1]},
            )
        ),
        *(
            ({"ModelInfo": {**GOOD["/ModelInfo"], "workbench": told}}, "crashed", "no scenario")
            for told in (
                None,
                5,
                {},
                {"inputs": [], "outputs": [], "scenario": "kind = 5"},
                {"inputs": [], "outputs": [], "scenario": {"striker": 5}},
            )
        ),
    ],
)
def test_a_server_that_is_none_gives_an_outcome_with_a_sentence(changes, outcome, words) -> None:
    with standing(**changes) as (url, _):
        answer = Remote(url, timeout=30.0).simulate(HIT)
    assert outcome_of(answer).value == outcome
    assert words in answer.attrs["message"]
    assert len(answer.attrs["message"].split()) >= 4
    assert answer.attrs["message"].isprintable()
    assert not answer.data_vars
    assert bool(collapse_of(answer)) == (outcome == "collapse")
    warned = [finding for finding in findings_of(answer) if not finding.refusal]
    assert outcome != "collapse" or "does not tell which scenario" in warned[0].text


FLOOD = b"HTTP/1.1 200 OK\r\n\r\n"


@pytest.mark.parametrize(
    "write",
    [
        dripping(b"HTTP/1.1 200 OK\r\nX: ", b"x"),
        dripping(b"HTTP/1.1 200 OK\r\nContent-Length: 90000\r\n\r\n", b" "),
        dripping(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n", b"1\r\n \r\n"),
        dripping(b"", b"HTTP/1.1 100 Continue\r\n\r\n"),
        lambda handler: time.sleep(3.0),
    ],
)
@pytest.mark.parametrize("path", ["Info", "Evaluate"])
def test_an_answer_that_never_ends_is_timed_out(write, path) -> None:
    with standing(**{path: write}) as (url, _):
        begun = time.monotonic()
        answer = Remote(url, timeout=0.6).simulate(HIT)
        assert time.monotonic() - begun < 2.5
    assert outcome_of(answer) is Outcome.TIMED_OUT
    assert f"/{path} has not answered in time" in answer.attrs["message"]


def test_a_body_beyond_the_limit_is_not_read_on(monkeypatch) -> None:
    sent = []

    def write(handler):
        handler.wfile.write(FLOOD)
        for _ in range(1000):
            sent.append(handler.wfile.write(b" " * 100_000))

    with standing(Evaluate=write) as (url, _):
        answer = Remote(url).simulate(HIT)
    assert outcome_of(answer) is Outcome.CRASHED
    assert "more than 1 MB" in answer.attrs["message"]
    assert sum(sent) < 20 * LARGEST  # with what lies on the way


def test_no_server_is_one_sentence() -> None:
    with socket.socket() as bound:  # and does not listen
        bound.bind(("127.0.0.1", 0))
        answer = Remote(f"http://127.0.0.1:{bound.getsockname()[1]}").simulate(HIT)
    assert outcome_of(answer) is Outcome.CRASHED
    assert "Connection refused; start the server" in answer.attrs["message"]
    for url in ("http://localhost:99999", "http://a..b", "https://127.0.0.1:1"):
        answer = Remote(url).simulate(HIT)
        assert outcome_of(answer) is Outcome.CRASHED
        assert "no answer from" in answer.attrs["message"]


def test_a_server_of_http_alone_is_none_of_https() -> None:
    with standing() as (url, _):
        answer = Remote(url.replace("http:", "https:")).simulate(HIT)
    assert outcome_of(answer) is Outcome.CRASHED


def test_no_proxy_is_asked(monkeypatch) -> None:
    monkeypatch.setenv("http_proxy", "http://127.0.0.1:1")
    with standing() as (url, _):
        assert outcome_of(Remote(url).simulate(HIT)) is Outcome.OK


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"url": "ftp://localhost"}, "must be http://HOST:PORT"),
        ({"url": "file:///etc/passwd"}, "must be http://HOST:PORT"),
        ({"url": "localhost:4242"}, "must be http://HOST:PORT"),
        ({"url": "http://"}, "must be http://HOST:PORT"),
        ({"url": "http://user:word@localhost"}, "without user"),
        ({"url": "http://localhost?a=1"}, "query"),
        ({"url": "http://localhost#a"}, "fragment"),
        ({"url": "http://local host"}, "must be http"),
        ({"url": "http://localhost/a\r\nX: y"}, "one line"),
        ({"url": "http://müller"}, "must be http"),
        ({"url": "http://localhost:port"}, "must be http"),
        ({"config": "[]"}, "must be a JSON object"),
        ({"config": "{"}, "must be a JSON object"),
        ({"config": "[" * 2000}, "must be a JSON object"),
        ({"inputs": []}, "0 are given"),
        ({"inputs": ["a", "a"]}, "stands twice"),
        ({"outputs": ["colour"]}, "peak_displacement"),
        ({"outputs": "impulse"}, "lists stand in brackets"),
        ({"timeout": 0.0}, "from 0.001"),
    ],
)
def test_bad_options_are_one_message(options, words) -> None:
    with pytest.raises(InputError, match=r"^option\.") as caught:
        make_model("remote", options)
    assert words in str(caught.value)


def test_addresses_of_all_forms_are_allowed() -> None:
    for url in ("http://localhost:4242", "https://example.org/a/b/", "http://[::1]:4242"):
        assert Remote(url).url == url


def test_the_command_line_asks_a_server(ours, tmp_path, capsys) -> None:
    file = tmp_path / "hit.toml"
    file.write_text(to_toml(HIT))
    command = ["simulate", str(file), "--model", "remote", "--option", f"url={ours.url}"]
    both = f"outputs={json.dumps(BOTH)}"
    assert run([*command, "--option", both, "--set", "striker.velocity=6", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    direct = make_model("four-dof").simulate(HIT.at_velocity(6.0))
    peak = float(direct["peak_displacement"])
    assert answer["peak_displacement"] == pytest.approx(peak, rel=1e-12)
    assert answer["error"]["low"] < answer["error"]["expected"] < answer["error"]["high"]
    assert run([*command, "--option", both, "--set", "striker.mass=900"]) == 1
    assert "stands for another scenario" in " ".join(capsys.readouterr().out.split())
    assert run([*command, "--option", "url=ftp://x"]) == 2
    error = capsys.readouterr().err
    assert "option.url" in error
    assert error.count("\n") == 1
    with standing(Evaluate=error_with_html) as (url, _):
        assert run(["simulate", str(file), "--model", "remote", "--option", f"url={url}"]) == 1
    assert "<script>" in capsys.readouterr().out  # as text


def error_with_html(handler):
    error("Boom", "<script>alert(1)</script>")(handler)
