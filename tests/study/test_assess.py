from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pandas as pd
import pytest
from toy_models import Spring, Troubled

from workbench.base.errors import InputError
from workbench.base.tables import plain_rows
from workbench.models.base import respond
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.single_dof import SingleDof
from workbench.responses import Finding, Response, build_response
from workbench.scenarios import ColumnImpact, ColumnPushover, Scenario
from workbench.study import Case, Gate, Store, Study, assess, cells_of, run_study, survey
from workbench.study.assessment import METRICS, Scope
from workbench.study.tables import (
    counts,
    csv_bytes,
    lists,
    numbers,
    read_table,
    table,
    texts,
    write_table,
)

V15_PEAK = 15.0 / (5e6 / 1500.0) ** 0.5  # of the exact spring, v0 / omega


@dataclass(frozen=True)
class Data:
    """A published peak with a reading uncertainty."""

    peak: float = V15_PEAK
    width: float = 0.002

    name: ClassVar[str] = "toy-data"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = ("Read from a figure.",)
    sources: ClassVar[tuple[str, ...]] = ()

    def domain(self, scenario: Scenario) -> list[Finding]:
        known = scenario.striker.velocity == 15.0
        return [] if known else [Finding("published", "not published for this case", True)]

    def simulate(self, scenario: Scenario) -> Response:
        return respond(self, scenario, self._solve)

    def _solve(self, scenario: Scenario) -> Response:
        response = build_response({"peak_displacement": self.peak})
        response.attrs["data_uncertainty"] = json.dumps({"peak_displacement": self.width})
        return response


def gate(model: str, against: str, bound: float, **more: object) -> Gate:
    settings = {"quantity": "peak_displacement", "metric": "relative_error", **more}
    return Gate(model, against, bound=bound, rationale="why", source="where", **settings)


def assessed(study: Study, root: Path) -> tuple[Study, dict[str, pd.DataFrame]]:
    run_study(study, root, jobs=0)
    assess(study, root)
    directory = root / study.name / "tables"
    names = ("cells", "findings", "comparisons", "ladder", "gates")
    return study, {name: pd.read_csv(directory / f"{name}.csv") for name in names}


def test_the_ladder_of_a_first_order_error_is_found(toy_study: Study, tmp_path: Path) -> None:
    _, tables = assessed(toy_study, tmp_path)
    rows = tables["ladder"].set_index(["case", "quantity"])
    row = rows.loc["v15.0", "peak_displacement"]
    assert row["coarse"] == pytest.approx(1.08 * V15_PEAK, rel=1e-14)
    assert row["fine"] == pytest.approx(1.02 * V15_PEAK, rel=1e-14)
    assert row["order"] == pytest.approx(1.0, abs=1e-9)
    assert row["extrapolated"] == pytest.approx(V15_PEAK, rel=1e-9)
    assert row["uncertainty"] == pytest.approx(1.25 * 0.02 * V15_PEAK, rel=1e-9)
    assert len(rows) == 9
    assert rows.loc["v15.0", "residual_displacement"]["note"].startswith("residual_displacement is")


def test_a_comparison_carries_the_uncertainty_of_the_reference(
    toy_study: Study, tmp_path: Path
) -> None:
    _, tables = assessed(toy_study, tmp_path)
    rows = tables["comparisons"].set_index(["case", "model", "quantity", "metric"]).sort_index()
    row = rows.loc["v15.0", "soft", "peak_displacement", "relative_error"]
    ratio = np.sqrt(5.0 / 4.0) / 1.02
    assert row["against"] == "fine"
    assert row["velocity"] == 15.0
    assert row["error"] == pytest.approx(ratio - 1.0, rel=1e-9)
    assert row["value"] / row["against_value"] == pytest.approx(ratio, rel=1e-12)
    # d(S/D) = S/D u_D/D with u_D = 1.25 * 0.02 of the exact, D = 1.02 of it
    assert row["uncertainty"] == pytest.approx(ratio * 0.025 / 1.02, rel=1e-9)
    assert row["note"].startswith("ladder of fine: observed order 1.00")


def test_history_metrics_get_the_ladder_of_the_metric(toy_study: Study, tmp_path: Path) -> None:
    study = dataclasses.replace(toy_study, models={**toy_study.models, "soft": Spring()})
    _, tables = assessed(study, tmp_path)
    rows = tables["comparisons"].set_index(["case", "model", "quantity", "metric"]).sort_index()
    row = rows.loc["v15.0", "soft", "displacement", "sprague_geers_magnitude"]
    # the reference is 2 % too high throughout: M = 1/1.02 - 1; its levels are 1/(1 + 0.08/2^k) - 1
    assert row["error"] == pytest.approx(1.0 / 1.02 - 1.0, rel=1e-9)
    values = [1.0 / (1.0 + 0.08 * 0.5**k) - 1.0 for k in range(3)]
    order = np.log2((values[1] - values[0]) / (values[2] - values[1]))
    assert row["uncertainty"] == pytest.approx(
        1.25 * (values[2] - values[1]) / (2.0**order - 1.0), rel=1e-6
    )
    assert np.isnan(row["value"])
    metrics = set(rows.loc["v15.0", "soft", "displacement"].index)
    assert metrics == {name for name, m in METRICS.items() if m.scope is Scope.HISTORY}


def test_pushovers_are_compared_as_curves(toy_study: Study, tmp_path: Path) -> None:
    column = toy_study.cases[0].scenario.column
    push = Case("push", ColumnPushover("push", column=column, displacement=0.1))
    study = dataclasses.replace(toy_study, cases=(push,))
    _, tables = assessed(study, tmp_path)
    rows = tables["comparisons"].set_index(["model", "quantity", "metric"])
    row = rows.loc["soft", "force", "area_difference"]
    assert row["error"] == pytest.approx(1.0 - 4.0 / (5.0 * 1.02), rel=1e-9)
    assert row["uncertainty"] > 0.0
    assert set(tables["comparisons"]["metric"]) == {
        name for name, m in METRICS.items() if m.scope is Scope.CURVE
    }


def test_data_against_the_reference_and_against_a_reduced_model(
    toy_study: Study, tmp_path: Path
) -> None:
    models = {**toy_study.models, "paper": Data()}
    study = dataclasses.replace(toy_study, models=models, quick_models=())
    _, tables = assessed(study, tmp_path)
    rows = tables["comparisons"].set_index(["case", "model", "against", "quantity"])
    both = rows.loc[("v15.0", "fine", "paper", "peak_displacement")]
    error, uncertainty = float(both["error"]), float(both["uncertainty"])
    assert error == pytest.approx(0.02, rel=1e-9)
    # V&V 20: numerical part u_S/D = 1.25 * 0.02; data part S/D u_D/D
    assert uncertainty == pytest.approx(np.hypot(0.025, 1.02 * 0.002 / V15_PEAK), rel=1e-9)
    reduced = rows.loc[("v15.0", "soft", "paper", "peak_displacement")]
    ratio = np.sqrt(5.0 / 4.0)
    assert float(reduced["uncertainty"]) == pytest.approx(ratio * 0.002 / V15_PEAK, rel=1e-9)
    assert "uncertainty of the data" in reduced["note"]
    assert ("v10.0", "soft", "paper", "peak_displacement") not in rows.index
    cells = tables["cells"].set_index(["case", "label"])
    assert cells.loc[("v10.0", "paper"), "outcome"] == "out-of-domain"
    assert "not published for this case" in cells.loc[("v10.0", "paper"), "message"]


def test_gates_end_in_pass_fail_or_inconclusive(toy_study: Study, tmp_path: Path) -> None:
    models = {
        **toy_study.models,
        "stuck": Troubled("solver", above=12.0),
        "paper": Data(),
        "alone": Spring(),
    }
    gates = (
        gate("soft", "fine", 0.2),  # 9.6 % +- 2.7 %: pass
        gate("soft", "fine", 0.05),  # the same name, another bound: fail
        gate("soft", "fine", 0.1),  # straddles
        gate("stuck", "fine", 1e3),  # no answer in two cases
        gate("soft", "paper", 0.5),  # only one case is published
        gate("soft", "fine", 0.5, cases=("v10.0",)),
        gate("soft", "fine", 0.5, quantity="residual_displacement"),
        gate("stuck", "paper", 0.5, cases=("v10.0",)),
        gate("soft", "alone", 0.02, metric="sprague_geers_comprehensive", quantity="displacement"),
    )
    study = dataclasses.replace(toy_study, models=models, gates=gates, quick_models=())
    run_study(study, tmp_path, jobs=0)
    result = assess(study, tmp_path)
    verdicts = [outcome.verdict.value for outcome in result.verdicts]
    assert verdicts == [
        *("pass", "fail", "inconclusive", "inconclusive", "inconclusive", "pass"),
        *("inconclusive", "inconclusive", "fail"),
    ]
    assert result.failed
    first, stuck, paper = (result.verdicts[i] for i in (0, 3, 4))
    assert first.critical is not None
    assert first.critical.value == pytest.approx(np.sqrt(1.25) / 1.02 - 1.0, rel=1e-9)
    assert first.counts == {
        **{"asked": 3, "pass": 3},
        **dict.fromkeys(("fail", "inconclusive", "refused", "unanswered", "collapses"), 0),
    }
    assert (stuck.counts["pass"], stuck.counts["unanswered"]) == (1, 2)
    assert stuck.reasons[0].startswith(
        "no answer in 2 of 3 asked cases: v15.0 (stuck: not-converged, "
    )
    assert (paper.counts["pass"], paper.counts["refused"]) == (1, 2)
    table = pd.read_csv(tmp_path / "toy" / "tables" / "gates.csv")
    assert list(table.groupby("number").size()) == [3, 3, 3, 3, 3, 1, 3, 1, 3]
    notes = table.set_index(["number", "case"])["note"]
    assert "stuck: not-converged" in notes[4, "v15.0"]
    assert notes[8, "v10.0"] == "paper: out-of-domain, not published for this case"


def test_survival_against_collapse_fails_and_collapse_on_both_sides_agrees(
    toy_study: Study, tmp_path: Path
) -> None:
    models = {
        **toy_study.models,
        "collapsing": Troubled("collapse", above=18.0),
        "too": Troubled("collapse", above=17.0),
        "cautious": Troubled("refuse"),
        "open": Troubled("no peak", above=18.0),
    }
    lenient = gate("collapsing", "fine", 1e3)
    last = dataclasses.replace(lenient, cases=("v20.0",))
    study = dataclasses.replace(
        toy_study,
        models=models,
        gates=(
            *(lenient, dataclasses.replace(lenient, cases=("v10.0", "v15.0"))),
            dataclasses.replace(last, against="too"),
            *(dataclasses.replace(last, against=name) for name in ("cautious", "open")),
            dataclasses.replace(last, against="collapsing", metric="relative_uncertainty"),
        ),
        quick_models=(),
    )
    summary = run_study(study, tmp_path, jobs=0)
    assert (summary.failed, summary.outcomes["collapse"]) == (0, 2)
    result = assess(study, tmp_path)
    whole, _, both, refused, undecided, alone = result.verdicts
    assert result.failed
    assert [outcome.verdict.value for outcome in result.verdicts] == [
        *("fail", "pass", "pass", "inconclusive", "inconclusive", "inconclusive")
    ]
    assert (whole.counts["fail"], whole.counts["collapses"], whole.counts["refused"]) == (1, 1, 0)
    (reason,) = whole.reasons
    assert reason == (
        "one side collapses and the other survives in 1 of 3 asked cases: v20.0 (collapsing: "
        "collapse at 0.02 s and 0.5 m (geometry, below); fine survives)"
    )
    critical = whole.critical  # no number reaches as far
    assert (critical.case, critical.value, critical.collapsed) == ("v20.0", None, ("collapsing",))
    assert both.critical.collapsed == ("collapsing", "too")
    assert both.reasons[0].startswith("both sides collapse, which passes without a number, in 1")
    assert refused.counts["refused"] == 1
    assert "ends before its peak and may still collapse" in undecided.reasons[0]
    assert alone.counts["inconclusive"] == 1
    cells = pd.read_csv(tmp_path / "toy" / "tables" / "cells.csv").set_index(["case", "label"])
    row = cells.loc["v20.0", "collapsing"]
    assert row["outcome"] == "collapse"
    assert (row["collapse_mechanism"], row["collapse_parts"]) == ("geometry", '["below"]')
    assert (row["collapse_time"], row["collapse_displacement"]) == (0.02, 0.5)
    assert cells.loc["v20.0", "fine"].filter(like="collapse_").isna().all()
    assert {e.state for e in survey(study, cells_of(study), Store(tmp_path / "toy"))} == {
        *("done", "failed")
    }
    # a case that the study does not ask of a label is not asked by the gate
    cases = tuple(
        dataclasses.replace(case, models=("soft", "fine") if case.name == "v20.0" else ())
        for case in study.cases
    )
    unsupported, *_ = assess(dataclasses.replace(study, cases=cases), tmp_path).verdicts
    assert (unsupported.verdict, unsupported.counts["asked"]) == ("pass", 2)


def test_the_car_park_column_that_only_the_single_dof_lets_survive(
    parked: ColumnImpact, tmp_path: Path
) -> None:
    impact = dataclasses.replace(parked, duration=0.2)
    compared = {"quantity": "peak_displacement", "metric": "relative_error", "bound": 0.3}
    values = {"rationale": "why", "source": "where"}
    study = Study(
        name="car-park",
        title="Car park",
        question="Does the column stand?",
        cases=tuple(Case(f"{v:g} m/s", impact.at_velocity(v)) for v in (5.0, 8.0, 10.0)),
        models={
            "4-DOF": FourDof(),
            "SDOF": SingleDof(resistance="cubic"),
            "panels": FourDofShear(),
        },
        reference="4-DOF",
        gates=(
            Gate("SDOF", "4-DOF", **compared, **values),
            Gate("panels", "4-DOF", **compared, cases=("10 m/s",), **values),
        ),
    )
    run_study(study, tmp_path, jobs=0)
    result = assess(study, tmp_path)
    simple, panels = result.verdicts
    assert (simple.verdict, panels.verdict) == ("fail", "pass")
    assert simple.critical.case == "10 m/s"
    assert simple.critical.collapsed == ("4-DOF",)
    assert simple.counts["fail"] == 1
    assert panels.critical.collapsed == ("panels", "4-DOF")


def test_gates_that_differ_only_in_their_cases_are_two(toy_study: Study, tmp_path: Path) -> None:
    gates = tuple(gate("soft", "fine", 0.2, cases=(case,)) for case in ("v10.0", "v15.0"))
    study = dataclasses.replace(toy_study, gates=gates)
    run_study(study, tmp_path, jobs=0)
    assessment = assess(study, tmp_path)
    assert [each.number for each in assessment.verdicts] == [1, 2]
    table = pd.read_csv(tmp_path / "toy" / "tables" / "verdicts.csv")
    assert list(table["case"]) == ["v10.0", "v15.0"]
    assert list(table["verdict"]) == ["pass", "pass"]


def test_without_a_ladder_nothing_passes(toy_study: Study, tmp_path: Path) -> None:
    study = dataclasses.replace(toy_study, ladder=(), gates=(gate("soft", "fine", 0.2),))
    run_study(study, tmp_path, jobs=0)
    result = assess(study, tmp_path)
    assert result.verdicts[0].verdict == "inconclusive"
    assert "no refinement ladder" in result.verdicts[0].cases[0].note
    strict = dataclasses.replace(study, gates=(gate("soft", "fine", 0.01),))
    assert assess(strict, tmp_path).failed


def test_a_broken_level_shortens_the_ladder(toy_study: Study, tmp_path: Path) -> None:
    models = {**toy_study.models, "coarse": Troubled("solver")}
    study = dataclasses.replace(toy_study, models=models)
    _, tables = assessed(study, tmp_path)
    row = tables["ladder"].set_index(["case", "quantity"]).loc["v15.0", "peak_displacement"]
    assert np.isnan(row["coarse"])
    assert row["note"].startswith("two levels only")
    assert row["uncertainty"] == pytest.approx(3.0 * 0.02 * V15_PEAK, rel=1e-9)
    models = {**toy_study.models, "middle": Troubled("solver")}
    _, tables = assessed(dataclasses.replace(toy_study, models=models), tmp_path)
    row = tables["ladder"].set_index(["case", "quantity"]).loc["v15.0", "peak_displacement"]
    assert np.isnan(row["uncertainty"])
    assert row["note"].startswith("middle: not-converged")


def test_answers_that_memory_does_not_hold_are_read_again(
    toy_study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_study(toy_study, tmp_path, jobs=0)
    whole = assess(toy_study, tmp_path)
    monkeypatch.setattr("workbench.study.assessor.MOST", 0)
    again = assess(toy_study, tmp_path)
    assert (len(whole.responses), len(again.responses)) == (12, 0)
    assert whole.verdicts == again.verdicts
    for name, frame in whole.tables.items():
        pd.testing.assert_frame_equal(again.tables[name], frame)


def test_an_assessment_reads_the_store_only(
    toy_study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(InputError, match="no stored cells yet; run it first"):
        assess(toy_study, tmp_path)
    run_study(toy_study, tmp_path, jobs=0, only="v1*")

    def forbidden(*arguments: object) -> None:
        raise AssertionError("an assessment must not simulate")

    monkeypatch.setattr(Spring, "simulate", forbidden)
    result = assess(toy_study, tmp_path)
    tables = tmp_path / "toy" / "tables"
    first = {path.name: path.read_bytes() for path in tables.iterdir()}
    assert {Path(name).with_suffix(".csv").name for name in first if name.endswith(".nc")} == {
        name for name in first if name.endswith(".csv")
    }
    assert {name for name in first if name.endswith(".csv")} == {
        "budget.csv",
        "cells.csv",
        "findings.csv",
        "comparisons.csv",
        "ladder.csv",
        "gates.csv",
        "verdicts.csv",
        "bias.csv",
        "references.csv",
        "validation.csv",
        "matrix.csv",
        "cost.csv",
        "ranking.csv",
        "error-cells.csv",
        "coverage.csv",
        "chooser.csv",
    }
    outcomes = list(result.tables["cells"]["outcome"])
    assert outcomes == ["ok"] * 8 + ["not run"] * 4
    assess(toy_study, tmp_path)
    assert {path.name: path.read_bytes() for path in tables.iterdir()} == first


def test_the_cells_table(toy_study: Study, tmp_path: Path) -> None:
    models = {**toy_study.models, "soft": Spring(stiffness=5e4)}
    study, tables = assessed(dataclasses.replace(toy_study, models=models), tmp_path)
    row = tables["cells"].set_index(["case", "label"]).loc["v10.0", "soft"]
    findings = tables["findings"].set_index(["case", "label"]).loc[("v10.0", "soft")]
    assert (findings["subject"], findings["severity"], findings["sentence"]) == (
        "stiffness", "warning", "very soft",
    )  # fmt: skip
    assert row["model"] == "toy-spring"
    assert row["energy_error"] < 1e-14
    assert row["wall_time"] > 0.0
    assert row["velocity"] == 10.0
    assert row["key"] == cells_of(study)[0].key
    stored = Store(tmp_path / "toy").response(row["key"])
    assert row["peak_displacement"] == stored["peak_displacement"].item()  # all digits


def test_bad_studies_are_refused(toy_study: Study, tmp_path: Path) -> None:
    run_study(toy_study, tmp_path, jobs=0)
    gates = (gate("soft", "fine", 0.1, metric="relative"),)
    with pytest.raises(InputError, match=r"gate\.metric.*relative_error"):
        dataclasses.replace(toy_study, gates=gates)
    cases = tuple(dataclasses.replace(c, parameters={"value": 1}) for c in toy_study.cases)
    with pytest.raises(InputError, match="is the name of a column"):
        assess(dataclasses.replace(toy_study, cases=cases), tmp_path)


def test_a_metric_of_scalars_needs_a_rule_for_its_uncertainty() -> None:
    with pytest.raises(TypeError, match="rule for their uncertainty"):
        dataclasses.replace(METRICS["difference"], spread=None)


@pytest.mark.parametrize("metric", [n for n, m in METRICS.items() if m.scope is Scope.SCALAR])
def test_the_rules_are_derivatives(metric: str) -> None:
    s, d, u = 1.3, 1.1, 1e-6

    def value(a: float, b: float) -> float:
        return METRICS[metric](
            build_response({"impulse": a}), build_response({"impulse": b}), "impulse"
        )

    by_model = (value(s + u, d) - value(s - u, d)) / 2.0
    by_data = (value(s, d + 2 * u) - value(s, d - 2 * u)) / 2.0
    width = METRICS[metric].half_width(s, d, u, 2 * u)
    assert width == pytest.approx(np.hypot(by_model, by_data), rel=1e-5)


def test_csv_keeps_all_digits_and_quotes_texts() -> None:
    row = {"a": np.float64(0.1) + 0.2, "b": 'x, "y"', "c": None, "d": True, "e": ["é", 'z"']}
    typed = table([row], texts("b") | numbers("a", "c") | counts("d") | lists("e"))
    assert csv_bytes(typed) == (
        'b,a,c,d,e\n"x, ""y""",0.30000000000000004,,1,"[""é"", ""z\\""""]"\n'.encode()
    )


def test_a_table_is_read_as_it_was_written(tmp_path: Path) -> None:
    columns = texts("case", "V/Vpl of the mechanism") | numbers("a", "b") | counts("n")
    columns |= lists("reasons")
    rows = [
        {"case": "NA", "a": 1.0 / 3.0, "n": 2, "reasons": ["ä, b", ""]},
        {"case": "", "V/Vpl of the mechanism": "slow", "b": np.inf},
    ]
    for typed in (table(rows, columns), table([], columns)):
        write_table(tmp_path / "t", typed)
        pd.testing.assert_frame_equal(read_table(tmp_path / "t"), typed, check_exact=True)
    assert plain_rows(table(rows, columns))[1] == {
        **{"case": "", "V/Vpl of the mechanism": "slow", "a": None, "b": np.inf, "n": 0},
        "reasons": None,
    }


def test_the_quick_form_drops_what_lost_its_models(
    toy_study: Study, thesis_impact: ColumnImpact
) -> None:
    from workbench.study import Figure

    study = dataclasses.replace(
        toy_study,
        cases=(*toy_study.cases, Case("only-coarse", thesis_impact, models=("coarse",))),
        figures=(Figure("f", "history", "t", "c", models=("coarse",)),),
        gates=(gate("soft", "fine", 0.1), gate("coarse", "fine", 0.1)),
    )
    quick = study.quickened()
    assert [case.name for case in quick.cases] == ["v10.0", "v15.0", "v20.0"]
    assert quick.figures == ()
    assert [g.model for g in quick.gates] == ["soft"]
    assert dataclasses.replace(study, quick_models=("soft", "coarse")).quickened().reference == (
        "coarse"
    )
    with pytest.raises(InputError, match="quick_models"):
        dataclasses.replace(study, quick_models=("soft",)).quickened()
