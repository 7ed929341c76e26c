"""The struck solid: mass, waves, frequencies, momentum, ledger, slow strikes, contract."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.sparse import diags_array
from scipy.sparse.linalg import eigsh

from workbench.base.errors import SolverError
from workbench.mechanics.structures.explicit import explicit_impact
from workbench.mechanics.structures.impact import PointMass
from workbench.models.references.fiber_beams import FiberShear
from workbench.models.references.solid import SolidPlaneStress
from workbench.models.references.solid.kernels import SolidAssembly, nodal_mass, solid_column
from workbench.models.superelements import FlexibleSuperelement
from workbench.responses import Outcome, Response, energy_error, outcome_of
from workbench.responses.uncertainty import WIDTHS
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, MemberPulse, Pulse, Striker
from workbench.steel.materials import MILD_STEEL, Steel
from workbench.steel.sections import find, rectangle
from workbench.testing import check_model

pytestmark = pytest.mark.thorough

STEEL = Steel()
THESIS = Column(find("HEB 220"), 0.8, 3.2, fillets=False, axial_load=0.5e6, restraint_stiffness=1e7)
BAR = Column(rectangle(0.1, 0.05), 1.0, 1.0)
NEVER = PointMass(1e6, 1.0, 0.0, position=-1.0)  # a striker that comes too late


def solid_of(column: Column, refinement: int = -1) -> SolidAssembly:
    return solid_column(column, refinement=refinement)


def width_of(response: Response) -> float:
    """Stated numerical half-width of the peak, in m."""
    return float(json.loads(response.attrs[WIDTHS])["peak_displacement"])


def strike(
    column: Column, mass: float, velocity: float, duration: float, restitution=0.0, **options
) -> Response:
    model = SolidPlaneStress(**{"levels": 1, "refinement": -1, **options})
    scenario = ColumnImpact("strike", column, Striker(mass, velocity, restitution), duration)
    response = model.simulate(scenario)
    assert outcome_of(response) is Outcome.OK, response.attrs["message"]
    return response


@pytest.fixture(scope="module")
def thesis_strike() -> Response:
    return strike(THESIS, 1500.0, 15.0, 0.055)


# --- mass -----------------------------------------------------------------------------------


@pytest.mark.parametrize("ends", [("clamped", "guided"), ("pinned", "pinned")])
def test_mass_of_the_unknowns_is_that_of_the_moving_nodes(ends: tuple[str, str]) -> None:
    column = replace(THESIS, base=ends[0], head=ends[1], head_mass=70.0)
    solid = solid_of(column)
    supports, mesh = solid.supports, solid.mesh
    mass, nodal = solid.mass, nodal_mass(solid.mesh, column)
    assert np.all(mass > 0.0)
    lengthwise = np.unique(mesh.dofs[:, 1::2])
    whole = column.properties.mass_per_length * column.length
    assert nodal[lengthwise].sum() == pytest.approx(whole, rel=1e-12)
    # kinetic energy of the nodes at random places and velocities, plates turned far
    random = np.random.default_rng(2)
    q, speed = random.uniform(-1.0, 1.0, (2, supports.unknowns))
    nodes = supports.derivative(q) @ speed
    kinetic = 0.5 * np.sum(nodal * nodes**2) + 0.5 * 70.0 * speed[supports.head] ** 2
    assert 0.5 * np.sum(mass * speed**2) == pytest.approx(kinetic, rel=1e-12)


# --- waves and frequencies ------------------------------------------------------------------


def test_a_sudden_load_on_the_head_runs_through_the_bar_as_a_wave() -> None:
    solid = solid_of(BAR)
    head = solid.supports.head
    load = 0.2 * BAR.properties.squash_load  # doubled by reflection, far below yield
    solid.load[head] = -load
    modulus, area = STEEL.elastic_modulus, BAR.section.area
    speed = np.sqrt(modulus * area / BAR.properties.mass_per_length)
    passage = BAR.length / speed
    spans = [(4.0 * passage, passage / 50.0)]
    seen = [
        (step.time, -float(solid.displacement[head]))
        for step in explicit_impact(solid, solid.supports.hit, NEVER, spans)
    ]
    time, shortening = np.array(seen).T
    static = load * BAR.length / (modulus * area)
    # d'Alembert: rises at F / (rho c A) until the reflection is back at 2 L / c, then falls
    expected = static * np.minimum(time, 4.0 * passage - time) / passage
    assert np.max(np.abs(shortening - expected)) < 0.06 * static
    early = (time > 0.2 * passage) & (time < 1.8 * passage)
    slope = np.polyfit(time[early], shortening[early], 1)[0]
    assert slope == pytest.approx(static / passage, rel=0.01)


@pytest.mark.parametrize("slenderness", [8.0, 20.0])
def test_frequencies_are_timoshenkos(slenderness: float) -> None:
    height = 0.1
    length = slenderness * height
    column = Column(rectangle(height, 0.05), length / 2, length / 2, base="pinned", head="pinned")
    solid = solid_of(column, refinement=0)
    solid.assemble(solid.displacement)
    root = 1.0 / np.sqrt(solid.mass)
    scaled = diags_array(root) @ solid.tangent @ diags_array(root)
    result = np.sqrt(eigsh(scaled, k=6, sigma=0.0, return_eigenvectors=False))[::-1]
    bending = [timoshenko(column, mode) for mode in (1, 2, 3)]
    for expected in bending:
        nearest = result[np.argmin(np.abs(result - expected))]
        assert nearest == pytest.approx(expected, rel=0.01)


def timoshenko(column: Column, mode: int) -> float:
    """Circular frequency of a pinned beam, 1/s: the lower root of its characteristic equation."""
    modulus, section = STEEL.elastic_modulus, column.section
    mass, turning = column.properties.mass_per_length, STEEL.density * section.second_moment
    shear, k = 5.0 / 6.0 * STEEL.shear_modulus * section.area, mode * np.pi / column.length
    bending = modulus * section.second_moment * k**2

    def determinant(omega: float) -> float:
        first = shear * k**2 - mass * omega**2
        return first * (bending + shear - turning * omega**2) - (shear * k) ** 2

    slender = k * np.sqrt(bending / mass)
    return float(brentq(determinant, 0.3 * slender, slender))


# --- momentum, energy, slow strikes ---------------------------------------------------------


def test_momentum_stays_until_the_supports_feel_the_strike() -> None:
    solid = solid_of(replace(THESIS, axial_load=0.0))
    striker = PointMass(1500.0, 15.0)
    nodal = nodal_mass(solid.mesh, THESIS)
    sideways = np.unique(solid.mesh.dofs[:, 0::2])
    for step in explicit_impact(solid, solid.supports.hit, striker, [(6e-5, 1e-5)]):
        velocity = solid.supports.tied @ solid.velocity
        assert step.striker is not None
        total = step.striker.velocity * 1500.0 + nodal[sideways] @ velocity[sideways]
        # velocities of nodes are half a step older or newer than the impulses
        assert total == pytest.approx(1500.0 * 15.0, rel=1e-4)


def test_the_ledger_closes_and_the_striker_gives_what_it_loses(thesis_strike) -> None:
    error = energy_error(thesis_strike)
    assert error is not None
    assert error < 4e-9  # measured 2.2e-9
    lost = 1500.0 * (15.0 - thesis_strike["striker_velocity"].values[-1])
    assert thesis_strike["percussion"].values.sum() == pytest.approx(lost, rel=1e-12)
    assert np.all(np.diff(thesis_strike["dissipated"]) >= 0.0)
    # only the hit section is brought to speed at once: the thesis' lumped mass loses 6 %
    share = float(thesis_strike["contact_loss"][-1] / thesis_strike["input_energy"])
    assert 0.0 < share < 0.002


def test_a_strike_without_loss_in_the_contact() -> None:
    response = strike(replace(BAR, axial_load=1e5), 50.0, 2.0, 0.004, restitution=1.0)
    assert float(response["contact_loss"][-1]) == pytest.approx(0.0, abs=1e-9 * 100.0)
    assert energy_error(response) < 1e-6  # measured 5.4e-7
    assert float(response["striker_velocity"][-1]) < 0.0


def test_a_slow_heavy_strike_follows_the_push() -> None:
    column = Column(rectangle(0.2, 0.1), 0.8, 0.8)
    mass, velocity = 1e5, 0.5
    response = strike(column, mass, velocity, 0.05)
    pushed = SolidPlaneStress(levels=1, refinement=-1).simulate(
        ColumnPushover("push", column, 0.02)
    )
    work = np.interp(0.5 * mass * velocity**2, pushed["external_work"], pushed["displacement"])
    assert float(response["peak_displacement"]) == pytest.approx(float(work), rel=0.01)


# --- the thesis column ----------------------------------------------------------------------


def test_peak_of_the_thesis_column_is_that_of_its_push_by_energy(thesis_strike) -> None:
    # an independent quasi-static solid gives 0.302 m by the balance of energy
    assert float(thesis_strike["peak_displacement"]) == pytest.approx(0.302, rel=0.011)
    below, above = thesis_strike["shear_utilisation"].values
    # the front of the wave meets the rigid end before the web yields there
    assert 1.0 < below < 1.5
    assert 0.5 < above < 1.2


@pytest.mark.slow
@pytest.mark.parametrize(("velocity", "peak"), [(10.0, 0.1481), (15.0, 0.3035), (20.0, 0.4310)])
def test_default_answer_states_less_than_five_per_cent(velocity: float, peak: float) -> None:
    scenario = ColumnImpact("strike", THESIS, Striker(1500.0, velocity), 0.06)
    response = SolidPlaneStress().simulate(scenario)
    value, width = float(response["peak_displacement"]), width_of(response)
    assert value == pytest.approx(peak, rel=5e-4)
    assert 0.0 < width < 0.05 * value
    finer = SolidPlaneStress(levels=1, refinement=1).simulate(scenario)
    assert abs(float(finer["peak_displacement"]) - value) < width


@pytest.mark.slow
@pytest.mark.parametrize(
    ("load", "share", "length"), [("point", 1.3, 0.004), ("uniform", 1.2, 0.02)]
)
def test_panels_answer_direct_shear_and_fiber_shear_goes_too_far(load, share, length) -> None:
    """Half of the force is `share` V_pl; docs/theory/shear-panel.md."""
    column = Column(find("HEB 220").without_fillets(), 2.0, 2.0)
    force = 2.0 * share * column.properties.shear_resistance
    pulse = Pulse("triangular", force / (column.length if load == "uniform" else 1.0), length)
    scenario = MemberPulse("sheared", column, pulse, load, 0.015)
    solid = pulsed(scenario)
    panels, beam = (
        float(model.simulate(scenario)["peak_displacement"])
        for model in (FlexibleSuperelement(), FiberShear(levels=1))
    )
    assert panels == pytest.approx(solid, rel=0.1)
    assert beam > 1.3 * solid


def pulsed(scenario: MemberPulse) -> float:
    """Peak (m) of a solid under a pulse: a load that is renewed with every record of the driver."""
    column = scenario.column
    solid = solid_of(column)
    sideways = np.zeros(solid.mesh.size)
    sideways[solid.mesh.dofs[:, 0::2]] = 1.0
    pattern = np.asarray(solid.supports.tied.T @ (nodal_mass(solid.mesh, column) * sideways))
    if scenario.load == "point":
        pattern = np.eye(solid.size)[solid.supports.hit]
    else:
        pattern *= column.length / float(np.sum(nodal_mass(solid.mesh, column) * sideways))
    records = 300
    factors = scenario.pulse.means(np.linspace(0.0, scenario.duration, records + 1))
    solid.load = factors[0] * pattern
    spans = [(scenario.duration, scenario.duration / records)]
    peak = 0.0
    for number, _ in enumerate(explicit_impact(solid, solid.supports.hit, NEVER, spans), 1):
        solid.load = factors[min(number, records - 1)] * pattern
        peak = max(peak, float(solid.displacement[solid.supports.hit]))
    return peak


def test_keeps_the_contract_of_models() -> None:
    hit = ColumnImpact("strike", BAR, Striker(30.0, 5.0), 0.003)
    check_model(SolidPlaneStress(levels=1, refinement=-1), [hit])


def test_no_answer_is_an_error_that_says_where() -> None:
    solid = solid_of(BAR)
    inside_out = solid.displacement.copy()
    inside_out[solid.supports.head] = -3.0
    with pytest.raises(SolverError, match="turned inside out"):
        solid.resist(inside_out)


# --- strain rate ----------------------------------------------------------------------------


@pytest.mark.slow
def test_panels_with_one_factor_meet_the_solid_with_a_rate() -> None:
    """An HEA 180 whose web yields at 2.5 times its shear resistance, of mild steel."""
    column = Column(find("HEA 180"), 0.6, 2.4, Steel(rate=MILD_STEEL))
    solid = strike(column, 424.0, 10.0, 0.05)
    static = strike(replace(column, steel=Steel()), 424.0, 10.0, 0.05)
    hit = ColumnImpact("strike", column, Striker(424.0, 10.0), 0.05)
    panels = FlexibleSuperelement().simulate(hit)
    peak = float(solid["peak_displacement"])
    assert abs(energy_error(solid) or 0.0) < 0.01
    assert peak < 0.8 * float(static["peak_displacement"])
    assert float(panels["peak_displacement"]) == pytest.approx(peak, rel=0.08)
