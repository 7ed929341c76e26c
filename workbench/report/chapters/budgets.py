"""What all errors together may make of an answer: a sentence on the first page, tables behind."""

from collections.abc import Iterator, Mapping
from typing import Any

from workbench.assessment.budget import PEAK
from workbench.content.budgets import budget_sentence, budget_table
from workbench.content.tree import Block, Paragraph, Section
from workbench.report.stored import Stored

Row = dict[str, Any]
_WHAT = (
    "Half-widths of what scatters add as squares about the measured bias; the strain rate pulls "
    "one way only and adds in full. The best reference is where a reference would answer, given "
    "the same input; the total has all terms that are known. Without the "
    "model form there is neither."
)


def budgets(stored: Stored, taken: Mapping[str, str]) -> Iterator[Block]:
    """A sentence on the peak of the first answer with a budget by the model `taken` in its case."""
    for (case, label, quantity), rows in _groups(stored).items():
        if quantity == PEAK and taken.get(case) == label:
            sentence = budget_sentence(rows[0]["value"], quantity, rows)
            yield Paragraph(f"With all errors, {case}, {label}: {sentence}.")
            return


def budget_tables(stored: Stored) -> Section | None:
    """Every term with its reason; None without a budget."""
    tables = [
        Section(
            f"terms-{number}",
            f"{case}, {label}",
            (budget_table(f"budget-terms-{number}", quantity, rows[0]["value"], rows),),
        )
        for number, ((case, label, quantity), rows) in enumerate(_groups(stored).items(), 1)
    ]
    if not tables:
        return None
    return Section("budgets", "Error budgets", (Paragraph(_WHAT), *tables))


def _groups(stored: Stored) -> dict[tuple[str, str, str], list[Row]]:
    """Rows of the table by case, label and quantity."""
    found: dict[tuple[str, str, str], list[Row]] = {}
    for row in stored.rows["budget"]:
        found.setdefault((row["case"], row["label"], row["quantity"]), []).append(row)
    return found
