"""Names that readers of tables take for missing, and names that look like formulas, are names."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from synthetic_study import small_study, store_of

from workbench.base.errors import InputError
from workbench.report.build import build_report
from workbench.report.chapters.answer import in_brief, in_labels
from workbench.report.page.terminal import render_text
from workbench.responses import Finding
from workbench.study import Study
from workbench.study.assessor import Assessment

NAMES = ("NA", "null", "None", "nan", "N/A", r"$\x{$", r"a\b")


def renamed(study: Study) -> Study:
    """A study whose labels and cases have the names of `NAMES`, in their order."""
    labels = dict(zip(study.models, NAMES, strict=True))
    cases = zip(study.cases, NAMES, strict=False)
    gates = (replace(g, model=labels[g.model], against=labels[g.against]) for g in study.gates)
    return replace(
        study,
        cases=tuple(replace(case, name=name) for case, name in cases),
        models={labels[label]: model for label, model in study.models.items()},
        reference=labels[study.reference],
        ladder=tuple(labels[label] for label in study.ladder),
        gates=tuple(gates),
    )


@pytest.mark.thorough
def test_names_that_look_missing_or_like_formulas_are_read_back(
    small: Assessment, tmp_path: Path
) -> None:
    stored = store_of(renamed(small_study()), tmp_path)
    outcomes = [cell.outcome for cell in small.cells.values()]
    assert [cell.outcome for cell in stored.cells.values()] == outcomes
    assert outcomes.count("ok") > 20
    assert {row["model"] for row in stored.records("comparisons")} == {*NAMES} - {
        stored.study.reference
    }
    first = render_text(in_brief(stored.study, stored))
    assert all(f"\n{name} " in first for name in NAMES)
    files = build_report(stored, formats=("html",))
    page = files["html"].read_text("utf-8")
    assert all(f">{name}<" in page for name in NAMES)


def test_models_of_a_sentence_get_their_labels_once() -> None:
    study = small_study()
    models = dict(zip((r"\1 $", "synthetic"), study.models.values(), strict=False))
    study = replace(study, models=models, reference=r"\1 $", ladder=(), gates=())
    finding = in_labels(study, Finding("any", "a text", instead=("synthetic",)))
    assert finding.remedy == r"take synthetic (\1 $)"


@pytest.mark.parametrize("name", ["a\nb", "\x00", "\x1b[31m", " ", "\ud800"])
def test_names_of_more_than_one_line_are_refused(name: str) -> None:
    study = small_study()
    with pytest.raises(InputError, match=r"case\.name.*one line"):
        replace(study, cases=(replace(study.cases[0], name=name),))
