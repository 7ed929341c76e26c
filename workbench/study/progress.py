"""Progress of a run, with an estimate of the time left: a bar on a terminal, lines elsewhere."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TextIO

from workbench.responses import Outcome
from workbench.study.cells import Cell


class Progress(Protocol):
    """Told by the runner what happens."""

    def begin(self, study: str, waiting: Sequence[Cell], stored: int, jobs: int) -> None:
        """A run begins with `waiting` cells to answer and `stored` ones already there."""
        ...

    def advance(self, cell: Cell, outcome: Outcome, seconds: float) -> None:
        """A cell has been answered, in `seconds` of its worker's time."""
        ...

    def note(self, text: str) -> None:
        """Something that the user should know."""
        ...

    def end(self) -> None:
        """The run is over, or was interrupted."""
        ...


@dataclass
class Estimate:
    """Time left, from the mean cost of each label's cells so far."""

    jobs: int = 1
    left: Counter[str] = field(default_factory=Counter)
    cost: dict[str, list[float]] = field(default_factory=dict)
    failed: int = 0

    def add(self, label: str, seconds: float, failed: bool) -> None:
        """Count a cell that has been answered."""
        self.left[label] -= 1
        self.failed += failed
        self.cost.setdefault(label, []).append(seconds)

    def seconds(self) -> float | None:
        """Expected time left in s; None before the first cell."""
        every = [seconds for label in self.cost.values() for seconds in label]
        if not every:
            return None
        means = {label: sum(costs) / len(costs) for label, costs in self.cost.items()}
        overall = sum(every) / len(every)
        work = sum(count * means.get(label, overall) for label, count in self.left.items())
        return work / self.jobs


@dataclass
class Silent:
    """Says nothing."""

    def begin(self, study: str, waiting: Sequence[Cell], stored: int, jobs: int) -> None:
        """Ignore."""

    def advance(self, cell: Cell, outcome: Outcome, seconds: float) -> None:
        """Ignore."""

    def note(self, text: str) -> None:
        """Ignore."""

    def end(self) -> None:
        """Ignore."""


@dataclass
class Lines:
    """One plain line about every tenth of the run, for logs."""

    stream: TextIO = field(default_factory=lambda: sys.stderr)
    estimate: Estimate = field(default_factory=Estimate)
    total: int = 0
    done: int = 0
    began: float = 0.0

    def begin(self, study: str, waiting: Sequence[Cell], stored: int, jobs: int) -> None:
        """Say how much there is to do."""
        self.total, self.began = len(waiting), time.monotonic()
        self.estimate = Estimate(jobs, Counter(cell.label for cell in waiting))
        self.note(f"{study}: {self.total} cells to answer, {stored} already stored")

    def advance(self, cell: Cell, outcome: Outcome, seconds: float) -> None:
        """Count, and print when another tenth is done."""
        before = 10 * self.done // self.total
        self.done += 1
        self.estimate.add(cell.label, seconds, outcome not in (Outcome.OK, Outcome.OUT_OF_DOMAIN))
        tenth = 10 * self.done // self.total
        if tenth > before and self.done < self.total:
            left = self.estimate.seconds() or 0.0
            self.note(
                f"{self.done} of {self.total} cells, {_failures(self.estimate.failed)}"
                f"about {duration(left)} left"
            )

    def note(self, text: str) -> None:
        """Print a line."""
        print(text, file=self.stream, flush=True)

    def end(self) -> None:
        """Say how much was done in which time."""
        if self.total:
            took = duration(time.monotonic() - self.began)
            failures = _failures(self.estimate.failed)
            self.note(f"{self.done} of {self.total} cells answered, {failures}in {took}")


@dataclass
class Bar:
    """A progress bar with the cell that was answered last and the time left."""

    estimate: Estimate = field(default_factory=Estimate)
    display: Any = None
    task: Any = None

    def begin(self, study: str, waiting: Sequence[Cell], stored: int, jobs: int) -> None:
        """Draw the bar."""
        from rich import progress
        from rich.console import Console

        self.estimate = Estimate(jobs, Counter(cell.label for cell in waiting))
        self.display = progress.Progress(
            progress.TextColumn(study),
            progress.BarColumn(),
            progress.MofNCompleteColumn(),
            progress.TextColumn("{task.fields[left]}"),
            progress.TextColumn("{task.fields[last]}", markup=False),
            console=Console(stderr=True),
        )
        stored_text = f"({stored} already stored)" if stored else ""
        self.task = self.display.add_task(study, total=len(waiting), left="", last=stored_text)
        self.display.start()

    def advance(self, cell: Cell, outcome: Outcome, seconds: float) -> None:
        """Move the bar."""
        failed = outcome not in (Outcome.OK, Outcome.OUT_OF_DOMAIN)
        self.estimate.add(cell.label, seconds, failed)
        left = f"about {duration(self.estimate.seconds() or 0.0)} left"
        last = f"{_failures(self.estimate.failed)}{cell.name}: {outcome}"
        self.display.update(self.task, advance=1, left=left, last=last)

    def note(self, text: str) -> None:
        """Print a line above the bar."""
        if self.display is None:
            print(text, file=sys.stderr)
        else:
            self.display.console.print(text, markup=False, highlight=False)

    def end(self) -> None:
        """Leave the bar as it is."""
        if self.display is not None:
            self.display.update(self.task, left="", last=_failures(self.estimate.failed))
            self.display.stop()
            self.display = None


def progress_for(stream: TextIO, environment: Mapping[str, str]) -> Progress:
    """A bar if `stream` is a terminal and this is no automatic build (CI), else lines."""
    return Bar() if stream.isatty() and not environment.get("CI") else Lines(stream)


def duration(seconds: float) -> str:
    """A span of time in words, such as ``40 s`` or ``3 min 20 s``."""
    if seconds < 10.0:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    minutes, rest = divmod(whole, 60)
    if minutes < 60:
        return f"{minutes} min {rest} s"
    return f"{minutes // 60} h {minutes % 60} min"


def _failures(count: int) -> str:
    return f"{count} failed, " if count else ""
