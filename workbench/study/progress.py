"""Progress of a run, with an estimate of the time left: a bar on a terminal, lines elsewhere."""

import sys
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import timedelta
from itertools import chain
from statistics import fmean
from typing import Any, TextIO

from workbench.responses import Outcome
from workbench.study.cells import Cell


class Progress:
    """Counts what the runner tells, and prints a plain line about every tenth of the run.

    Without a `stream` it says nothing.
    """

    total = done = failed = 0
    began = 0.0

    def __init__(self, stream: TextIO | None = None) -> None:
        self.stream = stream

    def begin(self, study: str, waiting: Sequence[Cell], stored: int, jobs: int) -> None:
        """A run of `jobs` begins with `waiting` cells to answer and `stored` ones there."""
        self.total, self.done, self.failed = len(waiting), 0, 0
        self.began, self._jobs = time.monotonic(), jobs
        self._left = Counter(cell.label for cell in waiting)
        self._costs: dict[str, list[float]] = {}
        self._say(f"{study}: {self.total} cells to answer, {stored} already stored")

    def advance(self, cell: Cell, outcome: Outcome, seconds: float) -> None:
        """A cell has been answered, in `seconds` of its worker's time."""
        before = 10 * self.done // self.total
        self.done += 1
        self.failed += outcome.is_failure
        self._left[cell.label] -= 1
        self._costs.setdefault(cell.label, []).append(seconds)
        if before < 10 * self.done // self.total < 10:
            self._say(f"{self.done} of {self.total} cells, {self.failures}{self.left}")

    def note(self, text: str) -> None:
        """Something that the user should know."""
        self._say(text)

    def end(self) -> None:
        """The run is over, or was interrupted."""
        if self.total:
            took = timedelta(seconds=round(time.monotonic() - self.began))
            self._say(f"{self.done} of {self.total} cells answered, {self.failures}in {took}")

    def _say(self, text: str) -> None:
        if self.stream is not None:
            print(text, file=self.stream, flush=True)

    def seconds_left(self) -> float | None:
        """Expected time left in s, from the mean cost of each label; None before the first cell."""
        if not self._costs:
            return None
        means = {label: fmean(costs) for label, costs in self._costs.items()}
        overall = fmean(chain.from_iterable(self._costs.values()))
        work = sum(count * means.get(label, overall) for label, count in self._left.items())
        return work / self._jobs

    @property
    def failures(self) -> str:
        """How many cells have failed, in words."""
        return f"{self.failed} failed, " if self.failed else ""

    @property
    def left(self) -> str:
        """The time left, in words."""
        return f"about {timedelta(seconds=round(self.seconds_left() or 0.0))} left"


class Bar(Progress):
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
    return Bar() if stream.isatty() and not environment.get("CI") else Progress(stream)
