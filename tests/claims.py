"""Claims of tests: what a marked test shows of its subjects, measured, and the table of them all.

`@pytest.mark.claim(subject(s), says, source, expected, tolerance)` marks a test, or one run of it,
whose fixture `claim` is called with what was measured; texts name parameters in braces. The worst
counts of what stands on one line of the table, which `make manual` writes.
"""

from __future__ import annotations

import ast
import csv
import math
import re
from collections import namedtuple
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from workbench.base.datafiles import data_directory

TESTS, TABLE = Path(__file__).parent, data_directory() / "verification.csv"
WITHOUT_PAPER = ("closed form", "independent code", "another program", "property")
MEASURED: dict[Claim, list[float]] = {}  # by the tests of this run; nothing by those skipped


class Claim(namedtuple("Claim", "subject says source expected tolerance test")):
    """A line of the table without what was computed, as texts; `test` is file::function."""

    @classmethod
    def of(cls, said: Sequence[Any], test: str) -> Claim:
        """What a marker says, names of parameters still in braces."""
        subjects = said[0] if isinstance(said[0], str) else " ".join(said[0])
        return cls(subjects, *map(str, said[1:]), test)

    def fits(self, row: Claim) -> bool:
        """Whether a line may be of this marker."""
        if self.test != row.test:
            return False
        patterns = (re.sub(r"\\\{.*?\\\}", ".+", re.escape(text)) for text in self)
        return all(map(re.fullmatch, patterns, row))

    @property
    def width(self) -> float:
        """The tolerance as a number."""
        number, percent, _ = self.tolerance.partition("%")
        return float(number) * (abs(float(self.expected)) / 100 if percent else 1.0)

    def error(self, value: float) -> float:
        """Distance from what is expected."""
        return abs(value - float(self.expected))

    def moved(self, value: float, old: float, *, many: bool = False) -> bool:
        """Whether a value is not the stored one, which of `many` runs on a line is the worst."""
        far = self.error(value) - self.error(old) if many else abs(value - old)
        return far > self.width / 10

    def line(self, value: float) -> dict[str, str]:
        """The line of the table, with digits as far as the tolerance gives them a meaning."""
        digits = 2 - math.floor(math.log10(self.width))
        computed, error = (round(x, digits) + 0.0 for x in (value, value - float(self.expected)))
        *first, test = self._asdict().items()
        return dict([*first, ("computed", f"{computed:.10g}"), ("error", f"{error:.10g}"), test])


def stored() -> dict[Claim, float]:
    """What the table says that was computed, by claims."""
    with TABLE.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    return {Claim(*(row[key] for key in Claim._fields)): float(row["computed"]) for row in rows}


def marked() -> Iterator[Claim]:
    """Markers of all tests, from their text: all of them count whatever is run."""
    for path in sorted(TESTS.rglob("test_*.py")):
        text = path.read_text(encoding="utf-8")
        for function in ast.parse(text).body if "mark.claim(" in text else ():
            test = f"{path.relative_to(TESTS.parent).as_posix()}::{getattr(function, 'name', '')}"
            for node in ast.walk(function):
                if isinstance(node, ast.Call) and ast.unparse(node.func) == "pytest.mark.claim":
                    yield Claim.of([ast.literal_eval(each) for each in node.args], test)


def of_item(item: pytest.Item) -> Claim:
    """The claim of a marked test."""
    test = f"{item.path.relative_to(TESTS.parent).as_posix()}::{item.function.__name__}"
    values = getattr(getattr(item, "callspec", None), "params", {})
    said = Claim.of(item.get_closest_marker("claim").args, test)
    return Claim(*(text.format(**values) for text in said))


@pytest.fixture
def claim(request: pytest.FixtureRequest) -> Iterator[Callable[[float], None]]:
    """Assert that a value is what the marker says, and keep it; the table must not be stale."""
    said = of_item(request.node)
    values: list[float] = []

    def measured(value: float) -> None:
        assert said.error(value) <= said.width, f"{said.says}: {value}, expected {said.expected}"
        values.append(float(value))

    yield measured
    if values:
        worst = max(values, key=said.error)
        request.node.user_properties.append(("claim", (tuple(said), worst)))
        old, many = stored().get(said, worst), hasattr(request.node, "callspec")
        if said.moved(worst, old, many=many) and not request.config.getoption("--manual"):
            pytest.fail(f"{said.says}: now {worst:g}, stored {old:g}; if right, run: make manual")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--manual", action="store_true", help="write data/verification.csv")


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Gather what tests measured, in the process that started the workers."""
    if report.when == "teardown":
        for said, value in (each for key, each in report.user_properties if key == "claim"):
            MEASURED.setdefault(Claim(*said), []).append(value)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Write the table, if asked; lines of marked tests that did not run stay as they are."""
    if not session.config.getoption("--manual") or hasattr(session.config, "workerinput"):
        return
    ran, markers = {said.test for said in MEASURED}, list(marked())
    rows = {
        said: old
        for said, old in stored().items()
        if said in MEASURED or (said.test not in ran and any(each.fits(said) for each in markers))
    }
    for said, values in MEASURED.items():
        worst = max(values, key=said.error)
        if said.moved(worst, rows.get(said, math.inf)):
            rows[said] = worst
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        lines = [said.line(value) for said, value in sorted(rows.items())]
        table = csv.DictWriter(file, lines[0], lineterminator="\n")
        table.writeheader()
        table.writerows(lines)
