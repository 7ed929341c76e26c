"""Residual capacity: what may be claimed with which rows, and the choice of a relation."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest

from workbench.base.catalogue import load
from workbench.base.errors import InputError
from workbench.studs import RELATIONS, TESTS, Grade, MechanicalCurve, ResidualFit, fit_residual
from workbench.studs.damaged import damaged_rows
from workbench.studs.fit_protocol import plain
from workbench.studs.schema import from_frame
from workbench.studs.statistics.intervals import without_each

Maker = Callable[..., pd.DataFrame]


def texts(fit: ResidualFit) -> list[str]:
    return [finding.text for finding in fit.findings]


@pytest.fixture
def predicted() -> MechanicalCurve:
    level = np.array([0.0, 0.5, 1.0])
    return MechanicalCurve(
        level, np.array([1.0, 0.8, 0.4]), np.array([1.0, 0.6, 0.1]), np.array([1.0, 0.9, 0.7]),
        "pull-out", "displacement ratio", "strength", "made for a test",
    )  # fmt: skip


def test_without_tests_only_the_mechanical_prediction_is_left(
    push_outs: pd.DataFrame, predicted: MechanicalCurve
) -> None:
    fit = fit_residual(push_outs, mechanical=predicted)
    assert fit.grade is Grade.MECHANICAL
    assert str(fit.grade) == "mechanical prediction, not validated by tests after pre-damage"
    assert fit.left([0.25, 0.75]).tolist() == pytest.approx([0.9, 0.6])
    low, high = fit.band([0.5])
    assert (low[0], high[0]) == (0.6, 0.9)
    assert "holds no test after pre-damage" in fit.findings[0].text
    stored = json.loads(json.dumps(plain(fit.summary()), allow_nan=False))
    assert stored["grade"] == str(fit.grade)
    with pytest.raises(InputError, match="holds no test after pre-damage"):
        fit_residual(push_outs)
    with pytest.raises(InputError, match="must predict the stiffness"):
        fit_residual(push_outs, "stiffness", mechanical=predicted)


def test_a_table_with_such_rows_flips_the_path_and_says_so(
    push_outs: pd.DataFrame, predicted: MechanicalCurve, damaged: Maker
) -> None:
    synthetic = damaged(kind="pull-out", measure="displacement ratio")
    both = pd.concat([push_outs, synthetic], ignore_index=True)
    fit = fit_residual(both, mechanical=predicted)
    assert fit.grade is Grade.SYNTHETIC
    assert "40 of 40 rows are synthetic" in texts(fit)
    assert {score.name for score in fit.scores} == {*RELATIONS, "mechanical"}
    assert fit.scores[0].by == "campaign"
    measured = fit_residual(
        damaged(kind="pull-out", measure="displacement ratio", origin="measured")
    )
    assert measured.grade is Grade.CROSS_VALIDATED
    assert fit_residual(damaged(1, origin="measured")).grade is Grade.ONE_CAMPAIGN


@pytest.mark.thorough
@pytest.mark.parametrize(("c", "p"), [(0.5, 2.5), (0.45, 0.4)])
def test_the_power_relation_is_chosen_and_recovered(damaged: Maker, c: float, p: float) -> None:
    fit = fit_residual(damaged(8, 8, c, p, 0.03, 0.02))
    assert fit.relation.name == "power"
    assert fit.fitted is not None
    result = fit.fitted.parameters
    assert result["c"].low < c < result["c"].high
    assert result["p"].low < p < result["p"].high
    low, high = fit.band([0.2, 0.8])
    assert np.all((low < fit.left([0.2, 0.8])) & (fit.left([0.2, 0.8]) < high))


def test_a_damage_without_effect_is_called_so(damaged: Maker) -> None:
    fit = fit_residual(damaged(6, 8, 0.0, kind="corrosion", measure="section loss"))
    assert fit.relation.name == "none"
    # lines, and a threshold at 0, are one relation: each has as much of what chance leaves it
    assert fit.scores[0].weight > 2.0 * fit.scores[1].weight
    assert fit.left([0.9]).tolist() == [pytest.approx(1.0, abs=0.01)]  # an average; measured 0.004
    assert fit.parameters == {}


@pytest.mark.thorough
def test_fatigue_without_loss_contradicts_published_findings(damaged: Maker) -> None:
    fit = fit_residual(damaged(6, 8, 0.0))
    assert any("contradicts Hanswille" in text for text in texts(fit))
    findings = load("stud-findings")
    row = findings[findings["reference"].str.contains("Hanswille")].iloc[0]
    assert (row["value_low"], row["value_high"]) == (0.10, 0.15)
    assert not any("contradicts" in text for text in texts(fit_residual(damaged())))


def test_kinds_of_damage_are_not_mixed(damaged: Maker) -> None:
    both = pd.concat(
        [damaged(), damaged(kind="pull-out", measure="load ratio", seed=5).assign(campaign="x")],
        ignore_index=True,
    ).assign(specimen=[f"s{i}" for i in range(80)])
    with pytest.raises(InputError, match="different kinds of damage"):
        fit_residual(both)
    chosen = fit_residual(both, predamage="fatigue")
    assert (chosen.predamage, len(chosen.rows)) == ("fatigue", 40)
    with pytest.raises(InputError, match="must be one of strength, stiffness"):
        fit_residual(both, "colour")


def test_one_campaign_gives_its_own_band_and_two_give_none(damaged: Maker) -> None:
    one = fit_residual(damaged(1, 12))
    assert one.band([0.5]) is not None
    assert one.foretold == "this laboratory alone"
    assert one.scores[0].by == "specimen"
    assert any("leaving out specimens" in text for text in texts(one))
    two = fit_residual(damaged(2, 12))
    assert two.band([0.5]) is None
    assert any("no band for a new one" in text for text in texts(two))


def test_validation_refuses_seen_rows(damaged: Maker) -> None:
    table = damaged(6, origin="measured")
    seen, unseen = table[table["campaign"] != "lab 5"], table[table["campaign"] == "lab 5"]
    fit = fit_residual(seen)
    with pytest.raises(InputError, match="was used for the fit"):
        fit.judge(table)
    result = fit.judge(unseen)
    assert len(result.rows) == 8
    error = result.rows["test"] - result.rows["prediction"]
    assert np.sqrt(np.mean(error**2)) < 0.079  # measured 0.0395


def test_the_reference_may_come_from_companions() -> None:
    rows = [
        {"campaign": "a", "specimen": "u1", "test": "push-out", "diameter_mm": 19, "shear_kN": 100},
        {"campaign": "a", "specimen": "u2", "test": "push-out", "diameter_mm": 19, "shear_kN": 110},
        {"campaign": "a", "specimen": "d1", "test": "push-out", "diameter_mm": 19, "shear_kN": 84,
         "predamage": "pull-out", "predamage_measure": "load ratio", "predamage_level": 0.6},
        {"campaign": "b", "specimen": "d1", "test": "push-out", "diameter_mm": 19, "shear_kN": 84,
         "predamage": "pull-out", "predamage_measure": "load ratio", "predamage_level": 0.6},
    ]  # fmt: skip
    result = damaged_rows(from_frame(pd.DataFrame(rows), TESTS), "strength")
    assert result["campaign"].tolist() == ["a"]  # campaign b has nothing to compare with
    assert result["ratio"].tolist() == [pytest.approx(0.8)]


def test_relations_start_whole_and_refuse_other_levels() -> None:
    for relation in RELATIONS.values():
        theta = relation.starts[0]
        assert relation(0.0, theta) == pytest.approx(1.0)
        values = relation(np.linspace(0.0, 1.0, 20), theta)
        assert np.all(np.diff(values) <= 0.0)
        assert 0.0 <= relation(3.0, theta) <= values[-1]  # driven beyond what it bears
        with pytest.raises(InputError, match="damage is 0 or more"):
            relation(-0.2, theta)


def test_a_mechanical_curve_must_be_a_curve() -> None:
    with pytest.raises(InputError, match="rising levels"):
        MechanicalCurve(np.array([0.0, 0.0]), np.ones(2), np.ones(2), np.ones(2), "pull-out",
                        "load ratio", "strength", "")  # fmt: skip


def test_damage_beyond_the_tests_is_an_extrapolation(damaged: Maker) -> None:
    """Twelve tests with damage up to 0.12 support nothing at 1, and say so."""
    narrow = damaged(3, 4, origin="measured")
    fit = fit_residual(narrow.assign(predamage_level=0.12 * narrow["predamage_level"]))
    assert fit.grade is Grade.NARROW
    assert fit.levels[1] <= 0.12
    assert fit.holds.startswith("for damage up to 0.1")
    low, high = fit.band([0.05, fit.levels[1], 0.5, 1.0])
    assert np.isfinite([low[:2], high[:2]]).all()
    assert np.isnan([low[2:], high[2:]]).all()
    curve = fit.tables(0.9)["curve"]
    assert curve["extrapolated"].tolist() == [level > fit.levels[1] for level in curve["level"]]


def test_what_cannot_be_told_apart_is_averaged(damaged: Maker) -> None:
    fit = fit_residual(damaged(3, 6, 0.4, origin="measured"))
    assert sum(score.weight for score in fit.scores) == pytest.approx(1.0)
    assert len(fit.averaged) >= 2
    each = [c.weight * c.relation(0.6, c.estimate.theta) for c in fit.averaged]
    assert fit.left(0.6) == pytest.approx(np.sum(each))
    assert next(s for s in fit.scores if s.name == "none").weight < 0.05
    moved, largest = fit.influence(), fit.levels[1]
    others = sum(
        c.weight * np.array([float(c.relation(largest, t)) for t in without_each(c.estimate)])
        for c in fit.averaged
    )
    assert moved["without"].to_numpy() == pytest.approx(others)
    assert moved["value"].to_numpy() == pytest.approx(float(fit.left(largest)))
    low, high = fit.band([0.6])
    assert low[0] < min(c.relation(0.6, c.estimate.theta) for c in fit.averaged)
    assert high[0] > max(c.relation(0.6, c.estimate.theta) for c in fit.averaged)


def test_the_loss_of_a_threshold_is_that_of_a_life() -> None:
    left = RELATIONS["threshold"](np.array([0.1, 0.2, 0.6, 1.0]), (0.4, 0.2))
    assert left == pytest.approx([1.0, 1.0, 0.8, 0.6])


def test_two_campaigns_do_not_validate(damaged: Maker) -> None:
    fit = fit_residual(damaged(2, 4, origin="measured"))
    assert fit.grade is Grade.TWO_CAMPAIGNS
    assert any("2 of 3 campaigns do not tell how much" in text for text in texts(fit))
    one = fit_residual(damaged(1, 6, origin="measured"))
    assert any("one campaign does not tell how much" in text for text in texts(one))
