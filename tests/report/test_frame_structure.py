"""Frames on paper: complete, to scale, and legible."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from synthetic_frames import portal, storeys
from synthetic_study import columns
from test_report_figures import request

from workbench.report.drawing.frame import Layout
from workbench.report.figures import draw
from workbench.report.figures.structure import spans
from workbench.scenarios import (
    ColumnImpact,
    Frame,
    FrameStatic,
    Load,
    Member,
    MemberPulse,
    Node,
    Pulse,
    Striker,
    frame_scenario,
    regular_frame,
)
from workbench.steel.sections import find
from workbench.study import Case

CASES = ("storeys", "from above", "cycles", "shaken")


def drawn(frames, *names):
    cases = [case for case in frames.study.cases if case.name in names]
    return draw(request(frames, "structure", cases=cases))


def texts_of(canvas):
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    renderer = FigureCanvasAgg(canvas).get_renderer()
    canvas.draw(renderer)
    texts = [text for panel in canvas.axes for text in panel.texts if text.get_text().strip()]
    return [(text.get_text(), text.get_window_extent(renderer)) for text in texts]


@pytest.mark.parametrize("name", CASES)
def test_texts_are_inside_and_do_not_touch(frames, name):
    canvas = drawn(frames, name).canvas
    texts = texts_of(canvas)
    assert len(texts) > 8
    for i, (words, box) in enumerate(texts):
        assert -1 < box.x0 <= box.x1 < canvas.bbox.width + 1, words
        assert -1 < box.y0 <= box.y1 < canvas.bbox.height + 1, words
        # anti-aliased edges may meet
        small = box.padded(-1.0)
        assert [other for other, place in texts[:i] if small.overlaps(place)] == [], words


def test_the_thesis_frame_shows_where_and_how_it_is_hit(frames):
    words = [words for words, _ in texts_of(drawn(frames, "storeys").canvas)]
    for expected in ("50 m/s", "1500 kg", "0.8 m", "3.2 m", "12 m", "hit"):
        assert expected in words
    assert words.count("3 m") == 4
    assert any("200" in word and "MPa" in word for word in words)


def test_everything_on_the_portal_is_named(frames):
    drawing = drawn(frames, "from above")
    words = [words for words, _ in texts_of(drawing.canvas)]
    for expected in (
        *("500 kg", "120 kN", "40 kN", "5 kN m", "20 kN/mm", "1000 kN m/rad"),
        *("6 m/s", "800 kg", "pinned joint", "joint semi"),
    ):
        assert expected in words
    assert "rotational stiffness 20000 kN m/rad, plastic moment 120 kN m" in drawing.statements[0]
    assert "clamped at A" in drawing.alt
    assert "pinned at E" in drawing.alt


def test_patterns_say_what_is_imposed(frames):
    drawing = drawn(frames, "cycles")
    words = [words for words, _ in texts_of(drawing.canvas)]
    assert {"λ × 10 kN", "λ × 20 kN", "control"} <= set(words)
    texts = [text.replace("\u00a0", " ") for text in drawing.statements]
    assert "c: displacement of B along x through 19 targets between −80 and 80 mm." in texts


def test_moments_alone_are_followed_as_rotations(frames):
    profile = find("IPE 200")
    frame = Frame(
        (Node("a", 0.0, 0.0, "pinned"), Node("b", 3.0, 0.0, "roller-x"), Node("c", 5.0, 1.0)),
        (Member("m", "a", "b", profile), Member("n", "b", "c", profile)),
    )
    push = FrameStatic("turn", frame, (Load("a", moment=1e4),), "a", "rotation", (0.1,))
    drawing = draw(request(frames, "structure", cases=[Case("turn", push)]))
    assert drawing.statements[0] == "λ P is the moment that is sought."
    assert "rotation of a to 0.1\u00a0rad" in drawing.statements[1]


def test_members_are_to_scale_or_it_is_said(frames):
    layout = Layout(storeys())
    for member in layout.frame.members:
        assert layout.depth(member) == pytest.approx(0.2 * layout.scale)
    assert not any("deeper" in text for text in drawn(frames, "storeys").statements)
    wide = regular_frame((30.0,) * 3, (10.0,), find("IPE 200"), find("IPE 200"))
    push = FrameStatic("w", wide, (Load("A1", x=1.0),), "A1", "x", (0.1,))
    drawing = draw(request(frames, "structure", cases=[Case("w", push)]))
    assert any("drawn deeper than they are" in text for text in drawing.statements)


def test_the_numbers_are_those_of_the_members(frames):
    drawing = drawn(frames, "from above", "cycles", "shaken")  # one frame, one picture
    frame = portal()
    assert list(drawing.data["member"]) == [member.name for member in frame.members]
    row = drawing.data.set_index("member").loc["B-C"]
    assert row["length_m"] == pytest.approx(3.0)
    assert row["plastic_moment_Nm"] == frame.properties("B-C").plastic_moment
    assert row["joint_start"] == "semi"


def test_a_column_is_its_frame(frames):
    impact = ColumnImpact("c", columns()["thesis"], Striker(1500.0, 15.0), 0.05)
    as_column = Case("column", impact)
    as_frame = Case("frame", frame_scenario(impact))
    both = draw(request(frames, "structure", cases=[as_column, as_frame]))
    assert len(both.canvas.axes) == 1
    assert len(both.data) == 2


def test_different_structures_stand_together(frames):
    drawing = drawn(frames, "storeys", "shaken")
    assert len(drawing.canvas.axes) == 2
    boxes = [panel.get_position() for panel in drawing.canvas.axes]
    assert not boxes[0].overlaps(boxes[1])


def test_many_equal_loads_and_masses_share_a_label(frames):
    big = regular_frame((5.0,) * 10, (3.5,) * 6, find("HEB 300"), find("IPE 360"))
    free = [node for node in big.nodes if node.support == "free"]
    big = replace(
        big,
        loads=tuple(Load(node.name, y=-1e5) for node in free),
        nodes=tuple(replace(n, mass=1e4) if n in free else n for n in big.nodes),
    )
    push = FrameStatic("p", big, (Load("A6", x=1.0),), "A6", "x", (0.1,))
    drawing = draw(request(frames, "structure", cases=[Case("p", push)]))
    words = [words for words, _ in texts_of(drawing.canvas)]
    assert words.count("each 100 kN") == 1
    assert words.count("each 10000 kg") == 1
    assert "10 × 5 m = 50 m" in words
    assert "100 kN" not in words


def testspans():
    assert [text for _, _, text in spans([0.0, 0.8, 4.0])] == ["0.8 m", "3.2 m"]
    assert spans(list(np.arange(12.0))) == [(0.0, 11.0, "11 × 1 m = 11 m")]
    uneven = [*np.arange(11.0), 12.0]
    assert spans(uneven) == [(0.0, 12.0, "12 m")]


@pytest.mark.parametrize("load", ["point", "uniform"])
def test_pulses_stand_where_they_push(frames, load):
    column = columns()["thesis"]
    blast = MemberPulse("blast", column, Pulse("triangular", 2e5, 0.01), load, 0.05)
    drawing = draw(request(frames, "structure", cases=[Case("blast", blast)]))
    words = [words for words, _ in texts_of(drawing.canvas)]
    assert "displacement" in words
    assert ("p(t)" in words) == (load == "point")
    texts = " ".join(drawing.statements)
    assert "triangular" in texts
    assert ("on below, above" in texts) == (load == "uniform")
