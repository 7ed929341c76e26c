"""The data catalogue: what each table holds, where it is from, what it may be used for."""

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import pandas as pd

from workbench.datafiles import data_directory
from workbench.errors import InputError
from workbench.fields import Choice, Declared, Instance, Many, Text, checked, did_you_mean
from workbench.scenarios.codec import read

TEXT, MAYBE = Text(2000), Text(2000, shortest=0)
TABLE = Instance(dict, read=lambda value, path: Instance(dict).check(path, value))


@dataclass(frozen=True)
class Dataset(Declared, table="dataset", label="name"):
    """One table of the catalogue.

    `file` is relative to the data directory; `role` says what the rows may be used for;
    `uncertainty` says how well they are known; `columns` names every column with its meaning;
    `scenario` and `axis` (optional) give the scenario file that published rows belong to and
    the key that a column of the table varies.
    """

    name: str = checked(TEXT)
    title: str = checked(TEXT)
    file: str = checked(TEXT)
    source: str = checked(TEXT)
    licence: str = checked(TEXT)
    role: str = checked(Choice(("calibrate", "validate", "verify")))
    uncertainty: str = checked(TEXT)
    columns: dict[str, str] = checked(TABLE)
    units: str = checked(TEXT, "SI, as the column names say")
    key: str = checked(MAYBE, "")
    scenario: str = checked(MAYBE, "")
    axis: str = checked(MAYBE, "")
    axis_column: str = checked(MAYBE, "")

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of the works behind the table; `key` lists them with spaces between."""
        return tuple(self.key.split())

    @property
    def path(self) -> Path:
        """Where the table is."""
        return data_directory() / self.file


@dataclass(frozen=True)
class Catalogue(Declared):
    """The file of all datasets."""

    datasets: tuple[Dataset, ...] = checked(Many(Instance(Dataset), 1), path="dataset")


def datasets() -> tuple[Dataset, ...]:
    """All datasets of the catalogue. Raises `InputError` if the catalogue itself is broken."""
    path = data_directory() / "catalogue.toml"
    try:
        return _datasets(path.read_text(encoding="utf-8"))
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise InputError("data catalogue", path.name, f"cannot be read: {error}") from error


@lru_cache(maxsize=1)  # every answer from tests asks for it
def _datasets(text: str) -> tuple[Dataset, ...]:
    catalogue: Catalogue = read(Catalogue, tomllib.loads(text))
    return catalogue.datasets


def dataset(name: str) -> Dataset:
    """The dataset of this name. Raises `InputError` with the nearest names."""
    entries = {entry.name: entry for entry in datasets()}
    if name not in entries:
        allowed = "must be one of " + ", ".join(entries)
        raise InputError("dataset", name, allowed, did_you_mean(name, entries))
    return entries[name]


def load(name: str) -> pd.DataFrame:
    """The rows of a dataset."""
    return pd.read_csv(dataset(name).path)


def check() -> list[str]:
    """Problems of the whole catalogue, one sentence each; empty when all is well."""
    entries = datasets()
    names = [entry.name for entry in entries]
    twice = [f"dataset {n}: the name stands twice" for n in set(names) if names.count(n) > 1]
    told = (f"dataset {entry.name}: {text}" for entry in entries for text in _problems(entry))
    return [*sorted(twice), *told]


def _problems(entry: Dataset) -> Iterator[str]:
    if not entry.path.is_file():
        yield f"file {entry.file} is missing"
        return
    table = pd.read_csv(entry.path)
    given, described = set(table.columns), set(entry.columns)
    yield from (f"column {name} is not described" for name in sorted(given - described))
    yield from (f"column {name} is missing in the file" for name in sorted(described - given))
    if table.empty:
        yield "the table has no rows"
    if entry.scenario and not (data_directory() / entry.scenario).is_file():
        yield f"scenario file {entry.scenario} is missing"
