"""What was struck, in one sentence: a reader has to know whether it is his own structure."""

import re
from collections.abc import Iterator, Sequence

from workbench.content.formatting import brief, count, several
from workbench.content.tree import Block, Paragraph
from workbench.errors import OutOfDomainError
from workbench.frames.column_line import column_line
from workbench.report.drawing.layout import Layout
from workbench.scenarios import ColumnImpact, Frame, FrameImpact, Striker
from workbench.study.definition import Study

FORMS = 4  # of frames, that are all told


def subject(study: Study) -> Iterator[Block]:
    """The columns and frames that are hit, and by what."""
    scenarios = [case.scenario for case in study.cases]
    columns = [each for each in scenarios if isinstance(each, ColumnImpact)]
    frames = [each for each in scenarios if isinstance(each, FrameImpact)]
    said = [*(_columns(columns) if columns else ()), *(_frames(frames) if frames else ())]
    if said:
        yield Paragraph(f"What is hit: {'; '.join(said)}.")


def measured_at(study: Study, group: str) -> str:
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
    if not heights:
        return ""
    return f" Measured on hits {_values(heights, 1.0, 'section heights')} from the nearest joint."


def in_labels(study: Study, text: str) -> str:
    """A text that names models as the registry does, with the labels that the study gives them."""
    labels: dict[str, str] = {}
    for label, model in study.models.items():
        labels.setdefault(model.name, label)
    names = "|".join(map(re.escape, sorted(labels, key=len, reverse=True)))
    whole = rf"(?<![\w-])(?:{names})(?![\w-]| --option)"
    return re.sub(whole, lambda match: f"{match[0]} ({labels[match[0]]})", text)


def _columns(impacts: Sequence[ColumnImpact]) -> Iterator[str]:
    owns = [impact.column for impact in impacts]
    steels = _values([own.steel.yield_stress for own in owns], 1e-6, "MPa")
    yield f"{_names([own.section.name for own in owns])} of {steels}"
    hits = list(dict.fromkeys((own.length_below, own.length_above) for own in owns))
    if len(hits) <= 2:
        yield "hit " + " or ".join(
            f"{brief(a)} m above the base, {brief(b)} m below the head" for a, b in hits
        )
    else:
        below, whole = ([pair[0] for pair in hits], [sum(pair) for pair in hits])
        yield f"{_values(whole, 1.0, 'm')} long, hit {_values(below, 1.0, 'm')} above the base"
    yield " or ".join(dict.fromkeys(f"{own.base} below and {own.head} above" for own in owns))
    yield f"axial load {_values([own.axial_load for own in owns], 1e-3, 'kN')}"
    springs = [own.restraint_stiffness for own in owns if own.head != "fixed"]
    if any(springs):
        yield f"axial spring at the head {_values(springs, 1e-6, 'kN/mm')}"
    yield _strikers([impact.striker for impact in impacts])


def _frames(impacts: Sequence[FrameImpact]) -> Iterator[str]:
    """Frames of one form in one part each: where they are hit, and by what."""
    forms: dict[str, list[FrameImpact]] = {}
    for impact in impacts:
        forms.setdefault(_form(impact.frame), []).append(impact)
    for form, alike in list(forms.items())[:FORMS]:
        places = [f"{brief(each.frame.node(each.striker.node).y)} m" for each in alike]
        where = f"hit {_names(places)} above the ground"
        yield ", ".join((form, where, _strikers([each.striker for each in alike])))
    if len(forms) > FORMS:
        yield f"{count(len(forms) - FORMS, 'frame')} of other forms"


def _form(frame: Frame) -> str:
    members = _names([member.section.name for member in frame.members])
    extent = Layout(frame).extent
    size = f"{brief(extent.real)} m wide and {brief(extent.imag)} m high"
    return f"a frame {size} of {count(len(frame.members), 'member')} ({members})"


def _strikers(strikers: Sequence[Striker]) -> str:
    masses = _values([each.mass for each in strikers], 1.0, "kg")
    speeds = _values([each.velocity for each in strikers], 1.0, "m/s")
    given_back = [each.restitution for each in strikers]
    bounce = f", restitution {_values(given_back, 1.0, '')}" if any(given_back) else ""
    return f"by a rigid striker of {masses} at {speeds}{bounce}"


def _names(names: Sequence[str]) -> str:
    return several(list(dict.fromkeys(names)), 4)


def _values(values: Sequence[float], factor: float, unit: str) -> str:
    """One value, two, or their range."""
    found = sorted({float(f"{factor * value:.3g}") for value in values})
    ends = found if len(found) < 3 else [found[0], found[-1]]
    join = " and " if len(found) == 2 else " to "
    return f"{join.join(map(brief, ends))} {unit}".strip()
