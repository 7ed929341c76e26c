from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from workbench.cli import run
from workbench.models.base import make_model
from workbench.responses import Response
from workbench.scenarios import Scenario


def states(text: str) -> dict[str, str]:
    return {check["name"]: check["state"] for check in json.loads(text)["checks"]}


def diagnosed(capsys: pytest.CaptureFixture[str], store: Path) -> dict[str, str]:
    assert run(["doctor", "--json", "--store", str(store)]) == 1
    return states(capsys.readouterr().out)


def test_a_sound_environment(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    status = run(["doctor", "--json", "--store", str(tmp_path / "reports")])
    output = states(capsys.readouterr().out)
    expected = {"libraries", "kernel cache", "store", "disk", "models", "physics four-dof"}
    assert expected <= set(output)
    assert {name for name, state in output.items() if state == "fail"} == set()
    assert output["physics four-dof"] == "ok"
    assert status == 0
    assert not (tmp_path / "reports").exists()  # a check leaves nothing behind


def test_everything_wrong_comes_with_a_remedy(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(blocked / "cache"))
    monkeypatch.setattr("shutil.disk_usage", lambda path: SimpleNamespace(free=1e6))
    monkeypatch.setattr("importlib.metadata.version", lambda name: "0.0.1")

    def wrong(name: str) -> None:
        raise RuntimeError("a kernel is gone")

    monkeypatch.setattr("workbench.models.base.make_model", wrong)
    assert run(["doctor", "--json", "--store", str(tmp_path)]) == 1
    checks = json.loads(capsys.readouterr().out)["checks"]
    by_name = {check["name"]: check for check in checks}
    assert by_name["kernel cache"]["state"] == "warn"
    assert by_name["libraries"]["state"] == "warn"
    assert by_name["disk"]["state"] == "fail"
    assert "a kernel is gone" in by_name["physics"]["detail"]
    for check in checks:
        assert bool(check["remedy"]) == (check["state"] != "ok"), check
    assert run(["doctor", "--store", str(tmp_path)]) == 1
    assert "disk: free some disk space" in capsys.readouterr().out


def test_physics_that_drifts_is_caught(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    sound = make_model("four-dof")

    def simulate(scenario: Scenario) -> Response:
        response = sound.simulate(scenario)
        response["peak_displacement"] = response["peak_displacement"] * 1.01
        return response

    monkeypatch.setattr(
        "workbench.models.base.make_model",
        lambda name, *options: SimpleNamespace(simulate=simulate),
    )
    result = diagnosed(capsys, tmp_path)
    assert result["physics four-dof"] == "fail"


def test_a_store_that_cannot_be_written(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    store = tmp_path / "file" / "reports"
    assert run(["doctor", "--json", "--store", str(store)]) == 1
    checks = json.loads(capsys.readouterr().out)["checks"]
    (check,) = [check for check in checks if check["name"] == "store"]
    assert check["state"] == "fail"
    assert check["remedy"]
