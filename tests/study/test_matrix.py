"""The best reference wins, gates know domains, and the matrix counts every case."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd
import pytest
from toy_models import Spring, Troubled

from workbench.base.errors import InputError
from workbench.extras.frame_models.hinged_frames import PlasticHinge
from workbench.responses import Finding
from workbench.scenarios import ColumnPushover, FrameStatic, Load, Scenario, regular_frame
from workbench.steel.sections import square
from workbench.study import Assessment, Case, Study, assess, cells_of, run_study
from workbench.study.assessment import Gate
from workbench.study.cells import perform, task_of


@dataclass(frozen=True)
class Warned(Spring):
    """A spring that warns above a velocity (m/s)."""

    above: float = 0.0
    subject: str = "shear"

    name: ClassVar[str] = "toy-warned"

    def domain(self, scenario: Scenario) -> list[Finding]:
        if isinstance(scenario, ColumnPushover) or scenario.striker.velocity <= self.above:
            return []
        return [Finding(self.subject, "the web yields", number=1.8)]


FAST = ("v15.0", "v20.0")


@pytest.fixture
def study(toy_study: Study, thesis_impact) -> Study:
    """A better reference up to 12 m/s; models that warn, refuse and fail; a push."""
    push = Case("push", ColumnPushover("push", thesis_impact.column, 0.1), models=("fine", "soft"))
    models = {
        "better": Warned(stiffness=6e6, error=0.0, above=12.0),
        "soft": Warned(stiffness=4e6, above=17.0),
        "stuck": Troubled("solver", above=12.0),
        "refuses": Troubled("refuse"),
        **{name: toy_study.models[name] for name in toy_study.ladder},
    }
    return dataclasses.replace(
        toy_study,
        cases=(*toy_study.cases, push),
        models=models,
        references=("better", "fine"),
        groups={"slow": ("v10.0",), "fast": FAST},
        quick_models=(),
    )


def assessed(study: Study, root: Path) -> tuple[Assessment, dict[str, pd.DataFrame]]:
    run_study(study, root, jobs=0)
    assessment = assess(study, root)
    tables = {
        path.stem: pd.read_csv(path) for path in (assessment.directory / "tables").glob("*.csv")
    }
    return assessment, tables


def gate(model: str, against: str, bound: float, *cases: str) -> Gate:
    return Gate(model, against, "peak_displacement", "relative_error", bound, "w", "s", cases)


def test_the_best_reference_inside_its_domain_counts(study: Study, tmp_path: Path) -> None:
    _, tables = assessed(study, tmp_path)
    result = tables["references"].set_index("case")
    assert list(result["label"]) == ["better", "fine", "fine", "fine"]
    assert list(result["inside"]) == [1, 1, 1, 1]
    assert result.loc["v15.0", "reason"] == "better is outside its domain (shear)"
    assert result.loc["push", "reason"] == "the study does not ask better"


def test_without_a_reference_inside_the_best_that_answered_counts(
    study: Study, tmp_path: Path
) -> None:
    models = {**study.models, "fine": Warned(error=0.08, level=2)}
    _, tables = assessed(dataclasses.replace(study, models=models), tmp_path)
    result = tables["references"].set_index("case")
    assert result.loc["v20.0", ["label", "inside"]].tolist() == ["better", 0]
    assert "no reference is inside its domain" in result.loc["v20.0", "reason"]
    row = tables["matrix"].set_index(["group", "label"]).loc[("fast", "soft")]
    assert (row["against"], row["against_outside"]) == ("better", 2)


@pytest.mark.parametrize("subject", ["mesh", "time-step", "no-peak", "refinement"])
def test_warnings_about_a_run_are_none_about_the_domain(subject: str) -> None:
    assert not Finding(subject, "t").outside
    assert Finding("shear", "t").outside
    assert Finding("of another package", "t").outside
    assert not Finding("shear", "t", refusal=True).outside


@pytest.mark.thorough
def test_a_gate_does_not_pass_where_agreement_says_nothing(study: Study, tmp_path: Path) -> None:
    """Soft is 12 % above fine; better, where it counts, is 18 % below fine."""
    models = {
        **study.models,
        "fine": Warned(error=0.08, level=2, above=0.0),
        "better": Warned(stiffness=6e6),
    }
    inside = {**models, "better": Spring(stiffness=6e6)}
    agreeing = {**models, "better": Spring(stiffness=4.1e6)}
    gates = tuple(gate("soft", "fine", bound, "v10.0", *FAST) for bound in (0.2, 0.01))
    bare = dataclasses.replace(study, models=models, gates=gates)

    def verdicts(of: dict[str, Any], root: str) -> list[Any]:
        return list(assessed(dataclasses.replace(bare, models=of), tmp_path / root)[0].verdicts)

    both, failing = verdicts(models, "a")
    # soft is inside its domain up to 17 m/s; nothing confirms it, as better is outside too
    assert [c.verdict.value for c in both.cases] == ["inconclusive"] * 3
    assert both.cases[2].doubt == "within the bound, but both sides are outside their domain,"
    assert both.cases[0].doubt == "fine is outside its domain and better does not confirm it"
    assert both.verdict == "inconclusive"
    assert any("both sides are outside their domain, in 1 of 3" in text for text in both.reasons)
    assert failing.verdict == "fail"  # what fails stays failed
    contradicted, _ = verdicts(inside, "b")
    assert contradicted.counts["inconclusive"] == 3
    confirmed, _ = verdicts(agreeing, "c")
    assert [c.verdict.value for c in confirmed.cases] == ["pass", "pass", "inconclusive"]


def test_the_matrix_counts_every_case(study: Study, tmp_path: Path) -> None:
    _, tables = assessed(study, tmp_path)
    rows = tables["matrix"].set_index(["group", "label"])
    assert list(rows.index.get_level_values("group").unique()) == ["slow", "fast"]
    assert list(rows.loc["fast"].index)[:2] == ["better", "fine"]  # references first
    soft = rows.loc[("fast", "soft")]
    assert (soft["asked"], soft["answered"], soft["outside"]) == (2, 2, 1)
    assert soft["peak_displacement_bias"] == pytest.approx(np.sqrt(5.0 / 4.0) / 1.02, rel=1e-9)
    assert np.isnan(soft["peak_displacement_low"])  # two cases tell no scatter
    ends = [soft[f"peak_displacement_{end}"] for end in ("least", "most")]
    assert ends == pytest.approx([soft["peak_displacement_bias"]] * 2)  # both are alike
    assert rows.loc[("fast", "stuck"), ["answered", "failed"]].tolist() == [0, 2]
    assert rows.loc[("slow", "refuses"), ["answered", "refused"]].tolist() == [0, 1]
    assert rows.loc[("fast", "fine"), ["reference", "known"]].tolist() == pytest.approx(
        [2, 0.025 / 1.02]
    )
    # a single case: its error with its uncertainty, unknown for a reference without a ladder
    one = rows.loc[("slow", "fine")]
    assert one["peak_displacement_count"] == 1
    ratio, width = 1.02 * np.sqrt(6.0 / 5.0), 0.025 * np.sqrt(6.0 / 5.0)
    assert one["peak_displacement_bias"] == pytest.approx(ratio, rel=1e-9)
    assert one["peak_displacement_high"] == pytest.approx(ratio + width, rel=1e-3)
    assert one["peak_displacement_within"] == pytest.approx(ratio - 1.0 + width, rel=1e-3)


@pytest.mark.usefixtures("few_load_steps")
def test_groups_of_static_cases_are_judged_by_what_they_resist(tmp_path: Path) -> None:
    """Displacements are given there; a group without anything compared has no row."""
    frame = regular_frame((5.0,), (4.0,), square(0.2), square(0.2))
    push = FrameStatic("push", frame, (Load("A1", x=1e3),), "A1", "x", (0.2,))
    study = Study(
        name="static",
        title="Static",
        question="?",
        cases=(Case("push", push),),
        models={"hinges": PlasticHinge(), "linear": PlasticHinge(surface="linear")},
        reference="hinges",
        quantities=("peak_displacement", "resistance"),
        groups={"pushed": ("push",)},
    )
    _, tables = assessed(study, tmp_path)
    row = tables["matrix"].set_index("label").loc["linear"]
    pushed = {label: model.simulate(push) for label, model in study.models.items()}
    ratio = float(pushed["linear"]["resistance"]) / float(pushed["hinges"]["resistance"])
    assert row["quantity"] == "resistance"
    assert row["peak_displacement_bias"] == pytest.approx(ratio, rel=1e-9)
    assert ratio < 1.0


def test_times_that_may_hold_compilation_do_not_count(study: Study, tmp_path: Path) -> None:
    _, tables = assessed(study, tmp_path)
    cost = tables["cost"].set_index("label")
    assert set(cost["against"]) == {"fine"}  # counts in two of three impacts
    assert cost.loc["fine", "ratio"] == 1.0
    assert "stuck" in cost.index  # its one answer
    assert "refuses" not in cost.index
    slow = dataclasses.replace(study, models={**study.models, "soft": Spring(delay=0.05)})
    cell = next(cell for cell in cells_of(slow) if cell.label == "soft")
    warm: set[str] = set()
    assert perform(task_of(cell, limit=0.14), warm).record["cold"]  # too slow for a second call
    assert "cold" not in perform(task_of(cell, limit=0.14), warm).record


def test_a_long_answer_is_repeated_only_where_kernels_were_compiled(
    study: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls, simulate, cell = list[int](), Spring.simulate, cells_of(study)[0]
    monkeypatch.setattr(Spring, "simulate", lambda *given: calls.append(1) or simulate(*given))
    for below, times in ((0.0, 1), (5.0, 2)):  # from which on reading kernels is nothing
        monkeypatch.setattr("workbench.study.cells.READ_BELOW", below)
        monkeypatch.setattr("workbench.study.cells.TIMED_OFTEN_BELOW", 0.0)
        calls.clear()
        assert "cold" not in perform(task_of(cell), set()).record
        assert len(calls) == times


def test_groups_and_references_name_what_the_study_has(study: Study) -> None:
    with pytest.raises(InputError, match=r"group\.cases.*v99"):
        dataclasses.replace(study, groups={"none": ("v99",)})
    with pytest.raises(InputError, match=r"study label.*nobody"):
        dataclasses.replace(study, references=("nobody",))
    with pytest.raises(InputError, match=r"study\.decisive.*map"):
        dataclasses.replace(study, decisive="map")
    cases = tuple(dataclasses.replace(c, quick=c.name == "v10.0") for c in study.cases)
    quick = dataclasses.replace(study, cases=cases, quick_models=("soft", "fine")).quickened()
    assert quick.ranked == ("fine",)
    assert dict(quick.groups) == {"slow": ("v10.0",)}


@pytest.mark.thorough
def test_a_collapse_that_the_reference_does_not_share_is_counted(
    study: Study, tmp_path: Path
) -> None:
    models = {
        **study.models,
        "fine": Troubled("collapse", above=18.0),
        "falls": Troubled("collapse", above=8.0),
    }
    gates = (gate("soft", "middle", 0.5, "v20.0"),)
    ladders = {"ladder": (), "reference": "fine", "references": ("fine", "middle")}
    bare = dataclasses.replace(study, models=models, gates=gates, **ladders)
    _, tables = assessed(bare, tmp_path)
    # a collapse is an answer of the best reference, no reason to take the next one
    assert list(tables["references"].set_index("case").loc[list(FAST), "label"]) == ["fine"] * 2
    rows = tables["matrix"].set_index(["group", "label"])
    columns = ["answered", "collapsed", "false_alarm", "false_safe"]
    assert rows.loc[("slow", "falls"), columns].tolist() == [0, 1, 1, 0]
    assert rows.loc[("fast", "falls"), columns].tolist() == [0, 2, 1, 0]
    assert rows.loc[("fast", "soft"), columns].tolist() == [2, 0, 0, 1]
    warned = {**models, "middle": Warned(error=0.08, level=1), "soft": Spring(stiffness=4.9e6)}
    assessment, _ = assessed(dataclasses.replace(bare, models=warned), tmp_path / "warned")
    (case,) = assessment.verdicts[0].cases
    assert case.doubt == "middle is outside its domain and fine does not confirm it"
