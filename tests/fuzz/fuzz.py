"""Throws disturbed input at the command line: scenarios, overrides, tables, stored results.

Run on demand, for an hour and with a seed of its own:

    python tests/fuzz/fuzz.py --seconds 3600 --seed 7

Every job must end with status 0, 1 or 2, at most one line of `workbench: ...` on the error
stream, no traceback, within `MOST_SECONDS` of processor time and `MOST_MEMORY`. A job that does
not is kept in tests/fuzz/corpus as a file that says all of it; the suite replays the corpus.
"""

from __future__ import annotations

import argparse
import base64
import contextlib
import io
import json
import multiprocessing
import os
import random
import resource
import shutil
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from math import inf, nan
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

import tomli_w
import xarray as xr
from scenario_tables import SCENARIOS, places, put
from threadpoolctl import threadpool_limits

from workbench.base.datafiles import data_directory
from workbench.cli import run
from workbench.models.base import model_kind, model_names

CORPUS = Path(__file__).with_name("corpus")
TOYS = Path(__file__).parents[1] / "toy_models.py"
MOST_SECONDS, MOST_MEMORY = 60.0, 2**31  # of one job: processor time (s), bytes
PATIENCE = 3.0 * MOST_SECONDS  # of wall time, on a machine that others use as well
WILD: list[Any] = [
    0,
    -1,
    1e-170,
    1e300,
    nan,
    inf,
    10**30,
    "",
    "x" * 5000,
    "\x00",
    True,
    [],
    {},
    [1],
]
MESH = {"smallest_element": 0.2, "largest_element": 0.4, "levels": 1}
REFERENCES = "workbench.models.references"
LOOKED_UP = ("measured", "published", "imported", "remote", "opensees")  # solve nothing
ANSWER = "answer.nc"
SOLVED = ("ok", "collapse", "not-converged", "timed-out")
FITS = {  # verbs by the shipped table that feeds them
    "stud-strength": "push_out",
    "load-slip": "load_slip",
    "residual": "push_out",
    "interaction": "pull_out",
    "few-tests": "push_out",
}
STUDY = """
import sys
sys.path.insert(0, {toys!r})
from toy_models import Spring
from workbench.scenarios import load_scenario
from workbench.study import Case, Gate, Study

impact = load_scenario({scenario!r})
study = Study(
    name="toy", title="Toy", question="Does it read what it finds?",
    cases=tuple(Case(f"v{{v}}", impact.at_velocity(v)) for v in (8.0, 10.0)),
    models={{"soft": Spring(), "fine": Spring(error=0.08, level=1)}}, reference="fine",
    gates=(Gate("soft", against="fine", quantity="peak_displacement", metric="relative_error",
                bound=0.5, rationale="why", source="where"),),
)
"""


@dataclass(frozen=True)
class Job:
    """`files` (base64) to lay into an empty directory, after a stored study if `store`; a verb."""

    arguments: list[str]
    files: dict[str, str] = field(default_factory=dict)
    store: bool = False


@dataclass(frozen=True)
class Ending:
    """How a job ended: exit `status` (None: an exception), `said`, processor time, peak memory.

    `outcome` of a scenario that was answered; `flat`, whether its peak is 0 beside a history that
    moves.
    """

    status: int | None
    said: str
    seconds: float
    memory: int
    outcome: str = ""
    flat: bool = False

    @property
    def fault(self) -> str:
        """What is wrong, or nothing."""
        if self.status not in (0, 1, 2):
            return f"status {self.status}: {self.said[-2000:]}"
        if "Traceback" in self.said:
            return f"a traceback: {self.said[-2000:]}"
        if self.status == 2 and not 1 <= self.said.count("\n") <= 2:  # a run says what it does
            return f"not one message: {self.said[-2000:]}"
        if self.flat:
            return "a peak of 0 beside a history that moves"
        if self.seconds > MOST_SECONDS:
            return f"{self.seconds:.0f} s of processor time"
        return f"{self.memory / 2**30:.1f} GB" if self.memory > MOST_MEMORY else ""

    @property
    def reaches_solver(self) -> bool:
        """Whether a solver was at work."""
        return self.outcome in SOLVED


def coded(content: bytes) -> str:
    return base64.b64encode(content).decode()


def disturbed_number(value: float, chance: random.Random) -> Any:
    pick = chance.random()
    if pick < 0.1:
        return chance.choice(WILD)
    reach = 0.5 if pick < 0.7 else 6.0  # decades: most jobs must get beyond the reader
    return value * 10.0 ** chance.uniform(-reach, reach) * (1.0 if pick < 0.95 else -1.0)


def scenario_job(chance: random.Random, quick: bool) -> Job:
    """A scenario with one to four values elsewhere, for any model (`quick`: but references)."""
    name = chance.choice(list(SCENARIOS))
    tables = SCENARIOS[name]
    for _ in range(chance.randint(1, 4)):
        place = chance.choice(places(tables))
        value: Any = tables
        for key in place:
            value = value[key]
        if isinstance(value, float):
            tables = put(tables, place, disturbed_number(value, chance))
        elif chance.random() < 0.1:
            tables = put(tables, place, chance.choice(WILD))
    answer = [n for n in model_names() if SCENARIOS[name]["kind"] in model_kind(n).answers]
    if quick:
        answer = [n for n in answer if not model_kind(n).__module__.startswith(REFERENCES)]
        answer = [n for n in answer if n not in LOOKED_UP] or answer
    model = chance.choice(answer)
    known = {f.name for f in model_kind(model).__dataclass_fields__.values()}
    options = [f"--option={key}={value}" for key, value in MESH.items() if key in known]
    content = tomli_w.dumps(tables).encode(errors="surrogatepass")
    arguments = ["simulate", "scenario.toml", "--model", model, *options, "--out", ANSWER]
    return Job(arguments, {"scenario.toml": coded(content)})


def override_job(chance: random.Random) -> Job:
    """A good scenario with an override of any key by any text."""
    name = chance.choice(list(SCENARIOS))
    tables = SCENARIOS[name]
    path = ".".join(map(str, chance.choice(places(tables))))
    text = chance.choice([str(value) for value in WILD] + ["[[1]", "٣", "1e999", "{a=1}", "'"])
    model = "single-dof" if name in ("impact", "pushover") else "rigid-superelement"
    arguments = ["simulate", "scenario.toml", "--model", model, "--set", f"{path}={text}"]
    return Job(arguments, {"scenario.toml": coded(tomli_w.dumps(tables).encode())})


def table_job(chance: random.Random, quick: bool) -> Job:
    """A shipped table of stud tests with cells exchanged, scaled, emptied or doubled."""
    verb = chance.choice(["stud-strength", "few-tests"] if quick else sorted(FITS))
    name = FITS[verb] if chance.random() < 0.8 else "beam_retest"
    text = (data_directory() / "studs" / f"{name}.csv").read_text(encoding="utf-8")
    head, *lines = text.splitlines()
    first = chance.randrange(len(lines))  # a campaign or a curve stays together
    lines = lines[first : first + chance.randint(1, 120)]
    for _ in range(chance.randint(0, 4)):
        at = chance.randrange(len(lines))
        cells = lines[at].split(",")
        cell = chance.randrange(len(cells))
        try:
            cells[cell] = str(disturbed_number(float(cells[cell]), chance))
        except ValueError:
            cells[cell] = chance.choice(["", "push-out", "1", "-1", "nan", "é", "9" * 400, '"'])
        lines[at] = ",".join(cells)
    content = "\n".join([head, *lines]).encode()
    more = ["--keep-good"] if chance.random() < 0.5 else []
    more += ["--known-variation", "0.1"] if verb == "few-tests" else []
    return Job(["fit", verb, "tests.csv", *more], {"tests.csv": coded(content)})


def store_job(chance: random.Random, quick: bool, stored: dict[str, bytes]) -> Job:
    """A stored study of which one file is cut, changed, exchanged or emptied; all that reads it."""
    one, other = chance.sample(sorted(stored), 2)
    content = bytearray(stored[one])
    kind = chance.randrange(5)
    if kind == 0:
        content = content[: chance.randrange(len(content) + 1)]
    elif kind == 1:
        for _ in range(chance.randint(1, 8)):
            content[chance.randrange(len(content))] = chance.randrange(256)
    elif kind == 2:
        content = bytearray(stored[other])
    elif kind == 3 and one.endswith(".json"):
        tables = json.loads(content)
        value = chance.choice([v for v in WILD if v == v and v != inf])
        content = bytearray(json.dumps(put(tables, chance.choice(places(tables)), value)).encode())
    else:
        content = bytearray(chance.choice([b"", b"[]", b"[" * 100_000, b"\xff\xfe", b"null"]))
    verb = chance.choice(("status", "validate", "run", "report")[: 3 if quick else None])
    more = {"run": ["--jobs", "0"], "report": ["--format", "html"]}.get(verb, [])
    arguments = [verb, "toy_study.py", "--store", "store", *more]
    return Job(arguments, {f"store/{one}": coded(bytes(content))}, store=True)


def make_store(directory: Path) -> dict[str, bytes]:
    """A small stored study in `directory`; its files by their names within the store."""
    scenario = str(data_directory() / "published" / "heng2017_impact_column.toml")
    content = STUDY.format(toys=str(TOYS.parent), scenario=scenario)
    (directory / "toy_study.py").write_text(content)
    asked = ["run", str(directory / "toy_study.py"), "--jobs", "0"]
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        assert run([*asked, "--store", str(directory / "store")]) == 0
    root = directory / "store"
    files = [path for path in root.rglob("*") if path.is_file()]
    return {str(path.relative_to(root)): path.read_bytes() for path in files if path.stat().st_size}


def jobs(chance: random.Random, stored: dict[str, bytes], quick: bool = False) -> Iterator[Job]:
    """Random jobs without end; `quick`: without the slow ones."""
    while True:
        pick = chance.random()
        if pick < 0.5:
            yield scenario_job(chance, quick)
        elif pick < 0.6:
            yield override_job(chance)
        elif pick < 0.8:
            yield table_job(chance, quick)
        else:
            yield store_job(chance, quick, stored)


def perform(job: Job, base: Path) -> Ending:
    """Do a job in this process, in a directory of its own."""
    out, err = io.StringIO(), io.StringIO()
    before, here = time.process_time(), Path.cwd()
    with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
        if job.store:
            shutil.copytree(base, name, dirs_exist_ok=True)
        for path, content in job.files.items():
            (Path(name) / path).write_bytes(base64.b64decode(content))
        os.chdir(name)
        try:
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                status = run(job.arguments)
        except BaseException:
            return Ending(None, traceback.format_exc(), time.process_time() - before, 0)
        finally:
            os.chdir(here)
        outcome, flat = answered(Path(name, ANSWER))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    return Ending(status, err.getvalue(), time.process_time() - before, memory, outcome, flat)


def answered(path: Path) -> tuple[str, bool]:
    """Outcome in a file of an answer, and whether its peak is 0 beside a history that moves."""
    if not path.is_file():
        return "", False
    with xr.open_dataset(path) as answer:
        peak = float(answer.get("peak_displacement", nan))
        moved = float(abs(answer["displacement"]).max()) if "displacement" in answer else 0.0
        return str(answer.attrs["outcome"]), peak == 0.0 < moved


def replay(path: Path, base: Path) -> Ending:
    """Do a kept job again."""
    return perform(Job(**json.loads(path.read_text())), base)


def _serve(pipe: Any, base: Path) -> None:
    with threadpool_limits(1):
        while True:
            pipe.send(perform(pipe.recv(), base))


def main() -> None:
    """Throw jobs for a while and keep those that end badly."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    context = multiprocessing.get_context("spawn")
    done = faults = 0
    statuses: Counter[int | None] = Counter()
    worker = pipe = None
    end = time.monotonic() + asked.seconds
    with tempfile.TemporaryDirectory(prefix="fuzz-base-") as name:
        base = Path(name)
        for job in jobs(random.Random(asked.seed), make_store(base)):
            if time.monotonic() > end:
                break
            if worker is None:
                pipe, theirs = context.Pipe()
                worker = context.Process(target=_serve, args=(theirs, base), daemon=True)
                worker.start()
            pipe.send(job)
            try:
                late = Ending(None, f"no end after {PATIENCE:g} s", inf, 0)
                ending = pipe.recv() if pipe.poll(PATIENCE) else late
            except EOFError:
                ending = Ending(None, "the process died", 0.0, 0)
            if ending.memory > MOST_MEMORY or ending.status is None:
                worker.kill()  # peak memory is that of a process: the next job has a new one
                worker = None
            done += 1
            statuses[ending.status] += 1
            if ending.fault:
                faults += 1
                kept = CORPUS / f"{asked.seed}-{done}.json"
                kept.write_text(json.dumps(asdict(job), indent=1) + "\n")
                print(f"{kept.name}: {' '.join(job.arguments)}: {ending.fault}", flush=True)
        if worker is not None:
            worker.kill()
    print(f"{done} jobs, {faults} of them end badly; statuses {dict(statuses)}")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
