"""Configuration of a study, with all that is needed to run it again, and independent checks."""

import re
import textwrap
import tomllib
from collections.abc import Iterator, Sequence
from typing import Any

from workbench.base.catalogue import datasets
from workbench.base.datafiles import data_directory
from workbench.base.errors import OutOfDomainError
from workbench.base.tables import records
from workbench.mechanics.frames.elastic import column_line
from workbench.models.base import Model, options_of
from workbench.report.chapters.results import sources_of_tests
from workbench.report.drawing.frame import Layout
from workbench.report.page.bibliography import cited
from workbench.report.page.formatting import brief, several
from workbench.report.page.markdown import Markdown, listing
from workbench.report.page.page import Page
from workbench.scenarios import ColumnImpact, Frame, FrameImpact, Striker, to_toml
from workbench.study.assessment import METRICS
from workbench.study.assessor import Assessment
from workbench.study.cells import differences
from workbench.study.definition import Case, Study

FORMS = 4  # of frames, that are all described
_PRINTED = 60
PAGE = Page(__file__, printed=_PRINTED)
_MOST_CHANGES = 12
_MOST_ITEMS = 6
_WIDE = 96  # characters of a line in a listing
_NUMBERS = re.compile(r"^(\S+ = )\[\n((?:\s+[-+.\deE]+,\n)+)\]", re.MULTILINE)


def subject(study: Study) -> Markdown:
    """The columns and frames that are hit, and by what."""
    scenarios = [case.scenario for case in study.cases]
    columns = [each for each in scenarios if isinstance(each, ColumnImpact)]
    forms: dict[str, list[FrameImpact]] = {}
    for impact in scenarios:
        if isinstance(impact, FrameImpact):
            forms.setdefault(_form(impact.frame), []).append(impact)
    if not (columns or forms):
        return Markdown()
    alike = list(forms.values())
    return PAGE.blocks(
        "hit",
        columns=[_columns(columns)] if columns else [],
        frames=[_frames(impacts) for impacts in alike[:FORMS]],
        more=max(len(alike) - FORMS, 0),
    )


def _columns(impacts: Sequence[ColumnImpact]) -> str:
    columns = [impact.column for impact in impacts]
    hits = list(dict.fromkeys((each.length_below, each.length_above) for each in columns))
    few = len(hits) <= 2
    whole, below = _values([sum(hit) for hit in hits], 1.0, "m"), [hit[0] for hit in hits]
    springs = [each.restraint_stiffness for each in columns if each.head != "fixed"]
    return PAGE.words(
        "columns",
        sections=_names([each.section.name for each in columns]),
        steels=_values([each.steel.yield_stress for each in columns], 1e-6, "MPa"),
        places=[PAGE.words("place", below=a, above=b) for a, b in hits] if few else [],
        lengths="" if few else PAGE.words("lengths", whole=whole, below=_values(below, 1.0, "m")),
        supports=list(dict.fromkeys("{} below and {} above".format(*c.ends) for c in columns)),
        load=_values([each.axial_load for each in columns], 1e-3, "kN"),
        springs=_values(springs, 1e-6, "kN/mm") if any(springs) else "",
        striker=_strikers([impact.striker for impact in impacts]),
    )


def _form(frame: Frame) -> str:
    """Extent, members and sections that frames of one form have in common."""
    extent = Layout(frame).extent
    return f"{extent} {len(frame.members)} {_sections(frame)}"


def _sections(frame: Frame) -> str:
    return _names([member.section.name for member in frame.members])


def _frames(impacts: Sequence[FrameImpact]) -> str:
    """Frames of one form: where they are hit, and by what."""
    frame = impacts[0].frame
    extent = Layout(frame).extent
    heights = [f"{brief(each.frame.node(each.striker.node).y)} m" for each in impacts]
    return PAGE.words(
        "frame",
        width=extent.real,
        height=extent.imag,
        members=len(frame.members),
        sections=_sections(frame),
        places=_names(heights),
        striker=_strikers([each.striker for each in impacts]),
    )


def _strikers(strikers: Sequence[Striker]) -> str:
    restitutions = [each.restitution for each in strikers]
    stiffnesses = [each.stiffness for each in strikers if each.stiffness is not None]
    crushing = sum(each.crushes for each in strikers)
    return PAGE.words(
        "striker",
        crushing="all" if crushing == len(strikers) else "some" if crushing else "",
        stiffnesses=_values(stiffnesses, 1e-3, "kN/m") if stiffnesses else "",
        masses=_values([each.mass for each in strikers], 1.0, "kg"),
        velocities=_values([each.velocity for each in strikers], 1.0, "m/s"),
        restitutions=_values(restitutions, 1.0, "") if any(restitutions) else "",
    )


def hit_distance(study: Study, group: str) -> str:
    """How far from their joints the struck members of a group were hit, in heights; or nothing."""
    heights = []
    names = study.groups.get(group, [case.name for case in study.cases])  # no groups: all are one
    for case in study.cases:
        if case.name in names and isinstance(case.scenario, FrameImpact):
            try:
                line = column_line(case.scenario)
            except OutOfDomainError:  # a joint, or a beam that is no line between two
                continue
            struck = case.scenario.frame.member(line.members[0])
            height = min(line.below, line.above) / struck.section.height
            heights.append(float(f"{height:.2g}"))
    return _values(heights, 1.0, "section heights") if heights else ""


def _names(names: Sequence[str]) -> str:
    return several(list(dict.fromkeys(names)), 4)


def _values(values: Sequence[float], factor: float, unit: str) -> str:
    """One value, two, or their range."""
    distinct = sorted({float(f"{factor * value:.3g}") for value in values})
    ends = distinct if len(distinct) < 3 else [distinct[0], distinct[-1]]
    join = " and " if len(distinct) == 2 else " to "
    return f"{join.join(map(brief, ends))} {unit}".strip()


def configuration(study: Study, stored: Assessment) -> Markdown:
    """Models with options and assumptions, cases as TOML, provenance."""
    first: dict[str, Case] = {}
    for case in study.cases:
        first.setdefault(case.scenario.KIND, case)
    others = [case for case in study.cases if case is not first[case.scenario.KIND]]
    records = [
        [(name.replace("_", " "), f"`{value}`") for name, value in record.items()]
        for record in stored.provenance
    ]
    return PAGE.blocks(
        "configuration",
        models=list(_models(study)),
        one_kind=len(first) == 1,
        first=[_listing(case) for case in first.values()],
        others=[
            {"case": case, "first": kind, "changes": _changes(kind, case)}
            for case in others
            for kind in [first[case.scenario.KIND]]
        ],
        listings=[_listing(case, on_paper=False) for case in others],
        records=records,
    )


def _models(study: Study) -> Iterator[dict[str, Any]]:
    """Label, options and sources of every model; assumptions of those alike stand once."""
    stated: dict[tuple[str, ...], str] = {}
    for label, model in study.models.items():
        first = stated.setdefault(tuple(model.assumptions), label)
        alike = first != label
        pairs = [*_pairs(study, label, model), ("assumptions", f"those of {first}")]
        yield {
            "label": label,
            "pairs": pairs if alike else pairs[:-1],
            "assumptions": () if alike else model.assumptions,
        }


def _pairs(study: Study, label: str, model: Model) -> Iterator[tuple[str, str]]:
    options = [f"`{name} = {_option(value)}`" for name, value in options_of(model).items()]
    yield "model", f"`{model.name}`, version {model.version}"
    yield "options", ", ".join(options) or "none"
    if label == study.reference:
        yield "role", "the reference"
    elif label in study.ladder:
        yield "role", "a coarser level of the reference"
    if model.sources:
        yield "sources", " ".join(map(cited, model.sources))


def _option(value: object) -> str:
    if value is None:
        return "default"
    return str(value).lower() if isinstance(value, bool) else str(value)


def _listing(case: Case, *, on_paper: bool = True) -> Markdown:
    return listing(case.name, _compact(to_toml(case.scenario)), on_paper=on_paper)


def _compact(toml: str) -> str:
    """Reflow TOML: lists of numbers along the line instead of below each other."""

    def along(match: re.Match[str]) -> str:
        numbers = ", ".join(match[2].replace(",", " ").split())
        return match[1] + "\n".join(textwrap.wrap(f"[{numbers}]", _WIDE, subsequent_indent="    "))

    return _NUMBERS.sub(along, toml)


def _changes(first: Case, other: Case) -> str:
    """Entries in which one scenario file differs from another."""
    before, after = (tomllib.loads(to_toml(case.scenario)) for case in (first, other))
    changes = [
        f"`{path} = {_short(new)}`" for path, _, new in differences(before, after) if path != "name"
    ]
    if len(changes) > _MOST_CHANGES:
        return f"{len(changes)} entries: its listing is in the HTML report"
    return ", ".join(changes) or "nothing but its name"


def _short(value: Any) -> str:
    """A value as text, long lists by their ends."""
    if value is None:
        return "not set"
    if isinstance(value, list) and len(value) > _MOST_ITEMS:
        return f"[{value[0]}, ..., {value[-1]}] ({len(value)} values)"
    return str(value)


def claims() -> list[dict[str, str]]:
    """Lines of the manual, texts by column: subjects, what is claimed, expected, computed, test."""
    return list(records((data_directory() / "verification.csv").read_text(encoding="utf-8")))


def checks(study: Study, stored: Assessment) -> Markdown:
    """Checks of the models, metrics and tables of a study, what has none, and all their sources."""
    metrics = dict.fromkeys(row["metric"] for row in stored.records("comparisons"))
    tables = {entry["name"] for entry in sources_of_tests(study, stored)}
    for holder in (*study.models.values(), *(case.scenario for case in study.cases)):
        tables |= {getattr(holder, "dataset", None), *getattr(holder, "tables", ())}
        tables |= {*getattr(holder, "curves", ())}
    used = {f"model:{model.name}": model.sources for model in study.models.values()}
    used |= {f"metric:{name}": (METRICS[name].citation,) for name in metrics}
    used |= {f"dataset:{entry.name}": entry.keys for entry in datasets() if entry.name in tables}
    pairs = [(row, [name for name in used if name in row["subject"].split()]) for row in claims()]
    bare = [name for name in used if not any(name in names for _, names in pairs)]
    works = [(name, " ".join(map(cited, keys))) for name, keys in used.items() if keys]
    return PAGE.blocks("checks", rows=[pair for pair in pairs if pair[1]], bare=bare, works=works)
