"""Four-DOF column with panels: independent numbers, limits, ledger, random columns, bad input."""

from dataclasses import replace

import numpy as np
import pytest
from builders import THESIS_SPRINGS, Answers, plateau

from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.references.fiber_beams import FiberShear
from workbench.responses import Outcome, collapse_of, outcome_of, warnings_of
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, Striker
from workbench.steel.hinges import ShearSurface
from workbench.steel.materials import Steel
from workbench.steel.sections import circular_tube, find, i_section, square

# An implementation of its own with six unknowns (rotations of the sections among them): forces in
# kN, steps of 0.25 to 1 mm, regularised by 1e-6 of the elastic stiffness; peaks in m at steps of
# 0.1 ms, to four digits
AT = (0.001, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.7)
STATIC_KN = {
    "clear": (114.13, 402.05, 421.44, 460.33, 480.00, 463.52, 511.89, 678.21, 1088.76, 1695.76,
              2859.97),
    "centre": (119.40, 436.06, 458.67, 497.95, 511.76, 495.67, 545.09, 711.62, 1117.11, 1676.48,
               2860.00),
}  # fmt: skip
VELOCITIES = (5.0, 10.0, 15.0, 20.0)
PEAKS = {
    "clear": (0.0405, 0.1533, 0.3103, 0.4373),
    "centre": (0.0379, 0.1435, 0.2964, 0.4267),
}
KINDS = sorted(STATIC_KN)


class ClearWeb(FourDofShear):
    """Webs that carry shear between the flanges alone, as those of fibers do."""

    def surface(self, column: Column) -> ShearSurface:
        return ShearSurface(column.strength_section, column.steel, "clear")


def model(kind: str, **options) -> FourDofShear:
    """The model as its numbers were derived: with the lumped mass and the springs of the thesis."""
    options = {"hit_mass": "thesis", **THESIS_SPRINGS, **options}
    return ClearWeb(**options) if kind == "clear" else FourDofShear(**options)


def ledger(response, scenario: ColumnImpact) -> float:
    return float(np.max(np.abs(response["balance_error"]))) / scenario.input_energy


@pytest.mark.claim("model:four-dof-shear", "static force, error", "independent code", 0, 1.5e-3)
@pytest.mark.parametrize("kind", KINDS, ids="-".join)
def test_static_forces_of_the_thesis_column(kind, thesis_impact, claim) -> None:
    response = model(kind).simulate(ColumnPushover("push", thesis_impact.column, 0.7))
    force = np.interp(AT, response["displacement"], response["force"]) / 1e3
    # stated 0.15 %; measured 0.14 % below 10 mm, 0.08 % at most beyond
    claim(np.abs(force / STATIC_KN[kind] - 1.0).max())


@pytest.mark.parametrize("kind", KINDS, ids="-".join)
def test_peaks_of_the_thesis_column(kind, thesis_impact) -> None:
    scenarios = [thesis_impact.at_velocity(velocity) for velocity in VELOCITIES]
    responses = [model(kind, time_step=1e-4).simulate(scenario) for scenario in scenarios]
    peaks = [float(response["peak_displacement"]) for response in responses]
    # stated 1e-3, and half of the last digit printed; measured 5e-5 m
    np.testing.assert_allclose(peaks, PEAKS[kind], rtol=1e-3, atol=5e-5)
    for scenario, response in zip(scenarios, responses, strict=True):
        assert ledger(response, scenario) < 1e-6  # measured 8e-8
        given = model(kind).simulate(scenario)  # with the step the model chooses
        peak = float(response["peak_displacement"])
        assert float(given["peak_displacement"]) == pytest.approx(peak, rel=2e-3)  # measured 1.6e-3
        assert ledger(given, scenario) < 1e-6


@pytest.mark.parametrize(("restitution", "peak"), [(0.0, 0.3103), (0.5, 0.3097)])
def test_restitution(restitution, peak, thesis_impact) -> None:
    striker = replace(thesis_impact.striker, restitution=restitution)
    scenario = replace(thesis_impact, striker=striker)
    response = model("clear", time_step=2e-5).simulate(scenario)
    # stated 1e-3; measured 4e-4
    assert float(response["peak_displacement"]) == pytest.approx(peak, rel=1e-3)


class Strong(ShearSurface):
    """A web without bound in shear, stiffness and strength."""

    @property
    def record(self):
        given = super().record.copy()
        given["shear"], given["stiffness"] = 1e7 * given["shear"], 1e7 * given["stiffness"]
        return given


class StrongWeb(FourDofShear):
    def surface(self, column: Column) -> Strong:
        return Strong(column.strength_section, column.steel)


def test_without_shear_it_is_the_column_with_the_exact_interaction(thesis_impact) -> None:
    # peaks of an own implementation with the exact N-M envelope of the plates
    expected = (0.02462, 0.08812, 0.18958, 0.31918)
    for velocity, peak in zip(VELOCITIES, expected, strict=True):
        response = StrongWeb(time_step=1e-4, hit_mass="thesis", **THESIS_SPRINGS).simulate(
            thesis_impact.at_velocity(velocity)
        )
        # five digits printed; measured 1.2e-4
        assert float(response["peak_displacement"]) == pytest.approx(peak, rel=5e-4)


def test_elastic_column_is_bending_and_shear_in_series() -> None:
    column = Column(find("HEB 220"), 2.0, 2.0, fillets=False)
    response = FourDofShear().simulate(ColumnPushover("elastic", column, 1e-5))
    stiffness = float(response["force"][1] / response["displacement"][1])
    steel = column.steel
    bending = 192.0 * steel.elastic_modulus * column.properties.second_moment / 4.0**3
    web = ShearSurface(column.strength_section, steel).record["stiffness"]
    series = 1.0 / (1.0 / bending + 1.0 / web)  # two panels side by side, 2 m each
    assert stiffness == pytest.approx(series, rel=1e-8)  # measured 2e-10


@pytest.mark.claim(
    "model:four-dof-shear", "limit load, hit at {below} m, N", "closed form", "{expected}", 1e3
)
@pytest.mark.parametrize(
    ("below", "expected"),
    [(0.4, 515.2e3), (0.8, 533.7e3), (2.0, 549.2e3)],
)
def test_limit_loads_without_axial_force(below: float, expected: float, claim) -> None:
    # panel below slides, R0 = Vpl + Vb with Vb Lb = Mf + Mc(Vb); at 2 m bending, V L = 2 Mc(V)
    column = Column(find("HEB 220"), below, 4.0 - below, fillets=False)
    response = model("clear").simulate(ColumnPushover("limit", column, 0.04))
    # all hinges flow and the chords have hardly turned
    claim(response["force"][-1])


def test_a_slender_panel_agrees_with_the_column_without_shear() -> None:
    # the length of transition of HEB 220 is 2 Mf / Vpl = 1.39 m
    for restraint, other in ((0.0, FourDof()), (1e7, StrongWeb())):
        column = Column(find("HEB 220"), 3.0, 3.0, fillets=False, restraint_stiffness=restraint)
        push = ColumnPushover("slender", column, 0.3)
        pair = (model.simulate(push) for model in (FourDofShear(), other))
        forces = [np.interp([0.05, 0.1, 0.2, 0.3], r["displacement"], r["force"]) for r in pair]
        assert forces[0] == pytest.approx(forces[1], rel=0.02)


def random_impact(rng: np.random.Generator) -> ColumnImpact:
    section = find(rng.choice(["HEB 220", "HEB 300", "IPE 300", "HEA 200", "HEB 160", "IPE 400"]))
    squash = section.without_fillets().squash_load(Steel())
    length, share = rng.uniform(2.5, 6.0), rng.uniform(0.08, 0.92)
    column = Column(
        section,
        share * length,
        (1.0 - share) * length,
        base=rng.choice(["clamped", "pinned"]).item(),
        head=rng.choice(["guided", "pinned", "fixed"]).item(),
        fillets=False,
        axial_load=rng.uniform(-0.2, 0.5) * squash,
        restraint_stiffness=rng.choice([0.0, 1e7, 1e8]).item(),
        head_mass=rng.choice([0.0, 500.0]).item(),
    )
    striker = Striker(rng.uniform(100, 5e3), rng.uniform(1, 40), rng.choice([0.0, 0.5, 1.0]).item())
    return ColumnImpact("random", column, striker, 0.15)


@pytest.mark.parametrize(
    "count", [60, pytest.param(400, marks=pytest.mark.slow)], ids=["some", "all"]
)
def test_random_columns_close_their_ledger_or_say_why_not(count: int) -> None:
    rng, answers, typed = np.random.default_rng(10), Answers(), 0
    for _ in range(count):
        scenario = random_impact(rng)
        response = FourDofShear().simulate(scenario)
        outcome = outcome_of(response)
        typed += outcome is not Outcome.NOT_CONVERGED
        if outcome is Outcome.OK:
            assert ledger(response, scenario) < 1e-6
            assert float(response["shear_utilisation"].max()) <= 1.0 + 1e-9
        turned = scenario.input_energy / scenario.column.properties.plastic_moment
        asked = turned < 0.5 and outcome is not Outcome.COLLAPSE
        answers.note(FourDofShear(), scenario, response, asked=asked)
    # the others lose their axial equilibrium: heavy load, no restraint, no mass at the head
    assert typed >= 0.95 * count  # measured 398 of 400
    answers.demand(0.98, of=count // 10)


def test_sections_and_columns_that_panels_do_not_hold_for(thesis_impact) -> None:
    column = thesis_impact.column
    tube = Column(circular_tube(0.2, 0.01), 0.8, 3.2)
    response = FourDofShear().simulate(replace(thesis_impact, column=tube))
    assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
    assert "plane webs" in response.attrs["message"]
    thin = Column(i_section(0.8, 0.2, 0.006, 0.012), 1.8, 3.2)
    (finding,) = FourDofShear().domain(replace(thesis_impact, column=thin))
    assert finding.refusal
    assert finding.number == pytest.approx((0.776 / 0.006) / (60.0 * np.sqrt(235 / 355)), rel=1e-3)
    overridden = replace(column, plastic_moment=2.0 * column.plastic_moment)
    (finding,) = FourDofShear().domain(replace(thesis_impact, column=overridden))
    assert finding.refusal
    weaker = replace(column, plastic_moment=0.95 * column.properties.plastic_moment)
    (finding,) = FourDofShear().domain(replace(thesis_impact, column=weaker))
    assert not finding.refusal
    assert finding.number == pytest.approx(1.0 / 0.95, rel=1e-4)
    filleted = Column(find("HEB 220"), 0.8, 3.2)
    response = FourDofShear().simulate(replace(thesis_impact, column=filleted))
    assert outcome_of(response) is Outcome.OK
    subjects = {finding.subject for finding in warnings_of(response)}
    assert "plates" not in subjects  # the panels have the fillets


def test_limit_load_of_a_column_with_root_fillets() -> None:
    column = Column(find("IPE 300"), 3.0, 3.0)
    response = FourDofShear().simulate(ColumnPushover("limit", column, 0.1))
    surface, force = FourDofShear().surface(column), float(response["force"][-1])
    assert force == pytest.approx(plateau(surface, (3.0, 3.0)), rel=5e-3)
    # of bending alone, to which V/Vpl = 0.36 is 1.3 %; plates alone had 0.945
    assert force == pytest.approx(4.0 * column.properties.plastic_moment / 3.0, rel=0.015)


def test_hinges_turn_by_bending_alone_however_a_bar_slides(thesis_impact) -> None:
    """Before, the chord of a sliding bar turned all hinges by 0.04 rad."""
    low = replace(thesis_impact.column, length_below=0.5)
    response = FourDofShear().simulate(replace(thesis_impact.at_velocity(5.0), column=low))
    assert float(response["largest_sliding"]) > 0.03
    assert 0.005 < np.abs(response["plastic_rotation"].values[:, -1]).max() < 0.01


def test_collapse_is_typed(thesis_impact) -> None:
    response = FourDofShear().simulate(thesis_impact.at_velocity(60.0))
    assert outcome_of(response) is Outcome.COLLAPSE
    assert collapse_of(response).parts == ("below",)


def test_a_bar_that_is_shortened_and_turns_over_has_collapsed(parked) -> None:
    """It never moves by nine tenths of its first length, and comes to rest hanging."""
    response = FourDofShear().simulate(replace(parked.at_velocity(9.0), duration=0.2))
    collapse = collapse_of(response)
    assert collapse.mechanism == "geometry"
    assert collapse.parts == ("below",)
    assert 0.7 * 0.6 < collapse.displacement < 0.9 * 0.6


@pytest.mark.claim("model:four-dof-shear", "peak, {below} m, ratio", "independent code", 1, "{rel}")
@pytest.mark.parametrize(("below", "rel"), [(0.8, 0.03), (2.0, 0.02)])
def test_a_solid_square_follows_the_beam_with_the_same_domain(below, rel, claim) -> None:
    # fibers with one shear strain per section, sigma^2 + 3 tau^2 <= fy^2: the exact set integrated
    column = Column(square(0.2), below, 4.0 - below, axial_load=5e5, restraint_stiffness=1e7)
    scenario = ColumnImpact("square", column, Striker(6000.0, 10.0), 0.08)
    response = model(("section", "centre")).simulate(scenario)
    beam = FiberShear(levels=1, refinement=-1).simulate(scenario)
    expected = float(beam["peak_displacement"])
    claim(response["peak_displacement"] / expected)
    assert ledger(response, scenario) < 1e-6


def test_a_stub_is_warned_about(thesis_impact) -> None:
    (finding,) = FourDofShear().domain(
        replace(thesis_impact, column=Column(find("HEB 220"), 0.4, 3.6, fillets=False))
    )
    assert not finding.refusal
    assert finding.number == pytest.approx(0.4 / 0.22, rel=1e-12)
    # two flanges with two plastic hinges each, b t^2 / 4 f_y
    mechanism = 4.0 * 0.22 * 0.016**2 / 4.0 * 355e6 / 0.4
    assert f"{mechanism / 397.2e3:.2f} of V_pl" in finding.text
    assert FourDofShear().domain(thesis_impact) == []
