"""Rules of validity and rankings from a stored study of drawn columns.

Every answer is judged by its peak against the reference that counts: its relative error, infinite
where one side alone collapses, zero where both do. A small tree per model finds the regions in
which it errs; pairs of answers on the same column say which of two models errs less.
"""

from collections.abc import Iterator, Mapping
from math import inf
from typing import Any

import numpy as np
from scipy.stats import binomtest

from workbench.arrays import Array, Indices
from workbench.assessment.budget import PEAK
from workbench.assessment.tree import Leaf, grow, impurity
from workbench.evidence.descriptors import FEATURES, features, region_of, variant_of
from workbench.evidence.measured import BEYOND
from workbench.responses import Outcome
from workbench.scenarios import ColumnImpact
from workbench.study.definition import Study
from workbench.study.matrix import Tables, against_best, standings_of
from workbench.study.store import Row

DEPTH, FEWEST = 4, 12  # of the tree of a model, and columns of a region
ADVISED_DEPTH, ADVISED_FEWEST = 2, 20  # of the tree that says which model to take
LARGE_GROUP = 20  # columns from which models of a group are ranked by counts
_MIDDLE = (5.0, 95.0)  # percentiles of the errors that are told
VALIDITY_COLUMNS = (
    *("model", "model_version", "options"),
    *(f"{name}_{end}" for name in FEATURES for end in ("low", "high")),
    *("count", "low", "high", "falls", "stands", "bias", "least", "most"),
    *("better", "better_count", "better_off", "study"),
)
RANKING_COLUMNS = (
    *("group", "label", "asked", "judged", "within", "low", "high", "falls", "stands", "refused"),
    *("median", "least", "most", "against", "pairs", "wins", "chance"),
)
ADVICE_COLUMNS = (
    *("region", "label", "count", "within", "low", "high", "falls", "stands"),
    *("median", "least", "most", "asked", "right"),
)
Errors = Mapping[str, Mapping[str, float]]


def errors_of(study: Study, tables: Tables) -> dict[str, dict[str, float]]:
    """Errors of the peak by label and case, of reduced models."""
    standings = standings_of(tables)
    pairs = against_best(tables, standings)
    outcomes = {(row["case"], row["label"]): row["outcome"] for row in tables["cells"]}
    found: dict[str, dict[str, float]] = {}
    for (case, label), outcome in outcomes.items():
        standing = standings.get(case)
        if standing is None or not standing["inside"] or label in study.ranked:
            continue
        ends = (outcome, outcomes[case, standing["label"]])
        fallen = tuple(end == Outcome.COLLAPSE for end in ends)
        pair = pairs.get((case, label, PEAK))
        if any(fallen):
            error = 0.0 if all(fallen) else inf if fallen[0] else -inf
            if all(fallen) or ends[1 if fallen[0] else 0] == Outcome.OK:
                found.setdefault(label, {})[case] = error
        elif pair is not None and pair["against_value"] > 0.0:
            found.setdefault(label, {})[case] = pair["value"] / pair["against_value"] - 1.0
    return found


def classes_of(errors: Array) -> Indices:
    """Classes of errors: 0 too small, 1 within the bound, 2 too large."""
    return np.asarray(np.digitize(errors, [-BEYOND, BEYOND]), dtype=np.int64)


def validity_rows(study: Study, tables: Tables, unseen: set[str]) -> Iterator[Row]:
    """A row for every region of every model, from all columns but the `unseen` ones."""
    errors = errors_of(study, tables)
    points = points_of(study)
    versions = {row["label"]: row["model_version"] for row in tables["cells"]}
    for label, found in errors.items():
        model, cases = study.models[label], [case for case in found if case not in unseen]
        for leaf in leaves_of(found, points, cases):
            inside = [cases[i] for i in leaf.members]
            ends = dict.fromkeys(FEATURES, (-inf, inf)) | _named(leaf)
            yield {
                "model": model.name,
                "model_version": versions[label],
                "options": variant_of(model),
                **{
                    f"{n}_{e}": v
                    for n, b in ends.items()
                    for e, v in zip(("low", "high"), b, strict=True)
                },
                **_counted(np.array([found[case] for case in inside])),
                **_better(study, errors, label, inside),
                "study": study.name,
            }


def unseen_of(study: Study) -> set[str]:
    """Cases that a study leaves out of its rules: parameter `part` is ``unseen``."""
    return {case.name for case in study.cases if case.parameters.get("part") == "unseen"}


def points_of(study: Study) -> dict[str, Array]:
    """Features of the columns of a study by case."""
    hits = hits_of(study).items()
    return {name: np.array(list(features(hit).values())) for name, hit in hits}


def hits_of(study: Study) -> dict[str, ColumnImpact]:
    """The impacts on columns of a study, by case."""
    cases = ((case.name, case.scenario) for case in study.cases)
    return {name: each for name, each in cases if isinstance(each, ColumnImpact)}


def leaves_of(
    found: Mapping[str, float], points: Mapping[str, Array], cases: list[str]
) -> list[Leaf]:
    """The tree of a model over some cases."""
    classes = classes_of(np.array([found[case] for case in cases]))
    own = np.array([points[case] for case in cases])
    return list(grow(own, impurity(classes), DEPTH, FEWEST))


def _named(leaf: Leaf) -> dict[str, tuple[float, float]]:
    """Bounds of a region by the name of the feature."""
    return {list(FEATURES)[i]: bounds for i, bounds in leaf.bounds.items()}


def advice_rows(study: Study, tables: Tables) -> Iterator[Row]:
    """The tree that says which model to take: a row for every region, and how it did unseen.

    In a region the model that is within the bound most often is taken, the cheapest of equals.
    Nothing where a study leaves no columns unseen.
    """
    unseen, errors, points = unseen_of(study), errors_of(study, tables), points_of(study)
    costs = {row["label"]: row["ratio"] for row in tables.get("cost", ())}
    labels = sorted(errors, key=lambda label: costs.get(label, inf))
    judged = [case for case in points if any(case in errors[label] for label in labels)]
    cases = [case for case in judged if case not in unseen]
    left = [case for case in judged if case in unseen]
    if not left or len(cases) < LARGE_GROUP:
        return
    hits = np.array([[_within(errors[label], case) for label in labels] for case in cases])

    def missed(members: Indices) -> float:
        return float(len(members) - hits[members].sum(axis=0).max())

    own = np.array([points[case] for case in cases])
    for leaf in grow(own, missed, ADVISED_DEPTH, ADVISED_FEWEST):
        within = hits[leaf.members].sum(axis=0)
        label = labels[int(within.argmax())]
        held = [case for case in left if leaf.holds(points[case])]
        taken = [cases[i] for i in leaf.members if cases[i] in errors[label]]
        counted = _counted(np.array([errors[label][case] for case in taken]))
        yield {
            "region": region_of(_named(leaf)),
            "label": label,
            "within": int(within.max()),
            "median": counted.pop("bias"),
            **counted,
            "count": len(leaf.members),
            "asked": len(held),
            "right": sum(_within(errors[label], case) for case in held),
        }


def _within(found: Mapping[str, float], case: str) -> bool:
    """Whether a model answers a case within the bound; not if it gives no answer."""
    return abs(found.get(case, inf)) <= BEYOND


def checked(study: Study, tables: Tables, unseen: set[str]) -> Iterator[Row]:
    """How often the tree of each model is right on columns that it has not seen."""
    points = points_of(study)
    for label, found in errors_of(study, tables).items():
        cases = [case for case in found if case not in unseen]
        leaves, asked = leaves_of(found, points, cases), [case for case in found if case in unseen]
        classes = classes_of(np.array([found[case] for case in cases]))
        right = 0
        for case in asked:
            leaf = next(leaf for leaf in leaves if leaf.holds(points[case]))
            usual = np.bincount(classes[leaf.members]).argmax()
            right += int(usual == classes_of(np.array([found[case]]))[0])
        yield {"label": label, "asked": len(asked), "right": right}


def ranking_rows(study: Study, tables: Tables) -> Iterator[Row]:
    """A row for every large group and model, the best first, with its pairs against that one."""
    errors = errors_of(study, tables)
    cells = {(row["case"], row["label"]): row["outcome"] for row in tables["cells"]}
    for group, names in study.groups.items():
        if len(names) < LARGE_GROUP:
            continue
        own = {
            label: {case: found[case] for case in names if case in found}
            for label, found in errors.items()
        }
        missed = {label: _missed(by_case, names) for label, by_case in own.items() if by_case}
        order = sorted(missed, key=missed.__getitem__)
        for label in order:
            ended = [cells.get((case, label)) for case in names]
            counted = _counted(np.array(list(own[label].values())))
            yield {
                "group": group,
                "label": label,
                "asked": sum(end is not None for end in ended),
                "judged": counted.pop("count"),
                "within": sum(abs(error) <= BEYOND for error in own[label].values()),
                "median": counted.pop("bias"),
                **counted,
                "refused": ended.count(Outcome.OUT_OF_DOMAIN),
                **_paired(own[order[0]], own[label], order[0]),
            }


def _missed(found: Mapping[str, float], names: tuple[str, ...]) -> tuple[float, float]:
    """By what models are ranked: columns not within the bound, then their median error."""
    sizes = np.abs(list(found.values()))
    return len(names) - float(np.sum(sizes <= BEYOND)), float(np.median(sizes))


def _counted(errors: Array) -> dict[str, Any]:
    """How errors are spread; `bias` is the ratio of the median column that both sides survive."""
    finite = errors[np.isfinite(errors)]
    row: dict[str, Any] = {
        "count": len(errors),
        "low": int(np.sum(errors < -BEYOND)),
        "high": int(np.sum(errors > BEYOND)),
        "falls": int(np.sum(errors == inf)),
        "stands": int(np.sum(errors == -inf)),
    }
    if len(finite):
        least, most = np.percentile(finite, _MIDDLE)
        ends = {"bias": np.median(finite), "least": least, "most": most}
        row |= {name: float(f"{1.0 + value:.4g}") for name, value in ends.items()}
    return row


def _better(study: Study, errors: Errors, label: str, cases: list[str]) -> Row:
    """The model that is off in the fewest of some columns, none if that is the model itself."""

    def off(name: str) -> int:
        return sum(not _within(errors[name], case) for case in cases)

    best = min(errors, key=lambda name: (off(name), name != label))
    if best == label:
        return {"better": ""}
    model = study.models[best]
    words = f"{model.name} {variant_of(model)}".rstrip()
    return {"better": words, "better_count": len(cases), "better_off": off(best)}


def _paired(best: Mapping[str, float], other: Mapping[str, float], name: str) -> Row:
    """In how many of the columns that both answered the best one errs less, and by what chance.

    The sign test: `chance` of as many if both were equal. Ties count for neither.
    """
    both = [(abs(best[case]), abs(other[case])) for case in best if case in other]
    apart = [(a, b) for a, b in both if a != b]
    wins = sum(a < b for a, b in apart)
    row: dict[str, Any] = {"against": name, "pairs": len(apart), "wins": wins}
    if apart:
        row["chance"] = float(f"{binomtest(wins, len(apart), alternative='greater').pvalue:.2g}")
    return row
