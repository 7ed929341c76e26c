"""Compiled code on disk: never older than what it was compiled from, kept once, one user's."""

from __future__ import annotations

import importlib
import os
import pickle
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher

import workbench
from workbench.base.compiled import KernelCache, KernelFiles, cache_folder, sources
from workbench.base.datafiles import private_folder

PACKAGE = Path(workbench.__file__).parent
KEPT = sorted(p for p in PACKAGE.rglob("*.py") if "cache=True" in p.read_text("utf-8"))
LENGTH = '''"""A kernel that calls the kernel of another file, which reads a constant of a third."""

from workbench.base.compiled import njit
from workbench.{folder}_area import area


@njit(cache=True)
def volume(side):
    """Volume."""
    return side * area(side)
'''
AREA = """from workbench.base.compiled import njit
from workbench.{folder}_factor import FACTOR


@njit
def area(side):
    return FACTOR * side * side
"""


def package_with(folder: Path, factor: float) -> Path:
    """A copy of what compiles, and three files of its own: volume, area, factor."""
    package = folder / "workbench"
    (package / "base").mkdir(parents=True, exist_ok=True)
    base = ("base/__init__", "base/compiled", "base/datafiles", "base/errors")
    for name in ("__init__", *base):
        (package / f"{name}.py").write_text((PACKAGE / f"{name}.py").read_text("utf-8"), "utf-8")
    (package / "cube_volume.py").write_text(LENGTH.format(folder="cube"))
    (package / "cube_area.py").write_text(AREA.format(folder="cube"))
    (package / "cube_factor.py").write_text(f"FACTOR = {factor}\n")
    return folder


def volume(folder: Path, cache: Path) -> tuple[float, int]:
    """Volume of a cube of side 2 as a new process has it, and how often it compiled."""
    code = (
        "from workbench.cube_volume import volume\n"
        "print(volume(2.0), sum(volume.stats.cache_misses.values()))"
    )
    env = {**os.environ, "PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(cache)}
    ran = subprocess.run(
        [sys.executable, "-c", code], env=env, cwd=folder, capture_output=True, text=True
    )
    assert ran.returncode == 0, ran.stderr
    number, compiled = ran.stdout.split()
    return float(number), int(compiled)


@pytest.mark.thorough
def test_an_edit_two_files_away_is_compiled_anew_and_old_code_goes(tmp_path: Path) -> None:
    package, cache = package_with(tmp_path / "tree", 1.0), tmp_path / "cache"
    assert volume(package, cache) == (8.0, 1)
    assert volume(package, cache) == (8.0, 0)  # read from disk
    (folder,) = (cache / "kernels").iterdir()
    for days in range(1, 10):  # what earlier edits left
        older = folder.with_name(f"{folder.name[:-4]}{days:04}")
        older.mkdir()
        os.utime(older, (days, days))
    package_with(tmp_path / "tree", 2.0)
    assert volume(package, cache) == (16.0, 1)
    left = {each.name for each in (cache / "kernels").iterdir()}
    assert len(left) == 8
    assert folder.name in left


@pytest.mark.thorough
def test_a_type_that_moves_to_another_file_is_compiled_for_anew(tmp_path: Path) -> None:
    package, cache = package_with(tmp_path / "tree", 1.0), tmp_path / "cache"
    kernel = "from workbench.base.compiled import njit\n\n\n@njit(cache=True)\ndef side(cube):\n"
    (package / "workbench" / "cube_side.py").write_text(f"{kernel}    return cube.side\n")
    shape = "from typing import NamedTuple\n\n\nclass Cube(NamedTuple):\n    side: float\n"
    env = {**os.environ, "PYTHONPATH": str(package), "NUMBA_CACHE_DIR": str(cache)}
    for name in ("cube_shape", "cube_form"):
        (package / "workbench" / f"{name}.py").write_text(shape)
        code = (
            f"from workbench.{name} import Cube; from workbench.cube_side import side\n"
            "print(side(Cube(2.0)))"
        )
        ran = subprocess.run(
            [sys.executable, "-c", code], env=env, cwd=package, capture_output=True, text=True
        )
        assert ran.stdout == "2.0\n", ran.stderr
        (package / "workbench" / f"{name}.py").unlink()


@pytest.mark.thorough
def test_first_runs_at_once_do_not_disturb_each_other(tmp_path: Path) -> None:
    package, cache = package_with(tmp_path / "tree", 1.0), tmp_path / "cache"
    code = "from workbench.cube_volume import volume; print(volume({}))"
    env = {**os.environ, "PYTHONPATH": str(package), "NUMBA_CACHE_DIR": str(cache)}
    runs = [
        subprocess.Popen(
            [sys.executable, "-c", code.format(side)],
            **{"env": env, "cwd": package, "stdout": subprocess.PIPE, "text": True},
        )
        for side in (2.0, 2) * 2  # code for two types at once, of one name in numba
    ]
    assert [run.communicate()[0].strip() for run in runs] == ["8.0"] * 4
    assert volume(package, cache)[0] == 8.0  # the index of one may have lost what another compiled
    assert volume(package, cache) == (8.0, 0)


def test_a_folder_that_cannot_be_written_leads_to_a_temporary_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(blocked / "cache"))
    monkeypatch.setattr("workbench.base.datafiles.gettempdir", lambda: str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    for others in (False, True):  # a folder that others may change could hold their code
        cache_folder.cache_clear()
        private_folder.cache_clear()
        try:
            folder = cache_folder()
            assert folder.parent.parent == tmp_path
            assert (folder.parent.name == f"workbench-{os.getuid()}") is not others
            folder.parent.mkdir(exist_ok=True)
            folder.parent.chmod(0o777)
        finally:
            cache_folder.cache_clear()
            private_folder.cache_clear()


@pytest.mark.thorough
@pytest.mark.parametrize("ending", ["nbi", "nbc"])
@pytest.mark.parametrize("left", [0, 30, 200])
def test_a_damaged_file_of_code_is_compiled_anew(tmp_path: Path, ending: str, left: int) -> None:
    package, cache = package_with(tmp_path / "tree", 1.0), tmp_path / "cache"
    assert volume(package, cache) == (8.0, 1)
    (kept,) = cache.rglob(f"*.{ending}")
    kept.write_bytes(kept.read_bytes()[:left])
    assert volume(package, cache) == (8.0, 1)
    assert volume(package, cache) == (8.0, 0)


def test_an_index_never_leads_to_code_of_another_process(tmp_path: Path) -> None:
    one, other = (KernelFiles(str(tmp_path), "kernel", "stamp") for _ in range(2))
    one.save("of floats", 1.0)
    (tmp_path / "kernel.nbi").unlink()  # the other one read before this one wrote
    other.save("of integers", 2)
    assert sorted(pickle.loads(path.read_bytes()) for path in tmp_path.glob("*.nbc")) == [1.0, 2]
    assert (other.load("of floats"), other.load("of integers")) == (None, 2)
    KernelFiles(str(tmp_path / "gone"), "kernel", "stamp").save("key", 1.0)  # no room: no error


def test_functions_of_others_stay_where_numba_keeps_them() -> None:
    assert KernelCache.from_function(np.mean, np.__file__) is None


def module_of(path: Path) -> ModuleType:
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return importlib.import_module(".".join(("workbench", *parts)))


def compiled_into(function: Any, seen: set[int]) -> set[Path]:
    """Files of all functions of this package that a function calls by name, itself included."""
    function = getattr(function, "py_func", function)
    code = getattr(function, "__code__", None)
    if code is None or id(function) in seen or not code.co_filename.startswith(str(PACKAGE)):
        return set()
    seen.add(id(function))
    names = [function.__globals__.get(name) for name in code.co_names]
    cells = [cell.cell_contents for cell in getattr(function, "__closure__", None) or ()]
    return {Path(code.co_filename).resolve()}.union(
        *(compiled_into(each, seen) for each in (*names, *cells))
    )


@pytest.mark.parametrize("path", KEPT, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_sources_hold_every_file_that_is_compiled_into_a_kernel(path: Path) -> None:
    for kernel in vars(module_of(path)).values():
        if isinstance(kernel, Dispatcher) and kernel.__module__ == module_of(path).__name__:
            assert compiled_into(kernel, set()) <= sources(path), kernel


def test_every_kernel_is_compiled_through_the_room_that_keeps_code_fresh() -> None:
    for path in PACKAGE.rglob("*.py"):
        if path.name != "compiled.py":
            text = path.read_text("utf-8")
            assert "from numba import" not in text, path
            assert "import numba" not in text, path
