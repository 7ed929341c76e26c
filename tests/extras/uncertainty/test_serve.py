"""`workbench serve`: raw HTTP by the protocol of UM-Bridge."""

import http.client
import json
import signal
import socket
import subprocess
import sys
import threading
import time
from functools import partial

import pytest
from waitress import wasyncore

from workbench.cli import run
from workbench.extras.uncertainty.service import Server, Service
from workbench.models.base import make_model
from workbench.scenarios import Column, ColumnImpact, Striker, to_toml

SCENARIO = ColumnImpact(
    "hit", Column("HEB 220", 2.0, 2.0, axial_load=3e5), Striker(1500.0, 8.0), duration=0.2
)
MODEL = "single-dof"


@pytest.fixture(scope="module")
def served():
    keys = ["striker.velocity", "steel.yield_stress"]
    service = Service(make_model(MODEL), SCENARIO, keys, ["peak_displacement", "impulse"])
    server = Server(service, "127.0.0.1", 0)
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    yield server
    server.trigger.pull_trigger(lambda: wasyncore.close_all(server._map))
    thread.join()


def ask(server, method, path, body=None, raw=None, **headers):
    connection = http.client.HTTPConnection("127.0.0.1", server.effective_port, timeout=60)
    content = raw if raw is not None else (None if body is None else json.dumps(body))
    connection.request(method, path, content, {"Content-Type": "application/json", **headers})
    response = connection.getresponse()
    assert response.headers["Content-Type"] == "application/json"
    reply = json.loads(response.read())
    connection.close()
    return response.status, reply


def test_the_protocol_says_what_is_served(served):
    assert ask(served, "GET", "/Info") == (200, {"protocolVersion": 1.0, "models": [MODEL]})
    named = {"name": MODEL, "config": {}}
    assert ask(served, "POST", "/InputSizes", named) == (200, {"inputSizes": [2]})
    assert ask(served, "POST", "/OutputSizes", named) == (200, {"outputSizes": [2]})
    support = ask(served, "POST", "/ModelInfo", {"name": MODEL})[1]["support"]
    features = ("Evaluate", "Gradient", "ApplyJacobian", "ApplyHessian")
    assert support == dict(zip(features, (True, False, False, False), strict=True))


def test_evaluations_are_the_answers_of_single_calls(served):
    asked = {"name": MODEL, "input": [[11, 300e6]], "config": {}}
    status, reply = ask(served, "POST", "/Evaluate", asked)
    steel = SCENARIO.column.steel.changed(yield_stress=300e6)
    column = SCENARIO.column.changed(steel=steel)
    response = make_model(MODEL).simulate(SCENARIO.at_velocity(11.0).changed(column=column))
    assert status == 200
    known = [float(response.peak_displacement), float(response.impulse)]
    assert reply["output"] == [pytest.approx(known, rel=1e-12)]


@pytest.mark.parametrize(
    ("path", "body", "status", "kind", "message"),
    [
        ("/Evaluate", {"name": "other", "input": [[8.0, 3e8]]}, 400, "ModelNotFound", MODEL),
        ("/Evaluate", {"name": MODEL}, 400, "InvalidInput", "one list"),
        ("/Evaluate", {"name": MODEL, "input": [8.0, 3e8]}, 400, "InvalidInput", "one list"),
        ("/Evaluate", {"name": MODEL, "input": [[8.0], [3e8]]}, 400, "InvalidInput", "one list"),
        ("/Evaluate", {"name": MODEL, "input": [[8.0]]}, 400, "InvalidInput", "2 finite"),
        ("/Evaluate", {"name": MODEL, "input": [[True, 3e8]]}, 400, "InvalidInput", "2 finite"),
        ("/Evaluate", {"name": MODEL, "input": [["8", 3e8]]}, 400, "InvalidInput", "2 finite"),
        ("/Evaluate", {"name": MODEL, "input": [[-8.0, 3e8]]}, 400, "InvalidInput", "velocity"),
        (
            "/Evaluate",
            {"name": MODEL, "input": [[float("nan"), 3e8]]},
            400,
            "InvalidInput",
            "finite",
        ),
        (
            "/Evaluate",
            {"name": MODEL, "input": [[10**400, 3e8]]},
            400,
            "InvalidInput",
            "finite",
        ),
        ("/Evaluate", {"name": MODEL, "input": [[80.0, 3e8]]}, 500, "Collapse", "collapse"),
        (
            "/Evaluate",
            {"name": MODEL, "input": [[8.0, 3e8]], "config": {"a": 1}},
            400,
            "In",
            "conf",
        ),
        ("/Gradient", {"name": MODEL}, 400, "UnsupportedFeature", "Gradient"),
        ("/nothing", {"name": MODEL}, 404, "NotFound", "/nothing"),
        ("/InputSizes", [1], 400, "ModelNotFound", MODEL),
    ],
)
def test_requests_without_an_answer_are_error_objects(served, path, body, status, kind, message):
    replied, reply = ask(served, "POST", path, body)
    assert replied == status
    assert reply["error"]["type"].startswith(kind)
    assert message in reply["error"]["message"]


def test_garbage_and_silence_end_no_server(served):
    for raw in (b"{", b"", b"\xff\xfe", b"[" * 100_000):
        status, reply = ask(served, "POST", "/Evaluate", raw=raw)
        assert (status, reply["error"]["type"]) == (400, "InvalidInput")
    assert ask(served, "GET", "/Evaluate")[0] == 404
    assert ask(served, "GET", "/Info")[0] == 200


HEAD = b"POST /Evaluate HTTP/1.1\r\nHost: localhost\r\n"


def connect(server):
    return socket.create_connection(("127.0.0.1", server.effective_port), timeout=30)


@pytest.mark.parametrize(
    ("length", "status"),
    [
        (b"999999999999", b"413"),
        (b"9" * 4000, b"413"),
        (b"9" * 5000, b"431"),  # the head is too large
        (b"-5", b"400"),
        (b"five", b"400"),
        (b"5, 7", b"400"),
    ],
)
def test_lengths_that_cannot_be_have_an_answer(served, length, status):
    with connect(served) as client:
        client.sendall(HEAD + b"Content-Length: " + length + b"\r\n\r\n{}")
        assert client.makefile("rb").readline().split()[1] == status


def test_slow_and_silent_clients_hold_no_one_and_are_left(served, monkeypatch):
    with connect(served) as slow, connect(served) as silent:
        slow.sendall(HEAD + b"Content-Length: 500\r\n\r\n{")
        begun = time.monotonic()
        assert ask(served, "GET", "/Info")[0] == 200
        assert time.monotonic() - begun < 5.0
        monkeypatch.setattr("workbench.extras.uncertainty.service.PATIENCE", 0.5)
        served.adj.channel_timeout = 0.5
        for client in (slow, silent):
            assert client.recv(100) == b""
    served.adj.channel_timeout = 10


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Host": "evil.example"}, 403),
        ({"Host": "evil.example:4242"}, 403),
        ({"Host": "["}, 403),
        ({"Host": "10.0.0.1"}, 403),
        ({"Host": "LOCALHOST:80"}, 200),
        ({"Host": "[::1]:4242"}, 200),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Origin": "http://127.0.0.1:8000"}, 200),
    ],
)
def test_pages_of_other_places_are_refused(served, headers, status):
    replied, reply = ask(served, "GET", "/Info", **headers)
    assert replied == status
    if status == 403:
        assert reply["error"]["type"] == "Forbidden"


def test_two_hundred_at_once_are_all_answered(served):
    clients = [connect(served) for _ in range(200)]
    body = json.dumps({"name": MODEL, "input": [[8.0, 3e8]]}).encode()
    for client in clients:
        client.sendall(HEAD + b"Content-Length: %d\r\n\r\n" % len(body) + body)
    for client in clients:
        assert client.makefile("rb").readline().split()[1] == b"200"
        client.close()


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "column.toml"
    path.write_text(to_toml(SCENARIO))
    return str(path)


def started(program, file):
    """A process that serves, and its port."""
    verb = ["serve", file, "--over", "striker.velocity", "--model", MODEL, "--port", "0", "--json"]
    process = subprocess.Popen(
        [sys.executable, "-c", program, *verb],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_IGN),  # as a shell's job has it
    )
    line = process.stderr.readline()
    assert "is served at http://127.0.0.1:" in line
    return process, int(line.split("http://127.0.0.1:")[1].split()[0])


MAIN = "from workbench.cli import main; main()"


@pytest.mark.thorough
def test_the_verb_serves_until_it_is_interrupted(file):
    process, port = started(MAIN, file)
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=300)
    connection.request("POST", "/Evaluate", json.dumps({"name": MODEL, "input": [[8.0]]}))
    assert len(json.loads(connection.getresponse().read())["output"][0]) == 1
    connection.close()
    process.send_signal(signal.SIGINT)
    out, error = process.communicate(timeout=60)
    assert process.returncode == 0
    assert json.loads(out) == {"model": MODEL, "evaluations": 1}
    assert error == ""


@pytest.mark.thorough
def test_an_interrupt_ends_a_long_request_too(file):
    slow = "import time; from workbench.extras.uncertainty import service; "
    slow += "service.Service.evaluate = lambda *_: time.sleep(100.0); " + MAIN
    process, port = started(slow, file)
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=300)
    connection.request("POST", "/Evaluate", json.dumps({"name": MODEL, "input": [[8.0]]}))
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    begun = time.monotonic()
    process.communicate(timeout=60)
    assert process.returncode == 0
    assert time.monotonic() - begun < 20.0
    connection.close()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--over", "striker.colour"), "--over"),
        (("--over", "column.section"), "--over"),
        (("--over", "striker"), "--over"),
        (("--over", "striker.velocity.x"), "value, not a table"),
        (("--over", "striker.velocity", "--quantity", "colour"), "--quantity"),
        (("--over", "striker.velocity", "--port", "70000"), "--port"),
        (("--over", "striker.velocity", "--port", "1", "--host", "256.0.0.1"), "--port"),
        (("--over", "striker.velocity", "--model", "nothing"), "nothing"),
    ],
)
def test_bad_input_is_one_line(file, capsys, arguments, message):
    assert run(["serve", file, *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_a_port_that_is_taken_is_one_line(file, served, capsys):
    port = str(served.effective_port)
    assert run(["serve", file, "--over", "striker.velocity", "--port", port]) == 2
    assert "cannot be listened at" in capsys.readouterr().err
