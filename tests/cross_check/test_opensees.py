"""Three columns in OpenSeesPy: the same fiber discretisation gives the same histories."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import opensees_columns as opensees
import pytest
from builders import lumped
from threadpoolctl import threadpool_limits

from workbench.mechanics.structures.impact import PointMass, impact
from workbench.models.references.fiber_beams import FiberCorotational
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, Striker
from workbench.steel.sections import Section
from workbench.steel.sections.section import Rectangle

SIZE, HARDENING, TIME_STEP = 0.1, 1e-4, 5e-5
MODEL = FiberCorotational(
    levels=1,
    element="interpolated",
    shear_flexible=False,
    smallest_element=SIZE,
    largest_element=SIZE,
    hardening_ratio=HARDENING,
    refinement=0,
)
NAMES = ("restrained", "clamped", "propped")


@pytest.fixture
def scenario(request, thesis_impact, clamped_impact) -> ColumnImpact:
    square = Column(
        section=Section("square 0.2 m", Rectangle(0.2, 0.2)),
        length_below=1.2,
        length_above=2.0,
        head="pinned",
        axial_load=1e6,
        restraint_stiffness=5e7,
    )
    known = {
        "restrained": thesis_impact,
        "clamped": clamped_impact,
        "propped": replace(
            thesis_impact, name="propped", column=square, striker=Striker(1500.0, 30.0)
        ),
    }
    return known[request.param]


@pytest.mark.parametrize("scenario", NAMES, indirect=True)
def test_static_force_displacement(scenario) -> None:
    pushed = ColumnPushover(scenario.name, scenario.column, displacement=0.3)
    response = MODEL.simulate(pushed)
    assert response.attrs["outcome"] == "ok"
    path = np.linspace(0.0, 0.3, 301)[1:]
    lengths = MODEL.lengths(pushed)
    opensees.stand(scenario.column, np.concatenate(lengths), HARDENING)
    forces = opensees.push(len(lengths[0]) + 1, path)
    result = np.interp(path, response["displacement"].values, response["force"].values)
    difference = np.max(np.abs(result - forces)) / np.max(forces)
    print(f"static, {scenario.name}: {difference:.2e}")
    assert difference <= 0.01


@pytest.mark.parametrize("scenario", NAMES, indirect=True)
def test_impact_history(scenario) -> None:
    """Up to the peak and a fifth beyond, while the contact lasts."""
    structure, lengths = lumped(MODEL, scenario), MODEL.lengths(scenario)
    assembly, hit = structure.assembly, structure.dof("hit", "x")[0]
    striker = PointMass(scenario.striker.mass, scenario.striker.velocity)
    values = []
    with threadpool_limits(1, user_api="blas"):
        for _ in impact(assembly, hit, striker, [(scenario.duration, TIME_STEP)], 0.5):
            values.append(float(assembly.displacement[hit]))
            if len(values) > 1.2 * (int(np.argmax(values)) + 1):
                break
    opensees.stand(scenario.column, np.concatenate(lengths), HARDENING)
    expected = opensees.hit_by(scenario, len(lengths[0]) + 1, TIME_STEP, len(values))
    assert np.argmax(expected) < len(values) - 1
    difference = np.max(np.abs(np.array(values) - expected)) / np.max(expected)
    print(f"impact, {scenario.name}: {difference:.2e}")
    assert difference <= 0.01


@pytest.mark.parametrize("scenario", NAMES[:1], indirect=True)
def test_the_spring_is_unstressed_under_the_axial_load(scenario) -> None:
    """Otherwise the restraint would hide a part of the axial load from the comparison."""
    lengths = MODEL.lengths(scenario)
    head = opensees.stand(scenario.column, np.concatenate(lengths), HARDENING)
    opensees.ops.reactions()
    assert abs(opensees.ops.nodeReaction(opensees.SPRING, opensees.AXIS)) < 1e-6
    assert opensees.ops.nodeDisp(head, opensees.AXIS) < 0.0
