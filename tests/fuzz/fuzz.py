"""Throws disturbed input at the command line and at Python calls, of all kinds in `SHARES`.

Run on demand, for an hour and with a seed of its own:

    python tests/fuzz/fuzz.py --seconds 3600 --seed 7

Every job must end with status 0, 1 or 2, at most one line of `workbench: ...` on the error
stream, no traceback, within `MOST_SECONDS` of processor time and `MOST_MEMORY`. A job that does
not is kept in tests/fuzz/corpus as a file that says all of it; the suite replays the corpus.
Most values are drawn near good ones: half of the jobs and more must reach a solver. The last lines
say how many did, by kind of job; verbs without a solver count as if they should have.
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
import tomllib
import traceback
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from functools import cache, partial, reduce
from math import inf, nan, pi, sin
from operator import getitem
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

import tomli_w
import xarray as xr
from scenario_tables import SCENARIOS, places, put
from threadpoolctl import threadpool_limits

import workbench.cli
from workbench.base.datafiles import data_directory
from workbench.base.errors import WorkbenchError
from workbench.cli import run
from workbench.models.base import findings_before, make_model, model_kind, model_names
from workbench.scenarios import scenario_from
from workbench.scenarios.pulse import PULSES as SHAPES

CORPUS = Path(__file__).with_name("corpus")
TOYS = Path(__file__).parents[1] / "toy_models.py"
MOST_SECONDS, MOST_MEMORY = 60.0, 2**31  # of one job: processor time (s), bytes
PATIENCE = 15.0 * MOST_SECONDS  # of wall time, on a machine that others use as well
WILD: list[Any] = [
    *(0, -1, 1e-170, 1e300, nan, inf, 10**30, "", "x" * 5000, "\x00", True, [], {}, [1])
]
MESH = {"smallest_element": 0.2, "largest_element": 0.4, "levels": 1}
REFERENCES = "workbench.models.references"
LOOKED_UP = ("measured", "published", "imported", "remote", "opensees")  # solve nothing
ANSWER = "answer.nc"
SOLVED = ("ok", "collapse", "not-converged", "timed-out")
SOLVING = {"limit", "sweep", "sample", "run", "fit", "python"}  # if they end with 0
SHARES = {  # kinds of jobs, each by the maker `<kind>_job`
    "scenario": 32, "override": 5, "budget": 4, "limit": 8, "sweep": 15, "uncertain": 8,
    "study": 6, "text": 8, "fit": 7, "own": 3, "store": 4,
}  # fmt: skip
TEMPLATES = Path(workbench.cli.__file__).with_name("templates")
TABLE = {"shape": "table", "times": [0.0, 0.005, 0.02], "factors": [1.0, 0.6, -0.1]}
PULSES = [TABLE if shape == "table" else {"shape": shape} for shape in SHAPES]
STRIKERS: list[dict[str, Any]] = [
    *({"stiffness": 3e6}, {"angle": 0.3, "friction": 0.2}, {"eccentricity": 0.05}),
    {"restitution": 0.0, "crush": [[0.0, 0.0], [0.1, 3e5], [0.5, 6e5]]},
]
RANGES = {"striker.velocity": (1.0, 60.0), "pulse.peak": (1e4, 1e7)}  # survives, collapses
IMPACTS = """
campaign,specimen,section,span,hit_at,base,head,axial_load,mass,velocity,yield_stress,peak,\
peak_uncertainty,residual,residual_uncertainty,source,licence,year,role
,,,m,m,,,N,kg,m/s,Pa,m,m,m,m,,,,
our lab,B1,HEB 220,4,2,pinned,pinned,0,1500,5,355e6,0.068,0.003,0.04,0.003,R,CC0,2026,validate
our lab,B2,HEB 220,4,0.8,clamped,guided,2e5,1500,8,355e6,0.07,0.004,0.055,0.004,R,CC0,2026,validate
""".strip()
FITS = {  # verbs by the shipped table that feeds them
    **dict.fromkeys(("stud-strength", "residual", "few-tests"), "push_out"),
    **{"load-slip": "load_slip", "interaction": "pull_out"},
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
    """`files` (base64) to lay into an empty directory, after a stored study if `store`; a verb.

    The verb `python` executes a file.
    """

    arguments: list[str]
    files: dict[str, str] = field(default_factory=dict)
    store: bool = False
    kind: str = ""


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
    reaches_solver: bool = False

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


def coded(content: bytes) -> str:
    return base64.b64encode(content).decode()


def disturbed_number(value: float, chance: random.Random) -> Any:
    pick = chance.random()
    if pick < 0.04:
        return chance.choice(WILD)
    reach = 6.0 if pick < 0.1 else 0.5 if pick < 0.3 else 0.1  # decades: most stay in their ranges
    return value * 10.0 ** chance.uniform(-reach, reach) * (1.0 if pick > 0.05 else -1.0)


@cache
def suited(name: str) -> list[str]:
    """Models that answer the undisturbed scenario of this name."""
    scenario = scenario_from(SCENARIOS[name])
    kinds = [each for each in model_names() if scenario.KIND in model_kind(each).answers]
    found = {n: findings_before(make_model(n), scenario, ()) for n in kinds if n not in LOOKED_UP}
    return [n for n, findings in found.items() if not any(each.refusal for each in findings)]


def value_at(tables: Any, place: tuple[Any, ...]) -> Any:
    return reduce(getitem, place, tables)


def reshaped(tables: dict[str, Any], chance: random.Random) -> dict[str, Any]:
    """A scenario of the same kind with other bays, loads, pulses, strikers."""
    tables = dict(tables)
    if "bays" in tables.get("frame", {}):
        base, (bays, storeys) = chance.choice(["pinned", "clamped"]), chance.choices((1, 2, 3), k=2)
        spans = {"bays": [3.0 + 3.0 * chance.random()] * bays, "storeys": [4.0] * storeys}
        tables["frame"] = {**tables["frame"], **spans, "base": base}
        tables["load"] = [{"node": "A1", "y": -1e5 * chance.random()}] * chance.randint(0, 2)
    if "pulse" in tables:
        tables["pulse"] = {**tables["pulse"], **chance.choice(PULSES)}
    if "striker" in tables and chance.random() < 0.3:
        tables["striker"] = {**tables["striker"], **chance.choice(STRIKERS)}
    return tables


def disturbed(tables: Any, chance: random.Random, most: int = 4) -> Any:
    """Tables with one to so many values elsewhere."""
    for _ in range(chance.randint(1, most)):
        place = chance.choice(places(tables))
        if isinstance(value := value_at(tables, place), float):
            tables = put(tables, place, disturbed_number(value, chance))
        elif chance.random() < 0.1:
            tables = put(tables, place, chance.choice(WILD))
    return tables


def given(tables: Any) -> dict[str, str]:
    """The file of a scenario."""
    return {"scenario.toml": coded(tomli_w.dumps(tables).encode(errors="surrogatepass"))}


def asked_of(chance: random.Random, name: str, quick: bool) -> list[str]:
    """A model, mostly one that answers the scenario of this name, and its options."""
    kind = SCENARIOS[name]["kind"]
    answer = suited(name) if chance.random() < 0.9 else []
    answer = answer or [n for n in model_names() if kind in model_kind(n).answers]
    if quick:
        answer = [n for n in answer if not model_kind(n).__module__.startswith(REFERENCES)]
        answer = [n for n in answer if n not in LOOKED_UP] or answer
    model = chance.choice(answer)
    known = {f.name for f in model_kind(model).__dataclass_fields__.values()}
    return [model, *(f"--option={key}={value}" for key, value in MESH.items() if key in known)]


def scenario_job(chance: random.Random, quick: bool, name: str = "") -> Job:
    """A scenario with one to four values elsewhere, for any model (`quick`: but references)."""
    name = name or chance.choice(list(SCENARIOS))
    tables = disturbed(reshaped(SCENARIOS[name], chance), chance)
    asked = asked_of(chance, name, quick)
    return Job(["simulate", "scenario.toml", "--model", *asked, "--out", ANSWER], given(tables))


def budget_job(chance: random.Random, quick: bool) -> Job:
    """The budget of errors of such an answer."""
    job = scenario_job(chance, True, "impact")
    spread = f"--spread={chance.choice(['mass', 'yield_stress'])}={disturbed_number(0.1, chance)}"
    return replace(job, arguments=[*job.arguments, "--budget", *chance.choice([[], [spread]])])


def limit_job(chance: random.Random, quick: bool) -> Job:
    """A search for collapse from end to end of a range."""
    name = chance.choice(["impact", "frame", "regular", "pulse", "frame-pulse"])
    key = "pulse.peak" if "pulse" in name else "striker.velocity"
    low, high = (disturbed_number(end, chance) for end in RANGES[key])
    asked = ["limit", "scenario.toml", "--model", asked_of(chance, name, True)[0], f"--over={key}"]
    more = [f"--from={low}", f"--to={high}", "--tolerance=0.05"]
    return Job([*asked, *more], given(disturbed(SCENARIOS[name], chance, 2)))


def sweep_job(chance: random.Random, quick: bool) -> Job:
    """A scenario with some values of a key, in the call, in a table of cases or in Python."""
    name = chance.choice([each for each in SCENARIOS if each != "studs"])
    tables = reshaped(SCENARIOS[name], chance)
    numbers = [each for each in places(tables) if isinstance(value_at(tables, each), float)]
    place = chance.choice([each for each in numbers if len(each) == 2])
    key, value = ".".join(map(str, place)), value_at(tables, place) or 0.5
    values = [disturbed_number(value, chance) for _ in range(chance.randint(1, 4))]
    model, files, form = asked_of(chance, name, True)[0], given(tables), chance.randrange(3)
    script = (
        "from math import inf, nan\nimport workbench as wb\n"
        f"wb.sweep('scenario.toml', {{{key!r}: {values!r}}}, [{model!r}]).outcome.item(0)\n"
    )
    if form == 2:
        return Job(["python", "script.py"], {**files, "script.py": coded(script.encode())})
    asked = [f"--over={key}={','.join(map(str, values))}", "--cases=cases.csv"][form]
    files["cases.csv"] = coded("\n".join([key, *map(str, values)]).encode())
    out = f"--out=answers.{chance.choice(['csv', 'nc', 'xlsx'])}"
    return Job(["sweep", "scenario.toml", asked, "--model", model, "--jobs=1", out], files)


def uncertain_job(chance: random.Random, quick: bool) -> Job:
    """Samples of a column with distributions, or its fragility with a reference of its own."""
    tables = tomllib.loads((TEMPLATES / "uncertain.toml.txt").read_text(encoding="utf-8"))
    files = given(disturbed(tables, chance, 3))
    low, high, most = (disturbed_number(value, chance) for value in (2.0, 12.0, 0.1))
    if chance.random() < 0.2:
        limit = chance.choice(["collapse", f"displacement={most}"])
        asked = [f"--over=striker.velocity={low}:{high}", "--limit", limit, "--reference=four-dof"]
        more = ["--model=single-dof", "--samples=2048", "--references=8", "--seconds=5"]
        return Job(["fragility", "scenario.toml", *asked, *more, "--jobs=1"], files)
    model = chance.choice(["single-dof", "four-dof", "energy-estimate", "rigid-superelement"])
    numbers = [f"--samples={chance.choice([1, 7, 40])}", f"--seed={chance.choice([1, 9, 77, -1])}"]
    more = chance.choice([["--out=a.chunks", "--slice=1/1"], ["--first=1000"], ["--out=a.xlsx"]])
    return Job(["sample", "scenario.toml", "--model", model, "--jobs=1", *numbers, *more], files)


def study_job(chance: random.Random, quick: bool) -> Job:
    """The template of a study with other numbers, models and gates, run and judged."""
    text = (TEMPLATES / "study.py.txt").read_text(encoding="utf-8")
    models = chance.sample(["single-dof", "rigid-superelement", "biggs", "four-dof-shear"], 2)
    text = text.replace('"fiber-shear", "four-dof"', f'"{models[0]}", "four-dof", "{models[1]}"')
    text = text.replace("fiber-shear", models[0])
    for number in ("2.0", "4.0", "6.0", "0.10", "500", "1.5"):
        if chance.random() < 0.3:
            text = text.replace(number, str(disturbed_number(float(number), chance)), 1)
    more = chance.choice([[], ["--quick"], ["--only=4*"], ["--timeout=30"], ["--timeout=1e-3"]])
    asked = ["run", "study.py", "--jobs=0", "--store=store", *more]
    return Job(asked, {"study.py": coded(text.encode())})


def text_job(chance: random.Random, quick: bool) -> Job:
    """A template in other words: spellings, units, blanks; a line lost, doubled, misspelt."""
    name = chance.choice(["column", "frame", "pulse"])
    lines = (TEMPLATES / f"{name}.toml.txt").read_text(encoding="utf-8").splitlines()
    for _ in range(chance.randint(1, 5)):
        at = chance.randrange(len(lines))
        key, sign, value = lines[at].split("#")[0].partition(" = ")
        number, *unit = value.strip(' "').split(" ", 1)
        pick = chance.random()
        if pick < 0.06:
            lines[at] = chance.choice(["", f"{lines[at]}\n{lines[at]}", lines[at][::-1], key])
        elif sign and number.strip("-").replace(".", "").isdigit():
            scale = f"{float(number) * 10.0 ** chance.uniform(-0.1, 0.1):e}"
            lines[at] = f"{key}\t= " + (f"'{scale} {unit[0]}'" if unit else f"+{scale}  # é")
            lines[at] = lines[at].replace("+-", "-")
    model = {"pulse": "biggs", "column": "four-dof", "frame": "rigid-superelement"}[name]
    files = {"scenario.toml": coded("\r\n".join(lines).encode())}
    return Job(["simulate", "scenario.toml", "--model", model, "--out", ANSWER], files)


def override_job(chance: random.Random, quick: bool) -> Job:
    """A good scenario with an override of any key by any text, or by a number that may do."""
    name = chance.choice(list(SCENARIOS))
    tables = SCENARIOS[name]
    place = chance.choice(places(tables))
    path, value = ".".join(map(str, place)), value_at(tables, place)
    text = chance.choice([str(value) for value in WILD] + ["[[1]", "٣", "1e999", "{a=1}", "'"])
    if isinstance(value, float) and chance.random() < 0.7:
        text = str(disturbed_number(value, chance))
    model = "single-dof" if name in ("impact", "pushover") else asked_of(chance, name, True)[0]
    asked = ["simulate", "scenario.toml", "--model", model, "--set", f"{path}={text}"]
    return Job([*asked, "--out", ANSWER], given(tables))


def rows_of(lines: list[str], chance: random.Random, most: int) -> list[str]:
    """Rows of a table, of which so many cells at `most` are exchanged, scaled or emptied."""
    lines = list(lines)
    for _ in range(chance.randint(0, most)):
        at = chance.randrange(len(lines))
        cells = lines[at].split(",")
        cell = chance.randrange(len(cells))
        try:
            cells[cell] = str(disturbed_number(float(cells[cell]), chance))
        except ValueError:
            cells[cell] = chance.choice(["", "push-out", "1", "-1", "nan", "é", "9" * 400, '"'])
        lines[at] = ",".join(cells)
    return lines


def own_job(chance: random.Random, quick: bool) -> Job:
    """An own table of impacts or studs that is checked or added, or an answer that is added."""
    head, *lines = IMPACTS.splitlines()
    files = {}
    verb = chance.choice([["check"], ["add", "--into=own"], ["add", "--into=own", "--name=é"]])
    if chance.random() < 0.3:
        tables = tomllib.loads((TEMPLATES / "column.toml.txt").read_text(encoding="utf-8"))
        files = given(disturbed(tables, chance, 2))
        head = "time_ms,displacement_mm"
        lines = [f"{ms},{100.0 * sin(pi * ms / 100.0)}" for ms in range(0, 60, 2)]
        verb = ["add-answer", "--scenario=scenario.toml", "--model=ours", "--source=Report 1"]
    content = "\n".join([head, *rows_of(lines, chance, 2)]).encode()
    return Job(["data", verb[0], "own.csv", *verb[1:]], {"own.csv": coded(content), **files})


def fit_job(chance: random.Random, quick: bool) -> Job:
    """A shipped table of stud tests with cells exchanged, scaled, emptied or doubled."""
    verb = chance.choice(["stud-strength", "few-tests"] if quick else sorted(FITS))
    name = FITS[verb] if chance.random() < 0.8 else "beam_retest"
    text = (data_directory() / "studs" / f"{name}.csv").read_text(encoding="utf-8")
    head, *lines = text.splitlines()
    first = chance.randrange(len(lines))  # a campaign or a curve stays together
    lines = lines[first : first + chance.randint(1, 120)]
    content = "\n".join([head, *rows_of(lines, chance, 4)]).encode()
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
    makers = {kind: globals()[f"{kind}_job"] for kind in SHARES}
    makers["store"] = partial(store_job, stored=stored)
    while True:
        (kind,) = chance.choices(list(SHARES), list(SHARES.values()))
        yield replace(makers[kind](chance, quick), kind=kind)


def called(file: str) -> int:
    """Exit status of a file of Python calls; what the workbench refuses ends it in one line."""
    try:
        exec(Path(file).read_text(encoding="utf-8"), {})
    except WorkbenchError as error:
        print(f"workbench: {error}", file=sys.stderr)
        return 2
    return 0


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
                verb, *rest = job.arguments
                status = called(*rest) if verb == "python" else run(job.arguments)
        except BaseException:
            return Ending(None, traceback.format_exc(), time.process_time() - before, 0)
        finally:
            os.chdir(here)
        outcome, flat = answered(Path(name, ANSWER))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    seconds = time.process_time() - before
    reaches = outcome in SOLVED or (status == 0 and verb in SOLVING and not job.store)
    reaches |= " references, " in err.getvalue()  # of a fragility, whatever came of it
    return Ending(status, err.getvalue(), seconds, memory, outcome, flat, reaches)


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
            job = pipe.recv()
            most = int(time.process_time() + 2.0 * MOST_SECONDS)  # then the system ends it
            resource.setrlimit(resource.RLIMIT_CPU, (most, resource.RLIM_INFINITY))
            pipe.send(perform(job, base))


def main() -> None:
    """Throw jobs for a while and keep those that end badly."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    context = multiprocessing.get_context("spawn")
    done = faults = 0
    statuses: Counter[int | None] = Counter()
    asked_by, reached = Counter[str](), Counter[str]()  # by kind of job
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
                theirs.close()  # so that a worker that dies is noticed
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
            asked_by[job.kind] += 1
            reached[job.kind] += ending.reaches_solver
            if ending.fault:
                faults += 1
                kept = CORPUS / f"{asked.seed}-{done}.json"
                kept.write_text(json.dumps(asdict(job), indent=1) + "\n")
                print(f"{kept.name}: {' '.join(job.arguments)}: {ending.fault}", flush=True)
        if worker is not None:
            worker.kill()
    share = 100.0 * reached.total() / max(done, 1)
    print(f"{done} jobs, {faults} of them end badly; statuses {dict(statuses)}")
    print(f"{reached.total()} reached a solver ({share:.0f} %), by kind of job:")
    print("\n".join(f"  {kind:<10}{reached[kind]:>6} of {asked_by[kind]}" for kind in SHARES))
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
