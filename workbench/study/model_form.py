"""Measuring the model form: bias and scatter of every model of a stored study, by region.

The regions were chosen by looking at the columns of `shear_columns`. Hits that bring less than five
times the elastic energy of the column scatter by a rule of their own. Above, V/Vpl decides: a half
and one are bounds that models and report know. Within a region the bias follows a straight line
over V/Vpl, which is steep above one for models without shear. A wide region follows for models
with few columns. A region ends at its lightest striker: where strikers weigh no more than what they
hit at once, peaks hang on the rule for that mass, and columns drawn afterwards lay far outside.
"""

from collections.abc import Iterator
from dataclasses import asdict
from itertools import pairwise
from math import floor, inf, log10, nan

import numpy as np
import pandas as pd

from workbench.arrays import Array
from workbench.assessment.budget import BOUNDS, FEWEST, PEAK, RESIDUAL, TREND, Trend
from workbench.errors import InputError
from workbench.evidence.descriptors import DEMAND, STRIKER, YIELDING, descriptors, variant_of
from workbench.study.assess import Assessment
from workbench.study.definition import Study
from workbench.study.matrix import against_governing, governing_references, telling
from workbench.study.store import NOT_RUN, Store
from workbench.study.tables import Row, counts, numbers, texts
from workbench.study.validity import hits_of

_MILD = 5.0
_EDGES = (0.0, 0.5, 1.0, inf)
_WIDE = (0.0, 1.0)
_DIGITS = 3  # to which the sampled ranges are rounded, outwards
_FROM_ZERO = ("axial_over_squash", "axial_over_euler", "restraint_over_axial")
_NEAR_ZERO = 0.01  # of the largest value: those descriptors count as sampled from zero on
COLUMNS = (
    texts("model")
    | counts("model_version")
    | texts("options", "quantity", "region")
    | numbers(*(f"{name}_{end}" for name in BOUNDS for end in ("low", "high")))
    | counts("held_out")
    | {name: 0 if name == "count" else nan for name in TREND}
    | counts("outside")
    | texts("references", "study", "commits")
)
RANGE_COLUMNS = texts("descriptor") | numbers("low", "high")


def model_form_rows(study: Study, assessed: Assessment) -> Iterator[Row]:
    """A row for every model, quantity and region with enough compared columns.

    A reference is held against better ones only. Wide regions stand in for narrow ones with too
    few columns. Raises `InputError` if the study has no compared impact on a column.
    """
    hits = pd.DataFrame({name: descriptors(hit) for name, hit in hits_of(study).items()}).T
    governing = governing_references(assessed.tables)
    pairs = against_governing(assessed.tables)
    if pairs.empty or hits.empty:
        text = "has no impact on a column that is answered and compared"
        raise InputError("study", study.name, text, "run it first")
    store, cells = Store(assessed.directory), assessed.tables["cells"]
    answered = map(store.record, cells.loc[cells["outcome"] != NOT_RUN, "key"])
    commits = sorted({record["provenance"].get("commit", "unknown") for record in answered})
    versions = dict(zip(cells["label"], cells["model_version"], strict=True))
    for label, model in study.models.items():
        better = study.ranked[: study.ranked.index(label)] if label in study.ranked else None
        head = {"model": model.name, "model_version": versions[label], "options": variant_of(model)}
        for quantity in (PEAK, RESIDUAL):
            compared = telling(pairs, label, quantity)
            compared = compared[compared.index.isin(hits.index)]
            if better is not None:
                compared = compared[compared["against"].isin(better)]
            drawn = hits.loc[compared.index]
            for region in _filled(drawn):
                inside = _holds(region, drawn)
                of_region, demand = compared[inside], drawn.loc[inside, DEMAND].to_numpy()
                ratios = np.log((of_region["value"] / of_region["against_value"]).to_numpy())
                held = of_region["against"].value_counts()
                counted = {name: held[name] for name in study.ranked if name in held}
                yield {
                    **head,
                    "quantity": quantity,
                    **region,
                    f"{STRIKER}_low": _down(drawn.loc[inside, STRIKER].min()),
                    **_numbers(demand, ratios),
                    "outside": (governing["inside"].loc[of_region.index] == 0).sum(),
                    "references": ", ".join(f"{name} ({n})" for name, n in counted.items()),
                    "study": study.name,
                    "commits": " ".join(commits),
                }


def range_rows(study: Study) -> Iterator[Row]:
    """What the columns of a study span in each descriptor, rounded outwards."""
    sampled = pd.DataFrame(map(descriptors, hits_of(study).values()))
    for name, values in sampled.items():
        low, high = _down(values.min()), -_down(-values.max()) + 0.0
        if name in _FROM_ZERO and low < _NEAR_ZERO * high:
            low = 0.0
        yield {"descriptor": name, "low": low, "high": high}


def _filled(drawn: pd.DataFrame) -> Iterator[Row]:
    """The regions with enough of the columns, the one that counts first."""

    def enough(region: Row) -> bool:
        return int(_holds(region, drawn).sum()) >= FEWEST

    mild = _region("hits that hardly yield", (0.0, inf), (0.0, _MILD))
    narrow = {edges: _sheared(*edges) for edges in pairwise(_EDGES)}
    yield from filter(enough, [mild, *narrow.values()])
    if not all(enough(region) for edges, region in narrow.items() if edges[1] <= _WIDE[1]):
        yield from filter(enough, [_sheared(*_WIDE)])


def _sheared(low: float, high: float) -> Row:
    words = f"{low:g} to {high:g}" if low else f"below {high:g}"
    return _region(f"V/Vpl {words if high < inf else f'above {low:g}'}", (low, high))


def _region(
    name: str, demand: tuple[float, float], yielding: tuple[float, float] = (_MILD, inf)
) -> Row:
    bounds = {DEMAND: demand, YIELDING: yielding, STRIKER: (0.0, inf)}
    ends = {f"{k}_{end}": v[i] for k, v in bounds.items() for i, end in enumerate(("low", "high"))}
    return {"region": name, **ends}


def _holds(region: Row, drawn: pd.DataFrame) -> pd.Series:
    """Which of the columns, by their descriptors, lie in a region."""
    inside = pd.Series(True, index=drawn.index)
    for name in BOUNDS:
        inside &= (region[f"{name}_low"] <= drawn[name]) & (drawn[name] < region[f"{name}_high"])
    return inside


def _numbers(demand: Array, ratios: Array) -> Row:
    """The trend of log ratios, and how many of them the interval of the others holds."""
    held = 0
    for i, ratio in enumerate(ratios):
        others = trend_of(np.delete(demand, i), np.delete(ratios, i))
        held += bool(abs(ratio - others.expected(demand[i])) <= others.half_width(demand[i]))
    trend = asdict(trend_of(demand, ratios))
    rounded = {name: float(f"{trend[name]:.4g}") for name in TREND if name != "count"}
    return {"count": len(ratios), "held_out": held, **rounded}


def trend_of(demand: Array, ratios: Array) -> Trend:
    """The straight line through log `ratios` over V/Vpl, the `demand`."""
    centre = float(np.mean(demand))
    away = demand - centre
    spread = float(np.sqrt(away @ away))
    slope = float(away @ ratios) / spread**2
    rest = ratios - np.mean(ratios) - slope * away
    scatter = float(np.sqrt(rest @ rest / (len(ratios) - 2)))
    return Trend(len(ratios), float(np.exp(np.mean(ratios))), slope, scatter, centre, spread)


def _down(value: float) -> float:
    """The next lower number of few digits."""
    if value == 0.0:
        return 0.0
    step = 10.0 ** (floor(log10(abs(value))) - _DIGITS + 1)
    return float(f"{floor(value / step) * step:.{_DIGITS}g}")
