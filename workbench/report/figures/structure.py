"""The structure to scale: members, joints, supports, loads, what happens to it, dimensions.

Options: `case` (a name; default every different structure of the cases, two at most). A column is
drawn as the frame of its two segments.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.transforms import Bbox

from workbench.report.figures.drawing import Drawing, Request, joined, nothing, rows
from workbench.report.figures.frame_actions import draw_actions, targets
from workbench.report.figures.frame_layout import Layout
from workbench.report.figures.frame_margins import draw_dimensions, draw_sections
from workbench.report.figures.frame_picture import draw_frame
from workbench.report.figures.frames import FrameScenario, frame_scenario_of
from workbench.report.figures.style import TEXT_WIDTH
from workbench.scenarios import Frame
from workbench.study.definition import Case

_MOST = 2
_EDGE, _BETWEEN, _TITLE = 0.08, 0.35, 0.3  # inches


@dataclass(frozen=True)
class _Sheet:
    """A drawn structure: its `panel` in inches, and the `box` around all of it."""

    panel: Axes
    box: tuple[float, float, float, float]

    @property
    def width(self) -> float:
        return self.box[2] - self.box[0]

    @property
    def height(self) -> float:
        return self.box[3] - self.box[1]


def draw(request: Request) -> Drawing:
    """Every different structure once, with all that happens to it."""
    named = request.option("case", "")
    groups = _groups([case for case in request.cases if not named or case.name == named])
    if not groups:
        return nothing("None of the cases is about a frame or a column.")
    statements = []
    if len(groups) > _MOST:
        statements.append(f"Shown are the first {_MOST} of {len(groups)} different structures.")
        groups = groups[:_MOST]
    canvas = Canvas(figsize=(20.0, 20.0))
    sheets, blocks = [], []
    for frame, cases in groups:
        title = cases[0][0].name if len(groups) > 1 else ""
        sheet, said = _sheet(canvas, frame, [scenario for _, scenario in cases], title)
        sheets.append(sheet)
        statements += said
        blocks.append(_members(cases[0][0], frame))
    width = _arrange(canvas, sheets)
    alt = "; ".join(_words(frame, [s for _, s in cases]) for frame, cases in groups)
    return Drawing(canvas, joined(blocks), tuple(statements), alt, min(1.0, width / TEXT_WIDTH))


_Group = tuple[Frame, list[tuple[Case, FrameScenario]]]


def _groups(cases: list[Case]) -> list[_Group]:
    found: dict[Frame, list[tuple[Case, FrameScenario]]] = {}
    for case in cases:
        scenario = frame_scenario_of(case)
        if scenario is not None:
            found.setdefault(scenario.frame, []).append((case, scenario))
    return list(found.items())


def _sheet(
    canvas: Canvas, frame: Frame, scenarios: list[FrameScenario], title: str
) -> tuple[_Sheet, list[str]]:
    """Draw a structure in inches; its own corner is the origin."""
    panel = canvas.add_axes((0.0, 0.0, 1.0, 1.0), label=f"structure {len(canvas.axes)}")
    panel.axis("off")
    wide, high = canvas.get_size_inches()
    panel.set_xlim(-wide / 2, wide / 2)
    panel.set_ylim(-high / 2, high / 2)
    layout, hit = Layout(frame), targets(scenarios)
    draw_frame(panel, layout, hit)
    said = draw_actions(panel, layout, scenarios)
    top = layout.extent[1] * layout.scale
    # what stands above the frame does not keep dimension lines away
    corner = (_box(panel, top)[2] - 0.1, _box(panel)[1] + 0.12)
    draw_dimensions(panel, layout, hit, corner)
    said = draw_sections(panel, frame, (_box(panel, top)[2] + 0.25, top + 0.1)) + said
    if any(layout.depth(m) > 1.001 * layout.true_depth(m) for m in frame.members):
        said.append("Some members are drawn deeper than they are, so that they can be seen.")
    box = _box(panel)
    if title:
        panel.text(box[0], box[3] + 0.15, title, fontsize=8.5, va="center")
        box = _box(panel)
    return _Sheet(panel, box), said


def _box(panel: Axes, below: float = np.inf) -> tuple[float, float, float, float]:
    """Left, lower, right and upper end of all that is drawn in a panel, in its units.

    `below`: what lies wholly above this height does not count.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas = panel.get_figure()
    assert isinstance(canvas, Canvas)
    renderer = FigureCanvasAgg(canvas).get_renderer()  # type: ignore[no-untyped-call]
    # the panel itself, which is much larger, does not count
    boxes = []
    for artist in (*panel.lines, *panel.patches, *panel.texts):
        box = artist.get_tightbbox(renderer)
        if box is not None and np.isfinite(box.get_points()).all():
            inches = panel.transData.inverted().transform_bbox(box)
            if inches.y0 < below:
                boxes.append(inches)
    whole = Bbox.union(boxes)
    edge = 0.02  # line ends
    return (
        *(float(whole.x0) - edge, float(whole.y0) - edge),
        *(float(whole.x1) + edge, float(whole.y1) + edge),
    )


def _arrange(canvas: Canvas, sheets: list[_Sheet]) -> float:
    """Put the sheets side by side, or below each other if they are wide; return the width."""
    beside = sum(sheet.width for sheet in sheets) + (len(sheets) - 1) * _BETWEEN
    row = beside + 2 * _EDGE <= TEXT_WIDTH
    if row:
        width, height = beside, max(sheet.height for sheet in sheets)
    else:
        width = max(sheet.width for sheet in sheets)
        height = sum(sheet.height for sheet in sheets) + (len(sheets) - 1) * _BETWEEN
    width, height = width + 2 * _EDGE, height + 2 * _EDGE
    canvas.set_size_inches(width, height)
    left, top = _EDGE, height - _EDGE
    for sheet in sheets:
        x0, y0, x1, y1 = sheet.box
        low = top - sheet.height
        place = (left / width, low / height, sheet.width / width, sheet.height / height)
        sheet.panel.set_position(place)
        sheet.panel.set_xlim(x0, x1)
        sheet.panel.set_ylim(y0, y1)
        if row:
            left += sheet.width + _BETWEEN
        else:
            top = low - _BETWEEN
    return float(width)


def _members(case: Case, frame: Frame) -> Any:
    """One row per member."""
    entries = []
    for member in frame.members:
        properties = frame.properties(member)
        start, end = frame.node(member.start), frame.node(member.end)
        entries.append(
            {
                "case": case.name,
                "member": member.name,
                "section": member.section.name,
                "start_x_m": start.x,
                "start_y_m": start.y,
                "end_x_m": end.x,
                "end_y_m": end.y,
                "length_m": frame.length(member),
                "joint_start": member.joint_start,
                "joint_end": member.joint_end,
                "area_m2": properties.area,
                "second_moment_m4": properties.second_moment,
                "plastic_moment_Nm": properties.plastic_moment,
                "squash_load_N": properties.squash_load,
                "shear_resistance_N": properties.shear_resistance,
                "mass_per_length_kg_per_m": properties.mass_per_length,
            }
        )
    return joined([rows(entry, 1) for entry in entries])


def _words(frame: Frame, scenarios: list[FrameScenario]) -> str:
    wide, high = Layout(frame).extent
    sections = ", ".join(dict.fromkeys(member.section.name for member in frame.members))
    held = ", ".join(f"{n.support} at {n.name}" for n in frame.nodes if n.support != "free")
    size = f"{wide:.4g} m wide and {high:.4g} m high" if wide else f"{high:.4g} m high"
    at = ", ".join(targets(scenarios))
    return (
        f"structure of {len(frame.members)} members ({sections}), {size}, {held}; "
        f"what happens is seen at {at}"
    )
