"""Studs: what no test validates, what unseen tests say of the rest, numbers for designers."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from workbench.content.formatting import count, number
from workbench.content.tree import Block, Bullets, Callout, Section
from workbench.report.chapters import stud_design
from workbench.report.chapters import stud_tables as tables
from workbench.report.stored import Stored
from workbench.responses import Finding, findings_of
from workbench.scenarios import StudTests
from workbench.studs.answers.common import content_of
from workbench.study.definition import Study

_FEW = 10  # curves that hardly tell laws apart
_NEAR = 1e-3  # m, in diameter: such a stud
MEASURES = {  # of damage, what its level is over what
    "displacement ratio": "uplift reached before, over that at which an undamaged stud fails",
    "load ratio": "tension before, over the pull-out resistance of an undamaged stud",
}


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
            if response is not None and (content := content_of(response)):
                told = case.scenario.asked, content, findings_of(response)
                yield Answered(case.name, label, *told)


def in_short(study: Study, stored: Stored) -> tuple[Block, ...]:
    """What is not validated, then one answer to each question; nothing for a study without studs.

    A usual stud by the codes, what unseen tests say, what is left after damage, load-slip laws and
    what no test tells.
    """
    found = list(answers(study, stored))
    if not found:
        return ()
    blocks: list[Block] = []
    missing = [*_residual(found), *_combined(found)]
    if missing:
        text = f"Not validated: {'; '.join(missing)}. Do not design with these numbers."
        blocks.append(Callout("bad", text))
    blocks.extend(_strength(found))
    items = (
        *_usual(found),
        *_judged(study, [each for each in found if not _on_curves(each)]),
        *_left(found),
        *_laws(found),
        *_unknown(found),
        *_same(found),
        *_factors(found),
        *_judged(study, [each for each in found if _on_curves(each)]),
    )
    return (*blocks, *([Bullets(items)] if items else []))


def _usual(found: list[Answered]) -> Iterator[str]:
    """A usual stud by the codes, and which formula no test falls below."""
    formulas = [each for each in _widest(found) if each.content.get("usual")]
    named = {each.fit["model"]: each for each in formulas}
    if "en1994" not in named:
        return
    own = named["en1994"].content["usual"]
    steel, concrete, other = (own[f"{n}_term"] for n in ("steel", "concrete", "other_concrete"))
    value, gamma = own["resistance"], own["partial_factor"]
    text = (
        f"Stud {number(1e3 * own['diameter'], 2)} x {number(1e3 * own['height'], 3)} mm, f_ck "
        f"{number(own['concrete_strength'] / 1e6, 2)} MPa, specified f_u "
        f"{number(own['ultimate_strength'] / 1e6, 3)} MPa, by EN 1994-1-1: characteristic "
        f"{_kilo(value)}, design {_kilo(value / gamma)} with γ_V = {number(gamma, 3)}; "
        f"{_governs(own)} ({_kilo(steel)} steel, {_kilo(concrete)} concrete)"
    )
    for name, word in (("roik-mean", "mean form"), ("aisc360", "AISC 360-22, nominal")):
        if name in named:
            each = named[name].content["usual"]
            text += f"; {word} {_kilo(each['resistance'])}, {_governs(each)}"
    text += ". E_cm of the EN forms is that of EN 1992-1-1, the mean form takes f_cm = f_ck + 8 MPa"
    if other < min(steel, concrete):
        text += (
            "; with 4733 √f_cm, as the fits take it where none was measured, concrete governs: "
            f"{_kilo(other)} and {_kilo(other / gamma)}"
        )
    yield f"{text}. These are values of the codes, not of the tests."
    least = {e.label: min(row["ratio"] for row in e.content["tests"]) for e in _widest(found)}
    shown = ", ".join(f"{number(value, 3)} ({label})" for label, value in least.items())
    tests = named["en1994"].fit["tests"]
    safe = [label for label, value in least.items() if value >= 1.0]
    text = f"Least of {count(tests, 'test')} over each formula as it is: {shown}. "
    text += f"To take, as every test exceeds it: {', '.join(safe) or 'none of them'}."
    size = own["diameter"]
    near = sum(abs(row["diameter"] - size) <= _NEAR for row in named["en1994"].content["tests"])
    yield f"{text} Of these tests {near} had a stud of that diameter, within 1 mm."


def _kilo(load: float) -> str:
    return f"{number(1e-3 * load, 3)} kN"


def _governs(usual: dict[str, Any]) -> str:
    term = "steel" if usual["steel_term"] <= usual["concrete_term"] else "concrete"
    return f"{term} governs"


def _widest(found: list[Answered]) -> list[Answered]:
    """The formulas as fitted to most tests."""
    formulas = [each for each in found if "d8" in each.fit]
    most = max((each.fit["tests"] for each in formulas), default=0)
    return [each for each in formulas if each.fit["tests"] == most]


def _same(found: list[Answered]) -> Iterator[str]:
    """Models whose predictions of unseen tests are those of a formula as it is."""
    judged = [e for e in found if e.asked == "strength" and e.content.get("judgement")]
    for each in judged:
        if "d8" in each.fit:
            continue
        own = [row["prediction"] for row in each.content["judged"]]
        for other in (e for e in judged if "d8" in e.fit and e.case == each.case):
            theirs = [row["prediction"] for row in other.content["judged"]]
            if len(own) == len(theirs) and np.allclose(own, theirs, rtol=1e-6, atol=0.0):
                yield (
                    f"{each.label}: no result of its own for strength. In these tests the limit "
                    f"of the {other.label} (concrete, shank) governs: its predictions are the same."
                )


def _left(found: list[Answered]) -> Iterator[str]:
    """What a computation leaves of a stud after damage, where no test tells."""
    own = [each for each in found if "curve" in each.content and not each.fit["tests"]]
    kinds: dict[tuple[str, str, str], list[str]] = {}
    for each in own:
        key = each.fit["predamage"], each.fit["measure"], each.fit["stud"]
        shares = f"{each.fit['quantity']} {_shares(each.content['curve'])}"
        kinds.setdefault(key, []).append(shares)
    for (kind, measure, stud), texts in kinds.items():
        yield (
            f"Left after damage by {kind} (stud {stud}; level: {MEASURES.get(measure, measure)}), "
            f"as a share of the undamaged: {'; '.join(texts)}. Computed, no test: do not design. "
            "The ranges run over assumed parameters and are no confidence intervals."
        )


def _shares(curve: dict[str, Any]) -> str:
    texts = []
    for level in (0.5, 1.0):
        at = min(range(len(curve["level"])), key=lambda i: abs(curve["level"][i] - level))
        text = number(curve["left"][at], 2)
        if curve["low"] is not None:
            text += f" ({number(curve['low'][at], 2)} to {number(curve['high'][at], 2)})"
        texts.append(f"{text} at level {number(curve['level'][at], 2)}")
    return ", ".join(texts)


def _laws(found: list[Answered]) -> Iterator[str]:
    """The load-slip laws by their misfit on unseen curves."""
    own = {e.label: e.content["judgement"] for e in found if _on_curves(e)}
    if len(own) > 1:
        order = sorted(own, key=lambda label: own[label]["median_rms"])
        first, *others = (f"{x} ({number(own[x]['median_rms'], 2)})" for x in order)
        curves = own[order[0]]["curves"]
        yield (
            f"Smallest misfit on {count(curves, 'unseen curve')}, root mean square of the load "
            f"over the largest load: {first}; then {', '.join(others)}."
            + (" So few curves hardly tell close ones apart." if curves < _FEW else "")
        )


def _on_curves(each: Answered) -> bool:
    return "curves" in (each.content.get("judgement") or {}) and each.asked == "load-slip"


def _unknown(found: list[Answered]) -> Iterator[str]:
    """What no test at hand tells."""
    for each in _widest(found)[:1]:
        yield f"Not known, as no test tells: strength other than {each.fit['holds']}; " + (
            "studs in profiled decks, under tension and shear together, or after damage, unless a "
            "table of your own holds such tests."
        )


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
        own = (e.content for e in found if e.label == label and e.content.get("judgement"))
        parts = [stud_design.judged(each["judgement"], each["judged"]) for each in own]
        if parts:
            yield f"{label}: {'; '.join(parts)}."


def _factors(found: list[Answered]) -> Iterator[str]:
    """The partial factors that EN 1990 D.8 gives over most tests."""
    known = [each for each in found if each.fit.get("d8", {}).get("gamma_m_star") is not None]
    most = max((each.fit["tests"] for each in known), default=0)
    factors = {e.label: e.fit["d8"]["gamma_m_star"] for e in known if e.fit["tests"] == most}
    if factors:
        shown = ", ".join(f"{number(star, 3)} ({label})" for label, star in factors.items())
        yield (
            f"EN 1990 D.8 over {most} tests gives a partial factor γ_M* of {shown}; EN 1994-1-1 "
            "has 1.25. That is no reason to go below 1.25: D.8 takes tests as independent that "
            f"are not{_shank(found)}. It shows the procedure, it is no design value for a project."
        )


def _shank(found: list[Answered]) -> str:
    """How many tests bore more than their shank can, as a reason not to trust them."""
    for each in _widest(found)[:1]:
        above = sum((row["over_steel"] or 0.0) > 1.0 for row in each.content["tests"])
        if above:
            return f", and {above} of them exceed the strength of their shank"
    return ""


def design(study: Study, stored: Stored) -> Section | None:
    """Tables of D.8, Annex B, campaigns left out, load-slip parameters and what is left."""
    blocks = tuple(_blocks(list(answers(study, stored))))
    return Section("design", "Design numbers", blocks) if blocks else None


def _blocks(found: list[Answered]) -> Iterator[Block]:
    formulas = _largest([each for each in found if "d8" in each.fit], "tests")
    several = [each for each in formulas if len(each.fit["campaigns"]) > 1] or formulas
    if several:
        yield stud_design.reference_stud(several[0].fit["reference"])
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
