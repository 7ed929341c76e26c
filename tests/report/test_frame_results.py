"""Curves, ledgers, paths of hinges and peaks of frames; frames in whole reports."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from pages import views
from synthetic_frames import SyntheticFrame, frame_study, portal
from synthetic_study import store_of
from test_report_figures import request

from workbench.base.errors import InputError
from workbench.models.superelements import FlexibleSuperelement
from workbench.report.build import build_report
from workbench.report.chapters import configuration, limits
from workbench.report.drawing.sheet import thinned
from workbench.report.figures import draw
from workbench.report.gallery import to_svg
from workbench.report.page.documents import Document, render_pdf
from workbench.report.page.markdown import Picture, section
from workbench.scenarios import FrameStatic, Load, regular_frame, scenario_from
from workbench.steel.sections import find
from workbench.study import Case
from workbench.study.assessment import Gate
from workbench.study.assessor import read_assessment


def test_loops_keep_all_their_reversals(frames):
    drawing = draw(request(frames, "force-displacement"))
    response = frames.response("cycles", "reference")
    data = drawing.data[drawing.data["label"] == "reference"]
    x = data["displacement_SI"].to_numpy()
    turns = np.flatnonzero(np.diff(np.sign(np.diff(x))) != 0)
    assert len(turns) == 18  # 19 targets
    assert x.max() == pytest.approx(response["displacement"].values.max())
    assert data["force_SI"].min() == pytest.approx(-8e4)
    (panel,) = drawing.canvas.axes
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("displacement (mm)", "force (kN)")
    low, high = panel.get_ylim()
    assert low < -80.0 < 80.0 < high


def test_loops_over_the_load_factor(frames):
    drawing = draw(request(frames, "force-displacement", quantity="load_factor"))
    assert drawing.canvas.axes[0].get_ylabel() == "load factor"
    response = frames.response("cycles", "rigid")
    data = drawing.data[drawing.data["label"] == "rigid"]
    assert data["load_factor_SI"].max() == pytest.approx(response["load_factor"].values.max())
    with pytest.raises(InputError, match=r"figure\.options\.quantity"):
        draw(request(frames, "force-displacement", quantity="shear"))


def test_moments_over_rotations_have_their_units(tmp_path):
    push = FrameStatic("turn", portal(), (Load("C", moment=1e4),), "C", "rotation", (0.1, -0.1))
    study = replace(
        frame_study("turning"),
        cases=(Case("turn", push),),
        models={"reference": SyntheticFrame()},
        figures=(),
    )
    stored = store_of(study, tmp_path)
    (panel,) = draw(request(stored, "force-displacement")).canvas.axes
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("rotation (rad)", "moment (kN m)")
    titles = [
        panel.get_title(loc="left") for panel in draw(request(stored, "deformed")).canvas.axes
    ]
    assert any("rad" in title for title in titles)


def test_thinned_loops_keep_extremes_of_both_axes():
    t = np.linspace(0.0, 60.0 * np.pi, 40_001)
    x, y = np.sin(t) * t, np.cos(t) * t
    x[20_000], y[30_000] = 1e3, -1e3
    few_x, few_y = thinned(x, y, 2000)
    assert len(few_x) < 5000
    assert few_x.max() == 1e3
    assert few_y.min() == -1e3


def test_histories_cover_impacts_and_ground_motions(frames):
    drawing = draw(request(frames, "history"))
    assert list(dict.fromkeys(drawing.data["case"])) == ["storeys", "from above", "shaken"]
    # a drop of 25 mm and an impact of 300 mm do not share a scale
    limits_up = [panel.get_ylim()[1] for panel in drawing.canvas.axes]
    assert limits_up[0] > 5.0 * limits_up[1]


def test_histories_of_a_hinge(frames):
    shown = request(frames, "history", quantity="plastic_rotation", hinge="E-D:end")
    drawing = draw(shown)
    data = drawing.data[(drawing.data["label"] == "rigid") & (drawing.data["case"] == "shaken")]
    stored = frames.response("shaken", "rigid")["plastic_rotation"].sel(hinge="E-D:end")
    assert data["plastic_rotation_SI"].max() == pytest.approx(float(stored.max()))
    assert any("E-D:end in storeys" in text for text in drawing.statements)


def test_hinges_are_chosen_and_normalised_by_their_members(frames):
    drawing = draw(request(frames, "interaction", case="from above", labels=["rigid"]))
    assert "Shown are the 6 of 8 hinges" in drawing.statements[1]
    assert len(set(drawing.data["hinge"])) == 6
    one = draw(
        request(frames, "interaction", case="from above", labels=["rigid"], hinges=("B-C:end",))
    )
    assert set(one.data["hinge"]) == {"B-C:end"}
    response = frames.response("from above", "rigid")
    moment = response["moment"].sel(hinge="B-C:end").values
    strength = portal().properties("B-C").plastic_moment
    ratio = one.data["moment_over_plastic_moment"].to_numpy()
    assert ratio.max() == pytest.approx(moment.max() / strength, rel=1e-3)
    with pytest.raises(InputError, match=r"figure\.options\.hinges.*must be among A-B:start"):
        draw(request(frames, "interaction", case="from above", hinges=("Z:end",)))


def test_surfaces_of_members_are_drawn_as_their_model_states_them(frames):
    drawing = draw(request(frames, "interaction", case="from above", labels=["rigid"]))
    words = [text.get_text() for text in drawing.canvas.legends[0].get_texts()]
    assert "super-ellipse α = 1, β = 1.7" in words
    assert {"exact plastic envelope of HEB 220", "exact plastic envelope of IPE 300"} <= set(words)
    assert "within the surface of the member: B-C:start." in drawing.statements[-1]
    strong = draw(
        request(frames, "interaction", case="from above", labels=["rigid"], hinges=("A-B:start",))
    )
    assert not any("weaker" in text for text in strong.statements)


@pytest.mark.thorough
@pytest.mark.parametrize(("beta", "expected"), [(None, 1.3), (1.0, 1.0)])
def test_paths_of_superelements_reach_the_surface_that_they_state(tmp_path, beta, expected):
    frame = regular_frame((6.0,), (4.0,), find("HEB 220"), find("HEB 220"))
    frame = replace(frame, loads=(Load("A1", y=-3e5), Load("B1", y=-3e5)))
    push = FrameStatic("push", frame, (Load("A1", x=1e4),), "A1", "x", (0.2,))
    study = replace(
        frame_study("pushed"),
        cases=(Case("push", push),),
        models={"reference": FlexibleSuperelement(alpha=1.0, beta=beta, shear="none")},
        quantities=("resistance",),
        figures=(),
    )
    drawing = draw(request(store_of(study, tmp_path), "interaction"))
    words = [text.get_text() for text in drawing.canvas.legends[0].get_texts()]
    assert f"super-ellipse α = 1, β = {expected:g}" in words
    m = drawing.data["moment_over_plastic_moment"].abs()
    n = drawing.data["axial_force_over_squash_load"].abs()
    assert (m + n**expected).max() == pytest.approx(1.0, abs=1e-3)
    assert n[m > 0.8].max() > 0.05  # the surface counts


@pytest.mark.parametrize("case", ["storeys", "shaken"])
def test_ledgers_close_whatever_brings_the_energy(frames, case):
    data = draw(request(frames, "energy", case=case, labels=["reference"])).data
    parts = data[["kinetic", "elastic", "dissipated", "contact_loss"]].sum(axis=1)
    energy = 1.0 if case == "shaken" else 0.97  # the closed forms leave out some of the impact
    assert (parts / data["brought_in"]).between(energy - 0.01, 1.01).all()


def test_gates_that_differ_in_their_cases_keep_their_reasons(tmp_path):
    gates = tuple(
        Gate("rigid", "reference", "peak_displacement", "relative_error", 0.1, why, "", (case,))
        for case, why in (("storeys", "Hit from the side."), ("from above", "Hit from above."))
    )
    stored = store_of(replace(frame_study("sorted"), gates=gates, figures=()), tmp_path)
    assert [
        (row["rationale"], row["asked"], row["case"]) for row in stored.records("verdicts")
    ] == [
        ("Hit from the side.", 1, "storeys"),
        ("Hit from above.", 1, "from above"),
    ]


def test_peaks_leave_out_cases_without_one(frames):
    drawing = draw(request(frames, "peaks"))
    assert "Without peak displacement of any model: cycles, shaken." in drawing.statements
    assert set(drawing.data["case"]) == {"storeys", "from above"}


def test_the_layout_of_a_drawn_figure_is_final(frames):
    drawing = draw(request(frames, "interaction", case="storeys"))
    before = [panel.get_position().extents for panel in drawing.canvas.axes]
    first = to_svg(drawing.canvas, "key")
    assert to_svg(drawing.canvas, "key") == first
    after = [panel.get_position().extents for panel in drawing.canvas.axes]
    assert np.array_equal(before, after)


def test_shear_below_the_plastic_resistance_has_a_table_and_no_headline(frames):
    page = limits.domain(frames.study, frames)
    assert not views(page, "callout")
    assert [table.key for table in views(page, "table")] == ["shear"]


def test_every_kind_of_case_is_listed_in_full(frames):
    page = configuration.configuration(frames.study, frames)
    listings = views(page, "listing")
    printed = [listing.title for listing in listings if listing.on_paper]
    assert printed == ["storeys", "cycles", "shaken"]
    for case, block in zip(
        sorted(frames.study.cases, key=lambda case: case.name),
        sorted(listings, key=lambda block: block.title),
        strict=True,
    ):
        assert scenario_from(tomllib.loads(block.text)) == case.scenario
        assert max(map(len, block.text.splitlines())) < 140
    table = next(table for table in views(page, "table") if table.key == "cases")
    ((name, like, changes, _),) = table.rows
    assert (name.text, like.text) == ("from above", "storeys")
    assert "its listing is in the HTML report" in changes.text


def pages_of(pictures: int, height: float) -> int:
    """Pages of a report with pictures of a height (mm) over the whole width of 170 mm."""
    box = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 170 {height}"/>'
    drawn = [Picture(f"p{i}", "t", "caption", box, "alt") for i in range(pictures)]
    parts = [section(f"s{i}", f"Picture {i}", p, level=2) for i, p in enumerate(drawn)]
    page = section("results", "Results", *parts)
    pdf = render_pdf(Document("Report", "", ("fact",), page, {p.key: p for p in drawn}))
    return len(re.findall(rb"/Type\s*/Page\b(?!s)", pdf))


def test_figures_share_pages_where_a_little_less_size_makes_them_fit():
    assert pages_of(1, 80.0) == 1
    assert pages_of(6, 60.0) <= 3
    # two of 145 mm and their captions are higher than a page, at 70 % they are not
    assert pages_of(5, 145.0) == 3
    assert pages_of(4, 190.0) == 4


@pytest.mark.thorough
def test_the_whole_report_repeats(frames, stills_study, stills_report, tmp_path):
    """With one figure alone: still pictures repeat in other reports."""
    one, two = (
        stills_report,
        build_report(read_assessment(frames.directory, stills_study), out=tmp_path),
    )
    for name in ("html", "pdf"):
        assert one[name].read_bytes() == two[name].read_bytes()
    html = one["html"].read_text(encoding="utf-8")
    assert "http://" not in html
    assert 'id="plot-stills"' in html
