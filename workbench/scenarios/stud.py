"""Tests on studs: which tables, and which campaigns calibrate or validate."""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from workbench.datafiles import open_input
from workbench.errors import InputError
from workbench.fields import Choice, Declared, Many, Number, Text, checked

CSV = ".csv"
ASKED = ("strength", "load-slip", "interaction", "residual-strength", "residual-stiffness")
NAMES = Many(Text(), different=True)


@dataclass(frozen=True)
class StudTests(Declared, table="tests"):
    """Tests on studs and what they are used for.

    Arguments: `asked`, what models are to answer; `tables` of tests and `curves`, tables of
    load-slip points, each a name of the data catalogue or a CSV file; `calibrate`, campaigns that
    fits may use (empty: all that do not validate); `validate`, campaigns that fits are judged by;
    `confidence` of intervals and bands;
    `digests` of the CSV files, in their order (None: taken from the files now), so that a stored
    answer belongs to one content. Raises `InputError`, also where a campaign is to do both.
    """

    name: str = checked(Text(), path="name")
    asked: str = checked(Choice(ASKED), "strength")
    tables: tuple[str, ...] = checked(NAMES, ("stud-push-out",))
    curves: tuple[str, ...] = checked(NAMES, ())
    calibrate: tuple[str, ...] = checked(NAMES, ())
    validate: tuple[str, ...] = checked(NAMES, ())
    confidence: float = checked(Number(0.5, 0.999), 0.9)
    digests: tuple[str, ...] | None = checked(Many(Text()), optional=True)

    KIND: ClassVar[str] = "stud-tests"
    STATIC: ClassVar[bool | None] = None  # neither pushed nor moving in time

    def check(self) -> None:
        """Refuse campaigns that do both and files that have changed; take the digests."""
        if not self.tables and not self.curves:
            raise self.refusal("tables", "must name a table or a CSV file")
        for campaign in self.validate:
            if campaign in self.calibrate:
                text = "calibrates: a fit is not validated by its own rows"
                raise InputError("tests.validate", campaign, text)
        found = tuple(_digest(Path(file)) for file in self.files)
        stated = self.digests or found
        if len(found) != len(stated):
            raise InputError("tests.digests", stated, f"must be {len(found)}, one per file")
        for file, digest, expected in zip(self.files, found, stated, strict=True):
            if digest != expected:
                text = f"is not that of {file}: the file has changed"
                advice = "remove the key to take the file as it is now"
                raise InputError("tests.digests", expected, text, advice)
        object.__setattr__(self, "digests", found or None)

    @property
    def files(self) -> tuple[str, ...]:
        """The CSV files among the tables, in order."""
        return tuple(name for name in (*self.tables, *self.curves) if name.endswith(CSV))


def _digest(path: Path) -> str:
    with open_input(path, "tests.tables") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()[:16]
