"""Tests on studs: which tables, and which campaigns calibrate or validate."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from workbench.errors import InputError
from workbench.fields import Choice, Number, Text, check_fields, check_keys, checked

CSV = ".csv"
ASKED = ("strength", "load-slip", "interaction", "residual-strength", "residual-stiffness")
_LISTS = ("tables", "curves", "calibrate", "validate", "digests")


@dataclass(frozen=True)
class StudTests:
    """Tests on studs and what they are used for.

    Arguments: `asked`, what models are to answer; `tables` of tests and `curves`, tables of
    load-slip points, each a name of the data catalogue or a CSV file; `calibrate`, campaigns that
    fits may use (empty: all that do not validate); `validate`, campaigns that fits are judged by;
    `confidence` of intervals and bands;
    `digests` of the CSV files, in their order (empty: taken from the files now), so that a stored
    answer belongs to one content. Raises `InputError`, also where a campaign is to do both.
    """

    name: str = checked(Text())
    asked: str = checked(Choice(ASKED), "strength", path="tests.asked")
    tables: tuple[str, ...] = ("stud-push-out",)
    curves: tuple[str, ...] = ()
    calibrate: tuple[str, ...] = ()
    validate: tuple[str, ...] = ()
    confidence: float = checked(Number(0.5, 0.999), 0.9, path="tests.confidence")
    digests: tuple[str, ...] = ()

    KIND: ClassVar[str] = "stud-tests"
    TABLE: ClassVar[str] = "tests"

    def __post_init__(self) -> None:
        check_fields(self, "")
        for name in _LISTS:
            object.__setattr__(self, name, _texts(f"{self.TABLE}.{name}", getattr(self, name)))
        if not self.tables and not self.curves:
            raise InputError("tests.tables", None, "must name a table or a CSV file")
        for campaign in self.validate:
            if campaign in self.calibrate:
                raise InputError(
                    "tests.validate", campaign, "calibrates: a fit is not validated by its own rows"
                )
        found = tuple(_digest(Path(file)) for file in self.files)
        if not self.digests:
            object.__setattr__(self, "digests", found)
        for file, digest, stated in zip(self.files, found, self.digests, strict=False):
            if digest != stated:
                raise InputError(
                    "tests.digests", stated, f"is not that of {file}: the file has changed",
                    "remove the key to take the file as it is now",
                )  # fmt: skip
        if len(found) != len(self.digests):
            raise InputError("tests.digests", self.digests, f"must be {len(found)}, one per file")

    @property
    def files(self) -> tuple[str, ...]:
        """The CSV files among the tables, in order."""
        return tuple(name for name in (*self.tables, *self.curves) if name.endswith(CSV))

    def to_tables(self) -> dict[str, Any]:
        """The scenario as nested tables in canonical order."""
        content: dict[str, Any] = {"asked": self.asked}
        content |= {name: list(getattr(self, name)) for name in _LISTS[:4]}
        content["confidence"] = self.confidence
        if self.digests:
            content["digests"] = list(self.digests)
        return {"kind": self.KIND, "name": self.name, self.TABLE: content}


def stud_tests_from(tables: Mapping[str, Any]) -> StudTests:
    """The scenario of nested tables as TOML gives them. Raises `InputError`."""
    content = tables.get(StudTests.TABLE, {})
    if not isinstance(content, dict):
        raise InputError(StudTests.TABLE, content, "must be a table [tests]")
    check_keys(list(content), ("asked", *_LISTS, "confidence"), StudTests.TABLE)
    return StudTests(tables.get("name", StudTests.KIND), **content)


def _texts(path: str, value: object) -> tuple[str, ...]:
    """Different lines of text, as a tuple."""
    if not isinstance(value, (list, tuple)):
        raise InputError(path, value, "must be a list of texts")
    texts = tuple(Text().check(path, each) for each in value)
    for text in texts:
        if texts.count(text) > 1 and not path.endswith("digests"):
            raise InputError(path, text, "stands twice")
    return texts


def _digest(path: Path) -> str:
    try:
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()[:16]
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError("tests.tables", str(path), f"cannot be read: {reason}") from error
