"""What an addition costs: one of each is added to a copy of the package, and the files counted."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FIGURE = '''
"""Bars of one quantity."""

from workbench.report.drawing.sheet import Drawing, Request, nothing


def draw(request: Request) -> Drawing:
    """Nothing but a sentence."""
    return nothing(f"Bars of {request.study.quantities[0]}.")
'''
MODEL = '''
"""A spring for the whole column."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from workbench.models.base import respond
from workbench.models.domain import member_findings
from workbench.responses import build_response
from workbench.scenarios import ColumnImpact


@dataclass(frozen=True)
class OneSpring:
    """A mass on an elastic spring."""

    stiffness: float = 5e6

    name: ClassVar[str] = "one-spring"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = ("Elastic.",)
    sources: ClassVar[tuple[str, ...]] = ()

    def domain(self, scenario):
        """Those of all member models."""
        return member_findings(scenario)

    def simulate(self, scenario):
        """Answer an impact."""
        return respond(self, scenario, self._solve)

    def _solve(self, scenario):
        mass, speed = scenario.striker.mass, scenario.striker.velocity
        omega = (self.stiffness / mass) ** 0.5
        time = np.linspace(0.0, np.pi / omega, 200)
        moved = speed / omega * np.sin(omega * time)
        return build_response({"displacement": moved}, time=time)
'''
METRIC = '''

@metric(
    "squared error",
    Scope.SCALAR,
    "asme-vv20",
    low=0.0,
    spread=lambda s, d, own, other: 2.0 * abs(s / d - 1.0) * (own + s / d * other) / d,
)
def squared_error(pair: ResponsePair) -> float:
    """Relative error squared."""
    return (pair.value / pair.reference - 1.0) ** 2
'''
FRAME_MODEL = '''
"""Frames whose hinges lose moment along a straight line."""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.models.frame_model import (
    ELEMENTS, GEOMETRY, REGULARISATION, TIME_STEP, FrameModel
)
from workbench.extras.frame_models.hinged_frames import (
    SHEAR_FLEXIBLE, STRAIGHT, hinged_group, plastic_end
)


@dataclass(frozen=True)
class StraightHinge(FrameModel):
    """Hinges with a straight line of N and M."""

    elements: int | None = ELEMENTS()
    time_step: float | None = TIME_STEP()
    regularisation: float = REGULARISATION()
    geometry: str = GEOMETRY()
    shear_flexible: bool = SHEAR_FLEXIBLE()

    name: ClassVar[str] = "straight-hinge"
    version: ClassVar[int] = 1
    sources: ClassVar[tuple[str, ...]] = ("orbison1982",)
    assumptions: ClassVar[tuple[str, ...]] = ("Straight yield line.",)

    def group(self, cut):
        """Bars with these hinges."""
        return hinged_group(self, cut, straight_end)


def straight_end(piece, side):
    """The hinge at one end."""
    return replace(plastic_end(piece, side), curve=STRAIGHT)
'''
LAW = '''@dataclass(frozen=True)
class HyperbolicLaw(Law):
    """q = s / (s + `half_slip`)."""

    half_slip: float = checked(Number(1e-6, 0.1, "m"), 4e-4)
    name: ClassVar[str] = "hyperbolic"
    formula: ClassVar[str] = "q = s / (s + half slip)"
    keys: ClassVar[tuple[str, ...]] = ()
    bounds: ClassVar[Mapping[str, Bound]] = {"half_slip": Bound(1e-6, 0.02, 4e-4, "mm", 1e-3)}

    def curve(self, slip):
        """Of the slip."""
        return np.asarray(slip / (slip + self.half_slip))

    def inverse(self, ratio):
        """Of the load."""
        return self.half_slip * ratio / (1.0 - ratio)


'''
VERB = '''
"""`workbench energy`: the energy that a striker brings."""

from workbench.cli.output import Answer, ScenarioFile, verb


@verb
def energy(scenario: ScenarioFile) -> Answer:
    """Print the energy of the striker."""
    from workbench.scenarios import load_scenario

    return Answer({"energy": load_scenario(scenario).input_energy})
'''
USE = """
import json
from dataclasses import replace
from pathlib import Path
from workbench.cli import run
from workbench.models.base import make_model
from workbench.report.build import build_report
from workbench.scenarios import load_scenario
from workbench.studs import fit_load_slip
from workbench.studs.tables import shipped
from workbench.study import Case, Figure, Gate, Study, assess, run_study
from workbench.base.tables import plain_rows

study = Study(
    "added", "Added", "What does an addition cost?",
    (Case("hit", load_scenario("data/published/heng2017_impact_column.toml")),),
    {"one": make_model("one-spring"), "other": make_model("energy-estimate")},
    "other",
    quantities=("largest_velocity",),
    gates=(Gate("one", "other", "peak_displacement", "squared_error", 1e3, "why", "where"),),
    figures=(Figure("bars", "bars", "Bars", "Bars."),),
)
run_study(study, Path("reports"), jobs=0)
found = assess(study, Path("reports"))
html = build_report(found, formats=("html",))["html"].read_text("utf-8")
HIT = "data/published/heng2017_impact_column.toml"
framed = make_model("straight-hinge").simulate(replace(load_scenario(HIT), duration=0.005))
slips = fit_load_slip(shipped("stud-load-slip"), "hyperbolic")
status = run(["energy", HIT])
print(json.dumps({
    "framed": framed.attrs["outcome"],
    "half slip": slips.population["half_slip"].estimates["median"],
    "verb": status,
    "outcomes": list(found.tables["cells"]["outcome"]),
    "velocities": [row["largest_velocity"] for row in plain_rows(found.tables["cells"])],
    "squared": found.verdicts[0].cases[0].value,
    "drawn": "Bars of largest_velocity." in html,
}))
"""


def append(path: Path, text: str) -> None:
    path.write_text(path.read_text(encoding="utf-8") + text, encoding="utf-8")


def swap(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), encoding="utf-8")


def add_metric(root: Path) -> None:
    append(root / "workbench/study/assessment/metric.py", METRIC)


def add_figure(root: Path) -> None:
    (root / "workbench/report/figures/bars.py").write_text(FIGURE)
    line = '    "budget": "values.budget",\n'
    swap(root / "workbench/report/figures/__init__.py", line, f'    "bars": "bars.draw",\n{line}')


def add_model(root: Path) -> None:
    (root / "workbench/models/one_spring.py").write_text(MODEL)
    heading = '[project.entry-points."workbench.models"]\n'
    entry = 'one-spring = "workbench.models.one_spring:OneSpring"\n'
    swap(root / "pyproject.toml", heading, heading + entry)
    (root / "docs/theory/one-spring.md").write_text("# `one-spring`\n")
    append(root / "docs/thesis.md", "\n`one-spring`\n")


def add_frame_model(root: Path) -> None:
    (root / "workbench/extras/frame_models/straight_hinge.py").write_text(FRAME_MODEL)
    heading = '[project.entry-points."workbench.models"]\n'
    entry = 'straight-hinge = "workbench.extras.frame_models.straight_hinge:StraightHinge"\n'
    swap(root / "pyproject.toml", heading, heading + entry)
    (root / "docs/theory/straight-hinge.md").write_text("# `straight-hinge`\n")
    append(root / "docs/thesis.md", "\n`straight-hinge`\n")


def add_law(root: Path) -> None:
    laws = root / "workbench/studs/load_slip.py"
    swap(laws, "LAWS: dict", f"{LAW}LAWS: dict")
    text = laws.read_text(encoding="utf-8")
    listed = re.search(r"LAWS: dict.* in \(([\w\s,]+)\)", text)
    assert listed is not None
    swap(laws, f"({listed[1]})", f"({listed[1].rstrip(', ')}, HyperbolicLaw)")


def add_verb(root: Path) -> None:
    (root / "workbench/cli/energy.py").write_text(VERB)
    verbs = root / "workbench/cli/__init__.py"
    line = '    "doctor": ("doctor",),\n'
    swap(verbs, line, f'{line}    "energy": ("energy",),\n')


def add_scalar(root: Path) -> None:
    line = "structure,impulse,,N s,total impulse of the contact\n"
    more = "structure,largest_velocity,,m/s,largest velocity of the striker\n"
    swap(root / "workbench/responses/variables.csv", line, line + more)
    swap(
        root / "workbench/models/energy_estimate.py",
        '"peak_displacement": peak - sag,\n',
        '"largest_velocity": scenario.striker.velocity,\n'
        '            "peak_displacement": peak - sag,\n',
    )


@pytest.mark.thorough
def test_what_additions_cost(tmp_path: Path) -> None:
    for part in ("workbench", "data", "docs"):
        # compiled kernels are copied too, but nothing that another process writes just now
        skipped = shutil.ignore_patterns("_data", "*.tmp.*", "*.pyc*")
        shutil.copytree(ROOT / part, tmp_path / part, ignore=skipped)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    # the recipes of docs/contributing.md; of a model, its pages are counted too
    costs = {
        **{add_metric: 1, add_law: 1, add_figure: 2, add_scalar: 2, add_verb: 2},
        **{add_model: 4, add_frame_model: 4},
    }
    for add, files in costs.items():
        before = contents(tmp_path)
        add(tmp_path)
        after = contents(tmp_path)
        changed = [path.name for path in after if before.get(path) != after[path]]
        assert len(changed) == files, (add.__name__, changed)
    install(tmp_path)
    done = subprocess.run(
        [sys.executable, "-c", USE],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    answer = json.loads(done.stdout.splitlines()[-1])
    assert answer["outcomes"] == ["ok", "ok"]
    assert answer["velocities"] == [None, 15.0]
    assert answer["squared"] > 0.0
    assert answer["drawn"]
    assert answer["framed"] == "ok"
    assert 1e-4 < answer["half slip"] < 1e-3
    assert answer["verb"] == 0


def contents(root: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in root.rglob("*") if path.is_file()}


def install(root: Path) -> None:
    """Do what an installation does with the declared entry points."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    directory = root / f"steel_impact_workbench-{project['version']}.dist-info"
    directory.mkdir()
    lines = ""
    for group, points in project["entry-points"].items():
        lines += f"[{group}]\n" + "".join(f"{name} = {of}\n" for name, of in points.items())
    (directory / "entry_points.txt").write_text(lines)
    (directory / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    )
