"""Struck columns in decks that CalculiX runs: the references in the plane, shells beside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from calculix import answer, needs_calculix

from workbench.extras.exchange.deck import DeckChoices
from workbench.mechanics.impact import integrator
from workbench.models.references.shell import Shell
from workbench.models.references.solid import SolidPlaneStress
from workbench.responses import attribute
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.sections import find

THESIS = Column(find("HEB 220"), 0.8, 3.2, fillets=False, axial_load=0.5e6, restraint_stiffness=1e7)


def struck(velocity: float, duration: float) -> ColumnImpact:
    """The thesis column, hit along its web by a rigid striker."""
    return ColumnImpact("hit", THESIS, Striker(1500.0, velocity), duration)


@pytest.mark.thorough
@needs_calculix
def test_the_first_milliseconds_are_those_of_the_solid(tmp_path: Path) -> None:
    """Until 2 ms after the hit, where the web has yielded and hardly any load is back."""
    scenario = struck(15.0, 2e-3)
    time, displacement, axis = answer(scenario, DeckChoices(refinement=-1), tmp_path)
    assert time[-1] == pytest.approx(2e-3)
    solid = SolidPlaneStress(levels=1, refinement=-1).simulate(scenario)
    expected = np.interp(time, solid["time"], solid["displacement"], left=0.0)
    assert np.abs(displacement - expected).max() < 0.02 * expected.max()
    assert axis == pytest.approx(displacement, abs=1e-6)


@pytest.mark.slow
@needs_calculix
@pytest.mark.parametrize(
    ("velocity", "duration", "measured"),
    [(10.0, 0.033, 0.1468), (15.0, 0.041, 0.2998), (20.0, 0.045, 0.4236)],
)
def test_the_solid_meets_plane_stress_of_calculix(velocity, duration, measured, tmp_path) -> None:
    """Peaks as measured; the solid within the uncertainty that it states itself."""
    scenario = struck(velocity, duration)
    peak = answer(scenario, DeckChoices(), tmp_path)[1].max()
    assert peak == pytest.approx(measured, rel=2e-3)
    solid = SolidPlaneStress().simulate(scenario)
    known = attribute(solid, "numerical_uncertainty")["peak_displacement"]
    assert float(solid["peak_displacement"]) == pytest.approx(peak, abs=known)


@pytest.mark.slow
@needs_calculix
@pytest.mark.parametrize(
    ("degrees", "duration", "faces", "axes"),
    [(90.0, 0.0275, 0.025, 0.025), (30.0, 0.02, 0.05, 0.105)],
)
def test_shells_meet_bricks(degrees, duration, faces, axes, tmp_path, monkeypatch) -> None:
    """Face and axis at all times, over their largest; the spring gives back all that it takes.

    Obliquely the flange folds about the face of the web of bricks, but about the middle of that of
    shells, and one brick through it has a plastic moment of 1.155 of the right one: the axis goes
    farther.
    """
    monkeypatch.setattr(integrator, "UNLOADING", 1.0)
    striker = Striker(1500.0, 8.0, angle=np.radians(degrees), stiffness=2e8)
    scenario = ColumnImpact("hit", THESIS, striker, duration)
    time, face, axis = answer(scenario, DeckChoices(mesh="bricks", struck="face"), tmp_path)
    assert time[-1] == pytest.approx(duration)
    response = Shell(levels=1).simulate(scenario)
    for name, bricks, away in (("displacement", face, faces), ("shell.axis", axis, axes)):
        shells = np.interp(time, response["time"], response[name])
        assert np.abs(bricks - shells).max() < away * shells.max(), name
