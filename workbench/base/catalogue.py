"""The data catalogue: what each table holds, where it is from, what it may be used for."""

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import pandas as pd

from workbench.base.codec import read
from workbench.base.datafiles import data_directory, open_input, own_data_directory
from workbench.base.errors import InputError, one_line
from workbench.base.fields import Choice, Declared, Instance, Many, Text, checked, did_you_mean
from workbench.base.tables import frame_of

CATALOGUE = "catalogue.toml"
SYNTHETIC = "synthetic"  # the role of made numbers, which show a form and validate nothing
IMPORTED = "imported"  # name of the model that holds answers of other programs
DATA = ("published", "measured", IMPORTED)  # models that hold numbers and compute none
ROLES = ("calibrate", "validate", "verify", SYNTHETIC)
OTHER, IMPACT_TESTS, ANSWERS = "other", "impact-tests", "answers"  # kinds of tables
STUD_TESTS, STUD_POINTS = "stud-tests", "stud-points"
TEXT, MAYBE = Text(2000), Text(2000, shortest=0)
TABLE = Instance(dict, read=lambda value, path: Instance(dict).check(path, value))


@dataclass(frozen=True)
class Dataset(Declared, table="dataset", label="name"):
    """One table of the catalogue.

    `file` is relative to the `folder` of its catalogue; `kind` says of which schema its rows are;
    `role` says what they may be used for; `made`, how the file came about;
    `uncertainty` says how well they are known; `columns` names every column with its meaning;
    `scenario` and `axis` (optional) give the scenario file that published rows belong to and
    the key that a column of the table varies; `asked`, the tables of the scenario that it answers.
    """

    name: str = checked(TEXT)
    title: str = checked(TEXT)
    file: str = checked(TEXT)
    source: str = checked(TEXT)
    licence: str = checked(TEXT)
    role: str = checked(Choice(ROLES))
    uncertainty: str = checked(TEXT)
    columns: dict[str, str] = checked(TABLE)
    units: str = checked(TEXT, "SI, as the column names say")
    key: str = checked(MAYBE, "")
    scenario: str = checked(MAYBE, "")
    axis: str = checked(MAYBE, "")
    axis_column: str = checked(MAYBE, "")
    kind: str = checked(Choice((OTHER, IMPACT_TESTS, STUD_TESTS, STUD_POINTS, ANSWERS)), OTHER)
    year: str = checked(MAYBE, "")
    made: str = checked(MAYBE, "")
    folder: str = checked(MAYBE, "")
    asked: dict[str, Any] | None = checked(TABLE, optional=True)

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of the works behind the table; `key` lists them with spaces between."""
        return tuple(self.key.split())

    @property
    def path(self) -> Path:
        """Where the table is."""
        return Path(self.folder) / self.file


@dataclass(frozen=True)
class Catalogue(Declared):
    """The file of all datasets."""

    datasets: tuple[Dataset, ...] = checked(Many(Instance(Dataset), 1), path="dataset")


def datasets() -> tuple[Dataset, ...]:
    """All datasets, those that come with the workbench and the user's own.

    Raises `InputError` if a catalogue is broken.
    """
    user_catalogue = own_data_directory() / CATALOGUE
    shipped = datasets_in(data_directory() / CATALOGUE)
    return (*shipped, *datasets_in(user_catalogue)) if user_catalogue.is_file() else shipped


def datasets_in(path: Path) -> tuple[Dataset, ...]:
    """The datasets of one catalogue. Raises `InputError`."""
    try:
        return _datasets(path.read_text(encoding="utf-8"), str(path.parent))
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise InputError(f"{path}, {error.field}", error.value, error.allowed) from error
        raise InputError("data catalogue", str(path), f"cannot be read: {error}") from error


@lru_cache(maxsize=4)  # every answer from tests asks for it
def _datasets(text: str, folder: str) -> tuple[Dataset, ...]:
    catalogue: Catalogue = read(Catalogue, tomllib.loads(text))
    return tuple(replace(entry, folder=folder) for entry in catalogue.datasets)


def dataset(name: str) -> Dataset:
    """The dataset of this name. Raises `InputError` with the nearest names."""
    entries = {entry.name: entry for entry in datasets()}
    return entries[Choice(tuple(entries), did_you_mean(name, entries)).check("dataset", name)]


def load(name: str) -> pd.DataFrame:
    """The rows of a dataset. Raises `InputError` for a file that is no table."""
    return _rows(dataset(name))


def _rows(entry: Dataset) -> pd.DataFrame:
    place = f"dataset {entry.name}"
    try:
        with open_input(entry.path, place) as stream:
            return frame_of(stream)
    except InputError:
        raise
    except (OSError, ValueError) as error:  # cells too many in a row, other encodings, no text
        text = f"cannot be read: {one_line(str(error).strip(), 200)}"
        raise InputError(place, str(entry.path), text, "save it as CSV (UTF-8)") from error


def check() -> list[str]:
    """Problems of the whole catalogue, one sentence each; empty when all is well."""
    entries = datasets()
    names = [entry.name for entry in entries]
    twice = [f"dataset {n}: the name stands twice" for n in set(names) if names.count(n) > 1]
    problems = (f"dataset {entry.name}: {text}" for entry in entries for text in _problems(entry))
    return [*sorted(twice), *problems]


def _problems(entry: Dataset) -> Iterator[str]:
    if not entry.path.is_file():
        yield f"file {entry.file} is missing"
        return
    try:
        table = _rows(entry)
    except InputError as error:
        yield f"{error.allowed}; {error.advice}"
        return
    given, described = set(table.columns), set(entry.columns)
    yield from (f"column {name} is not described" for name in sorted(given - described))
    yield from (f"column {name} is missing in the file" for name in sorted(described - given))
    if table.empty:
        yield "the table has no rows"
    if entry.scenario and not (data_directory() / entry.scenario).is_file():
        yield f"scenario file {entry.scenario} is missing"
