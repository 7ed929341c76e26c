"""Measuring the model form: bias and scatter of every model of a stored study, by region.

The regions were chosen by looking at the columns of `shear_columns`. Hits that bring less than five
times the elastic energy of the column scatter by a rule of their own. Above, V/Vpl decides: a half
and one are bounds that models and report know. Within a region the bias follows a straight line
over V/Vpl, which is steep above one for models without shear. A wide region follows for models
with few columns. A region ends at its lightest striker: where strikers weigh no more than what they
hit at once, peaks hang on the rule for that mass, and columns drawn afterwards lay far outside.
"""

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from itertools import pairwise
from math import floor, inf, log10

import numpy as np

from workbench.arrays import Array
from workbench.assessment.budget import PEAK, RESIDUAL
from workbench.assessment.model_form import BOUNDS, FEWEST, TREND, Trend
from workbench.errors import InputError
from workbench.evidence.descriptors import DEMAND, STRIKER, YIELDING, descriptors, variant_of
from workbench.study.assess import Assessment
from workbench.study.definition import Study
from workbench.study.matrix import against_best, standings_of, telling
from workbench.study.store import Row, Store
from workbench.study.validity import hits_of

_MILD = 5.0
_EDGES = (0.0, 0.5, 1.0, inf)
_WIDE = (0.0, 1.0)
_DIGITS = 3  # to which the sampled ranges are rounded, outwards
_FROM_ZERO = ("axial_over_squash", "axial_over_euler", "restraint_over_axial")
_NEAR_ZERO = 0.01  # of the largest value: those descriptors count as sampled from zero on
COLUMNS = (
    *("model", "model_version", "options", "quantity", "region"),
    *(f"{name}_{end}" for name in BOUNDS for end in ("low", "high")),
    *("held_out", *TREND, "outside", "references", "study", "commits"),
)
RANGE_COLUMNS = ("descriptor", "low", "high")


def model_form_rows(study: Study, found: Assessment) -> Iterator[Row]:
    """A row for every model, quantity and region with enough compared columns.

    A reference is held against better ones only. Wide regions stand in for narrow ones with too
    few columns. Raises `InputError` if the study has no compared impact on a column.
    """
    told = {name: descriptors(hit) for name, hit in hits_of(study).items()}
    standings = standings_of(found.tables)
    pairs = against_best(found.tables, standings)
    if not pairs or not told:
        text = "has no impact on a column that is answered and compared"
        raise InputError("study", study.name, text, "run it first")
    store = Store(found.directory)
    answered = (store.record(row["key"]) for row in found.tables["cells"] if "message" in row)
    commits = sorted({record["provenance"].get("commit", "unknown") for record in answered})
    versions = {row["label"]: row["model_version"] for row in found.tables["cells"]}
    for label, model in study.models.items():
        better = study.ranked[: study.ranked.index(label)] if label in study.ranked else None
        head = {"model": model.name, "model_version": versions[label], "options": variant_of(model)}
        for quantity in (PEAK, RESIDUAL):
            compared = {
                case: pair
                for case in told
                if (pair := telling(pairs, case, label, quantity)) is not None
                and (better is None or standings[case]["label"] in better)
            }
            for region in _filled(told, compared):
                inside = [case for case in compared if _holds(region, told[case])]
                ratios = [compared[c]["value"] / compared[c]["against_value"] for c in inside]
                against = [str(standings[case]["label"]) for case in inside]
                counts = {name: against.count(name) for name in study.ranked if name in against}
                yield {
                    **head,
                    "quantity": quantity,
                    **region,
                    f"{STRIKER}_low": _down(min(told[case][STRIKER] for case in inside)),
                    **_numbers(np.array([told[c][DEMAND] for c in inside]), np.log(ratios)),
                    "outside": sum(not standings[case]["inside"] for case in inside),
                    "references": ", ".join(f"{name} ({n})" for name, n in counts.items()),
                    "study": study.name,
                    "commits": " ".join(commits),
                }


def range_rows(study: Study) -> Iterator[Row]:
    """What the columns of a study span in each descriptor, rounded outwards."""
    sampled = list(map(descriptors, hits_of(study).values()))
    for name in sampled[0]:
        values = [own[name] for own in sampled]
        low, high = _down(min(values)), -_down(-max(values)) + 0.0
        if name in _FROM_ZERO and low < _NEAR_ZERO * high:
            low = 0.0
        yield {"descriptor": name, "low": low, "high": high}


def _filled(told: Mapping[str, dict[str, float]], compared: Mapping[str, Row]) -> Iterator[Row]:
    """The regions with enough columns, the one that counts first."""

    def enough(region: Row) -> bool:
        return sum(_holds(region, told[case]) for case in compared) >= FEWEST

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


def _holds(region: Row, own: dict[str, float]) -> bool:
    return all(region[f"{k}_low"] <= own[k] < region[f"{k}_high"] for k in BOUNDS)


def _numbers(demand: Array, ratios: Array) -> Row:
    """The trend of log ratios, and how many of them the interval of the others holds."""
    held = 0
    for i, own in enumerate(ratios):
        others = trend_of(np.delete(demand, i), np.delete(ratios, i))
        held += bool(abs(own - others.expected(demand[i])) <= others.half_width(demand[i]))
    found = asdict(trend_of(demand, ratios))
    rounded = {name: float(f"{found[name]:.4g}") for name in TREND if name != "count"}
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
