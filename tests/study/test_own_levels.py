"""A study whose reference makes coarser runs of its own: ladder, intervals, gates on the run."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pandas as pd
import pytest
from toy_models import Spring

from workbench.base.errors import InputError
from workbench.models.base import respond
from workbench.models.references.refine import refined
from workbench.study import Case, Gate, Study, assess, run_study

EXACT = 15.0 / (5e6 / 1500.0) ** 0.5


@dataclass(frozen=True)
class Refining:
    """The spring with an error of first order in its mesh."""

    refinement: int = 2
    levels: int = 3
    error: float = 0.08
    yields: float = 0.998

    name: ClassVar[str] = "toy-refining"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = Spring.answers
    assumptions: ClassVar[tuple[str, ...]] = Spring.assumptions
    sources: ClassVar[tuple[str, ...]] = ()

    def domain(self, scenario):
        return []

    def simulate(self, scenario):
        return respond(self, scenario, lambda given: refined(self, given, self._solve))

    def _solve(self, scenario):
        response = Spring(error=self.error, level=self.refinement)._solve(scenario)
        response.attrs["yield_ratio"] = self.yields
        return response


def gate(model: str, against: str, quantity: str, metric: str, bound: float) -> Gate:
    return Gate(model, against, quantity, metric, bound, "why", "where")


@pytest.fixture
def study(thesis_impact) -> Study:
    return Study(
        "own",
        "Own levels",
        "Does a reference know itself?",
        tuple(
            Case(f"v{v}", thesis_impact.at_velocity(v), parameters={"velocity": v})
            for v in (10.0, 15.0, 20.0)
        ),
        {"soft": Spring(stiffness=4.5e6), "beam": Refining(), "alone": Refining(levels=1)},
        "beam",
        gates=(
            gate("soft", "beam", "peak_displacement", "relative_error", 0.1),
            gate("beam", "beam", "peak_displacement", "relative_uncertainty", 0.03),
            gate("beam", "beam", "yield_ratio", "shortfall", 0.001),
            gate("alone", "alone", "peak_displacement", "relative_uncertainty", 0.03),
            gate("soft", "beam", "displacement", "sprague_geers_magnitude", 0.2),
            gate("soft", "beam", "velocity", "residual_mean", 0.2),
        ),
    )


def tables_of(study: Study, root: Path) -> dict[str, pd.DataFrame]:
    run_study(study, root, jobs=0)
    assess(study, root)
    names = ("ladder", "comparisons", "gates", "bias")
    return {name: pd.read_csv(root / study.name / "tables" / f"{name}.csv") for name in names}


def test_tables_and_gates(study: Study, tmp_path: Path) -> None:
    tables = tables_of(study, tmp_path)
    ladder = tables["ladder"].set_index(["case", "quantity"]).loc["v15.0", "peak_displacement"]
    assert list(ladder[["4 h", "2 h", "h"]]) == pytest.approx(
        [1.08 * EXACT, 1.04 * EXACT, 1.02 * EXACT]
    )
    assert ladder["order"] == pytest.approx(1.0)
    assert ladder["uncertainty"] == pytest.approx(1.25 * 0.02 * EXACT)
    rows = tables["comparisons"].set_index(["case", "model", "quantity", "metric"]).sort_index()
    soft = rows.loc["v15.0", "soft", "peak_displacement", "relative_error"]
    ratio = (5.0 / 4.5) ** 0.5
    assert soft["uncertainty"] == pytest.approx(ratio * 0.025 / 1.02**2, rel=1e-9)
    shape = rows.loc["v15.0", "soft", "displacement", "sprague_geers_magnitude"]
    assert shape["uncertainty"] == pytest.approx(0.025, rel=0.2)
    verdicts = list(tables["gates"].drop_duplicates(["gate"])["verdict"])
    assert verdicts == ["pass", "pass", "fail", "inconclusive", "pass", "inconclusive"]
    notes = list(tables["gates"].drop_duplicates(["gate"])["note"])
    assert "observed order 1.00" in notes[0]
    assert notes[2] == "a number about the run itself"
    assert "levels = 1" in notes[3] or "no numerical uncertainty" in notes[3]
    assert "keeps no velocity of its coarser runs" in notes[5]


def test_the_bias_holds_what_the_reference_leaves_open(study: Study, tmp_path: Path) -> None:
    result = tables_of(study, tmp_path)["bias"].set_index(["model", "quantity"])
    row = result.loc["soft", "peak_displacement"]
    ratio = (5.0 / 4.5) ** 0.5 / 1.02
    assert row["bias"] == pytest.approx(ratio)
    # the cases do not scatter: all of the interval is the numerical uncertainty of the reference
    assert row["uncertainty"] == pytest.approx(0.025 / 1.02, rel=1e-9)
    assert row["low"] == pytest.approx(ratio * (1.0 - row["uncertainty"]), rel=1e-6)
    assert row["high"] == pytest.approx(ratio * (1.0 + row["uncertainty"]), rel=1e-6)
    alone = result.loc["alone", "peak_displacement"]
    assert alone["note"].endswith("numerical uncertainty unknown in 3 of 3 cases")


def test_uncertainties_of_a_history_on_both_sides_add_in_quadrature(study, tmp_path) -> None:
    pair = {"beam": Refining(), "other": Refining(error=0.04)}
    both = dataclasses.replace(study, models={**study.models, **pair}, gates=())
    rows = tables_of(both, tmp_path)["comparisons"]
    rows = rows[(rows["case"] == "v15.0") & (rows["metric"] == "sprague_geers_magnitude")]
    widths = rows[rows["against"] == "beam"].set_index("model")["uncertainty"]
    # the error of half the size leaves half as much: 0.0125 of its own beside 0.025
    assert widths["other"] == pytest.approx(5**0.5 / 2.0 * widths["soft"], rel=0.1)


def test_metrics_of_a_run_take_one_label(study: Study, tmp_path: Path) -> None:
    wrong = gate("soft", "beam", "yield_ratio", "shortfall", 0.1)
    with pytest.raises(InputError, match=r"gate\.against.*must be soft as well"):
        run_study(dataclasses.replace(study, gates=(wrong,)), tmp_path, jobs=0)
