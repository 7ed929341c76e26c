"""The answer of a study: every model over groups of cases against the governing references.

Groups of static cases alone, in which displacements are given, are judged by the quantity of their
gate or the first of the study.

**Second part.** Which model to take: rankings over large groups of cases, and what the error model
is worth.

Models are ranked by the errors of their peaks; pairs of answers on the same column say which of two
errs less. What the error model says of the drawn scenarios of a study, by cell, by model and as a
chooser, is cross-validated: what is said of a case comes from the other cases of its cell. As in
`evidence/error_model.py`, ln(answer / truth) is ln(answer / anchor), which is known, plus what the
others near it make expect of ln(anchor / truth); ends are order statistics of the rests.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict
from math import inf
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import scipy

from workbench.base.catalogue import IMPORTED
from workbench.base.errors import OutOfDomainError
from workbench.models.strain_rate import feels_rate
from workbench.responses import PEAK, RESIDUAL, Outcome
from workbench.responses.outcome import WARNED, loss_of
from workbench.study.assessment import bias_and_scatter
from workbench.study.assessment.gates import REMAINS
from workbench.study.definition import Study, holds_data
from workbench.study.error_model.error_model import BEYOND, chances_beyond
from workbench.study.error_model.error_table import LocalMean, ends_of, table_of, variant_of
from workbench.study.error_rows import DOUBTFUL
from workbench.study.store import NOT_RUN
from workbench.study.tables import Row, Tables, counts, numbers, tabled, texts
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


@tabled(MATRIX_COLUMNS)
def _matrix(study: Study, tables: Tables) -> Iterator[Row]:
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
        or study.models[label].name == IMPORTED
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


@tabled(BIAS_COLUMNS)
def _bias(study: Study, tables: Tables) -> Iterator[Row]:
    """Bias and scatter of every model against the reference over the cases, per quantity."""
    compared = tables["comparisons"]
    chosen = (compared["against"] == study.reference) & (compared["metric"] == "relative_error")
    compared = compared[chosen & (compared["value"] * compared["against_value"] > 0.0)]
    for (model, quantity), pairs in compared.groupby(["model", "quantity"], sort=False):
        if len(pairs) >= _FEWEST_FOR_BIAS:
            row = {"model": model, "against": study.reference, "quantity": quantity}
            yield {**row, **pooled(pairs)}


@tabled(COST_COLUMNS)
def _cost(study: Study, tables: Tables) -> Iterator[Row]:
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


LARGE_GROUP = 20  # columns from which models of a group are ranked by counts
_MIDDLE = (5.0, 50.0, 95.0)  # percentiles of the errors that are told
# of the columns that were `judged`: `low` and `high`, beyond the bound; percentiles of the ratios
# to the reference; of `pairs` with the best model, `against`, those that this `wins`, and the
# `chance` of as many if both were equal (sign test; ties count for neither)
RANKING_COLUMNS = (
    texts("group", "label")
    | counts("asked", "judged", "within", "low", "high", "false_alarm", "false_safe", "refused")
    | numbers("least", "median", "most")
    | texts("against")
    | counts("pairs", "wins")
    | numbers("chance")
)
FEWEST = 20  # cases of a cell, of which anything is said
REACH = 0.9  # share of the errors within `reach`
QUICK, CORRECTED, SURE = (
    "the best quick model of each cell",
    "the anchor, over its expected ratio",
    "the same, the reference where the anchor is warned of",
)
# `off`: more than 10 % in error; `held`: inside the interval of the others; `collapses` of the
# truth; `median`, `low` and `high` of the error of the anchor, `chance` of more than 10 %
CELL_COLUMNS = (
    texts("cell", "anchor", "reference")
    | counts("count", "off", "held", "collapses", "warned")
    | numbers("median", "low", "high", "chance")
)
# `count` of peaks with an interval, its median `width` as truth over answer; of all `answers`
# `right`: warned, but within 10 %, `silent`: beyond it and not warned; `apart`: model or truth
# collapses alone, `unseen`: without a warning
COVERAGE_COLUMNS = (
    texts("label")
    | counts("count", "held")
    | numbers("width")
    | counts("answers", "warned", "right", "silent", "apart", "unseen")
)
# `chooses`: whether the `way` is to choose among models, else one model; `seconds`, mean of a case
CHOOSER_COLUMNS = texts("way") | counts("chooses", "count", "within") | numbers("reach", "seconds")


@tabled(RANKING_COLUMNS)
def ranking(study: Study, tables: Tables) -> Iterator[Row]:
    """A row for every large group and model, the best first, with its pairs against that one.

    Ranked by columns not within the bound, then by the median size of the error.
    """
    errors, cells = errors_of(study, tables), tables["cells"]
    for group, names in study.groups.items():
        if len(names) < LARGE_GROUP:
            continue
        of_models = errors[errors.index.isin(names)].dropna(axis="columns", how="all")
        sizes = of_models.abs()
        ranks = pd.DataFrame({"missed": -(sizes <= BEYOND).sum(), "size": sizes.median()})
        order = ranks.sort_values(["missed", "size"], kind="stable").index
        of_group = cells[cells["case"].isin(names)]
        for label in order:
            ends = of_group.loc[of_group["label"] == label, "outcome"]
            judged = of_models[label].dropna()
            finite = judged[np.isfinite(judged)]
            spread = np.percentile(finite, _MIDDLE) if len(finite) else ()
            best, other = sizes[order[0]], sizes[label]
            apart = best.notna() & other.notna() & (best != other)
            pairs, wins = int(apart.sum()), int((best < other)[apart].sum())
            chance = (
                scipy.stats.binomtest(wins, pairs, alternative="greater").pvalue if pairs else None
            )
            yield {
                "group": group,
                "label": label,
                "asked": len(ends),
                "judged": len(judged),
                "within": (judged.abs() <= BEYOND).sum(),
                "low": (judged < -BEYOND).sum(),
                "high": (judged > BEYOND).sum(),
                "false_alarm": (judged == np.inf).sum(),
                "false_safe": (judged == -np.inf).sum(),
                "refused": (ends == Outcome.OUT_OF_DOMAIN).sum(),
                **{
                    name: float(f"{1.0 + value:.4g}")
                    for name, value in zip(("least", "median", "most"), spread, strict=False)
                },
                **{"against": order[0], "pairs": pairs, "wins": wins},
                "chance": None if chance is None else float(f"{chance:.2g}"),
            }


class _Drawn(NamedTuple):
    """Judged cases and what is expected of them by the others: tables by (case, label).

    `errors` as `errors_of`, `cells` of the cases; `collapses` of the truth; `known`: model, anchor
    and truth stand; `fallen`: the model does not; `expected` error, its ends and the `loss` to
    expect.
    """

    anchor: str
    reference: str
    cells: pd.Series
    errors: pd.DataFrame
    seconds: pd.DataFrame
    fallen: pd.DataFrame
    collapses: pd.Series
    known: pd.DataFrame
    low: pd.DataFrame
    expected: pd.DataFrame
    high: pd.DataFrame
    loss: pd.DataFrame

    @property
    def held(self) -> pd.DataFrame:
        """Whether an error lies inside its interval."""
        return (self.low <= self.errors) & (self.errors <= self.high)

    @property
    def warned(self) -> pd.DataFrame:
        """Whether an answer is warned of."""
        return (self.loss > WARNED) | self.fallen.ne(self.fallen[self.anchor], axis=0)


def derived_tables(study: Study, tables: Tables) -> dict[str, pd.DataFrame]:
    """Tables that follow from those of cells, comparisons and references, by name."""
    return {
        "bias": _bias(study, tables),
        "matrix": _matrix(study, tables),
        "cost": _cost(study, tables),
        "ranking": ranking(study, tables),
        **error_tables(study, tables),
    }


def error_tables(study: Study, tables: Tables) -> dict[str, pd.DataFrame]:
    """Tables of the error model by name; without rows if a study has no anchor or few cases."""
    drawn = _drawn(study, tables)
    makers = {"error-cells": _cells, "coverage": _coverages, "chooser": _choosers}
    return {name: made(drawn) for name, made in makers.items()}


def _drawn(study: Study, tables: Tables) -> _Drawn | None:
    scenarios: dict[str, Any] = {case.name: case.scenario for case in study.cases}
    errors = errors_of(study, tables)
    of_kind = table_of(scenarios[errors.index[0]]) if len(errors) else None
    if of_kind is None:
        return None
    models = {label: study.models[label] for label in map(str, errors)}
    anchors = (n for n, m in models.items() if m.name == of_kind.anchor and not variant_of(m))
    anchor = next(anchors, "")
    if not anchor:
        return None
    listed = {}
    for case in errors.index[errors[anchor].notna()]:
        with suppress(OutOfDomainError):  # such a scenario has no cell
            if table_of(scenarios[case]) is of_kind and not feels_rate(scenarios[case]):
                listed[case] = of_kind.features(scenarios[case])
    features = pd.DataFrame.from_dict(listed, orient="index", columns=list(of_kind.words))
    bounds = {name: each for name, each in of_kind.cells.items() if name in features}
    places = [np.searchsorted(each, features[name], "right") for name, each in bounds.items()]
    features = features.iloc[np.lexsort(places[::-1])]
    words = (of_kind.cell(dict(row)) for _, row in features.iterrows())
    cells = pd.Series(list(words), features.index, dtype="str")
    cells = cells[cells.map(cells.value_counts()) >= FEWEST]
    if cells.empty:
        return None
    errors, all_cells = errors.loc[cells.index], tables["cells"]
    outcomes = all_cells.pivot_table("outcome", "case", "label", aggfunc="first")
    timed = all_cells[all_cells["cold"] == 0].pivot_table("wall_time", "case", "label")
    fallen = (outcomes == Outcome.COLLAPSE).loc[errors.index, errors.columns]
    collapses = fallen[anchor] ^ np.isinf(errors[anchor])
    known = (errors.notna() & ~fallen).mul(~fallen[anchor] & ~collapses, axis=0)
    logs = errors.where(known).transform(np.log1p)
    rests, stands = logs[anchor].copy(), known[anchor]
    if of_kind.centred and stands.any():
        points = of_kind.scaled(features.loc[stands.index[stands]])
        rests[stands] = LocalMean(points, rests[stands].to_numpy()).rests
    expected = _expected(logs, rests.groupby(cells))
    seconds = timed.reindex(errors.index)
    return _Drawn(
        *(anchor, study.reference, cells, errors, seconds, fallen, collapses, known), *expected
    )


def _expected(logs: pd.DataFrame, by_cell: Any) -> Iterator[pd.DataFrame]:
    """Low end, median and high end of the errors to expect, and the loss.

    From `logs`, ln(answer / truth), and rests of the anchor by cell; NaN where nothing is known.
    """
    expected = np.full((4, *logs.shape), np.nan)
    rows, anchor = logs.to_numpy(), by_cell.obj.to_numpy()
    for places in by_cell.indices.values():
        places = places[np.isfinite(anchor[places])]
        low, high = ends_of(len(places) - 1)
        for place in places:
            others = np.sort(anchor[places[places != place]])
            errors = np.exp((rows[place] - anchor[place])[:, None] + others) - 1.0
            ends = errors[:, low], np.median(errors, axis=1), errors[:, high]
            expected[:, place] = *ends, loss_of(*chances_beyond(errors))
    for each in np.where(np.isfinite(rows), expected, np.nan):
        yield pd.DataFrame(each, logs.index, logs.columns)


@tabled(CELL_COLUMNS)
def _cells(drawn: _Drawn | None) -> Iterator[Row]:
    """A row for every cell: the error of the anchor, of all cases of the cell."""
    if drawn is None:
        return
    anchor = drawn.anchor
    for cell, members in drawn.cells.groupby(drawn.cells, sort=False):
        stands = drawn.known.loc[members.index, anchor]
        errors = np.sort(drawn.errors.loc[stands.index[stands], anchor].to_numpy())
        low, high = ends_of(len(errors))
        off = np.count_nonzero(np.abs(errors) > BEYOND)
        chance, unsafe = chances_beyond(errors)
        warned = loss_of(chance, unsafe) > WARNED
        yield {
            **{"cell": cell, "anchor": anchor, "reference": drawn.reference},
            **{"count": len(errors), "off": off, "chance": chance, "warned": warned},
            "held": drawn.held.loc[stands.index, anchor].sum(),
            "collapses": drawn.collapses[stands.index].sum(),
            **{"median": np.median(errors), "low": errors[low], "high": errors[high]},
        }


@tabled(COVERAGE_COLUMNS)
def _coverages(drawn: _Drawn | None) -> Iterator[Row]:
    """A row for every model: what intervals hold, who is warned, and what nobody said."""
    if drawn is None:
        return
    within, warned, held = drawn.errors.abs() <= BEYOND, drawn.warned, drawn.held
    apart = drawn.fallen.ne(drawn.collapses, axis=0)
    widths = 1.0 / (1.0 + drawn.low) - 1.0 / (1.0 + drawn.high)
    for label in map(str, drawn.errors):
        answered = drawn.errors[label].notna()
        counted = {
            "held": held,
            "warned": warned,
            "right": warned & within,
            "silent": ~warned & ~within,
            "apart": apart,
            "unseen": apart & ~warned,
        }
        yield {
            "label": label,
            **{"count": drawn.known[label].sum(), "answers": answered.sum()},
            "width": widths[label].median(),
            **{name: of.loc[answered, label].sum() for name, of in counted.items()},
        }


@tabled(CHOOSER_COLUMNS)
def _choosers(drawn: _Drawn | None) -> Iterator[Row]:
    """A row for every model by itself, then for every way to choose; the reference is right."""
    if drawn is None:
        return
    errors, anchor, seconds = drawn.errors, drawn.anchor, drawn.seconds
    for label in map(str, errors):
        yield _chosen(label, errors[label], seconds[label])
    times = seconds.mean()
    quick = [n for n in map(str, errors) if times[n] < times[anchor]]
    if quick:
        hits = (errors[quick].abs() <= BEYOND).groupby(drawn.cells).transform("sum")
        best = (hits - (errors[quick].abs() <= BEYOND)).idxmax(axis=1)
        places = np.arange(len(best)), errors.columns.get_indexer(pd.Index(best))
        tables = errors, seconds[errors.columns]
        picked = (pd.Series(each.to_numpy()[places], best.index) for each in tables)
        yield _chosen(QUICK, *picked, chooses=True)
    uncorrected = errors[anchor]
    corrected = ((1.0 + uncorrected) / (1.0 + drawn.expected[anchor]) - 1.0).fillna(uncorrected)
    yield _chosen(CORRECTED, corrected, seconds[anchor], chooses=True)
    warned = drawn.warned[anchor]
    asked = seconds[anchor] + seconds[drawn.reference].where(warned, 0.0)
    yield _chosen(SURE, corrected.mask(warned, 0.0), asked, chooses=True)


def _chosen(way: str, errors: pd.Series, seconds: pd.Series, *, chooses: bool = False) -> Row:
    sizes = errors.abs().dropna()
    row = {"way": way, "chooses": chooses, "count": len(sizes), "seconds": seconds.mean()}
    reach = sizes.quantile(REACH, interpolation="higher")
    return {**row, "within": (sizes <= BEYOND).sum(), "reach": reach}
