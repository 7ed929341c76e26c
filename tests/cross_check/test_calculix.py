"""Columns struck about their weak axis and obliquely: shells against bricks of CalculiX."""

from __future__ import annotations

import shutil

import calculix
import numpy as np
import pytest

from workbench.mechanics.impact import integrator
from workbench.models.references.shell import Shell
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.sections import find

PROGRAM = shutil.which("ccx")
THESIS = Column(find("HEB 220"), 0.8, 3.2, fillets=False, axial_load=0.5e6, restraint_stiffness=1e7)


def struck(degrees: float, duration: float) -> ColumnImpact:
    """The thesis column, hit at an angle off its web at 8 m/s through a spring."""
    striker = Striker(1500.0, 8.0, angle=np.radians(degrees), stiffness=2e8)
    return ColumnImpact("hit", THESIS, striker, duration)


@pytest.mark.slow
@pytest.mark.skipif(PROGRAM is None, reason="CalculiX is not installed: apt install calculix-ccx")
@pytest.mark.parametrize(
    ("degrees", "duration", "faces", "axes"),
    [(90.0, 0.0275, 0.015, 0.015), (30.0, 0.02, 0.05, 0.105)],
)
def test_shells_meet_bricks(degrees, duration, faces, axes, tmp_path, monkeypatch) -> None:
    """Face and axis at all times, over their largest; the spring gives back all that it takes.

    Obliquely the flange folds about the face of the web of bricks, but about the middle of that of
    shells, and one brick through it has a plastic moment of 1.155 of the right one: the axis goes
    farther.
    """
    monkeypatch.setattr(integrator, "UNLOADING", 1.0)
    scenario = struck(degrees, duration)
    mesh = calculix.bricks(scenario, 0, 0.11)
    printed = calculix.run(calculix.deck(scenario, mesh, 1.6e-4), str(PROGRAM), tmp_path)
    time, face, axis = calculix.histories(scenario, mesh, printed)
    assert time[-1] == pytest.approx(duration)
    response = Shell(levels=1).simulate(scenario)
    for name, bricks, away in (("displacement", face, faces), ("shell.axis", axis, axes)):
        shells = np.interp(time, response["time"], response[name])
        assert np.abs(bricks - shells).max() < away * shells.max(), name


def test_bricks_have_the_section_and_the_mass_of_the_column() -> None:
    scenario = struck(0.0, 0.01)
    mesh = calculix.bricks(scenario, 0, 0.11)
    sizes = np.ptp(mesh.place[mesh.nodes], axis=1)
    assert np.prod(sizes, axis=1).sum() == pytest.approx(THESIS.strength_section.area * 4.0)
    weights = mesh.weights(0.8)
    x, y = mesh.section.T
    second = weights @ x**2, weights @ y**2
    section = THESIS.strength_section
    radii = section.second_moment / section.area, section.about("weak").second_moment / section.area
    assert second == pytest.approx(radii, rel=1e-9)
    assert weights @ np.array([x, y]).T == pytest.approx([0.0, 0.0], abs=1e-12)
