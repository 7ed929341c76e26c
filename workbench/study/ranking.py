"""Errors of the peaks of a study's models, and their ranking over large groups of cases.

Every answer is judged by the error of its peak against the governing reference: relative, infinite
where one side alone collapses, zero where both do. Pairs of answers on the same column say which of
two models errs less.
"""

from collections.abc import Iterator
from math import inf
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import binomtest

from workbench.assessment.budget import PEAK
from workbench.evidence.error_model import BEYOND
from workbench.responses import Outcome
from workbench.study.definition import Study
from workbench.study.error_rows import DOUBTFUL
from workbench.study.matrix import against_governing, governing_references
from workbench.study.tables import Row, Tables, counts, numbers, texts

LARGE_GROUP = 20  # columns from which models of a group are ranked by counts
_MIDDLE = (5.0, 95.0)  # percentiles of the errors that are told
_COUNTED = counts("low", "high", "false_alarm", "false_safe")
RANKING_COLUMNS = (
    texts("group", "label")
    | counts("asked", "judged", "within")
    | _COUNTED
    | counts("refused")
    | numbers("median", "least", "most")
    | texts("against")
    | counts("pairs", "wins")
    | numbers("chance")
)


def errors_of(study: Study, tables: Tables) -> pd.DataFrame:
    """Errors of the peak by case and label, of reduced models; NaN where nothing is judged.

    References judge nobody outside their domain, or where they warn of their own numbers.
    """
    governing, findings = governing_references(tables), tables["findings"]
    doubtful = findings[findings["subject"].isin(DOUBTFUL)].set_index(["case", "label"]).index
    doubted = governing.set_index("label", append=True).index.isin(doubtful)
    governing = governing[(governing["inside"] == 1) & ~doubted]
    pairs = against_governing(tables).reset_index()
    pairs = pairs[(pairs["quantity"] == PEAK) & (pairs["against_value"] > 0.0)]
    pairs = pairs.assign(ratio=pairs["value"] / pairs["against_value"])
    ratios = pairs.pivot_table("ratio", "case", "model")
    outcomes = tables["cells"].pivot_table("outcome", "case", "label", aggfunc="first")
    labels = [label for label in study.models if label in outcomes and label not in study.ranked]
    ends, reference = outcomes.reindex(index=governing.index)[labels], governing["outcome"]
    errors = ratios.reindex(index=ends.index, columns=labels) - 1.0
    for label in labels:
        collapsed, survived = ends[label] == Outcome.COLLAPSE, ends[label] == Outcome.OK
        errors.loc[collapsed & (reference == Outcome.COLLAPSE), label] = 0.0
        errors.loc[collapsed & (reference == Outcome.OK), label] = inf
        errors.loc[survived & (reference == Outcome.COLLAPSE), label] = -inf
    return errors.dropna(axis="columns", how="all")


def ranking_rows(study: Study, tables: Tables) -> Iterator[Row]:
    """A row for every large group and model, the best first, with its pairs against that one.

    Ranked by columns not within the bound, then by the median size of the error.
    """
    errors = errors_of(study, tables)
    cells = tables["cells"]
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
            counted = _counted(judged)
            yield {
                "group": group,
                "label": label,
                "asked": len(ends),
                "judged": counted.pop("count"),
                "within": (judged.abs() <= BEYOND).sum(),
                "median": counted.pop("bias", None),
                **counted,
                "refused": (ends == Outcome.OUT_OF_DOMAIN).sum(),
                **_paired(sizes[order[0]], sizes[label], order[0]),
            }


def _counted(errors: pd.Series) -> dict[str, Any]:
    """How errors are spread; `bias` is the ratio of the median column that both sides survive."""
    finite = errors[np.isfinite(errors)]
    row: dict[str, Any] = {
        "count": len(errors),
        "low": (errors < -BEYOND).sum(),
        "high": (errors > BEYOND).sum(),
        "false_alarm": (errors == inf).sum(),
        "false_safe": (errors == -inf).sum(),
    }
    if len(finite):
        least, most = np.percentile(finite, _MIDDLE)
        ends = {"bias": np.median(finite), "least": least, "most": most}
        row |= {name: float(f"{1.0 + value:.4g}") for name, value in ends.items()}
    return row


def _paired(best: pd.Series, other: pd.Series, name: str) -> Row:
    """In how many of the columns that both answered the best one errs less, and by what chance.

    The sign test: `chance` of as many if both were equal. Ties count for neither.
    """
    apart = best.notna() & other.notna() & (best != other)
    pairs, wins = int(apart.sum()), int((best < other)[apart].sum())
    row: dict[str, Any] = {"against": name, "pairs": pairs, "wins": wins}
    if pairs:
        row["chance"] = float(f"{binomtest(wins, pairs, alternative='greater').pvalue:.2g}")
    return row
