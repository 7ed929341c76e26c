"""Around a frame on paper: dimension lines, cross sections, the meaning of symbols."""

import itertools
import textwrap
from collections.abc import Sequence

from matplotlib.axes import Axes

from workbench.content.formatting import TIMES, brief
from workbench.report.drawing.frame import TINTS, joint_mark, sections_of
from workbench.report.drawing.layout import Layout
from workbench.report.drawing.sheet import first
from workbench.report.drawing.style import MUTED
from workbench.report.drawing.symbols import cross_section, dimension, note
from workbench.scenarios import Frame, Member

_ROW = 0.38
_MOST_SPANS = 8
_LINE = 14  # characters of a section's name


def draw_dimensions(panel: Axes, layout: Layout, further: Sequence[str], corner: complex) -> None:
    """Bays below and storeys on the right, with the heights of `further` nodes nearer.

    `corner`: right and lower end of what is drawn already.
    """
    for axis, step, along, start in (
        ("y", _ROW, 1j, layout.origin.imag),
        ("x", -1j * _ROW, 1.0, layout.origin.real),
    ):
        base = complex(corner.real) if axis == "y" else complex(0.0, corner.imag)
        for chain in _chains(layout, axis, further):
            base += step
            for a, b, text in spans(chain):
                low, high = ((level - start) * layout.scale * along for level in (a, b))
                dimension(panel, base + low, base + high, text)


def _chains(layout: Layout, axis: str, further: Sequence[str]) -> list[list[float]]:
    """Chains of levels from the inner to the outer: with `further` nodes, without, overall."""
    main, fine = layout.levels(axis), layout.levels(axis, further)
    found = [fine] if len(fine) > len(main) else []
    if len(main) > 1:
        found.append(main)
    if 3 < len(main) <= _MOST_SPANS + 1:  # longer chains say it themselves
        found.append([main[0], main[-1]])
    return found


def spans(levels: Sequence[float]) -> list[tuple[float, float, str]]:
    """Dimensions between rising levels (m) with their texts; one for all if there are many."""
    pairs = list(itertools.pairwise(levels))
    if len(pairs) <= _MOST_SPANS:
        return [(a, b, f"{brief(b - a)} m") for a, b in pairs]
    each = {f"{brief(b - a)}" for a, b in pairs}
    whole = f"{brief(levels[-1] - levels[0])} m"
    text = f"{len(pairs)} {TIMES} {each.pop()} m = {whole}" if len(each) == 1 else whole
    return [(levels[0], levels[-1], text)]


def draw_sections(panel: Axes, frame: Frame, corner: complex) -> list[str]:
    """Cross sections, enlarged to one scale, and joints, below the upper left `corner`.

    Returns sentences on what has no room.
    """
    left, high = corner.real, corner.imag
    said: list[str] = []
    sections = sections_of(frame)
    shown = first(list(sections.items()), len(TINTS), "sections", said)
    scale = 0.62 / max(max(strong.height, strong.width) for _, strong in shown)
    for i, (given, section) in enumerate(shown):
        h, b = section.height * scale, section.width * scale
        high -= 0.2
        centre = complex(left + b / 2, high - h / 2)
        cross_section(panel, section, centre, scale, TINTS[i])
        side, over = centre + b / 2 + 0.09, centre + 1j * (h / 2 + 0.09)
        dimension(panel, side - 0.5j * h, side + 0.5j * h, f"{brief(1e3 * section.height)} mm")
        dimension(panel, over - b / 2, over + b / 2, f"{brief(1e3 * section.width)} mm")
        words = textwrap.wrap(section.name.replace(" x ", TIMES), _LINE)
        if len(sections) > 1:
            members = [member for member in frame.members if member.section == given]
            words.append(_role(frame, members))
        if i == len(shown) - 1:
            words.append(f"{brief(frame.steel.yield_stress / 1e6)} MPa")
        at = complex(left, high - h - 0.06)
        note(panel, at, "\n".join(words), va="top", linespacing=1.4, zorder=3)
        high -= h + 0.1 + 0.14 * len(words) + 0.12
    names = [joint for m in frame.members for joint in (m.joint_start, m.joint_end)]
    joints = [joint for joint in dict.fromkeys(names) if joint != "rigid"]
    for joint in joints:
        joint_mark(panel, complex(left + 0.1, high), joint)
        text = "pinned joint" if joint == "pinned" else f"joint {joint}"
        note(panel, complex(left + 0.24, high), text, MUTED, zorder=3)
        high -= 0.19
    return [*(_joint_words(frame, joint) for joint in joints if joint != "pinned"), *said]


def _role(frame: Frame, members: Sequence[Member]) -> str:
    """What the members of a section are: columns, beams, or both."""
    rises = set()
    for member in members:
        start, end = frame.node(member.start), frame.node(member.end)
        rises.add(abs(end.y - start.y) > abs(end.x - start.x))
    return "columns and beams" if len(rises) > 1 else "columns" if True in rises else "beams"


def _joint_words(frame: Frame, name: str) -> str:
    joint = frame.joint(name)
    facts = (
        ("rotational stiffness {} kN m/rad", joint.rotational_stiffness, 1e3),
        ("axial stiffness {} kN/mm", joint.axial_stiffness, 1e6),
        ("plastic moment {} kN m", joint.plastic_moment, 1e3),
        ("{} kN m where moments are negative", joint.plastic_moment_negative, 1e3),
        ("resistance in tension {} kN", joint.tension_resistance, 1e3),
        ("resistance in compression {} kN", joint.compression_resistance, 1e3),
    )
    known = [words.format(brief(value / unit)) for words, value, unit in facts if value is not None]
    return f"Joint {name}: {', '.join(known) or 'as the member'}."
