"""Processes of samples and references end with what started them."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

SLOW = """
import os, sys, time
from pathlib import Path
from workbench.study.batches import Processes

def slow(_):
    Path(sys.argv[1], str(os.getpid())).touch()
    time.sleep(300.0)

if __name__ == "__main__":
    with Processes(2) as run:
        list(run(slow, range(8)))
"""


@pytest.mark.thorough
@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs to see other processes")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_processes_end_with_the_one_that_started_them(tmp_path, number):
    script, folder = tmp_path / "slow.py", tmp_path / "begun"
    script.write_text(SLOW)
    folder.mkdir()
    with subprocess.Popen(
        [sys.executable, str(script), str(folder)],
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        start_new_session=True,
    ) as process:
        until = time.monotonic() + 120.0
        while len(list(folder.iterdir())) < 2 and time.monotonic() < until:
            time.sleep(0.05)
        workers = [Path("/proc", each.name) for each in folder.iterdir()]
        assert len(workers) == 2
        begun = time.monotonic()
        os.kill(process.pid, number)
        process.communicate(timeout=60)
        while any(map(is_alive, workers)) and time.monotonic() < begun + 60.0:
            time.sleep(0.05)
        assert time.monotonic() - begun < 15.0  # some 0.1 s; tests share their machine
        assert not any(map(is_alive, workers))


def is_alive(process: Path) -> bool:
    try:
        return (process / "stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
