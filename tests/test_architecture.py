"""The house: a floor imports only from floors below it; modules stay small."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

import workbench

ROOT = Path(workbench.__file__).parent
FLOORS = (
    *("base", "steel", "responses", "scenarios", "mechanics", "models", "testing", "studs"),
    *("study", "report", "api", "cli", "extras"),
)
MODULES = sorted(ROOT.rglob("*.py"))
NO_NOUN = re.compile(r"(What|That|Those|As|The same)\b")


def floor_of(module: str) -> str | None:
    parts = module.split(".")
    return parts[1] if len(parts) > 1 and parts[0] == "workbench" else None


def name_of(path: Path) -> str:
    parts = ("workbench", *path.relative_to(ROOT).with_suffix("").parts)
    return ".".join(parts).removesuffix(".__init__")


CORE_MODULES, CORE_LINES = 217, 58_122
NAMES = {name_of(path) for path in MODULES}


@cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    return tuple(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


@cache
def imported(path: Path) -> frozenset[str]:
    names: set[str] = set()
    for node in nodes(path):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                names.add(inner if inner in NAMES else node.module)
    return frozenset(names)


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_no_floor_imports_from_above(path: Path) -> None:
    here = path.relative_to(ROOT).with_suffix("").parts[0]
    if here == "__init__":
        return
    assert here in FLOORS, f"{here} has no floor: add it to the list in its place"
    for name in imported(path):
        floor = floor_of(name)
        if floor is not None and floor.isidentifier() and floor in FLOORS:
            assert FLOORS.index(floor) <= FLOORS.index(here), f"{path} imports {name}"


def is_companion(path: Path) -> bool:
    return path.relative_to(ROOT).parts[0] == "extras"


def test_modules_hold_one_thought() -> None:
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in MODULES}
    assert max(lengths.values()) <= 700  # a module cut by the ruler is as bad as a heap
    core = [path for path in MODULES if not is_companion(path)]
    assert len(core) <= CORE_MODULES
    assert sum(lengths[path] for path in core) <= CORE_LINES


def test_no_class_name_stands_twice() -> None:
    names = [
        node.name for path in MODULES for node in nodes(path) if isinstance(node, ast.ClassDef)
    ]
    assert not {name for name in names if names.count(name) > 1}


def test_the_core_knows_no_companion() -> None:
    for path in MODULES:
        if not is_companion(path):
            assert not [name for name in imported(path) if name.startswith("workbench.extras")], (
                path
            )


def test_the_picture_of_the_house_shows_every_room() -> None:
    picture = (ROOT.parent / "docs" / "house.svg").read_text(encoding="utf-8")
    companions = {p.relative_to(ROOT).parts[1] for p in MODULES if is_companion(p)} - {
        "__init__.py"
    }
    rooms = {*FLOORS, *companions} - {"testing", "extras"}  # the kit for plug-ins is no room
    assert not {room for room in rooms if re.search(rf"[> ]{room}[<,]", picture) is None}


def test_only_what_this_program_packed_itself_is_unpickled() -> None:
    """SECURITY.md says so; the folder of compiled kernels is guarded in `base/compiled.py`."""
    loaders = {"pickle", "marshal", "shelve", "joblib", "dill", "cloudpickle", "yaml"}
    found = {path.relative_to(ROOT).as_posix() for path in MODULES if imported(path) & loaders}
    assert found == {"study/cells.py", "testing.py"}


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_no_function_takes_more_than_ten_arguments(path: Path) -> None:
    for node in nodes(path):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            taken = node.args
            count = len(taken.posonlyargs) + len(taken.args) + len(taken.kwonlyargs)
            is_verb = any(isinstance(d, ast.Name) and d.id == "verb" for d in node.decorator_list)
            # the options of a verb are its page of help, not a call that someone writes
            assert count <= (16 if is_verb else 10), f"{node.name} takes {count}"


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_docstrings_begin_with_a_noun_or_a_verb(path: Path) -> None:
    documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
    texts = (ast.get_docstring(node) or "" for node in nodes(path) if isinstance(node, documented))
    assert not [text for text in texts if NO_NOUN.match(text)]


def test_packages_have_no_import_cycles() -> None:
    graph = {name_of(p): {n for n in imported(p) if n in NAMES} for p in MODULES}
    done: set[str] = set()

    def visit(module: str, trail: tuple[str, ...]) -> None:
        assert module not in trail, f"import cycle: {' -> '.join((*trail, module))}"
        if module in done or module not in graph:
            return
        for target in graph[module]:
            if target != module:
                visit(target, (*trail, module))
        done.add(module)

    for module in graph:
        visit(module, ())


def test_tests_use_public_names() -> None:
    for path in sorted(Path(__file__).parent.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("workbench"):
                words = [*node.module.split("."), *(alias.name for alias in node.names)]
                private = [w for w in words if w.startswith("_") and not w.endswith("__")]
                assert not private, f"{path.name} imports {private}"
