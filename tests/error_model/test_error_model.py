"""The error of answers through the anchor: the shipped table, its intervals, and what is said."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from math import inf, isfinite, nan
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from workbench.base.catalogue import load
from workbench.base.errors import Collapse, CollapseError, Mechanism
from workbench.cli import run
from workbench.models.base import make_model
from workbench.models.references.fiber_beams import FiberShear
from workbench.models.superelements import FlexibleSuperelement
from workbench.responses import Outcome, build_response, collapsed_response, failed_response
from workbench.scenarios import ColumnImpact, scenario_from
from workbench.study import Case, Study
from workbench.study.error_model import error_model
from workbench.study.error_model.error_model import (
    anchor_peak,
    expected_error,
    truth_ratio,
    widened,
)
from workbench.study.error_model.error_table import (
    ANCHOR,
    COLUMNS,
    CRUSH,
    FACTOR,
    FINEST,
    MARGIN,
    REFERENCE,
    STRIKER,
    TABLES,
    TRUTH,
    UNUSUAL,
    LocalMean,
    ends_of,
)

STANDING = COLUMNS.rows[np.isfinite(COLUMNS.ratios)]
JUDGED = STANDING[(STANDING[MARGIN] == 0.0) & (STANDING[FACTOR] == 1.0) & (STANDING[CRUSH] == 0.0)]


def drawn(row) -> ColumnImpact:
    """The drawn column of a row, from its inputs."""
    tables = {"kind": COLUMNS.kind, "name": row["case"]}
    for path, value in row.items():
        table, _, key = str(path).partition(".")
        if key and table in ("column", "steel", "striker", "time") and value == value:
            plain = value.item() if hasattr(value, "item") else value
            read = json.loads(plain) if str(plain).startswith(("{", "[")) else plain
            tables.setdefault(table, {})[key] = read
    return scenario_from(tables)


def answered(peak: float, name: str = "plug-in"):
    """The answer of a model that nobody measured."""
    if isfinite(peak):
        response = build_response({"peak_displacement": peak})
    else:
        fall = Collapse(Mechanism.GEOMETRY, ("hit",), 0.5, 0.1)
        response = collapsed_response(CollapseError(fall, "falls"))
    response.attrs |= {"model": name, "options": "{}"}
    return response


@pytest.fixture
def stored(monkeypatch: pytest.MonkeyPatch):
    """Peaks of the anchor are looked up in the table, or given, and not computed."""
    peaks = dict(zip(COLUMNS.rows["case"], COLUMNS.rows[ANCHOR], strict=True))
    monkeypatch.setattr(
        error_model, "_anchor", lambda hit: error_model.Reached(peaks[hit.name], nan)
    )
    truth_ratio.cache_clear()  # it knows anchors
    yield peaks
    truth_ratio.cache_clear()


@pytest.mark.parametrize("table", TABLES.values(), ids=TABLES)
def test_a_table_of_other_versions_of_anchor_or_reference_is_refused(table) -> None:
    """Whoever raises one of them measures again: `workbench data measure`."""
    for name, column in ((table.anchor, "anchor"), (table.reference, "reference")):
        assert set(table.rows[f"{column}_version"]) == {make_model(name).version}, name
    assert {*table.words, *table.cells, TRUTH, table.anchor} <= set(table.rows)
    assert load(table.dataset)["case"].is_unique


def test_the_anchor_of_the_table_is_the_anchor_of_now() -> None:
    heavy = JUDGED[JUDGED[STRIKER] > 0.6]  # light ones bounce as the last digit of inputs decides
    for _, row in heavy.iloc[::150].iterrows():
        hit = drawn(row)
        assert anchor_peak(hit) == pytest.approx(row[ANCHOR], rel=1e-3)
        assert list(COLUMNS.features(hit).values()) == pytest.approx(
            [row[name] for name in COLUMNS.words], rel=1e-4, abs=1e-9
        )


@pytest.mark.parametrize("count", [5, 20, 39, 40, 100, 777])
def test_ends_hold_nine_of_ten_new_values(count: int) -> None:
    """A new value has any place among the others with the same chance."""
    low, high = ends_of(count)
    held = (high - low) / (count + 1)
    assert held >= 0.9 or (low, high) == (0, count - 1)
    assert held <= 0.9 + 2.0 / (count + 1)


@pytest.mark.parametrize("table", TABLES.values(), ids=TABLES)
def test_intervals_hold_nine_of_ten_that_they_were_not_made_of(table) -> None:
    """Leave one out, in every cell and of every kind; a collapse lies above any finite end."""
    held = {}
    for place in np.flatnonzero(table._judged & (table.rows[MARGIN] < 1.0)):
        row = table.rows.iloc[place]
        if row[MARGIN] and not table.knows(row[MARGIN]):
            continue
        values = table.rests(row)
        others = np.delete(values, np.searchsorted(values, table._rests[place]))
        low, high = ends_of(len(others))
        inside = others[low] <= table._rests[place] <= others[high]
        held.setdefault(table.cell(row), []).append(inside)
    for cell, inside in held.items():
        assert np.mean(inside) > 0.75 or len(inside) < 20, cell
    assert 0.88 <= np.mean(np.concatenate(list(held.values()))) <= 0.95


def test_the_same_truth_is_expected_whatever_the_model(stored) -> None:
    """The interval of the truth is that of the anchor, in units of the answer."""
    hit = drawn(JUDGED.iloc[0])
    values, *_ = truth_ratio(hit)
    low, high = ends_of(len(values))
    log_ratios = stored[hit.name] * np.exp(values)
    for factor in (0.5, 1.0, 1.3):
        answer = factor * stored[hit.name]
        error = expected_error(hit, answered(answer))
        assert error.reason == ""
        assert error.low == pytest.approx(answer / log_ratios[high] - 1.0)
        assert error.high == pytest.approx(answer / log_ratios[low] - 1.0)
        assert error.low < error.expected < error.high
        off = np.abs(answer / log_ratios - 1.0) > 0.1
        assert error.chance == pytest.approx((off.sum() + 0.5) / (len(log_ratios) + 1))
        below = answer / log_ratios - 1.0 < -0.1
        assert error.unsafe == pytest.approx((below.sum() + 0.5) / (len(log_ratios) + 1))
        loss = error.unsafe + 0.2 * (error.chance - error.unsafe)
        assert error.warns == (loss > 0.1)


def test_a_model_that_is_20_percent_low_is_told_so(stored) -> None:
    """A plug-in that the data never saw: 0.8 of the reference, as the solids correct that."""
    rows = JUDGED.iloc[np.random.default_rng(3).permutation(len(JUDGED))[:50]]
    statements, held = [], 0
    for _, row in rows.iterrows():
        doubts = COLUMNS.doubts(row)
        truth = row[TRUTH] * np.exp(np.median(doubts) if len(doubts) else 0.0)
        error = expected_error(drawn(row), answered(0.8 * truth))
        statements.append(error.expected)
        held += error.low <= -0.2 <= error.high
        assert error.warns
    assert np.median(statements) == pytest.approx(-0.2, abs=0.02)
    assert np.count_nonzero(np.abs(np.array(statements) + 0.2) <= 0.05) >= 40
    assert held >= 40


def test_what_is_near_centres_the_interval_and_a_scenario_does_not_judge_itself() -> None:
    """A bump that no cell and no line follows; a drawn point has what the others expect."""
    points = np.stack(np.meshgrid(np.arange(12.0), np.arange(12.0)), axis=-1).reshape(-1, 2)
    values = 0.3 * points[:, 0] - np.exp(-0.1 * ((points - 5.5) ** 2).sum(axis=1))
    local = LocalMean(points, values)
    assert np.abs(local.rests).mean() < 0.25 * values.std()
    place = 70
    others = np.arange(len(values)) != place
    wrong = LocalMean(points, np.where(others, values, values - 0.05))
    assert wrong.at(points[place]) == pytest.approx(local.at(points[place]), abs=0.002)
    assert local.rests[place] == pytest.approx(values[place] - local.at(points[place]))
    assert local.at(points[place] + 1e-3) != local.at(points[place])


def test_restitution_head_mass_and_fixed_head_warn_of_nothing(stored) -> None:
    """They bound nothing: no reason for an unknown error comes from them."""
    hit = drawn(JUDGED.iloc[7])
    plain = truth_ratio(hit)
    bounced = replace(hit, striker=replace(hit.striker, restitution=1.0))
    mass = 10.0 * hit.striker.mass
    loaded = replace(hit, column=replace(hit.column, head_mass=mass))
    for other in (bounced, loaded):
        assert truth_ratio(other).reason == plain.reason == ""
        assert truth_ratio(other).cell == plain.cell
    fixed = replace(hit, column=replace(hit.column, head="fixed", restraint_stiffness=0.0))
    assert truth_ratio(fixed).reason == ""


def test_outside_of_what_was_drawn_nothing_is_known(stored) -> None:
    hit = drawn(JUDGED.iloc[0])
    light = replace(hit, striker=replace(hit.striker, mass=0.1 * hit.column.properties.impact_mass))
    error = expected_error(light, answered(0.01))
    assert (error.expected, error.low, error.high, error.chance) == (None,) * 4
    assert error.reason.startswith("not measured here: striker over lumped mass 0.1, drawn")
    assert not error.warns


def test_collapse_goes_by_the_anchor(stored) -> None:
    """Where both fall or stand the doubt is small; a model alone is most likely wrong."""
    hit = drawn(JUDGED.iloc[0])
    peak = stored[hit.name]
    stands, falls = answered(peak), answered(inf)
    assert expected_error(hit, stands).collapse < 0.01
    assert expected_error(hit, falls).chance > 0.99
    stored[hit.name] = inf
    truth_ratio.cache_clear()
    assert expected_error(hit, falls).chance < 0.2
    error = expected_error(hit, stands)
    assert error.chance > 0.8
    assert error.reason == "the anchor collapses"


@pytest.mark.parametrize(("grows", "near"), [(1.9, False), (2.1, True), (inf, True), (nan, True)])
def test_an_anchor_that_falls_at_a_little_more_velocity_is_near_collapse(
    monkeypatch: pytest.MonkeyPatch, grows: float, near: bool
) -> None:
    """Or that goes twice as far, or does not come to rest: from 1.1 of the velocity on."""
    hit = drawn(JUDGED.iloc[0])
    at_first = hit.striker.velocity

    def reached(there: ColumnImpact) -> error_model.Reached:
        gone = there.striker.velocity > 1.1 * at_first
        return error_model.Reached(0.01 * (grows if gone else 1.0), nan)

    monkeypatch.setattr(error_model, "_anchor", reached)
    margin = error_model.margin_of(hit)
    assert margin == (pytest.approx(1.0 / 1.1, abs=0.01) if near else 0.0)
    later = hit.at_velocity(1.15 * at_first)
    if grows == inf:
        assert error_model.margin_of(later) == pytest.approx(1.15 / 1.1, abs=0.01)
    assert error_model.margin_of(hit.at_velocity(1.5 * at_first)) == 0.0


def test_close_to_collapse_the_chance_of_one_is_that_of_drawn_columns() -> None:
    """It rises with the margin, and is in no doubt far from it."""
    row = dict(STANDING.iloc[0])
    chances = [COLUMNS.collapses(False, row | {MARGIN: m}) for m in (0.0, 0.85, 0.94, 0.98)]
    assert chances[0] < 0.01
    assert chances == sorted(chances)
    assert COLUMNS.collapses(True, row | {MARGIN: 1.1}) > chances[-1]
    rests = COLUMNS.rests(row | {MARGIN: 0.98})
    share = np.isinf(rests).mean()
    assert share == pytest.approx(chances[-1], abs=0.05)


def test_two_references_that_differ_about_collapse_both_stand() -> None:
    rows = COLUMNS.rows
    twice = rows[rows["case"].duplicated(keep=False)]
    assert len(twice) == 2
    for _, pair in twice.groupby("case"):
        assert sorted(np.isinf(pair[TRUTH])) == [False, True]


def test_reference_and_solid_are_not_judged_by_the_anchor(stored) -> None:
    hit = drawn(JUDGED.iloc[0])
    assert expected_error(hit, answered(0.1, FINEST)).reason == "nothing finer has measured it"
    error = expected_error(hit, answered(0.1, REFERENCE))
    assert error.reason or error.high - error.low < 0.2


def test_no_answer_has_no_error(stored) -> None:
    hit = drawn(JUDGED.iloc[0])
    refused = failed_response(Outcome.NOT_CONVERGED, "why")
    refused.attrs |= {"model": "plug-in", "options": "{}"}
    assert expected_error(hit, refused).reason == "the answer has no peak displacement"
    assert json.dumps(asdict(expected_error(hit, refused)))


def test_the_doubt_about_the_reference_adds_in_quadrature() -> None:
    values = np.linspace(-0.03, 0.03, 99)
    assert widened(values, values[:0]) is values
    doubts = np.linspace(-0.02, 0.06, 99)  # median 0.02, half-width 0.036
    moved = widened(values, doubts)
    low, high = ends_of(99)
    half = 0.5 * (doubts[high] - doubts[low])
    assert np.median(moved) == pytest.approx(0.02)
    assert moved[high] - 0.02 == pytest.approx(np.hypot(values[high], half))
    assert 0.02 - moved[low] == pytest.approx(np.hypot(values[low], half))
    assert np.all(np.diff(moved) > 0.0)


def test_steel_that_feels_its_rate_is_a_stronger_one_of_its_own_cell() -> None:
    """And a front is as large as the share of the energy that it takes; neither hardens."""
    rated, soft = (STANDING[STANDING[name] > bound] for name, bound in ((FACTOR, 1.1), (CRUSH, 0)))
    for rows, name in ((rated, FACTOR), (soft, CRUSH)):
        hit = drawn(rows.iloc[0])
        features = COLUMNS.features(hit)
        assert features[name] == pytest.approx(rows.iloc[0][name], rel=1e-4)
        assert UNUSUAL[name][0] in COLUMNS.cell(features)
    law = replace(drawn(rated.iloc[0]).column.steel, hardening_modulus=2.1e9)
    hard = replace(hit, column=replace(hit.column, steel=law))
    assert truth_ratio(hard).reason == "errors were measured without hardening"
    front = hit.striker.crush or ((0.0, 0.0), (1.0, hit.striker.stiffness))
    table = replace(hit, striker=hit.striker.changed(stiffness=None, crush=front))
    assert COLUMNS.features(table)[CRUSH] >= 0.99 * features[CRUSH]


@pytest.mark.thorough
def test_the_verb_measures_a_table_and_goes_on_where_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two of the shipped columns again, with their peaks and features; no other table is known."""
    rows = JUDGED.sort_values("time.duration").iloc[:2]
    models = {"beam": FiberShear(levels=1), "anchor": FlexibleSuperelement()}
    cases = tuple(Case(row["case"], drawn(row)) for _, row in rows.iterrows())
    small = Study("small", "Small", "How far off?", cases, models, "beam")
    monkeypatch.setitem(TABLES, "columns", replace(COLUMNS, studies=("small",)))
    monkeypatch.setattr(
        "workbench.study.load_study", lambda name: SimpleNamespace(study=small, file=None)
    )
    target = tmp_path / "columns.csv"
    ask = ["data", "measure", "columns", "--store", str(tmp_path), "--out", str(target), "--json"]
    for stored in (0, 4):
        assert run([*ask, "--jobs", "0"]) == 0
        captured = capsys.readouterr()
        assert json.loads(captured.out)["judged"] == 2
        assert f"{stored} already stored" in captured.err
    table = pd.read_csv(target)
    assert list(table["reference_state"]) == ["ok", "ok"]
    for name in (TRUTH, ANCHOR, *COLUMNS.words):
        assert list(table[name]) == pytest.approx(list(rows[name]), rel=1e-3, abs=1e-9)
    assert run(["data", "measure", "shear_columns"]) == 2
    assert "table = 'shear_columns': must be one of columns" in capsys.readouterr().err
