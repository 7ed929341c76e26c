"""Progress of a run, with an estimate of the time left: a bar on a terminal, lines elsewhere."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TextIO

from workbench.responses import Outcome
from workbench.study.cells import Cell


class Progress:
    """Told by the runner what happens; says nothing itself."""

    def begin(self, study: str, waiting: Sequence[Cell], stored: int, jobs: int) -> None:
        """A run begins with `waiting` cells to answer and `stored` ones already there."""

    def advance(self, cell: Cell, outcome: Outcome, seconds: float) -> None:
        """A cell has been answered, in `seconds` of its worker's time."""

    def note(self, text: str) -> None:
        """Something that the user should know."""

    def end(self) -> None:
        """The run is over, or was interrupted."""


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
class Estimating(Progress):
    """Progress that knows what is left."""

    estimate: Estimate = field(default_factory=Estimate)
    total: int = 0
    done: int = 0
    began: float = 0.0

    def begin(self, study: str, waiting: Sequence[Cell], stored: int, jobs: int) -> None:
        """Count what there is to do."""
        self.total, self.done, self.began = len(waiting), 0, time.monotonic()
        self.estimate = Estimate(jobs, Counter(cell.label for cell in waiting))

    def advance(self, cell: Cell, outcome: Outcome, seconds: float) -> None:
        """Count what has been answered."""
        self.done += 1
        failed = outcome not in (Outcome.OK, Outcome.OUT_OF_DOMAIN)
        self.estimate.add(cell.label, seconds, failed)

    @property
    def failures(self) -> str:
        """How many cells have failed, in words."""
        return f"{self.estimate.failed} failed, " if self.estimate.failed else ""

    @property
    def left(self) -> str:
        """The time left, in words."""
        return f"about {duration(self.estimate.seconds() or 0.0)} left"


@dataclass
class Lines(Estimating):
    """One plain line about every tenth of the run, for logs."""

    stream: TextIO = field(default_factory=lambda: sys.stderr)

    def begin(self, study: str, waiting: Sequence[Cell], stored: int, jobs: int) -> None:
        """Say how much there is to do."""
        super().begin(study, waiting, stored, jobs)
        self.note(f"{study}: {self.total} cells to answer, {stored} already stored")

    def advance(self, cell: Cell, outcome: Outcome, seconds: float) -> None:
        """Count, and print when another tenth is done."""
        before = 10 * self.done // self.total
        super().advance(cell, outcome, seconds)
        if before < 10 * self.done // self.total < 10:
            self.note(f"{self.done} of {self.total} cells, {self.failures}{self.left}")

    def note(self, text: str) -> None:
        """Print a line."""
        print(text, file=self.stream, flush=True)

    def end(self) -> None:
        """Say how much was done in which time."""
        if self.total:
            took = duration(time.monotonic() - self.began)
            self.note(f"{self.done} of {self.total} cells answered, {self.failures}in {took}")


@dataclass
class Bar(Estimating):
    """A progress bar with the cell that was answered last and the time left."""

    display: Any = None
    task: Any = None

    def begin(self, study: str, waiting: Sequence[Cell], stored: int, jobs: int) -> None:
        """Draw the bar."""
        from rich import progress
        from rich.console import Console

        super().begin(study, waiting, stored, jobs)
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
        super().advance(cell, outcome, seconds)
        last = f"{self.failures}{cell.name}: {outcome}"
        self.display.update(self.task, advance=1, left=self.left, last=last)

    def note(self, text: str) -> None:
        """Print a line above the bar."""
        if self.display is None:
            print(text, file=sys.stderr)
        else:
            self.display.console.print(text, markup=False, highlight=False)

    def end(self) -> None:
        """Leave the bar as it is."""
        if self.display is not None:
            self.display.update(self.task, left="", last=self.failures)
            self.display.stop()
            self.display = None


def progress_for(stream: TextIO, environment: Mapping[str, str]) -> Progress:
    """A bar if `stream` is a terminal and this is no automatic build (CI), else lines."""
    return Bar() if stream.isatty() and not environment.get("CI") else Lines(stream=stream)


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
