"""Compiled code of kernels on disk, never older than any file that it was compiled from.

numba compares the file of the function it kept, not those of the functions that are compiled into
it. Here the folder of a file's kernels is named by the content of all that the file imports.
"""

import hashlib
import re
from contextlib import suppress
from functools import cache
from os import environ
from pathlib import Path
from shutil import rmtree
from typing import Any
from uuid import uuid4

from numba import njit
from numba.core import caching
from numba.extending import register_jitable
from numba.misc.appdirs import AppDirs

from workbench.base.datafiles import can_write, private_folder

__all__ = ["KernelCache", "cache_folder", "njit", "register_jitable", "sources", "usual_folder"]

_ROOT = Path(__file__).resolve().parents[1]
_IMPORTS = re.compile(r"^\s*from (workbench[\w.]*) import (\([^)]*\)|[^\n]*)", re.MULTILINE)
_KERNELS = re.compile(r"^from (numba|workbench\.base\.compiled)\b", re.MULTILINE)
_TYPES = re.compile(r"\nclass (\w+)\(NamedTuple\)")
# A first call may compile kernels; answers that take less than this are timed by a second call.
TIMED_AGAIN_BELOW = 180.0  # s
_KEPT = 8  # folders of a file, of older contents and of other installations too


def usual_folder() -> Path:
    """Folder of the user for compiled code; NUMBA_CACHE_DIR overrides the usual place."""
    given = environ.get("NUMBA_CACHE_DIR")
    own = Path(given).absolute() if given else Path(AppDirs("workbench", False).user_cache_dir)
    return own / "kernels"


@cache
def cache_folder() -> Path:
    """Folder of compiled code: the usual one, else a temporary one of this user.

    Without a home the usual one is relative, a folder ``~`` of wherever the user works.
    """
    usual = usual_folder()
    usable = usual.is_absolute() and can_write(usual)
    return usual if usable else private_folder() / "kernels"


@cache
def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@cache
def _file(module: tuple[str, ...]) -> Path | None:
    """File of a module of this package, None if there is none of that name."""
    base = _ROOT.joinpath(*module)
    places = (base.with_suffix(".py"), base / "__init__.py")
    return next((place for place in places if place.is_file()), None)


@cache
def _imported(path: Path) -> tuple[Path, ...]:
    """Files of this package that a file with kernels, or a package, imports from."""
    if path.name != "__init__.py" and not _KERNELS.search(_text(path)):
        return ()
    modules: list[tuple[str, ...]] = []
    for module, names in _IMPORTS.findall(_text(path)):
        parts = tuple(module.split(".")[1:])
        modules.append(parts)
        place = _file(parts)
        if place is None or place.name == "__init__.py":
            modules += [(*parts, name) for name in re.findall(r"\w+", names)]
    return tuple(place for module in modules if (place := _file(module)) is not None)


def sources(path: Path) -> set[Path]:
    """All files whose content is compiled into the kernels of a file.

    Imports are followed through files with kernels and through packages; constants and types may
    stand in any file that one of these imports.
    """
    reached: set[Path] = set()
    waiting = [path.resolve()]
    while waiting:
        place = waiting.pop()
        if place not in reached:
            reached.add(place)
            waiting += _imported(place)
    return reached


@cache
def _types() -> str:
    """Names of all tuple types with their files: what is kept on disk names those it was given."""
    named = ((path, _TYPES.findall(_text(path))) for path in sorted(_ROOT.rglob("*.py")))
    return "\n".join(f"{path.relative_to(_ROOT)} {names}" for path, names in named if names)


@cache
def _folder(file: str) -> Path | None:
    """Folder of the kernels of a file, whose earlier ones are removed; None for others' files."""
    path = Path(file).resolve()
    if _ROOT not in path.parents:
        return None
    digest = hashlib.sha256(_types().encode())
    for place in sorted(sources(path)):
        digest.update(f"{place.relative_to(_ROOT)}\n{_text(place)}\n".encode())
    name = ".".join(path.relative_to(_ROOT).with_suffix("").parts)
    folder = cache_folder() / f"{name}-{digest.hexdigest()[:16]}"
    if not folder.exists():
        ages = {old: old.stat().st_mtime for old in cache_folder().glob(f"{name}-*")}
        for old in sorted(ages, key=ages.__getitem__, reverse=True)[_KEPT - 1 :]:
            rmtree(old, ignore_errors=True)
    return folder


class KernelCache(caching.UserProvidedCacheLocator):
    """Where numba keeps the compiled functions of this package; others' stay where they are."""

    def __init__(self, py_func: Any, py_file: str) -> None:
        self._py_file, self._lineno = py_file, py_func.__code__.co_firstlineno
        self._cache_path = str(_folder(py_file))

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> "KernelCache | None":
        """The place for a function, None for one of another package."""
        return cls(py_func, py_file) if _folder(py_file) else None


class KernelFiles(caching.IndexDataCacheFile):
    """Index and code of a kernel on disk; what is damaged or finds no room is compiled anew.

    Names of code are a process's own: else an index may lead to code that another process compiled
    for other types at the same time.
    """

    def __init__(self, *args: Any, **named: Any) -> None:
        super().__init__(*args, **named)
        self._data_name_pattern = f"{uuid4().hex[:12]}.{self._data_name_pattern}"

    def _load_index(self) -> Any:
        with suppress(Exception):  # damaged bytes raise whatever they spell
            return super()._load_index()
        return {}

    def load(self, key: Any) -> Any:
        """Code of a key: signature, processor, bytecode; None if there is none to be read."""
        with suppress(Exception):
            return super().load(key)
        return None

    def save(self, key: Any, data: Any) -> None:
        """Keep the code of a key, where there is room."""
        with suppress(OSError):
            super().save(key, data)


caching.CacheImpl._locator_classes.insert(0, KernelCache)
caching.IndexDataCacheFile = KernelFiles  # type: ignore[misc]
