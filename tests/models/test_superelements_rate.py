"""Superelements whose bars flow at a rate and harden (rate_level = bars)."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from workbench.base.errors import InputError
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.references.fiber_beams import FiberReissner
from workbench.models.strain_rate import with_rate
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.responses import findings_of, outcome_of
from workbench.scenarios import Column, ColumnImpact, Striker, load_scenario
from workbench.steel.materials import MILD_STEEL, CowperSymonds, Steel
from workbench.steel.sections import circular_tube, find

FRAME = Path(__file__).parents[2] / "data" / "published" / "heng2017_frame.toml"
MODELS = {
    "flexible": FlexibleSuperelement(rate_level="bars", shear="elastic"),
    "rigid": RigidSuperelement(rate_level="bars", shear="elastic"),
}
PANELS = {name: replace(model, shear="panel") for name, model in MODELS.items()}
HARD = Steel(rate=MILD_STEEL, hardening_modulus=2.1e9)


def hit(steel: Steel, below: float = 2.0, velocity: float = 15.0) -> ColumnImpact:
    column = Column(
        find("HEB 220"), below, 4.0 - below, steel, axial_load=5e5, restraint_stiffness=1e7
    )
    return ColumnImpact("C1", column, Striker(1500.0, velocity), 0.12)


def peak(model, impact) -> float:
    response = model.simulate(impact)
    assert outcome_of(response) == "ok"
    return float(response["peak_displacement"])


@pytest.mark.claim("model:{kind}-superelement", "peak over four-dof", "independent code", 1, 0.04)
@pytest.mark.parametrize("kind", MODELS)
@pytest.mark.parametrize("below", [0.8, 2.0])
@pytest.mark.parametrize("steel", [Steel(rate=MILD_STEEL), Steel(hardening_modulus=2.1e9), HARD])
def test_two_formulations_of_bars_that_flow(kind: str, below: float, steel: Steel, claim) -> None:
    """The column of two rigid bars solves the same bars in displacements of its own."""
    impact = hit(steel, below)
    # measured 0.6 to 3 %: elastic bars, and mass along them
    claim(peak(MODELS[kind], impact) / peak(FourDof(rate_level="bars"), impact))


@pytest.mark.parametrize("kind", PANELS)
@pytest.mark.parametrize("below", [0.8, 1.2])
@pytest.mark.parametrize("steel", [Steel(rate=MILD_STEEL), Steel(hardening_modulus=2.1e9), HARD])
def test_two_formulations_of_panels_that_flow(kind: str, below: float, steel: Steel) -> None:
    """Flanges and web at rates of their own; webs that stay elastic go less far."""
    impact = hit(steel, below)
    response = PANELS[kind].simulate(impact)
    assert float(abs(response["sliding"]).max()) > 0.02
    ahead = float(response["peak_displacement"])
    assert ahead == pytest.approx(peak(FourDofShear(rate_level="bars"), impact), rel=0.04)
    assert ahead > 1.2 * peak(MODELS[kind], impact)


@pytest.mark.thorough
@pytest.mark.parametrize("kind", MODELS)
def test_fibers_with_the_same_law(kind: str) -> None:
    impact = hit(HARD)
    assert peak(MODELS[kind], impact) == pytest.approx(peak(FiberReissner(), impact), rel=0.02)


@pytest.mark.parametrize("models", [MODELS, PANELS], ids=["elastic webs", "panels"])
@pytest.mark.parametrize("kind", MODELS)
def test_energy_balances_and_flow_dissipates(models, kind: str) -> None:
    response = models[kind].simulate(hit(HARD, 1.2))
    kinetic = float(response["kinetic"][0])
    assert float(abs(response["balance_error"]).max()) < 1e-7 * kinetic
    assert (np.diff(response["dissipated"]) >= -1e-9 * kinetic).all()


@pytest.mark.parametrize("models", [MODELS, PANELS], ids=["elastic webs", "panels"])
@pytest.mark.parametrize("kind", MODELS)
def test_without_rate_and_hardening_superelements_are_the_same(models, kind: str) -> None:
    ordinary = replace(models[kind], rate_level="factor").simulate(hit(Steel()))
    bars = models[kind].simulate(hit(Steel()))
    assert np.array_equal(ordinary["displacement"], bars["displacement"])


@pytest.mark.parametrize("kind", MODELS)
def test_a_rate_that_is_hardly_felt(kind: str) -> None:
    """D = 1e6 1/s, q = 1: the overstress at 50 1/s is 5e-5; what is left are the two envelopes."""
    impact = hit(Steel(rate=CowperSymonds(1e6, 1.0)))
    static = replace(MODELS[kind], rate_level="factor", shear="none")
    assert peak(MODELS[kind], impact) == pytest.approx(peak(static, hit(Steel())), rel=0.03)


@pytest.mark.parametrize("kind", PANELS)
@pytest.mark.parametrize("below", [0.8, 2.0])
def test_panels_of_a_rate_that_is_hardly_felt(kind: str, below: float) -> None:
    """The surface of both is the same; what is left is the place of the flow in a step."""
    static = replace(PANELS[kind], rate_level="factor").simulate(hit(Steel(), below))
    rated = PANELS[kind].simulate(hit(Steel(rate=CowperSymonds(1e6, 1.0)), below))
    for name, bound in (("peak_displacement", 2e-3), ("largest_plastic_rotation", 0.03)):
        assert float(rated[name]) == pytest.approx(float(static[name]), rel=bound)
    slid, expected = (each["sliding"].isel(time=-1).to_numpy() for each in (rated, static))
    assert slid == pytest.approx(expected, rel=0.02, abs=1e-3)


def test_frames_by_bars_and_by_one_factor() -> None:
    impact = load_scenario(FRAME)
    rated = with_rate(impact, MILD_STEEL)
    bars, factor = FlexibleSuperelement(rate_level="bars"), FlexibleSuperelement()
    assert peak(bars, rated) == pytest.approx(peak(factor, rated), rel=0.1)
    assert peak(bars, rated) < 0.95 * peak(factor, impact)


@pytest.mark.parametrize("kind", MODELS)
def test_options_that_bars_do_not_know(kind: str) -> None:
    for name, value in (("alpha", 1.3), ("beta", 1.3)):
        with pytest.raises(InputError, match=f"{name} = .* is not known with rate_level = bars"):
            replace(MODELS[kind], **{name: value})


@pytest.mark.parametrize("kind", MODELS)
def test_sections_and_joints_that_bars_do_not_know(kind: str) -> None:
    impact = hit(Steel(rate="S355"))
    tube = replace(impact, column=replace(impact.column, section=circular_tube(0.22, 0.01)))
    refused = MODELS[kind].simulate(tube)
    assert outcome_of(refused) == "out-of-domain"
    assert "section" in [finding.subject for finding in findings_of(refused)]
