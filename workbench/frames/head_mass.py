"""The mass that moves with the head of a column cut out of its frame."""

import numpy as np

from workbench.arrays import Array
from workbench.errors import OutOfDomainError
from workbench.frames.column_line import ColumnLine
from workbench.frames.elastic import ElasticFrame
from workbench.scenarios import Frame

HEAD_MASSES = ("column-line", "joint", "deflected-shape", "none")
STRAIGHT_ON = 0.02  # sine of the largest kink in the line above the head


def mass_of_head(rule: str, line: ColumnLine, shape: Array | None) -> float:
    """Mass (kg) at the head by a rule of `HEAD_MASSES`.

    Joint: point mass of the head and half of the other members that meet there. Column line: the
    same for all joints of the line that goes on beyond the head, its members whole; that line is
    far stiffer along its axis than the beams that hold it, and moves with the head. Deflected
    shape: generalised mass of the frame without the column in the deflection that its spring has.
    """
    if rule == "none":
        return 0.0
    if rule != "deflected-shape":
        nodes = [line.head] if rule == "joint" else _line_above(line)
        return _mass_of(line.frame, nodes, line.members)
    if shape is None:
        raise OutOfDomainError(
            "head_mass = deflected-shape: without the column nothing resists a movement of its "
            "head along it, so that there is no such shape; take another rule"
        )
    return float(shape @ ElasticFrame(line.frame, line.rest).mass @ shape)


def _mass_of(frame: Frame, nodes: list[str], without: tuple[str, ...]) -> float:
    """Point masses of `nodes` and half a member's mass per end there."""
    total = sum(frame.node(name).mass for name in nodes)
    for member in frame.members:
        if member.name not in without:
            ends = (member.start in nodes) + (member.end in nodes)
            mass = frame.properties(member).mass_per_length * frame.length(member)
            total += 0.5 * ends * mass
    return total


def _line_above(line: ColumnLine) -> list[str]:
    """Names of the nodes from the head on along the axis of the column."""
    frame, nodes = line.frame, [line.head]
    axis = np.array(line.axis)
    while True:
        at = frame.node(nodes[-1])
        if at.held:
            return nodes
        beyond = []
        for member in frame.members:
            if at.name in (member.start, member.end):
                far = frame.node(member.end if member.start == at.name else member.start)
                chord = np.array([far.x - at.x, far.y - at.y])
                across = abs(float(axis[0] * chord[1] - axis[1] * chord[0]))
                if axis @ chord > 0.0 and across < STRAIGHT_ON * float(np.hypot(*chord)):
                    beyond.append(far.name)
        if not beyond:
            return nodes
        nodes.append(beyond[0])
