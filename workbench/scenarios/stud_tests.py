"""Tests on studs as a scenario: tables, campaigns and what models are to answer."""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from workbench.base.datafiles import open_input
from workbench.base.errors import InputError
from workbench.base.fields import Choice, Declared, Many, Number, Text, checked
from workbench.base.tables import FILES

ASKED = ("strength", "load-slip", "interaction", "residual-strength", "residual-stiffness")
NAMES = Many(Text(), different=True)


@dataclass(frozen=True)
class StudTests(Declared, table="tests"):
    """Tests on studs and what they are used for.

    Examples
    --------
    >>> wb.StudTests("push-outs", asked="strength", confidence=0.95).tables
    ('stud-push-out',)
    """

    name: str = checked(Text(), path="name")
    asked: str = checked(Choice(ASKED), "strength", help="what models are to answer")
    tables: tuple[str, ...] = checked(
        NAMES, ("stud-push-out",), help="tests: names of the data catalogue or CSV files"
    )
    curves: tuple[str, ...] = checked(
        NAMES, (), help="load-slip points: names of the data catalogue or CSV files"
    )
    calibrate: tuple[str, ...] = checked(
        NAMES, (), help="campaigns that fits may use (empty: all that do not validate)"
    )
    validate: tuple[str, ...] = checked(NAMES, (), help="campaigns that fits are judged by")
    confidence: float = checked(Number(0.5, 0.999), 0.9, help="of intervals and bands")
    digests: tuple[str, ...] | None = checked(
        Many(Text()), optional=True, help="of the CSV files in their order, by default as they are"
    )

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
        digests = tuple(_digest(Path(file)) for file in self.files)
        stated = self.digests or digests
        if len(digests) != len(stated):
            raise InputError("tests.digests", stated, f"must be {len(digests)}, one per file")
        for file, digest, expected in zip(self.files, digests, stated, strict=True):
            if digest != expected:
                text = f"is not that of {file}: the file has changed"
                advice = "remove the key to take the file as it is now"
                raise InputError("tests.digests", expected, text, advice)
        object.__setattr__(self, "digests", digests or None)

    @property
    def files(self) -> tuple[str, ...]:
        """The CSV files among the tables, in order."""
        return tuple(name for name in (*self.tables, *self.curves) if name.endswith(FILES))


def _digest(path: Path) -> str:
    with open_input(path, "tests.tables") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()[:16]
