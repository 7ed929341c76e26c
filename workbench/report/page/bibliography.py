"""The works that models, data and metrics rest on, by key; they stand in ``bibliography.toml``."""

import tomllib
from functools import cache
from pathlib import Path
from typing import NamedTuple

_FILE = Path(__file__).with_name("bibliography.toml")


class Reference(NamedTuple):
    """A published work: `where` names journal, publisher or institution; `doi` may be empty."""

    key: str
    authors: str
    year: str
    title: str
    where: str
    doi: str = ""

    @property
    def short(self) -> str:
        """Authors and year, for texts without a list of references."""
        return f"{self.authors} {self.year}" if self.authors else self.title

    @property
    def who(self) -> str:
        """Text before the title in a list of references."""
        return f"{self.authors} ({self.year}): " if self.authors else ""

    @property
    def place(self) -> str:
        """Text behind the title in a list of references."""
        where = f". {self.where}" if self.where else ""
        return f"{where}." + (f" doi:{self.doi}" if self.doi else "")


@cache
def bibliography() -> dict[str, Reference]:
    """All known works by their keys; the file is read once."""
    entries = tomllib.loads(_FILE.read_text(encoding="utf-8"))
    return {key: Reference(key, **entry) for key, entry in entries.items()}


def reference_of(key: str) -> Reference:
    """The work of a key; a key that the file lacks stands for itself, as written."""
    return bibliography().get(key) or Reference(key, "", "", key, "")


def cited(source: str) -> str:
    """A source as a citation if it is a key of the bibliography, else as written."""
    return f"[@{source}]" if source in bibliography() else source
