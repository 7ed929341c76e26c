"""What leaves its plane on paper: columns in two views, frames in space in an oblique one."""

from __future__ import annotations

import json
import re
from base64 import b64decode
from dataclasses import replace
from math import radians

import numpy as np
import pytest
from synthetic_frames import frame_study
from synthetic_study import store_of
from test_report_figures import request

from workbench.models.seven_dof import SevenDof
from workbench.models.superelement_space import SuperelementSpace
from workbench.report.drawing.shapes import shapes_of
from workbench.report.explorer import explorer
from workbench.report.figures import draw
from workbench.scenarios import (
    Column,
    ColumnImpact,
    FrameImpact,
    FrameStriker,
    Striker,
    regular_frame,
)
from workbench.study import Case


def column(degrees: float) -> ColumnImpact:
    upright = Column("HEB 220", 0.8, 3.2, axial_load=0.5e6, restraint_stiffness=1e7)
    return ColumnImpact("hit", upright, Striker(1500.0, 10.0, angle=radians(degrees)), 0.06)


def drawn(scenarios, kind, folder):
    cases = tuple(Case(name, scenario) for name, scenario in scenarios.items())
    models = {"reference": SuperelementSpace()}
    study = replace(frame_study("beside"), cases=cases, models=models, gates=(), figures=())
    study = replace(study, quantities=("peak_displacement",))
    return draw(request(store_of(study, folder), kind))


def test_a_column_that_drifts_sideways_is_seen_along_the_hit_as_well(tmp_path):
    drawing = drawn({"plane": column(0.0), "oblique": column(30.0)}, "deformed", tmp_path)
    titles = [panel.get_title(loc="left") for panel in drawing.canvas.axes]
    assert [bool("sideways" in title) for title in titles] == [False, False, True]
    data = drawing.data
    beside = data[(data["view"] == "sideways") & (data["instant"] == "peak")]
    response = SuperelementSpace().simulate(column(30.0))
    at = int(np.argmax(np.abs(response["displacement"].values)))
    reached = float(response["sideways"].values[at])
    assert np.abs(beside["x_m"]).max() == pytest.approx(abs(reached), rel=0.05)


def test_the_explorer_shows_both_views_and_the_direction(tmp_path):
    """Of every answer, at rest and moved; what stays in its plane does not move in the second."""
    impacts = {"plane": column(0.0), "oblique": column(30.0)}
    impacts["beside"] = impacts["plane"].changed(
        striker=impacts["plane"].striker.changed(eccentricity=0.07)
    )
    cases = tuple(Case(name, impact) for name, impact in impacts.items())
    models = {"reference": SuperelementSpace(), "hinges": SevenDof()}
    study = replace(frame_study("seen"), cases=cases, models=models, gates=(), figures=())
    study = replace(study, quantities=("peak_displacement",), reference="reference")
    page = explorer(study, store_of(study, tmp_path))
    (inside,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)
    plane, oblique, beside = json.loads(inside)["cases"]
    assert oblique["about"].startswith("oblique, hit at 30 degrees off the height of the section.")
    assert beside["about"].startswith("beside, hit 70 mm beside the shear centre.")
    assert [case["aside"] for case in (plane, oblique, beside)] == [False, True, False]
    assert len(oblique["rest"]) == 2 * len(plane["rest"])
    first = len(plane["rest"])
    for cell, model in zip(oblique["cells"], models.values(), strict=True):
        response, shape = model.simulate(impacts["oblique"]), cell["shape"]
        assert len(shape["points"]) == 2 * first
        values = np.frombuffer(b64decode(shape["moved"]["n"]), dtype="<i2")
        moved = shape["moved"]["step"] * values.reshape(-1, sum(shape["points"]), 2)
        split = sum(shape["points"][:first])
        for part, name in ((moved[:, :split], "displacement"), (moved[:, split:], "sideways")):
            reached = float(response[name].max())
            assert part[..., 1].max() == pytest.approx(reached, rel=0.05)


@pytest.mark.thorough
def test_a_frame_in_space_is_drawn_with_its_depths(tmp_path):
    frame = regular_frame((6.0,), (3.5,), "HEB 220", "IPE 300", depths=(5.0, 4.0))
    frame = frame.split("Aa0-Aa1", 1.2, "hit")
    striker = FrameStriker(1500.0, 8.0, node="hit", angle=radians(30.0))
    event = FrameImpact("corner", frame, striker, 0.05)
    drawing = drawn({"corner": event}, "structure", tmp_path)
    assert "Oblique view; depths towards the viewer: 5 m, 4 m." in drawing.statements
    assert {"start_z_m", "end_z_m"} <= set(drawing.data)
    shapes = shapes_of(event, SuperelementSpace().simulate(event))
    assert shapes.aside is None
    start, end = frame.places[frame.ends.T]
    assert shapes.rest_places[:, :, 0] == pytest.approx(start.T)
    assert shapes.rest_places[:, :, -1] == pytest.approx(end.T)
    # what recedes goes up and to the right
    assert (shapes.rest[1, 0] - shapes.rest[0, 0]).imag != 0.0
