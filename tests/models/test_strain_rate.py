"""One factor for the strain rate (level A), and what models say that leave the rate out."""

import tomllib
from dataclasses import replace
from typing import Any

import pytest

from workbench.base.errors import InputError
from workbench.models.base import make_model
from workbench.models.batch import simulate_many
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.single_dof import SingleDof
from workbench.models.strain_rate import rate_factor, stronger, with_rate
from workbench.responses import findings_of
from workbench.scenarios import (
    ColumnImpact,
    ColumnPushover,
    MemberPulse,
    Pulse,
    Scenario,
    scenario_from,
    to_toml,
)
from workbench.steel.hinges.panel_elements import hinge_overstress, overstress_shape
from workbench.steel.materials import GRADES, MILD_STEEL, CowperSymonds, Steel


def read(text: str) -> Any:
    return scenario_from(tomllib.loads(text))


def steel(**given: Any) -> Steel:
    return Steel(**given)


SMOOTH = {"levels": 1, "steel_law": "menegotto-pinto"}
LEVEL_A = ("four-dof", "four-dof-shear", "single-dof", "energy-estimate", "hand-estimate")


@pytest.fixture
def rated(thesis_impact: ColumnImpact) -> ColumnImpact:
    return with_rate(thesis_impact, MILD_STEEL)


def test_a_steel_in_a_file(thesis_impact: ColumnImpact) -> None:
    """Grades and named laws are shorthands; a law is written with its range, and read again."""
    assert steel(grade="S235") == steel(yield_stress=235e6, rate="S235")
    assert steel(grade="S355", rate="none") == steel()
    assert steel(grade="S355", yield_stress=400e6, rate="none") == steel(yield_stress=400e6)
    assert steel(hardening_modulus=0.0) == steel()
    text = to_toml(thesis_impact)
    assert "rate" not in text
    for law in (MILD_STEEL, GRADES["S460"][1]):
        again = read(to_toml(with_rate(thesis_impact, law)))
        assert again.column.steel.rate == law
    short = text.replace("[steel]", '[steel]\ngrade = "S355"').replace("yield_stress", "#")
    assert read(short).column.steel == steel(grade="S355")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('rate = "S999"', "steel.rate = 'S999': must be a rate law, or one of S235"),
        ("rate = 5.0", "steel.rate = 5.0: must be a table or the name of a grade"),
        ("rate = { D = 40.4 }", "steel.rate.q: is missing"),
        ("rate = { D = 0.0, q = 5.0 }", "steel.rate.D = 0.0: must be a number from 0.001"),
        ("rate = { D = 40.4, q = 0.5 }", "steel.rate.q = 0.5: must be a number from 1 to 50"),
        ('rate = { law = "norton", D = 40.4, q = 5.0 }', "must be one of cowper-symonds"),
        ("rate = { D = 40.4, p = 5.0 }", "steel.rate.p: unknown key"),
        ("rate = { D = 40.4, q = 5.0, D_range = [50.0, 90.0] }", "D = 40.4 1/s between them"),
        ("rate = { D = 40.4, q = 5.0, D_range = 3.0 }", "steel.rate.D_range = 3.0: must be two"),
        ('grade = "S356"', "steel.grade = 'S356': must be one of S235"),
        ("thickness = 0.02", "steel.thickness = 0.02: lowers the yield stress of a grade"),
        ('grade = "S355"\nthickness = 20.0', "steel.thickness = 20.0: must be a number from"),
        ("hardening_modulus = -1.0", "steel.hardening_modulus = -1.0: must be a number from 0"),
    ],
)
def test_wrong_values_of_a_steel(thesis_impact: ColumnImpact, line: str, words: str) -> None:
    text = to_toml(thesis_impact).replace("[steel]", f"[steel]\n{line}")
    with pytest.raises(InputError) as refused:
        read(text)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_thick_plates_of_a_grade_yield_earlier() -> None:
    """EN 10025-2, table 6: the bounds belong to the thinner class."""
    stress = {t: Steel(grade="S355", thickness=t).yield_stress for t in (0.016, 0.0161, 0.04, 0.1)}
    assert list(stress.values()) == [355e6, 345e6, 345e6, 315e6]
    assert Steel(grade="S460", thickness=0.07).yield_stress == 400e6
    assert Steel(grade="S235", thickness=0.05).yield_stress == 215e6
    assert Steel(grade="S235", thickness=0.01) == Steel(grade="S235")
    assert Steel(grade="S355", thickness=0.05, yield_stress=390e6).yield_stress == 390e6


def test_the_factor_of_the_thesis_column(thesis_impact: ColumnImpact) -> None:
    """Of hinges and of sliding webs, at three velocities and with three steels."""
    column = replace(thesis_impact.column, plastic_moment=None, squash_load=None)
    hinges, webs = {}, {}
    for D in (40.4, 500.0, 6000.0):
        hit = with_rate(replace(thesis_impact, column=column), CowperSymonds(D, 5.0))
        hits = [hit.at_velocity(v) for v in (10.0, 15.0, 20.0)]
        hinges[D] = [rate_factor(each) for each in hits]
        webs[D] = [rate_factor(each, shear_yields=True) for each in hits]
    assert webs[40.4] == pytest.approx([1.612, 1.661, 1.699], abs=5e-3)
    assert webs[500.0] == pytest.approx([1.376, 1.406, 1.429], abs=3e-3)
    assert webs[6000.0] == pytest.approx([1.233, 1.252, 1.266], abs=2e-3)
    assert all(a > b for D in webs for a, b in zip(hinges[D], webs[D], strict=True))
    assert rate_factor(with_rate(hit, CowperSymonds(1e30, 1.0))) == pytest.approx(1.0, abs=1e-14)


def test_a_pinned_bar_has_one_hinge_and_its_whole_length(parked: ColumnImpact) -> None:
    column = replace(parked.column, base="pinned", head="pinned", steel=steel(rate=MILD_STEEL))
    column = replace(column, length_below=2.0, length_above=2.0)
    hit = replace(parked, column=column)
    striker, struck = hit.striker.mass, column.properties.impact_mass
    turning = hit.striker.velocity * striker / (striker + struck) / 2.0
    shape = overstress_shape(column.strength_section, 5.0)
    over = hinge_overstress(turning, 2.0, column.section.height, shape, MILD_STEEL)
    assert rate_factor(hit) == pytest.approx(1.0 + 12.0 / 13.0 * over)


@pytest.mark.parametrize("name", LEVEL_A)
def test_a_model_runs_with_the_factor(rated: ColumnImpact, name: str) -> None:
    model = make_model(name)
    answer = model.simulate(rated)
    factor = rate_factor(rated, getattr(model, "shear_yields", False))
    same = model.simulate(stronger(rated, factor))
    assert answer.attrs["rate_factor"] == factor
    assert float(answer["peak_displacement"]) == float(same["peak_displacement"])
    assert "rate_factor" not in same.attrs
    assert answer.attrs["scenario_hash"] != same.attrs["scenario_hash"]
    assert "strain-rate" not in [each.subject for each in findings_of(answer)]


@pytest.mark.parametrize("kind", [SingleDof, EnergyEstimate])
def test_a_curve_of_sliding_webs_has_their_factor(rated: ColumnImpact, kind: type[Any]) -> None:
    """One mass on the resistance of panels grows as the panels do."""
    answer = kind(resistance="panel", hit_mass="waves").simulate(rated)
    expected = make_model("four-dof-shear").simulate(rated)
    assert answer.attrs["rate_factor"] == expected.attrs["rate_factor"] == rate_factor(rated, True)
    assert float(answer.peak_displacement) == pytest.approx(
        float(expected.peak_displacement), rel=0.01
    )


def test_many_columns_have_their_factors_too(rated: ColumnImpact) -> None:
    many = simulate_many(SingleDof(), [rated])
    alone = SingleDof().simulate(rated)
    assert many["peak_displacement"][0] == float(alone["peak_displacement"])


def test_statics_know_no_rate(rated: ColumnImpact) -> None:
    push = ColumnPushover("push", rated.column, 0.05)
    still = replace(push, column=replace(push.column, steel=steel(rate="none")))
    model = make_model("four-dof")
    with_law, without = model.simulate(push), model.simulate(still)
    assert "rate_factor" not in with_law.attrs
    assert "strain-rate" not in [each.subject for each in findings_of(with_law)]
    assert float(with_law["force"][-1]) == float(without["force"][-1])


def test_what_leaves_the_rate_out_says_so(rated: ColumnImpact) -> None:
    """Pulses and references that do not know it run with the static yield stress."""

    def subjects(name: str, scenario: Scenario) -> list[str]:
        answer = make_model(name, SMOOTH if name == "fiber-reissner" else {}).simulate(scenario)
        assert "rate_factor" not in answer.attrs
        return [each.subject for each in findings_of(answer)]

    pulse = MemberPulse("pulse", rated.column, Pulse("triangular", 1e5, 0.01), "uniform", 0.01)
    assert "strain-rate" in subjects("biggs", pulse)
    assert "strain-rate" in subjects("fiber-reissner", replace(rated, duration=0.002))
    hardening = replace(rated.column, steel=steel(hardening_modulus=2.1e9))
    assert "hardening" in subjects("four-dof", replace(rated, column=hardening))


def test_nothing_was_measured_with_a_factor_that_was_not_drawn(rated: ColumnImpact) -> None:
    """A law much steeper than that of mild steel."""
    from workbench.study.error_model.error_model import expected_error

    steep = with_rate(rated, CowperSymonds(0.5, 5.0))
    error = expected_error(steep, make_model("four-dof").simulate(steep))
    assert error.expected is None
    assert "factor on the yield stress for the strain rate" in error.reason


def test_the_range_of_a_grade_holds_overstress_that_fades() -> None:
    """Webs of A992 at 2 1/s: 0.45 fy at yield, 0.20 of fu = 1.3 fy at the ultimate stress."""
    law = Steel(rate="S355").rate
    assert law is not None
    ends = sorted((law.slow or 0.0, law.fast or 0.0), reverse=True)
    least, largest = ((2.0 / D) ** (1.0 / law.exponent) for D in ends)
    assert least < 0.20 * 1.3 < 0.45 < largest
