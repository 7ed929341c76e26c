"""Records of impacts read many at a time: as one by one; responses of their own."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from workbench.base.errors import CollapseError
from workbench.mechanics.frames.runs import Record
from workbench.mechanics.frames.struck import StruckRecord, show
from workbench.mechanics.impact.pace import Pace
from workbench.mechanics.structures.impact import PointMass, StepEnergies, TimeStep
from workbench.mechanics.structures.march import follow_impact
from workbench.models.frame_model import as_frame
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.responses import Response
from workbench.scenarios import ColumnImpact, FrameImpact

MODELS = {
    "rigid": RigidSuperelement(),
    "flexible": FlexibleSuperelement(),
    "no webs": FlexibleSuperelement(shear="none", elements=3),
    "undeformed": RigidSuperelement(geometry="linear", shear="none"),
}


def both(
    model: RigidSuperelement | FlexibleSuperelement,
    impact: FrameImpact,
) -> list[Record]:
    """The record of an impact, many states at a time, and one that sees its states one by one.

    Until the frame collapses, if it does; then what is said of that is in `kept` of both.
    """
    given, records, parts, before = impact.striker, [], [], 0.0
    step = impact.duration / 1500  # in two parts
    pace = Pace(impact.duration, step, step, inf, inf, inf, 0.0, 100_000)
    mass = PointMass(given.mass, given.velocity, given.restitution)
    for kind in (StruckRecord, Record):
        structure, parts = model.structure(impact), [*parts, 0]
        record = kind(structure, given.node, given.direction, impact.duration)
        records.append(record)
        dof, assembly = structure.dof(given.node, given.direction)[0], structure.assembly
        limits = StruckRecord(structure, given.node, given.direction, impact.duration).limits
        try:
            for several in follow_impact(assembly, dof, mass, pace, limits):
                parts[-1] += 1
                if kind is StruckRecord:
                    record.take(several, several.time)
                    continue
                plastic = np.diff(several.table["plastic"], prepend=before)
                before = several.table["plastic"][-1]
                for row, time in enumerate(several.time.tolist()):
                    show(structure, several, row)
                    if time > 0.0:  # the first one is that of the start
                        energies = StepEnergies(0.0, float(plastic[row]), 0.0, 0.0)
                        record.take(TimeStep(step, energies, 0.0, 0.0, time=time), time)
        except CollapseError as error:
            structure.kept["collapse"] = str(error), error.collapse
    assert parts == [2, 2] or "collapse" in records[0].structure.kept
    return records


@pytest.mark.thorough
@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_many_states_at_a_time_read_as_one_by_one(
    model: RigidSuperelement | FlexibleSuperelement,
    thesis_impact: ColumnImpact,
) -> None:
    impact = as_frame(replace(thesis_impact.at_velocity(8.0), duration=0.03))
    assert isinstance(impact, FrameImpact)
    compiled, plain = both(model, impact)
    result, expected = compiled.states(), plain.states()
    names = ("at", "displacement", "velocity", "elastic")
    result |= compiled.columns(*names) | {"dissipated": compiled.dissipated}
    expected |= plain.columns(*names) | {"dissipated": plain.dissipated}
    result["unyielding"], expected["unyielding"] = (r.unyielding_shear() for r in (compiled, plain))
    assert result.keys() == expected.keys()
    assert len(result["snapshot_at"]) > 50
    for name, values in expected.items():
        scale = np.abs(values).max()
        np.testing.assert_allclose(
            result[name], values, rtol=1e-13, atol=1e-14 * scale, err_msg=name
        )
    assert np.abs(expected["plastic_rotation"]).max() > 1e-3


def test_a_collapse_is_found_in_the_same_state(
    thesis_impact: ColumnImpact,
) -> None:
    impact = as_frame(thesis_impact.at_velocity(80.0))
    assert isinstance(impact, FrameImpact)
    values = [r.structure.kept["collapse"] for r in both(RigidSuperelement(), impact)]
    assert values[0] == values[1]


def frozen(response: Response) -> list[object]:
    """All that a response says, but times."""
    values = [(n, v.dims, v.values.tolist(), dict(v.attrs)) for n, v in response.variables.items()]
    return [values, {n: v for n, v in response.attrs.items() if "time" not in n}]


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
