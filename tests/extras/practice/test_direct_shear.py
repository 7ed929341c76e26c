"""Direct shear beside flexure: slips by scipy and in closed form."""

from __future__ import annotations

from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from workbench.base.errors import CollapseError, InputError
from workbench.extras.practice.biggs import Biggs, slip_resistance, slips
from workbench.responses import Outcome, findings_of, outcome_of
from workbench.scenarios import Column, ColumnImpact, MemberPulse, Pulse, Striker
from workbench.steel.sections import find
from workbench.testing import check_model


@pytest.fixture(scope="module")
def stocky() -> Column:
    return Column(find("HEB 220"), 1.0, 1.0, fillets=False)


def blast(column: Column, share: float, length: float, load: str = "uniform") -> MemberPulse:
    """A rectangular pulse, half of it so many times V_pl."""
    force = 2.0 * share * column.properties.shear_resistance
    pulse = Pulse("rectangular", force / (column.length if load == "uniform" else 1.0), length)
    return MemberPulse("blast", column, pulse, load, 0.02)


def test_the_web_is_elastic_over_the_height_and_then_plastic(stocky) -> None:
    curve, steel = slip_resistance(stocky, "web"), stocky.steel
    elastic = steel.yield_stress / sqrt(3.0) / steel.shear_modulus * stocky.section.height
    force = stocky.properties.shear_resistance
    np.testing.assert_allclose(
        curve.force(elastic * np.array([0.5, 1.0, 30.0])), force * np.array([0.5, 1.0, 1.0])
    )


def test_a_steady_reaction_in_closed_form(stocky) -> None:
    """Below V_pl twice its static slip; above it, plastic from s_e on with what it has won."""
    curve, force = slip_resistance(stocky, "web"), stocky.properties.shear_resistance
    mass = 0.5 * stocky.properties.mass_per_length * stocky.length
    elastic = curve.elastic_limit
    frequency = sqrt(force / elastic / mass)
    time = np.linspace(0.0, 3.0 * pi / frequency, 40)
    low, high = slips(stocky, "web", time, np.outer([0.4, 1.6], np.full(40, force)))
    np.testing.assert_allclose(
        low, 0.4 * elastic * (1.0 - np.cos(frequency * time)), atol=2e-3 * elastic
    )
    yields = np.arccos(1.0 - 1.0 / 1.6) / frequency
    speed, pull = 1.6 * elastic * frequency * np.sin(frequency * yields), 0.6 * force / mass
    left = time[time > yields] - yields
    plastic = elastic + speed * left + 0.5 * pull * left**2
    np.testing.assert_allclose(high[time > yields], plastic, rtol=1e-3)


def test_slips_under_dynamic_reactions_by_scipy(stocky) -> None:
    response = Biggs(direct_shear="web").simulate(blast(stocky, 1.4, 0.004))
    plain = Biggs().simulate(blast(stocky, 1.4, 0.004))
    assert float(response["peak_displacement"]) == float(plain["peak_displacement"])
    time, reaction = response["time"].values, response["reaction"].values
    slip = response["direct_shear.slip"].values
    curve, force = slip_resistance(stocky, "web"), stocky.properties.shear_resistance
    mass = 0.5 * stocky.properties.mass_per_length * stocky.length
    stiffness = force / curve.elastic_limit

    def motion(t, y):  # slip, velocity, force of the web
        flows = abs(y[2]) >= force and y[1] * y[2] > 0.0
        pull = np.interp(t, time, reaction[0]) - y[2]
        return [y[1], pull / mass, 0.0 if flows else stiffness * y[1]]

    hand = solve_ivp(motion, (0.0, time[-1]), [0.0] * 3, t_eval=time, max_step=2e-5, rtol=1e-7)
    assert np.abs(slip[0] - hand.y[0]).max() < 5e-3 * slip.max()
    np.testing.assert_allclose(slip[1], slip[0])  # both ends alike
    assert slip.max() > 10.0 * curve.elastic_limit
    findings = {each.subject: each.number for each in findings_of(response)}
    assert findings["slip"] == pytest.approx(1e3 * slip.max())


def test_points_that_end_shear_the_member_off(stocky, tmp_path: Path) -> None:
    """A law of concrete falls; behind its last point the support holds nothing."""
    force = stocky.properties.shear_resistance
    path = tmp_path / "slip.csv"
    rows = ("0,0", f"0.0003,{force!r}", f"0.001,{force!r}", f"0.004,{0.3 * force!r}")
    path.write_text("\n".join(["displacement_m,force_N", *rows]) + "\n")
    model = Biggs(direct_shear=str(path))
    assert model.data_digest
    survives, falls = blast(stocky, 0.5, 5e-4), blast(stocky, 1.4, 0.004)
    assert outcome_of(model.simulate(survives)) is Outcome.OK
    response = model.simulate(falls)
    assert outcome_of(response) is Outcome.COLLAPSE
    assert "the base slides beyond its resistance to direct shear" in response.attrs["message"]
    time = np.linspace(0.0, 0.01, 50)
    with pytest.raises(CollapseError, match="the head slides"):
        slips(stocky, str(path), time, np.outer([0.1, 2.0], np.full(50, force)))
    check_model(Biggs(direct_shear="web"), [survives, falls])


def test_what_has_no_line_load_is_refused(stocky) -> None:
    hit = ColumnImpact("hit", stocky, Striker(500.0, 5.0))
    for scenario in (blast(stocky, 1.4, 0.004, "point"), hit):
        response = Biggs(direct_shear="web").simulate(scenario)
        assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
        assert "no line load here" in response.attrs["message"]
    with pytest.raises(InputError, match=r"direct_shear = 'webb': must be one of none, web, or"):
        Biggs(direct_shear="webb")
