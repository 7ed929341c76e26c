"""Studs: what no test validates, what unseen tests say of the rest, numbers for designers."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from workbench.content.formatting import count, number, percent
from workbench.content.tree import Block, Bullets, Callout, Paragraph, Section
from workbench.report.chapters import stud_tables as tables
from workbench.report.stored import Stored
from workbench.responses import Finding, findings_of
from workbench.scenarios import StudTests
from workbench.studs.answers.typed import content_of
from workbench.study.definition import Study


class Answered(NamedTuple):
    """A stored answer on studs: its case and label, what was asked, its content and findings."""

    case: str
    label: str
    asked: str
    content: dict[str, Any]
    findings: list[Finding]

    @property
    def fit(self) -> dict[str, Any]:
        """The fit behind the answer, empty where there is none."""
        return self.content.get("fit") or {}


def answers(study: Study, stored: Stored) -> Iterator[Answered]:
    """Every stored answer to a question on studs."""
    for case in study.cases:
        if not isinstance(case.scenario, StudTests):
            continue
        for label in study.models:
            response = stored.response(case.name, label)
            content = {} if response is None else content_of(response)
            if response is not None and content:
                found = findings_of(response)
                yield Answered(case.name, label, case.scenario.asked, content, found)


def in_short(study: Study, stored: Stored) -> Section | None:
    """What is not validated, then what unseen tests say; None for a study without studs."""
    found = list(answers(study, stored))
    if not found:
        return None
    blocks: list[Block] = []
    missing = [*_residual(found), *_combined(found)]
    if missing:
        text = f"Not validated: {'; '.join(missing)}. Do not design with these numbers."
        blocks.append(Callout("bad", text))
    blocks.extend(_strength(found))
    items = [*_judged(study, found), *_factors(found)]
    if items:
        blocks.append(Bullets(tuple(items)))
    return Section("short", "In short", tuple(blocks))


def _residual(found: list[Answered]) -> Iterator[str]:
    grades: dict[str, dict[str, None]] = {}
    for each in found:
        if "curve" in each.content and not each.content["judgement"]:
            grades.setdefault(each.fit["grade"], {})[each.fit["quantity"]] = None
    for grade, quantities in grades.items():
        yield f"{' and '.join(quantities)} left after damage ({grade})"


def _combined(found: list[Answered]) -> Iterator[str]:
    asked = [each.content for each in found if each.asked == "interaction"]
    if asked and not any(content.get("tests") for content in asked):
        yield "tension and shear together (no combined test is in the tables)"


def _strength(found: list[Answered]) -> Iterator[Block]:
    formulas = [each for each in found if "d8" in each.fit]
    if not formulas:
        return
    widest = max(formulas, key=lambda each: len(each.fit["campaigns"]))
    texts = []
    if widest.fit["new_campaign_factor"] is None:
        texts.append(
            f"Strength rests on {count(widest.fit['tests'], 'test')} of "
            f"{count(len(widest.fit['campaigns']), 'campaign')}: they do not tell how much "
            "campaigns differ, so there is no value for a new one, and EN 1990 D.8, which takes "
            "all tests as independent, errs on the unsafe side."
        )
    shank = [finding.text for finding in widest.findings if finding.subject == "shank"]
    texts += [f"{text[0].upper()}{text[1:]}." for text in shank]
    if texts:
        yield Callout("doubt", " ".join(texts))


def _judged(study: Study, found: list[Answered]) -> Iterator[str]:
    """One sentence for every label that a gate judges by unseen tests."""
    for label in dict.fromkeys(gate.model for gate in study.gates):
        own = (each for each in found if each.label == label and each.content.get("judgement"))
        parts = [judged(each.content["judgement"]) for each in own]
        if parts:
            yield f"{label}: {'; '.join(parts)}."


def judged(judgement: dict[str, Any]) -> str:
    """How a fit meets what it has not seen, in words."""
    return (_curves if "curves" in judgement else _tests)(judgement)


def _tests(judgement: dict[str, Any]) -> str:
    ratio, interval = number(judgement["test_over_prediction"], 3), judgement["interval"]
    closed = interval and None not in (interval["low"], interval["high"])
    least = judgement["least_test_over_prediction"]
    tests = f"{count(judgement['tests'], 'unseen test')} of {', '.join(judgement['campaigns'])}"
    text = f"{tests} bore {ratio}" + (f" ({tables.span(interval)})" if closed else "")
    text += " of the prediction in the median"
    return text + (f", {judgement['worst']} only {number(least, 2)}" if least < 1.0 else "")


def _curves(judgement: dict[str, Any]) -> str:
    text = f"on {count(judgement['curves'], 'unseen curve')}"
    if judgement["coverage"] is not None:
        text += f" its 90 % band holds {percent(judgement['coverage'], signed=False)} of the points"
    if judgement["stiffness"]:
        ratio = number(judgement["stiffness"]["test_over_prediction"], 3)
        text += f", stiffness is {ratio} times the predicted one"
    return text


def _factors(found: list[Answered]) -> Iterator[str]:
    """The partial factors that EN 1990 D.8 gives over most tests."""
    known = [each for each in found if each.fit.get("d8", {}).get("gamma_m_star") is not None]
    most = max((each.fit["tests"] for each in known), default=0)
    factors = {e.label: e.fit["d8"]["gamma_m_star"] for e in known if e.fit["tests"] == most}
    if factors:
        shown = ", ".join(f"{number(star, 3)} ({label})" for label, star in factors.items())
        yield (
            f"EN 1990 D.8 over {most} tests asks for a partial factor gamma_M* of {shown}; EN "
            "1994-1-1 has 1.25. It shows the procedure, it is no design value for a project."
        )


def design(study: Study, stored: Stored) -> Section | None:
    """Tables of D.8, Annex B, campaigns left out, load-slip parameters and what is left."""
    blocks = tuple(_blocks(list(answers(study, stored))))
    return Section("design", "Design numbers", blocks) if blocks else None


def _blocks(found: list[Answered]) -> Iterator[Block]:
    formulas = _largest([each for each in found if "d8" in each.fit], "tests")
    several = [each for each in formulas if len(each.fit["campaigns"]) > 1] or formulas
    if several:
        yield reference_stud(several[0].fit["reference"])
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


def reference_stud(reference: dict[str, Any]) -> Paragraph:
    """The stud that EN 1990 D.8 was evaluated for, and what was assumed of structures to come."""
    return Paragraph(
        "EN 1990 D.8 [@en1990] for the stud in the middle of the tests: "
        f"d = {number(1e3 * reference['diameter'], 3)} mm, "
        f"h = {number(1e3 * reference['height'], 3)} mm, "
        f"f_cm = {number(reference['concrete_strength'] / 1e6, 3)} MPa, "
        f"f_u = {number((reference['ultimate_strength'] or 0.0) / 1e6, 3)} MPa. The coefficients "
        "of variation of structures to come are assumptions: diameter 1 %, concrete strength 15 %, "
        "its modulus 10 %, stud strength 5 %. γ_M* is the nominal value of the code, without "
        "partial factor, over the design value found here; EN 1994-1-1 has 1.25."
    )
