"""The content tree of a study: which part comes where."""

from __future__ import annotations

from workbench.content.bibliography import bibliography
from workbench.content.formatting import count
from workbench.content.tree import Document, Picture, Section
from workbench.report.chapters import (
    configuration,
    cost,
    limits,
    reference,
    results,
    stud_design,
    stud_evidence,
    verdicts,
)
from workbench.report.stored import Stored
from workbench.study.definition import Figure, Study

# figures of these kinds stand in chapters of their own
_ELSEWHERE = ("convergence", "cost")


def document(
    study: Study, stored: Stored, figures: tuple[Figure, ...], drawn: dict[str, Picture]
) -> Document:
    """Build the content tree from stored results and drawn figures."""
    own = {
        kind: [drawn[figure.key] for figure in figures if figure.kind == kind]
        for kind in _ELSEWHERE
    }
    shear = limits.shear_demand(study, stored)
    keys = [figure.key for figure in figures if figure.kind not in _ELSEWHERE]
    parts: list[Section | None] = [
        verdicts.asked(study, stored),
        stud_evidence.in_short(study, stored),
        verdicts.verdicts(stored, shear.headline),
        limits.missing(study, stored),
        limits.domain(stored, shear),
        limits.notes(study),
        results.pictures(drawn, keys),
        stud_design.design(study, stored),
        results.numbers(study, stored),
        reference.convergence(study, stored, [*own["convergence"]]),
        cost.cost(study, stored, [*own["cost"]]),
        configuration.configuration(study, stored),
    ]
    sections = tuple(part for part in parts if part is not None)
    facts = (
        f"{count(len(study.cases), 'case')}, {count(len(study.models), 'model')}",
        f"reference: {study.reference}",
        f"study: {study.name}",
    )
    return Document(study.title, "Validation report", facts, sections)


def unknown_sources(study: Study) -> list[str]:
    """Keys that models cite and the bibliography does not have."""
    keys = dict.fromkeys(key for model in study.models.values() for key in model.sources)
    return [key for key in keys if key not in bibliography()]
