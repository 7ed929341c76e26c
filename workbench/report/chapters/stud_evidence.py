"""A study of studs in short: what no test validates, and what unseen tests say of the rest."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from workbench.content.formatting import count, number, percent
from workbench.content.tree import Block, Bullets, Callout, Section
from workbench.report.stored import Stored
from workbench.scenarios import StudTests
from workbench.studs.answers.common import content_of
from workbench.study.definition import Study

Answered = tuple[str, str, str, dict[str, Any]]  # case, label, what is asked, content


def answers(study: Study, stored: Stored) -> Iterator[Answered]:
    """Every stored answer to a question on studs: case, label, what was asked, its content."""
    for case in study.cases:
        if not isinstance(case.scenario, StudTests):
            continue
        for label in study.models:
            response = stored.response(case.name, label)
            content = {} if response is None else content_of(response)
            if content:
                yield case.name, label, case.scenario.asked, content


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
    items = [*_judged(study, found), *_design(found)]
    if items:
        blocks.append(Bullets(tuple(items)))
    return Section("short", "In short", tuple(blocks))


def _residual(found: list[Answered]) -> Iterator[str]:
    grades: dict[str, list[str]] = {}
    for _, _, _, content in found:
        if "curve" in content and not content["judgement"]:
            fit = content["fit"]
            quantities = grades.setdefault(fit["grade"], [])
            if fit["quantity"] not in quantities:
                quantities.append(fit["quantity"])
    for grade, quantities in grades.items():
        yield f"{' and '.join(quantities)} left after damage ({grade})"


def _combined(found: list[Answered]) -> Iterator[str]:
    asked = [content for _, _, asked, content in found if asked == "interaction"]
    if asked and not any(content.get("tests") for content in asked):
        yield "tension and shear together (no combined test is in the tables)"


def _strength(found: list[Answered]) -> Iterator[Block]:
    fits = [c["fit"] for _, _, asked, c in found if asked == "strength" and "tests" in c]
    formulas = [fit for fit in fits if "d8" in fit]
    if not formulas:
        return
    widest = max(formulas, key=lambda fit: len(fit["campaigns"]))
    texts = []
    if widest["new_campaign_factor"] is None:
        texts.append(
            f"Strength rests on {count(widest['tests'], 'test')} of "
            f"{count(len(widest['campaigns']), 'campaign')}: they do not tell how much campaigns "
            "differ, so there is no value for a new one, and EN 1990 D.8, which takes all tests as "
            "independent, errs on the unsafe side."
        )
    shank = [text for text in widest["warnings"] if "tensile strength of their shank" in text]
    texts += [f"{text[0].upper()}{text[1:]}." for text in shank]
    if texts:
        yield Callout("doubt", " ".join(texts))


def _judged(study: Study, found: list[Answered]) -> Iterator[str]:
    """One sentence for every label that a gate judges by unseen tests."""
    for label in dict.fromkeys(gate.model for gate in study.gates):
        parts = []
        for _, own, asked, content in found:
            judgement = content.get("judgement")
            if own == label and judgement:
                curves = asked == "load-slip"
                parts.append(_curves(judgement) if curves else _tests(judgement))
        if parts:
            yield f"{label}: {'; '.join(parts)}."


def _tests(judgement: dict[str, Any]) -> str:
    ratio = number(judgement["test_over_prediction"], 3)
    interval = judgement["interval"]
    span = ""
    if interval and None not in (interval["low"], interval["high"]):
        span = f" ({number(interval['low'], 3)} to {number(interval['high'], 3)})"
    least = judgement["least_test_over_prediction"]
    tests = f"{count(judgement['tests'], 'unseen test')} of {', '.join(judgement['campaigns'])}"
    text = f"{tests} bore {ratio}{span} of the prediction in the median"
    if least < 1.0:
        text += f", {judgement['worst']} only {number(least, 2)}"
    return text


def _curves(judgement: dict[str, Any]) -> str:
    text = f"on {count(judgement['curves'], 'unseen curve')}"
    if judgement["coverage"] is not None:
        text += f" its 90 % band holds {percent(judgement['coverage'], signed=False)} of the points"
    if judgement["stiffness"]:
        ratio = number(judgement["stiffness"]["test_over_prediction"], 3)
        text += f", stiffness is {ratio} times the predicted one"
    return text


def _design(found: list[Answered]) -> Iterator[str]:
    """The partial factors that EN 1990 D.8 gives over most tests."""
    factors: dict[str, tuple[int, float]] = {}
    for _, label, asked, content in found:
        fit = content.get("fit") or {}
        star = fit.get("d8", {}).get("gamma_m_star") if asked == "strength" else None
        if star is not None and fit["tests"] > factors.get(label, (0, 0.0))[0]:
            factors[label] = fit["tests"], star
    most = max((tests for tests, _ in factors.values()), default=0)
    shown = [f"{number(f, 3)} ({label})" for label, (tests, f) in factors.items() if tests == most]
    if shown:
        yield (
            f"EN 1990 D.8 over {most} tests asks for a partial factor gamma_M* of "
            f"{', '.join(shown)}; EN 1994-1-1 has 1.25. It shows the procedure, it is no design "
            "value for a project."
        )
