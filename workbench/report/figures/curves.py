"""Curves of all labels: histories, pushes, bench records over each other, energies side by side.

``history``, options: `quantity` (a history; `impulse` stands for the percussions summed up),
`hinge` (a name, for quantities that belong to hinges), `cases`.
``force-displacement``, options: `quantity` (``force``, the default, or ``load_factor``), `cases`.
``energy``: the ledger of one impact, one panel per label. Option: `case` (default the first that
has a ledger).

**Second part.** Paths of the hinges in the plane of axial force and moment, with the yield
surfaces.

Options: `case` (a name; default the first with hinge forces), `hinges` (names; default the six
with the largest plastic rotations, or the most forces), `surfaces`: pairs (alpha, beta) drawn
besides the surface that the model states.
"""

import textwrap
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from workbench.base.errors import InputError
from workbench.base.fields import Choice
from workbench.report.drawing.frame import displacement_unit, frame_scenario_of
from workbench.report.drawing.sheet import Array, Drawing, Request, Sheet, evenly, nothing, thinned
from workbench.report.drawing.style import INK, MUTED, PALETTE, TEXT_WIDTH, Style, entry
from workbench.report.page.formatting import Unit, axis_label, number, several, title_of, unit_of
from workbench.responses import Response
from workbench.scenarios import ColumnImpact, Frame, FrameImpact, FrameStatic, Member
from workbench.steel.hinges import YieldSurface
from workbench.study.definition import Case

_PEAKS = {"displacement": ("peak_displacement", "time_of_peak")}
_TIME = unit_of("time").factor
_QUANTITY = Choice(("force", "load_factor"))
_LOOPS = 0.8  # width of a line that turns back, over that of one that does not
# bottom to top; fixed colours that no label uses as a fill
PARTS = (
    ("dissipated", "dissipated (plastic, algorithmic)", "#8c510a"),
    ("contact_loss", "lost in contact", "#e3b778"),
    ("crushing", "spent on crushing the striker", "#dfc27d"),
    ("elastic", "elastic", "#5ab4ac"),
    ("kinetic", "kinetic", "#c7dfee"),
)
_MOST_POINTS = 400
_BROUGHT: Style = {"color": INK, "linestyle": "--"}


def history(request: Request) -> Drawing:
    """Overlaid histories in time; models without a history show their peak."""
    quantity, hinge = str(request.option("quantity", "displacement")), request.option("hinge", "")
    sheet, panels = request.case_panels(static=False)
    if not panels:
        return nothing("Histories in time need an impact or a ground motion; no case is one.")
    if hinge:
        sheet.notes.append(f"Hinge: {hinge}.")
    unit = unit_of(quantity).factor
    for case, panel in panels:
        for label, response in request.answers(case, sheet.absent).items():
            curve, look = _history(response, quantity, str(hinge)), request.looks[label]
            if curve is None:
                _peak(request, sheet, case, label, panel)
                continue
            time, values = thinned(*curve)
            panel.plot(time * _TIME, values * unit, **look.curve())
            sheet.legend(entry(label, **look.curve()))
            sheet.record(case=case.name, label=label, time_s=time, **{f"{quantity}_SI": values})
        sheet.name(panel, case.name, axis_label("time"), axis_label(quantity))
        fallen = [n for n in request.shown(case) if request.stored.collapses(case.name, n)]
        if fallen:
            words = textwrap.fill(f"collapse: {', '.join(fallen)}", 34)
            panel.text(0.97, 0.04, words, transform=panel.transAxes, ha="right", color=MUTED)
        panel.set_xlim(left=0.0)
        panel.margins(x=0.0)
        if not panel.lines:
            panel.text(0.5, 0.5, "no curve", transform=panel.transAxes, ha="center", color=MUTED)
    sheet.level()
    return sheet.finish(
        f"{title_of(quantity)} over time for {', '.join(case.name for case, _ in panels)}",
        empty=f"No model answered these cases with {title_of(quantity)}.",
    )


def _history(response: Response, quantity: str, hinge: str) -> tuple[Array, Array] | None:
    stored = "percussion" if quantity == "impulse" else quantity
    if "time" not in response.coords or stored not in response:
        return None
    values = response[stored]
    if values.dims == ("hinge", "time") and hinge in values["hinge"].values:
        values = values.sel(hinge=hinge)
    if values.dims != ("time",):
        return None
    curve = values.values.astype(float)
    return response["time"].values.astype(float), curve.cumsum() if stored != quantity else curve


def _peak(request: Request, sheet: Sheet, case: Case, label: str, panel: Axes) -> None:
    """Draw the peak of a model without a history: a marker, or a line if its time is unknown."""
    quantity, hinge = str(request.option("quantity", "displacement")), request.option("hinge", "")
    names, look = _PEAKS.get(quantity, ()), request.looks[label]
    peak, when = (*(request.number(case, label, name) for name in names), None, None)[:2]
    if peak is None:
        where = f" of {hinge} in {case.name}" if hinge else ""
        sheet.absent.without(f"{title_of(quantity)} over time{where}", label)
        return
    shown = peak * unit_of(quantity).factor
    if when is None:
        style = look.curve(linestyle=":")
        panel.axhline(shown, **style)
    else:
        style = look.points()
        panel.plot([when * _TIME], [shown], **style)
    sheet.legend(entry(f"{label} (peak only)", **style))
    at = np.nan if when is None else when
    sheet.record(case=case.name, label=label, time_s=at, **{f"{quantity}_SI": peak})


def force_displacement(request: Request) -> Drawing:
    """Force over displacement of static loading, with all of its reversals."""
    quantity = request.option("quantity", "force")
    quantity = _QUANTITY.check("figure.options.quantity", quantity)
    sheet, panels = request.case_panels(static=True, height=2.6)
    if not panels:
        return nothing("Force-displacement curves need static loading; no case is static.")
    what, units = f"{title_of(quantity)} and displacement", set()
    for case, panel in panels:
        (along, across), (up, upright) = _axes(case, quantity)
        units.add(up.text)
        turning = False
        answers = request.answers(case, sheet.absent, (quantity, "displacement"), what)
        for label, response in answers.items():
            x, y = response["displacement"].values, response[quantity].values
            back = bool(np.any(np.diff(x) < 0.0))
            turning |= back
            x, y = thinned(x, y, 2400 if back else 700)
            look = request.looks[label]
            width = look.width * (_LOOPS if back else 1.0)
            panel.plot(x * along.factor, y * up.factor, **look.curve(linewidth=width))
            sheet.legend(entry(label, **look.curve()))
            sheet.record(case=case.name, label=label, displacement_SI=x, **{f"{quantity}_SI": y})
        if turning:  # loops get axes through the origin and air around them
            panel.axhline(0.0, color=MUTED, linewidth=0.6, zorder=1)
            panel.axvline(0.0, color=MUTED, linewidth=0.6, zorder=1)
            panel.margins(x=0.04, y=0.06)
        else:
            panel.margins(x=0.0)
            panel.set_ylim(bottom=min(0.0, panel.get_ylim()[0]))
        height = f"{upright} ({up.text})" if up.text else upright
        sheet.name(panel, case.name, f"{across} ({along.text})", height)
    if len(units) == 1:  # forces beside forces
        sheet.level()
    return sheet.finish(
        f"{title_of(quantity)} over displacement for {', '.join(case.name for case, _ in panels)}",
        empty="No model answered these cases with a curve.",
    )


def _axes(case: Case, quantity: str) -> tuple[tuple[Unit, str], tuple[Unit, str]]:
    """Return display unit and name of displacement and quantity; patterns may be moments only."""
    scenario = case.scenario
    if not isinstance(scenario, FrameStatic):
        across = unit_of("displacement"), "displacement"
    else:
        along = displacement_unit(scenario)
        across = along, "rotation" if along.text == "rad" else "displacement"
        if quantity == "force" and not any(load.x or load.y for load in scenario.loads):
            return across, (unit_of("moment"), "moment")
    return across, (unit_of(quantity), title_of(quantity))


def energy(request: Request) -> Drawing:
    """Stacked energies with the energy that has come in as a line on top."""
    notes: list[str] = []
    needed = {"dissipated", "elastic", "input_energy"}
    case, ledgers = request.first_answered(needed, "an energy ledger", notes)
    if case is None:
        return nothing("No model keeps an energy ledger of these cases.")
    notes.insert(0, f"Case: {case.name}. Energies in J in the data file.")
    sheet = Sheet.grid(len(ledgers), notes)
    unit = unit_of("kinetic").factor
    struck = isinstance(case.scenario, ColumnImpact | FrameImpact)
    stacked: set[str] = set()
    for (label, response), panel in zip(ledgers.items(), sheet.panels, strict=True):
        history = "time" if "time" in response.dims else "step"
        at, parts, brought = ledger(response, history, struck)
        x = at * unit_of(history).factor
        stacked |= set(parts)
        colors = [color for name, _, color in PARTS if name in parts]
        panel.stackplot(x, *(part * unit for part in parts.values()), colors=colors, linewidth=0.0)
        panel.plot(x, brought * unit, **_BROUGHT, linewidth=1.1)
        sheet.name(panel, "", axis_label(history), "energy (kJ)")
        panel.set_title(label, loc="left", pad=13.0)
        error = request.number(case, label, "energy_error")
        if error is not None:
            words = f"largest error {number(error, 2)} of the input"
            above: Style = {"xycoords": "axes fraction", "textcoords": "offset points"}
            text = panel.annotate(words, (0.0, 1.0), (0.0, 3.0), fontsize=6.5, **above)
            text.set_in_layout(False)  # long words would make narrow panels
        panel.margins(x=0.0)
        panel.set_ylim(bottom=min(0.0, panel.get_ylim()[0]))
        sheet.record(case=case.name, label=label, **{history: at}, **parts, brought_in=brought)
    sheet.legend(*(Patch(color=c, label=title) for n, title, c in PARTS[::-1] if n in stacked))
    sheet.legend(entry("brought in so far", **_BROUGHT))
    return sheet.finish(f"energy ledgers of {', '.join(ledgers)} for {case.name}")


def ledger(response: Response, history: str, struck: bool) -> tuple[Array, dict[str, Array], Array]:
    """Times or steps, energies by part in J, and the energy that has come in.

    Arguments: `history`, time or step; `struck`, whether a striker brings energy.
    """
    index = evenly(response.sizes[history], _MOST_POINTS)

    def taken(name: str) -> Array:
        return np.asarray(response[name].values[index], dtype=float)

    at, parts = taken(history), {name: taken(name) for name, _, _ in PARTS if name in response}
    # a striker brings its energy at once, all else does work; what dead loads had stored before
    # is part of every later sum
    work = taken("external_work") if "external_work" in response else 0.0 * at
    hit = float(response["input_energy"]) if struck else 0.0
    stored = float(response["elastic"].values[0]) if history == "time" else 0.0
    return at, parts, hit + work + stored


_MOST_HINGES = 6
_MOST_PATH_POINTS = 1200
_ALONE = 5.2  # inches: width of a single panel with its legend
_ENVELOPES = ("#9a9a9a", "#c9b48a", "#9cc0ad")  # one per section


def interaction_path(request: Request) -> Drawing:
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
        {history: evenly(response.sizes[history], _MOST_PATH_POINTS)}
    )
    properties = frame.properties(_member(frame, head["hinge"]))
    n = path["axial_force"].values / properties.squash_load
    m = path["moment"].values / properties.plastic_moment
    panel.plot(n, m, color=color, linewidth=0.9, zorder=3)
    panel.plot(n[-1:], m[-1:], color=color, marker="o", markersize=3.5, zorder=4)
    sheet.legend(entry(f"hinge: {head['hinge']}", color=color))
    ratios = {"axial_force_over_squash_load": n, "moment_over_plastic_moment": m}
    sheet.record(**head, **{history: path[history].values}, **ratios)
