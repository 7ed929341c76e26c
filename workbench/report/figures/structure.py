"""The structure to scale: members, joints, supports, loads, what happens to it, dimensions.

Options: `case` (a name; default every different structure of the cases, two at most). A column is
drawn as its two-member frame.
"""

import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from itertools import pairwise
from math import cos, degrees, sin
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas
from matplotlib.transforms import Bbox

from workbench.report.drawing.frame import (
    ACTION,
    TINTS,
    Layout,
    arrow,
    cross_section,
    dimension,
    draw_actions,
    draw_frame,
    frame_scenario_of,
    joint_mark,
    note,
    targets,
)
from workbench.report.drawing.sheet import Drawing, Request, Sheet, first, nothing
from workbench.report.drawing.style import MUTED, TEXT_WIDTH, Shown
from workbench.report.page.formatting import TIMES, brief
from workbench.scenarios import Frame, FrameImpact, FrameScenario

_MOST = 2
_EDGE, _BETWEEN, _LINE_END = 0.08, 0.35, 0.02  # inches
_ROOM = 20.0  # inches of the canvas that structures are drawn on before their size is known
_ROW = 0.38
_MOST_SPANS = 8
_LINE = 14  # characters of a section's name
_PLAN = 0.3  # length of the arrow of a hit on a section
_UNITS = ("m2", "m4", "Nm", "N", "N", "kg_per_m")  # of the properties of members
_JOINT = (
    ("rotational_stiffness", "rotational stiffness {} kN m/rad", 1e3),
    ("axial_stiffness", "axial stiffness {} kN/mm", 1e6),
    ("plastic_moment", "plastic moment {} kN m", 1e3),
    ("plastic_moment_negative", "{} kN m where moments are negative", 1e3),
    ("tension_resistance", "resistance in tension {} kN", 1e3),
    ("compression_resistance", "resistance in compression {} kN", 1e3),
)


def draw(request: Request) -> Drawing:
    """Every different structure once, with all that happens to it."""
    cases_of: dict[Frame, list[tuple[str, FrameScenario]]] = {}
    for case in request.named():
        scenario = frame_scenario_of(case.scenario)
        if scenario is not None:
            drawn = scenario.frame.unchecked(gravity=(0.0, 0.0))  # which no picture shows
            cases_of.setdefault(drawn, []).append((case.name, scenario))
    if not cases_of:
        return nothing("None of the cases is about a frame or a column.")
    notes: list[str] = []
    groups = first(list(cases_of.items()), _MOST, "different structures", notes)
    canvas = Shown(figsize=(_ROOM, _ROOM))
    panels = [
        canvas.add_axes((0.0, 0.0, 1.0, 1.0), label=f"structure {i}") for i in range(len(groups))
    ]
    sheet, texts, boxes = Sheet(canvas, panels, notes), [], []
    names = [case.name for case in request.cases]
    fallen = len(names) == 1 and all(request.stored.collapses(names[0], n) for n in request.labels)
    for (frame, cases), panel in zip(groups, panels, strict=True):
        scenarios, name = [scenario for _, scenario in cases], cases[0][0]
        sheet.notes += _draw_structure(panel, frame, scenarios)
        if title := name if len(groups) > 1 else "collapse" if fallen else "":
            box = _box(panel)
            panel.text(box.x0, box.y1 + 0.15, title, fontsize=8.5, va="center")
        boxes.append(_box(panel))
        texts.append(_text(frame, scenarios))
        for member in _members(frame):
            sheet.record(case=name, **member)
    width = _arrange(canvas, panels, boxes)
    return sheet.finish("; ".join(texts), width=min(1.0, width / TEXT_WIDTH))


def _draw_structure(panel: Axes, frame: Frame, scenarios: list[FrameScenario]) -> list[str]:
    """Draw a structure in inches, its lower left corner the origin; return what has no room."""
    panel.axis("off")
    panel.set(xlim=(-_ROOM / 2, _ROOM / 2), ylim=(-_ROOM / 2, _ROOM / 2))
    layout, hit = Layout(frame), targets(scenarios)
    draw_frame(panel, layout, hit)
    notes = draw_actions(panel, layout, scenarios)
    top = layout.extent.imag * layout.scale
    # what stands above the frame does not keep dimension lines away
    _draw_dimensions(panel, layout, hit, complex(_box(panel, top).x1 - 0.1, _box(panel).y0 + 0.12))
    corner = complex(_box(panel, top).x1 + 0.25, top + 0.1)
    notes = _draw_sections(panel, frame, corner, _plan_directions(scenarios)) + notes
    if frame.spatial:
        depths = ", ".join(text for _, _, text in spans(layout.levels("z")))
        notes.append(f"Oblique view; depths towards the viewer: {depths}.")
    if layout.deepened:
        text = "Some members are drawn deeper than they are, so that they can be seen."
        notes.append(text)
    return notes


def _box(panel: Axes, below: float = np.inf) -> Bbox:
    """The box around all that is drawn in a panel, in its units.

    `below`: what lies wholly above this height does not count.
    """
    canvas = panel.get_figure()
    assert isinstance(canvas, Canvas)
    renderer = FigureCanvasAgg(canvas).get_renderer()  # type: ignore[no-untyped-call]
    inverse = panel.transData.inverted()
    boxes = []
    for artist in (*panel.lines, *panel.patches, *panel.texts):  # not the panel, which is larger
        box = artist.get_tightbbox(renderer)
        if box is not None and np.isfinite(box.get_points()).all():
            boxes.append(inverse.transform_bbox(box))
    return Bbox.union([box for box in boxes if box.y0 < below]).padded(_LINE_END)


def _arrange(canvas: Canvas, panels: list[Axes], boxes: list[Bbox]) -> float:
    """Put structures side by side, or below each other if they are wide; return the width."""
    sizes = np.array([box.size for box in boxes])
    gaps = (len(boxes) - 1) * _BETWEEN + 2 * _EDGE
    beside = bool(sizes[:, 0].sum() + gaps <= TEXT_WIDTH)
    along = 0 if beside else 1
    whole = sizes.max(axis=0) + 2 * _EDGE
    whole[along] = sizes[:, along].sum() + gaps
    canvas.set_size_inches(*whole)
    left, top = _EDGE, whole[1] - _EDGE
    for panel, box, (wide, high) in zip(panels, boxes, sizes, strict=True):
        place = np.array([[left, top - high], [wide, high]]) / whole
        panel.set_position(tuple(place.ravel()))
        panel.set(xlim=box.intervalx, ylim=box.intervaly)
        if beside:
            left += wide + _BETWEEN
        else:
            top -= high + _BETWEEN
    return float(whole[0])


def _members(frame: Frame) -> Iterator[dict[str, Any]]:
    """The numbers of each member."""
    axes = "xyz" if frame.spatial else "xy"
    for member in frame.members:
        start, end = frame.node(member.start), frame.node(member.end)
        properties = list(asdict(frame.properties(member)).items())[: len(_UNITS)]
        yield {
            "member": member.name,
            "section": member.section.name,
            **{f"start_{axis}_m": getattr(start, axis) for axis in axes},
            **{f"end_{axis}_m": getattr(end, axis) for axis in axes},
            "length_m": frame.length(member),
            "joint_start": member.joint_start,
            "joint_end": member.joint_end,
            **{f"{n}_{unit}": v for (n, v), unit in zip(properties, _UNITS, strict=True)},
        }


def _text(frame: Frame, scenarios: list[FrameScenario]) -> str:
    extent = Layout(frame).extent
    sections = ", ".join(dict.fromkeys(member.section.name for member in frame.members))
    held = ", ".join(f"{n.support} at {n.name}" for n in frame.nodes if n.support != "free")
    size = f"{extent.real:.4g} m wide and " if extent.real else ""
    return (
        f"structure of {len(frame.members)} members ({sections}), {size}{extent.imag:.4g} m high, "
        f"{held}; what happens is seen at {', '.join(targets(scenarios))}"
    )


def _draw_dimensions(panel: Axes, layout: Layout, further: Sequence[str], corner: complex) -> None:
    """Bays below and storeys on the right, with the heights of `further` nodes nearer.

    `corner`: right and lower end of what is drawn already.
    """
    for axis, base, step, along in (
        ("y", complex(corner.real), _ROW, 1j),
        ("x", complex(0.0, corner.imag), -1j * _ROW, 1.0),
    ):
        start = min(getattr(node, axis) for node in layout.frame.nodes)
        main, fine = layout.levels(axis), layout.levels(axis, further)
        # chains of levels from the inner to the outer: with further nodes, without, overall
        chains = [fine] if len(fine) > len(main) else []
        chains += [main] if len(main) > 1 else []
        if 3 < len(main) <= _MOST_SPANS + 1:  # longer chains say it themselves
            chains.append([main[0], main[-1]])
        for chain in chains:
            base += step
            for a, b, text in spans(chain):
                low, high = ((level - start) * layout.scale * along for level in (a, b))
                dimension(panel, base + low, base + high, text)


def spans(levels: Sequence[float]) -> list[tuple[float, float, str]]:
    """Dimensions between rising levels (m) with their texts; one for all if there are many."""
    pairs = list(pairwise(levels))
    if len(pairs) <= _MOST_SPANS:
        return [(a, b, f"{brief(b - a)} m") for a, b in pairs]
    each = {f"{brief(b - a)}" for a, b in pairs}
    whole = f"{brief(levels[-1] - levels[0])} m"
    text = f"{len(pairs)} {TIMES} {each.pop()} m = {whole}" if len(each) == 1 else whole
    return [(levels[0], levels[-1], text)]


def _plan_directions(scenarios: Sequence[FrameScenario]) -> list[float]:
    """Angles (rad) of strikers off the height of a section, where one is not hit along its web."""
    impacts = [each for each in scenarios if isinstance(each, FrameImpact)]
    weak = any(member.axis == "weak" for each in impacts for member in each.frame.members)
    angles = {each.striker.angle for each in impacts}
    return sorted(angles) if weak or any(angles) else []


def _plan_arrows(panel: Axes, section: complex, centre: complex, angles: Sequence[float]) -> float:
    """Arrows of hits at `angles` (rad) off the height of a section, b + i h; return their depth."""
    for angle in angles:
        along = complex(sin(angle), cos(angle))
        reach = 0.5 * (section.imag * along.imag + section.real * along.real)
        start = centre - (reach + _PLAN) * along
        arrow(panel, start, centre - (reach + 0.02) * along, ACTION)
        if angle > 0.0:
            note(panel, start - 0.09 * along, f"{degrees(angle):.3g}°", ACTION, ha="center")
    return _PLAN + 0.1 if angles else 0.0


def _draw_sections(
    panel: Axes, frame: Frame, corner: complex, angles: Sequence[float]
) -> list[str]:
    """Cross sections, enlarged to one scale, and joints, below the upper left `corner`.

    The first one is hit at `angles` (rad) off its height. Returns sentences on what has no room,
    and on the joints.
    """
    left, high = corner.real, corner.imag
    notes: list[str] = []
    strengths = {member.section: frame.strength_section(member) for member in frame.members}
    shown = first(list(strengths.items()), len(TINTS), "sections", notes)
    scale = 0.62 / max(max(strong.height, strong.width) for _, strong in shown)
    for i, (given, section) in enumerate(shown):
        h, b = section.height * scale, section.width * scale
        high -= 0.2
        centre = complex(left + b / 2, high - h / 2)
        cross_section(panel, section, centre, scale, TINTS[i])
        side, over = centre + b / 2 + 0.09, centre + 1j * (h / 2 + 0.09)
        dimension(panel, side - 0.5j * h, side + 0.5j * h, f"{brief(1e3 * section.height)} mm")
        dimension(panel, over - b / 2, over + b / 2, f"{brief(1e3 * section.width)} mm")
        if i == 0:
            high -= _plan_arrows(panel, complex(b, h), centre, angles)
        lines = textwrap.wrap(section.name.replace(" x ", TIMES), _LINE)
        if len(strengths) > 1:
            members = [member for member in frame.members if member.section == given]
            ends = [(frame.node(m.start), frame.node(m.end)) for m in members]
            rises = {abs(end.y - start.y) > abs(end.x - start.x) for start, end in ends}
            names = {True: "columns", False: "beams"}
            lines.append(" and ".join(names[rise] for rise in sorted(rises, reverse=True)))
        if i == len(shown) - 1:
            lines.append(f"{brief(frame.steel.yield_stress / 1e6)} MPa")
        at = complex(left, high - h - 0.06)
        note(panel, at, "\n".join(lines), va="top", linespacing=1.4, zorder=3)
        high -= h + 0.1 + 0.14 * len(lines) + 0.12
    joints = dict.fromkeys(name for m in frame.members for name in (m.joint_start, m.joint_end))
    texts = []
    for name in joints:
        if name == "rigid":
            continue
        joint_mark(panel, complex(left + 0.1, high), name)
        text = "pinned joint" if name == "pinned" else f"joint {name}"
        note(panel, complex(left + 0.24, high), text, MUTED, zorder=3)
        high -= 0.19
        if name != "pinned":
            values = [(getattr(frame.joint(name), key), words, unit) for key, words, unit in _JOINT]
            known = [words.format(brief(v / unit)) for v, words, unit in values if v is not None]
            texts.append(f"Joint {name}: {', '.join(known) or 'as the member'}.")
    return texts + notes
