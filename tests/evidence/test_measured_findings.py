"""The shipped rules of validity: regions that tile, warnings with numbers, cause and remedy."""

from __future__ import annotations

from dataclasses import replace
from math import isinf

import pandas as pd
import pytest

from workbench.evidence import load
from workbench.evidence.advice import advise
from workbench.evidence.descriptors import FEATURES, WORDS, beyond, descriptors, features
from workbench.evidence.measured import RANGES, TABLE, TOLERATED, measured_findings
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.registry import make_model
from workbench.responses import warnings_of
from workbench.scenarios import ColumnImpact, Striker, parse_value
from workbench.study import load_study
from workbench.study.model_form import range_rows


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    return load(TABLE).fillna({"options": "", "better": ""})


def test_regions_of_a_model_tile_and_their_counts_add_up(table, thesis_impact) -> None:
    scenarios = [thesis_impact.at_velocity(v) for v in (0.5, 2.0, 8.0, 15.0, 40.0)]
    for (_, _), regions in table.groupby(["model", "options"]):
        for scenario in scenarios:
            own = features(scenario)
            held = sum(
                all(row[f"{n}_low"] <= own[n] < row[f"{n}_high"] for n in FEATURES)
                for _, row in regions.iterrows()
            )
            assert held == 1
    assert (table["low"] + table["high"] <= table["count"]).all()
    assert (table["false_alarm"] <= table["high"]).all()
    assert (table["false_safe"] <= table["low"]).all()


def test_a_model_without_shear_is_warned_of_where_webs_yield(thesis_impact: ColumnImpact) -> None:
    (finding,) = measured_findings(FourDof(), thesis_impact)
    assert finding.subject == "measured"
    assert finding.outside
    assert "V/Vpl of the mechanism 1.79, above" in finding.text
    assert "too small" in finding.text
    assert TOLERATED < finding.number <= 1.0
    response = FourDof().simulate(thesis_impact)
    assert "measured" not in [f.subject for f in warnings_of(response)]  # a model reads no study
    advice = advise(FourDof(), thesis_impact, response)
    assert "measured" in [f.subject for f in advice]
    assert all(f.remedy for f in advice if f.instead is not None)


def test_variants_have_rules_of_their_own_and_other_models_none(thesis_impact, table) -> None:
    assert measured_findings(FourDof(beta=1.3), thesis_impact) == []  # not measured
    assert measured_findings(make_model("fiber-reissner"), thesis_impact) == []
    options = set(table.loc[table["model"] == "energy-estimate", "options"])
    assert options >= {"", "resistance=cubic", "resistance=panel hit_mass=waves"}
    told = {
        str(model): [f.text for f in measured_findings(model, thesis_impact)]
        for model in (EnergyEstimate(), EnergyEstimate(resistance="panel", hit_mass="waves"))
    }
    assert len({tuple(texts) for texts in told.values()}) == 2


def test_a_region_with_few_errors_is_not_warned_of(table) -> None:
    quiet = table[(table["low"] + table["high"] + 1) / (table["count"] + 2) <= TOLERATED]
    assert len(quiet) > 0
    bounded = [name for name in FEATURES if not isinf(quiet.iloc[0][f"{name}_low"])]
    assert len(bounded) <= len(FEATURES)
    assert FourDofShear().name in set(table["model"])


def test_better_models_are_those_that_were_less_often_off(thesis_impact, table) -> None:
    """Of the same column, the one that did best in the region first."""
    (finding,) = measured_findings(FourDof(), thesis_impact)
    own = features(thesis_impact)
    held = table[
        [
            all(row[f"{n}_low"] <= own[n] < row[f"{n}_high"] for n in FEATURES)
            for _, row in table.iterrows()
        ]
    ]
    plain = held[held["options"] == ""].set_index("model")
    chances = (plain["low"] + plain["high"] + 1) / (plain["count"] + 2)
    less = chances[chances < chances["four-dof"]]
    assert set(finding.instead) == set(less.index)
    assert finding.instead[0] == plain.loc["four-dof", "better"]
    assert list(less[list(finding.instead[1:])]) == sorted(less[list(finding.instead[1:])])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"velocity": 60.0}, "velocity over (fy / rho)^½ 0.282: columns were measured at 0.0033"),
        ({"mass": 15.0}, "striker over lumped mass 0.1"),
    ],
)
def test_nothing_is_expected_of_hits_unlike_those_that_were_drawn(
    thesis_impact, changes, said
) -> None:
    slow = replace(thesis_impact, striker=Striker(300.0, 24.0))
    hit = replace(slow, striker=replace(slow.striker, **changes))
    for name in ("four-dof", "single-dof", "energy-estimate", "rigid-superelement"):
        model = make_model(name, {})
        (known,), (found,) = measured_findings(model, slow), measured_findings(model, hit)
        assert "; expect " in known.text
        assert known.subject in ("measured", "measured-risk")
        assert found.subject in ("unmeasured", "unmeasured-risk")
        assert found.outside == (found.subject == "unmeasured") == (found.number > 0.5)
        assert said in found.text
        assert "; expect " not in found.text
        assert found.instead == ()


def test_the_ranges_are_those_of_the_columns_that_were_drawn() -> None:
    columns = load_study("which_model").study
    rows = list(range_rows(columns))
    assert pd.DataFrame(rows).equals(load(RANGES))
    assert {row["descriptor"] for row in rows} == set(WORDS)
    for case in columns.cases:
        assert beyond(descriptors(case.scenario), RANGES) == {}
        bounced = replace(case.scenario, striker=replace(case.scenario.striker, restitution=0.01))
        assert list(beyond(descriptors(bounced), RANGES)) == ["restitution"]


def options_of(variant: str) -> dict[str, object]:
    pairs = (each.partition("=") for each in variant.split())
    return {name: parse_value(value) for name, _, value in pairs}
