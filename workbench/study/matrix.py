"""The answer of a study: every model over groups of cases against the references that count.

Made of the tables of cells, comparisons and references. Groups of static cases alone, in which
displacements are given, are judged by the quantity of their gate or the first of the study.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from statistics import median

from workbench.assessment import bias_and_scatter
from workbench.assessment.budget import PEAK, REMAINS, RESIDUAL
from workbench.responses import Outcome
from workbench.study.definition import Study, holds_data
from workbench.study.store import NOT_RUN, Row
from workbench.study.validation import MEASURED

ALL = "all cases"
_POOLED = ("count", "bias", "low", "high", "least", "most", "worst", "within")
_ENDS = ("answered", "collapsed", "refused", "not_run", "failed")
# `quantity`: whose numbers the columns of the peak hold
# `falls`: the model collapses and the reference survives, `stands`: the other way round;
# `against`: the references that count, in words; `reference`: cases in which the label is that
# itself; `known`: largest relative uncertainty of its own peaks there; `outside`: answers outside
# the domain of the model; `against_outside`: comparisons with a reference outside its own;
# `synthetic`: cases whose reference is made numbers
MATRIX_COLUMNS = (
    *("group", "label", "quantity", "against", "asked", *_ENDS, "falls", "stands", "outside"),
    *("reference", "known", "against_outside", "synthetic"),
    *(f"{quantity}_{name}" for quantity in (PEAK, RESIDUAL) for name in _POOLED),
)
COST_COLUMNS = ("label", "against", "count", "ratio", "seconds")

Tables = Mapping[str, Sequence[Row]]
Pairs = Mapping[tuple[str, str, str], Row]


def matrix_rows(study: Study, tables: Tables) -> Iterator[Row]:
    """A row for every group of cases and label, references first.

    Published and measured numbers have none, unless tests are the reference.
    """
    cells = {(row["case"], row["label"]): row for row in tables["cells"]}
    standings = standings_of(tables)
    counting = {case: cells[case, str(row["label"])] for case, row in standings.items()}
    pairs = against_best(tables, standings)
    moving = [case.name for case in study.cases if case.scenario.STATIC is False]
    static = [case.name for case in study.cases if case.scenario.STATIC]
    models = {label: study.models[label] for label in (*study.ranked, *study.models)}
    models = {label: model for label, model in models.items() if _shown(study, label)}
    groups = dict(study.groups) or {ALL: tuple(moving or static)}
    for group, names in groups.items():
        cases = [name for name in names if name in moving]
        quantity = PEAK if cases else _told_by(study, names, pairs)
        cases = cases or [name for name in names if quantity]
        best = Counter(str(standings[case]["label"]) for case in cases if case in standings)
        counted = (f"{label} ({n})" for label, n in best.items())
        against = ", ".join(counted if len(best) > 1 else best)
        for label in models:
            asked = {case: cells[case, label] for case in cases if (case, label) in cells}
            if not asked:
                continue
            own = [standings[case] for case in asked if case in standings]
            yield {
                **{"group": group, "label": label, "quantity": quantity, "against": against},
                **_ended(list(asked.values())),
                **_apart(asked, counting),
                "synthetic": sum(row["synthetic"] for row in own),
                **_as_reference(own, label),
                **_compared(label, list(asked), standings, pairs, quantity),
            }


def _told_by(study: Study, names: Sequence[str], pairs: Pairs) -> str:
    """The quantity by which static cases are judged; empty if none was compared."""
    compared = {quantity for case, _, quantity in pairs if case in names}
    gated = [gate.quantity for gate in study.gates if set(gate.cases or ()) == set(names)]
    return next((name for name in (*gated, *study.quantities) if name in compared), "")


def standings_of(tables: Tables) -> dict[str, Row]:
    """The references that count, by case, where one answered."""
    return {row["case"]: row for row in tables["references"] if row.get("label")}


def against_best(tables: Tables, standings: Mapping[str, Row]) -> Pairs:
    """Comparisons with the reference that counts, by case, label and quantity."""
    return {
        (row["case"], row["model"], row["quantity"]): row
        for row in tables["comparisons"]
        if row["metric"] == "relative_error"
        and row["case"] in standings
        and row["against"] == standings[row["case"]]["label"]
    }


def _ended(cells: Sequence[Row]) -> Row:
    """How many cells were asked, and how they ended."""
    found = Counter(row["outcome"] for row in cells)
    outcomes = (Outcome.OK, Outcome.COLLAPSE, Outcome.OUT_OF_DOMAIN, NOT_RUN)
    counts = [found[outcome] for outcome in outcomes]
    outside = sum(1 for row in cells if row["outcome"] == Outcome.OK and row["outside"])
    ends = zip(_ENDS, (*counts, len(cells) - sum(counts)), strict=True)
    return {"asked": len(cells), **dict(ends), "outside": outside}


def _apart(asked: Mapping[str, Row], best: Mapping[str, Row]) -> Row:
    """Cases in which one side alone collapses, `asked` of the model and `best`, by case."""
    pairs = [(row["outcome"], best[case]["outcome"]) for case, row in asked.items() if case in best]
    ends = {"falls": (Outcome.COLLAPSE, Outcome.OK), "stands": (Outcome.OK, Outcome.COLLAPSE)}
    return {name: pairs.count(end) for name, end in ends.items()}


def _as_reference(standings: Sequence[Row], label: str) -> Row:
    own = [row.get("uncertainty") for row in standings if row["label"] == label]
    known = [float(width) for width in own if width is not None]
    return {
        "reference": len(own),
        "known": max(known) if known and len(known) == len(own) else None,
    }


def _compared(
    label: str, cases: Sequence[str], standings: Mapping[str, Row], pairs: Pairs, quantity: str
) -> Row:
    """Bias of `quantity`, as a rule the peak, and of the residual displacement over a group."""
    row: dict[str, object] = {}
    for name, judged in ((PEAK, quantity), (RESIDUAL, RESIDUAL)):
        told = (telling(pairs, case, label, judged) for case in cases)
        found = [pair for pair in told if pair is not None]
        if found:
            numbers = pooled(found)
            row |= {f"{name}_{number}": numbers[number] for number in _POOLED}
        if name == PEAK:
            row["against_outside"] = sum(not standings[pair["case"]]["inside"] for pair in found)
    return row


def telling(pairs: Pairs, case: str, label: str, quantity: str) -> Row | None:
    """The comparison of a case, None where its ratio says nothing or there is none."""
    pair, peak = (pairs.get((case, label, name)) for name in (quantity, PEAK))
    if quantity not in (PEAK, RESIDUAL):
        peak = pair
    if pair is None or peak is None or min(pair["value"], pair["against_value"]) <= 0.0:
        return None
    return pair if pair["against_value"] >= REMAINS * peak["against_value"] else None


def pooled(rows: Sequence[Row]) -> dict[str, object]:
    """Bias and scatter over compared cases; of a single case its error with its uncertainty.

    The interval holds what the cases scatter and the mean `uncertainty` of their comparisons.
    Two cases tell no scatter. `least` and `most` are the ends of the ratios, `worst` is the error
    of largest magnitude, `within` the largest with its uncertainty (None: unknown in a case).
    """
    found = bias_and_scatter([row["value"] for row in rows], [row["against_value"] for row in rows])
    errors = [row["value"] / row["against_value"] - 1.0 for row in rows]
    both = [(abs(e), row["uncertainty"]) for e, row in zip(errors, rows, strict=True)]
    known = [
        row["uncertainty"] * (row["against_value"] / row["value"])
        for row in rows
        if row["uncertainty"] is not None
    ]
    # numerical errors have one sign over the cases: they shift the bias, they do not scatter
    common = sum(known) / len(known) if known else 0.0
    note = ""
    if len(known) < len(rows):
        unknown = f"{len(rows) - len(known)} of {len(rows)} cases"
        note = f"numerical uncertainty unknown in {unknown}"
    low, high = (None, None) if len(rows) == 2 else (found.low, found.high)
    if len(rows) == 1 and known:
        low = high = found.bias
    return {
        **asdict(found),
        "low": None if low is None else low * (1.0 - common),
        "high": None if high is None else high * (1.0 + common),
        "uncertainty": common if known else None,
        "least": min(errors) + 1.0,
        "most": max(errors) + 1.0,
        "worst": max(errors, key=abs),
        "within": None if len(known) < len(rows) else max(error + width for error, width in both),
        "note": note,
    }


def cost_rows(study: Study, tables: Tables) -> Iterator[Row]:
    """Median time of every label over that of the reference that counts in most cases.

    Solving alone where both sides know that, else the whole answer; a time that may hold
    compilation does not count. Tests have no cost: where they are the reference, the slowest model
    stands for it.
    """
    moving = {case.name for case in study.cases if case.scenario.STATIC is False}
    moving = moving or {case.name for case in study.cases if case.scenario.STATIC}
    standings = standings_of(tables)
    best = Counter(row["label"] for case, row in standings.items() if case in moving)
    timed = {
        (row["case"], row["label"]): row
        for row in tables["cells"]
        if row["outcome"] == Outcome.OK and not row["cold"]
    }
    computed = {label for label, model in study.models.items() if not holds_data(model)}
    whole: dict[str, list[float]] = {}
    for (_, label), row in timed.items():
        whole.setdefault(label, []).append(float(row["wall_time"]))
    slowest = max(computed, key=lambda label: median(whole.get(label, [0.0])), default="")
    counted = [label for label, _ in best.most_common() if label in computed]
    for base in (counted or [slowest])[:1]:
        for label, model in study.models.items():
            pairs = [(timed.get((case, label)), timed.get((case, base))) for case in sorted(moving)]
            ratios = [_ratio(own, other) for own, other in pairs if own and other]
            if ratios and not holds_data(model):
                row = {"label": label, "against": base, "count": len(ratios)}
                own = [timed[case, label] for case in moving if (case, label) in timed]
                seconds = median(float(r.get("solve_time") or r["wall_time"]) for r in own)
                yield {**row, "ratio": median(ratios), "seconds": seconds}


def _shown(study: Study, label: str) -> bool:
    """Whether a label has a row: a model has, and tests that are the reference."""
    model = study.models[label]
    return not holds_data(model) or (model.name == MEASURED and label in study.ranked)


def _ratio(own: Row, other: Row) -> float:
    both = own.get("solve_time") and other.get("solve_time")
    name = "solve_time" if both else "wall_time"
    return float(own[name]) / float(other[name])
