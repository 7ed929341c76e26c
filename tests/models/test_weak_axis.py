"""Hits along the flanges: plane models bend the column about its weak axis."""

import tomllib
from dataclasses import replace

import pytest

import workbench as wb
from workbench.base.errors import InputError
from workbench.models.base import make_model
from workbench.models.batch import simulate_many
from workbench.models.domain import euler_load, member_findings
from workbench.responses import Outcome, outcome_of
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.scenarios.files import scenario_from, scenario_hash, to_toml
from workbench.scenarios.frame_events import frame_of

HEB = Column("HEB 220", 0.8, 3.2, axial_load=0.5e6, restraint_stiffness=1e7, axis="weak")
IPE = Column("IPE 300", 1.2, 2.3, axial_load=0.15e6, restraint_stiffness=5e6, axis="weak")
HEA = Column("HEA 200", 1.0, 2.5, axial_load=0.2e6, restraint_stiffness=5e6, axis="weak")


def _peak(
    model: str, column: Column, mass: float, velocity: float, duration: float = 0.15
) -> float:
    scenario = ColumnImpact("weak", column, Striker(mass, velocity), duration)
    return float(make_model(model).simulate(scenario).peak_displacement)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("column", "mass", "velocity", "four_dof", "fibers"),
    [
        (HEB, 1500.0, 6.0, 0.06663, 0.06878),
        (HEB, 1500.0, 10.0, 0.18727, 0.19021),
        (HEB, 1500.0, 14.0, 0.32610, 0.33141),
        (IPE, 800.0, 4.0, 0.06475, 0.06867),
        (IPE, 800.0, 8.0, 0.23998, 0.24357),
        (HEA, 1200.0, 5.0, 0.08052, 0.08285),
        (HEA, 1200.0, 9.0, 0.25299, 0.25500),
    ],
)
def test_peaks_about_the_weak_axis(column, mass, velocity, four_dof, fibers) -> None:
    # The values come from these models on shapes turned by hand, before columns knew an axis.
    assert _peak("four-dof", column, mass, velocity) == pytest.approx(four_dof, rel=1e-3)
    assert _peak("fiber-shear", column, mass, velocity) == pytest.approx(fibers, rel=2e-3)


@pytest.mark.parametrize(
    ("model", "deviation"),
    [
        ("four-dof-shear", 0.05),
        ("single-dof", 0.02),
        ("energy-estimate", 0.02),
        ("rigid-superelement", 0.02),
        ("flexible-superelement", 0.02),
    ],
)
def test_reduced_models_follow_the_fibers(model: str, deviation: float) -> None:
    assert _peak(model, HEB, 1500.0, 10.0) == pytest.approx(0.1902, rel=deviation)


def test_columns_turn_their_section_and_files_keep_its_name() -> None:
    scenario = ColumnImpact("weak", HEB, Striker(1500.0, 10.0))
    assert HEB.section.name == "HEB 220, weak axis"
    assert HEB.changed(axis="strong").section.name == "HEB 220"
    assert HEB.changed(section="IPE 300").section.name == "IPE 300, weak axis"
    text = to_toml(scenario)
    assert 'section = "HEB 220"' in text
    assert 'axis = "weak"' in text
    assert scenario_from(tomllib.loads(text)) == scenario


def test_an_axis_that_is_strong_leaves_the_hash_alone() -> None:
    scenario = ColumnImpact("w", Column("HEB 220", 0.8, 3.2), Striker(1500.0, 10.0), 0.15)
    assert scenario_hash(scenario) == "2e03d8907390b7e5"  # before columns knew an axis
    assert "axis" not in to_toml(scenario)


def test_supports_may_differ_about_the_weak_axis() -> None:
    pinned = HEB.changed(base_weak="pinned")
    assert pinned.ends == ("pinned", "guided")
    assert pinned.changed(axis="strong").ends == ("clamped", "guided")
    assert frame_of(pinned).node("base").support == "pinned"
    assert _peak("four-dof", pinned, 1500.0, 10.0) > 1.05 * _peak("four-dof", HEB, 1500.0, 10.0)


def test_square_tubes_answer_alike_about_both_axes() -> None:
    tube = replace(HEB, section="SHS 200x10")
    weak = _peak("four-dof", tube, 1500.0, 10.0)
    assert weak == _peak("four-dof", tube.changed(axis="strong"), 1500.0, 10.0)


def test_an_axial_load_that_buckles_the_column_out_of_the_plane_is_named() -> None:
    slender = Column("IPE 300", 2.0, 4.0, base="pinned", head="pinned", axial_load=5e5)
    scenario = ColumnImpact("slender", slender, Striker(500.0, 2.0))
    assert slender.euler_load("weak") < 5e5 < euler_load(scenario)
    subjects = [finding.subject for finding in member_findings(scenario)]
    assert "buckling-weak" in subjects
    braced = replace(scenario, column=slender.changed(unbraced_length=2.0))
    assert "buckling-weak" not in [each.subject for each in member_findings(braced)]
    weak = replace(scenario, column=slender.changed(axis="weak"))
    assert any(each.refusal for each in member_findings(weak))


@pytest.mark.thorough
def test_residual_stresses_soften_the_weak_axis_first() -> None:
    scenario = ColumnImpact("weak", HEB, Striker(1500.0, 10.0))
    peaks = [
        float(
            make_model("fiber-shear", {"residual_stress": pattern})
            .simulate(scenario)
            .peak_displacement
        )
        for pattern in ("none", "triangular")
    ]
    assert peaks[1] == pytest.approx(peaks[0], rel=0.01)
    assert peaks[1] != peaks[0]


@pytest.mark.parametrize(
    ("values", "field"),
    [
        ({"axis": "minor"}, "column.axis"),
        ({"axis": "weak", "unbraced_length": 2.0}, "column.unbraced_length"),
        ({"head": "fixed", "head_weak": "pinned"}, "column.head_weak"),
        ({"base_weak": "free"}, "column.base_weak"),
    ],
)
def test_wrong_axes_are_refused_by_name(values: dict, field: str) -> None:
    with pytest.raises(InputError) as refused:
        Column("HEB 220", 0.8, 3.2, **values)
    assert refused.value.field == field


@pytest.mark.parametrize("model", ["four-dof", "single-dof", "energy-estimate", "fiber-shear"])
def test_plane_models_refuse_a_hit_off_their_plane(model: str) -> None:
    oblique = ColumnImpact("o", HEB.changed(axis="strong"), Striker(1500.0, 10.0, angle="30 deg"))
    response = make_model(model).simulate(oblique)
    assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
    assert "30 degrees off" in response.attrs["message"]
    rows = simulate_many(make_model(model), [oblique, oblique])
    assert set(rows["outcome"]) == {Outcome.OUT_OF_DOMAIN.value}


def test_an_angle_beside_the_weak_axis_is_refused() -> None:
    with pytest.raises(InputError, match=r"striker\.angle"):
        ColumnImpact("o", HEB, Striker(1500.0, 10.0, angle=0.5))


def test_the_answer_names_the_axis_and_has_an_interval_there() -> None:
    weak = wb.simulate(ColumnImpact("weak", HEB, Striker(1500.0, 10.0)), "four-dof")
    headline = weak.workbench.headline
    assert "bent about the weak axis" in headline
    assert "90 %: " in headline
    assert "bent about the weak axis" in weak.workbench.error.cell
    strong = HEB.changed(axis="strong")
    assert (
        "axis"
        not in wb.simulate(
            ColumnImpact("s", strong, Striker(1500.0, 10.0)), "four-dof"
        ).workbench.headline
    )
