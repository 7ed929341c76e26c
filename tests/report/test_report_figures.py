"""Every kind of figure, with everything, with little, and with nothing to show."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from synthetic_study import Synthetic, columns, small_study, store_of

from workbench.base.errors import InputError
from workbench.report.drawing.sheet import Request, Sheet, thinned
from workbench.report.drawing.style import PALETTE, house_style, looks, settle
from workbench.report.figures import KINDS, draw
from workbench.report.gallery import cases_of, figures_of, to_csv, to_svg
from workbench.scenarios import ColumnImpact, ColumnPushover, Striker
from workbench.steel.sections import circular_tube, find, rectangular_tube, square
from workbench.study import Case, Figure


def request(stored, kind, cases=None, labels=None, **options) -> Request:
    study = stored.study
    figure = Figure(kind, kind, kind, kind, options=options)
    chosen = study.cases if cases is None else cases
    return Request(
        study, figure, stored, tuple(chosen), tuple(labels or study.models), looks(study)
    )


MEMBERS = [
    kind for kind in KINDS if not kind.startswith("stud-")
]  # studs have studies of their own
ELSEWHERE = (
    *("sweep", "domain-map", "shear-domain", "meshes", "budget"),
    *("place", "work-precision", "chooser", "exceedance"),
)


TWICE = ("history", "deformed", "cost")  # equal stores give equal bytes: see `test_report_build`


@pytest.mark.thorough
@pytest.mark.parametrize(
    "kind",
    [kind for kind in MEMBERS if kind not in ELSEWHERE],
)
def test_every_kind_draws(small, kind):
    drawing = draw(request(small, kind))
    assert drawing.canvas is not None
    assert len(drawing.data) > 0
    assert drawing.alt
    svg = to_svg(drawing.canvas, kind)
    assert svg.startswith("<svg")
    assert "<metadata" not in svg
    assert "<!--" not in svg
    if kind in TWICE:
        assert svg == to_svg(draw(request(small, kind)).canvas, kind)
    assert to_csv(drawing.data).count("\n") == len(drawing.data) + 1


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_to_draw_is_said(small, kind):
    drawing = draw(request(small, kind, cases=()))
    assert drawing.canvas is None
    assert drawing.statements


@pytest.mark.parametrize(
    "kind",
    [
        kind
        for kind in MEMBERS
        if kind not in ("shear-surfaces", "yield-surfaces", "structure", "sweep", "domain-map")
    ],
)
def test_a_model_without_an_answer_is_no_crash(small, kind):
    push = [case for case in small.study.cases if case.name == "push"]
    drawing = draw(request(small, kind, cases=push, labels=["estimate"]))
    assert drawing.canvas is None
    assert drawing.statements


def test_meshes_stand_over_their_size_with_the_interval_of_the_reference(small):
    study = small.study
    sizes = {label: 0.1 * 2.0**i for i, label in enumerate(study.models)}
    drawing = draw(request(small, "meshes", sizes=sizes))
    assert drawing.canvas is not None
    known = {label for label in sizes if label in set(drawing.data["label"])}
    assert len(known) >= 2
    for row in drawing.data.itertuples():
        assert row.size_m == sizes[row.label]
        stored = small.number(row.case, row.label, study.quantities[0])
        assert getattr(row, f"{study.quantities[0]}_SI") == stored
    (panel,) = drawing.canvas.axes
    assert [line.get_label() for line in panel.lines] == ["uniform meshes"]
    assert any(study.reference in str(patch.get_label()) for patch in panel.patches) or any(
        study.reference in text for text in drawing.statements
    )


def test_drawing_leaves_the_global_settings_alone(small):
    before = dict(mpl.rcParams)
    draw(request(small, "history"))
    assert dict(mpl.rcParams) == before


def test_unknown_kinds_are_refused(small):
    with pytest.raises(InputError, match=r"figure\.kind"):
        draw(request(small, "pie"))


DRAWN = ("history", "peaks", "interaction", "energy", "convergence", "cost", "deformed")


@pytest.fixture(scope="module")
def rendered(small):
    """Figures of a kind as they are laid out, drawn once, with their renderers."""

    @cache
    def of(kind):
        canvas = draw(request(small, kind)).canvas
        renderer = FigureCanvasAgg(canvas).get_renderer()
        canvas.draw(renderer)
        return canvas, renderer

    return of


@pytest.mark.thorough
@pytest.mark.parametrize("kind", DRAWN)
def test_texts_stay_inside_the_picture(rendered, kind):
    canvas, renderer = rendered(kind)
    texts = [text for legend in canvas.legends for text in legend.get_texts()]
    for panel in canvas.axes:
        texts += [panel.xaxis.label, panel.yaxis.label, panel.title, *panel.texts]
    for text in texts:
        if text.get_text().strip():
            box = text.get_window_extent(renderer)
            assert -2 < box.x0 <= box.x1 < canvas.bbox.width + 2, text.get_text()
            assert -2 < box.y0 <= box.y1 < canvas.bbox.height + 2, text.get_text()


@pytest.mark.parametrize("kind", DRAWN)
def test_tick_labels_do_not_touch(rendered, kind):
    canvas, renderer = rendered(kind)
    for panel in canvas.axes:
        for axis in (panel.xaxis, panel.yaxis):
            low, high = sorted(axis.get_view_interval())
            shown = [
                tick.label1.get_window_extent(renderer)
                for tick in axis.get_major_ticks()
                if low <= tick.get_loc() <= high
                and tick.label1.get_visible()
                and tick.label1.get_text()
            ]
            for i, box in enumerate(shown):
                assert not any(box.overlaps(other) for other in shown[:i])


@pytest.mark.parametrize("kind", ["history", "peaks", "force-displacement", "energy", "cost"])
def test_legends_lie_outside_the_panels(rendered, kind):
    canvas, renderer = rendered(kind)
    legend = canvas.legends[0].get_window_extent(renderer)
    for panel in canvas.axes:
        assert not legend.overlaps(panel.get_window_extent(renderer))


def test_numbers_in_the_data_file_are_those_of_the_store(small):
    data = draw(request(small, "peaks")).data
    row = data[(data["case"] == "10 metres per second") & (data["label"] == "four-dof")].iloc[0]
    expected = 1.01 * 1.6e-3 * 10.0**1.75
    assert row["peak_displacement_SI"] == pytest.approx(expected)
    reference = small.number("10 metres per second", "reference", "peak_displacement")
    assert row["relative_error"] == pytest.approx(expected / reference - 1.0)


def test_histories_keep_their_peak(small):
    case = small.study.cases[0]
    data = draw(request(small, "history", cases=[case])).data
    top = data[data["label"] == "reference"]["displacement_SI"].max()
    assert top == pytest.approx(small.number(case.name, "reference", "peak_displacement"), rel=1e-4)


def test_thinning_keeps_extremes_and_ends():
    x = np.linspace(0.0, 1.0, 20_001)
    y = np.sin(40.0 * x)
    y[12_345] = 9.0
    few_x, few_y = thinned(x, y, 200)
    assert len(few_x) < 500
    assert few_y.max() == 9.0
    assert few_y.min() == y.min()
    assert (few_x[0], few_x[-1]) == (0.0, 1.0)
    assert np.all(np.diff(few_x) > 0.0)


def test_looks_are_told_apart_and_keep_to_their_label():
    study = small_study()
    result = looks(study)
    assert result["reference"].color == "#000000"
    assert result["four-dof"].color == PALETTE[0]
    assert len({(look.color, str(look.line)) for look in result.values()}) == len(result)
    fewer = replace(
        study, models={k: v for k, v in study.models.items() if k != "breaks"}, gates=()
    )
    assert looks(fewer)["four-dof"] == result["four-dof"]


@pytest.mark.thorough
def test_sweep_marks_warnings_and_failures(sweep):
    drawing = draw(request(sweep, "sweep"))
    assert drawing.canvas is not None
    data = drawing.data
    failed = data[(data["model"] == "four-dof") & (data["velocity (m/s)"] == 25.0)]
    assert failed["failed"].all()
    assert failed["error"].isna().all()
    fine = data[(data["model"] == "four-dof") & (data["velocity (m/s)"] == 10.0)]
    assert fine["error"].to_numpy() == pytest.approx(0.05)
    assert set(data[data["warned"]]["position (L)"]) == {0.1, 0.2, 0.35}
    assert len(drawing.canvas.axes) == 2 * 2 + 1


def test_sweep_over_chosen_parameters_says_what_it_merges(sweep):
    drawing = draw(request(sweep, "sweep", x="velocity (m/s)", y="section", facet=""))
    assert drawing.canvas is not None
    assert any("position (L)" in statement for statement in drawing.statements)


def test_a_map_of_one_model_has_a_parameter_for_its_rows(sweep):
    options = {"x": "position (L)", "y": "velocity (m/s)", "facet": "", "rows": "section"}
    drawing = draw(request(sweep, "sweep", labels=["four-dof"], **options))
    assert drawing.canvas is not None
    assert len(drawing.canvas.axes) == 2 + 1
    assert "Model: four-dof. Rows of panels: section." in drawing.statements


def test_columns_of_all_kinds_are_drawn(tmp_path):
    thesis = columns()["thesis"]
    variety = {
        "pinned": columns()["pinned"],
        "fixed": replace(thesis, head="fixed", restraint_stiffness=0.0, axial_load=0.0),
        "tension": replace(thesis, section=square(0.2), axial_load=-1e5),
        "box": replace(thesis, section=rectangular_tube(0.3, 0.2, 0.01)),
        "pipe": replace(thesis, section=circular_tube(0.2, 0.01)),
        "hit high": replace(thesis, length_below=3.9, length_above=0.1),
    }
    cases = tuple(
        Case(name, ColumnImpact(name, column, Striker(500.0, 5.0), 0.02), figure=name)
        for name, column in variety.items()
    )
    push = Case("pushed", ColumnPushover("pushed", variety["box"], 0.1), figure="pushed")
    study = replace(
        small_study("variety"),
        cases=(*cases, push),
        models={"reference": Synthetic()},
        ladder=(),
        gates=(),
        figures=(),
    )
    stored = store_of(study, tmp_path)
    for case in study.cases:
        drawing = draw(request(stored, "structure", cases=[case]))
        assert drawing.canvas is not None, case.name
        assert case.scenario.column.base in drawing.alt
    several = draw(request(stored, "structure"))
    assert any("first 2 of 6" in statement for statement in several.statements)


def test_the_ladder_of_a_study_without_one_is_said(sweep):
    assert "unknown" in draw(request(sweep, "convergence")).statements[0]


def test_cases_and_standard_figures():
    study = small_study()
    by_key = {figure.key: figure for figure in figures_of(study)}
    assert [case.name for case in cases_of(study, by_key["curves"])] == ["push"]
    assert len(cases_of(study, by_key["peaks"])) == 3
    assert len(cases_of(study, by_key["cost"])) == 4
    named = replace(by_key["cost"], options={"cases": ("push",)})
    assert [case.name for case in cases_of(study, named)] == ["push"]
    standard = replace(study, figures=(*study.figures, replace(study.figures[0], key="cost")))
    with pytest.raises(InputError, match=r"figure\.key"):
        figures_of(standard)


def test_a_dollar_in_a_name_is_no_formula(small, tmp_path):
    case = replace(small.study.cases[0], name="costs $5 or $_6$")
    study = replace(small.study, name="dollar", cases=(case,), gates=(), figures=())
    stored = store_of(study, tmp_path)
    assert draw(request(stored, "history")).canvas is not None
    assert find("HEB 220").name in draw(request(stored, "structure")).alt


def test_a_domain_map_classes_errors_and_names_silent_ones(sweep):
    options = {"x": "velocity (m/s)", "over": "position (L)", "y": "v/La"}
    drawing = draw(request(sweep, "domain-map", **options))
    assert drawing.canvas is not None
    data = drawing.data
    fine = data[(data["model"] == "four-dof") & (data["x"] == 10.0)]
    assert set(fine["class"]) == {"within 10 %"}  # 5 % everywhere, rounded up
    small = data[(data["model"] == "single-dof") & data["error"].notna()]
    assert set(small["class"]) == {"more than 10 % too small"}
    failed = data[(data["model"] == "four-dof") & (data["x"] == 25.0)]
    assert set(failed["class"]) == {"no answer"}
    assert set(data["model"]) == set(sweep.study.models) - {sweep.study.reference}
    silent = int((~small["warned"]).sum())
    assert 0 < silent < len(small)
    assert f"single-dof: {silent} errors beyond 10 % carry no warning." in drawing.statements


def test_a_domain_map_needs_its_parameter(sweep):
    drawing = draw(request(sweep, "domain-map", x="depth"))
    assert drawing.canvas is None
    assert "parameter depth" in drawing.statements[0]


def test_no_label_is_clipped_at_the_resolution_of_the_page() -> None:
    """Letters are as wide when a figure is laid out (100 dpi) as when it is saved."""
    with house_style():
        sheet = Sheet.table(1, 1, 2.0)
        sheet.panel.set_yticks([0.0, 1.0], ["restraint stiffness ±5 %", "total"])
        settle(sheet.canvas)
        for resolution in (72, 100, 160, 300):
            sheet.canvas.set_dpi(resolution)
            renderer = FigureCanvasAgg(sheet.canvas).get_renderer()
            assert sheet.panel.yaxis.get_tightbbox(renderer).x0 >= 0.0


def test_clusters_name_their_points_in_place_of_a_legend(small):
    """Labels stand at the points of the first case, one above the other's side, clusters below."""
    whole = request(small, "peaks")
    labels = whole.labels
    clusters = {"one side": labels[2:4], "the other": labels[:2]}
    figure = replace(whole.figure, options={**whole.figure.options, "clusters": clusters})
    canvas = draw(replace(whole, figure=figure)).canvas
    top, bottom = canvas.axes
    shown = [text.get_text() for text in top.texts]
    assert shown[:4] == [*labels[2:4], *labels[:2]]
    assert {text.get_text() for text in bottom.texts} == set(clusters)
    places = [text.xy[0] for text in top.texts]
    assert places == sorted(places)
    assert max(places) < 0.5  # inside the slot of the first case
    kept = [text.get_text() for legend in canvas.legends for text in legend.get_texts()]
    assert not set(kept) & set(labels)
