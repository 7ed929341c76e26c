"""Finding and loading study files: Python files that define ``study = Study(...)``."""

import hashlib
import importlib.util
import sys
from dataclasses import dataclass
from pathlib import Path
from traceback import extract_tb

from workbench.base.datafiles import data_directory
from workbench.base.errors import InputError, message_of
from workbench.base.fields import did_you_mean
from workbench.study.definition import Study


@dataclass(frozen=True)
class LoadedStudy:
    """A study and the `file` that defines it, which worker processes load as well."""

    study: Study
    file: Path


def study_files() -> dict[str, Path]:
    """Study files by name: those in ``studies/`` here, then those that come with the workbench."""
    files: dict[str, Path] = {}
    for directory in (Path("studies"), data_directory("studies")):
        for path in sorted(directory.glob("*.py")):
            if not path.stem.startswith("_"):
                files.setdefault(path.stem, path)
    return files


def load_study(name: str | Path) -> LoadedStudy:
    """Load a study by the path of its file or by its name in ``studies/``.

    Raises `InputError` if there is no such study (naming the nearest one), if the file cannot
    be run, or if it does not define ``study = Study(...)``.
    """
    path = Path(name)
    if path.suffix != ".py":
        known = study_files()
        stem = str(name).replace("-", "_")
        if stem not in known:
            near = did_you_mean(stem, known)
            text = f"is not known; {near}".removesuffix("; ")
            advice = f"give the path of a study file, or one of {len(known)} names in ./studies"
            raise InputError("study", str(name), text, advice)
        path = known[stem]
    if not path.is_file():
        raise InputError("study", str(name), "there is no such file")
    return LoadedStudy(study_in(path), path.resolve())


def study_in(path: Path) -> Study:
    """The study that a file defines, imported with its directory on the import path.

    The module name comes from the path, so that a worker process that loads the same file finds
    the classes that the file defines. Raises `InputError`.
    """
    path = path.resolve()
    name = f"workbench_study_{path.stem}_{hashlib.sha256(str(path).encode()).hexdigest()[:8]}"
    if name not in sys.modules:
        if str(path.parent) not in sys.path:
            sys.path.insert(0, str(path.parent))
        specification = importlib.util.spec_from_file_location(name, path)
        if specification is None or specification.loader is None:
            raise InputError("study", str(path), "is not a Python file")
        module = importlib.util.module_from_spec(specification)
        sys.modules[name] = module
        try:
            specification.loader.exec_module(module)
        except (Exception, SystemExit) as error:
            del sys.modules[name]
            if isinstance(error, InputError):
                raise
            trace = extract_tb(error.__traceback__)
            lines = [frame.lineno for frame in trace if frame.filename == str(path)]
            where = f"line {lines[-1]}: " if lines else ""
            text = f"cannot be loaded: {where}{message_of(error)}"
            raise InputError("study", path.name, text) from error
    study = getattr(sys.modules[name], "study", None)
    if not isinstance(study, Study):
        raise InputError("study", path.name, "must define study = Study(...)")
    return study
