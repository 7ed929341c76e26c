"""Numbers that a designer of studs asks for, from the stored fits."""

from __future__ import annotations

from collections.abc import Iterator

from workbench.content.formatting import number
from workbench.content.tree import Block, Paragraph, Section
from workbench.report.chapters import stud_tables as tables
from workbench.report.chapters.stud_evidence import Answered, answers
from workbench.report.stored import Stored
from workbench.study.definition import Study

MILLI = 1e3


def design(study: Study, stored: Stored) -> Section | None:
    """Tables of D.8, Annex B, campaigns left out, load-slip parameters and what is left."""
    blocks = tuple(_blocks(list(answers(study, stored))))
    return Section("design", "Design numbers", blocks) if blocks else None


def _blocks(found: list[Answered]) -> Iterator[Block]:
    formulas = _largest([each for each in found if "d8" in each.fit], "tests")
    several = [each for each in formulas if len(each.fit["campaigns"]) > 1] or formulas
    if several:
        yield _reference(several[0])
        noted = {f"{a.label}\n({a.case}, {a.fit['tests']} tests)": a.content for a in several}
        yield from tables.design_values(noted)
        yield from tables.left_out({a.label: a.content for a in several})
    groups = next((a.content["series"] for a in found if a.content.get("series")), None)
    if groups:
        yield from tables.series(groups)
    laws = _largest([each for each in found if "population" in each.fit], "curves")
    named = {f"{a.label} ({a.case}, {a.fit['curves']} curves)": a.content for a in laws}
    yield from tables.load_slip(named)
    yield from tables.residual(a.content for a in found if "curve" in a.content)


def _largest(found: list[Answered], size: str) -> list[Answered]:
    """The answer of every label, where its fit has most tests or curves."""
    best: dict[str, Answered] = {}
    for each in found:
        if each.label not in best or each.fit[size] > best[each.label].fit[size]:
            best[each.label] = each
    return list(best.values())


def _reference(answer: Answered) -> Paragraph:
    reference = answer.fit["reference"]
    return Paragraph(
        "EN 1990 D.8 [@en1990] for the stud in the middle of the tests: "
        f"d = {number(MILLI * reference['diameter'], 3)} mm, "
        f"h = {number(MILLI * reference['height'], 3)} mm, "
        f"f_cm = {number(reference['concrete_strength'] / 1e6, 3)} MPa, "
        f"f_u = {number((reference['ultimate_strength'] or 0.0) / 1e6, 3)} MPa. The coefficients "
        "of variation of structures to come are assumptions: diameter 1 %, concrete strength 15 %, "
        "its modulus 10 %, stud strength 5 %. γ_M* is the nominal value of the code, without "
        "partial factor, over the design value found here; EN 1994-1-1 has 1.25."
    )
