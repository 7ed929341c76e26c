"""Scores of the bench: errors against the references, ranks with intervals, collapse, cost.

All cases count that are asked: a refusal, a failure, a missing answer and a wrong verdict on
collapse are errors of 100 %, the largest there is. An error inside the interval of the reference is
none. Ranks are by the mean error; their intervals of 90 % are by drawing the cases anew (bootstrap,
Efron 1979).
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import pandas as pd
from scipy.stats import rankdata

from workbench.base.arrays import Array
from workbench.extras.bench.answers import PEAK, SECONDS, WIDTH
from workbench.extras.bench.cases import FALLS, SURVIVES, BenchCase, ReferenceAnswer
from workbench.study.tables import Row, counts, numbers, tabled, texts

BEYOND = 0.10  # of the reference: a larger error is a miss
DRAWS, SEED, ENDS = 4000, 48, (5.0, 95.0)  # of the bootstrap; percentiles of ranks
SCORES = (
    counts("rank", "rank_low", "rank_high")
    | texts("model")
    | numbers("mean_error")
    | counts("asked", "within", "refused", "failed", "false_safe", "false_alarm", "silent_misses")
    | counts("judged")
    | numbers("median_error", "median_ratio")
    | counts("intervals", "intervals_held")
    | numbers("wall_time_s")
    | counts("common")
    | numbers("common_error", "common_error_of_first")
)


def judged(
    cases: Sequence[BenchCase], known: Mapping[str, ReferenceAnswer], answers: pd.DataFrame
) -> pd.DataFrame:
    """Every series with every case whose reference is `known`: error, loss, verdicts.

    `error` is the answer over the reference less one, where both survive; `loss`, its size beyond
    the interval of the reference, at most 1; `missed`, a loss above 10 % of an answer without a
    warning. Answers in SI, see `read_answers`.
    """
    names = [case.name for case in cases if case.name in known]
    models = list(dict.fromkeys(answers["model"]))
    grid = pd.MultiIndex.from_product([models, names], names=["model", "case"])
    rows = answers.set_index(["model", "case"]).reindex(grid)
    rows["outcome"] = rows["outcome"].fillna("failed")
    groups = {case.name: case.group for case in cases}
    truths = [known[name] for name in names] * len(models)
    truth = np.array([each.peak for each in truths])
    width = np.array([each.half_width for each in truths])
    fallen = np.array([each.outcome == FALLS for each in truths])
    ok, falls = rows["outcome"] == SURVIVES, rows["outcome"] == FALLS
    both = ok & ~fallen
    apart = (rows[PEAK] - truth).abs().where(both)
    truth = np.where(fallen, np.nan, truth)
    loss = ((apart - width).clip(lower=0.0) / truth).clip(upper=1.0)
    rows["group"] = [groups[case] for _, case in grid]
    rows["error"] = rows[PEAK].where(both) / truth - 1.0
    rows["loss"] = loss.where(both, np.where(falls & fallen, 0.0, 1.0))
    rows["false_safe"], rows["false_alarm"] = ok & fallen, falls & ~fallen
    rows["missed"] = (rows["loss"] > BEYOND) & (ok | falls) & (rows["warned"] != "yes")
    rows["stated"] = both & rows[WIDTH].notna()
    rows["held"] = rows["stated"] & (apart <= np.hypot(rows[WIDTH], width))
    return rows.reset_index()


@tabled(SCORES)
def scores(rows: pd.DataFrame) -> Iterator[Row]:
    """A row for every series of `judged`, the best first."""
    losses = rows.pivot_table("loss", "case", "model", sort=False)
    means = losses.mean()
    order = means.sort_values(kind="stable").index
    ranks = rankdata(means, method="min").astype(int)
    places = dict(zip(losses.columns, zip(ranks, *_rank_ends(losses), strict=True), strict=True))
    answers = dict(iter(rows.groupby("model", sort=False)))
    first = answers[order[0]].set_index("case")
    for model in order:
        of = answers[model]
        errors = of["error"].dropna()
        both = of.set_index("case")["error"].notna() & first["error"].notna()
        done = of["outcome"].isin((SURVIVES, FALLS))
        yield {
            **dict(zip(("rank", "rank_low", "rank_high"), places[model], strict=True)),
            **{"model": model, "mean_error": means[model], "asked": len(of)},
            "within": int((of["loss"] <= BEYOND).sum()),
            **{name: int((of["outcome"] == name).sum()) for name in ("refused", "failed")},
            **{name: int(of[name].sum()) for name in ("false_safe", "false_alarm")},
            "silent_misses": int(of["missed"].sum()),
            **{"judged": len(errors), "median_error": errors.abs().median()},
            "median_ratio": 1.0 + errors.median(),
            **{"intervals": int(of["stated"].sum()), "intervals_held": int(of["held"].sum())},
            "wall_time_s": of.loc[done, SECONDS].median(),
            "common": int(both.sum()),
            "common_error": losses[model][both].mean(),
            "common_error_of_first": losses[order[0]][both].mean(),
        }


def _rank_ends(losses: pd.DataFrame) -> Array:
    """Ends (2, models) of the intervals of ranks: by the mean losses of cases that are drawn."""
    rng, count = np.random.default_rng(SEED), len(losses)
    weights = rng.multinomial(count, np.full(count, 1.0 / count), DRAWS) / count
    ranks = rankdata(weights @ losses.to_numpy(), method="min", axis=1)
    ends: Array = np.percentile(ranks, ENDS, axis=0, method="nearest")
    return ends


def by_group(rows: pd.DataFrame) -> pd.DataFrame:
    """A row for every series of `judged`, the best first: cases within the bound by group."""
    within = rows.assign(within=rows["loss"] <= BEYOND)
    table = within.pivot_table("within", "model", "group", aggfunc="sum", sort=False).astype(int)
    order = rows.groupby("model", sort=False)["loss"].mean().sort_values(kind="stable").index
    return table.loc[order].rename_axis(columns=None).reset_index()
