"""Put the faults of `faults.toml` into a copy of the package, one at a time, and run their tests.

    python tests/mutants/run.py [--only PATTERN] [--jobs N] [--sound]

A fault is noticed where a test of its own room fails. Nobody collects this script: all faults take
half an hour. Kernels are compiled into a folder of this run (or NUMBA_CACHE_DIR), those that hold
a fault anew: their place is named by all that they are made of (`workbench/base/compiled.py`).
"""

from __future__ import annotations

import argparse
import compileall
import importlib
import os
import re
import shutil
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIST = Path(__file__).with_name("faults.toml")
COPIED, LINKED = ("workbench", "tests", "pyproject.toml"), ("data", "docs", "studies")
PATIENCE = 1800  # s, after which tests are given up
ENOUGH = 0.9  # share of the faults that must be noticed
NOTICED = "noticed"
ENDINGS = {0: "NOT NOTICED", 1: NOTICED, 2: NOTICED, -1: "ERROR: no end"}  # by status of pytest
# imported once: each trial begins with them
SHARED = (
    *("pytest", "numba", "pandas", "xarray", "matplotlib.figure", "jinja2", "rich"),
    *("scipy.optimize", "scipy.stats", "scipy.interpolate", "scipy.sparse.linalg"),
)


@dataclass(frozen=True)
class Fault:
    """A small fault: in `file`, `new` stands for `old`; `tests`, files of its room."""

    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    def __str__(self) -> str:
        words = (" ".join(text.split()) or "nothing" for text in (self.old, self.new))
        return f"{self.file}: {' -> '.join(words)}"


def faults() -> list[Fault]:
    """All faults of the list, in its order."""
    rooms = tomllib.loads(LIST.read_text(encoding="utf-8"))["room"]
    return [
        Fault(f"workbench/{room['file']}", old, new, tuple(f"tests/{t}" for t in room["tests"]))
        for room in rooms
        for old, new in room["faults"]
    ]


def mistakes(listed: Sequence[Fault]) -> Iterator[str]:
    """What is wrong with the list itself: old text that is gone or not unique, missing tests."""
    for fault in listed:
        path = ROOT / fault.file
        times = path.read_text(encoding="utf-8").count(fault.old) if path.is_file() else 0
        if times != 1:
            yield f"{fault}: stands {times} times in the file"
        if fault.old == fault.new:
            yield f"{fault}: changes nothing"
        yield from (f"{fault}: no {test}" for test in fault.tests if not (ROOT / test).is_file())


def copy_of_the_project(place: Path) -> None:
    """Make a copy in which faults can be put in."""
    place.mkdir(exist_ok=True)
    for name in COPIED:
        source, target = ROOT / name, place / name
        if source.is_dir():
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, target)
    for name in LINKED:
        (place / name).symlink_to(ROOT / name)
    compileall.compile_dir(place / "workbench", quiet=1)


def status_of(place: Path, tests: Sequence[str]) -> int:
    """How pytest ends in a copy of the project, in a process of its own; -1 if it does not."""
    child = os.fork()
    if child == 0:
        os.chdir(place)
        os.setsid()
        silent = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silent, 1)
        os.dup2(silent, 2)
        os.environ["PYTHONPATH"] = str(place)
        sys.path.insert(0, str(place))
        status = importlib.import_module("pytest").main(["-x", "-q", "-pno:cacheprovider", *tests])
        os._exit(status)
    given_up = time.monotonic() + PATIENCE
    while time.monotonic() < given_up:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.05)
    os.killpg(child, 9)
    os.waitpid(child, 0)
    return -1


def tried(directory: Path, fault: Fault) -> tuple[str, float]:
    """Whether the tests of a fault notice it, and the time (s) that they took."""
    place = directory / str(os.getpid())
    if not place.exists():
        copy_of_the_project(place)
    path, begun = place / fault.file, time.monotonic()
    whole, times = path.read_text(encoding="utf-8"), path.stat()
    path.write_text(whole.replace(fault.old, fault.new), encoding="utf-8")
    try:
        status = status_of(place, fault.tests)
    finally:
        path.write_text(whole, encoding="utf-8")
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))  # its bytecode counts again
    return ENDINGS.get(status, f"ERROR: status {status}"), time.monotonic() - begun


def main() -> int:
    """Exit status 0 if enough faults are noticed, 1 if not, 2 if the list or a test is wrong."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--only", default="", help="regular expression of faults: file, texts")
    parser.add_argument("--jobs", type=int, default=1, help="faults at a time")
    parser.add_argument("--sound", action="store_true", help="tests are known to pass without one")
    asked = parser.parse_args()
    listed = [fault for fault in faults() if re.search(asked.only, str(fault))]
    wrong = list(mistakes(listed))
    if wrong or not listed:
        print(*wrong or ["no such fault"], sep="\n", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory(prefix="workbench-faults-") as name:
        directory = Path(name)
        os.environ.setdefault("NUMBA_CACHE_DIR", str(directory / "kernels"))
        os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
        sys.dont_write_bytecode = True
        for module in SHARED:
            importlib.import_module(module)
        tests = list(dict.fromkeys(test for fault in listed for test in fault.tests))
        if not asked.sound:
            copy_of_the_project(directory / "sound")
        if not asked.sound and status_of(directory / "sound", tests):
            print("tests of these faults fail without them", file=sys.stderr)
            return 2
        noticed = 0
        with ProcessPoolExecutor(asked.jobs, get_context("fork")) as pool:
            result = pool.map(partial(tried, directory), listed)
            for fault, (verdict, seconds) in zip(listed, result, strict=True):
                noticed += verdict == NOTICED
                print(f"{verdict:12} {seconds:5.0f} s  {fault}", flush=True)
    print(f"{noticed} of {len(listed)} faults noticed, {100 * noticed / len(listed):.0f} %")
    return 0 if noticed >= ENOUGH * len(listed) else 1


if __name__ == "__main__":
    sys.exit(main())
