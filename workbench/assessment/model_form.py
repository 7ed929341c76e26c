"""Model form: how far a model was off in columns like this one, as the shipped studies measured it.

`workbench data measure` writes the table from a stored study, `study/model_form` says how. A row
holds the trend over V/Vpl and the scatter of the log ratio of a model to the best reference in the
columns of a region; regions are told apart by what a scenario says before anything is run. Outside
what was sampled nothing is known, and nothing is extrapolated.
"""

from dataclasses import dataclass, fields
from functools import lru_cache
from math import expm1, log, sqrt
from typing import Any

from workbench.assessment.budget import COVERAGE, MODEL_FORM, Term
from workbench.evidence import dataset, load
from workbench.evidence.descriptors import (
    DEMAND,
    STRIKER,
    YIELDING,
    beyond,
    descriptors,
    variant_of,
)
from workbench.models.base import Model
from workbench.scenarios import ColumnImpact

TABLE, RANGES = "model-form", "model-form-ranges"
FEWEST = 6  # columns of a region
BOUNDS = (DEMAND, YIELDING, STRIKER)  # descriptors that tell regions apart


@dataclass(frozen=True, slots=True)
class Trend:
    """A straight line through log ratios of a region over V/Vpl, fitted by least squares.

    `bias`, the ratio at the `centre` of the V/Vpl of `count` columns, `slope` of the log ratio;
    `scatter`, its standard deviation about the line; `spread`, the root of the summed squares of
    the distances to the centre.
    """

    count: int
    bias: float
    slope: float
    scatter: float
    centre: float
    spread: float

    def expected(self, demand: float) -> float:
        """The log ratio of a new column."""
        return log(self.bias) + self.slope * (demand - self.centre)

    def half_width(self, demand: float) -> float:
        """Half-width of the interval in which the log ratio of a new column lies."""
        from scipy.stats import t as student

        quantile = float(student.ppf(0.5 * (1.0 + COVERAGE), self.count - 2))
        away = (demand - self.centre) / self.spread
        return quantile * self.scatter * sqrt(1.0 + 1.0 / self.count + away**2)


TREND = tuple(f.name for f in fields(Trend))


def model_form(model: Model, scenario: ColumnImpact, quantity: str) -> Term:
    """What the model form leaves open in a quantity: a prediction interval for a new column.

    The reference is expected where the measured trend puts it.
    """
    title = dataset(TABLE).title
    own = descriptors(scenario)
    outside = beyond(own, RANGES)
    if outside:
        text = f"not measured here: {', '.join(outside)} outside the columns of the study"
        return Term(MODEL_FORM, text, title, 0.0, None, None)
    variant = variant_of(model)
    for row in _rows():
        same = (row["model"], row["options"], row["quantity"]) == (model.name, variant, quantity)
        if same and all(row[f"{name}_low"] <= own[name] < row[f"{name}_high"] for name in BOUNDS):
            trend = Trend(**{name: row[name] for name in TREND})
            off, width = trend.expected(own[DEMAND]), trend.half_width(own[DEMAND])
            source = f"study {row['study']}"
            return Term(MODEL_FORM, _said(row, off, model), source, -off, width, width)
    text = f"not measured here: the study has no {model.name} {variant}".rstrip()
    text += f" with {quantity.replace('_', ' ')} in such columns"
    return Term(MODEL_FORM, text, title, 0.0, None, None)


def _said(row: dict[str, Any], expected: float, model: Model) -> str:
    """Where the numbers of a row are from, and by how much the model is off, in words."""
    off = 100.0 * expm1(expected)
    bias = f"{abs(off):.0f} % {'low' if off < 0 else 'high'}" if abs(off) >= 0.5 else "no bias"
    text = f"{bias}, scatter {100.0 * row['scatter']:.0f} %"
    text += f", {row['count']} columns, {row['region']}"
    if row["outside"]:
        text += f"; {row['outside']} of the references outside their domain"
    if row["model_version"] != model.version:
        text += f"; measured with version {row['model_version']} of the model"
    return text


@lru_cache(maxsize=1)
def _rows() -> tuple[dict[str, Any], ...]:
    table = load(TABLE).fillna({"options": ""})
    return tuple({str(name): v for name, v in row.items()} for row in table.to_dict("records"))
