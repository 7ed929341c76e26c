"""Studs in a study: what no test validates, what unseen tests say, numbers for designers."""

from collections.abc import Iterator
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from workbench.report.chapters.studs import page, records
from workbench.report.page.formatting import number
from workbench.report.page.markdown import Markdown, section
from workbench.responses import Finding
from workbench.scenarios import StudTests
from workbench.studs.fit_protocol import Tables, stacked
from workbench.study.assessor import Assessment
from workbench.study.definition import Study

_NEAR = 1e-3  # m, in diameter: such a stud
_CONFIDENCE = 0.9
MEASURES = {  # of damage, what its level is over what
    "displacement ratio": "uplift reached before, over that at which an undamaged stud fails",
    "load ratio": "tension before, over the pull-out resistance of an undamaged stud",
}


class StoredStudAnswer(NamedTuple):
    """A stored answer on studs: its case and label, what was asked, its tables and findings."""

    case: str
    label: str
    asked: str
    tables: Tables
    findings: list[Finding]

    @property
    def fit(self) -> dict[str, Any]:
        """The summary of the answer, empty where there is none."""
        return records(self.tables["fit"])[0] if "fit" in self.tables else {}


def answers(study: Study, stored: Assessment) -> Iterator[StoredStudAnswer]:
    """Every stored answer to a question on studs."""
    for case in study.cases:
        if not isinstance(case.scenario, StudTests):
            continue
        for label in study.models:
            if tables := stored.answer_tables(case.name, label):
                findings = list(stored.cells[case.name, label].findings)
                yield StoredStudAnswer(case.name, label, case.scenario.asked, tables, findings)


def in_short(study: Study, stored: Assessment) -> Markdown:
    """Summary of studs: what is not validated, then a sentence on each question; may be empty.

    A usual stud by the code, the formula to take, unseen tests, what is left after damage, laws.
    """
    return _answer("in_short", study, stored)


def _answer(part: str, study: Study, stored: Assessment) -> Markdown:
    """The answers in short, or `part` in_full: on what they rest and what no test tells."""
    every = list(answers(study, stored))
    if not every:
        return Markdown()
    tables = stacked(
        (each.label, {key: table.assign(case=each.case) for key, table in each.tables.items()})
        for each in every
    )
    formulas = [each for each in every if "d8" in each.tables]
    most = max((each.fit["tests"] for each in formulas), default=0)
    widest = [each for each in formulas if each.fit["tests"] == most]  # fitted to most tests
    usual = [e.tables["usual"].assign(model=e.fit["model"]) for e in widest if "usual" in e.tables]
    tables["usual"] = pd.concat(usual) if usual else pd.DataFrame()
    shank = [f.text for f in widest[0].findings if f.subject == "shank"] if widest else []
    residual = [e for e in every if "left" in e.tables.get("curve", ())]
    ungraded: dict[str, dict[str, None]] = {}
    for each in residual:
        if "judgement" not in each.tables:
            ungraded.setdefault(each.fit["grade"], {})[each.fit["quantity"]] = None
    combined = [e for e in every if e.asked == "interaction"]  # no table holds such a test?
    tested = any("tests" in e.tables or "validation" in e.tables for e in combined)
    return page(
        part,
        tables,
        confidence=_CONFIDENCE,
        widest=[_formula(each) for each in widest],
        shank_findings=shank,
        ungraded={grade: list(quantities) for grade, quantities in ungraded.items()},
        uncombined=bool(combined) and not tested,
        gated=list(dict.fromkeys(gate.model for gate in study.gates)),
        predictions=_predictions([e for e in residual if not e.fit["tests"]]),
        same_predictions=list(_same(every)),
    )


def _formula(each: StoredStudAnswer) -> dict[str, Any]:
    """A formula as fitted to most tests: its summary, and what its tests say of it as it is."""
    tests, near = each.tables["tests"], 0
    if "usual" in each.tables:
        usual = each.tables["usual"]["diameter"].iloc[0]
        near = int((tests["diameter"] - usual).abs().le(_NEAR).sum())
    return {
        **each.fit,
        "of": each.label,
        "least": float(tests["ratio"].min()),
        "near": near,
        "above_shank": int((tests["over_steel"] > 1.0).sum()),
        "gamma_m_star": records(each.tables["d8"])[0]["gamma_m_star"],
    }


def _predictions(
    every: list[StoredStudAnswer],
) -> dict[tuple[str, str, str], list[tuple[str, list[str]]]]:
    """Predicted rest of a stud after damage, by damage, its measure and the stud."""
    shares: dict[tuple[str, str, str], list[tuple[str, list[str]]]] = {}
    for each in every:
        curve, texts = each.tables["curve"], []
        for level in (0.5, 1.0):
            at = curve.iloc[int((curve["level"] - level).abs().argmin())]
            ends = (number(at[name], 2) for name in ("low", "high"))
            text = f"{number(at['left'], 2)} ({' to '.join(ends)})"
            texts.append(f"{text} at level {number(at['level'], 2)}")
        measure = MEASURES.get(each.fit["measure"], each.fit["measure"])
        key = each.fit["predamage"], measure, each.fit["stud"]
        shares.setdefault(key, []).append((each.fit["quantity"], texts))
    return shares


def _same(every: list[StoredStudAnswer]) -> Iterator[tuple[str, str]]:
    """Models whose predictions of unseen tests are those of a formula as it is, and the formula."""
    judged = [each for each in every if each.asked == "strength" and "judged" in each.tables]
    for each, other in product(judged, judged):
        if "d8" in other.tables and "d8" not in each.tables and each.case == other.case:
            one, two = (e.tables["judged"]["prediction"].to_numpy() for e in (each, other))
            if len(one) == len(two) and np.allclose(one, two, rtol=1e-6, atol=0.0):
                yield each.label, other.label


def design(study: Study, stored: Assessment) -> Markdown:
    """Tables of D.8, Annex B, campaigns left out, load-slip parameters and what is left."""
    every = list(answers(study, stored))
    formulas = _largest([each for each in every if "d8" in each.tables], "tests")
    several = [each for each in formulas if ", " in each.fit["campaigns"]] or formulas
    laws = _largest([e for e in every if "factor" in e.tables.get("parameters", ())], "curves")
    residual = [each for each in every if "left" in each.tables.get("curve", ())]
    series = [each for each in every if "series" in each.tables][:1]
    named = [
        *((f"{e.label}\n({e.case}, {e.fit['tests']} tests)", e.tables) for e in several),
        *((f"{e.label} ({e.case}, {e.fit['curves']} curves)", e.tables) for e in laws),
        *((f"{e.case}, {e.label}", e.tables) for e in residual),
        *((e.label, e.tables) for e in series),
    ]
    blocks = [_answer("in_full", study, stored)]
    blocks += [page("design", stacked(named))] if named else []
    return section("design", "Design numbers", *blocks)


def _largest(every: list[StoredStudAnswer], size: str) -> list[StoredStudAnswer]:
    """The answer of every label, where its fit has most tests or curves."""
    best: dict[str, StoredStudAnswer] = {}
    for each in every:
        if each.label not in best or each.fit[size] > best[each.label].fit[size]:
            best[each.label] = each
    return list(best.values())
