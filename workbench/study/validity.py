"""Rules of validity and rankings from a stored study of drawn columns.

Every answer is judged by the error of its peak against the governing reference: relative, infinite
where one side alone collapses, zero where both do. A small tree per model finds the regions in
which it errs; pairs of answers on the same column say which of two models errs less.
"""

from collections.abc import Iterator, Mapping
from math import inf
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import binomtest

from workbench.arrays import Array, Indices
from workbench.assessment.bias import Leaf, grow, impurity
from workbench.assessment.budget import PEAK
from workbench.evidence.descriptors import FEATURES, features, region_of, variant_of
from workbench.evidence.error_model import BEYOND
from workbench.responses import Outcome
from workbench.scenarios import ColumnImpact
from workbench.study.definition import Study
from workbench.study.matrix import against_governing, governing_references
from workbench.study.tables import Row, Tables, counts, numbers, texts

DEPTH, FEWEST = 4, 12  # of the tree of a model, and columns of a region
ADVISED_DEPTH, ADVISED_FEWEST = 2, 20  # of the tree that says which model to take
LARGE_GROUP = 20  # columns from which models of a group are ranked by counts
_MIDDLE = (5.0, 95.0)  # percentiles of the errors that are told
_COUNTED = counts("low", "high", "false_alarm", "false_safe")
VALIDITY_COLUMNS = (
    texts("model")
    | counts("model_version")
    | texts("options")
    | numbers(*(f"{name}_{end}" for name in FEATURES for end in ("low", "high")))
    | counts("count")
    | _COUNTED
    | numbers("bias", "least", "most")
    | texts("better", "study")
)
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
ADVICE_COLUMNS = (
    texts("region", "label")
    | counts("count", "within")
    | _COUNTED
    | numbers("median", "least", "most")
    | counts("asked", "right")
)


def errors_of(study: Study, tables: Tables) -> pd.DataFrame:
    """Errors of the peak by case and label, of reduced models; NaN where nothing is judged."""
    governing = governing_references(tables)
    governing = governing[governing["inside"] == 1]
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


def classes_of(errors: Array) -> Indices:
    """Classes of errors: 0 too small, 1 within the bound, 2 too large."""
    return np.asarray(np.digitize(errors, [-BEYOND, BEYOND]), dtype=np.int64)


def validity_rows(study: Study, tables: Tables, held_out: set[str]) -> Iterator[Row]:
    """A row for every region of every model, from all columns but the `held_out` ones."""
    errors, points = errors_of(study, tables), points_of(study)
    versions = dict(zip(tables["cells"]["label"], tables["cells"]["model_version"], strict=True))
    within = errors.abs() <= BEYOND
    for label in map(str, errors):
        model, judged = study.models[label], errors[label].dropna()
        judged = judged[~judged.index.isin(held_out)]
        for leaf in leaves_of(judged, points):
            inside = judged.iloc[leaf.members]
            hits = within.loc[inside.index].sum()
            best = hits.index[hits == hits.max()]
            better = "" if label in best else _words(study, best[0])
            ends = dict.fromkeys(FEATURES, (-inf, inf)) | _named(leaf)
            yield {
                "model": model.name,
                "model_version": versions[label],
                "options": variant_of(model),
                **{f"{name}_low": low for name, (low, _) in ends.items()},
                **{f"{name}_high": high for name, (_, high) in ends.items()},
                **_counted(inside),
                "better": better,
                "study": study.name,
            }


def _words(study: Study, label: str) -> str:
    """A model by its name and options."""
    model = study.models[label]
    return f"{model.name} {variant_of(model)}".rstrip()


def held_out_of(study: Study) -> set[str]:
    """Hold-out columns, which a study leaves out of its rules: parameter `part` is ``unseen``."""
    return {case.name for case in study.cases if case.parameters.get("part") == "unseen"}


def points_of(study: Study) -> dict[str, Array]:
    """Features of the columns of a study by case."""
    hits = hits_of(study).items()
    return {name: np.array(list(features(hit).values())) for name, hit in hits}


def hits_of(study: Study) -> dict[str, ColumnImpact]:
    """The impacts on columns of a study, by case."""
    cases = ((case.name, case.scenario) for case in study.cases)
    return {name: each for name, each in cases if isinstance(each, ColumnImpact)}


def leaves_of(errors: pd.Series, points: Mapping[str, Array]) -> list[Leaf]:
    """The tree of a model from its errors by case."""
    given = np.array([points[case] for case in errors.index])
    return list(grow(given, impurity(classes_of(errors.to_numpy())), DEPTH, FEWEST))


def _named(leaf: Leaf) -> dict[str, tuple[float, float]]:
    """Bounds of a region by the name of the feature."""
    return {list(FEATURES)[i]: bounds for i, bounds in leaf.bounds.items()}


def advice_rows(study: Study, tables: Tables) -> Iterator[Row]:
    """The tree that says which model to take: a row for every region, and its hold-out columns.

    In a region the model that is within the bound most often is taken, the cheapest of equals.
    Nothing where a study has no hold-out columns.
    """
    errors, points = errors_of(study, tables), points_of(study)
    errors = errors[errors.index.isin(points)].dropna(how="all")
    costs = tables["cost"].set_index("label")["ratio"].reindex(errors.columns)
    errors = errors[costs.sort_values(kind="stable").index]
    left_out = errors.index.isin(held_out_of(study))
    seen, left = errors[~left_out], errors[left_out]
    if left.empty or len(seen) < LARGE_GROUP:
        return
    within, within_left = (each.abs() <= BEYOND for each in (seen, left))

    def missed(members: Indices) -> float:
        return float(len(members) - within.iloc[members].sum().max())

    given = np.array([points[case] for case in seen.index])
    for leaf in grow(given, missed, ADVISED_DEPTH, ADVISED_FEWEST):
        hits = within.iloc[leaf.members].sum()
        label = str(hits.idxmax())
        held = [case for case in left.index if leaf.holds(points[case])]
        counted = _counted(seen[label].iloc[leaf.members].dropna())
        yield {
            "region": region_of(_named(leaf)),
            "label": label,
            "within": hits.max(),
            "median": counted.pop("bias", None),
            **counted,
            "count": len(leaf.members),
            "asked": len(held),
            "right": within_left.loc[held, label].sum(),
        }


def checked(study: Study, tables: Tables, held_out: set[str]) -> Iterator[Row]:
    """How often the tree of each model is right on its hold-out columns."""
    points = points_of(study)
    for label, errors in errors_of(study, tables).items():
        judged = errors.dropna()
        left_out = judged.index.isin(held_out)
        seen, left = judged[~left_out], judged[left_out]
        leaves, classes = leaves_of(seen, points), classes_of(seen.to_numpy())
        right = 0
        for case, error in left.items():
            leaf = next(leaf for leaf in leaves if leaf.holds(points[str(case)]))
            usual = np.bincount(classes[leaf.members]).argmax()
            right += int(usual == classes_of(np.array([error]))[0])
        yield {"label": label, "asked": len(left), "right": right}


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
