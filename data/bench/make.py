"""Cases of the impact bench, drawn and answered in some hours.

    PYTHONPATH=studies python data/bench/make.py KEY.json

Draws all cases anew, asks their references, writes their folders, and seals half of the answers
with a new key, see ``rotate.py``.

A case is left out, and the next one drawn, where its reference refuses, warns that it is outside
its domain or unsure of itself, or does not know its peak within 5 %; and where a coarser mesh, or
near a collapse the other fiber beam, disagrees about whether the structure falls.
"""

import json
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import count
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import drawn_columns
import drawn_directions
import drawn_frames
import drawn_pulses
import numpy as np
import shear_columns
import tomli_w
import which_model
from rotate import seal
from scipy.stats import qmc

import workbench
from workbench.extras.bench.cases import CASE, SCENARIO, ReferenceAnswer
from workbench.models.base import make_model
from workbench.responses import Outcome, findings_of, outcome_of
from workbench.responses.uncertainty import uncertainty_of
from workbench.scenarios import load_scenario, scenario_hash, to_toml
from workbench.study.error_model.error_table import DEMAND, STRIKER, features
from workbench.study.error_rows import DOUBTFUL

HERE = Path(__file__).resolve().parent
SEED = 20481
WELL, KNOWN = 0.03, 0.05  # half-widths over the peak: no finer mesh is asked; none is taken beyond
BENDING, SHEAR, SPACE, SOLID = "fiber-reissner", "fiber-shear", "fiber-space", "solid-plane-stress"
OPTIONS: dict[str, tuple[dict[str, int], ...]] = {  # meshes in turn, until the peak is well known
    BENDING: ({"levels": 3}, {"refinement": 1, "levels": 3}),
    SHEAR: ({"levels": 3}, {"refinement": 1, "levels": 3}),
    SPACE: ({"levels": 2}, {"refinement": 1, "levels": 2}),
    SOLID: ({},),
}
DOUBTS = {*DOUBTFUL} - {"mesh"}  # an error of the mesh is in the half-width
LONGEST = 0.3  # s, of a hit from the side
WEBS_GOVERN = 0.5  # V/Vpl of the mechanism from which webs are to yield


class Group(NamedTuple):
    """Cases of one kind: how many, where they come from, which reference answers them."""

    size: int
    drawn: Iterator[Any]
    reference: str = SHEAR
    near: bool = False  # close to collapse: half of them fall, and both fiber beams say so


GROUPS = (  # the dear ones first
    *("column", "near-collapse", "oblique", "thesis-column", "thesis-frame"),
    *("frame", "rate", "weak-axis", "hollow", "shear", "pulse"),
)


def columns() -> Iterator[Any]:
    """Struck columns of all cells of mass ratio and V/Vpl, in a random order."""
    drawn = [impact for impact, _ in which_model.stratified(SEED, np.full((3, 3), 5))]
    yield from (drawn[place] for place in np.random.default_rng(SEED).permutation(len(drawn)))


def sheared() -> Iterator[Any]:
    """Columns whose mechanism needs more than the plastic shear resistance."""
    points = qmc.LatinHypercube(8, seed=SEED + 1).random(120)
    for number, share in enumerate(points):
        case = shear_columns.strike(shear_columns.column_of(share, number), share, number, False)
        if case.parameters[shear_columns.DEMAND] >= 1.0:
            yield case.scenario


def hollow() -> Iterator[Any]:
    """Columns of round and of rectangular tubes in turn."""
    rng, tubes = np.random.default_rng(SEED + 2), which_model.SECTIONS[-4:-1]
    for impact in drawn_columns.hits_of(SEED + 2, drawn_columns.TUBES):
        yield impact
        yield which_model.drawn(rng.random(14), 1, bool(rng.random() < 0.35), tubes, (-0.1, 0.5))


def oblique() -> Iterator[Any]:
    """Columns hit off their web, so that fibers in space know the peak within minutes.

    Shortly, and by strikers that weigh no less than the lumped mass of the column.
    """
    for impact in drawn_directions.drawn_columns(SEED + 8, 1000):
        if impact.duration <= LONGEST and features(impact)[STRIKER] >= 1.0:
            yield impact


def frames() -> Iterator[Any]:
    """Frames of one or two storeys, every third hit by a light striker."""
    heavy = drawn_frames.drawn_hits(SEED + 3, 1000)
    light = drawn_frames.drawn_hits(SEED + 4, 1000, light=True)
    yield from (next(heavy if number % 3 else light) for number in count(1))


def pulses() -> Iterator[Any]:
    """Members under pulses, every fourth under one that rises."""
    plain = drawn_pulses.drawn_members(SEED + 5, 1000)
    rising = drawn_pulses.drawn_members(SEED + 6, 1000, rises=True)
    yield from (next(plain if number % 4 else rising) for number in count(1))


def thesis_column() -> Iterator[Any]:
    """The column of the thesis, hit as fast as the solid is sure of itself."""
    column = load_scenario(HERE.parent / "published" / "heng2017_impact_column.toml")
    yield from (column.at_velocity(velocity) for velocity in (15.0, 10.0, 5.0))


def thesis_frame() -> Iterator[Any]:
    """The frame of the thesis, hit at 50 m/s."""
    frame = load_scenario(HERE.parent / "published" / "heng2017_frame.toml")
    yield replace(frame, duration=0.06)


def groups() -> dict[str, Group]:
    """All groups of the bench by name."""
    hits = partial(drawn_columns.hits_of, SEED + 7)
    return {
        "column": Group(20, columns(), ""),
        "frame": Group(10, frames()),
        "pulse": Group(8, pulses()),
        "shear": Group(8, sheared()),
        "near-collapse": Group(8, hits(drawn_columns.NEAR), near=True),
        "rate": Group(6, hits(drawn_columns.RATES), ""),
        "weak-axis": Group(6, hits(drawn_columns.FLANGES), ""),
        "oblique": Group(4, oblique(), SPACE),
        "hollow": Group(8, hollow()),
        "thesis-column": Group(1, thesis_column(), SOLID),
        "thesis-frame": Group(1, thesis_frame(), BENDING),
    }


def titled(scenario: Any) -> Any:
    """The scenario under a name that says what it is."""
    if scenario.name != "drawn":
        return scenario
    column, hit = scenario.column, scenario.striker
    name = f"{column.section.name}, {column.length_below:.2f} + {column.length_above:.2f} m, "
    return replace(scenario, name=name + f"{hit.velocity:.1f} m/s, {hit.mass:.0f} kg")


def falls(name: str, scenario: Any) -> bool | None:
    """Whether the structure collapses on the usual mesh of a reference; None: no answer."""
    outcome = outcome_of(make_model(name, {"levels": 1}).simulate(scenario))
    return None if not outcome.is_answer else outcome is Outcome.COLLAPSE


class Asked(NamedTuple):
    """The answer of a reference and its options; or why the case is left out."""

    answer: ReferenceAnswer | None
    options: dict[str, int]
    reason: str = ""


def asked(model: str, scenario: Any, near: bool) -> Asked:
    """The answer of a reference on the first mesh that knows it well, else on the finest."""
    last = Asked(None, {}, "peak not known within 5 %")
    for options in OPTIONS[model]:
        response = make_model(model, options).simulate(scenario)
        outcome = outcome_of(response)
        if not outcome.is_answer:
            return Asked(None, {}, str(outcome))
        doubts = [f.subject for f in findings_of(response) if f.outside or f.subject in DOUBTS]
        if doubts:
            return Asked(None, {}, f"doubts itself ({doubts[0]})")
        fallen = outcome is Outcome.COLLAPSE
        others = {SHEAR, BENDING} if near else {model} if fallen else set[str]()
        if any(falls(each, scenario) is not fallen for each in sorted(others)):
            return Asked(None, {}, "references disagree about collapse")
        if fallen:
            if options == OPTIONS[model][-1]:
                return Asked(ReferenceAnswer("collapse"), options)
            continue
        peak = abs(float(response["peak_displacement"]))
        width = uncertainty_of(response, "peak_displacement")
        if width is not None and width <= KNOWN * peak:
            answer = ReferenceAnswer("ok", float(f"{peak:.6g}"), float(f"{width:.2g}"))
            last = Asked(answer, options)
            if width <= WELL * peak:
                break
    return last


def draw_group(group: str) -> tuple[dict[str, ReferenceAnswer], dict[str, int]]:
    """Draw the cases of a group and write their folders: references, and how many were left out."""
    size, drawn, reference, near = groups()[group]
    answers = dict[str, ReferenceAnswer]()
    reasons, kept = dict[str, int](), {"ok": 0, "collapse": 0}
    while len(answers) < size:
        scenario = titled(next(drawn))
        name = group if size == 1 else f"{group}-{len(answers) + 1:02d}"
        model = reference
        if not model:
            model = SHEAR if features(scenario)[DEMAND] >= WEBS_GOVERN else BENDING
        folder = HERE / name
        folder.mkdir(exist_ok=True)
        (folder / SCENARIO).write_text(to_toml(scenario), encoding="utf-8")
        scenario = load_scenario(folder / SCENARIO)
        answer, options, reason = asked(model, scenario, near)
        if answer is not None and near and kept[answer.outcome] >= size // 2:
            answer, reason = None, f"enough that end in {answer.outcome}"
        print(name, scenario.name, model, options, answer, reason, flush=True)
        if answer is None:
            reasons[reason] = reasons.get(reason, 0) + 1
            continue
        kept[answer.outcome] += 1
        answers[name] = answer
        solver = make_model(model)
        content = {
            "group": "thesis" if size == 1 else group,
            "scenario": scenario_hash(scenario),
            "asked": "outcome (ok or collapse) and peak_displacement at the hit point",
            "computed_by": f"steel-impact-workbench {workbench.__version__}",
            "model": {"name": model, "version": solver.version, "options": options},
        }
        (folder / CASE).write_text(tomli_w.dumps(content), encoding="utf-8")
    return answers, reasons


def draw(key: Path) -> None:
    """Draw all cases, ask their references, write the folders and the key."""
    answers, left_out = dict[str, ReferenceAnswer](), dict[str, dict[str, int]]()
    with ProcessPoolExecutor(2, get_context("fork")) as workers:
        for group, (of_group, reasons) in zip(GROUPS, workers.map(draw_group, GROUPS), strict=True):
            answers |= of_group
            left_out[group] = reasons
    (HERE / "left_out.json").write_text(json.dumps(left_out, indent=1) + "\n", encoding="utf-8")
    seal(HERE, answers, sorted(answers)[1::2], key)


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
