"""Answers of other programs: their histories, the model that has them, sides of every study.

``answers.csv`` beside this file declares the columns of a history, one row per instant. The
catalogue has the program as the title, and the scenario that it was given.
"""

import hashlib
import json
import tomllib
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from workbench.base.arrays import Array
from workbench.base.catalogue import ANSWERS, IMPORTED, Dataset, datasets
from workbench.base.errors import (
    Collapse,
    CollapseError,
    InputError,
    Mechanism,
    OutOfDomainError,
    shown,
)
from workbench.base.fields import Number, Text, checked
from workbench.extras.intake.mapping import check_stated
from workbench.models.base import Answering
from workbench.responses import (
    PEAK,
    RESIDUAL,
    Finding,
    Response,
    build_response,
    finding,
    set_attributes,
)
from workbench.scenarios import (
    ColumnImpact,
    FrameImpact,
    FramePulse,
    MemberPulse,
    Scenario,
    scenario_from,
    to_toml,
)
from workbench.studs.schema import TableSchema, declared, examine
from workbench.study.cells import differences
from workbench.study.definition import LONGEST, Case, Figure, Study

SERIES = TableSchema("answers", declared("answers", Path(__file__).with_name("answers.csv")))
STANDS, NOT_KNOWN = "none", "not known"
UNSTATED = "not stated: to be used here, not passed on"  # licence of an answer, unless given
ROUNDED = 1e-3  # share by which what follows from a section may differ: tables print three digits
_LONGEST = LONGEST - 20  # characters of a program in words, which is a label of studies
_SLOWEST, _FASTEST = 1.0 / 500.0, 2.0  # mean speed of what is hit over that of the striker
_SHARED = 0.1  # the slowest of a column, over the speed of striker and hit mass together
_LATEST = 0.1  # of the peak and its time, at which a history may begin
_STATED = ("name", "title", "source", "licence", "uncertainty", "made")
_DRAWN = ("history", "peaks")  # kinds of figures that take a further line


def contrasts(theirs: Any, ours: Any) -> tuple[list[str], list[str]]:
    """Inputs in which two scenarios differ, name and duration aside, one sentence each.

    Then those that follow from the section, which tables print rounded, and differ by no more than
    `ROUNDED`: they make no other scenario.
    """
    if theirs.KIND != ours.KIND:
        return [f"kind: theirs {theirs.KIND}, ours {ours.KIND}"], []
    differ, rounded = list[str](), list[str]()
    before, after = (tomllib.loads(to_toml(scenario)) for scenario in (theirs, ours))
    for path, *values in differences(before, after):
        table, _, name = path.partition(".")
        derived = table == "column" and hasattr(ours.column.properties, name)
        if derived:  # left out, it is that of the section
            values = [getattr(each.column.properties, name) for each in (theirs, ours)]
        near = derived and abs(values[0] - values[1]) <= ROUNDED * abs(values[1])
        if path not in ("name", "time.duration"):
            text = "{}: theirs {}, ours {}".format(path, *map(shown, values))
            (rounded if near else differ).append(text)
    return differ, rounded


def _nearest(differ: dict[str, list[str]]) -> tuple[str, str]:
    """Name of the scenario that differs least, and in what; another kind is farthest."""
    name = min(differ, key=lambda name: (differ[name][0].startswith("kind"), len(differ[name])))
    return name, "; ".join(differ[name])


def half_width(text: str, peak: float) -> float | None:
    """Half-width (m) of displacements known to ``"3 %"`` of their `peak` (m) or to ``"4 mm"``.

    None where that is not known. Raises `InputError`.
    """
    if text == NOT_KNOWN:
        return None
    number, percent, rest = text.partition("%")
    with suppress(ValueError):
        given: Any = float(number) / 100.0 if percent and not rest else text
        rule = Number(0.0, 1.0, "" if percent else "m", low_included=False)
        return rule.check("--uncertainty", given) * (peak if percent else 1.0)
    allowed = 'must look like "3 %", which is of the peak, or "4 mm"'
    raise InputError("--uncertainty", text, allowed, "half-width of a 95 % interval")


def held(entry: Dataset, rows: pd.DataFrame) -> Response | CollapseError:
    """The response, or the collapse, that an answer of the catalogue holds.

    Arguments: its `rows` in the columns of `SERIES`. Raises `InputError` for rows that are no
    history of its scenario.
    """
    Text(_LONGEST).check("--model", entry.title)
    check_stated("--source", entry.source)
    half_width(entry.uncertainty, 1.0)
    place, scenario = entry.file, asked_of(entry)
    if scenario.KIND not in Imported.answers:
        allowed = f"takes no answers; they are to {', '.join(Imported.answers)}"
        raise InputError("scenario, kind", scenario.KIND, allowed)
    known = rows.drop(columns="collapse", errors="ignore").dropna(axis=1, how="all")
    for column in known.columns[known.isna().any()]:
        raise InputError(f"{place}, column {column}", "", "must have a number in all rows or none")
    values: dict[str, Any] = {
        SERIES.column(n).base: known[n].to_numpy(float) for n in map(str, known)
    }
    time, displacement = values.pop("time"), values["displacement"]
    for i in np.flatnonzero(np.diff(time) <= 0.0):
        allowed = f"must be later than the row before, {time[i]:g} s"
        raise InputError(f"{place}, column time_s", float(time[i + 1]), allowed)
    fallen = [word for word in rows.get("collapse", ()) if word != STANDS]
    if fallen:
        reached = float(displacement[-1])
        collapse = Collapse(Mechanism(fallen[0]), ("structure",), reached, float(time[-1]))
        return CollapseError(collapse, f"so ended the run of {entry.title}")
    if "force" in values:  # as impulses of steps, of which the rest follows as for our models
        force = values.pop("force")
        impulses = 0.5 * (force[1:] + force[:-1]) * np.diff(time)
        values["percussion"] = np.concatenate([[0.0], impulses])
    else:
        values["balance_error"] = None  # a ledger of a blow begins with its impulses
    velocity = None
    if isinstance(scenario, (ColumnImpact, FrameImpact)):
        velocity, values["input_energy"] = scenario.striker.velocity, scenario.input_energy
    response = build_response(values, time=time)
    if PEAK not in response:
        advice = "run longer; of a collapse say --outcome geometry, squash, buckling or shear"
        raise InputError(f"{place}, column time_s", float(time[-1]), "ends before its peak", advice)
    if velocity is not None:
        slowest = _SLOWEST
        if isinstance(scenario, ColumnImpact):
            mass, more = scenario.striker.mass, scenario.column.properties.impact_mass
            slowest = max(_SLOWEST, _SHARED * mass / (mass + more))
        _check_plausible(place, time, displacement, response, velocity, slowest)
    width = half_width(entry.uncertainty, float(response[PEAK]))
    widths = {} if width is None else {PEAK: width, RESIDUAL: width}
    stated = {name: getattr(entry, name) for name in _STATED}
    set_attributes(response, data_uncertainty=widths, data=stated)
    return response


def _check_plausible(
    place: str,
    time: Array,
    displacement: Array,
    response: Response,
    velocity: float,
    slowest: float,
) -> None:
    """Refuse what no striker of this velocity (m/s) makes: other units, signs, clocks."""
    peak, at = float(response[PEAK]), float(response["time_of_peak"])
    if peak < 0.0:
        advice = "along the strike is positive: change the sign"
        raise InputError(f"{place}, displacement", peak, "has a peak below zero", advice)
    if not 0.0 <= time[0] <= _LATEST * at or abs(displacement[0]) > _LATEST * peak:
        allowed = f"begins at {time[0]:.3g} s with {displacement[0]:.3g} m"
        raise InputError(place, None, allowed, "count time and displacement from first contact")
    later = time > time[0]
    mean = (displacement[later] - displacement[0]) / (time[later] - time[0])
    ratio = float(np.max(mean)) / velocity
    if not slowest <= ratio <= _FASTEST:
        allowed = f"moves {ratio:.3g} times as fast as the striker, {velocity:g} m/s"
        advice = "are time and displacement in the units that the table says?"
        raise InputError(f"{place}, displacement", peak, allowed, advice)


def asked_of(entry: Dataset) -> Scenario:
    """The scenario that an answer is to. Raises `InputError` naming a spoilt entry."""
    try:
        return scenario_from(entry.asked or {})
    except InputError as error:
        place = f"data catalogue, answer {entry.name}, {error.field}"
        raise InputError(
            place, error.value, error.allowed, "mend the entry or delete it"
        ) from error


def check_new(entry: Dataset, other: Dataset) -> None:
    """Refuse a second answer of a program to the scenario of another one. Raises `InputError`."""
    both = [asked_of(each) for each in (entry, other) if each.asked]
    if len(both) == 2 and entry.title == other.title and not contrasts(*both)[0]:
        allowed = f"has answered this scenario already, as {other.name}"
        raise InputError("--model", entry.title, allowed, "say what is new, or remove that one")


@dataclass(frozen=True)
class Imported(Answering):
    """Answers of other programs in the data catalogue. Option: `answer`, the name of one.

    Or that of a program, for all of its answers; all there are by default. The response has the
    history as it came, and as attribute `data_uncertainty` how well displacements are known.
    """

    answer: str | None = checked(Text(LONGEST), optional=True)

    name: ClassVar[str] = IMPORTED
    version: ClassVar[int] = 1
    sources: ClassVar[tuple[str, ...]] = ()  # those of an answer stand in its attribute `data`
    judged: ClassVar[bool] = False
    crushing: ClassVar[bool] = True  # whatever a program knows, it was asked this scenario
    spatial: ClassVar[bool] = True
    eccentric: ClassVar[bool] = True
    material: ClassVar[tuple[str, ...]] = ("rate", "hardening")
    answers: ClassVar[tuple[str, ...]] = (
        *(ColumnImpact.KIND, MemberPulse.KIND, FrameImpact.KIND, FramePulse.KIND),
    )
    assumptions: ClassVar[tuple[str, ...]] = (
        "Numbers as another program gives them; they answer only the scenario that it was given.",
        "Its own assumptions are not known here: its source has them.",
    )

    def check(self) -> None:
        """Refuse a name that no answer has."""
        if self.answer is not None and not self.entries:
            known = ", ".join(e.name for e in datasets() if e.kind == ANSWERS) or "none"
            text = f"is no answer of the catalogue; there are {known}"
            raise self.refusal("answer", text, "workbench data add-answer adds one")

    @property
    def entries(self) -> tuple[Dataset, ...]:
        """The answers in the catalogue whose tables are there."""
        every = (e for e in datasets() if e.kind == ANSWERS and e.path.is_file())
        return tuple(e for e in every if self.answer in (None, e.name, e.title))

    @property
    def data_digest(self) -> str:
        """Hash of the answers, so that stored cells follow changes."""
        digest = hashlib.sha256()
        for entry in self.entries:
            said = [entry.asked, *(getattr(entry, name) for name in _STATED)]
            digest.update(json.dumps(said).encode() + entry.path.read_bytes())
        return digest.hexdigest()[:16]

    def domain(self, scenario: Scenario) -> list[Finding]:
        """Refuse what was not answered, input by input; note what tables of sections round."""
        both = {e.name: contrasts(asked_of(e), scenario) for e in self.entries}
        alike = {name: rounded for name, (differ, rounded) in both.items() if not differ}
        if not both:
            return [finding("answer-none")]
        if not alike:
            name, inputs = _nearest({name: differ for name, (differ, _) in both.items()})
            return [finding("answer-other", name=name, inputs=inputs)]
        if len(alike) > 1:
            return [finding("answers-several", names=", ".join(alike))]
        rounded = "; ".join(*alike.values())
        return [finding("answer-rounded", inputs=rounded)] if rounded else []

    def _solve(self, scenario: Scenario) -> Response:
        for entry in self.entries:
            if not contrasts(asked_of(entry), scenario)[0]:
                answer = held(entry, examine(entry.path, SERIES).accept())
                if isinstance(answer, CollapseError):
                    raise answer
                return answer
        raise OutOfDomainError("nothing was imported for this scenario")


def cases_of_answer(study: Study, theirs: Scenario) -> list[str]:
    """Names of the cases of a study that ask a scenario.

    Raises `InputError` with what differs in the nearest case where none does.
    """
    differ = {case.name: contrasts(theirs, case.scenario)[0] for case in study.cases}
    found = [name for name, inputs in differ.items() if not inputs]
    if not found:
        allowed = "is no case of {}; beside its case {}: {}".format(study.name, *_nearest(differ))
        raise InputError("--scenario", theirs.name, allowed, "give the program that of a case")
    return found


def joined(study: Study) -> Study:
    """The study with the answers of the catalogue to its scenarios as further sides.

    One for every program: it is asked in the groups of cases in which it has an answer, and
    refuses the others there; figures of these cases show it. Without answers, the study itself.
    """
    for title in dict.fromkeys(entry.title for entry in Imported().entries):
        known = set[str]()
        for entry in Imported(title).entries:
            theirs = asked_of(entry)
            with suppress(InputError):  # no case asks it
                known |= {*cases_of_answer(study, theirs)}
        if known:
            study = _with_side(study, title, known)
    return study


def _with_side(study: Study, title: str, known: set[str]) -> Study:
    """The study with a program as a side that knows some of the cases."""
    label = title if title not in study.models else f"{title} ({IMPORTED})"
    groups = study.groups.values() or [tuple(case.name for case in study.cases)]
    asked = known.union(*(group for group in groups if known & {*group}))

    def asking(case: Case) -> Case:
        labels = case.models or tuple(study.models)
        return replace(case, models=(*labels, label) if case.name in asked else labels)

    def showing(figure: Figure) -> Figure:
        own = {case.name for case in study.cases if case.figure == figure.key}
        cases = {*figure.options.get("cases", ())} or own or known
        further = figure.models and figure.kind in _DRAWN and cases & known
        return replace(figure, models=(*figure.models, label)) if further else figure

    return replace(
        study,
        cases=tuple(map(asking, study.cases)),
        models={**study.models, label: Imported(title)},
        figures=tuple(map(showing, study.figures)),
        quick_models=(*study.quick_models, label) if study.quick_models else (),
    )
