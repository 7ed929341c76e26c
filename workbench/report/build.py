"""Building the report of a stored study."""

from collections.abc import Sequence
from pathlib import Path

from workbench.content.formatting import count
from workbench.content.html import render_html
from workbench.content.tree import Document, Picture, Section
from workbench.content.typst import render_pdf
from workbench.errors import InputError
from workbench.fields import Choice
from workbench.report.chapters import (
    configuration,
    cost,
    limits,
    reference,
    results,
    stud_evidence,
    verdicts,
)
from workbench.report.gallery import draw_all, save_all
from workbench.report.stored import Stored
from workbench.study.definition import Study
from workbench.study.files import write_atomically

_FORMAT = Choice(("html", "pdf"))
# figures of these kinds stand in chapters of their own
_ELSEWHERE = ("convergence", "cost")


def build_report(
    directory: Path, study: Study, formats: Sequence[str] = ("html", "pdf"), out: Path | None = None
) -> dict[str, Path]:
    """Write the report of a stored and assessed study; nothing is simulated or assessed.

    Arguments: `directory`, the store of the study; `study`, in the form that was run; `formats`,
    any of html and pdf; `out`, where to write (default: ``report`` in the store). Returns the
    path of each format, and of the ``figures`` with their numbers. Equal stores give equal bytes.
    Raises `InputError` for an unknown format, a study without results, a figure of unknown kind
    or a directory that cannot be written.
    """
    for name in formats:
        _FORMAT.check("--format", name)
    target = Path(directory) / "report" if out is None else Path(out)
    stored = Stored(Path(directory), study)
    plates = draw_all(study, stored)
    pictures = {plate.figure.key: plate.picture() for plate in plates}
    kinds = {plate.figure.key: plate.figure.kind for plate in plates}
    content = document(study, stored, [(kinds[key], pictures[key]) for key in kinds])
    written = {}
    try:
        target.mkdir(parents=True, exist_ok=True)
        save_all(plates, target / "figures", pictures)
        written["figures"] = target / "figures"
        if "html" in formats:
            written["html"] = target / "report.html"
            write_atomically(written["html"], render_html(content).encode())
        if "pdf" in formats:
            written["pdf"] = target / "report.pdf"
            write_atomically(written["pdf"], render_pdf(content))
    except OSError as error:
        reason = error.strerror or "unknown reason"
        raise InputError("--out", str(target), f"cannot be written: {reason}") from error
    return written


def document(study: Study, stored: Stored, drawn: Sequence[tuple[str, Picture]]) -> Document:
    """The content tree of a study, from stored results and drawn figures with their kinds."""
    own = {kind: [picture for of, picture in drawn if of == kind] for kind in _ELSEWHERE}
    shear = limits.shear_demand(study, stored)
    parts: list[Section | None] = [
        verdicts.asked(study, stored),
        stud_evidence.in_short(study, stored),
        verdicts.verdicts(stored, shear.headline),
        limits.missing(study, stored),
        limits.domain(stored, shear),
        limits.notes(study),
        results.pictures([picture for of, picture in drawn if of not in own]),
        stud_evidence.design(study, stored),
        results.numbers(study, stored),
        reference.convergence(study, stored, own["convergence"]),
        cost.cost(study, stored, own["cost"]),
        configuration.configuration(study, stored),
    ]
    sections = tuple(part for part in parts if part is not None)
    facts = (
        f"{count(len(study.cases), 'case')}, {count(len(study.models), 'model')}",
        f"reference: {study.reference}",
        f"study: {study.name}",
    )
    return Document(study.title, "Validation report", facts, sections)
