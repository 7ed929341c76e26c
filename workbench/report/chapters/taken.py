"""Which model to take in a group of cases, or which is nearest, in one sentence."""

from math import ceil

from workbench.assessment.budget import PEAK, RESIDUAL
from workbench.content.formatting import part, several, title_of
from workbench.report.chapters import ranking
from workbench.report.chapters.subject import measured_at
from workbench.report.chapters.wording import FAIR, Row, rounded, up
from workbench.report.stored import Stored
from workbench.study.definition import Study

_OPEN = 0.05  # numerical uncertainty of a reference that is told beside what cannot be judged


def judged(row: Row) -> str:
    """What the numbers of a row are of, in words."""
    return "peak" if row["quantity"] == PEAK else title_of(row["quantity"]).lower()


def first(study: Study, stored: Stored, group: str) -> str:
    """The model to take in a group of cases; empty without one."""
    own = _ranked(study, stored, group)
    return next((label for label, row in own.items() if _sure(row)), "")


def trusted(study: Study, stored: Stored, group: str) -> str:
    """The model to take, and all that stay within `FAIR` in every case; else the nearest."""
    rows = [row for row in stored.rows["matrix"] if row["group"] == group]
    own = _ranked(study, stored, group)
    compared = [row for row in rows if row[f"{PEAK}_count"]]
    if any(row["synthetic"] for row in rows):
        return f"{group}: synthetic, shows the form only; no model is judged."
    if not compared:
        blind = [row["label"] for row in rows if row["stands"]]
        apart = f"; {several(blind, 8)} miss it" if blind else ", and so do all that answer"
        fallen = any(row["collapsed"] for row in rows if row["label"] in study.ranked)
        return f"{group}: {f'the reference collapses{apart}' if fallen else 'nothing to compare'}."
    if all(row["against_outside"] == row[f"{PEAK}_count"] for row in compared):
        text = "nobody knows, as no reference is inside its domain"
        return f"{group}: {text}{_nearest(own, 'against the best there is, ')}."
    sure = [label for label, row in own.items() if _sure(row)]
    if not sure:
        text = f"no model is surely within {up(FAIR)} in every case, inside its domain"
        open_by = max((row["known"] or 0.0 for row in rows), default=0.0)
        part_of = f"; the reference itself is open by {up(open_by)}" if open_by > _OPEN else ""
        return f"{group}: {ranking.advice(stored, group) or f'{text}{_nearest(own)}{part_of}.'}"
    label, *others = sure
    row, costs = own[label], stored.costs
    remains = row[f"{RESIDUAL}_within"]
    cases = "the case" if row["asked"] == 1 else f"all {row['asked']} cases"
    left = "" if remains is None else f", residual within {up(remains)}"
    spent = f", {part(costs[label])} of the time" if label in costs else ""
    of, what = row["against"] or "the reference", judged(row)
    within = {each: up(own[each][f"{PEAK}_within"]) for each in sure}
    text = f"{group}: {label}, {what} within {within[label]} of {of}{left} in {cases}{spent}"
    if others:
        names = several([f"{each} ({within[each]})" for each in others], 8)
        text += f". {what.capitalize()} within {up(FAIR)} as well, inside their domain: {names}"
    return f"{text}.{measured_at(study, group)}"


def _ranked(study: Study, stored: Stored, group: str) -> dict[str, Row]:
    """Models that answered all cases and no collapse wrongly, the one to take first.

    Inside their domain before others; by whole percents, then by what remains and by the time.
    """
    costs = stored.costs
    found = {
        row["label"]: row
        for row in stored.rows["matrix"]
        if row["group"] == group
        and row["label"] not in study.ranked
        and row[f"{PEAK}_count"]
        and row[f"{PEAK}_count"] + row["collapsed"] == row["asked"]
        and not any(row[name] for name in ("falls", "stands", "synthetic"))
    }

    def place(pair: tuple[str, Row]) -> tuple[float, ...]:
        label, row = pair
        within, remains = row[f"{PEAK}_within"], row[f"{RESIDUAL}_within"] or 0.0
        error = abs(row[f"{PEAK}_worst"]) if within is None else within
        shares = ceil(100.0 * error), ceil(100.0 * remains)
        return bool(row["outside"]), *shares, costs.get(label, 1.0)

    return dict(sorted(found.items(), key=place))


def _sure(row: Row) -> bool:
    """Whether a model is within `FAIR` with what is open, it and the reference in their domains."""
    within = row[f"{PEAK}_within"]
    return (within or 0.0) <= FAIR and not (
        within is None or row["outside"] or row["against_outside"]
    )


def _nearest(own: dict[str, Row], to: str = "") -> str:
    """The first of the ranked models and its largest error; the end of a sentence."""
    for label, row in own.items():
        text = (
            f"; {to}nearest is {label}, {judged(row)} off by up to {rounded(row[f'{PEAK}_worst'])}"
        )
        for of, name in (("", "outside"), ("the reference ", "against_outside")):
            if row[name] and not (to and of):
                text += f", {of}outside its domain in {row[name]} of {row['asked']}"
        return text + (", numerical error not known" if row[f"{PEAK}_within"] is None else "")
    return ""
