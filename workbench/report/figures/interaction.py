"""Paths of the hinges in the plane of axial force and moment, with the yield surfaces.

Options: `case` (a name; default the first with hinge forces), `hinges` (names; default the six
with the largest plastic rotations, or the most forces), `surfaces`: pairs (alpha, beta) drawn
besides the surface that the model states.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from workbench.errors import InputError
from workbench.report.figures.drawing import (
    Array,
    Drawing,
    Request,
    joined,
    nothing,
    rows,
)
from workbench.report.figures.frames import frame_scenario_of
from workbench.report.figures.panels import first_answered, name_axes, panel_grid
from workbench.report.figures.style import (
    INK,
    MUTED,
    PALETTE,
    TEXT_WIDTH,
    legend_below,
    legend_beside,
)
from workbench.responses import Response
from workbench.scenarios import Frame, Member
from workbench.study.definition import Case

_MOST_PANELS = 6
_MOST_HINGES = 6
_MOST_POINTS = 1200
_ALONE = 5.2  # inches: width of a single panel with its legend
_ENVELOPES = (("#9a9a9a", 2.6), ("#c9b48a", 2.6), ("#9cc0ad", 2.6))  # one per section


def draw(request: Request) -> Drawing:
    """One panel per label: N/Npl across, M/Mpl up, hinges as lines that end in a dot."""
    case, found, statements = first_answered(request, {"axial_force", "moment"}, "forces in hinges")
    if case is None:
        return nothing("No model states hinge forces over time for these cases.", *statements)
    if len(found) > _MOST_PANELS:
        statements.append(f"Shown are the first {_MOST_PANELS} of {len(found)} models.")
        found = dict(list(found.items())[:_MOST_PANELS])
    scenario = frame_scenario_of(case)
    assert scenario is not None
    frame = scenario.frame
    names, said = _hinges(request, found)
    statements += said
    alone = len(found) == 1
    height = 2.3 if len(found) > 2 or alone else 2.9
    canvas, axes = panel_grid(len(found), height=height, width=_ALONE if alone else TEXT_WIDTH)
    blocks: list[Any] = []
    handles: list[Any] = []
    members = list(dict.fromkeys(_member(frame, name) for name in names))
    for i, ((label, response), panel) in enumerate(zip(found.items(), axes, strict=True)):
        handles.extend(_surfaces(request, case, label, frame, members, panel))
        handles.extend(_paths(case, label, frame, names, response, panel, blocks))
        panel.set_title(label, loc="left")
        name_axes(panel, i, len(found), "N/Nₚₗ (tension positive)", "M/Mₚₗ")
        panel.axhline(0.0, color=MUTED, linewidth=0.5)
        panel.axvline(0.0, color=MUTED, linewidth=0.5)
        panel.set_xlim(-1.12, 1.12)
        panel.set_ylim(-1.12, 1.12)
        panel.set_xticks([-1, -0.5, 0, 0.5, 1])
        panel.set_yticks([-1, -0.5, 0, 0.5, 1])
        panel.set_aspect("equal")
    (legend_beside if alone else legend_below)(canvas, handles)
    weak = [name for name in names if _is_weaker(frame, name)]
    if weak:
        statements.append(
            "Joints weaker than their members yield within the surface of the member: "
            f"{', '.join(weak)}."
        )
    statements.insert(0, f"Case: {case.name}. Dots mark the end of the record.")
    alt = f"axial force and moment of the hinges of {', '.join(found)} for {case.name}"
    width = _ALONE / TEXT_WIDTH if alone else 1.0
    return Drawing(canvas, joined(blocks), tuple(statements), alt, width)


def _hinges(request: Request, found: dict[str, Response]) -> tuple[list[str], list[str]]:
    """The hinges that are drawn, and sentences on those that are not."""
    known = list(dict.fromkeys(str(h) for r in found.values() for h in r["hinge"].values))
    named = request.option("hinges", ())
    if named:
        strange = [name for name in named if name not in known]
        if strange:
            shown = ", ".join(known[:8]) + (", ..." if len(known) > 8 else "")
            raise InputError("figure.options.hinges", strange[0], f"must be among {shown}")
        return [name for name in known if name in named], []
    if len(known) <= _MOST_HINGES:
        return known, []
    size = dict.fromkeys(known, 0.0)
    turned = any("plastic_rotation" in response for response in found.values())
    for response in found.values():
        if turned and "plastic_rotation" not in response:
            continue
        values = np.abs(response["plastic_rotation" if turned else "moment"].values).max(axis=1)
        for name, value in zip(response["hinge"].values, values, strict=True):
            size[str(name)] = max(size[str(name)], float(value))
    largest = sorted(known, key=lambda name: -size[name])[:_MOST_HINGES]
    what = "plastic rotations" if turned else "moments"
    said = f"Shown are the {_MOST_HINGES} of {len(known)} hinges with the largest {what}."
    return [name for name in known if name in largest], [said]


def _member(frame: Frame, hinge: str) -> Member:
    """The member that a hinge belongs to; hinges of other names: the first member."""
    name = hinge.rpartition(":")[0]
    return next((m for m in frame.members if m.name == name), frame.members[0])


def _is_weaker(frame: Frame, hinge: str) -> bool:
    """Whether a hinge stands for a joint with less strength than its member."""
    member = _member(frame, hinge)
    joint = frame.joint(member.joint_end if hinge.endswith(":end") else member.joint_start)
    own = frame.properties(member)
    moments = (joint.plastic_moment, joint.plastic_moment_negative)
    forces = (joint.tension_resistance, joint.compression_resistance)
    return any(m is not None and m < own.plastic_moment for m in moments) or any(
        n is not None and n < own.squash_load for n in forces
    )


def _surfaces(
    request: Request, case: Case, label: str, frame: Frame, members: list[Member], panel: Axes
) -> list[Line2D]:
    handles = []
    sections = list(dict.fromkeys(frame.strength_section(member) for member in members))
    for section, (shade, width) in zip(sections, _ENVELOPES, strict=False):
        n, m = section.interaction_envelope()
        exact = {"color": shade, "linewidth": width, "alpha": 0.7, "zorder": 1}
        _all_quadrants(panel, n, m, **exact)
        name = "exact plastic envelope of " + (
            "the section" if len(sections) == 1 else section.name
        )
        handles.append(Line2D([], [], label=name, **exact))  # type: ignore[arg-type]
    pairs = [(float(a), float(b)) for a, b in request.option("surfaces", ())]
    pairs = _stated(request, case, label, frame, members) + pairs
    for i, (alpha, beta) in enumerate(dict.fromkeys(pairs)):
        share = np.linspace(0.0, 1.0, 121) ** 2
        style = {"color": INK, "linewidth": 1.0, "linestyle": ("--", ":", "-.")[i % 3], "zorder": 2}
        _all_quadrants(panel, share ** (1.0 / beta), (1.0 - share) ** (1.0 / alpha), **style)
        name = f"super-ellipse α = {alpha:.3g}, β = {beta:.3g}"
        handles.append(Line2D([], [], label=name, **style))  # type: ignore[arg-type]
    return handles


def _stated(
    request: Request, case: Case, label: str, frame: Frame, members: list[Member]
) -> list[tuple[float, float]]:
    """Exponents (alpha, beta) of the surfaces that a model says it uses."""
    model = request.study.models[label]
    column, each = getattr(model, "surface", None), getattr(model, "member_surface", None)
    surfaces = []
    if callable(each):
        surfaces = [each(frame, member) for member in members]
    elif callable(column) and hasattr(case.scenario, "column"):
        surfaces = [column(case.scenario.column)]
    return [(float(surface.alpha), float(surface.beta)) for surface in surfaces]


def _all_quadrants(panel: Axes, n: Array, m: Array, **style: Any) -> None:
    x = np.concatenate([n, n[::-1], -n, -n[::-1]])
    y = np.concatenate([m, -m[::-1], -m, m[::-1]])
    panel.plot(np.append(x, x[0]), np.append(y, y[0]), **style)


def _paths(
    case: Case,
    label: str,
    frame: Frame,
    names: list[str],
    response: Response,
    panel: Axes,
    blocks: list[Any],
) -> list[Line2D]:
    handles = []
    history = "time" if "time" in response.dims else "step"
    size = response.sizes[history]
    index = np.unique(np.linspace(0, size - 1, min(size, _MOST_POINTS)).astype(int))
    known = [str(name) for name in response["hinge"].values]
    for i, name in enumerate(names):
        if name not in known:
            continue
        color = PALETTE[i % len(PALETTE)]
        properties = frame.properties(_member(frame, name))
        at = known.index(name)
        n = response["axial_force"].values[at, index] / properties.squash_load
        m = response["moment"].values[at, index] / properties.plastic_moment
        panel.plot(n, m, color=color, linewidth=0.9, zorder=3)
        panel.plot(n[-1:], m[-1:], color=color, marker="o", markersize=3.5, zorder=4)
        handles.append(Line2D([], [], color=color, label=f"hinge: {name}"))
        block = {
            "case": case.name,
            "label": label,
            "hinge": name,
            history: response[history].values[index],
            "axial_force_over_squash_load": n,
            "moment_over_plastic_moment": m,
        }
        blocks.append(rows(block, len(index)))
    return handles
