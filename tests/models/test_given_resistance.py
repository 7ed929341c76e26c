"""Resistance curves that a user gives: against curves they are points of, closed forms, files."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from workbench.base.errors import InputError
from workbench.models.batch import simulate_many
from workbench.models.energy_estimate import EnergyEstimate, energy_to_absorb
from workbench.models.resistance import column_curve
from workbench.models.single_dof import SingleDof
from workbench.models.soft_impact import SoftImpact
from workbench.models.strain_rate import rate_factor
from workbench.responses import Outcome, outcome_of, warnings_of
from workbench.scenarios import ColumnPushover, MemberPulse, Pulse
from workbench.steel.materials import CowperSymonds
from workbench.study.cells import ingredients_of, key_of
from workbench.testing import check_model

# straight up, straight down, level: softens to two fifths
STIFFNESS, TOP, REST = 1e8, 1e6, 4e5
AT, FORCES = (0.0, 0.01, 0.21, 0.6), (0.0, TOP, REST, REST)


def write(path: Path, v, force) -> str:
    rows = (f"{a!r},{b!r}" for a, b in zip(map(float, v), map(float, force), strict=True))
    path.write_text("\n".join(["displacement_m,force_N", *rows]) + "\n")
    return str(path)


@pytest.fixture
def softening(tmp_path) -> str:
    return write(tmp_path / "softening.csv", AT, FORCES)


@pytest.mark.parametrize(
    ("shape", "kind", "tolerance"),
    [
        ("panel", SingleDof, 1e-12),  # its 220 straight pieces, one by one
        ("panel", EnergyEstimate, 1e-12),
        ("panel", SoftImpact, 1e-12),
        ("analytic", SingleDof, 6e-8),  # measured 3e-8: 4000 chords of a cubic
        ("analytic", EnergyEstimate, 6e-8),
    ],
)
def test_points_of_a_curve_answer_as_it(thesis_impact, tmp_path, shape, kind, tolerance) -> None:
    curve = column_curve(thesis_impact.column, None, shape)
    at = np.append(curve.starts, 0.72)  # nine tenths of the shorter bar
    if shape == "analytic":
        at = np.union1d(at[at < 0.7], np.linspace(0.0, 0.7, 4001))
    given = write(tmp_path / "curve.csv", at, curve.force(at))
    for velocity in (10.0, 20.0):
        impact = thesis_impact.at_velocity(velocity)
        stiff = {"striker_stiffness": 1e8} if kind is SoftImpact else {}
        ours, theirs = (kind(resistance=r, **stiff).simulate(impact) for r in (given, shape))
        assert outcome_of(ours) is Outcome.OK
        for name in ("peak_displacement", "residual_displacement"):
            assert float(ours[name]) == pytest.approx(float(theirs[name]), rel=tolerance)


def test_a_softening_curve_by_hand(thesis_impact, softening) -> None:
    """Energy over areas, residual by the first slope, time of the peak by scipy."""
    impact = thesis_impact.at_velocity(12.0)
    energy = energy_to_absorb(impact)  # joined masses
    triangle, slope = 0.5 * TOP * AT[1], (TOP - REST) / (AT[2] - AT[1])
    assert triangle < energy < triangle + 0.5 * (TOP + REST) * (AT[2] - AT[1])
    fallen = (TOP - sqrt(TOP**2 - 2.0 * slope * (energy - triangle))) / slope
    peak = AT[1] + fallen
    residual = peak - (TOP - slope * fallen) / STIFFNESS
    mass = impact.striker.mass + impact.column.properties.impact_mass

    def motion(_, y):
        return [y[1], -np.interp(y[0], AT, FORCES) / mass]

    def stops(_, y):
        return y[1]

    stops.terminal = True
    start = [0.0, sqrt(2.0 * energy / mass)]
    hand = solve_ivp(motion, (0.0, 1.0), start, events=stops, rtol=1e-10, max_step=1e-4)

    single = SingleDof(softening).simulate(impact)
    estimate = EnergyEstimate(softening).simulate(impact)
    for response in (single, estimate):
        assert float(response["peak_displacement"]) == pytest.approx(peak, rel=1e-9)
        assert float(response["residual_displacement"]) == pytest.approx(residual, rel=1e-9)
    assert float(single["time_of_peak"]) == pytest.approx(hand.t_events[0][0], rel=1e-3)
    # level behind the softening
    fast = thesis_impact.at_velocity(16.0)
    area = triangle + 0.5 * (TOP + REST) * (AT[2] - AT[1])
    level = AT[2] + (energy_to_absorb(fast) - area) / REST
    assert float(SingleDof(softening).simulate(fast)["peak_displacement"]) == pytest.approx(level)
    check_model(SingleDof(softening), [impact, fast, ColumnPushover("push", impact.column, 0.3)])


FACTOR = 1.4


def test_strain_rate_strengthens_a_curve_and_leaves_its_stiffness(thesis_impact, softening) -> None:
    """By hand: 1.4 times the force where that is below the first slope; the corner by its root."""
    fall = (TOP - REST) / (AT[2] - AT[1])  # k v = 1.4 (TOP - fall (v - AT[1]))
    corner = FACTOR * (TOP + fall * AT[1]) / (STIFFNESS + FACTOR * fall)
    top = STIFFNESS * corner
    assert AT[1] < corner < AT[2]
    impact = thesis_impact.at_velocity(12.0)
    energy, slope = energy_to_absorb(impact), FACTOR * fall
    fallen = (top - sqrt(top**2 - 2.0 * slope * (energy - 0.5 * top * corner))) / slope
    residual = corner + fallen - (top - slope * fallen) / STIFFNESS
    for kind in (SingleDof, EnergyEstimate):
        response = kind(softening, rate_factor=FACTOR).simulate(impact)
        assert float(response["peak_displacement"]) == pytest.approx(corner + fallen, rel=1e-9)
        assert float(response["residual_displacement"]) == pytest.approx(residual, rel=1e-9)
    stiff = {"striker_stiffness": 1e9}  # nearly rigid: more mass moves with the striker
    soft = float(SoftImpact(resistance=softening, rate_factor=FACTOR, **stiff).simulate(impact)[
        "peak_displacement"])  # fmt: skip
    assert soft == pytest.approx(corner + fallen, rel=0.1)
    points = [0.5 * corner, corner, AT[2], AT[3]]
    curve = SingleDof(softening, rate_factor=FACTOR).curve(impact.column)
    at = curve.force(np.array(points))
    np.testing.assert_allclose(at, [0.5 * top, top, FACTOR * REST, FACTOR * REST], rtol=1e-12)
    elastic = SingleDof(softening, rate_factor=10.0).curve(impact.column)  # hardly yields
    assert elastic.elastic_limit > 3.0 * AT[1]


def test_a_steel_that_knows_its_rate_strengthens_a_curve_as_it_does_the_column(
    thesis_impact, softening
) -> None:
    column = thesis_impact.column
    quick = replace(column, steel=replace(column.steel, rate=CowperSymonds(500.0, 5.0)))
    impact = replace(thesis_impact.at_velocity(12.0), column=quick)
    factor = rate_factor(impact)
    assert factor > 1.1
    single = SingleDof(softening).simulate(impact)
    fixed = SingleDof(softening, rate_factor=factor).simulate(thesis_impact.at_velocity(12.0))
    assert float(single["peak_displacement"]) == float(fixed["peak_displacement"])
    assert (
        single.attrs["rate_factor"] == factor == SingleDof().simulate(impact).attrs["rate_factor"]
    )
    many = simulate_many(SingleDof(softening), [impact])
    assert many["peak_displacement"][0] == float(single["peak_displacement"])
    pulse = MemberPulse("pulse", quick, Pulse("triangular", 1e6, 0.01), "point", 0.05)
    responses = [SingleDof(softening, rate_factor=r).simulate(pulse) for r in (None, 1.2)]
    findings = [{f.subject for f in warnings_of(response)} for response in responses]
    assert ["strain-rate" in each for each in findings] == [True, False]


def test_a_curve_that_drops_and_one_that_snaps(thesis_impact, tmp_path) -> None:
    """A drop over a micrometre by areas; a load above the valley of a curve, by scipy."""
    at, forces = (0.0, 0.01, 0.010001, 0.6), (0.0, 1e6, 2e5, 2e5)
    drop = write(tmp_path / "drop.csv", at, forces)
    impact = thesis_impact.at_velocity(8.0)
    energy = energy_to_absorb(impact)
    peak = at[2] + (energy - 0.5e6 * at[1] - 0.6e6 * (at[2] - at[1])) / forces[2]
    for model in (SingleDof(drop), EnergyEstimate(drop)):
        assert float(model.simulate(impact)["peak_displacement"]) == pytest.approx(peak, rel=1e-9)

    at, forces = (0.0, 0.01, 0.06, 0.3, 0.7), (0.0, 1e6, 3e5, 2e6, 3e6)
    snap = write(tmp_path / "snap.csv", at, forces)
    column = replace(thesis_impact.column, impact_mass=200.0)
    for load, snaps in ((4.5e5, False), (1.1e6, True)):
        pulse = MemberPulse("snap", column, Pulse("ramp", load, 0.05), "point", 0.12)

        def motion(t, y, load=load):
            return [y[1], (load * min(t / 0.05, 1.0) - np.interp(y[0], at, forces)) / 200.0]

        hand = solve_ivp(motion, (0.0, 0.12), [0.0, 0.0], rtol=1e-10, max_step=1e-4)
        response = SingleDof(snap).simulate(pulse)
        assert outcome_of(response) is Outcome.OK
        largest = float(response["displacement"].max())
        assert largest == pytest.approx(hand.y[0].max(), rel=2e-3)
        assert (largest > 0.05) == snaps


def test_behind_its_last_point_there_is_no_answer(thesis_impact, softening, tmp_path) -> None:
    fast = thesis_impact.at_velocity(25.0)
    pulse = MemberPulse("pulse", fast.column, Pulse("rectangular", 2e6, 0.05), "point", 0.06)
    push = ColumnPushover("push", fast.column, 0.65)
    single = SingleDof(softening)
    stiff = SoftImpact(resistance=softening, striker_stiffness=1e8)
    for model, scenario in [
        (single, fast), (single, pulse), (single, push), (EnergyEstimate(softening), fast),
        (stiff, fast),
    ]:  # fmt: skip
        response = model.simulate(scenario)
        assert outcome_of(response) is Outcome.OUT_OF_DOMAIN, (model, scenario.KIND)
        assert "ends at 0.6 m" in response.attrs["message"]
    lost = write(tmp_path / "lost.csv", (0.0, 0.01, 0.2), (0.0, 1e6, 0.0))
    assert outcome_of(SingleDof(lost).simulate(fast)) is Outcome.COLLAPSE


def test_shear_is_the_business_of_the_curve(thesis_impact, softening) -> None:
    assert "shear" in {f.subject for f in warnings_of(SingleDof().simulate(thesis_impact))}
    response = SingleDof(softening).simulate(thesis_impact)
    assert "shear" not in {f.subject for f in warnings_of(response)}
    assert "shear_utilisation" not in response or np.isnan(response["shear_utilisation"]).all()


def test_answers_follow_the_points(thesis_impact, softening) -> None:
    """The same name with other points: another key, another answer in the same process."""
    model = SingleDof(softening)
    key, peak = key_of(ingredients_of(thesis_impact, model)), model.simulate(thesis_impact)
    write(Path(softening), AT, np.multiply(FORCES, 2.0))
    assert key_of(ingredients_of(thesis_impact, model)) != key
    stronger = model.simulate(thesis_impact)
    assert float(stronger["peak_displacement"]) < 0.6 * float(peak["peak_displacement"])
    assert ingredients_of(thesis_impact, SingleDof())["data"] == ""


HEAD = "displacement_m,force_N\n0,0\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "cannot be read"),
        ("", "curve.csv = '': is empty"),
        ("displacement_mm,force_kN\n0,0\n1,2\n3,4\n", "must begin with the line"),
        (b"\xff\xfe\x00", "curve.csv, line 1 = .*is binary data, not text"),
        (HEAD + "0.1,1e6\n", "must have 3 to 10000 points, not 2"),
        (HEAD.replace("0,0", "0,5") + "0.1,1e6\n0.2,1e6\n", "line 2 = .*must be the point 0,0"),
        (HEAD + "0.1,1e6\n0.1,2e6\n", "line 4, displacement_m = 0.1: must be larger"),
        (HEAD + "0.1,0\n0.2,2e6\n", "line 3, force_N = 0.0: must be above 0"),
        (HEAD + "0.1,1e6\n\n0.2,-1\n", "line 5, force_N = -1.0: must be a number from 0"),
        (HEAD + "0.1,1e6\n0.2,nan\n", "line 4, force_N = nan"),
        (HEAD + "0.1,1e6\n0,2;3e5\n", "line 4 = '0,2;3e5': must be two numbers; decimals"),
        (HEAD + "0.1,1e6,7\n0.2,1e6\n", "line 3 = '0.1,1e6,7': must be two numbers"),
    ],
)
def test_bad_files_are_named_with_their_line(tmp_path, text, message) -> None:
    path = tmp_path / "curve.csv"
    if text is not None:
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError, match=message) as caught:
        SingleDof(str(path))
    assert "\n" not in str(caught.value)


def test_options_that_have_no_part_are_refused(softening) -> None:
    with pytest.raises(InputError, match=r"option\.rotational_stiffness = 6\.0: has no part"):
        SingleDof(softening, rotational_stiffness=6.0)
    with pytest.raises(InputError, match=r"option\.interaction = 'linear': has no part"):
        EnergyEstimate(softening, interaction="linear")
    with pytest.raises(InputError, match=r"option\.rate_factor = 1\.2: is for a curve .* rate law"):
        SoftImpact(rate_factor=1.2)
    with pytest.raises(InputError, match=r"option\.rate_factor = 0\.9: .* from 1 to 10"):
        SingleDof(softening, rate_factor=0.9)
    with pytest.raises(InputError, match=r"one of analytic, cubic.*or the name of a \.csv file"):
        SingleDof("softening")
