"""Records of impacts read in compiled code: as the plain reader says; responses of their own."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from workbench.errors import CollapseError
from workbench.frames.record import Record
from workbench.frames.struck import StruckRecord
from workbench.impact.pace import Pace
from workbench.models.frame_model import as_frame
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.responses import Response
from workbench.scenarios import ColumnImpact, FrameImpact
from workbench.structures.superelements import Superelements
from workbench.structures.superelements.group import SuperelementState
from workbench.structures.superelements.march import follow_impact
from workbench.structures.time_steps import PointMass, StepEnergies, TimeStep

MODELS = {
    "rigid": RigidSuperelement(),
    "flexible": FlexibleSuperelement(),
    "no webs": FlexibleSuperelement(shear="none", elements=3),
    "undeformed": RigidSuperelement(geometry="linear", shear="none"),
}


def both(model: RigidSuperelement | FlexibleSuperelement, impact: FrameImpact) -> list[Record]:
    """The compiled record of an impact, and one that sees its states one by one.

    Until the frame collapses, if it does; then what is said of that is in `found` of both.
    """
    own = impact.striker
    structures = [model.structure(impact) for _ in range(2)]
    place = own.node, own.direction, impact.duration
    compiled, plain = (
        kind(s, *place) for kind, s in zip((StruckRecord, Record), structures, strict=True)
    )
    step = impact.duration / 1500  # in two parts
    pace = Pace(impact.duration, step, step, inf, inf, inf, 0.0, 100_000)
    (shown, alone), dof = structures, structures[0].dof(own.node, own.direction)[0]
    (group,), (single,) = shown.assembly.groups, alone.assembly.groups
    assert isinstance(group, Superelements)
    assert isinstance(single, Superelements)
    mass, parts = PointMass(own.mass, own.velocity, own.restitution), 0
    for taken in follow_impact(shown.assembly, dof, mass, pace):
        parts += 1
        states, assembly = group.states[0], shown.assembly
        x, v, stored = assembly.displacement, assembly.velocity, assembly.stored
        try:
            compiled.take(taken, taken.time)
        except CollapseError as error:
            shown.found["collapse"] = str(error), error.collapse
        for r in range(int(parts == 1), len(x)):
            alone.assembly.show(x[r], v[r], stored[r])  # type: ignore[index]
            single.show(SuperelementState(*(each[r] for each in states)))
            energies = StepEnergies(*(each[r] for each in taken.energies))  # type: ignore[index]
            time = float(taken.time[r])  # type: ignore[index]
            try:
                plain.take(TimeStep(step, energies, 0.0, 0.0, time=time), time)
            except CollapseError as error:
                alone.found["collapse"] = str(error), error.collapse
                return [compiled, plain]
    assert parts == 2
    return [compiled, plain]


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_compiled_reading_is_that_of_the_states_one_by_one(
    model: RigidSuperelement | FlexibleSuperelement, thesis_impact: ColumnImpact
) -> None:
    impact = as_frame(replace(thesis_impact.at_velocity(8.0), duration=0.03))
    assert isinstance(impact, FrameImpact)
    compiled, plain = both(model, impact)
    found, expected = compiled.states(), plain.states()
    names = ("at", "displacement", "velocity", "elastic")
    found |= compiled.columns(*names) | {"dissipated": compiled.dissipated}
    expected |= plain.columns(*names) | {"dissipated": plain.dissipated}
    found["unyielding"], expected["unyielding"] = (r.unyielding_shear() for r in (compiled, plain))
    assert found.keys() == expected.keys()
    assert len(found["snapshot_at"]) > 50
    for name, values in expected.items():
        scale = np.abs(values).max()
        np.testing.assert_allclose(
            found[name], values, rtol=1e-13, atol=1e-14 * scale, err_msg=name
        )
    assert np.abs(expected["plastic_rotation"]).max() > 1e-3


def test_a_collapse_is_found_in_the_same_state(thesis_impact: ColumnImpact) -> None:
    impact = as_frame(thesis_impact.at_velocity(80.0))
    assert isinstance(impact, FrameImpact)
    said = [r.structure.found["collapse"] for r in both(RigidSuperelement(), impact)]
    assert said[0] == said[1]


def frozen(response: Response) -> list[object]:
    """All that a response says, but times."""
    said = [(n, v.dims, v.values.tolist(), dict(v.attrs)) for n, v in response.variables.items()]
    return [said, {n: v for n, v in response.attrs.items() if "time" not in n}]


def test_responses_of_one_structure_share_nothing_that_can_be_changed(
    thesis_impact: ColumnImpact,
) -> None:
    model = RigidSuperelement()
    first, second = (model.simulate(thesis_impact.at_velocity(v)) for v in (9.0, 10.0))
    expected = frozen(first), frozen(second)
    for name, variable in first.variables.items():
        variable.attrs["units"] = "furlongs"
        if name not in first.coords:
            variable.values[...] = -1.0
        elif variable.values.flags.writeable:
            variable.values[...] = variable.values[::-1].copy()
    first.attrs.update(dict.fromkeys(first.attrs, "gone"))
    again = model.simulate(thesis_impact.at_velocity(9.0))
    assert frozen(second) == expected[1]
    assert frozen(again) == expected[0]
