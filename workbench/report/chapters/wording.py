"""What a row of the matrix says in words: how cases ended, and how far a model is off."""

from collections.abc import Iterator
from math import ceil
from typing import Any

from workbench.assessment.budget import PEAK

FAIR = 0.10  # bound of what may do
Row = dict[str, Any]


def ends(row: Row) -> Iterator[str]:
    """How the cases without a number ended, and where the reference ended otherwise."""
    for name in ("collapsed", "refused", "failed", "not_run"):
        if row[name]:
            yield f"{row[name]} {name.replace('_', ' ')}"
    yield from _collapses(row)


def _collapses(row: Row) -> Iterator[str]:
    """Where the model and the reference do not agree on whether the structure survives."""
    if row["falls"]:
        yield f"{row['falls']} collapsed where the reference survives"
    if row["stands"]:
        yield f"survives {row['stands']} in which the reference collapses"


def sentence(rows: dict[str, Row]) -> str:
    """What the numbers of a model say, group by group; groups that say the same stand together."""
    said: dict[str, list[str]] = {}
    for group, row in rows.items():
        lost = row["refused"] + row["failed"]
        none = [f"no answer in {lost} of {row['asked']}"] if lost else []
        words = ", ".join([_number(row), *_collapses(row), *none])
        said.setdefault(words, []).append(group)
    if len(said) == 1:
        words = next(iter(said))
        return words[0].upper() + words[1:]
    return "; ".join(f"{' and '.join(groups)}: {words}" for words, groups in said.items())


def _number(row: Row) -> str:
    """What the peaks of a model say."""
    if not row[f"{PEAK}_count"]:
        if row["reference"]:
            return "the reference"
        return "no number to compare"
    bias, low, high, worst, within = (
        row[f"{PEAK}_{name}"] for name in ("bias", "low", "high", "worst", "within")
    )
    if within is None:
        text = f"off by up to {rounded(worst)}, with unknown uncertainty"
    elif within <= FAIR:
        text = f"within {up(within)}"
    elif low is not None and (high < 1.0 or low > 1.0):
        text = f"{rounded(bias - 1.0)} {'low' if high < 1.0 else 'high'}"
        if row[f"{PEAK}_count"] > 1:
            text += f", up to {rounded(worst)}"
    else:
        text = f"within {up(within)} only"
    if row["against_outside"] == row[f"{PEAK}_count"]:
        text += " of a reference outside its own domain"
    if row["synthetic"]:
        text += " of SYNTHETIC rows"
    return text


def up(value: float) -> str:
    """A share in whole percents, rounded up."""
    return f"{ceil(100.0 * value - 1e-9)}\u2009%"


def rounded(value: float) -> str:
    """A deviation in whole percents, without its sign."""
    return f"{abs(100.0 * value):.0f}\u2009%"
