"""How the cost of batches and studies grows with their size: exponents, and a figure.

Wall times of `simulate_many`, the least of some turns, of columns and frames as in `batches.py`:
over the number of scenarios on all cores, over the elements of each bar of a column and over the
threads. The exponent n of a line is that of time ~ size^n through its points, of threads up to the
number of cores. Nothing here passes or fails.

With `--cells`, of studies instead: processor time, wall time and peak memory of `run`, `status` and
`report`, each in a process of its own, over the number of cells of a model that costs nothing.

Usage: python benchmarks/growth.py [FIGURE.svg | --cells]
"""

from __future__ import annotations

import io
import os
import resource
import sys
import tempfile
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from batches import ONE_BAR, drawn, frames

from workbench.cli import run
from workbench.models.base import make_model
from workbench.models.batch import simulate_many
from workbench.models.superelements import RigidSuperelement
from workbench.scenarios.varied import Varied

TURNS = 3
COUNTS = {
    "energy-estimate": (1_000, 10_000, 100_000),
    "single-dof": (1_000, 10_000, 100_000),
    "four-dof": (100, 400, 1_600),
    "thesis frames": (25, 100, 400),
}
ELEMENTS, COLUMNS = (2, 4, 8, 16, 32), 10
THREADED = {"single-dof": 20_000, "four-dof": 800, "thesis frames": 200}
TESTS = str(Path(__file__).resolve().parents[1] / "tests")
CELLS = (5_000, 15_000, 50_000)
VERBS = {"run": ["--jobs=0"], "status": ["--json"], "report": ["--format=html"]}
STUDY = """
import sys
import numpy as np, workbench as wb
sys.path.insert(0, {tests!r})
from toy_models import Spring
hit = wb.impact(wb.Column("HEB 220", 2.0, 2.0, axial_load=5e5), mass=1500, velocity=4.0)
study = wb.Study(
    name="large", title="Large", question="How does it grow?", reference="fine",
    cases=tuple(wb.Case(f"{{v:.6f}}", hit.at_velocity(v)) for v in np.linspace(2.0, 8.0, {cases})),
    models={{"soft": Spring(), "fine": Spring(error=0.1)}},
)
"""


class Line(NamedTuple):
    """Wall times (s) over sizes."""

    label: str
    sizes: Sequence[int]
    times: Sequence[float]

    @property
    def exponent(self) -> float:
        """Slope through the points in logarithms; none of a single one."""
        if len(self.sizes) < 2:
            return float("nan")
        return float(np.polyfit(np.log(self.sizes), np.log(self.times), 1)[0])


def asked_of(name: str, count: int) -> tuple[Any, Varied]:
    """A model and its scenarios."""
    if name == "thesis frames":
        return ONE_BAR, frames(count, steels=True)
    return make_model(name), drawn(count)


def seconds(model: Any, scenarios: Varied, threads: int) -> float:
    """The least wall time of some turns."""
    times = []
    for _ in range(TURNS):
        start = perf_counter()
        simulate_many(model, scenarios, threads)
        times.append(perf_counter() - start)
    return min(times)


def by_scenarios(cores: int) -> list[Line]:
    """Times over the number of scenarios."""
    lines = []
    for name, counts in COUNTS.items():
        simulate_many(*asked_of(name, 20))  # compile
        lines.append(Line(name, counts, [seconds(*asked_of(name, n), cores) for n in counts]))
    return lines


def by_elements(cores: int) -> list[Line]:
    """Times over the elements of each bar of a column."""
    columns = drawn(COLUMNS)
    models = [RigidSuperelement(elements=n) for n in ELEMENTS]
    times = [seconds(model, columns, cores) for model in models]
    return [Line("rigid-superelement, columns", ELEMENTS, times)]


def by_threads(cores: int) -> list[Line]:
    """Times over the number of threads."""
    threads = sorted({min(2**k, cores) for k in range(cores.bit_length() + 1)})
    lines = []
    for name, count in THREADED.items():
        model, scenarios = asked_of(name, count)
        lines.append(Line(name, threads, [seconds(model, scenarios, n) for n in threads]))
    return lines


def costs(arguments: list[str]) -> tuple[float, float, float]:
    """Processor and wall time (s) and peak memory (GB) of a process for a verb that succeeds."""
    start = perf_counter()
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        assert run(arguments) == 0, arguments
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime, perf_counter() - start, used.ru_maxrss * 1024 / 1e9


def by_cells() -> None:
    """Print times and memory of the verbs of studies over the number of cells."""
    times: dict[str, list[float]] = {verb: [] for verb in VERBS}
    for count in CELLS:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "large.py")
            file.write_text(STUDY.format(cases=count // 2, tests=TESTS), encoding="utf-8")
            for verb, more in VERBS.items():
                asked = [verb, str(file), f"--store={folder}", *more]
                with get_context("spawn").Pool(1) as process:
                    seconds, wall, memory = process.apply(costs, (asked,))
                times[verb].append(seconds)
                text = f"{seconds:8.1f} s of processor, {wall:8.1f} s in all, {memory:5.2f} GB"
                print(f"{count:>7,} cells  {verb:<8}{text}", flush=True)
    for verb, each in times.items():
        print(f"{verb:<8}exponent {Line(verb, CELLS, each).exponent:.2f}")


def draw(panels: dict[str, list[Line]], file: str) -> None:
    """Draw times over sizes, a panel for each kind of size."""
    from matplotlib import pyplot
    from matplotlib.ticker import NullLocator

    figure, axes = pyplot.subplots(1, len(panels), figsize=(10.0, 3.6), layout="constrained")
    for ax, (title, lines) in zip(axes, panels.items(), strict=True):
        for line in lines:
            label = f"{line.label}: {line.exponent:.2f}"
            ax.loglog(line.sizes, line.times, "o-", label=label)
        sizes = sorted({n for line in lines for n in line.sizes})
        ax.set_xticks(sizes, labels=[f"{n:,}" for n in sizes], fontsize="xx-small", rotation=45)
        ax.xaxis.set_minor_locator(NullLocator())
        ax.tick_params(axis="y", which="minor", labelsize="xx-small")
        ax.set_xlabel(title)
        ax.legend(title="exponent", fontsize="x-small", title_fontsize="x-small")
    axes[0].set_ylabel("wall time in s")
    figure.savefig(file)


def main() -> None:
    """Measure, print exponents, draw."""
    if sys.argv[1:] == ["--cells"]:
        return by_cells()
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    panels = {
        "scenarios": by_scenarios(cores),
        "elements of a bar": by_elements(cores),
        "threads": by_threads(cores),
    }
    for title, lines in panels.items():
        for line in lines:
            points = "  ".join(
                f"{n}: {t:.3g} s" for n, t in zip(line.sizes, line.times, strict=True)
            )
            print(f"{title:<18}{line.label:<28}exponent {line.exponent:>5.2f}   {points}")
    if len(sys.argv) > 1:
        draw(panels, sys.argv[1])


if __name__ == "__main__":
    main()
