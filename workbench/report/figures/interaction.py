"""Paths of the hinges in the plane of axial force and moment, with the yield surfaces.

Options: `case` (a name; default the first with hinge forces), `hinges` (names; default the six
with the largest plastic rotations, or the most forces), `surfaces`: pairs (alpha, beta) drawn
besides the surface that the model states.
"""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from workbench.base.errors import InputError
from workbench.report.drawing.layout import frame_scenario_of
from workbench.report.drawing.sheet import Array, Drawing, Request, Sheet, evenly, nothing
from workbench.report.drawing.style import INK, MUTED, PALETTE, TEXT_WIDTH, Style, entry
from workbench.report.page.formatting import several
from workbench.responses import Response
from workbench.scenarios import Frame, Member
from workbench.steel.hinges import YieldSurface
from workbench.study.definition import Case

_MOST_HINGES = 6
_MOST_POINTS = 1200
_ALONE = 5.2  # inches: width of a single panel with its legend
_ENVELOPES = ("#9a9a9a", "#c9b48a", "#9cc0ad")  # one per section


def draw(request: Request) -> Drawing:
    """One panel per label: N/Npl across, M/Mpl up, hinges as lines that end in a dot."""
    notes: list[str] = []
    needed = {"axial_force", "moment"}
    case, answers = request.first_answered(needed, "forces in hinges", notes)
    scenario = None if case is None else frame_scenario_of(case.scenario)
    if case is None or scenario is None:
        return nothing("No model states hinge forces over time for these cases.")
    frame, alone = scenario.frame, len(answers) == 1
    names = _hinges(request, answers, notes)
    members = list(dict.fromkeys(_member(frame, name) for name in names))
    notes.insert(0, f"Case: {case.name}. Dots mark the end of the record.")
    height, width = 2.3 if len(answers) > 2 or alone else 2.9, _ALONE if alone else TEXT_WIDTH
    sheet = Sheet.grid(len(answers), notes, height=height, width=width)
    for (label, response), panel in zip(answers.items(), sheet.panels, strict=True):
        _surfaces(sheet, panel, frame, members, _exponents(request, case, label, frame, members))
        for i, name in enumerate(names):
            if name in response["hinge"].values:
                head = {"case": case.name, "label": label, "hinge": name}
                _path(sheet, panel, frame, response, head, PALETTE[i % len(PALETTE)])
        sheet.name(panel, label, "N/Nₚₗ (tension positive)", "M/Mₚₗ")
        panel.axhline(0.0, color=MUTED, linewidth=0.5)
        panel.axvline(0.0, color=MUTED, linewidth=0.5)
        ticks = [-1, -0.5, 0, 0.5, 1]
        panel.set(xlim=(-1.12, 1.12), ylim=(-1.12, 1.12), xticks=ticks, yticks=ticks)
        panel.set_aspect("equal")
    weak = [name for name in names if _is_weaker(frame, name)]
    if weak:
        what = "Joints weaker than their members yield within the surface of the member"
        sheet.notes.append(f"{what}: {', '.join(weak)}.")
    alt = f"axial force and moment of the hinges of {', '.join(answers)} for {case.name}"
    return sheet.finish(alt, beside="center" if alone else "", width=width / TEXT_WIDTH)


def _hinges(request: Request, answers: dict[str, Response], notes: list[str]) -> list[str]:
    """The hinges that are drawn, in the order of the models."""
    known = list(dict.fromkeys(str(n) for r in answers.values() for n in r["hinge"].values))
    named = request.option("hinges", ())
    for name in named:
        if name not in known:
            raise InputError("figure.options.hinges", name, f"must be among {several(known, 8)}")
    if named or len(known) <= _MOST_HINGES:
        return [name for name in known if not named or name in named]
    turned = any("plastic_rotation" in response for response in answers.values())
    history, what = ("plastic_rotation", "plastic rotations") if turned else ("moment", "moments")
    records = [
        abs(r[history]).max({*r[history].dims} - {"hinge"})
        for r in answers.values()
        if history in r
    ]
    size = xr.concat(records, "label", join="outer").max("label").to_series()
    chosen = set(size.reindex(known, fill_value=0.0).nlargest(_MOST_HINGES).index)
    notes.append(f"Shown are the {_MOST_HINGES} of {len(known)} hinges with the largest {what}.")
    return [name for name in known if name in chosen]


def _member(frame: Frame, hinge: str) -> Member:
    """The member that a hinge belongs to; hinges of other names: the first member."""
    name = hinge.rpartition(":")[0]
    return next((m for m in frame.members if m.name == name), frame.members[0])


def _is_weaker(frame: Frame, hinge: str) -> bool:
    """Whether a hinge stands for a joint with less strength than its member."""
    member = _member(frame, hinge)
    joint = frame.joint(member.joint_end if hinge.endswith(":end") else member.joint_start)
    strength = frame.properties(member).strength
    return joint.weaker(strength) != strength


def _exponents(
    request: Request, case: Case, label: str, frame: Frame, members: list[Member]
) -> list[tuple[float, float]]:
    """Exponents (alpha, beta) of the surfaces that a model says it uses, and of those asked for."""
    model = request.study.models[label]
    column, each = getattr(model, "surface", None), getattr(model, "member_surface", None)
    surfaces = []
    if callable(each):
        surfaces = [each(frame, member) for member in members]
    elif callable(column) and hasattr(case.scenario, "column"):
        surfaces = [column(case.scenario.column)]
    ellipses = [surface for surface in surfaces if isinstance(surface, YieldSurface)]
    pairs = [(float(surface.alpha), float(surface.beta)) for surface in ellipses]
    pairs += [(float(a), float(b)) for a, b in request.option("surfaces", ())]
    return list(dict.fromkeys(pairs))


def _surfaces(
    sheet: Sheet, panel: Axes, frame: Frame, members: list[Member], pairs: list[tuple[float, float]]
) -> None:
    """Exact envelopes of the sections, and super-ellipses."""
    sections = list(dict.fromkeys(frame.strength_section(member) for member in members))
    for section, color in zip(sections, _ENVELOPES, strict=False):
        which = "the section" if len(sections) == 1 else section.name
        exact: Style = {"color": color, "linewidth": 2.6, "alpha": 0.7, "zorder": 1}
        _all_quadrants(panel, *section.interaction_envelope(), **exact)
        sheet.legend(entry(f"exact plastic envelope of {which}", **exact))
    share = np.linspace(0.0, 1.0, 121) ** 2
    for i, (alpha, beta) in enumerate(pairs):
        style: Style = {"color": INK, "linewidth": 1.0, "zorder": 2}
        style["linestyle"] = ("--", ":", "-.")[i % 3]
        _all_quadrants(panel, share ** (1.0 / beta), (1.0 - share) ** (1.0 / alpha), **style)
        sheet.legend(entry(f"super-ellipse α = {alpha:.3g}, β = {beta:.3g}", **style))


def _all_quadrants(panel: Axes, n: Array, m: Array, **style: Any) -> None:
    x = np.concatenate([n, n[::-1], -n, -n[::-1], n[:1]])
    y = np.concatenate([m, -m[::-1], -m, m[::-1], m[:1]])
    panel.plot(x, y, **style)


def _path(
    sheet: Sheet, panel: Axes, frame: Frame, response: Response, head: dict[str, str], color: str
) -> None:
    """The path of one hinge, a dot at its end."""
    history = "time" if "time" in response.dims else "step"
    path = response.sel(hinge=head["hinge"]).isel(
        {history: evenly(response.sizes[history], _MOST_POINTS)}
    )
    properties = frame.properties(_member(frame, head["hinge"]))
    n = path["axial_force"].values / properties.squash_load
    m = path["moment"].values / properties.plastic_moment
    panel.plot(n, m, color=color, linewidth=0.9, zorder=3)
    panel.plot(n[-1:], m[-1:], color=color, marker="o", markersize=3.5, zorder=4)
    sheet.legend(entry(f"hinge: {head['hinge']}", color=color))
    ratios = {"axial_force_over_squash_load": n, "moment_over_plastic_moment": m}
    sheet.record(**head, **{history: path[history].values}, **ratios)
