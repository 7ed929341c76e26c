"""The answer of a study: every model over groups of cases against the governing references.

Groups of static cases alone, in which displacements are given, are judged by the quantity of their
gate or the first of the study.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from math import inf

import pandas as pd

from workbench.responses import Outcome
from workbench.study.assessment import bias_and_scatter
from workbench.study.assessment.budget import PEAK, REMAINS, RESIDUAL
from workbench.study.definition import Study, holds_data
from workbench.study.error_rows import DOUBTFUL
from workbench.study.store import NOT_RUN
from workbench.study.tables import Row, Tables, counts, numbers, texts
from workbench.study.validation import MEASURED

ALL = "all cases"
_POOLED = ("count", "bias", "low", "high", "least", "most", "worst", "within")
_ENDS = {
    "answered": Outcome.OK,
    "collapsed": Outcome.COLLAPSE,
    "refused": Outcome.OUT_OF_DOMAIN,
    "not_run": NOT_RUN,
}
# `quantity`: whose numbers the columns of the peak hold
# `false_alarm`: the model collapses and the reference survives, `false_safe`: the other way round;
# `against`: the governing references, in words; `reference`: cases in which the label is that
# itself; `known`: largest relative uncertainty of its own peaks there; `outside`: answers outside
# the domain of the model by its physics; `warned`: answers whose error the error model warns of,
# which the comparison measures; `against_outside`: comparisons with a reference outside its own;
# `synthetic`: cases whose reference is made numbers
MATRIX_COLUMNS = (
    texts("group", "label", "quantity", "against")
    | counts("asked", *_ENDS, "failed", "false_alarm", "false_safe")
    | counts("outside", "warned", "reference")
    | numbers("known")
    | counts("against_outside", "synthetic", f"{PEAK}_count")
    | numbers(*(f"{PEAK}_{name}" for name in _POOLED[1:]))
    | counts(f"{RESIDUAL}_count")
    | numbers(*(f"{RESIDUAL}_{name}" for name in _POOLED[1:]))
)
COST_COLUMNS = texts("label", "against") | counts("count") | numbers("ratio", "seconds")
BIAS_COLUMNS = (
    texts("model", "against", "quantity")
    | counts("count")
    | numbers("bias", "low", "high", "uncertainty", "model_scatter")
    | texts("note")
)
_FEWEST_FOR_BIAS = 3  # cases


def governing_references(tables: Tables) -> pd.DataFrame:
    """The governing references by case, where one answered, with its `outcome`."""
    ends = tables["cells"][["case", "label", "outcome"]]
    return tables["references"].merge(ends, on=["case", "label"]).set_index("case")


def against_governing(tables: Tables) -> pd.DataFrame:
    """Relative errors against the governing reference, by (case, model, quantity).

    Column `telling`: the ratio says something. Both numbers have one sign, and a residual
    displacement is no small part of the peak.
    """
    compared = tables["comparisons"]
    label = compared["case"].map(governing_references(tables)["label"])
    compared = compared[(compared["metric"] == "relative_error") & (compared["against"] == label)]
    peaks = compared[compared["quantity"] == PEAK].set_index(["case", "model"])["against_value"]
    pairs = compared.join(peaks.rename("peak"), on=["case", "model"])
    share = (pairs["against_value"] / pairs["peak"]).abs()
    remains = (pairs["quantity"] != RESIDUAL) | (share >= REMAINS)
    alike = pairs["value"] * pairs["against_value"] > 0.0
    return pairs.assign(telling=alike & remains).set_index(["case", "model", "quantity"])


def errors_of(study: Study, tables: Tables) -> pd.DataFrame:
    """Errors of the peak by case and label, of reduced models; NaN where nothing is judged.

    Relative to the governing reference: infinite where one side alone collapses, zero where both
    do. References judge nobody outside their domain, or where they warn of their own numbers.
    """
    governing, findings = governing_references(tables), tables["findings"]
    doubtful = findings[findings["subject"].isin(DOUBTFUL)].set_index(["case", "label"]).index
    doubted = governing.set_index("label", append=True).index.isin(doubtful)
    governing = governing[(governing["inside"] == 1) & ~doubted]
    pairs = against_governing(tables).reset_index()
    pairs = pairs[(pairs["quantity"] == PEAK) & (pairs["against_value"] != 0.0)]
    ratios = pairs.assign(ratio=pairs["value"] / pairs["against_value"])
    outcomes = tables["cells"].pivot_table("outcome", "case", "label", aggfunc="first")
    labels = [label for label in study.models if label in outcomes and label not in study.ranked]
    ends, reference = outcomes.reindex(index=governing.index)[labels], governing["outcome"]
    errors = ratios.pivot_table("ratio", "case", "model").reindex_like(ends) - 1.0
    for label in labels:
        collapsed, survived = ends[label] == Outcome.COLLAPSE, ends[label] == Outcome.OK
        errors.loc[collapsed & (reference == Outcome.COLLAPSE), label] = 0.0
        errors.loc[collapsed & (reference == Outcome.OK), label] = inf
        errors.loc[survived & (reference == Outcome.COLLAPSE), label] = -inf
    return errors.dropna(axis="columns", how="all")


def matrix_rows(study: Study, tables: Tables) -> Iterator[Row]:
    """A row for every group of cases and label, references first.

    Published and measured numbers have none, unless tests are the reference.
    """
    cells = tables["cells"]
    governing = governing_references(tables)
    pairs = against_governing(tables)
    moving = [case.name for case in study.cases if case.scenario.STATIC is False]
    static = [case.name for case in study.cases if case.scenario.STATIC]
    shown = [  # models, and tests that are the reference
        label
        for label in dict.fromkeys((*study.ranked, *study.models))
        if not holds_data(study.models[label])
        or (study.models[label].name == MEASURED and label in study.ranked)
    ]
    groups = dict(study.groups) or {ALL: tuple(moving or static)}
    for group, names in groups.items():
        cases = [name for name in names if name in moving]
        quantity = PEAK if cases else _judging_quantity(study, names, pairs)
        cases = cases or [name for name in names if quantity]
        best = governing.reindex(cases).dropna(subset="label")
        governed = Counter(best["label"])
        named = (f"{label} ({n})" for label, n in governed.items())
        in_words = ", ".join(named if len(governed) > 1 else governed)
        of_group = cells[cells["case"].isin(cases)]
        for label in shown:
            rows_by_case = of_group[of_group["label"] == label].set_index("case")
            if rows_by_case.empty:
                continue
            held = best.loc[best.index.intersection(rows_by_case.index)]
            ends, other = rows_by_case["outcome"], best["outcome"].reindex(rows_by_case.index)
            counted = {name: int((ends == outcome).sum()) for name, outcome in _ENDS.items()}
            itself = held[held["label"] == label]
            yield {
                **{"group": group, "label": label, "quantity": quantity, "against": in_words},
                "asked": len(ends),
                **counted,
                "failed": len(ends) - sum(counted.values()),
                "outside": (rows_by_case.loc[ends == Outcome.OK, "outside"] > 0).sum(),
                "warned": (rows_by_case.loc[ends == Outcome.OK, "warned"] > 0).sum(),
                "false_alarm": ((ends == Outcome.COLLAPSE) & (other == Outcome.OK)).sum(),
                "false_safe": ((ends == Outcome.OK) & (other == Outcome.COLLAPSE)).sum(),
                "synthetic": held["synthetic"].sum(),
                "reference": len(itself),
                "known": itself["uncertainty"].max(skipna=False),
                **_compared(pairs, label, rows_by_case.index, held, quantity),
            }


def _judging_quantity(study: Study, names: Sequence[str], pairs: pd.DataFrame) -> str:
    """The quantity by which static cases are judged; empty if none was compared."""
    compared = set(pairs.index[pairs.index.isin(names, level="case")].get_level_values("quantity"))
    gated = [gate.quantity for gate in study.gates if set(gate.cases or ()) == set(names)]
    return next((name for name in (*gated, *study.quantities) if name in compared), "")


def _compared(
    pairs: pd.DataFrame, label: str, cases: pd.Index, held: pd.DataFrame, quantity: str
) -> Row:
    """Bias of `quantity`, as a rule the peak, and of the residual displacement over a group."""
    row: dict[str, object] = {}
    of_label = pairs.index.get_level_values("model") == label
    for name, judged in ((PEAK, quantity), (RESIDUAL, RESIDUAL)):
        chosen = of_label & (pairs.index.get_level_values("quantity") == judged) & pairs["telling"]
        compared = pairs[chosen].droplevel(["model", "quantity"])
        compared = compared[compared.index.isin(cases)]
        if len(compared):
            pooling = pooled(compared)
            row |= {f"{name}_{number}": pooling[number] for number in _POOLED}
        if name == PEAK:
            row["against_outside"] = (held["inside"].reindex(compared.index) == 0).sum()
    return row


def pooled(pairs: pd.DataFrame) -> dict[str, object]:
    """Bias and scatter over compared cases; of a single case its error with its uncertainty.

    The interval holds what the cases scatter and the mean `uncertainty` of their comparisons.
    Two cases tell no scatter. `least` and `most` are the ends of the ratios, `worst` is the error
    of largest magnitude, `within` the largest with its uncertainty (None: unknown in a case).
    """
    bias = bias_and_scatter(pairs["value"], pairs["against_value"])
    errors, widths = pairs["value"] / pairs["against_value"] - 1.0, pairs["uncertainty"]
    # numerical errors have one sign over the cases: they shift the bias, they do not scatter
    known = (widths * pairs["against_value"] / pairs["value"]).dropna()
    common = float(known.mean()) if len(known) else 0.0
    unknown = len(pairs) - len(known)
    low, high = (None, None) if len(pairs) == 2 else (bias.low, bias.high)
    if len(pairs) == 1 and len(known):
        low = high = bias.bias
    return {
        **asdict(bias),
        "low": None if low is None else low * (1.0 - common),
        "high": None if high is None else high * (1.0 + common),
        "uncertainty": common if len(known) else None,
        "least": errors.min() + 1.0,
        "most": errors.max() + 1.0,
        "worst": errors.iloc[int(errors.abs().argmax())],
        "within": None if unknown else (errors.abs() + widths).max(),
        "note": f"numerical uncertainty unknown in {unknown} of {len(pairs)} cases"
        if unknown
        else "",
    }


def bias_rows(study: Study, tables: Tables) -> Iterator[Row]:
    """Bias and scatter of every model against the reference over the cases, per quantity."""
    compared = tables["comparisons"]
    chosen = (compared["against"] == study.reference) & (compared["metric"] == "relative_error")
    compared = compared[chosen & (compared["value"] * compared["against_value"] > 0.0)]
    for (model, quantity), pairs in compared.groupby(["model", "quantity"], sort=False):
        if len(pairs) >= _FEWEST_FOR_BIAS:
            row = {"model": model, "against": study.reference, "quantity": quantity}
            yield {**row, **pooled(pairs)}


def cost_rows(study: Study, tables: Tables) -> Iterator[Row]:
    """Median time of every label over that of the reference that governs most cases.

    Solving alone where both sides know that, else the whole answer; a time that may hold
    compilation does not count. Tests have no cost: where they are the reference, the slowest model
    stands for it.
    """
    moving = {case.name for case in study.cases if case.scenario.STATIC is False}
    moving = moving or {case.name for case in study.cases if case.scenario.STATIC}
    computed = [label for label, model in study.models.items() if not holds_data(model)]
    cells = tables["cells"]
    timed = cells[(cells["outcome"] == Outcome.OK) & (cells["cold"] == 0)]
    whole, solving = (
        timed.pivot_table(name, "case", "label").reindex(columns=computed)
        for name in ("wall_time", "solve_time")
    )
    slowest = whole.median().fillna(0.0).nlargest(1).index
    solving = solving.where(solving > 0.0).reindex_like(whole)
    best = governing_references(tables)["label"]
    governed = Counter(best[best.index.isin(moving)]).most_common()
    for base in [label for label, _ in governed if label in computed][:1] or slowest:
        whole, solving = (times[times.index.isin(moving)] for times in (whole, solving))
        ratios = solving.div(solving[base], axis=0).fillna(whole.div(whole[base], axis=0))
        seconds = solving.fillna(whole).median()
        for label in computed:
            if count := ratios[label].count():
                row = {"label": label, "against": base, "count": count}
                yield {**row, "ratio": ratios[label].median(), "seconds": seconds[label]}
