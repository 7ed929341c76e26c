"""Deformed frames: what is drawn is what was stored."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from synthetic_frames import SyntheticFrame, frame_study
from synthetic_study import store_of
from test_report_figures import request

from workbench.base.errors import InputError
from workbench.models.superelements import FlexibleSuperelement
from workbench.report.drawing.shapes import (
    INSTANTS,
    YIELDING,
    YIELDS,
    Shapes,
    magnification,
    shapes_of,
)
from workbench.report.figures import draw
from workbench.report.figures.deformed import colour_of, hinge_places
from workbench.scenarios import (
    Frame,
    FrameStatic,
    Load,
    Member,
    Node,
    regular_frame,
)
from workbench.steel.sections import find
from workbench.study import Case


def shapes(stored, case: str, label: str) -> Shapes:
    scenario = next(c.scenario for c in stored.study.cases if c.name == case)
    return shapes_of(scenario, stored.response(case, label))


def test_points_and_states_are_those_of_the_snapshots(frames):
    drawing = draw(
        request(frames, "deformed", [frames.study.cases[0]], ["rigid"], instants=[*INSTANTS])
    )
    response = frames.response("storeys", "rigid")
    peak = int(np.argmin(np.abs(response["snapshot_at"].values - float(response["time_of_peak"]))))
    data = drawing.data[drawing.data["instant"] == "peak"]
    points = data[data["member"] == "C0-C1/1"]
    stored = response["shape_x"].sel(member="C0-C1/1").values[:, peak]
    assert points["x_m"].to_numpy() == pytest.approx(stored)
    states = data[data["hinge"].notna()].set_index("hinge")["utilisation"]
    assert states["D2-E2:end"] == 1.0
    assert states.to_numpy() == pytest.approx(response["utilisation"].values[:, peak])
    assert set(data["time"]) == {response["snapshot_at"].values[peak]}


def test_instants(frames):
    result = shapes(frames, "storeys", "reference")
    peak, half = result.index("peak"), result.index("half-way")
    assert result.moved[peak] == result.moved.max()
    assert result.moved[half] >= 0.5 * result.moved[peak] > result.moved[half - 1]
    assert (result.index("start"), result.index("end")) == (0, len(result.at) - 1)
    assert result.at[result.index(0.01)] == pytest.approx(0.01, abs=5e-4)
    assert result.words(peak).replace("\u2009", " ").startswith("20.0 ms")
    shown = request(frames, "deformed", cases=[frames.study.cases[0]], instants=("start", 0.01))
    titles = [panel.get_title(loc="left") for panel in draw(shown).canvas.axes]
    assert titles[0].startswith("start: 0")
    assert titles[1].startswith("10.2")


@pytest.mark.thorough
def test_a_push_that_ends_at_its_peak_is_not_drawn_twice(tmp_path):
    frame = regular_frame((6.0,), (4.0,), find("HEB 220"), find("IPE 300"))
    for path, expected in ((0.1,), ["half-way", "end"]), ((0.1, 0.0), ["half-way", "peak", "end"]):
        push = FrameStatic("push", frame, (Load("A1", x=1e4),), "A1", "x", path)
        study = replace(
            frame_study(f"to-and-fro-{len(path)}"),
            cases=(Case("push", push),),
            models={"reference": SyntheticFrame()},
            figures=(),
        )
        drawing = draw(request(store_of(study, tmp_path), "deformed"))
        assert list(dict.fromkeys(drawing.data["instant"])) == expected


@pytest.mark.thorough
def test_flat_structures_have_room_for_their_axis(tmp_path):
    beam = Frame(
        (Node("l", 0.0, 0.0, "clamped"), Node("m", 2.0, 0.0), Node("r", 4.0, 0.0, "clamped")),
        (Member("l-m", "l", "m", find("HEB 220")), Member("m-r", "m", "r", find("HEB 220"))),
    )
    push = FrameStatic("push", beam, (Load("m", y=1e4),), "m", "y", (0.1, -0.1, 0.0))
    study = replace(
        frame_study("flat"),
        cases=(Case("push", push),),
        models={"reference": FlexibleSuperelement()},
        quantities=("resistance",),
        figures=(),
    )
    canvas = draw(request(store_of(study, tmp_path), "deformed")).canvas
    renderer = FigureCanvasAgg(canvas).get_renderer()
    numbers = [text for text in canvas.axes[0].get_yticklabels() if text.get_text()]
    boxes = [text.get_window_extent(renderer) for text in numbers]
    assert len(boxes) >= 3
    assert not any(a.overlaps(b) for a, b in pairwise(boxes))


@pytest.mark.parametrize("instants", [("late",), (True,), (), ("end",) * 5, (float("nan"),)])
def test_bad_instants_are_refused(frames, instants):
    with pytest.raises(InputError, match=r"figure\.options\.instants"):
        draw(request(frames, "deformed", instants=instants))


@pytest.mark.thorough
def test_scale_is_true_or_told(frames):
    large = draw(request(frames, "deformed", cases=[frames.study.cases[0]]))
    assert large.statements[0] == "True to scale, displacements too."
    labels = [panel.get_xlabel() for panel in large.canvas.axes]
    assert "x (m)" in labels
    small = draw(request(frames, "deformed", cases=[frames.study.cases[1]]))
    times = re.fullmatch(r"Displacements are drawn (\d+) times .*", small.statements[0])
    assert times
    assert f"x (m), displacements × {times[1]}" in [a.get_xlabel() for a in small.canvas.axes]
    for panel in large.canvas.axes[:9]:
        assert panel.get_aspect() == 1.0


@given(st.floats(1e-9, 100.0), st.floats(0.1, 100.0))
def test_magnifications_are_round_and_modest(largest, size):
    times = magnification(largest, size)
    assert times >= 1.0
    if times > 1.0:
        assert times * largest <= 0.05 * size * (1.0 + 1e-9)
        assert f"{times:e}"[0] in "125"


@pytest.mark.thorough
def test_models_without_shapes_are_named(frames):
    drawing = draw(request(frames, "deformed"))
    assert "Without deformed shape: bare." in drawing.statements


def test_columns_lie_with_named_axes_and_say_that_lines_are_chords(small):
    drawing = draw(request(small, "deformed", cases=[small.study.cases[0]]))
    (panel,) = drawing.canvas.axes
    assert panel.get_ylabel() == "displacement\n(m)"
    assert panel.get_xlabel() == "height above the base (m)"
    texts = next(text for text in drawing.statements if text.startswith("Straight lines"))
    assert "shape between is not known" in texts
    data = drawing.data[
        (drawing.data["label"] == "reference") & (drawing.data["instant"] == "peak")
    ]
    peak = small.number(small.study.cases[0].name, "reference", "peak_displacement")
    assert data["x_m"].max() == pytest.approx(peak, rel=1e-3)


def test_circles_stand_beside_the_ends_of_curves():
    arc = np.exp(1j * np.linspace(0.0, np.pi, 181))[None, :]
    first, last = hinge_places(arc, 0.3)
    assert np.angle(first) == pytest.approx(0.3, rel=1e-3)
    assert np.pi - np.angle(last) == pytest.approx(0.3, rel=1e-3)
    close = hinge_places(arc[:, :2], 0.3)  # shorter than twice the gap
    assert close[0] != pytest.approx(close[1])


def test_colours_darken_and_yielding_stands_out():
    def luminance(color: str) -> float:
        return float(np.dot([0.2126, 0.7152, 0.0722], to_rgb(color)))

    shades = [luminance(colour_of(u)) for u in np.linspace(0.0, YIELDS - 1e-6, 30)]
    assert np.all(np.diff(shades) <= 1e-3)
    assert shades[0] > 0.85
    assert shades[-1] < 0.25
    assert colour_of(YIELDS) == colour_of(1.0) == YIELDING
    assert abs(luminance(YIELDING) - shades[-1]) > 0.1


@pytest.mark.thorough
def test_still_pictures_of_a_motion(frames, stills_report):
    html = stills_report["html"].read_text(encoding="utf-8")
    assert "flexible <b>" not in html
    still = (stills_report["figures"] / "stills.svg").read_text(encoding="utf-8")
    assert still.startswith("<svg")
    drawing = draw(
        request(frames, "deformed", [frames.study.cases[0]], ["rigid"], instants=[*INSTANTS])
    )
    titles = [panel.get_title(loc="left").partition(":")[0] for panel in drawing.canvas.axes]
    assert titles[:4] == [*INSTANTS]
