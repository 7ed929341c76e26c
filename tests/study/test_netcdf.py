from __future__ import annotations

import hashlib
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from workbench.responses import Outcome, build_response, failed_response
from workbench.study.store import canonical_json, read_netcdf, to_netcdf_bytes, write_atomically

MAKE = """
import hashlib, json, sys
import numpy as np
from workbench.responses import build_response
from workbench.study.store import to_netcdf_bytes
t = np.linspace(0.0, 0.1, 3000)
r = build_response({"displacement": np.sin(t), "moment": np.outer([1.0, 2.0], t),
    "shear_utilisation": [1.8, 0.2], "peak_force": 3.0}, time=t,
    hinges=["base", "unter dem Stoß"], segments=["below", "above"])
r.attrs.update(message="ok – é", model_version=2, scenario="x" * 5000)
print(hashlib.sha256(to_netcdf_bytes(r)).hexdigest())
"""


@pytest.mark.thorough
def test_equal_responses_give_equal_bytes_in_any_process_at_any_time(
    capsys: pytest.CaptureFixture[str],
) -> None:
    exec(MAKE, {})
    time.sleep(1.1)  # HDF5 time stamps, were there any, count seconds
    done = subprocess.run([sys.executable, "-c", MAKE], capture_output=True, text=True, check=True)
    assert done.stdout == capsys.readouterr().out


def test_what_is_read_is_what_was_written(tmp_path: Path) -> None:
    time_axis = np.linspace(0.0, 0.1, 1000)
    response = build_response(
        {"displacement": np.sin(900.0 * time_axis), "peak_force": 1.0 / 3.0},
        time=time_axis,
    )
    path = tmp_path / "r.nc"
    path.write_bytes(to_netcdf_bytes(response))
    again = read_netcdf(path)
    assert again.identical(response)
    assert again["time"].dtype == np.float64  # seconds, not time spans
    assert again["time"].attrs["units"] == "s"
    assert len(path.read_bytes()) < 2 * response.nbytes


@pytest.mark.parametrize("message", ["", "no convergence – at t = 0.01 s"])
def test_a_failed_response_survives(tmp_path: Path, message: str) -> None:
    response = failed_response(Outcome.NOT_CONVERGED, message)
    path = tmp_path / "r.nc"
    path.write_bytes(to_netcdf_bytes(response))
    assert read_netcdf(path).identical(response)


def test_a_write_that_fails_leaves_the_old_content(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    write_atomically(path, b"old")
    with pytest.raises(TypeError):
        write_atomically(path, "not bytes")  # type: ignore[arg-type]
    assert path.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.json"]


def test_canonical_json() -> None:
    assert canonical_json({"b": np.float64(1.5), "a": "é"}) == (
        '{\n  "a": "é",\n  "b": 1.5\n}\n'.encode()
    )
    with pytest.raises(ValueError, match="not JSON compliant"):
        canonical_json({"a": float("nan")})
    assert hashlib.sha256(canonical_json({})).hexdigest()
